//! A first session, as a new user would do it: only by buttons, keys and clicks.

use std::ops::ControlFlow;

use egui::{Key, Modifiers, Role, vec2};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_kernels::export::csv::COLUMNS;
use raystep_kernels::export::trace::{Rays, Trace, trace};
use raystep_kernels::{Accelerator, Choices, Device, Renderer};
use raystep_scenes::generate::cornell_box;

use crate::ui::adapter::{block_on, gpu};
use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

/// The pixel to click in an image of this many rows and columns.
fn pixel(side: u32) -> [u32; 2] {
    [200, 360].map(|place| place * side / 512)
}

/// The history of one ray in a separate run.
fn history(settings: &Settings) -> Trace {
    let (gpu, scene) = (gpu(), cornell_box());
    let device = Device::Gpu(gpu.clone());
    let options = settings.options(&scene);
    let mut renderer = block_on(&gpu, Renderer::new(&scene, &options, &device)).expect("a small scene");
    let [x, y] = pixel(settings.size[0]);
    block_on(&gpu, trace(&mut renderer, x, y, Rays::All, |_| ControlFlow::Continue(()))).expect("a pixel")
}

#[test]
fn a_first_session_with_a_small_picture() {
    let mut stage = Stage::new(Plan::default());
    stage.perform(Command::PasteLink);
    stage.answer(&format!("raystep:1?scene={CORNELL}&size=128x128"));
    stage.perform(Command::End);
    go_on(stage, Settings { size: [128; 2], ..Settings::default() });
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn a_first_session() {
    let mut stage = Stage::new(Plan::default());
    stage.desk.lock().expect("not poisoned").choice = Some(CORNELL.into());
    stage.click(Role::Button, Command::OpenScene.name());
    stage.settle();
    go_on(stage, Settings::default());
}

/// The rest of the session, once the Cornell box is open.
fn go_on(mut stage: Stage, settings: Settings) {
    let [side, _] = settings.size;
    let pixel = pixel(side);
    assert!(stage.inspector().title().starts_with("cornell-box"), "{}", stage.inspector().title());

    // It is traced to the end. Restart, step 20 passes, go back 7.
    assert_eq!(stage.inspector().model().next, None);
    stage.key(Modifiers::NONE, Key::Home);
    stage.settle();
    for _ in 0..20 {
        stage.key(Modifiers::NONE, Key::F10);
    }
    stage.settle();
    assert_eq!(stage.place(), 20);
    for _ in 0..7 {
        stage.key(Modifiers::SHIFT, Key::F10);
    }
    stage.settle();
    assert_eq!(stage.place(), 13);
    assert!(stage.reads("after 13 of"), "{}", stage.read_out());

    // Click a pixel: its history is the same as in a separate run.
    let picture = stage.find(Role::Image, |name| name.contains("after 13 passes")).expect("the stream");
    let rect = picture.rect();
    let scale = rect.width().min(rect.height()) / side as f32;
    let texel = vec2(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) - egui::Vec2::splat(side as f32 / 2.0);
    stage.click_at(rect.center() + texel * scale);
    stage.settle();
    assert_eq!(stage.inspector().pixel(), Some(pixel));
    let shown = stage.inspector().model().history.clone().expect("a history");
    let expected = history(&settings);
    assert!(expected.rows.len() > 10, "{}", expected.rows.len());
    assert_eq!(shown.rows, expected.rows);
    assert_eq!(*shown, expected);

    // Set a watch, and run to it: the ray's hit next changes in this pass.
    stage.perform(Command::Show(PaneKind::Watches));
    stage.click(Role::CheckBox, "selected ray: its hit changes");
    let hit = |i: usize| (expected.rows[i].after.triangle, expected.rows[i].after.t);
    let fires = (1..expected.rows.len()).find(|&i| expected.rows[i].pass >= Some(13) && hit(i) != hit(i - 1));
    stage.key(Modifiers::NONE, Key::F5);
    stage.settle();
    assert_eq!(Some(stage.place()), fires.and_then(|i| expected.rows[i].place()));
    assert!(stage.reads(&format!("pixel {},{}", pixel[0], pixel[1])));

    // Compare with the BVH: the same ray there, and the same image.
    stage.key(Modifiers::COMMAND, Key::B);
    stage.settle();
    let tree =
        history(&Settings { choices: Choices { accelerator: Accelerator::Bvh, ..settings.choices }, ..settings });
    let hit = tree.rows.last().and_then(|row| row.after.triangle.zip(row.after.t)).expect("a hit");
    let line = format!("B: ray of pixel {},{}: ", pixel[0], pixel[1]);
    let end = format!(
        "{} passes: hits triangle {} at t {:.5} scene units",
        tree.rows.len(),
        hit.0,
        f64::from(hit.1) * tree.t_scale
    );
    let reads = |part: &str, end: &str| {
        stage.nodes().iter().any(|node| {
            use egui_kittest::kittest::NodeT as _;
            let node = node.accesskit_node();
            node.value().or(node.label()).is_some_and(|text| text.contains(part) && text.ends_with(end))
        })
    };
    assert!(reads(&line, &end), "{line}…{end}\n{}", stage.read_out());
    stage.click(Role::Button, "Run both to the end");
    stage.settle();
    assert!(stage.reads("No ray differs: hit has the same bits in both runs"), "{}", stage.read_out());

    // Export the passes.
    stage.key(Modifiers::COMMAND, Key::E);
    stage.settle();
    stage.click(Role::Button, Command::ExportPasses.name());
    stage.settle();
    assert!(stage.paints(&format!("{} rows written to ", stage.place())), "{:?}", stage.painted());
    let files = std::mem::take(&mut stage.desk.lock().expect("not poisoned").saved);
    assert_eq!(files.len(), 1);
    assert!(files[0].name.ends_with(".passes.csv"), "{}", files[0].name);
    let mut reader = csv::Reader::from_reader(files[0].bytes.as_slice());
    assert_eq!(reader.headers().expect("a header").iter().collect::<Vec<_>>(), *COLUMNS);
    let rows: Vec<_> = reader.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), stage.place());
    let column = |name: &str| COLUMNS.iter().position(|column| *column == name).expect("a column");
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row[column("pass_index")], i.to_string());
        assert_eq!((&row[column("width_px")], &row[column("accelerator")]), (side.to_string().as_str(), "grid"));
    }
    assert_eq!(&rows[0][column("kernel")], "generate");
}
