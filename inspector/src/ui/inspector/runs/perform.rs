//! What commands and the panel do with kept runs.

use raystep_lab::text::counted;

use crate::runs::differ::{COMPARING, Differences};
use crate::runs::kept::MOST_RUNS;
use crate::runs::measure::{MEASURING, Measured, Subject, measure};
use crate::runs::outcome::{KEEPING, Recorded, again, keep};
use crate::runs::{Kept, RunId};
use crate::session::request::Request;
use crate::ui::inspector::Inspector;
use crate::ui::state::kept_runs::{Asked, Question};

/// The job that restores edits of a session.
pub(super) const RESTORING: &str = "restoring edits";

impl Inspector {
    /// Keeps the open run: completes it if necessary, and returns.
    pub(in crate::ui) fn keep_run(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        let known = self.state.runs.hash(&opened.scene).map(str::to_owned);
        let most = self.state.runs.runs.budget();
        self.model.ask(Request::Job(KEEPING, keep(known, most)));
    }

    /// Shows the next kept run in stream views, or the one before.
    pub(in crate::ui) fn flip(&mut self, is_forward: bool) {
        let Some(opened) = &self.model.opened else { return };
        let (was_open_run, left_out) = (self.state.runs.flipped().is_none(), self.state.runs.left_out(opened));
        match (self.state.runs.flip(is_forward, opened), left_out) {
            (Err(why), _) => self.state.log.warn(why),
            (Ok(()), Some(runs)) if was_open_run => {
                self.state.log.tell(format!("{runs} left out: of another scene or size, or without a picture"));
            }
            (Ok(()), _) => {}
        }
    }

    /// Selects the next ray in which the compared runs differ, once it is known.
    pub(in crate::ui) fn next_differing(&mut self) {
        match self.state.runs.why_not_compared() {
            Some(why) => self.state.log.warn(why),
            None => self.state.runs.wants_next = true,
        }
    }

    /// Takes answers about kept runs, and performs what the panel asks for.
    pub(in crate::ui) fn serve_runs(&mut self) {
        while let Some(recorded) = self.model.take_answer::<Recorded>(KEEPING) {
            self.recorded(*recorded);
        }
        while let Some(times) = self.model.take_answer::<Vec<(RunId, Measured)>>(MEASURING) {
            for (id, measured) in *times {
                if let Some(kept) = self.state.runs.runs.get_mut(id) {
                    kept.measured = Some(std::sync::Arc::new(measured));
                }
            }
        }
        while let Some(found) = self.model.take_answer::<(Question, Differences)>(COMPARING) {
            self.state.runs.found = Some(*found);
        }
        while self.model.take_answer::<()>(RESTORING).is_some() {}
        self.identified();
        if self.state.runs.wants_next {
            self.go_to_next_differing();
        }
        for asked in std::mem::take(&mut self.state.runs.asked) {
            self.perform_asked(asked);
        }
        if !self.model.is_busy() {
            // A session whose scene could not be opened leaves no state behind.
            (self.state.runs.opening, self.state.runs.restoring) = (None, None);
        }
    }

    /// A run was recorded: a new one, or one that was run again.
    fn recorded(&mut self, recorded: Recorded) {
        let (path, kept) = (self.scene.path.clone().unwrap_or_default(), &mut self.state.runs);
        kept.scene = Some((std::sync::Arc::downgrade(&recorded.scene), recorded.hash.clone()));
        let name = recorded.recipe.name();
        let id = match recorded.again {
            Some(id) => Some(id),
            None => kept.runs.add(&name, recorded.recipe.clone(), path, recorded.hash.clone()),
        };
        let Some(id) = id else {
            self.fail(format!("{} are kept already: remove one first", counted(MOST_RUNS, "run")));
            return;
        };
        let (is_new, why) = (recorded.again.is_none(), recorded.picture.as_ref().err().cloned());
        kept.textures.forget(id);
        let dropped = kept.runs.set(id, recorded);
        if is_new {
            kept.choose(id);
        }
        let (count, name) = (kept.runs.list().len(), kept.runs.get(id).map_or(name, |kept| kept.name.clone()));
        if is_new {
            let kept = counted(count, "kept run");
            self.note(format!("kept as \"{name}\": {kept} in the panel Runs; press . or , to flip through them"));
        } else {
            // The table shows it.
            self.state.log.say(false, format!("\"{name}\" was run again"));
        }
        if let Some(why) = why {
            self.note(format!("\"{name}\" has no picture: {why}"));
        }
        self.tell_dropped(&dropped);
    }

