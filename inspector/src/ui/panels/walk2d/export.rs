//! The walk so far as an SVG drawing: seen along one axis, and below it unfolded; below that the second walk, on the same
//! scale of t.

use egui::{Painter, Rect, Sense, Ui, vec2};
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::text::counted;

use super::super::walked::number;
use super::progress::Progress;
use super::{Scene, Under, Walk2d, Whole, picture, strip, strip_height};
use crate::exports::ray_name;
use crate::ui::host::FileToSave;
use crate::ui::svg::{self, Titles};
use crate::walk::{Both, Outcome, Spacing, Strip, Structure, TestedTriangle, WalkGeometry};

/// Width of the drawing, and the most height of the picture in it, points.
const WIDTH: f32 = 900.0;
const HIGHEST: f32 = 540.0;
/// Most tests in words, and most triangles that only one of two walks tested.
const MOST_TESTS: usize = 200;
const MOST_IDS: usize = 24;

impl Walk2d {
    /// The walk so far, or all of it before the ray's first pass; beside a second walk, both.
    pub(super) fn drawing(&self, history: &Trace, data: &SceneData) -> Option<FileToSave> {
        let so_far = self.walked.row.map(|row| Whole::of(history, data, row));
        let first = so_far.as_ref().or(self.whole.as_ref())?;
        let second = self.beside.as_ref().map(|beside| {
            let found = &beside.found;
            let until = if found.is_run { up_to(&found.history, found.row) } else { String::new() };
            let whole = Whole::of(&found.history, &found.data, found.row.unwrap_or(usize::MAX));
            let both = Both::of([&first.walk, &whole.walk], [&first.strip, &whole.strip]);
            (format!("The same ray through the {}{until}", found.name), whole, both)
        });
        let title = format!("Ray of {}{}", history.name(), up_to(history, self.walked.row));
        let text = svg::drawing(WIDTH, self.is_dark, |ui, titles| {
            ui.heading(&title);
            ui.label(summary(&first.walk));
            if let Some(height) = picture::height(&first.picture, ui.available_width(), HIGHEST) {
                paint(ui, height, first, self.spacing(), titles, |painter, rect, scene| {
                    picture::draw(painter, rect, &first.picture, scene)
                });
            }
            let Some((title, second, both)) = &second else {
                return unfolded(ui, first, &first.strip, self.spacing(), titles);
            };
            unfolded(ui, first, &first.strip.clone().over(both.t), Spacing::ByT, titles);
            ui.heading(title);
            ui.label(summary(&second.walk));
            unfolded(ui, second, &second.strip.clone().over(both.t), Spacing::ByT, titles);
            for (only, which) in both.only.iter().zip(["first", "second"]) {
                let ids: Vec<String> = only.iter().take(MOST_IDS).map(u32::to_string).collect();
                let more = if only.len() > ids.len() { ", …" } else { "" };
                let text = format!("{}: {}{more}", counted(only.len(), "triangle"), ids.join(", "));
                ui.label(format!("Tested only in the {which}: {}", text.trim_end_matches([':', ' '])));
            }
        });
        Some(FileToSave {
            name: format!("{}.svg", ray_name(history)),
            bytes: text.into_bytes(),
            holds: "a drawing".into(),
        })
    }
}

/// The pass of a row, for titles.
fn up_to(history: &Trace, row: Option<usize>) -> String {
    let row = row.and_then(|row| history.rows.get(row));
    row.map(TraceRow::number).map_or_else(String::new, |pass| format!(", up to pass {pass}"))
}

/// A walk in one sentence.
fn summary(walk: &WalkGeometry) -> String {
    let visited = match walk.structure {
        Structure::Grid => format!("{} visited, ", counted(walk.cells.len(), "cell")),
        Structure::Tree => format!("{} visited, ", counted(walk.nodes.len(), "node")),
        Structure::Nothing => String::new(),
    };
    let tested = counted(walk.tested.len(), "triangle") + " tested";
    let end = match (walk.hit, walk.is_over) {
        (Some(hit), true) => format!("hit triangle {} at t {}", hit.triangle, number(hit.t)),
        (Some(hit), false) => format!("nearest hit so far: triangle {} at t {}", hit.triangle, number(hit.t)),
        (None, true) => "nothing hit".into(),
        (None, false) => "nothing hit yet".into(),
    };
    format!("{visited}{tested}; {end}. Lengths and t in traced units.")
}

