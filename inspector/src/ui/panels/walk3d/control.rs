//! Mouse and keys of the 3D view.

use egui::{Event, Key, PointerButton};
use glam::{DVec2, DVec3};

use super::Wish;
use crate::command::{COMMANDS, Command};
use crate::orbit::Orbit;

/// Flying speed per second, in sizes of the scene.
const SPEED: f64 = 0.8;

/// Moves the camera; returns other requests.
pub(super) fn control(ui: &egui::Ui, response: &egui::Response, camera: &mut Orbit) -> Option<Wish> {
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    if response.has_focus() {
        // Arrow keys select a neighbouring pixel, not the next button.
        let filter = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    }
    let rect = response.rect;
    let size = DVec2::new(rect.width().into(), rect.height().into());
    let flown = if response.has_focus() { fly(ui, camera) } else { false };
    let drag = response.drag_delta();
    let drag = DVec2::new(drag.x.into(), drag.y.into());
    if drag != DVec2::ZERO {
        if response.dragged_by(PointerButton::Primary) {
            camera.orbit(drag, size);
        } else if flown {
            camera.look(drag, size);
        } else {
            camera.pan(drag, size);
        }
    }
    if let Some(at) = response.hover_pos() {
        let factor = ui.input(|input| (-input.smooth_scroll_delta().y / 300.0).exp() / input.zoom_delta());
        if factor != 1.0 {
            let at = at - rect.min;
            let under = camera.under(DVec2::new(at.x.into(), at.y.into()), size);
            camera.zoom(factor.into(), under);
        }
    }
    if response.double_clicked() {
        return Some(Wish::Reset);
    }
    let keys = response.has_focus().then(|| ui.input(|i| (i.key_pressed(Key::F), i.modifiers)));
    match keys {
        Some((true, modifiers)) if modifiers.shift => Some(Wish::FrameScene),
        Some((true, _)) => Some(Wish::FrameCell),
        _ => None,
    }
}

/// The commands whose keys were pressed while the view has the focus, except for keys that the view uses itself.
pub(super) fn commands(input: &egui::InputState) -> Vec<Command> {
    const OWN: [Key; 7] = [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E, Key::F];
    let command = |event: &Event| {
        let Event::Key { key, modifiers, pressed: true, .. } = event else { return None };
        if OWN.contains(key) && !modifiers.command {
            return None;
        }
        let keys = COMMANDS.iter().flat_map(|info| info.keys.iter().map(move |key| (info.command, key)));
        let fits = keys.filter(|(_, (wanted, of))| of == key && modifiers.matches_logically(*wanted));
        // Most modifiers first: otherwise Shift+F10 would match F10.
        fits.max_by_key(|(_, (wanted, _))| [wanted.shift, wanted.command].iter().filter(|&&on| on).count()).map(|c| c.0)
    };
    input.events.iter().filter_map(command).collect()
}

/// W, A, S and D as in games, Q down and E up. Returns whether one of them is held.
fn fly(ui: &egui::Ui, camera: &mut Orbit) -> bool {
    let (steps, seconds) = ui.input(|input| {
        let axis = |less: Key, more: Key| f64::from(input.key_down(more)) - f64::from(input.key_down(less));
        let steps = DVec3::new(axis(Key::A, Key::D), axis(Key::Q, Key::E), axis(Key::S, Key::W));
        let is_plain = !input.modifiers.command && !input.modifiers.alt;
        let speed = if input.modifiers.shift { 4.0 * SPEED } else { SPEED };
        (if is_plain { steps * speed } else { DVec3::ZERO }, f64::from(input.stable_dt.min(0.1)))
    });
    if steps == DVec3::ZERO {
        return false;
    }
    camera.fly(steps * seconds);
    ui.ctx().request_repaint();
    true
}

/// Looks along `direction` at a point, from `distance` in front of it.
pub(super) fn look_along(camera: &mut Orbit, at: DVec3, direction: DVec3, distance: f64) {
    let Some(forward) = direction.try_normalize() else { return };
    if !(distance > 0.0 && at.is_finite()) {
        return;
    }
    let level = forward.x.hypot(forward.z);
    let pose = &mut camera.pose;
    (pose.target, pose.distance, pose.roll) = (at, distance, 0.0);
    pose.pitch = forward.y.atan2(level);
    // Looking straight up or down, any turn is possible: the previous one stays.
    if level > 1e-9 {
        pose.yaw = (-forward.x).atan2(-forward.z);
    }
}

#[cfg(test)]
mod tests {
    use egui::{Modifiers, MouseWheelUnit, Pos2, RawInput, Rect, Sense, TouchPhase, pos2, vec2};

    use super::*;
    use crate::walk::Aabb;

    /// A view of 400 by 300 points, with simulated input.
    struct Stage {
        ctx: egui::Context,
        camera: Orbit,
        wish: Option<Wish>,
        commands: Vec<Command>,
    }

