//! The strip in words, its scale, and its labels.

use egui::RawInput;
use raystep_kernels::{Accelerator, Options, Skip};

use super::super::super::labels::assert_apart;
use super::super::super::walked::{number, tests::history};
use super::super::Whole;
use super::super::progress::Progress;
use super::words::{cell_words, leap_words, note_words, test_words};
use super::*;
use crate::walk::WalkGeometry;
use crate::walk::tests::{CORNELL, TEAPOT, options, scene, traced};

/// Shows something of a walk in a frame.
fn in_a_frame<T>(whole: &Whole, row: Option<usize>, show: impl Fn(&Painter, &Scene<'_>) -> T) -> T {
    let progress = Progress::new(&whole.walk, &whole.picture, row);
    let ctx = egui::Context::default();
    let mut result = None;
    let mut output = ctx.run_ui(RawInput::default(), |ui| {
        let scene = Scene {
            walk: &whole.walk,
            now: Some(&whole.walk),
            progress: &progress,
            visuals: ui.visuals(),
            unit: 1.0,
            picked: None,
            hides_next: false,
            spacing: Spacing::Equal,
            cursor: None,
            titles: None,
        };
        result = Some(show(ui.painter(), &scene));
    });
    // No renderer takes the font.
    output.textures_delta.clear();
    result.expect("a frame")
}

#[test]
fn a_cell_is_told_in_numbers() {
    let (history, data) = history(Accelerator::Grid);
    let whole = Whole::of(&history, &data, usize::MAX);
    let cell = whole.strip.cells.iter().find(|cell| !cell.tests.is_empty()).expect("a test");
    let text = in_a_frame(&whole, None, |_, scene| cell_words(cell, scene));
    let [x, y, z] = cell.cell;
    let tmax = number(cell.tmax[cell.exit_axis].expect("a tmax"));
    assert!(text.contains(&format!("cell {x},{y},{z}, t {}", number(cell.t[0]))), "{text}");
    assert!(text.contains(&format!("{} {tmax}", crate::walk::AXES[cell.exit_axis])), "{text}");
    assert!(text.contains(&format!("{} tested", cell.tests.len())), "{text}");
    // In other units, all numbers are others.
    let doubled = in_a_frame(&whole, None, |_, scene| cell_words(cell, &Scene { unit: 2.0, ..*scene }));
    assert!(doubled.contains(&format!("t {}", number(2.0 * cell.t[0]))) && doubled != text, "{doubled}");
}

#[test]
fn a_test_is_told_with_its_reason() {
    let scene = scene(CORNELL);
    let mut reasons = std::collections::BTreeSet::new();
    for accelerator in [Accelerator::Grid, Accelerator::None] {
        for pixel in [[32, 32], [44, 50], [20, 40]] {
            let (history, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, pixel);
            let whole = Whole::of(&history, &data, usize::MAX);
            for test in &whole.walk.tested {
                let [long, short, hover] = in_a_frame(&whole, None, |_, scene| {
                    [note_words(test, true, scene), note_words(test, false, scene), test_words(test, scene)]
                });
                assert!(short.len() <= long.len() && short.starts_with(&test.triangle.to_string()), "{short} {long}");
                let why = test.why.to_string();
                assert_eq!(test.outcome == Outcome::Nearest, test.why == crate::walk::Why::Accepted);
                assert!(test.outcome == Outcome::Nearest || long.contains(&why) && hover.contains(&why), "{long}");
                // The kernels' own explanation gives the same reason.
                let row_why = &history.rows[test.row].why;
                if let Some(weight) = why.strip_suffix(" < 0") {
                    assert!(
                        row_why.contains(&format!("{weight} = -")) && row_why.contains(", outside"),
                        "{why}: {row_why}"
                    );
                }
                assert_eq!(why == "not nearer", row_why.contains("not nearer than"), "{why}: {row_why}");
                reasons.insert(why);
            }
        }
    }
    assert!(reasons.len() >= 4 && reasons.contains("not nearer"), "{reasons:?}");
}

#[test]
fn a_cell_that_is_left_by_a_leap_says_so_and_has_a_gap() {
    let scene = scene(TEAPOT);
    let (history, data) = traced(&scene, &Options { skip: Skip::On, ..options(&scene) }, [32, 32]);
    let whole = Whole::of(&history, &data, usize::MAX);
    let strip = &whole.strip;
    let columns = strip.columns(Spacing::Equal);
    let mut leaps = 0;
    for (i, pair) in strip.cells.windows(2).enumerate() {
        let [from, to] = [pair[0].cell, pair[1].cell];
        let moved = [0, 1, 2].map(|axis: usize| to[axis] - from[axis]);
        let [x, y, z] = moved;
        let is_leap = moved.iter().map(|n| n.abs()).sum::<i32>() > 1;
        let [words, leap] =
            in_a_frame(&whole, None, |_, scene| [cell_words(&pair[0], scene), leap_words(&pair[0], scene)]);
        assert_eq!(words.contains(&format!(", then skips {x},{y},{z} cells\n")), is_leap, "{words}");
        assert_eq!(leap.starts_with(&format!("leap by {x},{y},{z} cells, over empty cells")), is_leap, "{leap}");
        let gap = columns[i + 1][0] - columns[i][1];
        let width = columns[i][1] - columns[i][0];
        assert!(if is_leap { gap > 0.5 * width } else { gap.abs() < 1e-12 }, "{gap} {width}");
        if is_leap && pair[1].t[0] > pair[0].t[1] {
            let middle = strip.place((pair[0].t[1] + pair[1].t[0]) * 0.5, Spacing::Equal);
            assert!(columns[i][1] < middle && middle < columns[i + 1][0], "t within a leap lies in its gap");
        }
        leaps += u32::from(is_leap);
    }
    assert!(leaps > 0);
    assert!((columns[columns.len() - 1][1] - 1.0).abs() < 1e-12, "the last cell ends the strip");
}

#[test]
fn the_scale_goes_over_the_whole_strip_in_round_numbers_or_by_cells() {
    for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
        let (history, data) = history(accelerator);
        let strip = Strip::new(&WalkGeometry::new(&history, &data, usize::MAX));
        for spacing in [Spacing::ByT, Spacing::Equal] {
            for unit in [1.0, 4.0, 0.125] {
                let marks = marks(&strip, spacing, unit, 460.0);
                assert!(marks.len() > 2 && marks.iter().map(|mark| mark.0).is_sorted(), "{marks:?}");
                for (t, text) in &marks {
                    assert!(*t >= strip.t[0] - 1e-9 && *t <= strip.t[1] + 1e-9, "{t} in {:?}", strip.t);
                    let read: f64 = text.parse().expect("a number");
                    // Four digits, or three after the point.
                    assert!((read - t * unit).abs() <= 5.1e-4 * (t * unit).abs().max(1.0), "{text} for {t}");
                }
                if spacing == Spacing::Equal && !strip.cells.is_empty() {
                    // The exit of every cell.
                    assert_eq!(marks.len(), strip.cells.len() + 1);
                }
            }
        }
    }
}

