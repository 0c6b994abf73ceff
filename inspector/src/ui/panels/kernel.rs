//! The kernel's WGSL: what ran for the selected ray or element in the current pass, the branch that decided, which rays of the
//! pass took it, and which elements stop at a line.
//!
//! Touches: selection, display, asks.

mod listing;
mod run;
mod shown;
mod stop;

use std::collections::HashMap;
use std::sync::Arc;

use raystep_kernels::Kernel;
use raystep_kernels::export::trace::Trace;
use raystep_kernels::interpret::{LineWork, MOST_SITES};
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use crate::branches::Branch;
use crate::command::Command;
use crate::session::Model;
use crate::settings::DeviceKind;
use crate::source::{self, Mark};
use crate::ui::choice::Choices as _;
use crate::ui::mask::Mask;
use crate::ui::pane::{Context, Panel, saves};
use crate::ui::panels::walked::command_button;
use crate::ui::style::strong;
use crate::walk::row_after_passes;
use listing::{Clicked, Listing};
use run::{Heat, Looked, OneRay, PassKey, Runs};
use shown::Shown;
use stop::StopAt;

/// What of the view is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, SmartDefault)]
#[serde(default)]
struct Look {
    /// Show the composed source instead of the kernel's own files: the branch that decided is often in a shared function.
    #[default(true)]
    composed: bool,
}

/// What is known of the ray in the pass.
#[derive(Default)]
enum Known {
    /// No ray is selected.
    #[default]
    Nothing,
    /// Its streams are being read.
    Waiting,
    /// Why there is nothing; one line.
    Failed(String),
    Ray(OneRay),
}

/// The kernel's source.
#[derive(Default)]
pub(in crate::ui) struct KernelView {
    look: Look,
    shown: Option<Shown>,
    listing: Listing,
    runs: Runs,
    known: Known,
    /// The branch in view: an index into those reached.
    selected: Option<usize>,
    /// Whether the branch's mask is shown once all rays are known.
    is_mask_wanted: bool,
    /// Of each line of the listing, the line of the composed source that it is; `None` if they are the same.
    placed: Option<Vec<Option<usize>>>,
    stop: StopAt,
}

impl Panel for KernelView {
    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        if cx.model.opened.is_none() {
            ui.weak("Open a scene to see the kernel of its last pass.");
            return;
        }
        let Some(shown) = self.update(cx) else {
            ui.weak("This run has no passes.");
            return;
        };
        self.head(ui, &shown, cx);
        ui.separator();
        let selected = self.branch().map(|branch| branch.site);
        match self.listing.show(ui, selected) {
            Some(Clicked::Site(site)) => {
                let Known::Ray(OneRay { branches, .. }) = &self.known else { return };
                self.selected = branches.reached.iter().position(|branch| branch.site == site);
                self.show_mask(cx, false);
            }
            Some(Clicked::Line(line)) => {
                if let Some(line) = self.composed_line(line) {
                    self.stop.choose(cx.model, shown.kernel, line);
                }
            }
            None => {}
        }
    }

    saves!(look);

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if !matches!(command, Command::NextBranch | Command::PreviousBranch | Command::MaskBranch) {
            return false;
        }
        self.update(cx);
        match command {
            Command::MaskBranch => self.show_mask(cx, true),
            _ => self.go_on(command == Command::NextBranch),
        }
        true
    }
}

impl KernelView {
    /// Brings the lines up to date.
    fn update(&mut self, cx: &mut Context<'_>) -> Option<Shown> {
        let shown = Shown { code: cx.display.code.clone(), ..self.what(cx)? };
        self.stop.listen(cx);
        let has_news = self.runs.listen(cx.model);
        if self.shown.as_ref() != Some(&shown) || has_news || matches!(self.known, Known::Waiting) {
            let is_same_pass =
                self.shown.as_ref().is_some_and(|s| *s == Shown { composed: s.composed, ..shown.clone() });
            let selected = self.branch().filter(|_| is_same_pass).map(|branch| branch.site);
            self.known = self.know(cx.model, &shown);
            self.selected = match &self.known {
                Known::Ray(OneRay { branches, .. }) => {
                    let same = selected.and_then(|site| branches.reached.iter().position(|b| b.site == site));
                    same.or(branches.deciding)
                }
                _ => None,
            };
            self.list(&shown, cx.model);
            self.shown = Some(shown.clone());
            if std::mem::take(&mut self.is_mask_wanted) {
                self.show_mask(cx, false);
            }
        }
        Some(shown)
    }

