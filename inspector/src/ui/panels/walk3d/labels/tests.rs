//! Labels of many walks, at many sizes and from many sides.

use egui::{Event, RawInput, pos2};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Accelerator, Options};

use super::super::super::labels::assert_apart;
use super::super::super::walked::tests::history;
use super::*;
use crate::walk::tests::{TEAPOT, options, scene, traced};

const STYLE: LabelStyle = LabelStyle { scale: Scale::TRACED, hides_next: false };

/// A walk alone.
fn of(walk: &WalkGeometry) -> Subject<'_> {
    Subject { walk, lights: &[], picked: None }
}

/// Lays out labels as in a frame.
fn in_a_frame<T>(show: impl Fn(&egui::Painter, &egui::Visuals) -> T) -> T {
    let ctx = egui::Context::default();
    let mut result = None;
    let input = RawInput { events: vec![Event::PointerGone], ..RawInput::default() };
    let mut output = ctx.run_ui(input, |ui| result = Some(show(ui.painter(), ui.visuals())));
    // No renderer takes the font.
    output.textures_delta.clear();
    result.expect("a frame")
}

#[test]
fn no_label_lies_over_another_or_is_cut_off_whatever_the_walk_the_size_and_the_camera() {
    let teapot = scene(TEAPOT);
    let mut walks = Vec::new();
    for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
        let mut add = |(history, data): (_, SceneData)| {
            let history: raystep_kernels::export::trace::Trace = history;
            let rows = history.rows.len();
            walks
                .extend([1, rows / 3, rows / 2, rows * 3 / 4, rows].map(|row| WalkGeometry::new(&history, &data, row)));
        };
        add(history(accelerator));
        if accelerator != Accelerator::None {
            add(traced(&teapot, &Options { accelerator, ..options(&teapot) }, [32, 32]));
        }
    }
    let most = in_a_frame(|painter, visuals| {
        let mut most = 0;
        for (i, walk) in walks.iter().enumerate() {
            for size in [vec2(468.0, 120.0), vec2(170.0, 100.0), vec2(1200.0, 700.0), vec2(60.0, 30.0)] {
                let rect = Rect::from_min_size(pos2(11.0, 23.0), size);
                let aspect = f64::from(size.x / size.y);
                let mut camera = Orbit::framing(&walk.bounds, aspect);
                camera.frame_from_side(&walk.extent(), walk.direction, aspect, 0.1);
                for turn in 0..6 {
                    let marked = walk
                        .tested
                        .first()
                        .map(|test| (Picked::Triangle(test.triangle), Marked::Triangle(test.corners)));
                    let ready = arrange(
                        painter,
                        visuals,
                        rect,
                        Subject { picked: marked.filter(|_| turn % 2 == 0), ..of(walk) },
                        &camera,
                        STYLE,
                    );
                    let rects: Vec<Rect> = ready.iter().map(|label| label.place.rect).collect();
                    assert_apart(rect, &rects, &format!("walk {i}, {size}, turn {turn}"));
                    let text = |label: &Ready| label.place.rect.shrink2(MARGIN).size() - label.galley.size();
                    assert!(ready.iter().all(|label| text(label).length() < 0.1), "texts fit into their labels");
                    most = most.max(ready.len());
                    camera.orbit(DVec2::new(37.0, 11.0), DVec2::new(size.x.into(), size.y.into()));
                }
            }
        }
        most
    });
    assert!(most >= 5, "at most {most} labels in any picture");
}

#[test]
fn the_small_pane_of_the_full_layout_has_room_for_what_matters_most() {
    let (history, data) = history(Accelerator::Grid);
    let whole = WalkGeometry::new(&history, &data, usize::MAX);
    let test = whole.tested.iter().find(|test| !test.outcome.is_hit()).expect("a miss");
    let walk = WalkGeometry::new(&history, &data, test.row);
    let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(468.0, 120.0));
    let mut camera = Orbit::framing(&walk.bounds, 3.9);
    camera.frame_from_side(&whole.extent(), walk.direction, 3.9, 0.12);
    let texts = in_a_frame(|painter, visuals| {
        let ready = arrange(painter, visuals, rect, of(&walk), &camera, STYLE);
        ready.iter().map(|label| label.galley.text().to_owned()).collect::<Vec<_>>()
    });
    let starts = |part: &str| texts.iter().any(|text| text.starts_with(part));
    assert!(starts("triangle ") && starts("cell ") && texts.iter().any(|text| text.ends_with(": next")), "{texts:?}");
}

#[test]
fn labels_tell_cell_and_test_and_why() {
    let (history, data) = history(Accelerator::Grid);
    let whole = WalkGeometry::new(&history, &data, usize::MAX);
    let test = whole.tested.iter().find(|test| !test.outcome.is_hit()).expect("a miss");
    let texts: Vec<String> =
        labels(of(&WalkGeometry::new(&history, &data, test.row)), STYLE).into_iter().map(|label| label.text).collect();
    let [x, y, z] = whole.cells[test.visit.expect("a cell")].cell;
    assert_eq!(texts[0], format!("triangle {}: missed, {}", test.triangle, test.why), "{texts:?}");
    assert_eq!(texts[1], format!("cell {x},{y},{z}"), "{texts:?}");
    assert!(texts[2].starts_with("tmax ") && texts[2].ends_with(": next"), "{texts:?}");
    // At the end, there is no next cell.
    let end = labels(of(&whole), STYLE);
    assert!(end.iter().all(|label| !matches!(label.about, About::Axis(_))), "{end:?}");
    assert_eq!(end[0].about, About::Triangle(Outcome::Nearest));
}
