use raystep_kernels::options::mapping::{Cull, Fragment, Mapping};
use raystep_kernels::programs::stream;
use raystep_kernels::{Accelerator, Choices, Numerics, Samples, ScheduleKind};

use super::*;
use crate::link::{Link, LinkRay};
use crate::ray_text::GivenRay;
use crate::runs::Recipe;
use crate::session::Edit;
use crate::settings::{DeviceKind, Settings, View};

fn place() -> Link {
    Link { scene: Some("scenes/a b.glb".into()), ray: Some(LinkRay::Pixel([3, 4])), pass: Some(7), ..Link::default() }
}

fn run(recipe: &Recipe) -> SavedRun {
    let hash = "fnv1a64:0123456789abcdef";
    SavedRun::new(recipe, &place(), hash).named("a \"name\"", "two\nlines ø")
}

/// Recipes with everything that a link cannot express.
fn recipes() -> Vec<Recipe> {
    let of = |settings: Settings| Recipe { settings, edits: Vec::new(), twins: None };
    let hit = stream("hit").expect("a stream");
    let free = |fov_deg| View::Free {
        eye: [0.1, 2.0, 3.0],
        look_at: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov_deg,
        half_height: 1.0,
    };
    vec![
        of(Settings { device: DeviceKind::Cpu, ..Settings::default() }),
        of(Settings { device: DeviceKind::CpuF64, counters: false, size: [32, 16], ..Settings::default() }),
        of(Settings {
            view: free(None),
            choices: Choices { accelerator: Accelerator::Bvh, numerics: Numerics::Paper, ..Choices::stepped() },
            ..Settings::default()
        }),
        of(Settings {
            view: free(Some(33.3)),
            choices: Choices { samples: Samples { count: 4, seed: 7, ..Samples::default() }, ..Choices::stepped() },
            ..Settings::default()
        }),
        of(Settings {
            choices: Choices {
                mapping: Mapping::Fragment(Fragment { cull: Cull::EarlyZ, ..Fragment::default() }),
                schedule: ScheduleKind::First,
                ..Choices::stepped()
            },
            ..Settings::default()
        }),
        of(Settings { ray: Some(GivenRay([0.1, 0.2, 3.0, 0.0, -0.0, -1.0])), size: [512, 512], ..Settings::default() }),
        Recipe {
            edits: vec![Edit { place: 3, stream: hit, layer: 2, x: 1, y: 2, bits: u32::MAX }],
            twins: Some(5),
            ..of(Settings::default())
        },
    ]
}

fn some() -> SessionFile {
    let recipes = recipes();
    let mut file = SessionFile::new(run(&recipes[0]));
    file.runs = recipes.iter().map(run).collect();
    (file.reference, file.compared) = (Some(0), Some(5));
    file.bookmarks = vec![Bookmark { place: 3, pixel: Some([1, 2]), name: "here".into() }];
    file.watches = vec![(Watch::MoreSteps(9), true), (Watch::RayHit, false)];
    file.notes = "notes\nof some lines".into();
    file
}

#[test]
fn what_is_saved_comes_back() {
    let file = some();
    let text = file.to_text().expect("small");
    assert_eq!(SessionFile::from_bytes(text.as_bytes()), Ok(file.clone()), "{text}");
    assert!(text.contains("raystep:1?scene=scenes/a%20b.glb"), "{text}");
    for (saved, recipe) in file.runs.iter().zip(recipes()) {
        assert_eq!(saved.recipe(), recipe);
    }
    let least = br#"{"version": 1, "here": {"link": "raystep:1?scene=x.glb"}}"#;
    let least = SessionFile::from_bytes(least).expect("what is not there is as by default");
    assert_eq!(least.here.recipe().settings.size, [512, 512]);
}

