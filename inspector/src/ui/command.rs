//! Everything that can be done, in one table: menus, keys, the palette and the tests are made from it.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::pane::PaneKind;

/// Something that a user can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Open a scene by dialog.
    OpenScene,
    /// The run's place as one line of text, to the clipboard.
    CopyLink,
    /// Go to the place that a line of text names.
    PasteLink,
    /// What can be taken away.
    Export,
    /// Passes as CSV.
    ExportPasses,
    /// Passes as a trace for Perfetto.
    ExportTrace,
    /// The stream in view as EXR.
    ExportExr,
    /// The stream in view as npy.
    ExportNpy,
    /// The ray's life as CSV.
    ExportRay,
    /// The stream view as it is shown, as PNG.
    ExportView,
    /// The ray's walk as a drawing, SVG.
    ExportWalk,
    /// The data flow as a drawing, SVG.
    ExportDataflow,
    /// Close the window.
    Quit,

    /// One pass on.
    NextPass,
    /// One pass back.
    PreviousPass,
    /// After the next pass of the kernel that ran last.
    NextOfKernel,
    /// After the previous pass of the kernel that ran last.
    PreviousOfKernel,
    /// The end of this turn of the loop.
    IterationEnd,
    /// Its start.
    IterationStart,
    /// After the last pass.
    End,
    /// Before the first pass.
    Start,
    /// The ray's next cell or triangle.
    NextEvent,
    /// The ray's previous cell or triangle.
    PreviousEvent,
    /// On to where a watch fires.
    RunToWatch,
    /// Back to where a watch fired.
    RunBackToWatch,
    /// A watch on the selected ray's state and hit, on or off.
    ToggleWatch,
    /// Step by itself, or stop.
    Play,
    /// Stop what goes on.
    Cancel,

    /// A pixel by its numbers.
    GoToPixel,
    /// A ray by its numbers.
    TypeRay,
    /// The pixel to the left.
    NudgeLeft,
    /// The pixel to the right.
    NudgeRight,
    /// The pixel above.
    NudgeUp,
    /// The pixel below.
    NudgeDown,
    /// The ray that costs a little more.
    PreviousRayByCost,
    /// The ray that costs a little less.
    NextRayByCost,

    /// A component of the selected ray's texel by its number.
    EditTexel,

    /// Twice as bright.
    ExposureUp,
    /// Half as bright.
    ExposureDown,
    /// The range a tenth up.
    OffsetUp,
    /// The range a tenth down.
    OffsetDown,
    /// The range from the values.
    Normalise,
    /// Exposure, offset and range as at first.
    ResetRange,
    /// All of the picture in view.
    Fit,
    /// A copy of the stream as it is, in a view of its own.
    Pin,
    /// Light or dark.
    Theme,
    /// The first three panels.
    SimpleLayout,
    /// All that is used daily.
    FullLayout,
    /// A panel, on or off.
    Show(PaneKind),

    /// A second run beside this one: the tree beside the grid.
    Compare,
    /// End of the comparison.
    EndCompare,
    /// Where GPU and twins part, as a map.
    Divergence,
    /// Which rays are resolved wrongly, by f64 brute force.
    Judge,

    /// The palette.
    Palette,
    /// Keys and what they do.
    Help,
    /// How one ray finds its triangle.
    LessonRay,
    /// Why the grid lost in 2004.
    LessonGrid,
    /// A crack at a voxel face.
    LessonCrack,
}

/// Where a command is in the menus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// Scenes, links, exports.
    File,
    /// Passes.
    Step,
    /// The ray.
    Ray,
    /// Views and panels.
    View,
    /// Two runs.
    Compare,
    /// Help and lessons.
    Help,
}

impl Menu {
    /// Every menu, left to right.
    pub const ALL: [Self; 6] = [Self::File, Self::Step, Self::Ray, Self::View, Self::Compare, Self::Help];

