//! All commands, in one table that defines menus, keys, the palette and the tests.

mod keys;
mod layout;
mod menu;
mod pane_kind;

use egui::{Key, Modifiers};

pub use layout::{Layout, MOST_OWN};
pub use menu::Menu;
pub use pane_kind::PaneKind;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct CommandInfo {
    /// Which command.
    pub command: Command,
    /// Where it is in the menus.
    pub menu: Menu,
    /// Which rows of the menu it stands with, between separators.
    pub group: &'static str,
    /// Its name in menus and in the palette.
    pub name: &'static str,
    /// Keys; menus show the first.
    pub keys: &'static [(Modifiers, Key)],
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// Makes [`Command`] and [`COMMANDS`] from rows: a command's name, or one with a value in brackets, its name in menus,
/// and its keys.
macro_rules! commands {
    ($($menu:ident $group:ident { $($($(#[$about:meta])* $name:ident)? $([$of:expr])? $text:literal $(, $modifiers:ident $key:ident)*;)* })*) => {
        /// A command: its name in menus, and what it does where that says more.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Command {
            /// Toggles a panel.
            Show(PaneKind),
            /// Arranges the panels for a task.
            Arrange(Layout),
            /// Arranges the panels as the user saved them, by the index of what was saved.
            ArrangeOwn(usize),
            /// Begins a built-in lesson, by its index.
            Lesson(usize),
            /// Chooses an answer to the lesson's question, by its index.
            Choose(usize),
            $($($(#[doc = concat!("**", $text, "**")] $(#[$about])* $name,)?)*)*
        }

        /// Every command.
        pub const COMMANDS: &[CommandInfo] = &[$($(CommandInfo {
            command: $(Command::$name)? $($of)?,
            menu: Menu::$menu,
            group: stringify!($group),
            name: $text,
            keys: &[$(($modifiers, Key::$key)),*],
        }),*),*];
    };
}

#[rustfmt::skip]
commands! {
    File open {
        /// Opens a scene from a dialog.
        OpenScene "Open scene…", CTRL O;
        /// Reads the scene's file again, and returns to this ray and pass.
        ReloadScene "Reload scene", CTRL R;
        /// Opens a session from a dialog.
        OpenSession "Open session…", CTRL_SHIFT O;
        SaveSession "Save session…", CTRL S;
    }
    File kernels {
        /// Replaces the kernel that a WGSL file's entry point is named after, now and whenever the file is written.
        ReplaceKernel "Replace kernel…";
        BuiltInKernels "Use built-in kernels";
    }
    File links {
        CopyLink "Copy link to this view", CTRL_SHIFT C;
        PasteLink "Open link…", CTRL_SHIFT V;
    }
    File exports {
        /// Opens the export dialog.
        Export "Export…", CTRL E;
        ExportPasses "Export pass timings as CSV", CTRL_SHIFT E;
        /// Exports passes as a trace for Perfetto.
        ExportTrace "Export passes as trace JSON";
        /// Exports the stream in view as EXR.
        ExportExr "Export stream as EXR";
        /// Exports the stream in view as npy.
        ExportNpy "Export stream as npy";
        /// Exports the ray's history as CSV.
        ExportRay "Export ray as CSV";
        /// Exports the stream in view as PNG: a pixel for each texel, in the colours of the view.
        ExportTexels "Export stream as PNG";
        /// Exports what is seen of the stream as PNG, as large as the panel shows it.
        ExportView "Export stream view as PNG";
        /// Exports the ray's walk as SVG.
        ExportWalk "Export walk as SVG";
        ExportDataflow "Export data flow as SVG";
    }
    File end {
        /// Closes the window.
        Quit "Quit", CTRL Q;
    }
    Step passes {
        NextPass "Next pass", NONE F10, CTRL ArrowRight;
        PreviousPass "Previous pass", SHIFT F10, CTRL ArrowLeft;
        /// To the next pass of the kernel that ran last.
        NextOfKernel "Next pass of this kernel", CTRL F10;
        /// To the previous pass of the kernel that ran last.
        PreviousOfKernel "Previous pass of this kernel", CTRL_SHIFT F10;
        /// To the end of the current turn of the innermost loop: an iteration of the walk, a stage of a sort.
        IterationEnd "End of this iteration", CTRL F11;
        /// To the start of the current turn of the innermost loop: an iteration of the walk, a stage of a sort.
        IterationStart "Start of this iteration", CTRL_SHIFT F11;
        /// To the start of the run.
        Start "Go to start", NONE Home;
        /// To the end of the run.
        End "Go to end", NONE End;
        /// Starts or stops automatic stepping.
        Play "Play", NONE Space;
        /// Cancels work in progress.
        Cancel "Cancel", NONE Escape;
    }
    Step events {
        /// To the ray's next cell or triangle.
        NextEvent "Next event of the ray", NONE F11;
        /// To the ray's previous cell or triangle.
        PreviousEvent "Previous event of the ray", SHIFT F11;
        /// To the next condition that the ray reached in this pass.
        NextBranch "Next branch of the ray", NONE F7;
        /// To the previous condition that the ray reached in this pass.
        PreviousBranch "Previous branch of the ray", SHIFT F7;
        /// Shows which rays took the branch in view.
        MaskBranch "Show the rays that took this branch", CTRL F7;
    }
    Step watches {
        /// Forwards to where a watch fires.
        RunToWatch "Run to watch", NONE F5;
        /// Backwards to where a watch fires.
        RunBackToWatch "Run back to watch", SHIFT F5;
        /// Toggles a watch on the selected ray's state and hit.
        ToggleWatch "Watch the selected ray's state and hit", NONE F9;
    }
    Step bookmarks {
        /// Adds a bookmark at the current place, or removes it.
        ToggleBookmark "Bookmark this pass", CTRL M;
        NextBookmark "Next bookmark", CTRL_SHIFT ArrowDown;
        PreviousBookmark "Previous bookmark", CTRL_SHIFT ArrowUp;
    }
    Ray select {
        /// Selects a pixel by its coordinates.
        GoToPixel "Go to pixel…", CTRL G;
        /// Selects the pixel to the left.
        NudgeLeft "Pixel to the left", NONE ArrowLeft;
        /// Selects the pixel to the right.
        NudgeRight "Pixel to the right", NONE ArrowRight;
        /// Selects the pixel above.
        NudgeUp "Pixel above", NONE ArrowUp;
        /// Selects the pixel below.
        NudgeDown "Pixel below", NONE ArrowDown;
        /// Selects the next more expensive ray.
        PreviousRayByCost "Costlier ray", NONE OpenBracket;
        /// Selects the next cheaper ray.
        NextRayByCost "Cheaper ray", NONE CloseBracket;
    }
    Ray enter {
        /// Traces a ray entered as text.
        TypeRay "Enter a ray…";
        /// Edits a component of the selected ray's texel.
        EditTexel "Edit texel…";
    }
    View range {
        /// Doubles the exposure.
        ExposureUp "Exposure up", NONE E;
        /// Halves the exposure.
        ExposureDown "Exposure down", SHIFT E;
        /// Moves the range up by a tenth.
        OffsetUp "Offset up", NONE O;
        /// Moves the range down by a tenth.
        OffsetDown "Offset down", SHIFT O;
        /// Takes the range from the values.
        Normalise "Normalise range", NONE N;
        /// Resets exposure, offset and range.
        ResetRange "Reset range", NONE R;
    }
    View pictures {
        /// Fits the picture to its panel.
        Fit "Fit to panel", NONE F;
        /// Shows a copy of the current stream in a new tab.
        Pin "Pin this stream", NONE P;
        /// Toggles the magnifier of stream views.
        Magnifier "Magnifier", NONE M;
    }
    View walks {
        /// Frames the selected ray's walk in the 3D view.
        FrameWalk "Frame walk in 3D";
        /// Colours the scene in 3D by tests of triangles, by visits of cells or leaves, or by materials.
        PaintScene "Colour 3D view by cost";
        /// Shows the ray's walk through the other structure as well, in the unfolded walk.
        SecondWalk "Unfold grid and BVH walks together";
        NextSlice "Next layer of the grid", NONE PageUp;
        PreviousSlice "Previous layer of the grid", NONE PageDown;
        /// Shows layers of the grid perpendicular to the next axis.
        SliceAxis "Next axis of the grid's layers", NONE X;
    }
    View window {
        Theme "Toggle light/dark theme";
        LargerText "Larger text", CTRL Plus, CTRL Equals;
        SmallerText "Smaller text", CTRL Minus;
        NormalText "Normal text size", CTRL Num0;
        /// Shows or hides the words beside the toolbar's icons.
        ToolbarWords "Toolbar words";
    }
    Panels layouts {
        [Command::Arrange(Layout::Overview)] "Overview layout", NONE Num0;
        [Command::Arrange(Layout::Step)] "Step layout", NONE Num1;
        [Command::Arrange(Layout::Ray)] "Ray layout", NONE Num2;
        [Command::Arrange(Layout::Compare)] "Compare layout", NONE Num3;
        [Command::Arrange(Layout::Cost)] "Cost layout", NONE Num4;
        [Command::Arrange(Layout::Learn)] "Learn layout", NONE Num5;
        [Command::ArrangeOwn(0)] "Own layout 1", NONE Num6;
        [Command::ArrangeOwn(1)] "Own layout 2", NONE Num7;
        [Command::ArrangeOwn(2)] "Own layout 3", NONE Num8;
        [Command::ArrangeOwn(3)] "Own layout 4", NONE Num9;
        /// Saves the arrangement of panels under a name, to return to it with a key; removes saved ones.
        SaveLayout "Save layout…", CTRL L;
        /// Arranges the panels of this layout as they were at first.
        ResetLayout "Reset layout";
    }
    Panels focus {
        /// Gives a panel the whole window, or restores the layout.
        Maximise "Maximise panel", NONE F12;
        /// Moves keyboard focus to the next panel.
        NextPanel "Next panel", NONE F6;
        /// Moves keyboard focus to the previous panel.
        PreviousPanel "Previous panel", SHIFT F6;
        /// Shows the next tab beside the panel with keyboard focus.
        NextTab "Next tab", CTRL PageDown;
        /// Shows the previous tab beside the panel with keyboard focus.
        PreviousTab "Previous tab", CTRL PageUp;
    }
    Panels panels {
        [Command::Show(PaneKind::Passes)] "Passes", CTRL Num1;
        [Command::Show(PaneKind::Stream)] "Stream", CTRL Num2;
        [Command::Show(PaneKind::Ray)] "Ray", CTRL Num3;
        [Command::Show(PaneKind::Walk3d)] "Walk in 3D", CTRL Num4;
        [Command::Show(PaneKind::Walk2d)] "Unfolded walk", CTRL Num5;
        [Command::Show(PaneKind::LightTree)] "Light tree";
        [Command::Show(PaneKind::Bounces)] "Bounces";
        [Command::Show(PaneKind::Timeline)] "Timeline", CTRL Num6;
        [Command::Show(PaneKind::Kernel)] "Kernel", CTRL Num7;
        [Command::Show(PaneKind::Dataflow)] "Data flow", CTRL Num8;
        [Command::Show(PaneKind::Timings)] "Timings", CTRL Num9;
        [Command::Show(PaneKind::Plan)] "Plan";
        [Command::Show(PaneKind::Cost)] "Cost";
        [Command::Show(PaneKind::Structure)] "Grid and BVH";
        [Command::Show(PaneKind::Compare)] "Compare";
        [Command::Show(PaneKind::Divergence)] "Divergence";
        [Command::Show(PaneKind::Error)] "Error over time";
        [Command::Show(PaneKind::Choices)] "Choices";
        [Command::Show(PaneKind::Runs)] "Runs";
        [Command::Show(PaneKind::Watches)] "Watches";
        [Command::Show(PaneKind::Options)] "Options", CTRL Comma;
        [Command::Show(PaneKind::Lessons)] "Lessons";
        [Command::Show(PaneKind::Log)] "Log";
    }
    Compare pair {
        /// Opens a second run: with the BVH if this one has the grid.
        Compare "Compare with BVH", CTRL B;
        EndCompare "End comparison";
    }
    Compare judge {
        /// Maps differences between GPU and CPU reference.
        Divergence "Map GPU/CPU differences", CTRL D;
        /// Compares hits with f64 brute force.
        Judge "Judge hits";
        /// Times every choice of structure, schedule and rules, and judges its hits.
        Measure "Measure choices";
    }
    Compare kept {
        /// Keeps this run beside others.
        KeepRun "Keep this run", NONE K;
        /// Runs kept runs that have no results.
        RunKept "Run kept runs again";
        /// Shows the next kept run in stream views.
        NextRun "Flip to the next kept run", NONE Period;
        /// Shows the previous kept run in stream views.
        PreviousRun "Flip to the previous kept run", NONE Comma;
        /// Selects the next ray in which the compared kept runs differ.
        NextDifferingRay "Next differing ray", NONE D;
    }
    Help help {
        /// Opens the palette.
        Palette "Commands…", CTRL P;
        Help "Keyboard shortcuts", SHIFT Questionmark, NONE Questionmark;
    }
    Help lessons {
        [Command::Lesson(0)] "Lesson: how one ray finds its triangle";
        [Command::Lesson(1)] "Lesson: why the grid lost in 2004";
        [Command::Lesson(2)] "Lesson: the machine of 2004, and its two conjectures";
        [Command::Lesson(3)] "Lesson: a crack at a voxel face";
        [Command::Lesson(4)] "Lesson: what empty-space skipping leaps over";
        [Command::Lesson(5)] "Lesson: a tie that f32 cannot decide";
        [Command::Lesson(6)] "Lesson: from ray caster to path tracer";
        [Command::Lesson(7)] "Lesson: why is this pixel so bright?";
        [Command::Lesson(8)] "Lesson: a caustic, photon by photon";
    }
    Help steps {
        NextStep "Next step of the lesson", NONE F8;
        PreviousStep "Previous step of the lesson", SHIFT F8;
        RepeatStep "Set up this step again";
        [Command::Choose(0)] "Choose answer 1", NONE Num1;
        [Command::Choose(1)] "Choose answer 2", NONE Num2;
        [Command::Choose(2)] "Choose answer 3", NONE Num3;
        [Command::Choose(3)] "Choose answer 4", NONE Num4;
        SkipPlay "Skip what the lesson plays";
        CloseLesson "Close lesson";
    }
}

impl Command {
    /// Whether it begins, moves through or ends a lesson.
    #[must_use]
    pub fn is_of_lessons(self) -> bool {
        matches!(
            self,
            Self::Lesson(_)
                | Self::NextStep
                | Self::PreviousStep
                | Self::RepeatStep
                | Self::CloseLesson
                | Self::Choose(_)
                | Self::SkipPlay
        )
    }

    /// The command with this name, in any case and with or without the dots that ask for more: as `--do` and lessons
    /// name it.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let plain = |name: &str| name.trim_end_matches('…').to_lowercase();
        COMMANDS.iter().find(|info| plain(info.name) == plain(name)).map(|info| info.command)
    }

    /// Its row of the table.
    #[must_use]
    pub fn info(self) -> Option<&'static CommandInfo> {
        COMMANDS.iter().find(|info| info.command == self)
    }

    /// Its name in menus and in the palette.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.info().map_or("?", |info| info.name)
    }
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
            // The answers to a lesson's question take the digits of the layouts while it is asked.
            for key in info.keys.iter().filter(|_| !matches!(info.command, Command::Choose(_))) {
                assert!(keys.insert(format!("{key:?}")), "{}: {key:?}", info.name);
            }
        }
        for &kind in PaneKind::ALL {
            assert!(commands.contains(&Command::Show(kind)), "{kind:?}");
        }
    }
}