    /// The ray's last pass; without a ray the last pass of all, and before the first pass the next one.
    fn what(&self, cx: &Context<'_>) -> Option<Shown> {
        let model = &*cx.model;
        let row =
            model.history.as_ref().and_then(|history| Some((history.clone(), row_after_passes(history, model.place)?)));
        let of_row = row
            .as_ref()
            .and_then(|(history, row)| model.opened.as_ref()?.plan.program.kernel(history.rows.get(*row)?.kernel));
        let kernel = of_row.or(model.last_pass().map(|pass| pass.kernel)).or(model.next)?;
        let row = row.filter(|_| of_row.is_some());
        let (generation, edition) = (model.generation, model.edition);
        let element = cx.selection.pixel.filter(|_| !cx.has_rays()).zip(model.place.checked_sub(1));
        Some(Shown { generation, edition, kernel, row, element, composed: self.look.composed, code: None })
    }

    fn know(&mut self, model: &mut Model, shown: &Shown) -> Known {
        let of_row = |(history, row): &(Arc<Trace>, usize)| Some((history.pixel, history.rows.get(*row)?.pass));
        let of_element = shown.element.map(|(texel, pass)| (texel, Some(pass)));
        let Some((texel, pass)) = shown.row.as_ref().and_then(of_row).or(of_element) else {
            let opened = model.opened.clone();
            let made = opened.map(|opened| self.runs.code(model.generation, &opened, shown.kernel));
            // Without a ray, only what can never be interpreted is worth a word.
            return made.and_then(Result::err).map_or(Known::Nothing, |error| Known::Failed(error.to_string()));
        };
        let Some(pass) = pass else { return Known::Failed("the index of this pass is not known yet".into()) };
        let state = shown.row.as_ref().and_then(|(history, row)| history.rows.get(*row)).map(|row| row.after.state);
        match self.runs.branches(model, &Looked { kernel: shown.kernel, pass, texel, state }) {
            None => Known::Waiting,
            Some(Err(error)) => Known::Failed(format!("not interpreted: {error}")),
            Some(Ok(ray)) => Known::Ray(ray),
        }
    }

    /// The line of the composed source that a line of the listing is.
    fn composed_line(&self, line: usize) -> Option<usize> {
        self.placed.as_ref().map_or(Some(line), |placed| placed.get(line).copied().flatten())
    }

    /// Fills the listing, and scrolls to the branch in view.
    fn list(&mut self, shown: &Shown, model: &Model) {
        let Some(opened) = &model.opened else { return };
        let branches = match &self.known {
            Known::Ray(OneRay { branches, .. }) => Some(branches),
            _ => None,
        };
        let variant = opened.plan.variant(shown.kernel);
        let features = &opened.plan.features;
        let (mut lines, placed) = match variant {
            Some(variant) if shown.composed => (source::composed(variant), None),
            Some(variant) => {
                let placed = source::in_composed(variant, features);
                (source::kernel_files(shown.kernel, Some(variant), features), Some(placed))
            }
            None => (source::kernel_files(shown.kernel, None, features), Some(Vec::new())),
        };
        self.placed = placed;
        let there = |line: usize| self.composed_line(line);
        if let Some(branches) = branches {
            for (at, line) in lines.iter_mut().enumerate().filter(|(_, line)| line.mark == Mark::Plain) {
                line.mark = there(at).and_then(|at| branches.marks.get(at)).copied().unwrap_or_default();
            }
        }
        let reached = branches.map_or(&[][..], |branches| &branches.reached);
        let notes = (0..lines.len()).map(|at| {
            let at = there(at);
            reached.iter().filter(|branch| Some(branch.line) == at).collect::<Vec<&Branch>>()
        });
        let notes: Vec<Vec<&Branch>> = notes.collect();
        let marked = shown.code.as_ref().and_then(|name| source::function(&lines, name));
        let (heat, work) = self.heat(shown, model, lines.len(), there);
        self.listing.warm(heat);
        self.listing.charge(work);
        self.listing.set(lines, &notes);
        self.scroll();
        self.listing.mark(marked);
    }