#[test]
fn painted_texts_lie_apart_and_within_at_every_size() {
    let teapot = scene(TEAPOT);
    let mut all = Vec::new();
    for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
        all.push(history(accelerator));
        if accelerator != Accelerator::None {
            all.push(traced(&teapot, &Options { accelerator, ..options(&teapot) }, [32, 32]));
        }
    }
    let (mut labels, mut names) = (0, 0);
    for (i, (history, data)) in all.iter().enumerate() {
        let whole = Whole::of(history, data, usize::MAX);
        for size in [[468, 65], [468, 190], [620, 190], [850, 240], [1200, 300], [120, 40]] {
            let size = size.map(|side: u16| f32::from(side)).into();
            let rect = Rect::from_min_size(pos2(5.0, 7.0), size);
            for spacing in [Spacing::ByT, Spacing::Equal] {
                for row in [history.rows.len() / 3, history.rows.len() / 2, history.rows.len() - 1] {
                    let [placed, written] = in_a_frame(&whole, Some(row), |painter, scene| {
                        let (body, _) = split_scale(rect);
                        let scene = Scene { spacing, ..*scene };
                        let mut pen = Pen::new(painter, body, &whole.strip, &scene);
                        let _ = pen.draw();
                        // Whatever was noted has been placed, or left out.
                        let notes = std::mem::take(&mut pen.placed);
                        assert_apart(body, &notes, &format!("walk {i}, {size}, {spacing:?}, row {row}"));
                        let is_over = |bar: &Rect| notes.iter().any(|note| note.shrink(0.5).intersects(*bar));
                        assert!(!pen.bars.iter().any(is_over), "walk {i}, {size}: a label is over a bar");
                        for (i, [ink, bar]) in pen.written.iter().enumerate() {
                            assert!(bar.contains_rect(ink.expand(1.0)), "{size}: {ink} is cut off by {bar}");
                            let is_beneath = |dot: &Rect| dot.shrink(1.5).intersects(*ink);
                            assert!(!pen.dots.iter().any(is_beneath), "{size}: {ink} is over a test");
                            let is_over = |[other, _]: &[Rect; 2]| other.intersects(*ink);
                            assert!(!pen.written[..i].iter().any(is_over), "{size}: {ink} is over another name");
                        }
                        [notes.len(), pen.written.len()]
                    });
                    (labels, names) = (labels + placed, names + written);
                }
            }
        }
    }
    assert!(labels > 20 && names > 20, "{labels} labels and {names} names in all");
}
