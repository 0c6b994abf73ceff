//! The command palette.

use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher};

use crate::command::{COMMANDS, Command};

/// Height of the list.
const LIST: f32 = 320.0;

/// The text entered, and the selected match.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Palette {
    text: String,
    chosen: usize,
}

/// Commands that match the text: an exact match, then those that can be performed, the best first, then the others.
pub(super) fn matches(text: &str, can: &dyn Fn(Command) -> bool) -> Vec<Command> {
    let names = COMMANDS.iter().map(|info| info.name);
    let pattern = Pattern::parse(text, CaseMatching::Ignore, Normalization::Smart);
    let mut found = pattern.match_list(names, &mut Matcher::new(Config::DEFAULT));
    found.sort_by_key(|(name, _)| !name.eq_ignore_ascii_case(text.trim()));
    let exact = usize::from(found.first().is_some_and(|(name, _)| name.eq_ignore_ascii_case(text.trim())));
    let known = |name: &str| COMMANDS.iter().find(|info| info.name == name).map(|info| info.command);
    let mut found: Vec<Command> = found.iter().filter_map(|(name, _)| known(name)).collect();
    if let Some(rest) = found.get_mut(exact..) {
        rest.sort_by_key(|command| !can(*command));
    }
    found
}

impl Palette {
    /// Shows it; returns the chosen command, if any.
    pub(super) fn show(
        &mut self,
        ui: &mut egui::Ui,
        why_not: &dyn Fn(Command) -> Option<&'static str>,
    ) -> Option<Command> {
        let can = |command| why_not(command).is_none();
        ui.set_width(420.0);
        let field = egui::TextEdit::singleline(&mut self.text).hint_text("command").desired_width(f32::INFINITY);
        let response = ui.add(field);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "command"));
        response.request_focus();
        let found = matches(&self.text, &can);
        let (up, down, enter) = ui.input_mut(|input| {
            let mut key = |key| input.consume_key(egui::Modifiers::NONE, key);
            (key(egui::Key::ArrowUp), key(egui::Key::ArrowDown), key(egui::Key::Enter))
        });
        self.chosen = (self.chosen + usize::from(down)).saturating_sub(usize::from(up));
        self.chosen = if response.changed() { 0 } else { self.chosen.min(found.len().saturating_sub(1)) };
        if enter {
            return found.get(self.chosen).copied().filter(|command| can(*command));
        }
        let mut picked = None;
        // As high whatever was found: it does not move under the eyes of who types.
        ui.set_min_height(LIST);
        egui::ScrollArea::vertical().max_height(LIST).auto_shrink(false).show(ui, |ui| {
            for (i, command) in found.iter().enumerate() {
                let button = egui::Button::new(command.name())
                    .shortcut_text(command.key_text(ui.ctx()))
                    .frame(i == self.chosen)
                    .min_size(egui::vec2(ui.available_width(), 0.0));
                let response = ui.add_enabled(can(*command), button);
                if i == self.chosen && (up || down) {
                    response.scroll_to_me(None);
                }
                let response = response.on_disabled_hover_text(why_not(*command).unwrap_or_default());
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
        let all = |_| true;
        assert_eq!(matches("next pass", &all).first(), Some(&Command::NextPass));
        assert!(matches("nxtps", &all).contains(&Command::NextPass));
        assert!(matches("zzzz", &all).is_empty());
        for info in COMMANDS {
            assert_eq!(matches(info.name, &all).first(), Some(&info.command), "{}", info.name);
        }
        assert_eq!(matches("", &all).len(), COMMANDS.len());
    }

    #[test]
    fn commands_that_are_available_come_first() {
        let can = |command| command != Command::NextPass && command != Command::CopyLink;
        let found = matches("", &can);
        assert_eq!(found.len(), COMMANDS.len());
        assert!(found[COMMANDS.len() - 2..].iter().all(|command| !can(*command)), "{found:?}");
        let found = matches("pass", &can);
        assert_eq!(found.last(), Some(&Command::NextPass));
        // What was named is not replaced by something else under the Enter key.
        assert_eq!(matches("next pass", &can).first(), Some(&Command::NextPass));
    }
}
