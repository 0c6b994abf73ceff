//! The command palette.

use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher};

use super::command::{COMMANDS, Command};

/// The text entered, and the selected match.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Palette {
    text: String,
    chosen: usize,
}

/// Commands that match the text, the best first; an exact match precedes all others.
pub(super) fn matches(text: &str) -> Vec<Command> {
    let names = COMMANDS.iter().map(|info| info.name);
    let pattern = Pattern::parse(text, CaseMatching::Ignore, Normalization::Smart);
    let mut found = pattern.match_list(names, &mut Matcher::new(Config::DEFAULT));
    found.sort_by_key(|(name, _)| !name.eq_ignore_ascii_case(text.trim()));
    found.iter().filter_map(|(name, _)| COMMANDS.iter().find(|info| info.name == *name)).map(|i| i.command).collect()
}

impl Palette {
    /// Shows it; returns the chosen command, if any.
    pub(super) fn show(&mut self, ui: &mut egui::Ui) -> Option<Command> {
        ui.set_width(420.0);
        let field = egui::TextEdit::singleline(&mut self.text).hint_text("command").desired_width(f32::INFINITY);
        let response = ui.add(field);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "command"));
        response.request_focus();
        let found = matches(&self.text);
        let (up, down, enter) = ui.input_mut(|input| {
            let mut key = |key| input.consume_key(egui::Modifiers::NONE, key);
            (key(egui::Key::ArrowUp), key(egui::Key::ArrowDown), key(egui::Key::Enter))
        });
        self.chosen = (self.chosen + usize::from(down)).saturating_sub(usize::from(up));
        self.chosen = if response.changed() { 0 } else { self.chosen.min(found.len().saturating_sub(1)) };
        if enter {
            return found.get(self.chosen).copied();
        }
        let mut picked = None;
        egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            for (i, command) in found.iter().enumerate() {
                let button = egui::Button::new(command.name())
                    .shortcut_text(command.key_text(ui.ctx()))
                    .frame(i == self.chosen)
                    .min_size(egui::vec2(ui.available_width(), 0.0));
                let response = ui.add(button);
                if i == self.chosen && (up || down) {
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    picked = Some(*command);
                }
            }
        });
        if found.is_empty() {
            ui.weak("No matching command.");
        }
        picked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_letters_find_a_command() {
        assert_eq!(matches("next pass").first(), Some(&Command::NextPass));
        assert!(matches("nxtps").contains(&Command::NextPass));
        assert!(matches("zzzz").is_empty());
        for info in COMMANDS {
            assert_eq!(matches(info.name).first(), Some(&info.command), "{}", info.name);
        }
        assert_eq!(matches("").len(), COMMANDS.len());
    }
}
