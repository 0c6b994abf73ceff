//! What moves under the cursor: the ray that it points at, and the picture while a camera turns.

use std::sync::Arc;

use egui::{Event, Key, Modifiers, PointerButton, Role, pos2, vec2};
use raystep_inspector::command::Layout;
use raystep_inspector::settings::{DeviceKind, Settings, View};
use raystep_inspector::ui::{Arrival, Inspector};
use raystep_kernels::programs::closest_hit::streams;
use raystep_scenes::generate::cornell_box;

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

fn settings(device: DeviceKind) -> Settings {
    Settings { size: [64, 64], device, ..Settings::default() }
}

fn open(device: DeviceKind) -> Stage {
    Stage::with_scene(CORNELL, settings(device), Arrival::picture())
}

/// A button of the mouse, pressed or released at a point.
fn press(stage: &mut Stage, pos: egui::Pos2, pressed: bool) {
    let button = PointerButton::Primary;
    stage.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
}

#[test]
fn the_ray_under_the_cursor_is_told_without_a_click() {
    let mut stage = open(DeviceKind::Gpu);
    let selected = stage.inspector().pixel();
    let picture = stage.find(Role::Image, |name| name.starts_with("color after")).expect("the stream").rect();
    stage.event(Event::PointerMoved(picture.center() + vec2(60.0, 90.0)));
    let glanced = stage.inspector().model().glanced().expect("a ray").clone();
    assert_ne!(Some(glanced.pixel), selected);
    let [x, y] = glanced.pixel;
    let last = glanced.rows.last().expect("a row").after;
    let hit = last.triangle.expect("the box is closed");
    assert!(stage.paints(&format!("pixel {x},{y}: hits triangle {hit} at t ")), "{:?}", stage.painted());
    // Clicking it tells the same history.
    stage.click_at(picture.center() + vec2(60.0, 90.0));
    stage.settle();
    let history = stage.inspector().model().history.clone().expect("a history");
    assert_eq!(format!("{:?}", history.rows), format!("{:?}", glanced.rows));
    assert!(stage.inspector().model().glanced().is_none(), "the cursor has left");
}

/// The bits of the picture.
fn picture(inspector: &Inspector) -> Vec<u32> {
    let texels = &inspector.model().texels;
    texels.iter().find(|t| t.stream == streams::COLOR).expect("the picture was read").bits.clone()
}

#[test]
fn another_camera_changes_the_picture_and_nothing_is_built_again() {
    for device in [DeviceKind::Cpu, DeviceKind::Gpu] {
        let mut stage = open(device);
        let plan = stage.inspector().model().opened.as_ref().expect("a run").plan.clone();
        let before = picture(stage.inspector());
        let scene = cornell_box();
        let mut camera = View::Scene(0).camera(&scene);
        camera.eye += camera.right * 0.05;
        let view = View::of(&camera, &scene);

        // As if it had been opened with this camera.
        let mut fresh = Stage::with_scene(CORNELL, Settings { view, ..settings(device) }, Arrival::picture());
        let generation = stage.inspector().model().generation;
        stage.inspector().plan(Settings { view, ..settings(device) });
        stage.until("the picture from there", |stage| stage.harness.state().model().generation > generation);
        // It was never at the start: the window went from one picture to the next.
        let model = stage.inspector().model();
        assert!(model.is_complete && model.next.is_none() && model.place > 0);
        let opened = model.opened.as_ref().expect("a run");
        assert!(Arc::ptr_eq(&plan, &opened.plan), "{device:?}: it was planned again");
        assert_eq!(opened.settings.view, view);
        stage.settle();
        assert_ne!(picture(stage.inspector()), before);
        assert!(picture(stage.inspector()) == picture(fresh.inspector()), "{device:?}");
    }
}

#[test]
fn while_the_camera_turns_there_is_a_coarse_picture_and_then_the_true_one() {
    let mut stage = open(DeviceKind::Cpu);
    stage.arrange(Layout::Ray);
    // In a narrow panel it is in a menu.
    if stage.find(Role::Button, |name| name == "Camera").is_some() {
        stage.click(Role::Button, "Camera");
        stage.frames(2);
    }
    stage.click(Role::CheckBox, "trace as the camera moves");
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    let view = stage.find(Role::Image, |name| name.contains("cell ")).expect("the walk in 3D").rect();
    let at = view.center();
    stage.event(Event::PointerMoved(at));
    press(&mut stage, at, true);
    let mut turned = 0.0;
    // The glimpse comes while the button is held.
    while stage.inspector().model().glimpse.is_none() {
        turned += 1.0;
        assert!(turned < 1000.0, "no glimpse");
        stage.event(Event::PointerMoved(pos2(at.x + turned % 40.0, at.y)));
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let model = stage.inspector().model();
    let glimpse = model.glimpse.as_ref().expect("a glimpse");
    assert_eq!(glimpse.stream, streams::COLOR);
    assert!(glimpse.texture.width() < 64, "{}", glimpse.texture.width());
    assert!(model.is_complete && model.history.is_some(), "the run before stays");
    let generation = model.generation;
    press(&mut stage, at, false);
    stage.event(Event::PointerGone);
    stage.until("the true picture", |stage| stage.harness.state().model().generation > generation);
    stage.settle();
    let model = stage.inspector().model();
    assert!(model.glimpse.is_none() && model.next.is_none());
}