    /// Its title.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Step => "Step",
            Self::Ray => "Ray",
            Self::View => "View",
            Self::Compare => "Compare",
            Self::Help => "Help",
        }
    }
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct CommandInfo {
    /// Which command.
    pub command: Command,
    /// Where it is in the menus.
    pub menu: Menu,
    /// What people read.
    pub name: &'static str,
    /// Keys, the first of which menus show.
    pub keys: &'static [(Modifiers, Key)],
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

macro_rules! table {
    ($($menu:ident { $($command:expr, $name:literal $(, $modifiers:ident $key:ident)*;)* })*) => {
        &[$($(CommandInfo {
            command: $command, menu: Menu::$menu, name: $name, keys: &[$(($modifiers, Key::$key)),*],
        }),*),*]
    };
}

use Command as C;

/// Every command.
#[rustfmt::skip]
pub const COMMANDS: &[CommandInfo] = table! {
    File {
        C::OpenScene, "Open scene…", CTRL O;
        C::CopyLink, "Copy link to this place", CTRL_SHIFT C;
        C::PasteLink, "Go to link…", CTRL_SHIFT V;
        C::Export, "Export…", CTRL E;
        C::ExportPasses, "Export passes as CSV";
        C::ExportTrace, "Export passes as trace JSON";
        C::ExportExr, "Export stream as EXR";
        C::ExportNpy, "Export stream as npy";
        C::ExportRay, "Export ray as CSV";
        C::ExportView, "Export stream view as PNG";
        C::ExportWalk, "Export walk as SVG";
        C::ExportDataflow, "Export data flow as SVG";
        C::Quit, "Quit", CTRL Q;
    }
    Step {
        C::NextPass, "Next pass", NONE F10, CTRL ArrowRight;
        C::PreviousPass, "Previous pass", SHIFT F10, CTRL ArrowLeft;
        C::NextOfKernel, "Next pass of this kernel", CTRL F10;
        C::PreviousOfKernel, "Previous pass of this kernel", CTRL_SHIFT F10;
        C::NextEvent, "Next event of the ray", NONE F11;
        C::PreviousEvent, "Previous event of the ray", SHIFT F11;
        C::IterationEnd, "End of this iteration", CTRL F11;
        C::IterationStart, "Start of this iteration", CTRL_SHIFT F11;
        C::Start, "To the start", NONE Home;
        C::End, "To the end", NONE End;
        C::RunToWatch, "Run to watch", NONE F5;
        C::RunBackToWatch, "Run back to watch", SHIFT F5;
        C::ToggleWatch, "Watch the selected ray's state and hit", NONE F9;
        C::Play, "Play", NONE Space;
        C::Cancel, "Cancel", NONE Escape;
    }
    Ray {
        C::GoToPixel, "Go to pixel…", CTRL G;
        C::TypeRay, "Type a ray…";
        C::NudgeLeft, "Pixel to the left", NONE ArrowLeft;
        C::NudgeRight, "Pixel to the right", NONE ArrowRight;
        C::NudgeUp, "Pixel above", NONE ArrowUp;
        C::NudgeDown, "Pixel below", NONE ArrowDown;
        C::EditTexel, "Change a texel…";
        C::PreviousRayByCost, "Costlier ray", NONE OpenBracket;
        C::NextRayByCost, "Cheaper ray", NONE CloseBracket;
    }
    View {
        C::ExposureUp, "Exposure up", NONE E;
        C::ExposureDown, "Exposure down", SHIFT E;
        C::OffsetUp, "Offset up", NONE O;
        C::OffsetDown, "Offset down", SHIFT O;
        C::Normalise, "Normalise range", NONE N;
        C::ResetRange, "Reset range", NONE R;
        C::Fit, "Fit picture", NONE F;
        C::Pin, "Pin this stream", NONE P;
        C::Theme, "Light or dark";
        C::SimpleLayout, "Simple layout";
        C::FullLayout, "Full layout", CTRL L;
        C::Show(PaneKind::Passes), "Passes", CTRL Num1;
        C::Show(PaneKind::Stream), "Stream", CTRL Num2;
        C::Show(PaneKind::Ray), "Ray", CTRL Num3;
        C::Show(PaneKind::Walk3d), "Walk in 3D", CTRL Num4;
        C::Show(PaneKind::Walk2d), "Walk, unfolded", CTRL Num5;
        C::Show(PaneKind::Timeline), "Timeline", CTRL Num6;
        C::Show(PaneKind::Kernel), "Kernel", CTRL Num7;
        C::Show(PaneKind::Dataflow), "Data flow", CTRL Num8;
        C::Show(PaneKind::Timings), "Timings", CTRL Num9;
        C::Show(PaneKind::Plan), "Plan";
        C::Show(PaneKind::Cost), "Cost";
        C::Show(PaneKind::Structure), "Grid and tree";
        C::Show(PaneKind::Compare), "Compare";
        C::Show(PaneKind::Divergence), "Divergence";
        C::Show(PaneKind::Error), "Error over time";
        C::Show(PaneKind::Watches), "Watches";
        C::Show(PaneKind::Options), "Options", CTRL Comma;
        C::Show(PaneKind::Log), "Log";
    }
    Compare {
        C::Compare, "Compare with the tree", CTRL B;
        C::EndCompare, "End the comparison";
        C::Divergence, "Map where GPU and twins part", CTRL D;
        C::Judge, "Judge what rays hit";
    }
    Help {
        C::Palette, "Commands…", CTRL P;
        C::Help, "Keys", SHIFT Questionmark, NONE Questionmark;
        C::LessonRay, "Lesson: how one ray finds its triangle";
        C::LessonGrid, "Lesson: why the grid lost in 2004";
        C::LessonCrack, "Lesson: a crack at a voxel face";
    }
};

impl Command {
    /// Its row of the table.
    #[must_use]
    pub fn info(self) -> Option<&'static CommandInfo> {
        COMMANDS.iter().find(|info| info.command == self)
    }

    /// What people read.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.info().map_or("?", |info| info.name)
    }

    /// The first key, as the system writes it; empty where there is none.
    #[must_use]
    pub fn key_text(self, ctx: &egui::Context) -> String {
        let first = self.info().and_then(|info| info.keys.first());
        first.map_or_else(String::new, |&(modifiers, key)| ctx.format_shortcut(&KeyboardShortcut::new(modifiers, key)))
    }
}