#[test]
fn a_broken_file_says_where_in_one_line() {
    let here =
        |more: &str| format!("{{\"version\": 1,\n \"here\": {{\"link\": \"raystep:1?scene=x.glb&size=8x8\"{more}}}}}");
    let edit = |part: &str| here(&format!(", \"edits\": [{{\"place\": 1, {part}, \"bits\": 0}}]"));
    let session =
        |more: &str| format!("{{\"version\": 1, \"here\": {{\"link\": \"raystep:1?scene=x.glb\"}},\n {more}}}");
    let large = session(&format!("\"notes\": \"{}\"", "x".repeat(MOST_BYTES)));
    let many = vec!["{\"link\": \"raystep:1?\"}"; MOST_RUNS + 1].join(", ");
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (b"".into(), "line 1, column 0: EOF"),
        (b"\xff".into(), "not UTF-8"),
        (b"{\"version\": 2, \"what\": 1}".into(), "version 2, but this raystep reads version 1"),
        (b"{\"version\": 1}".into(), "missing field `here`"),
        (b"{\"version\": 1,\n \"here\": {\"link\": \"raystep:1?\"}}".into(), "names no scene"),
        (b"{\"version\": 1,\n \"here\": {\"link\": \"raystep:1?scene=x&size=0x0\"}}".into(), "line 2, column"),
        (here(", \"colour\": 1").into(), "line 2, column 60: unknown field `colour`"),
        (here(", \"f64\": 1").into(), "expected a boolean"),
        (edit("\"stream\": \"none\", \"layer\": 0, \"x\": 0, \"y\": 0").into(), "there is no stream \"none\""),
        (edit("\"stream\": \"hit\", \"layer\": 3, \"x\": 0, \"y\": 0").into(), "edit 0: hit has layers 0 to 2, not 3"),
        (edit("\"stream\": \"hit\", \"layer\": 0, \"x\": 8, \"y\": 0").into(), "0,0 to 7,7, not 8,0"),
        (session("\"reference\": 0").into(), "it has 0, counted from 0"),
        (session(&format!("\"runs\": [{many}]")).into(), "257 runs, but at most 256"),
        (session("\"layout\": \"{}\"").into(), "layout: missing field"),
        (session("\"watches\": [[\"Nothing\", true]]").into(), "line 2, column"),
        (large.into(), "limit is 4194304"),
        ("[".repeat(100_000).into(), "line 1"),
    ];
    for (bytes, wanted) in cases {
        let error = SessionFile::from_bytes(&bytes).expect_err(wanted).to_string();
        assert!(error.contains(wanted) && !error.contains('\n') && error.len() < 300, "{wanted}: {error}");
    }
}

#[test]
fn a_layout_that_would_not_end_is_refused() {
    let layout = |children: &str, shares: &str| {
        let linear = format!(
            "{{\"children\": [{children}], \"dir\": \"Horizontal\", \"shares\": {{\"shares\": {{{shares}}}}}}}"
        );
        format!(
            "{{\"id\": 1, \"root\": 1, \"tiles\": {{\"next_tile_id\": 9, \"tiles\": {{\"1\": {{\"Container\": {{\"Linear\": \
             {linear}}}}}, \"2\": {{\"Pane\": {{\"kind\": \"Log\"}}}}}}, \"invisible\": []}}, \"height\": 1.0, \"width\": 1.0}}"
        )
    };
    assert_eq!(layout::read::<layout::SavedPane>(&layout("2", "")).map(|tree| tree.tiles.len()), Ok(2));
    for (children, shares, wanted) in [
        ("1", "", "tile 1 is there twice"),
        ("2, 2", "", "tile 2 is there twice"),
        ("3", "", "there is no tile 3"),
        ("2", "\"2\": -1.0", "shares of tile 1"),
        ("2", "\"2\": 1e30", "shares of tile 1"),
    ] {
        let error = layout::read::<layout::SavedPane>(&layout(children, shares)).map(|_| ()).expect_err(wanted);
        assert!(error.contains(wanted), "{wanted}: {error}");
    }
}

#[test]
fn scenes_are_renamed_unless_they_are_built_in() {
    let mut file = some();
    file.runs[1].link.scene = Some("built-in:cornell-box".into());
    file.rename_scenes(|scene| format!("../{scene}"));
    let scenes: Vec<_> = file.runs.iter().map(|run| run.link.scene.clone().expect("a scene")).collect();
    assert_eq!(scenes[..2], ["../scenes/a b.glb", "built-in:cornell-box"]);
    assert_eq!(file.here.link.scene.as_deref(), Some("../scenes/a b.glb"));
}
