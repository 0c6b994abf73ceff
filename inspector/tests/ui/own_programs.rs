//! A program of the user's: it is opened as scenes are, stepped, shown, and run again when one of its files is saved.

use egui::{Role, Theme};
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;
use raystep_inspector::ui::host::HostEvent;

use super::desk::{CORNELL, PROGRAM, life};
use super::stage::{Plan, Stage};

fn stage(theme: Theme) -> Stage {
    let mut stage = Stage::new(Plan { size: [1180.0, 760.0], theme, ..Plan::default() });
    stage.open(PROGRAM, Settings::default(), Arrival { place: Some(20), ..Arrival::default() });
    stage
}

/// Saves a file of the program in an editor.
fn save(stage: &mut Stage, file: &str, from: &str, to: &str) {
    let text = String::from_utf8(life().file(file).expect("a file").to_vec()).expect("a text");
    assert!(text.contains(from), "{from}");
    let (path, bytes) = (format!("{PROGRAM}/{file}"), text.replacen(from, to, 1).into_bytes());
    stage.desk.lock().expect("not poisoned").events.push(HostEvent::Read { path, bytes });
    stage.frame();
    stage.settle();
}

fn kernels(stage: &Stage) -> Vec<&'static str> {
    let model = stage.harness.state().model();
    model.passes.iter().map(|pass| pass.kernel.name()).collect()
}

fn is_shown(theme: Theme, name: &str) {
    let mut stage = stage(theme);
    assert_eq!(stage.place(), 20);
    let ran = kernels(&stage);
    assert_eq!((ran[0], ran[1], ran[19]), ("seed", "generation", "generation"));
    stage.perform(Command::Arrange(Layout::Step));
    stage.snapshot(name);
    // Back and forth again, and to the end.
    stage.perform(Command::PreviousPass);
    assert_eq!(stage.place(), 19);
    stage.perform(Command::NextPass);
    stage.perform(Command::End);
    assert_eq!(stage.place(), 201);
}

#[test]
fn every_pass_of_a_program_is_shown_on_dark() {
    is_shown(Theme::Dark, "own-program-dark");
}

#[test]
fn every_pass_of_a_program_is_shown_on_light() {
    is_shown(Theme::Light, "own-program-light");
}

#[test]
fn the_kernel_shows_what_the_selected_element_did_and_which_elements_stop() {
    let mut stage = Stage::new(Plan { size: [1180.0, 760.0], ..Plan::default() });
    let arrival = Arrival { pixel: Some([3, 5]), place: Some(20), ..Arrival::default() };
    stage.open(PROGRAM, Settings::default(), arrival);
    stage.perform(Command::Arrange(Layout::Step));
    if !stage.harness.state().panes_in_view().contains(&PaneKind::Kernel) {
        stage.perform(Command::Show(PaneKind::Kernel));
    }
    assert!(stage.find(Role::Button, |name| name == "Replace kernel…").is_none(), "{}", stage.read_out());
    // Its elements read each other: all threads are interpreted.
    assert!(stage.reads("Branch 1 of ") && stage.reads("any(id.xy >= size)"), "{}", stage.read_out());
    stage.fill("Stop at", "generation.wgsl:20");
    stage.fill("when", "lives");
    stage.click(Role::Button, "this pass");
    stage.settle();
    let alive = {
        let model = stage.harness.state().model();
        let opened = model.opened.as_ref().expect("a run");
        format!("of {} ", opened.plan.width * opened.plan.height)
    };
    assert!(stage.reads("pass 19, generation, ") && stage.reads(&alive), "{}", stage.read_out());
    assert!(stage.reads("lives holds for "), "{}", stage.read_out());
}

#[test]
fn a_program_follows_its_files_and_stays_if_one_is_wrong() {
    let mut stage = stage(Theme::Dark);
    stage.perform(Command::Show(PaneKind::Kernel));
    let generation = stage.harness.state().model().generation;
    save(&mut stage, "generation.wgsl", "neighbours == 3u", "neighbours == 3u || neighbours == 6u");
    assert_eq!((stage.harness.state().model().generation, stage.place()), (generation + 1, 20));

    save(&mut stage, "generation.wgsl", "let alive =", "let alive = oops +");
    assert_eq!((stage.harness.state().model().generation, stage.place()), (generation + 1, 20));
    let error = stage.harness.state().last_error().unwrap_or_default().to_owned();
    assert!(error.starts_with("work/life/generation.wgsl:17:"), "{error}");
    save(&mut stage, "program.toml", "repeat = 200", "repeat = \"many\"");
    let error = stage.harness.state().last_error().unwrap_or_default().to_owned();
    assert!(error.starts_with("work/life/program.toml:"), "{error}");

    save(&mut stage, "program.toml", "repeat = 200", "repeat = 25");
    assert_eq!((stage.harness.state().model().generation, stage.place()), (generation + 2, 20));
    stage.perform(Command::End);
    assert_eq!(stage.place(), 26);
    // A scene takes its place.
    stage.open(CORNELL, Settings { size: [16, 16], ..Settings::default() }, Arrival::default());
    let opened = stage.harness.state().model().opened.clone().expect("a run");
    assert_eq!((opened.plan.program.name, opened.settings.folder.is_none()), ("closest_hit", true));
}
