//! All commands, in one table that defines menus, keys, the palette and the tests.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::pane::PaneKind;

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Opens a scene from a dialog.
    OpenScene,
    /// Copies a link to the current view.
    CopyLink,
    /// Opens a link.
    PasteLink,
    /// Opens the export dialog.
    Export,
    /// Exports passes as CSV.
    ExportPasses,
    /// Exports passes as a trace for Perfetto.
    ExportTrace,
    /// Exports the stream in view as EXR.
    ExportExr,
    /// Exports the stream in view as npy.
    ExportNpy,
    /// Exports the ray's history as CSV.
    ExportRay,
    /// Exports the stream view as PNG.
    ExportView,
    /// Exports the ray's walk as SVG.
    ExportWalk,
    /// Exports the data flow as SVG.
    ExportDataflow,
    /// Saves the session.
    SaveSession,
    /// Opens a session from a dialog.
    OpenSession,
    /// Closes the window.
    Quit,

    /// One pass forwards.
    NextPass,
    /// One pass backwards.
    PreviousPass,
    /// To the next pass of the kernel that ran last.
    NextOfKernel,
    /// To the previous pass of the kernel that ran last.
    PreviousOfKernel,
    /// To the end of the schedule's current iteration.
    IterationEnd,
    /// To the start of the schedule's current iteration.
    IterationStart,
    /// To the end of the run.
    End,
    /// To the start of the run.
    Start,
    /// To the next condition that the ray reached in this pass.
    NextBranch,
    /// To the previous condition that the ray reached in this pass.
    PreviousBranch,
    /// Shows which rays took the branch in view.
    MaskBranch,
    /// To the ray's next cell or triangle.
    NextEvent,
    /// To the ray's previous cell or triangle.
    PreviousEvent,
    /// Forwards to where a watch fires.
    RunToWatch,
    /// Backwards to where a watch fires.
    RunBackToWatch,
    /// Toggles a watch on the selected ray's state and hit.
    ToggleWatch,
    /// Adds a bookmark at the current place, or removes it.
    ToggleBookmark,
    /// To the next bookmark.
    NextBookmark,
    /// To the previous bookmark.
    PreviousBookmark,
    /// Starts or stops automatic stepping.
    Play,
    /// Cancels work in progress.
    Cancel,

    /// Selects a pixel by its coordinates.
    GoToPixel,
    /// Traces a ray entered as text.
    TypeRay,
    /// Selects the pixel to the left.
    NudgeLeft,
    /// Selects the pixel to the right.
    NudgeRight,
    /// Selects the pixel above.
    NudgeUp,
    /// Selects the pixel below.
    NudgeDown,
    /// Selects the next more expensive ray.
    PreviousRayByCost,
    /// Selects the next cheaper ray.
    NextRayByCost,

    /// Edits a component of the selected ray's texel.
    EditTexel,

    /// Doubles the exposure.
    ExposureUp,
    /// Halves the exposure.
    ExposureDown,
    /// Moves the range up by a tenth.
    OffsetUp,
    /// Moves the range down by a tenth.
    OffsetDown,
    /// Takes the range from the values.
    Normalise,
    /// Resets exposure, offset and range.
    ResetRange,
    /// Fits the picture to its panel.
    Fit,
    /// Frames the selected ray's walk in the 3D view.
    FrameWalk,
    /// Shows the ray's walk through the other structure as well, in the unfolded walk.
    SecondWalk,
    /// Shows a copy of the current stream in a new tab.
    Pin,
    /// Toggles the magnifier of stream views.
    Magnifier,
    /// Shows the next layer of the grid.
    NextSlice,
    /// Shows the previous layer of the grid.
    PreviousSlice,
    /// Shows layers of the grid perpendicular to the next axis.
    SliceAxis,
    /// Switches between light and dark theme.
    Theme,
    /// The default layout of three panels.
    SimpleLayout,
    /// The layout with all panels for daily use.
    FullLayout,
    /// Makes all text larger.
    LargerText,
    /// Makes all text smaller.
    SmallerText,
    /// Text at its normal size.
    NormalText,
    /// Shows or hides the words beside the toolbar's icons.
    ToolbarWords,
    /// Gives a panel the whole window, or restores the layout.
    Maximise,
    /// Moves keyboard focus to the next panel.
    NextPanel,
    /// Moves keyboard focus to the previous panel.
    PreviousPanel,
    /// Shows the next tab beside the panel with keyboard focus.
    NextTab,
    /// Shows the previous tab beside the panel with keyboard focus.
    PreviousTab,
    /// Toggles a panel.
    Show(PaneKind),

    /// Opens a second run: with the BVH if this one has the grid.
    Compare,
    /// Ends the comparison.
    EndCompare,
    /// Maps differences between GPU and CPU reference.
    Divergence,
    /// Compares hits with f64 brute force.
    Judge,
    /// Times every choice of structure, schedule and rules, and judges its hits.
    Measure,

    /// Keeps this run beside others.
    KeepRun,
    /// Runs kept runs that have no results.
    RunKept,
    /// Shows the next kept run in stream views.
    NextRun,
    /// Shows the previous kept run in stream views.
    PreviousRun,
    /// Selects the next ray in which the compared kept runs differ.
    NextDifferingRay,

    /// Opens the palette.
    Palette,
    /// Shows keyboard shortcuts.
    Help,
    /// Begins a built-in lesson, by its index.
    Lesson(usize),
    /// The next step of the lesson.
    NextStep,
    /// The step of the lesson before.
    PreviousStep,
    /// Sets the step of the lesson up again.
    RepeatStep,
    /// Chooses an answer to the lesson's question, by its index.
    Choose(usize),
    /// Skips what the lesson plays.
    SkipPlay,
    /// Closes the lesson.
    CloseLesson,
}

