//! The passes as a tree of the turns of loops, which are folded by the mouse and by keys.

use egui::{Event, Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::Choices;
use raystep_kernels::options::ProgramName;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};
use crate::ui::timeline::sort;

const PLACE: usize = 20;

fn stage(settings: Settings, place: usize) -> Stage {
    let mut stage = Stage::new(Plan { size: [600.0, 900.0], ..Plan::default() });
    stage.open(CORNELL, settings, Arrival { place: Some(place), ..Arrival::default() });
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::Passes));
    stage
}

fn cornell() -> Settings {
    Settings { size: [32, 32], device: DeviceKind::Cpu, ..Settings::default() }
}

/// The rows without their times, and which of them is the current one.
fn rows(stage: &Stage) -> (Vec<String>, Option<usize>) {
    let nodes: Vec<_> = stage.nodes().into_iter().filter(|node| node.accesskit_node().role() == Role::Row).collect();
    let two = |row: String| row.split(", ").take(3).collect::<Vec<_>>().join(", ");
    let texts = nodes.iter().filter_map(|node| node.accesskit_node().label()).map(two).collect();
    (texts, nodes.iter().position(|node| node.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)))
}

/// The place of a row that begins like this.
#[track_caller]
fn at(rows: &[String], begins: &str) -> usize {
    rows.iter().position(|row| row.starts_with(begins)).unwrap_or_else(|| panic!("no {begins:?} in {rows:?}"))
}

#[test]
fn turns_fold_stay_so_while_the_run_is_stepped_and_open_for_the_current_pass() {
    let mut stage = stage(cornell(), PLACE);
    let (all, _) = rows(&stage);
    let model = stage.harness.state().model();
    let (passes, turn) = (model.passes.clone(), at(&all, "4–5, iteration 1"));
    assert_eq!(passes[4].loops, [1], "{:?}", passes[4]);
    // All is told of the passes.
    let sum: u64 = passes[4..=5].iter().filter_map(|pass| pass.duration_ns).sum();
    let row = format!("4–5, iteration 1, {:.1}, ", sum as f64 / 1e3);
    assert!(sum > 0 && stage.find(Role::Row, |name| name == row).is_some(), "{row}: {}", stage.read_out());
    stage.click(Role::Button, "fold iteration 1");
    stage.settle();
    let without = |rows: &[String]| [&rows[..=turn], &rows[turn + 3..]].concat();
    assert_eq!(rows(&stage).0, without(&all));
    for _ in 0..3 {
        stage.perform(Command::NextPass);
    }
    let (further, current) = rows(&stage);
    assert!(further.len() > all.len() - 2 && further.starts_with(&without(&all)[..turn + 2]), "{further:?}");
    assert_eq!(current.map(|row| further[row].starts_with("22, ")), Some(true), "{further:?}");
    // Into the turn, and out of it.
    for (place, is_open) in [(5, true), (4, false)] {
        while stage.place() > place {
            stage.perform(Command::PreviousPass);
        }
        let (now, current) = rows(&stage);
        assert_eq!(now[turn + 1].starts_with("4, "), is_open, "{now:?}");
        assert_eq!(current.map(|row| now[row].starts_with(&format!("{}, ", place - 1))), Some(true), "{now:?}");
        let name = if is_open { "fold iteration 1" } else { "unfold iteration 1" };
        let arrow = stage.find(Role::Button, |found| found == name).expect("an arrow");
        assert_eq!(arrow.accesskit_node().is_disabled(), is_open, "the current turn stays unfolded");
    }
    stage.click(Role::Button, "unfold iteration 1");
    stage.settle();
    assert_eq!(rows(&stage).0.len(), further.len() + 2);
    assert_eq!(stage.harness.unnamed_widgets(), Vec::<String>::new());
    // Sorted, there are only passes, and each says where it was.
    stage.click(Role::ColumnHeader, "sort passes by pass");
    stage.settle();
    let (sorted, _) = rows(&stage);
    assert_eq!(sorted.len(), passes.len() + 3 + 1, "{sorted:?}");
    let is_it = |row: &str| row.starts_with("5, ") && row.ends_with(", iteration 1");
    assert!(stage.find(Role::Row, is_it).is_some(), "{}", stage.read_out());
}

#[test]
fn keys_fold_turns_and_go_into_and_out_of_them() {
    let mut stage = stage(sort(DeviceKind::Cpu), usize::MAX);
    // The last stage is the current one; stage 4 is passes 10 to 14.
    let (all, _) = rows(&stage);
    let (turn, end) = (at(&all, "10–14, stage 4"), stage.place());
    assert!(all[turn + 2].starts_with("11, step 1: exchange, "), "{all:?}");
    let last = stage.find(Role::Row, |row| row.starts_with("20, ")).expect("the current row").rect().center();
    stage.click_at(last);
    stage.settle();
    let current = |stage: &Stage| {
        let (rows, current) = rows(stage);
        rows[current.expect("a current row")].clone()
    };
    let press = |stage: &mut Stage, key| {
        stage.key(Modifiers::NONE, key);
        stage.settle();
    };
    // To the turn around it, which stays unfolded; to the pass before that.
    press(&mut stage, Key::ArrowLeft);
    assert!(current(&stage).starts_with("15–20, stage 5"), "{}", current(&stage));
    press(&mut stage, Key::ArrowLeft);
    assert_eq!((stage.place(), rows(&stage).0.len()), (end, all.len()));
    press(&mut stage, Key::ArrowUp);
    assert_eq!(stage.place(), 15);
    press(&mut stage, Key::ArrowDown);
    press(&mut stage, Key::ArrowLeft);
    assert!(current(&stage).starts_with("15–20, stage 5"), "a turn is no place: {}", current(&stage));
    assert_eq!(stage.place(), 15);
    assert_eq!(rows(&stage).0.len(), all.len() - 6, "it is not the current one any more");
    press(&mut stage, Key::ArrowRight);
    assert_eq!(rows(&stage).0.len(), all.len());
    press(&mut stage, Key::ArrowRight);
    assert!(current(&stage).starts_with("15, ") && stage.place() == 16, "{}", current(&stage));
    // A row of a turn is only chosen; a double click folds it.
    let center = |stage: &Stage| {
        stage.find(Role::Row, |row| row.starts_with("10–14, ")).expect("the turn before").rect().center()
    };
    let middle = center(&stage);
    stage.event(Event::PointerMoved(middle));
    // In one frame: frames of the harness are too long for a double click.
    for pressed in [true, false, true, false] {
        let button = egui::PointerButton::Primary;
        let event = Event::PointerButton { pos: middle, button, pressed, modifiers: Modifiers::NONE };
        stage.harness.input_mut().events.push(event);
    }
    stage.settle();
    assert_eq!((stage.place(), rows(&stage).0.len()), (16, all.len() - 5));
    assert!(current(&stage).starts_with("10–14, "));
}

#[test]
fn passes_without_turns_are_a_list() {
    // A build sorts by one pair of digits here: there is nothing to tell apart.
    let settings = cornell();
    let choices = Choices { program: ProgramName::GridBuild, ..settings.choices };
    let stage = stage(Settings { choices, ..settings }, usize::MAX);
    assert!(stage.harness.state().model().passes.iter().any(|pass| pass.loops == [0]));
    let (rows, _) = rows(&stage);
    assert_eq!(rows.len(), stage.place() + 1, "{rows:?}");
    assert!(stage.find(Role::Button, |name| name.starts_with("fold ")).is_none());
}
