//! The paths of the whole image, bounce by bounce, and its brightest pixels.

use egui::accesskit::Toggled;
use egui::{Role, Theme};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::options::{Integrator, Strategy};
use raystep_kernels::{Accelerator, Choices, Samples, ScheduleKind};

use crate::ui::desk::{GLARE, GLOW};
use crate::ui::stage::{Plan, Stage};

fn settings(integrator: Integrator, schedule: ScheduleKind, count: u32) -> Settings {
    let samples = Samples { count, ..Samples::default() };
    let steps_per_pass = if schedule == ScheduleKind::Compact { 8 } else { 1 };
    let accelerator = Accelerator::Grid;
    let choices = Choices { integrator, accelerator, schedule, steps_per_pass, samples, ..Choices::stepped() };
    Settings { size: [32, 32], device: DeviceKind::Cpu, choices, ..Settings::default() }
}

/// The panel alone, in a window of this size.
fn stage(size: [f32; 2], theme: Theme, settings: Settings, place: usize) -> Stage {
    let mut stage = Stage::new(Plan { size, theme, ..Plan::default() });
    stage.open(GLOW, settings, Arrival { pixel: Some([3, 4]), place: Some(place), ..Arrival::default() });
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::Bounces));
    stage
}

fn count(stage: &mut Stage, name: &str) {
    stage.click(Role::Button, name);
    stage.settle();
}

/// The rows of the table in view, and the highlighted one.
fn rows(stage: &Stage) -> (Vec<String>, Option<String>) {
    let nodes = stage.nodes().into_iter().filter(|node| node.accesskit_node().role() == Role::Row);
    let named = |node: &egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        Some((node.label()?, node.toggled() == Some(Toggled::True)))
    };
    let rows: Vec<_> = nodes.filter_map(|node| named(&node)).collect();
    let current = rows.iter().find(|(_, is_current)| *is_current).map(|(name, _)| name.clone());
    (rows.into_iter().map(|(name, _)| name).collect(), current)
}

fn seen(theme: Theme, name: &str) {
    let mut stage = stage([900.0, 300.0], theme, settings(Integrator::Path, ScheduleKind::Compact, 1), 40);
    count(&mut stage, "Count paths");
    stage.snapshot(&format!("bounces-{name}"));
    stage.click(Role::Button, "Brightest pixels");
    stage.settle();
    stage.snapshot(&format!("bounces-brightest-{name}"));
}

#[test]
fn bounces_are_seen_on_dark() {
    seen(Theme::Dark, "dark");
}

#[test]
fn bounces_are_seen_on_light() {
    seen(Theme::Light, "light");
}

#[test]
fn a_narrow_panel_has_the_reasons_below() {
    let settings = settings(Integrator::Path, ScheduleKind::Compact, 1);
    let mut stage = stage([420.0, 400.0], Theme::Dark, settings, 40);
    count(&mut stage, "Count paths");
    stage.snapshot("bounces-narrow");
}

#[test]
fn a_click_goes_to_the_first_pass_of_a_bounce_forward_and_back() {
    for schedule in [ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused] {
        let mut stage = stage([900.0, 400.0], Theme::Dark, settings(Integrator::Path, schedule, 2), usize::MAX);
        count(&mut stage, "Count paths of sample 2");
        assert!(stage.reads("sample 2 of 2"), "{}", stage.read_out());
        let (named, current) = rows(&stage);
        assert!(named.len() > 4 && named[0].starts_with("0") && named[0].contains("1024"), "{named:?}");
        assert_eq!(current.as_ref(), named.last());
        let end = stage.place();
        let mut places = Vec::new();
        for row in [1, 0, 2] {
            stage.click(Role::Row, &named[row]);
            stage.settle();
            assert_eq!(rows(&stage).1.as_ref(), Some(&named[row]), "{schedule}");
            places.push(stage.place());
            // It is the bounce's first pass: the one before is of another bounce.
            stage.perform(Command::PreviousPass);
            let before = rows(&stage).1;
            assert_eq!(before.as_ref(), row.checked_sub(1).and_then(|row| named.get(row)), "{schedule}");
        }
        assert!(places[1] < places[0] && places[0] < places[2] && places[2] < end, "{schedule}: {places:?}");
        // In the other sample, these are not what the run is at.
        stage.perform(Command::Start);
        assert_eq!(rows(&stage).1, None);
        count(&mut stage, "Count paths of sample 1");
        assert!(stage.reads("sample 1 of 2"), "{}", stage.read_out());
    }
}