/// The commands whose keys were pressed. Text fields, menus and lists that are open keep their own keys; `had_focus`:
/// something had the keys at the end of the last frame.
pub(super) fn pressed(ctx: &egui::Context, had_focus: bool) -> Vec<Command> {
    let is_taken = ctx.egui_wants_keyboard_input() || egui::Popup::is_any_open(ctx);
    let mut keys: Vec<(&CommandInfo, KeyboardShortcut)> = COMMANDS
        .iter()
        .flat_map(|info| info.keys.iter().map(move |&(modifiers, key)| (info, KeyboardShortcut::new(modifiers, key))))
        .filter(|(_, shortcut)| !is_taken || is_global(shortcut))
        .collect();
    // The more modifiers, the earlier: else Ctrl+Shift+F10 would be Ctrl+F10.
    keys.sort_by_key(|(_, s)| {
        let m = s.modifiers;
        std::cmp::Reverse([m.alt, m.shift, m.ctrl, m.command].iter().filter(|&&on| on).count())
    });
    // Escape closes what is open, and leaves what is typed, before it stops work.
    let is_escape_taken = had_focus || is_taken;
    // A key that was pressed twice since the last frame counts twice.
    let times = |input: &mut egui::InputState, shortcut: &KeyboardShortcut| match shortcut.logical_key {
        Key::Escape => usize::from(!is_escape_taken && input.key_pressed(Key::Escape)),
        key => input.count_and_consume_key(shortcut.modifiers, key),
    };
    ctx.input_mut(|input| keys.iter().flat_map(|(info, shortcut)| vec![info.command; times(input, shortcut)]).collect())
}

/// Whether a key does the same while text is typed.
fn is_global(shortcut: &KeyboardShortcut) -> bool {
    let function_keys = Key::F1..=Key::F12;
    function_keys.contains(&shortcut.logical_key)
        || shortcut.modifiers.command && matches!(shortcut.logical_key, Key::P | Key::O | Key::G | Key::E | Key::Q)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_key_and_no_name_is_used_twice() {
        let mut keys = HashSet::new();
        let mut names = HashSet::new();
        let mut commands = HashSet::new();
        for info in COMMANDS {
            assert!(names.insert(info.name) && commands.insert(info.command), "{}", info.name);
            for key in info.keys {
                assert!(keys.insert(format!("{key:?}")), "{}: {key:?}", info.name);
            }
        }
        for &kind in PaneKind::ALL {
            assert!(commands.contains(&Command::Show(kind)), "{kind:?}");
        }
    }
}
