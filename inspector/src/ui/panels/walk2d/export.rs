//! The walk as an SVG drawing.

use egui::{Sense, vec2};
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::text::counted;

use super::super::walked::describe;
use super::progress::Progress;
use super::{Scene, Walk2d, Whole, strip, strip_height};
use crate::ui::host::FileToSave;
use crate::ui::svg;

/// Width of the drawing, and the most height of the picture in it, points.
const WIDTH: f32 = 900.0;
const HIGHEST: f32 = 540.0;
/// Most tests in words, and most triangles that only one of two walks tested.
const MOST_TESTS: usize = 200;
const MOST_IDS: usize = 24;

impl Walk2d {
    /// The walk so far; beside a second walk, both of them as they are shown. `first` is the name of its structure.
    pub(super) fn drawing(&self, history: &Trace, data: &SceneData, first: &str) -> Option<FileToSave> {
        let shown = self.whole.as_ref()?;
        let row = self.walked.row;
        let so_far = row.filter(|_| self.beside.is_none()).map(|row| Whole::of(history, data, row));
        let drawn = so_far.as_ref().unwrap_or(shown);
        let now = self.walked.walk.as_ref().unwrap_or(&drawn.walk);
        let progress = Progress::new(&drawn.walk, &drawn.picture, now.row);
        let [x, y] = history.pixel;
        let last = row.and_then(|row| history.rows.get(row)).map(TraceRow::number);
        let until = last.map_or_else(String::new, |pass| format!(", up to pass {pass}"));
        let names = self.beside.as_ref().map(|beside| [first, beside.name.as_str()]);
        let text = svg::drawing(WIDTH, self.is_dark, |ui| {
            ui.heading(format!("Ray of pixel {x},{y}{until}"));
            ui.label(format!("{}. Lengths and t in traced units.", describe(now)));
            let visuals = ui.visuals().clone();
            let walk = &drawn.walk;
            let scene = Scene {
                walk,
                now: Some(now),
                progress: &progress,
                visuals: &visuals,
                unit: 1.0,
                picked: None,
                hides_next: false,
                spacing: self.spacing(),
                cursor: None,
            };
            let size = vec2(ui.available_width(), HIGHEST + strip_height(drawn));
            let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
            self.paint(ui.painter(), rect, drawn, names, &scene);
            let tested = walk.tested.iter().take(MOST_TESTS);
            let words: Vec<String> = tested.map(|test| strip::note_words(test, true, &scene)).collect();
            let more = walk.tested.len() - words.len();
            let more = if more > 0 { format!("; and {more} more") } else { String::new() };
            if !words.is_empty() {
                ui.label(format!("Tested, in order: {}{more}", words.join("; ")));
            }
            for (only, side) in self.beside.iter().flat_map(|beside| beside.only()) {
                let ids: Vec<String> = only.iter().take(MOST_IDS).map(u32::to_string).collect();
                let more = if only.len() > ids.len() { ", …" } else { "" };
                ui.label(format!(
                    "Tested only in {side}: {}: {}{more}",
                    counted(only.len(), "triangle"),
                    ids.join(", ")
                ));
            }
        });
        Some(FileToSave { name: format!("ray-{x}-{y}.svg"), bytes: text.into_bytes(), holds: "a drawing".into() })
    }
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
    use crate::walk::WalkGeometry;
    use crate::walk::tests::{CORNELL, TEAPOT, options, scene, traced};

    /// A view of a walk up to a row.
    fn view(history: &Arc<Trace>, data: &SceneData, row: usize, by_t: bool) -> Walk2d {
        let walk = Some(WalkGeometry::new(history, data, row));
        Walk2d {
            whole: Some(Whole::of(history, data, usize::MAX)),
            walked: Walked { history: Some(history.clone()), row: Some(row), walk, version: 1 },
            look: Look { by_t, beside: None },
            ..Walk2d::default()
        }
    }

    fn text(view: &Walk2d, history: &Trace, data: &SceneData, first: &str) -> String {
        let file = view.drawing(history, data, first).expect("a walk");
        let [x, y] = history.pixel;
        assert_eq!(file.name, format!("ray-{x}-{y}.svg"));
        let text = String::from_utf8(file.bytes).expect("text");
        text.replace(">\n", ">").replace("\n<", "<")
    }

    #[test]
    fn a_drawing_names_what_it_shows_of_every_structure() {
        for (path, pixel) in [(CORNELL, [20, 34]), (TEAPOT, [32, 32])] {
            let scene = scene(path);
            for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
                if (path, accelerator) == (TEAPOT, Accelerator::None) {
                    continue;
                }
                let (history, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, pixel);
                let (history, end) = (Arc::new(history.clone()), history.rows.len() - 1);
                for (row, by_t) in [(end / 2, false), (end, true)] {
                    let view = view(&history, &data, row, by_t);
                    let text = text(&view, &history, &data, accelerator.name());
                    let walk = view.walked.walk.as_ref().expect("a walk");
                    let [x, y] = pixel;
                    let until = format!("pixel {x},{y}, up to pass {}</text>", history.rows[row].number());
                    assert!(text.contains(&until) && text.contains(">view along "), "{path} {accelerator}: {until}");
                    assert_eq!(text.contains("Tested, in order: "), !walk.tested.is_empty());
                    if let (Some(cell), true) = (walk.cells.first(), by_t) {
                        // Dots: more visits of its square.
                        let has_letter = text.contains(">a</text>") || text.contains(">a…</text>");
                        assert!(has_letter, "the letter of {}", cell.name());
                        assert!(text.contains(&format!("{} cells visited", walk.cells.len())));
                    }
                    for nonsense in ["NaN", "inf"] {
                        assert!(!text.contains(nonsense), "{path} {accelerator}: {nonsense}");
                    }
                }
            }
        }
    }

    #[test]
    fn two_walks_are_drawn_below_each_other_with_what_only_one_tested() {
        let scene = scene(TEAPOT);
        let [(a, data), (b, other)] = [Accelerator::Grid, Accelerator::Bvh]
            .map(|accelerator| traced(&scene, &Options { accelerator, ..options(&scene) }, [32, 32]));
        let (a, row) = (Arc::new(a), b.rows.len().checked_sub(1));
        let mut view = view(&a, &data, a.rows.len() - 1, true);
        let (history, data_of_b) = (Arc::new(b), Arc::new(other));
        let found = Found { history, data: data_of_b, name: "bvh".into(), row, is_run: false };
        Beside::update(&mut view.beside, &a, view.whole.as_ref().expect("a walk"), &found);
        let text = text(&view, &a, &data, "grid");
        assert!(text.contains(">A grid: ") && text.contains(">B bvh: "), "{text}");
        assert!(text.contains(">Tested only in A: ") && text.contains(">Tested only in B: "), "{text}");
    }
}
