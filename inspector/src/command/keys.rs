//! The keys of commands as texts.

use egui::{Context, Key, KeyboardShortcut, Modifiers};

use super::Command;

impl Command {
    /// The first key in the system's notation; empty if there is none.
    #[must_use]
    pub fn key_text(self, ctx: &Context) -> String {
        self.key_texts(ctx).next().unwrap_or_default()
    }

    /// All keys in the system's notation.
    pub fn key_texts(self, ctx: &Context) -> impl Iterator<Item = String> {
        let keys = self.info().map_or(&[][..], |info| info.keys);
        keys.iter().map(|&(modifiers, key)| text(ctx, modifiers, key))
    }
}

/// egui names signs by words, "OpenBracket": here they are what is printed on the key.
fn text(ctx: &Context, modifiers: Modifiers, key: Key) -> String {
    // A question mark is typed with Shift on most keyboards.
    let modifiers = Modifiers { shift: modifiers.shift && key != Key::Questionmark, ..modifiers };
    let text = ctx.format_shortcut(&KeyboardShortcut::new(modifiers, key));
    let sign = key.symbol_or_name();
    let is_arrow = matches!(key, Key::ArrowDown | Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp);
    match text.strip_suffix(key.name()).filter(|_| !is_arrow) {
        Some(held) => format!("{held}{sign}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::COMMANDS;

    #[test]
    fn signs_are_shown_as_they_are_printed() {
        let ctx = Context::default();
        ctx.set_os(egui::os::OperatingSystem::Nix);
        for (command, wanted) in [
            (Command::PreviousRayByCost, "["),
            (Command::Help, "?"),
            (Command::PreviousRun, ","),
            (Command::LargerText, "Ctrl++"),
            (Command::Start, "Home"),
            (Command::PreviousPass, "Shift+F10"),
            (Command::NudgeLeft, "Left"),
        ] {
            assert_eq!(command.key_text(&ctx), wanted);
        }
        let words = ["Bracket", "mark", "Comma", "Period", "Minus", "Plus", "Equals"];
        for text in COMMANDS.iter().flat_map(|info| info.command.key_texts(&ctx)) {
            assert!(!words.iter().any(|word| text.contains(word)), "{text}");
        }
    }
}
