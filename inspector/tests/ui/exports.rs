//! Exports: everything is exported unless less was chosen, and the outcome is always shown.

use egui::{Key, Modifiers, Role};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_inspector::ui::command::Command;

use crate::ui::desk::{CORNELL, Dialogs, NO_DIALOG, TRIANGLE};
use crate::ui::stage::{Plan, Stage};

const PLACE: usize = 12;

fn stage() -> Stage {
    let settings = Settings { size: [32, 32], device: DeviceKind::Cpu, ..Settings::default() };
    let mut stage = Stage::new(Plan { size: [600.0, 400.0], ..Plan::default() });
    stage.open(CORNELL, settings, Arrival { place: Some(PLACE), ..Arrival::default() });
    stage
}

fn dialogs(stage: &Stage, dialogs: Dialogs) {
    stage.desk.lock().expect("not poisoned").dialogs = dialogs;
}

/// Number of rows of each saved table.
fn rows(stage: &Stage) -> Vec<usize> {
    let desk = stage.desk.lock().expect("not poisoned");
    desk.saved.iter().map(|file| csv::Reader::from_reader(file.bytes.as_slice()).records().count()).collect()
}

#[track_caller]
fn says(stage: &Stage, text: &str) {
    assert!(stage.paints(text), "{text:?} is not among {:?}", stage.painted());
}

#[test]
fn passes_end_here_only_where_that_is_chosen() {
    let mut stage = stage();
    stage.perform(Command::Export);
    stage.frames(2);
    let choice = "only up to here: 12 passes; otherwise the run is completed first";
    stage.click(Role::CheckBox, choice);
    stage.frame();
    stage.click(Role::Button, Command::ExportPasses.name());
    stage.settle();
    says(&stage, "12 rows written to cornell-box.passes.csv");
    // The choice applies to one export only.
    stage.perform(Command::ExportPasses);
    stage.perform(Command::End);
    assert_eq!(rows(&stage), [PLACE, stage.place()]);
    assert!(stage.place() > PLACE + 20);
}

#[test]
fn what_is_cancelled_is_said() {
    let mut stage = stage();
    // Before the run has ended.
    stage.inspector().perform(Command::ExportPasses);
    stage.inspector().perform(Command::Cancel);
    stage.settle();
    says(&stage, "cancelled: nothing written");
    assert_eq!((stage.place(), rows(&stage).len()), (PLACE, 0));
    let mut stage = self::stage();
    dialogs(&stage, Dialogs::Cancel);
    stage.perform(Command::ExportPasses);
    says(&stage, "cancelled: nothing written");
    stage.perform(Command::OpenScene);
    says(&stage, "cancelled: no scene opened");
    assert_eq!(rows(&stage).len(), 0);
}

#[test]
fn where_there_are_no_dialogs_the_window_asks_for_a_path() {
    let mut stage = stage();
    dialogs(&stage, Dialogs::Missing);
    stage.perform(Command::End);
    let all = stage.place();
    stage.perform(Command::ExportPasses);
    says(&stage, NO_DIALOG);
    stage.snapshot("dialog-path");
    stage.key(Modifiers::NONE, Key::Enter);
    stage.settle();
    says(&stage, &format!("{all} rows written to /here/cornell-box.passes.csv"));
    // The same name again: asks before replacing the file.
    stage.perform(Command::ExportPasses);
    stage.key(Modifiers::NONE, Key::Enter);
    stage.settle();
    says(&stage, "it is there already");
    assert_eq!(rows(&stage), [all]);
    stage.click(Role::CheckBox, "replace an existing file");
    stage.frame();
    stage.click(Role::Button, "Save");
    stage.settle();
    assert_eq!(rows(&stage), [all, all]);
    // If the dialog is cancelled, nothing is written.
    stage.perform(Command::ExportPasses);
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    says(&stage, "cancelled: nothing written");
    assert_eq!(rows(&stage), [all, all]);
    // Open a scene by its path.
    let generation = stage.inspector().model().generation;
    stage.perform(Command::OpenScene);
    stage.key(Modifiers::COMMAND, Key::A);
    stage.answer(CORNELL);
    assert_eq!(stage.inspector().model().generation, generation + 1);
    stage.perform(Command::OpenScene);
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    says(&stage, "cancelled: no scene opened");
}

#[test]
fn auto_is_the_twins_where_the_adapter_is_software() {
    let plan = Plan::default();
    let wanted = if plan.gpu.is_software() { DeviceKind::Cpu } else { DeviceKind::Gpu };
    let mut stage = Stage::new(plan);
    let device = |stage: &mut Stage| stage.inspector().model().opened.as_ref().map(|o| o.settings.device);
    stage.perform(Command::PasteLink);
    stage.answer(&format!("raystep:1?scene={CORNELL}&size=32x32&pixel=3,4&pass=7"));
    assert_eq!(device(&mut stage), Some(wanted), "by a link");
    stage.perform(Command::PasteLink);
    stage.answer(&format!("raystep:1?scene={CORNELL}&size=32x32&device=gpu&pixel=3,4&pass=7"));
    assert_eq!(device(&mut stage), Some(DeviceKind::Gpu), "by a link that says it");
    let mut stage = Stage::new(Plan::default());
    stage.desk.lock().expect("not poisoned").choice = Some(TRIANGLE.into());
    stage.perform(Command::OpenScene);
    assert_eq!(device(&mut stage), Some(wanted), "by a dialog");
}
