//! Which commands a key press means, and which keys belong to what has keyboard focus.

use egui::{Key, KeyboardShortcut};

use crate::command::{COMMANDS, Command, CommandInfo};
use crate::ui::panels::table;

/// Which keys the item with keyboard focus keeps for itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Holds {
    /// None: nothing has focus, or a panel as a whole.
    #[default]
    Nothing,
    /// Those that press a button, choose an item or move on: Space, Enter, arrows.
    Buttons,
    /// All that may be text.
    Text,
}

/// The commands whose keys were pressed. Open text fields, menus and lists keep their own keys; `had_focus`: something
/// that Escape leaves had keyboard focus at the end of the last frame; in a lesson, digits answer its
/// questions; otherwise they choose a layout.
pub(super) fn pressed(ctx: &egui::Context, holds: Holds, had_focus: bool, in_lesson: bool) -> Vec<Command> {
    // A table with the focus only takes the keys that choose its rows.
    let in_table = table::is_focused(ctx);
    let holds = match holds {
        _ if egui::Popup::is_any_open(ctx) => Holds::Text,
        _ if in_table => Holds::Nothing,
        holds => holds,
    };
    let mut keys: Vec<(&CommandInfo, KeyboardShortcut)> = COMMANDS
        .iter()
        .filter(|info| match info.command {
            Command::Choose(_) => in_lesson,
            Command::Arrange(_) | Command::ArrangeOwn(_) => !in_lesson,
            _ => true,
        })
        .flat_map(|info| info.keys.iter().map(move |&(modifiers, key)| (info, KeyboardShortcut::new(modifiers, key))))
        .filter(|(_, shortcut)| match holds {
            Holds::Nothing => true,
            Holds::Buttons => !is_of_buttons(shortcut),
            Holds::Text => is_global(shortcut),
        })
        .filter(|(_, shortcut)| !table::takes(ctx, shortcut.modifiers, shortcut.logical_key))
        .collect();
    // Most modifiers first: otherwise Ctrl+Shift+F10 would match Ctrl+F10.
    keys.sort_by_key(|(_, s)| {
        let m = s.modifiers;
        std::cmp::Reverse([m.alt, m.shift, m.ctrl, m.command].iter().filter(|&&on| on).count())
    });
    // Escape first closes what is open and leaves a text field, and only then cancels work.
    let is_escape_taken = had_focus || holds != Holds::Nothing;
    // A key that was pressed twice since the last frame counts twice.
    let times = |input: &mut egui::InputState, shortcut: &KeyboardShortcut| match shortcut.logical_key {
        Key::Escape => usize::from(!is_escape_taken && input.key_pressed(Key::Escape)),
        key => input.count_and_consume_key(shortcut.modifiers, key),
    };
    ctx.input_mut(|input| keys.iter().flat_map(|(info, shortcut)| vec![info.command; times(input, shortcut)]).collect())
}

/// Whether a key presses a button or moves to another one.
fn is_of_buttons(shortcut: &KeyboardShortcut) -> bool {
    let arrows = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];
    let is_plain = shortcut.modifiers.is_none();
    is_plain && (shortcut.logical_key == Key::Space || arrows.contains(&shortcut.logical_key))
}

/// Whether a key also works while text is being entered.
fn is_global(shortcut: &KeyboardShortcut) -> bool {
    let function_keys = Key::F1..=Key::F12;
    let with_command = [
        Key::P,
        Key::O,
        Key::G,
        Key::E,
        Key::Q,
        Key::Plus,
        Key::Equals,
        Key::Minus,
        Key::Num0,
        Key::PageUp,
        Key::PageDown,
        Key::M,
    ];
    function_keys.contains(&shortcut.logical_key)
        || shortcut.modifiers.command && with_command.contains(&shortcut.logical_key)
}