/// A menu.
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
    /// Its name in menus and in the palette.
    pub name: &'static str,
    /// Keys; menus show the first.
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
        C::CopyLink, "Copy link to this view", CTRL_SHIFT C;
        C::PasteLink, "Open link…", CTRL_SHIFT V;
        C::Export, "Export…", CTRL E;
        C::ExportPasses, "Export passes as CSV";
        C::ExportTrace, "Export passes as trace JSON";
        C::ExportExr, "Export stream as EXR";
        C::ExportNpy, "Export stream as npy";
        C::ExportRay, "Export ray as CSV";
        C::ExportView, "Export stream view as PNG";
        C::ExportWalk, "Export walk as SVG";
        C::ExportDataflow, "Export data flow as SVG";
        C::OpenSession, "Open session…", CTRL_SHIFT O;
        C::SaveSession, "Save session…", CTRL S;
        C::Quit, "Quit", CTRL Q;
    }
    Step {
        C::NextPass, "Next pass", NONE F10, CTRL ArrowRight;
        C::PreviousPass, "Previous pass", SHIFT F10, CTRL ArrowLeft;
        C::NextOfKernel, "Next pass of this kernel", CTRL F10;
        C::PreviousOfKernel, "Previous pass of this kernel", CTRL_SHIFT F10;
        C::NextEvent, "Next event of the ray", NONE F11;
        C::PreviousEvent, "Previous event of the ray", SHIFT F11;
        C::NextBranch, "Next branch of the ray", NONE F7;
        C::PreviousBranch, "Previous branch of the ray", SHIFT F7;
        C::MaskBranch, "Show the rays that took this branch", CTRL F7;
        C::IterationEnd, "End of this iteration", CTRL F11;
        C::IterationStart, "Start of this iteration", CTRL_SHIFT F11;
        C::Start, "Go to start", NONE Home;
        C::End, "Go to end", NONE End;
        C::RunToWatch, "Run to watch", NONE F5;
        C::RunBackToWatch, "Run back to watch", SHIFT F5;
        C::ToggleWatch, "Watch the selected ray's state and hit", NONE F9;
        C::ToggleBookmark, "Bookmark this pass", CTRL M;
        C::NextBookmark, "Next bookmark", CTRL_SHIFT ArrowDown;
        C::PreviousBookmark, "Previous bookmark", CTRL_SHIFT ArrowUp;
        C::Play, "Play", NONE Space;
        C::Cancel, "Cancel", NONE Escape;
    }
    Ray {
        C::GoToPixel, "Go to pixel…", CTRL G;
        C::TypeRay, "Enter a ray…";
        C::NudgeLeft, "Pixel to the left", NONE ArrowLeft;
        C::NudgeRight, "Pixel to the right", NONE ArrowRight;
        C::NudgeUp, "Pixel above", NONE ArrowUp;
        C::NudgeDown, "Pixel below", NONE ArrowDown;
        C::EditTexel, "Edit texel…";
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
        C::Fit, "Fit to panel", NONE F;
        C::FrameWalk, "Frame walk in 3D";
        C::SecondWalk, "Unfold grid and BVH walks together";
        C::Pin, "Pin this stream", NONE P;
        C::Magnifier, "Magnifier", NONE M;
        C::NextSlice, "Next layer of the grid", NONE PageUp;
        C::PreviousSlice, "Previous layer of the grid", NONE PageDown;
        C::SliceAxis, "Next axis of the grid's layers", NONE X;
        C::Theme, "Toggle light/dark theme";
        C::SimpleLayout, "Simple layout";
        C::FullLayout, "Full layout", CTRL L;
        C::LargerText, "Larger text", CTRL Plus, CTRL Equals;
        C::SmallerText, "Smaller text", CTRL Minus;
        C::NormalText, "Normal text size", CTRL Num0;
        C::ToolbarWords, "Toolbar words";
        C::Maximise, "Maximise panel", NONE F12;
        C::NextPanel, "Next panel", NONE F6;
        C::PreviousPanel, "Previous panel", SHIFT F6;
        C::NextTab, "Next tab", CTRL PageDown;
        C::PreviousTab, "Previous tab", CTRL PageUp;
        C::Show(PaneKind::Passes), "Passes", CTRL Num1;
        C::Show(PaneKind::Stream), "Stream", CTRL Num2;
        C::Show(PaneKind::Ray), "Ray", CTRL Num3;
        C::Show(PaneKind::Walk3d), "Walk in 3D", CTRL Num4;
        C::Show(PaneKind::Walk2d), "Unfolded walk", CTRL Num5;
        C::Show(PaneKind::Timeline), "Timeline", CTRL Num6;
        C::Show(PaneKind::Kernel), "Kernel", CTRL Num7;
        C::Show(PaneKind::Dataflow), "Data flow", CTRL Num8;
        C::Show(PaneKind::Timings), "Timings", CTRL Num9;
        C::Show(PaneKind::Plan), "Plan";
        C::Show(PaneKind::Cost), "Cost";
        C::Show(PaneKind::Structure), "Grid and BVH";
        C::Show(PaneKind::Compare), "Compare";
        C::Show(PaneKind::Divergence), "Divergence";
        C::Show(PaneKind::Error), "Error over time";
        C::Show(PaneKind::Choices), "Choices";
        C::Show(PaneKind::Runs), "Runs";
        C::Show(PaneKind::Watches), "Watches";
        C::Show(PaneKind::Options), "Options", CTRL Comma;
        C::Show(PaneKind::Log), "Log";
    }
    Compare {
        C::Compare, "Compare with BVH", CTRL B;
        C::EndCompare, "End comparison";
        C::Divergence, "Map GPU/CPU differences", CTRL D;
        C::Judge, "Judge hits";
        C::Measure, "Measure choices";
        C::KeepRun, "Keep this run", NONE K;
        C::RunKept, "Run kept runs again";
        C::NextRun, "Flip to the next kept run", NONE Period;
        C::PreviousRun, "Flip to the previous kept run", NONE Comma;
        C::NextDifferingRay, "Next differing ray", NONE D;
    }
    Help {
        C::Palette, "Commands…", CTRL P;
        C::Help, "Keyboard shortcuts", SHIFT Questionmark, NONE Questionmark;
        C::Lesson(0), "Lesson: how one ray finds its triangle";
        C::Lesson(1), "Lesson: why the grid lost in 2004";
        C::Lesson(2), "Lesson: the machine of 2004, and its two conjectures";
        C::Lesson(3), "Lesson: a crack at a voxel face";
        C::Lesson(4), "Lesson: what empty-space skipping leaps over";
        C::Lesson(5), "Lesson: a tie that f32 cannot decide";
        C::NextStep, "Next step of the lesson", NONE F8;
        C::PreviousStep, "Previous step of the lesson", SHIFT F8;
        C::RepeatStep, "Set up this step again";
        C::Choose(0), "Choose answer 1", NONE Num1;
        C::Choose(1), "Choose answer 2", NONE Num2;
        C::Choose(2), "Choose answer 3", NONE Num3;
        C::Choose(3), "Choose answer 4", NONE Num4;
        C::SkipPlay, "Skip what the lesson plays";
        C::CloseLesson, "Close lesson";
    }
};

impl Command {
    /// Whether it begins, moves through or ends a lesson.
    #[must_use]
    pub fn is_of_lessons(self) -> bool {
        matches!(self, C::Lesson(_) | C::NextStep | C::PreviousStep | C::RepeatStep | C::CloseLesson)
            || matches!(self, C::Choose(_) | C::SkipPlay)
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

    /// The first key in the system's notation; empty if there is none.
    #[must_use]
    pub fn key_text(self, ctx: &egui::Context) -> String {
        let first = self.info().and_then(|info| info.keys.first());
        first.map_or_else(String::new, |&(modifiers, key)| ctx.format_shortcut(&KeyboardShortcut::new(modifiers, key)))
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
            for key in info.keys {
                assert!(keys.insert(format!("{key:?}")), "{}: {key:?}", info.name);
            }
        }
        for &kind in PaneKind::ALL {
            assert!(commands.contains(&Command::Show(kind)), "{kind:?}");
        }
    }
}