/// The strip with its legend, and every test in words.
fn unfolded(ui: &mut Ui, whole: &Whole, strip: &Strip, spacing: Spacing, titles: &Titles) {
    ui.weak(match (whole.walk.structure, spacing) {
        (Structure::Grid, Spacing::ByT) => {
            "Unfolded: width of a cell proportional to its length along the ray; above each cell its tmax along x, y and \
             z, the smallest in red; inside it the triangles tested"
        }
        (Structure::Grid, Spacing::Equal) => {
            "Unfolded: cells equally wide; above each cell its tmax along x, y and z, the smallest in red; inside it the \
             triangles tested"
        }
        (Structure::Tree, _) => {
            "Unfolded: a bar for each node, from where the ray enters its box to where it leaves, below its parent. \
             Outlines: boxes not entered before the nearest hit. Dots: triangles tested"
        }
        (Structure::Nothing, _) => "Unfolded: where the ray meets the planes of the triangles tested",
    });
    paint(ui, strip_height(whole), whole, spacing, titles, |painter, rect, scene| {
        strip::draw(painter, rect, strip, scene)
    });
    let tested = &whole.walk.tested;
    let words: Vec<String> = tested.iter().take(MOST_TESTS).map(in_words).collect();
    let more = tested.len() - words.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    if !words.is_empty() {
        ui.label(format!("Tested, in order: {}{more}", words.join("; ")));
    }
}

/// A test with its t, and why it was not accepted.
fn in_words(test: &TestedTriangle) -> String {
    let t = test.t.map_or_else(String::new, |t| format!(" at t {}", number(t)));
    match test.outcome {
        Outcome::Nearest => format!("{}: hit{t}", test.triangle),
        Outcome::NotNearest => format!("{}: hit{t}, {}", test.triangle, test.why),
        Outcome::Missed => format!("{}: missed, {}", test.triangle, test.why),
    }
}

