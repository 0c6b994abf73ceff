//! Turns the page's events into egui's.

use egui::{Event, Key, Modifiers, Pos2, Rect, TouchPhase, Vec2, pos2, vec2};

/// Bits of the modifiers, as `page.js` sends them.
const ALT: u32 = 1;
const CTRL: u32 = 2;
const SHIFT: u32 = 4;
const META: u32 = 8;
/// Set on Apple's systems, where the command key is Meta.
const IS_MAC: u32 = 16;

/// Collects events between frames.
pub(crate) struct Input {
    /// Size in CSS pixels, and device pixels per CSS pixel.
    size: Vec2,
    scale: f32,
    events: Vec<Event>,
    modifiers: Modifiers,
    focused: bool,
    is_dark: bool,
}

fn modifiers(bits: u32) -> Modifiers {
    let has = |bit| bits & bit != 0;
    let is_mac = has(IS_MAC);
    Modifiers {
        alt: has(ALT),
        ctrl: has(CTRL),
        shift: has(SHIFT),
        mac_cmd: is_mac && has(META),
        command: if is_mac { has(META) } else { has(CTRL) },
    }
}

impl Input {
    pub(crate) fn new(width: f32, height: f32, scale: f32, is_dark: bool) -> Self {
        let modifiers = Modifiers::NONE;
        Self { size: vec2(width, height), scale, events: Vec::new(), modifiers, focused: true, is_dark }
    }

    pub(crate) fn resize(&mut self, width: f32, height: f32, scale: f32) {
        (self.size, self.scale) = (vec2(width, height), scale);
    }

    /// The canvas in device pixels.
    pub(crate) fn pixels(&self) -> [u32; 2] {
        [self.size.x, self.size.y].map(|side| (side * self.scale).round().max(1.0) as u32)
    }

    /// The input of a frame.
    pub(crate) fn take(&mut self, time_s: f64, zoom: f32, most_side: u32) -> egui::RawInput {
        let mut raw = egui::RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.size / zoom)),
            time: Some(time_s),
            events: std::mem::take(&mut self.events),
            focused: self.focused,
            max_texture_side: Some(most_side as usize),
            system_theme: Some(if self.is_dark { egui::Theme::Dark } else { egui::Theme::Light }),
            ..Default::default()
        };
        raw.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(self.scale);
        raw
    }

    pub(crate) fn pointer_moved(&mut self, at: Pos2) {
        // Only the last place counts until something is pressed.
        if let Some(Event::PointerMoved(last)) = self.events.last_mut() {
            *last = at;
        } else {
            self.events.push(Event::PointerMoved(at));
        }
    }

    pub(crate) fn pointer_button(&mut self, at: Pos2, button: u32, pressed: bool, bits: u32) {
        use egui::PointerButton as B;
        let Some(button) = [B::Primary, B::Middle, B::Secondary, B::Extra1, B::Extra2].get(button as usize) else {
            return;
        };
        self.modified(bits);
        self.pointer_moved(at);
        let modifiers = self.modifiers;
        self.events.push(Event::PointerButton { pos: at, button: *button, pressed, modifiers });
    }

    pub(crate) fn pointer_gone(&mut self) {
        self.events.push(Event::PointerGone);
    }

    pub(crate) fn touch(&mut self, id: u32, phase: u32, at: Pos2, force: f32) {
        let phase = match phase {
            0 => TouchPhase::Start,
            1 => TouchPhase::Move,
            2 => TouchPhase::End,
            _ => TouchPhase::Cancel,
        };
        let (device_id, id) = (egui::TouchDeviceId(0), egui::TouchId::from(u64::from(id)));
        self.events.push(Event::Touch { device_id, id, phase, pos: at, force: Some(force) });
    }

    /// `unit` is that of a `WheelEvent`.
    pub(crate) fn wheel(&mut self, delta: Vec2, unit: u32, bits: u32) {
        self.modified(bits);
        let unit = match unit {
            1 => egui::MouseWheelUnit::Line,
            2 => egui::MouseWheelUnit::Page,
            _ => egui::MouseWheelUnit::Point,
        };
        let (phase, modifiers) = (TouchPhase::Move, self.modifiers);
        let source = egui::MouseWheelSource::Unknown;
        self.events.push(Event::MouseWheel { unit, delta: -delta, phase, source, modifiers });
    }

    /// A key by its name and its place on the keyboard, as a `KeyboardEvent` has them.
    pub(crate) fn key(&mut self, name: &str, code: &str, pressed: bool, repeat: bool, bits: u32) {
        self.modified(bits);
        let modifiers = self.modifiers;
        if let Some(key) = Key::from_name(name) {
            let physical_key = Key::from_name(code);
            self.events.push(Event::Key { key, physical_key, pressed, repeat, modifiers });
        }
        // With these, a key is a command and not a text.
        let is_command = modifiers.ctrl || modifiers.command || modifiers.mac_cmd;
        let is_letter = name.chars().count() == 1;
        if pressed && is_letter && !is_command {
            self.text(name);
        }
    }

    pub(crate) fn modified(&mut self, bits: u32) {
        self.modifiers = modifiers(bits);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.events.push(Event::Text(text.into()));
    }

    pub(crate) fn composing(&mut self, text: &str) {
        self.events.push(Event::Ime(egui::ImeEvent::Preedit { text: text.into(), active_range_chars: None }));
    }

    pub(crate) fn composed(&mut self, text: &str) {
        self.events.push(Event::Ime(egui::ImeEvent::Commit(text.into())));
    }

    pub(crate) fn push(&mut self, event: Event) {
        self.events.push(event);
    }

    pub(crate) fn focus(&mut self, focused: bool) {
        self.focused = focused;
        self.events.push(Event::WindowFocused(focused));
    }

    /// A place in CSS pixels, in points.
    pub(crate) fn point(x: f32, y: f32, zoom: f32) -> Pos2 {
        pos2(x / zoom, y / zoom)
    }
}
