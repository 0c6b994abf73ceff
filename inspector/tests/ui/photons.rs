//! Photons in 3D, the search of a pixel for them, and a photon that is followed as a ray is.

use egui::{Role, Theme};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::history::Trace;
use raystep_kernels::options::{Integrator, Photons};
use raystep_kernels::{Accelerator, Choices};

use crate::ui::desk::{CORNELL, WHITTED};
use crate::ui::stage::{Plan, Stage};

/// Of the floor, beside a box.
const PIXEL: [u32; 2] = [12, 28];

fn settings(integrator: Integrator) -> Settings {
    let photons = Photons { count: 2000, radius: 60, nearest: 20, ..Photons::default() };
    let choices = Choices { integrator, photons, accelerator: Accelerator::Bvh, ..Choices::stepped() };
    Settings { size: [32, 32], device: DeviceKind::Cpu, choices, ..Settings::default() }
}

/// One panel in a window of this size, at the end of a run.
fn stage(scene: &str, size: [f32; 2], theme: Theme, kind: PaneKind) -> Stage {
    let mut stage = Stage::new(Plan { size, theme, ..Plan::default() });
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(usize::MAX), ..Arrival::default() };
    stage.open(scene, settings(Integrator::Photons), arrival);
    stage.close_panels();
    stage.perform(Command::Show(kind));
    stage
}

fn history(stage: &Stage) -> Trace {
    Trace::clone(stage.harness.state().model().history.as_ref().expect("a history"))
}

/// What the 3D view says that it draws.
fn said(stage: &Stage) -> String {
    let view = stage.find(Role::Image, |name| name.contains(" visited")).expect("the 3D view");
    view.accesskit_node().label().expect("a name")
}

/// Opens the menu of what the view shows, performs this, and closes it.
fn in_menu(stage: &mut Stage, role: Role, name: &str) {
    stage.click(Role::Button, "Show");
    stage.frames(2);
    stage.click(role, name);
    stage.key(egui::Modifiers::NONE, egui::Key::Escape);
    stage.settle();
}

fn seen(theme: Theme, name: &str) {
    let mut stage = stage(CORNELL, [900.0, 500.0], theme, PaneKind::Walk3d);
    stage.snapshot(&format!("photons-{name}"));
    in_menu(&mut stage, Role::Button, "bounce");
    stage.snapshot(&format!("photons-bounce-{name}"));
    in_menu(&mut stage, Role::Button, "Follow photon");
    stage.snapshot(&format!("photons-way-{name}"));
}

#[test]
fn photons_are_seen_on_dark() {
    seen(Theme::Dark, "dark");
}

#[test]
fn photons_are_seen_on_light() {
    seen(Theme::Light, "light");
}

#[test]
fn caustic_photons_are_told_from_others() {
    let mut stage = stage(WHITTED, [900.0, 500.0], Theme::Dark, PaneKind::Walk3d);
    assert!(said(&stage).contains(" of them caustic"), "{}", said(&stage));
    in_menu(&mut stage, Role::Button, "map");
    stage.snapshot("photons-map");
}

#[test]
fn the_3d_view_says_what_is_stored_and_what_the_pixel_has_taken() {
    let mut stage = stage(CORNELL, [900.0, 500.0], Theme::Dark, PaneKind::Walk3d);
    let history = history(&stage);
    let gather = history.rows.iter().rev().find_map(|row| row.after.gather).expect("a search");
    let told = format!("the pixel's search found {} photon", gather.found);
    assert!(said(&stage).contains(&told) && said(&stage).contains(" stored photons"), "{}", said(&stage));
    assert!(stage.paints(&told), "{:?}", stage.painted());
    in_menu(&mut stage, Role::CheckBox, "the pixel's photons");
    assert!(!said(&stage).contains(&told) && said(&stage).contains(" stored photons"), "{}", said(&stage));
    in_menu(&mut stage, Role::CheckBox, "stored photons");
    assert!(!said(&stage).contains(" stored photons"), "{}", said(&stage));
    in_menu(&mut stage, Role::CheckBox, "stored photons");
    // In the first cell, the search is not over; before it, there is none; and before photons are traced, none are stored.
    let first = history.rows.iter().position(|row| row.kernel == "gather").expect("a search");
    in_menu(&mut stage, Role::CheckBox, "the pixel's photons");
    let mut at = |row: usize| {
        let place = history.rows[row].place();
        let arrival = Arrival { pixel: Some(PIXEL), place, ..Arrival::default() };
        stage.open(CORNELL, settings(Integrator::Photons), arrival);
        said(&stage)
    };
    assert!(at(first).contains("the pixel's search has found ") && at(first).contains(" in 1 cell"), "{}", at(first));
    assert!(!at(0).contains("the pixel's search"), "{}", at(0));
    stage.perform(Command::Start);
    assert!(!stage.reads(" stored photons"), "{}", stage.read_out());
}

#[test]
fn the_history_of_a_pixel_tells_its_search_and_that_of_a_photon_its_way() {
    let mut stage = stage(CORNELL, [1000.0, 600.0], Theme::Dark, PaneKind::Ray);
    let of_pixel = history(&stage);
    assert_eq!((of_pixel.element, of_pixel.pixel), (None, PIXEL));
    assert!(of_pixel.rows.iter().any(|row| row.kernel == "gather" && row.why.starts_with("cell (")), "{of_pixel:?}");
    assert!(stage.paints("pixel 12,28") && !stage.paints("Back to pixel"), "{:?}", stage.painted());

    stage.perform(Command::Show(PaneKind::Walk3d));
    in_menu(&mut stage, Role::Button, "Follow photon");
    let of_photon = history(&stage);
    assert_eq!(of_photon.name(), "photon 0");
    assert_eq!((of_photon.rows[0].kernel, of_photon.passes), ("emit_photons", of_pixel.passes));
    stage.perform(Command::Show(PaneKind::Ray));
    assert!(stage.paints("photon 0") && stage.paints("Back to pixel 12,28"), "{:?}", stage.painted());
    stage.perform(Command::Show(PaneKind::Walk3d));
    assert!(said(&stage).contains("the photon's way has "), "{}", said(&stage));
    // Its rows are steps, and its walk is drawn.
    stage.perform(Command::Start);
    stage.perform(Command::NextEvent);
    let row = of_photon.rows.iter().find(|row| row.kernel != "emit_photons" && row.kernel != "photon_setup");
    assert!(row.and_then(|row| row.place()).is_some_and(|place| stage.place() <= place), "{}", stage.place());
    stage.perform(Command::Show(PaneKind::Ray));
    stage.click(Role::Button, "Back to pixel 12,28");
    stage.settle();
    assert_eq!(history(&stage).element, None);
    stage.perform(Command::Show(PaneKind::Walk3d));
    // Without photons, the pixel is what is followed.
    in_menu(&mut stage, Role::Button, "Follow photon");
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(usize::MAX), ..Arrival::default() };
    stage.open(CORNELL, settings(Integrator::Shadows), arrival);
    assert_eq!(history(&stage).element, None);
    assert!(stage.find(Role::Image, |name| name.contains(" stored photons")).is_none(), "{}", stage.read_out());
    stage.click(Role::Button, "Show");
    stage.frames(2);
    assert!(stage.find(Role::CheckBox, |name| name == "stored photons").is_none(), "{}", stage.read_out());
}