/// Paints something of a walk, all of which has been reached, in a rectangle of its own.
fn paint(
    ui: &mut Ui,
    height: f32,
    whole: &Whole,
    spacing: Spacing,
    titles: &Titles,
    draw: impl FnOnce(&Painter, Rect, &Scene<'_>) -> Option<Under>,
) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    let walk = &whole.walk;
    let scene = Scene {
        walk,
        now: Some(walk),
        progress: &Progress::new(walk, &whole.picture, walk.row),
        visuals: ui.visuals(),
        unit: 1.0,
        picked: None,
        hides_next: false,
        spacing,
        cursor: None,
        titles: Some(titles),
    };
    // There is no cursor.
    let _nothing = draw(&ui.painter().with_clip_rect(rect), rect, &scene);
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use raystep_kernels::{Accelerator, Options};

    use super::super::super::walked::Walked;
    use super::super::Look;
    use super::super::beside::Beside;
    use super::super::second::Found;
    use super::*;
    use crate::walk::Projected;
    use crate::walk::tests::{CORNELL, TEAPOT, options, scene, traced};

    /// A view of a walk up to a row.
    fn view(history: &Arc<Trace>, data: &SceneData, row: usize, by_t: bool, is_dark: bool) -> Walk2d {
        let walk = Some(WalkGeometry::new(history, data, row));
        Walk2d {
            whole: Some(Whole::of(history, data, usize::MAX)),
            walked: Walked { history: Some(history.clone()), row: Some(row), walk, version: 1 },
            look: Look { by_t, beside: None },
            is_dark,
            ..Walk2d::default()
        }
    }

    /// The drawing; kept where `RAYSTEP_PICTURES` names a folder.
    fn text(view: &Walk2d, history: &Trace, data: &SceneData, name: &str) -> String {
        let file = view.drawing(history, data).expect("a walk");
        let [x, y] = history.pixel;
        assert_eq!(file.name, format!("ray-{x}-{y}.svg"));
        if let Ok(folder) = std::env::var("RAYSTEP_PICTURES") {
            std::fs::write(std::path::Path::new(&folder).join(format!("{name}.svg")), &file.bytes).expect("a file");
        }
        let text = String::from_utf8(file.bytes).expect("text");
        text.replace(">\n", ">").replace("\n<", "<")
    }

    /// Every element that is begun is ended, and nothing is written that SVG does not know.
    fn assert_sound(text: &str, what: &str) {
        for nonsense in ["NaN", "inf", "\u{1}"] {
            assert!(!text.contains(nonsense), "{what}: {nonsense}");
        }
        for element in ["g", "text", "svg", "circle", "polygon", "clipPath", "title", "line", "rect"] {
            let is_begun = |tag: &&str| {
                let name = tag.split([' ', '>', '/']).next();
                name == Some(element) && !tag.split('>').next().unwrap_or(tag).ends_with('/')
            };
            let begun = text.split('<').filter(is_begun).count();
            assert_eq!(begun, text.matches(&format!("</{element}>")).count(), "{what}: {element}");
        }
    }

    /// The tests that the drawing lists, of the first walk.
    fn listed(text: &str) -> Vec<String> {
        let rows = text.split("<text ").filter_map(|part| part.split_once('>')?.1.split_once("</text>"));
        let rows: Vec<&str> = rows.map(|(row, _)| row).collect();
        let Some(first) = rows.iter().position(|row| row.starts_with("Tested, in order: ")) else { return Vec::new() };
        let is_on = |row: &&&str| !row.starts_with("Tested only") && !row.starts_with("The same ray");
        let all = rows[first..].iter().take_while(is_on).copied().collect::<Vec<_>>().join(" ");
        let all = all.trim_start_matches("Tested, in order: ").replace("&lt;", "<");
        all.split("; ").map(str::to_owned).collect()
    }

    #[test]
    fn a_drawing_names_what_it_shows_of_every_structure_and_is_sound() {
        for (path, file, pixel) in [(CORNELL, "cornell", [20, 34]), (TEAPOT, "teapot", [32, 32])] {
            let scene = scene(path);
            for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
                if (path, accelerator) == (TEAPOT, Accelerator::None) {
                    continue;
                }
                let (history, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, pixel);
                let (history, end) = (Arc::new(history.clone()), history.rows.len() - 1);
                for (row, by_t) in [(end / 2, false), (end, false), (end, true)] {
                    let what = format!("{file}-{accelerator}-{row}-{by_t}");
                    let view = view(&history, &data, row, by_t, by_t);
                    let text = text(&view, &history, &data, &what);
                    assert_sound(&text, &what);
                    let paper = if by_t { "<rect fill=\"#1b1b1b\" " } else { "<rect fill=\"#f8f8f8\" " };
                    assert_eq!(text.find(paper), text.find("<rect "), "{what}: dark or light");
                    let walk = view.walked.walk.as_ref().expect("a walk");
                    let [x, y] = pixel;
                    let until = format!(">Ray of pixel {x},{y}, up to pass {}</text>", history.rows[row].number());
                    assert!(text.contains(&until) && text.contains(">view along "), "{what}: {until}");
                    assert!(text.contains(">Unfolded: ") && text.contains(&summary(walk)), "{what}: {}", summary(walk));
                    // Each test that was made so far, and none that comes later.
                    let wanted: Vec<String> = walk.tested.iter().take(MOST_TESTS).map(in_words).collect();
                    let mut listed = listed(&text);
                    listed.truncate(wanted.len());
                    assert_eq!(listed, wanted, "{what}");
                    let whole = WalkGeometry::new(&history, &data, usize::MAX);
                    for later in &whole.tested[walk.tested.len()..] {
                        let is_new = walk.tested.iter().all(|test| test.triangle != later.triangle);
                        let title = format!("triangle {}: ", later.triangle);
                        assert!(!is_new || !text.contains(&title), "{what}: {title} comes after row {row}");
                    }
                    assert_titled(&text, walk, &what);
                    if let Some(cell) = walk.cells.first() {
                        assert!(text.contains(">a</text>") || text.contains(">a…</text>"), "{what}: {}", cell.name());
                    }
                    if path == CORNELL && accelerator == Accelerator::Grid && row == end && !by_t {
                        assert!(text.contains(&number(walk.cells[3].t_out)), "the exit of a cell is on the scale");
                    }
                }
            }
        }
    }

    /// What was under the cursor in the window has a title.
    fn assert_titled(text: &str, walk: &WalkGeometry, what: &str) {
        let has = |title: &str| text.contains(&format!("<title>{}", title.replace('<', "&lt;").replace('>', "&gt;")));
        for test in walk.tested.iter().filter(|test| walk.structure == Structure::Grid || test.t.is_some()) {
            let in_picture = format!("triangle {}: ", test.triangle);
            assert!(has(&in_picture), "{what}: {in_picture}");
        }
        for cell in &walk.cells {
            assert!(text.contains(&format!(": {}, t ", cell.name())), "{what}: {} unfolded", cell.name());
        }
        // Of cells over each other, the first.
        let seen = Projected::new(walk).squares;
        for cell in seen.iter().filter_map(|square| walk.cells.get(*square.visits.first()?)) {
            assert!(has(&format!("{}: t ", cell.name())), "{what}: {} from the side", cell.name());
        }
        for test in walk.tested.iter().filter(|test| walk.structure == Structure::Grid && !test.outcome.is_hit()) {
            let dot = format!("triangle {}: missed ({}), ", test.triangle, test.why);
            assert!(has(&dot), "{what}: {dot}");
        }
        let strip = Strip::new(walk);
        if let Some(hit) = walk.hit {
            assert!(text.contains("<title>nearest hit</title>"), "{what}");
            // Without a structure, the scale of the tests so far may end before it.
            let is_on_scale = (strip.t[0]..=strip.t[1]).contains(&hit.t);
            assert!(is_on_scale || walk.structure == Structure::Nothing, "{what}");
            assert!(!is_on_scale || has(&format!("nearest hit, t {}", number(hit.t))), "{what}");
        }
        assert!(walk.t <= 0.0 || has("current position"), "{what}");
        let is_seen = walk.structure == Structure::Grid && walk.crossings.len() > 4;
        assert!(!is_seen || has("crosses a plane of "), "{what}");
    }

    #[test]
    fn two_walks_are_drawn_below_each_other_with_the_picture_and_what_only_one_tested() {
        let scene = scene(TEAPOT);
        let [(a, data), (b, other)] = [Accelerator::Grid, Accelerator::Bvh]
            .map(|accelerator| traced(&scene, &Options { accelerator, ..options(&scene) }, [32, 32]));
        let (a, b, other) = (Arc::new(a), Arc::new(b), Arc::new(other));
        let last = a.rows.len() - 1;
        for (row, is_run) in [(last, false), (last / 2, true)] {
            let mut view = view(&a, &data, row, true, false);
            let row_of_b = if is_run { b.rows.len() / 2 } else { b.rows.len() - 1 };
            let found =
                Found { history: b.clone(), data: other.clone(), name: "bvh".into(), row: Some(row_of_b), is_run };
            Beside::update(&mut view.beside, &a, view.whole.as_ref().expect("a walk"), &found);
            let text = text(&view, &a, &data, &format!("teapot-both-{is_run}"));
            assert_sound(&text, "both");
            let second = WalkGeometry::new(&b, &other, row_of_b);
            let first = view.walked.walk.as_ref().expect("a walk");
            for wanted in [">view along ", &summary(first), &summary(&second), ">The same ray through the bvh"] {
                assert!(text.contains(wanted), "{wanted}: {text}");
            }
            assert_eq!(text.matches(", up to pass ").count(), 1 + usize::from(is_run), "of B only where it is stepped");
            // The tests so far, and only these are told apart.
            let wanted: Vec<String> = first.tested.iter().take(MOST_TESTS).map(in_words).collect();
            assert_eq!(listed(&text), wanted);
            let whole = Both::of([first, &second], [&Strip::new(first), &Strip::new(&second)]);
            for (only, which) in whole.only.iter().zip(["first", "second"]) {
                let wanted = format!(">Tested only in the {which}: {}", counted(only.len(), "triangle"));
                assert!(text.contains(&wanted), "{wanted}");
            }
            // Nothing is squeezed: every level of the BVH has room for names.
            let lines = Strip::new(&second).lines() as f32;
            assert_eq!(strip_height(&Whole::of(&b, &other, row_of_b)), strip::TREE_EDGES + 16.0 * lines);
            let named = second.nodes.iter().filter(|node| text.contains(&format!(">{}: ", node.node))).count();
            assert!(named > 0, "no node has a name");
        }
    }
}
