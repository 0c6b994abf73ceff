//! Tables: sorted, filtered, used by keys, and never cut off; the value under the cursor.

use egui::{Event, Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::programs::closest_hit::streams;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

const PLACE: usize = 20;

fn stage(size: [f32; 2], kinds: &[PaneKind]) -> Stage {
    let settings = Settings { size: [32, 32], device: DeviceKind::Cpu, ..Settings::default() };
    let mut stage = Stage::new(Plan { size, ..Plan::default() });
    stage.open(CORNELL, settings, Arrival { pixel: Some([20, 22]), place: Some(PLACE), ..Arrival::default() });
    stage.close_panels();
    for kind in kinds {
        stage.perform(Command::Show(*kind));
    }
    stage
}

/// The rows of tables, as screen readers are told them.
fn rows(stage: &Stage) -> Vec<String> {
    let nodes = stage.nodes().into_iter().filter(|node| node.accesskit_node().role() == Role::Row);
    nodes.filter_map(|node| node.accesskit_node().label()).collect()
}

/// The rays of each pass.
fn rays(stage: &Stage) -> Vec<u32> {
    rows(stage).iter().filter_map(|row| row.split(", ").nth(3)?.parse().ok()).collect()
}

#[test]
fn a_click_on_a_head_sorts_and_a_third_one_no_longer() {
    let mut stage = stage([600.0, 900.0], &[PaneKind::Passes]);
    let natural = rows(&stage);
    assert!(rays(&stage).len() == PLACE && natural[0].contains("start"), "{natural:?}");
    let sorted = |stage: &mut Stage| {
        stage.click(Role::ColumnHeader, "sort passes by rays");
        stage.settle();
        rays(stage)
    };
    let up = sorted(&mut stage);
    assert!(up.len() == PLACE && up.is_sorted() && up[0] < up[PLACE - 1], "{up:?}");
    let down = sorted(&mut stage);
    assert!(down.iter().rev().is_sorted() && down.len() == PLACE, "{down:?}");
    sorted(&mut stage);
    assert_eq!(rows(&stage), natural);
}

#[test]
fn words_filter_rows_and_numbers_compare() {
    let mut stage = stage([600.0, 900.0], &[PaneKind::Passes]);
    let natural = rows(&stage).len();
    stage.get(Role::TextInput, "filter passes").focus();
    stage.frame();
    stage.text("INTER rays>0");
    stage.settle();
    let shown = rows(&stage);
    assert!(shown.len() > 3 && shown.len() <= PLACE && shown.iter().all(|row| row.contains("intersect")), "{shown:?}");
    // Turns of loops are no rows of a list.
    assert!(stage.reads(&format!("{} of {} rows", shown.len(), PLACE + 1)), "{}", stage.read_out());
    stage.click(Role::Button, "×");
    stage.settle();
    assert_eq!(rows(&stage).len(), natural);
}

#[test]
fn keys_choose_the_row_below_while_other_keys_stay_commands() {
    let mut stage = stage([600.0, 400.0], &[PaneKind::Passes]);
    // A list, not a tree.
    stage.click(Role::ColumnHeader, "sort passes by pass");
    stage.settle();
    let current = stage.find(Role::Row, |row| row.starts_with(&format!("{}, ", PLACE - 1))).expect("a row in view");
    let at = current.rect().center();
    stage.click_at(at);
    stage.settle();
    for _ in 0..3 {
        stage.key(Modifiers::NONE, Key::ArrowUp);
    }
    stage.settle();
    assert_eq!(stage.place(), PLACE - 3);
    stage.key(Modifiers::NONE, Key::ArrowDown);
    stage.settle();
    assert_eq!(stage.place(), PLACE - 2);
    let pixel = stage.inspector().pixel().expect("a ray");
    stage.key(Modifiers::NONE, Key::ArrowRight);
    stage.settle();
    assert_eq!(stage.inspector().pixel(), Some([pixel[0] + 1, pixel[1]]));
    stage.key(Modifiers::NONE, Key::PageUp);
    stage.settle();
    assert!(stage.place() < PLACE - 8, "{}", stage.place());
    stage.key(Modifiers::NONE, Key::Home);
    stage.settle();
    assert_eq!(stage.place(), 0);
    assert!(rows(&stage).iter().any(|row| row.contains("start")), "the current row is in view: {:?}", rows(&stage));
    // Without the focus, the arrows are commands again.
    stage.key(Modifiers::NONE, Key::Escape);
    stage.key(Modifiers::NONE, Key::ArrowDown);
    stage.settle();
    assert_eq!((stage.place(), stage.inspector().pixel()), (0, Some([pixel[0] + 1, pixel[1] + 1])));
}

/// Texts that are wider than what is shown of them.
fn cut(stage: &Stage, status: f32) -> Vec<String> {
    fn collect(shape: &egui::Shape, clip: egui::Rect, status: f32, cut: &mut Vec<String>) {
        match shape {
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, clip, status, cut)),
            egui::Shape::Text(text) => {
                let rect = text.visual_bounding_rect();
                // Rows may be scrolled half out of view, and half a point is antialiasing.
                let is_seen = rect.intersects(clip) && rect.width() > 0.0 && rect.top() < status;
                if is_seen && (rect.right() > clip.right() + 0.5 || rect.left() < clip.left() - 0.5) {
                    cut.push(text.galley.text().to_owned());
                }
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    for clipped in &stage.harness.output().shapes {
        collect(&clipped.shape, clipped.clip_rect, status, &mut found);
    }
    found
}

#[test]
fn no_text_of_a_table_is_cut_off() {
    use PaneKind as P;
    for size in [[360.0, 500.0], [560.0, 500.0], [1280.0, 720.0]] {
        for kind in [P::Passes, P::Ray, P::Log, P::Cost, P::Watches, P::Timings] {
            let mut stage = stage(size, &[kind]);
            if kind == P::Cost {
                stage.perform(Command::End);
                stage.click(Role::Button, "Rays");
            }
            stage.settle();
            // Without edits there is no list of them; in a small window, that of rays has to be scrolled to.
            let may_be_empty = kind == P::Watches || kind == P::Cost && size[0] < 1000.0;
            assert!(may_be_empty || !rows(&stage).is_empty(), "{kind:?} at {size:?}");
            // The status bar is wider than the smallest window.
            assert_eq!(cut(&stage, size[1] - 24.0), Vec::<String>::new(), "{kind:?} at {size:?}");
        }
    }
}

#[test]
fn the_reason_is_in_view_however_narrow_the_panel_is() {
    for width in [300.0, 560.0, 1280.0] {
        let stage = stage([width, 700.0], &[PaneKind::Ray]);
        let reasons = stage.painted().into_iter().filter(|text| text.starts_with("triangle "));
        assert!(reasons.count() > 2, "at {width}: {:?}", stage.painted());
    }
}

#[test]
fn units_are_the_same_in_head_and_rows() {
    let mut stage = stage([1280.0, 700.0], &[PaneKind::Ray]);
    let history = stage.inspector().model().history.clone().expect("a history");
    let last = history.rows.last().expect("a row").after;
    let t = f64::from(last.t.expect("a hit"));
    assert_ne!(history.t_scale, 1.0, "the box is larger than a traced unit");
    for (unit, scale) in [("traced units", 1.0), ("scene units", history.t_scale)] {
        stage.click(Role::Button, unit);
        stage.settle();
        let digits = |decimals: usize| format!("{:.decimals$}", t * scale);
        let begins = digits(3);
        let wanted = format!("at t {}", &begins[..4]);
        let head = stage.painted().iter().any(|text| text.starts_with("hits triangle") && text.contains(&wanted));
        let row = rows(&stage).iter().any(|row| row.contains(&begins[..4]));
        assert!(head && row, "{unit}: {begins}: {:?}", rows(&stage));
    }
}

#[test]
fn the_range_of_colours_is_in_the_units_that_are_chosen() {
    let mut stage = stage([1280.0, 700.0], &[PaneKind::Ray, PaneKind::Stream]);
    stage.perform(Command::End);
    stage.show_stream(streams::STATE, "t");
    let [traced, scene] = ["traced units", "scene units"].map(|unit| {
        stage.perform(Command::Show(PaneKind::Ray));
        stage.click(Role::Button, unit);
        stage.perform(Command::Show(PaneKind::Stream));
        let legend = format!(" t in {unit}");
        assert!(stage.painted().iter().any(|text| text.ends_with(&legend)), "{:?}", stage.painted());
        ["from", "to"].map(|end| stage.number(end))
    });
    let scale = stage.inspector().model().history.as_ref().expect("a history").t_scale;
    for (traced, scene) in traced.into_iter().zip(scene) {
        // Fields have four decimals.
        assert!(traced > 0.1 && (scene - scale * traced).abs() <= 1e-4 * scale, "{traced} {scene} {scale}");
    }
}

#[test]
fn the_value_under_the_cursor_is_told_also_of_copies() {
    let mut stage = stage([900.0, 700.0], &[PaneKind::Stream]);
    let middle = stage.find(Role::Image, |name| name.starts_with("state after")).expect("a stream").rect().center();
    stage.event(Event::PointerMoved(middle));
    stage.settle();
    let line = |stage: &Stage| stage.painted().into_iter().find(|text| text.contains("   tag "));
    let told = line(&stage).expect("a line with the value");
    for part in ["tag ", "t ", "cell ", "item "] {
        assert!(told.contains(part), "{told}");
    }
    let name = stage.find(Role::Image, |name| name.contains("under the cursor")).expect("the same for screen readers");
    assert!(name.accesskit_node().label().is_some_and(|label| label.contains(&told)));
    stage.key(Modifiers::NONE, Key::M);
    stage.settle();
    let bits = |stage: &Stage| stage.painted().into_iter().filter(|text| text.starts_with("0x")).collect::<Vec<_>>();
    assert_eq!(bits(&stage).len(), 4, "{:?}", stage.painted());
    stage.key(Modifiers::NONE, Key::M);
    // A copy keeps its values while the run goes on.
    stage.perform(Command::Pin);
    stage.perform(Command::End);
    stage.event(Event::PointerMoved(middle + egui::vec2(0.0, 0.1)));
    stage.settle();
    assert_eq!(line(&stage), Some(told));
}