#[test]
fn a_run_without_paths_offers_them() {
    let settings = settings(Integrator::Whitted, ScheduleKind::Compact, 1);
    let mut stage = stage([700.0, 300.0], Theme::Dark, settings, usize::MAX);
    assert!(stage.paints("with --integrator path"), "{:?}", stage.painted());
    count(&mut stage, "Trace paths");
    count(&mut stage, "Count paths");
    assert!(!rows(&stage).0.is_empty());
    // Another run has other paths.
    stage.perform(Command::Start);
    let opened = stage.harness.state().model().opened.clone().expect("a run");
    assert_eq!(opened.settings.choices.integrator, Integrator::Path);
}

#[test]
fn a_bright_pixel_is_shown_with_the_vertex_in_its_light_tree() {
    // From the start, where no pass of the path is known, and from the end.
    for place in [0, usize::MAX] {
        // All pixels are in view.
        let settings = Settings { size: [8, 8], ..settings(Integrator::Path, ScheduleKind::Compact, 1) };
        let mut stage = stage([900.0, 1500.0], Theme::Dark, settings, place);
        count(&mut stage, "Count paths");
        stage.click(Role::Button, "Brightest pixels");
        stage.settle();
        let (named, _) = rows(&stage);
        let weight =
            |row: &String| row.rsplit(", ").next().filter(|weight| weight.starts_with("0.")).map(str::to_owned);
        let is_weighted = |row: &&String| row.contains("light sample") && weight(row).is_some();
        let row = named.iter().find(is_weighted).expect("a light sample with a weight below 1").clone();
        stage.click(Role::Row, &row);
        stage.settle();
        let pixel = stage.harness.state().pixel().expect("a pixel");
        assert!(row.contains(&format!("{},{}", pixel[0], pixel[1])), "{row}: {pixel:?}");
        assert!(stage.harness.state().panes_in_view().contains(&PaneKind::LightTree));
        let (_, current) = rows(&stage);
        let current = current.expect("a vertex");
        assert!(current.contains("visible"), "{current}");
        // The weight that the list told.
        assert_eq!(weight(&current), weight(&row), "{current}: {row}");
    }
}

#[test]
fn a_value_that_overflows_is_found_with_its_pass_pixel_and_line() {
    let settings = settings(Integrator::Path, ScheduleKind::Compact, 1);
    let mut stage = stage([900.0, 400.0], Theme::Dark, settings.clone(), 40);
    stage.click(Role::Button, "NaN or Inf");
    stage.settle();
    count(&mut stage, "Look for NaN and Inf");
    assert!(stage.paints("NaN or Inf: none in 1024 pixels"), "{:?}", stage.painted());
    // Walls that emit more than half of what a float holds.
    let choices = Choices { strategy: Strategy::Bsdf, ..settings.choices };
    let settings = Settings { choices, ..settings };
    stage.open(GLARE, settings, Arrival { pixel: Some([3, 4]), place: Some(0), ..Arrival::default() });
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::Bounces));
    stage.click(Role::Button, "NaN or Inf");
    stage.settle();
    count(&mut stage, "Look for NaN and Inf");
    assert!(stage.paints("NaN or Inf: first in pass "), "{:?}", stage.painted());
    assert!(stage.paints("sample_light") && stage.paints("radiance.r becomes inf"), "{:?}", stage.painted());
    stage.snapshot("bounces-inf");
    stage.click(Role::Button, "Go there");
    stage.settle();
    assert!(stage.harness.state().panes_in_view().contains(&PaneKind::Kernel));
    let [x, y] = stage.harness.state().pixel().expect("a pixel");
    let told = stage.painted().into_iter().find(|text| text.starts_with("NaN or Inf: first"));
    let place = stage.place();
    let row = stage.harness.state().model().history.as_ref().expect("a history").rows.iter();
    let radiance = row.clone().find(|row| row.place() == Some(place)).and_then(|row| row.after.bounce);
    assert_eq!(radiance.expect("a bounce").radiance[0], f32::INFINITY, "{x},{y}: {told:?}");
    let earlier =
        row.filter(|row| row.place().is_some_and(|earlier| earlier < place)).filter_map(|row| row.after.bounce);
    assert!(earlier.clone().count() > 2 && earlier.into_iter().all(|bounce| bounce.radiance[0].is_finite()));
}