    fn tell_dropped(&mut self, dropped: &[String]) {
        if !dropped.is_empty() {
            let names = dropped.join(", ");
            let budget = raystep_kernels::plan::Bytes(self.state.runs.runs.budget());
            self.note(format!("pictures of {names} dropped to stay within {budget}: run them again to see them"));
        }
    }

    fn go_to_next_differing(&mut self) {
        let runs = &mut self.state.runs;
        runs.compare(&mut self.model);
        let Some((_, found)) = runs.differences() else {
            // The comparison was cancelled, or failed.
            runs.wants_next = self.model.is_busy();
            return;
        };
        let (next, count) = (found.next(self.state.selection.pixel), found.rays.len());
        runs.wants_next = false;
        let what = runs.aspect.name();
        match next {
            Some([x, y]) => {
                let at = found_index(runs.differences().map(|(_, found)| found), [x, y]);
                self.state.asks.select = Some([x, y]);
                self.state.log.tell(format!("ray {x},{y}: {at} of {count} that differ in {what}"));
            }
            None => self.state.log.tell(format!("no ray differs in {what}")),
        }
    }

    fn perform_asked(&mut self, asked: Asked) {
        match asked {
            Asked::Remove(id) => self.state.runs.remove(id),
            Asked::Budget(bytes) => {
                let dropped = self.state.runs.runs.set_budget(bytes);
                self.tell_dropped(&dropped);
            }
            Asked::AllAgain => {
                let Some(opened) = &self.model.opened else { return };
                let runs = &self.state.runs;
                let is_wanted = |kept: &&Kept| kept.outcome.is_none() && runs.is_of(kept, opened);
                let ids: Vec<RunId> = runs.runs.list().iter().filter(is_wanted).map(|kept| kept.id).collect();
                if ids.is_empty() {
                    self.state.log.warn("all kept runs of this scene have their results");
                }
                ids.into_iter().for_each(|id| self.perform_asked(Asked::Again(id)));
            }
            Asked::Again(id) => {
                let Some(kept) = self.of_open_scene(id) else { return };
                let recipe = self.state.runs.runs.get(kept).map(|kept| kept.recipe.clone());
                let Some(recipe) = recipe else { return };
                let (device, clock) = (self.devices.of(recipe.settings.device), self.devices.clock);
                let most = self.state.runs.runs.budget();
                self.model.ask(Request::Job(KEEPING, again(id, recipe, device, clock, most)));
            }
            Asked::Measure(ids) => {
                let ids: Vec<RunId> = ids.into_iter().filter_map(|id| self.of_open_scene(id)).collect();
                let runs = &self.state.runs.runs;
                let subject = |id: &RunId| {
                    let recipe = runs.get(*id)?.recipe.clone();
                    Some(Subject { id: *id, device: self.devices.of(recipe.settings.device), recipe })
                };
                let subjects: Vec<Subject> = ids.iter().filter_map(subject).collect();
                if subjects.is_empty() {
                    return;
                }
                self.state.runs.measurements += 1;
                let (repeats, together) = (self.state.runs.repeats, self.state.runs.measurements);
                self.model.ask(Request::Job(MEASURING, measure(subjects, repeats, together, self.devices.clock)));
            }
            Asked::Open(id) => {
                let Some(id) = self.of_open_scene(id) else { return };
                let Some(recipe) = self.state.runs.runs.get(id).map(|kept| kept.recipe.clone()) else { return };
                self.model.ask(Request::Plan(Box::new(recipe.settings.clone())));
                self.state.runs.restoring = Some(recipe);
                self.state.runs.flipped = None;
            }
        }
    }

    /// The run, if it is of the open scene; otherwise that is said.
    fn of_open_scene(&mut self, id: RunId) -> Option<RunId> {
        let (runs, opened) = (&self.state.runs, self.model.opened.as_ref()?);
        let kept = runs.runs.get(id)?;
        if runs.is_of(kept, opened) {
            return Some(id);
        }
        let text = format!("\"{}\" is a run of another scene: open {} to run it again", kept.name, kept.path);
        self.state.log.warn(text);
        None
    }
}

/// The number of a ray among those that differ, from 1.
fn found_index(found: Option<&Differences>, [x, y]: [u32; 2]) -> usize {
    found.map_or(0, |found| found.rays.partition_point(|&ray| ray < y * found.size[0] + x) + 1)
}