    /// How the conditions of each line came out for all rays of the pass, and what the line took, once that is known; `there`
    /// is the line of the composed source that a line is.
    fn heat(
        &self,
        shown: &Shown,
        model: &Model,
        lines: usize,
        there: impl Fn(usize) -> Option<usize>,
    ) -> (HashMap<usize, Heat>, HashMap<usize, LineWork>) {
        let key = shown.pass().map(|pass| PassKey { generation: model.generation, edition: model.edition, pass });
        let Some(all) = self.runs.all.as_ref().filter(|all| Some(all.key) == key) else {
            return Default::default();
        };
        let heat = (0..lines).filter_map(|at| Some((at, *all.heat.get(&there(at)?)?)));
        let work = (0..lines).filter_map(|at| Some((at, *all.work.get(&there(at)?)?)));
        (heat.collect(), work.collect())
    }

    fn branch(&self) -> Option<&Branch> {
        match &self.known {
            Known::Ray(OneRay { branches, .. }) => branches.reached.get(self.selected?),
            _ => None,
        }
    }

    fn scroll(&mut self) {
        let site = self.branch().map(|branch| branch.site);
        self.listing.scroll_to(site);
    }

    /// To the next or the previous branch that the ray reached, round and round.
    fn go_on(&mut self, is_forward: bool) {
        let Known::Ray(OneRay { branches, .. }) = &self.known else { return };
        let is_listed = |index: &usize| self.listing.has(branches.reached[*index].site);
        let reached: Vec<usize> = (0..branches.reached.len()).filter(is_listed).collect();
        let here = self.selected;
        let next = if is_forward {
            reached.iter().copied().find(|&index| Some(index) > here).or(reached.first().copied())
        } else {
            let before = reached.iter().rev().copied().find(|&index| here.is_some_and(|here| index < here));
            before.or(reached.last().copied())
        };
        if next.is_some() {
            self.selected = next;
            self.scroll();
        }
    }

    /// Shows the branch's mask if all rays are known; otherwise asks for them if that is `wanted`.
    fn show_mask(&mut self, cx: &mut Context<'_>, wanted: bool) {
        let Known::Ray(OneRay { code, .. }) = &self.known else { return };
        let (Some(branch), Some(key)) = (self.branch(), self.key(cx.model)) else { return };
        if let Some(all) = self.runs.all.as_ref().filter(|all| all.key == key) {
            if all.outcomes.is_empty() {
                return;
            }
            let kernel = code.kernel().name();
            let what = format!("pass {}, {kernel}, line {}: {}", key.pass, branch.line + 1, branch.condition);
            let of = (key.generation, cx.model.place);
            let mask = Mask::new(of, what, all.size, &all.outcomes, branch.site).with_fates(all.fates.as_deref());
            cx.display.mask = Some(Arc::new(mask));
        } else if wanted && branch.site < MOST_SITES {
            let code = code.clone();
            self.runs.ask_for_all(cx.model, &code, key);
            self.is_mask_wanted = true;
        }
    }

    fn key(&self, model: &Model) -> Option<PassKey> {
        let pass = self.shown.as_ref()?.pass()?;
        Some(PassKey { generation: model.generation, edition: model.edition, pass })
    }

