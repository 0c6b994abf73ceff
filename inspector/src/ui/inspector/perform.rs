//! What commands do.

use super::Inspector;
use super::dialogs::Dialog;
use super::lessons::Lesson;
use super::palette::Palette;
use super::{first_steps, text_size};
use crate::command::Command;
use crate::session::request::Request;
use crate::session::{Direction, Model, Target};
use crate::ui::desk::arranged::Now;
use crate::ui::state::kept_runs::Asked;
use raystep_kernels::export::trace::TraceRow;

impl Inspector {
    /// Whether a command would have an effect now.
    pub(super) fn can(&self, command: Command) -> bool {
        self.why_not(command).is_none()
    }

    /// Why a command would have no effect now, for buttons that are grey; `None` if it would have one.
    pub(super) fn why_not(&self, command: Command) -> Option<&'static str> {
        use Command as C;
        let (model, runs, lesson) = (&self.model, &self.state.runs, self.lesson.as_ref());
        let needs = |is_met: bool, why: &'static str| (!is_met).then_some(why);
        let scene = needs(model.opened.is_some(), "needs an open scene");
        let ray = needs(model.history.is_some(), "needs a selected ray with a history: click a pixel");
        let event = |forward, why| needs(self.event(forward).is_some(), why);
        let mark = |forward, why| needs(self.state.bookmarks.from(model.place, forward).is_some(), why);
        match command {
            C::BuiltInKernels => needs(self.has_own_kernels(), "no kernel is replaced"),
            C::Quit => needs(self.host.can_quit(), "close the browser's tab"),
            C::OpenScene | C::OpenSession | C::PasteLink | C::Palette | C::Help | C::Theme | C::ToolbarWords => None,
            C::Arrange(_) | C::SaveLayout | C::ResetLayout | C::Show(_) | C::Lesson(_) => None,
            C::Maximise | C::NextPanel | C::PreviousPanel | C::NextTab | C::PreviousTab => None,
            C::ArrangeOwn(index) => needs(index < self.desk.arranged.own.len(), "save a layout first"),
            C::LargerText | C::SmallerText | C::NormalText => {
                let changes = text_size::resized(command, self.saved.text_size) != self.saved.text_size;
                needs(changes, "the text has this size")
            }
            C::NextRun | C::PreviousRun => {
                scene.or(needs(!runs.runs.list().is_empty(), "needs a kept run: Keep this run"))
            }
            C::RunKept => {
                let has = runs.runs.list().iter().any(|kept| kept.outcome.is_none());
                scene.or(needs(has, "all kept runs have results"))
            }
            C::NextDifferingRay => {
                let has = self.other.is_some() || runs.pair().is_some();
                scene.or(needs(has, "needs two runs: compare, or choose two kept runs"))
            }
            C::NextStep => needs(lesson.is_some_and(|l| l.has(true)), "needs a lesson with a next step"),
            C::PreviousStep => needs(lesson.is_some_and(|l| l.has(false)), "needs a lesson with a previous step"),
            C::RepeatStep | C::CloseLesson => needs(lesson.is_some(), "needs a lesson"),
            C::Choose(choice) => {
                needs(lesson.is_some_and(|lesson| choice < lesson.choices()), "needs a lesson's question")
            }
            C::SkipPlay => needs(lesson.is_some_and(Lesson::plays), "needs a lesson that plays"),
            C::Cancel => {
                let has = self.is_busy()
                    || self.is_playing
                    || self.state.selection.picked.is_some()
                    || self.desk.maximised().is_some();
                needs(has, "there is nothing to cancel")
            }
            C::NextPass | C::NextOfKernel | C::IterationEnd | C::End => {
                scene.or(needs(model.next.is_some(), "the run is at its end"))
            }
            C::PreviousPass | C::PreviousOfKernel | C::IterationStart | C::Start => {
                scene.or(needs(model.place > 0, "the run is at its start"))
            }
            C::NextEvent => ray.or_else(|| event(true, "the selected ray has no later event")),
            C::PreviousEvent => ray.or_else(|| event(false, "the selected ray has no earlier event")),
            C::NextBookmark => scene.or_else(|| mark(true, "there is no later bookmark")),
            C::PreviousBookmark => scene.or_else(|| mark(false, "there is no earlier bookmark")),
            C::ExportRay | C::ExportWalk | C::FrameWalk | C::SecondWalk => ray,
            C::NextBranch | C::PreviousBranch | C::MaskBranch => ray,
            C::EndCompare => needs(self.other.is_some(), "no second run is open"),
            C::Compare | C::Judge | C::Measure | C::PaintScene => {
                scene.or(needs(model.has_rays(), "this program has no rays"))
            }
            C::NextSlice | C::PreviousSlice | C::SliceAxis => {
                let has = model.opened.as_ref().is_some_and(|opened| opened.data.grid_cells.len() > 1);
                scene.or(needs(has, "needs a run with a grid"))
            }
            _ => scene,
        }
    }

    /// The place after the next or previous pass that processed the ray.
    fn event(&self, forward: bool) -> Option<usize> {
        let (rows, place) = (&self.model.history.as_ref()?.rows, self.model.place);
        let mut places = rows.iter().filter_map(TraceRow::place);
        if forward { places.find(|&p| p > place) } else { places.rfind(|&p| p < place) }
    }

    pub(super) fn execute(&mut self, ctx: &egui::Context, command: Command) {
        use Command as C;
        if !self.can(command) || self.desk.adapt_maximised(command) {
            return;
        }
        first_steps::note(&mut self.saved.first_steps, command);
        let last = self.model.last_pass().map(|pass| pass.kernel);
        let step = |model: &mut Model, target| {
            model.ask(Request::Step(target));
        };
        match command {
            C::OpenScene => self.host.choose_scene(),
            C::ReloadScene => self.reload(),
            C::ReplaceKernel => self.host.choose_kernel(),
            C::BuiltInKernels => self.use_built_in_kernels(),
            C::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            C::NextPass => step(&mut self.model, Target::Next),
            C::PreviousPass => step(&mut self.model, Target::Previous),
            C::NextOfKernel => step(&mut self.model, last.map_or(Target::Next, Target::NextOf)),
            C::PreviousOfKernel => step(&mut self.model, last.map_or(Target::Start, Target::PreviousOf)),
            C::IterationEnd => step(&mut self.model, Target::IterationEnd),
            C::IterationStart => step(&mut self.model, Target::IterationStart),
            C::Start => step(&mut self.model, Target::Start),
            C::End => step(&mut self.model, Target::End),
            C::NextEvent | C::PreviousEvent => self.state.asks.go_to = self.event(command == C::NextEvent),
            C::ToggleBookmark => {
                let is_there = self.state.bookmarks.toggle(self.model.place, self.state.selection.pixel);
                self.state.log.tell(if is_there { "bookmark added: see the timeline" } else { "bookmark removed" });
            }
            C::NextBookmark | C::PreviousBookmark => {
                if let Some(index) = self.state.bookmarks.from(self.model.place, command == C::NextBookmark) {
                    self.state.bookmarks.visit(index, &mut self.state.asks);
                }
            }
            // Not beyond the end of what a lesson plays: the next step may ask what comes then.
            C::Play if self.lesson.as_ref().is_some_and(Lesson::has_play) => {
                self.lesson.iter_mut().for_each(Lesson::toggle_play);
            }
            C::Play => {
                self.is_playing = !self.is_playing;
                if self.is_playing && self.model.next.is_none() {
                    step(&mut self.model, Target::Start);
                }
            }
            C::Cancel if !self.is_busy() && !self.is_playing => self.state.selection.picked = None,
            C::Cancel => {
                self.is_playing = false;
                self.state.asks.scrub.stop();
                self.lesson.iter_mut().for_each(Lesson::stop);
                self.model.cancel();
                if let Some(other) = &self.other {
                    other.cancel();
                }
            }
            C::GoToPixel => self.dialogs.open = Some(Dialog::Pixel(String::new())),
            C::TypeRay => self.dialogs.open = Some(Dialog::Ray(String::new())),
            C::EditTexel => {
                let Some(stream) = self.state.display.stream else { return };
                self.dialogs.open = Some(Dialog::Edit(stream, 0, String::new()));
            }
            C::CopyLink => {
                if let Some(link) = self.link() {
                    ctx.copy_text(link.to_string());
                    self.state.log.tell("link copied to the clipboard");
                }
            }
            C::PasteLink => self.dialogs.open = Some(Dialog::Link(String::new())),
            C::RunToWatch => self.run_to_watch(Direction::Forward),
            C::RunBackToWatch => self.run_to_watch(Direction::Back),
            C::ToggleWatch => self.toggle_watch(),
            C::Compare => self.compare(),
            C::EndCompare => {
                if let Some(other) = self.other.take() {
                    other.cancel();
                }
            }
            C::ExportPasses | C::ExportTrace | C::ExportExr | C::ExportNpy | C::ExportRay => self.take(command),
            C::OpenSession => self.host.choose_session(),
            C::SaveSession => self.save_session(),
            C::KeepRun => self.keep_run(),
            C::RunKept => self.state.runs.asked.push(Asked::AllAgain),
            C::NextRun | C::PreviousRun => self.flip(command == C::NextRun),
            C::NextDifferingRay if self.other.is_none() => self.next_differing(),
            C::Lesson(index) => self.begin_built_in(index),
            C::RepeatStep => self.repeat_step(),
            C::NextStep | C::PreviousStep => {
                if let Some((step, _)) = self.lesson_step() {
                    let by = usize::from(command == C::NextStep);
                    self.go_to_step((step + by).saturating_sub(usize::from(command == C::PreviousStep)));
                }
            }
            C::Choose(choice) => self.lesson.iter_mut().for_each(|lesson| lesson.choose(choice)),
            C::SkipPlay => self.skip_lesson_play(),
            C::CloseLesson => self.close_lesson(),
            C::NudgeLeft => self.nudge(-1, 0),
            C::NudgeRight => self.nudge(1, 0),
            C::NudgeUp => self.nudge(0, -1),
            C::NudgeDown => self.nudge(0, 1),
            C::Theme => {
                let is_dark = ctx.global_style().visuals.dark_mode;
                ctx.set_theme(if is_dark { egui::Theme::Light } else { egui::Theme::Dark });
            }
            C::LargerText | C::SmallerText | C::NormalText => {
                self.saved.text_size = text_size::resized(command, self.saved.text_size);
                ctx.set_zoom_factor(self.saved.text_size);
            }
            C::ToolbarWords => self.saved.toolbar_words = !self.saved.toolbar_words,
            C::Maximise => self.desk.toggle_maximised(ctx),
            C::NextPanel | C::PreviousPanel => self.desk.cycle_panels(ctx, command == C::NextPanel),
            C::NextTab | C::PreviousTab => self.desk.cycle_tabs(ctx, command == C::NextTab),
            C::Arrange(_) | C::ArrangeOwn(_) => {
                if let Some(to) = self.desk.arranged.of(command) {
                    self.desk.arrange(to);
                }
            }
            C::SaveLayout => {
                let name = match &self.desk.arranged.now {
                    Now::Own(name) => name.clone(),
                    Now::Task(_) => String::new(),
                };
                self.dialogs.open = Some(Dialog::Layout(name));
            }
            C::ResetLayout => self.desk.reset_layout(),
            C::Show(kind) => self.desk.toggle(kind),
            C::Magnifier => self.state.display.is_magnified = !self.state.display.is_magnified,
            C::Palette => self.dialogs.open = Some(Dialog::Palette(Palette::default())),
            C::Help => self.dialogs.open = Some(Dialog::Help),
            C::Export => self.dialogs.open = Some(Dialog::Export(false)),
            _ => self.ask_panels(command),
        }
    }

    fn nudge(&mut self, dx: i64, dy: i64) {
        let (Some(opened), Some([x, y])) = (&self.model.opened, self.state.selection.pixel) else { return };
        let moved = |at: u32, by: i64, side: u32| (i64::from(at) + by).clamp(0, i64::from(side) - 1) as u32;
        self.state.asks.select = Some([moved(x, dx, opened.plan.width), moved(y, dy, opened.plan.height)]);
    }

    /// Selects a pixel; the error says what was expected.
    pub(super) fn go_to_pixel(&mut self, text: &str) -> Result<(), String> {
        let Some(opened) = &self.model.opened else { return Ok(()) };
        let numbers: Vec<u32> = text.split([',', ' ']).filter_map(|part| part.trim().parse().ok()).collect();
        match numbers[..] {
            [x, y] if x < opened.plan.width && y < opened.plan.height => {
                self.state.asks.select = Some([x, y]);
                Ok(())
            }
            _ => {
                let (w, h) = (opened.plan.width - 1, opened.plan.height - 1);
                Err(format!("{text:?}: expected a column from 0 to {w} and a row from 0 to {h}"))
            }
        }
    }

    /// Traces a ray; the error says what was expected.
    pub(super) fn trace_ray(&mut self, text: &str) -> Result<(), String> {
        let Some(opened) = &self.model.opened else { return Ok(()) };
        let ray = text.parse::<crate::ray_text::GivenRay>().map_err(|error| error.to_string())?;
        let settings = crate::settings::Settings { ray: Some(ray), ..opened.settings.clone() };
        self.model.ask(Request::Plan(Box::new(settings)));
        Ok(())
    }
}
