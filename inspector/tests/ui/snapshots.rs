//! Snapshots of every panel, and of the whole window, compared with those in the repository.
//!
//! `UPDATE_SNAPSHOTS=1` rewrites them: look at every one before committing it. Runs use the CPU and a clock that only
//! counts, so that snapshots contain neither durations nor the adapter's name.

use egui::Theme;
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::{Choices, Samples, ScheduleKind};

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};
use crate::ui::timeline::{into_turn, sort};

fn open(stage: &mut Stage) {
    let settings = Settings { size: [64, 64], device: DeviceKind::Cpu, ..Settings::default() };
    stage.open(CORNELL, settings, Arrival { pixel: Some([40, 44]), place: Some(35), ..Arrival::default() });
}

#[test]
fn every_panel_alone() {
    let mut stage = Stage::new(Plan { size: [600.0, 400.0], ..Plan::default() });
    open(&mut stage);
    stage.close_panels();
    for &kind in PaneKind::ALL {
        match kind {
            PaneKind::Compare => stage.perform(Command::Compare),
            PaneKind::Divergence => stage.perform(Command::Divergence),
            PaneKind::Error => stage.perform(Command::Judge),
            PaneKind::Choices => stage.perform(Command::Measure),
            kind => stage.perform(Command::Show(kind)),
        }
        assert_eq!(stage.harness.state().panes_in_view(), [kind]);
        stage.snapshot(&format!("panel-{}", format!("{kind:?}").to_lowercase()));
        stage.perform(Command::EndCompare);
        stage.perform(Command::Show(kind));
    }
}

#[test]
fn turns_of_loops() {
    let mut stage = Stage::new(Plan { size: [600.0, 400.0], ..Plan::default() });
    let samples = Samples { count: 4, ..Samples::default() };
    let choices = Choices { schedule: ScheduleKind::Second, samples, ..Choices::stepped() };
    let samples = Settings { size: [64, 64], device: DeviceKind::Cpu, choices, ..Settings::default() };
    for (settings, turns, kind, name) in [
        (sort(DeviceKind::Cpu), 3, PaneKind::Timeline, "loops-of-sort"),
        (sort(DeviceKind::Cpu), 3, PaneKind::Passes, "loops-in-passes"),
        (samples.clone(), 30, PaneKind::Timeline, "loops-of-samples"),
        (samples, 30, PaneKind::Passes, "samples-in-passes"),
    ] {
        stage.open(CORNELL, settings, Arrival { place: Some(usize::MAX), ..Arrival::default() });
        stage.close_panels();
        stage.perform(Command::Show(kind));
        into_turn(&mut stage, turns);
        stage.snapshot(name);
    }
}

#[test]
fn every_dialog() {
    let mut stage = Stage::new(Plan { size: [600.0, 400.0], ..Plan::default() });
    open(&mut stage);
    for (command, name) in [
        (Command::Palette, "palette"),
        (Command::Help, "keys"),
        (Command::GoToPixel, "pixel"),
        (Command::TypeRay, "ray"),
        (Command::PasteLink, "link"),
        (Command::EditTexel, "edit"),
        (Command::Export, "export"),
    ] {
        stage.perform(command);
        stage.snapshot(&format!("dialog-{name}"));
        stage.key(egui::Modifiers::NONE, egui::Key::Escape);
        stage.settle();
    }
}

#[test]
fn before_a_scene_is_open() {
    let mut stage = Stage::new(Plan { size: [600.0, 400.0], ..Plan::default() });
    stage.settle();
    stage.snapshot("welcome");
}

/// The layouts in the window of a laptop; at twice the size, only the first.
fn whole(theme: Theme, scale: f32, name: &str) {
    let mut stage = Stage::new(Plan { theme, scale, ..Plan::default() });
    open(&mut stage);
    let layouts = if scale > 1.0 { &Layout::ALL[..1] } else { &Layout::ALL[..] };
    for &layout in layouts {
        stage.arrange(layout);
        stage.snapshot(&format!("{}-{name}", layout.name().to_lowercase()));
    }
}

#[test]
fn whole_dark() {
    whole(Theme::Dark, 1.0, "dark");
}

#[test]
fn whole_light() {
    whole(Theme::Light, 1.0, "light");
}

#[test]
fn whole_dark_at_2x() {
    whole(Theme::Dark, 2.0, "dark-2x");
}

#[test]
fn whole_light_at_2x() {
    whole(Theme::Light, 2.0, "light-2x");
}