    fn head(&mut self, ui: &mut egui::Ui, shown: &Shown, cx: &mut Context<'_>) {
        ui.horizontal_wrapped(|ui| {
            let all = "the source given to the device: options resolved, shared functions included";
            ui.choice_of(&mut self.look.composed, true, "composed").on_hover_text(all);
            let own = "the kernel's own files, including their options (@if) and what they omit";
            ui.choice_of(&mut self.look.composed, false, "file").on_hover_text(own);
            if ui.button("Copy").on_hover_text("copy the whole source to the clipboard").clicked() {
                ui.ctx().copy_text(self.listing.text());
            }
            strong(ui, shown.kernel.name()).on_hover_text(shown.kernel.info().summary);
            self.origin(ui, shown.kernel, cx);
            if matches!(self.known, Known::Ray(_)) {
                listing::legend(ui);
            }
        });
        if let Some(error) = &cx.display.kernel_error {
            ui.colored_label(ui.visuals().error_fg_color, error);
            ui.weak("The version before it still runs.");
        }
        match shown.row.as_ref().and_then(|(history, row)| history.rows.get(*row)) {
            Some(row) => {
                let is_last = row.place() == Some(cx.model.place);
                let when = if is_last { "" } else { " (the last one of this ray so far)" };
                strong(ui, format!("pass {}{when}: {}", row.number(), row.why.clone() + &row.noted()))
                    .on_hover_text("in traced units");
            }
            None => drop(ui.weak(shown.kernel.info().summary)),
        }
        self.tell(ui, cx);
        self.stop.show(ui, cx, shown.kernel, shown.pass().or(cx.model.place.checked_sub(1)));
    }

    /// Whether the kernel is a user's, and buttons to change that.
    fn origin(&self, ui: &mut egui::Ui, kernel: Kernel, cx: &mut Context<'_>) {
        let variant = cx.model.opened.as_ref().and_then(|opened| opened.plan.variant(kernel));
        let replaced = variant.and_then(|variant| variant.replaced.clone());
        if let Some(replaced) = &replaced {
            strong(ui, format!("from {}", replaced.by.short_name())).on_hover_text(&replaced.by.file);
        }
        let is_of_program = cx.model.opened.as_ref().is_some_and(|opened| opened.settings.folder.is_some());
        if is_of_program {
            // Its files are replaced by saving them.
        } else if replaced.is_some() || cx.display.kernel_error.is_some() {
            command_button(ui, cx.asks, Command::BuiltInKernels, "built-in");
        } else {
            command_button(ui, cx.asks, Command::ReplaceKernel, "replace…");
        }
    }

    /// The branch in view, and what is not known.
    fn tell(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let Known::Ray(OneRay { branches, note, .. }) = &self.known else {
            match &self.known {
                Known::Waiting => drop(ui.weak("Reading the ray's streams before this pass…")),
                Known::Failed(why) => drop(ui.weak(why)),
                Known::Nothing | Known::Ray(_) => {}
            }
            return;
        };
        if let Some(note) = note {
            ui.colored_label(ui.visuals().warn_fg_color, *note);
        }
        let settings = cx.model.opened.as_ref().map(|opened| opened.settings.device);
        if settings == Some(DeviceKind::CpuF64) {
            ui.weak("Interpreted in f32, from this run's f64 streams rounded to f32.");
        }
        let Some((selected, branch)) = self.selected.zip(self.branch()) else { return };
        let place = format!("{} of {}", selected + 1, branches.reached.len());
        let outcome = if branch.is_taken { "taken" } else { "not taken" };
        let role = if branches.deciding == Some(selected) { ", deciding" } else { "" };
        let source = if self.listing.has(branch.site) { "" } else { " of the composed source" };
        let line = branch.line + 1;
        let text = format!("Branch {place}, {outcome}{role}: line {line}{source}: {}", branch.condition);
        ui.horizontal_wrapped(|ui| {
            for (command, text) in [(Command::PreviousBranch, "< branch"), (Command::NextBranch, "branch >")] {
                command_button(ui, cx.asks, command, text);
            }
            command_button(ui, cx.asks, Command::MaskBranch, "rays");
            ui.label(text);
        });
    }
}