    impl Stage {
        fn new() -> Self {
            let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };
            let camera = Orbit::framing(&bounds, 4.0 / 3.0);
            let mut stage = Self { ctx: egui::Context::default(), camera, wish: None, commands: Vec::new() };
            stage.frame(vec![Event::PointerMoved(pos2(200.0, 150.0))]);
            stage
        }

        fn frame(&mut self, events: Vec<Event>) {
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(400.0, 300.0)));
            let mut output = self.ctx.clone().run_ui(RawInput { screen_rect, events, ..Default::default() }, |ui| {
                let rect = ui.max_rect();
                let response = ui.interact(rect, egui::Id::unique("view"), Sense::click_and_drag());
                self.wish = control(ui, &response, &mut self.camera).or(self.wish);
                self.commands.extend(if response.has_focus() { ui.input(commands) } else { Vec::new() });
            });
            output.textures_delta.clear();
        }

        fn button(button: PointerButton, pos: Pos2, pressed: bool) -> Event {
            Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE }
        }

        fn drag(&mut self, button: PointerButton) {
            self.frame(vec![Self::button(button, pos2(200.0, 150.0), true)]);
            self.frame(vec![Event::PointerMoved(pos2(240.0, 160.0))]);
            self.frame(vec![Event::PointerMoved(pos2(260.0, 170.0))]);
            self.frame(vec![Self::button(button, pos2(260.0, 170.0), false)]);
        }

        fn key(&mut self, key: Key, modifiers: Modifiers) {
            for pressed in [true, false] {
                let event = Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
                self.frame(vec![Event::ModifiersChanged(modifiers), event]);
            }
        }
    }

    #[test]
    fn drags_orbit_and_pan_and_the_wheel_zooms() {
        let mut stage = Stage::new();
        let before = stage.camera.pose;
        stage.drag(PointerButton::Primary);
        let orbited = stage.camera.pose;
        assert!(orbited.yaw != before.yaw && orbited.pitch != before.pitch && orbited.target == before.target);
        stage.drag(PointerButton::Secondary);
        let panned = stage.camera.pose;
        assert!(panned.yaw == orbited.yaw && panned.target != orbited.target);
        let delta = vec2(0.0, 60.0);
        let (unit, phase, modifiers) = (MouseWheelUnit::Point, TouchPhase::Move, Modifiers::NONE);
        let source = egui::MouseWheelSource::Unknown;
        stage.frame(vec![Event::MouseWheel { unit, delta, phase, source, modifiers }]);
        for _ in 0..20 {
            stage.frame(Vec::new());
        }
        assert!(stage.camera.pose.distance < panned.distance * 0.95, "{:?}", stage.camera.pose);
    }

    #[test]
    fn keys_are_for_the_view_once_it_was_clicked() {
        let mut stage = Stage::new();
        let before = stage.camera.pose;
        stage.key(Key::W, Modifiers::NONE);
        stage.key(Key::F, Modifiers::NONE);
        assert_eq!((stage.camera.pose, stage.wish), (before, None));
        for pressed in [true, false] {
            stage.frame(vec![Stage::button(PointerButton::Primary, pos2(200.0, 150.0), pressed)]);
        }
        stage.key(Key::W, Modifiers::NONE);
        assert!((stage.camera.pose.target - before.target).length() > 0.0);
        stage.key(Key::F, Modifiers::NONE);
        assert_eq!(stage.wish.take(), Some(Wish::FrameCell));
        stage.key(Key::F, Modifiers::SHIFT);
        assert_eq!(stage.wish, Some(Wish::FrameScene));
        assert_eq!(stage.commands, []);
        stage.key(Key::Space, Modifiers::NONE);
        stage.key(Key::ArrowLeft, Modifiers::NONE);
        stage.key(Key::ArrowLeft, Modifiers::COMMAND);
        assert_eq!(stage.commands, [Command::Play, Command::NudgeLeft, Command::PreviousPass]);
    }

    #[test]
    fn the_camera_looks_along_a_ray_of_any_direction() {
        let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };
        for direction in [DVec3::X, DVec3::NEG_Y, DVec3::new(1.0, -2.0, 0.5), DVec3::new(-3.0, 0.1, 7.0)] {
            let mut camera = Orbit::framing(&bounds, 1.0);
            let at = DVec3::new(0.2, 0.3, -0.4);
            look_along(&mut camera, at, direction, 2.0);
            let [_, _, forward] = camera.pose.axes();
            assert!(forward.dot(direction.normalize()) > 1.0 - 1e-12, "{direction}: {forward}");
            assert!((camera.pose.eye() - (at - direction.normalize() * 2.0)).length() < 1e-9, "{direction}");
            let before = camera;
            look_along(&mut camera, at, DVec3::ZERO, 2.0);
            look_along(&mut camera, at, direction, f64::NAN);
            assert_eq!(camera, before);
        }
    }
}
