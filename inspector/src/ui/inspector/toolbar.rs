//! The toolbar: an icon and a word for each command that is used all the time.

use egui::{Button, Color32, Painter, Pos2, Rect, Shape, Stroke, TextStyle, Ui, Vec2, vec2};

use super::Inspector;
use crate::command::Command;

/// The commands, and their words.
const BUTTONS: [(Command, &str); 8] = [
    (Command::Start, "Start"),
    (Command::PreviousPass, "Back"),
    (Command::NextPass, "Next pass"),
    (Command::End, "End"),
    (Command::Play, "Play"),
    (Command::PreviousEvent, "Previous event"),
    (Command::NextEvent, "Next event"),
    (Command::Export, "Export"),
];

/// Size of a button without a word.
const SIZE: Vec2 = vec2(28.0, 22.0);
/// Width of the progress of work, with its button.
const PROGRESS: f32 = 290.0;
/// Width of an icon.
const ICON: f32 = 14.0;

/// The width of all buttons with their words.
fn width(ui: &Ui) -> f32 {
    let font = TextStyle::Button.resolve(ui.style());
    let one = |word: &str| {
        let text = ui.painter().layout_no_wrap(word.to_owned(), font.clone(), Color32::PLACEHOLDER).size().x;
        text + ICON + 2.0 * ui.spacing().button_padding.x + 2.0 * ui.spacing().item_spacing.x
    };
    BUTTONS.iter().map(|(_, word)| one(word)).sum()
}

impl Inspector {
    pub(super) fn toolbar(&mut self, ui: &mut Ui) {
        // Words are dropped where they and the progress of work do not fit into one line.
        let has_words = self.saved.toolbar_words && width(ui) + PROGRESS <= ui.available_width();
        for (command, word) in BUTTONS {
            self.tool(ui, command, has_words.then_some(word));
        }
    }

    fn tool(&mut self, ui: &mut Ui, command: Command, word: Option<&str>) {
        let is_on = command == Command::Play && self.is_playing;
        let word = if is_on && word.is_some() { Some("Pause") } else { word };
        let why_not = self.why_not(command);
        let can = why_not.is_none();
        let response = ui.add_enabled_ui(can, |ui| {
            let icon = egui::Atom::paint(Vec2::splat(ICON), move |ui, icon| {
                sign(ui.painter(), icon.rect.center(), command, is_on, icon.fallback_text_color);
            });
            let button = match word {
                Some(word) => Button::new((icon, word)),
                None => Button::new(icon),
            };
            ui.add(button.selected(is_on).min_size(SIZE))
        });
        let response = response.inner;
        let (key, name) = (command.key_text(ui.ctx()), command.name());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, can, name));
        let text = if key.is_empty() { name.to_owned() } else { format!("{name} ({key})") };
        let refused = why_not.map_or_else(String::new, |why| format!("{text}: {why}"));
        if response.on_hover_text(text).on_disabled_hover_text(refused).clicked() {
            self.perform(command);
        }
    }
}

/// A button's icon, as on tape recorders; event buttons have a dot.
fn sign(painter: &Painter, middle: Pos2, command: Command, is_on: bool, color: Color32) {
    let triangle = |x: f32, width: f32| {
        let [base, tip] = [middle + vec2(x, 0.0), middle + vec2(x + width, 0.0)];
        let corners = vec![base + vec2(0.0, -5.0), base + vec2(0.0, 5.0), tip];
        painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
    };
    let bar = |x: f32| {
        painter.rect_filled(Rect::from_center_size(middle + vec2(x, 0.0), vec2(2.0, 10.0)), 0.0, color);
    };
    match command {
        Command::Start => {
            bar(-5.0);
            triangle(5.0, -8.0);
        }
        Command::PreviousPass => triangle(4.0, -8.0),
        Command::NextPass => triangle(-4.0, 8.0),
        Command::End => {
            triangle(-5.0, 8.0);
            bar(5.0);
        }
        Command::Play if is_on => {
            bar(-2.5);
            bar(2.5);
        }
        Command::Play => {
            triangle(-7.0, 7.0);
            triangle(0.0, 7.0);
        }
        Command::Export => {
            let corners = vec![middle + vec2(-4.0, 0.0), middle + vec2(4.0, 0.0), middle + vec2(0.0, 4.0)];
            painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
            painter.rect_filled(Rect::from_center_size(middle + vec2(0.0, -2.5), vec2(2.0, 5.0)), 0.0, color);
            painter.rect_filled(Rect::from_center_size(middle + vec2(0.0, 6.0), vec2(10.0, 1.5)), 0.0, color);
        }
        Command::PreviousEvent => {
            triangle(1.0, -7.0);
            painter.circle_filled(middle + vec2(5.0, 0.0), 2.0, color);
        }
        _ => {
            triangle(-1.0, 7.0);
            painter.circle_filled(middle + vec2(-5.0, 0.0), 2.0, color);
        }
    }
}
