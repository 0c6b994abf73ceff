//! Kept runs in the window: which are shown, compared and measured.

mod flip;

pub(in crate::ui) use flip::Flipped;
use flip::Textures;
use std::sync::{Arc, Weak};

use raystep_lab::Hash;
use raystep_scenes::Scene;
use smart_default::SmartDefault;

use crate::runs::differ::{Aspect, COMPARING, Differences, job};
use crate::runs::{Kept, Recipe, RunId, Runs};
use crate::session::Model;
use crate::session::request::{Opened, Request};
use crate::session_file::SessionFile;

/// The key of a comparison: both runs with the editions of their pictures, and what is compared.
pub(in crate::ui) type Question = ([(RunId, u64); 2], Aspect);

/// What a panel asks for.
pub(in crate::ui) enum Asked {
    /// Runs a kept run again.
    Again(RunId),
    /// Runs all kept runs of the open scene that have no results.
    AllAgain,
    /// Measures runs, one beside the other.
    Measure(Vec<RunId>),
    /// Opens a kept run's settings, with its edits.
    Open(RunId),
    /// Removes a run.
    Remove(RunId),
    /// Sets the budget of pictures, in bytes.
    Budget(u64),
}

/// A session whose scene is being opened.
pub(in crate::ui) struct Opening {
    /// The scene, as the host names it.
    pub(in crate::ui) scene: String,
    /// The session's file.
    pub(in crate::ui) path: String,
    pub(in crate::ui) file: SessionFile,
}

/// Kept runs, and what is done with them.
#[derive(SmartDefault)]
pub(in crate::ui) struct KeptRuns {
    pub(in crate::ui) runs: Runs,
    /// The run that others are compared with.
    pub(in crate::ui) reference: Option<RunId>,
    /// The run that is compared with it.
    pub(in crate::ui) compared: Option<RunId>,
    pub(in crate::ui) aspect: Aspect,
    #[default(crate::runs::spread::FEWEST_REPEATS)]
    pub(in crate::ui) repeats: usize,
    /// The user's notes about the session.
    pub(in crate::ui) notes: String,
    /// Requests of the panel.
    pub(in crate::ui) asked: Vec<Asked>,
    /// The comparison that was requested last.
    pub(in crate::ui) comparing: Option<Question>,
    /// The last result.
    pub(in crate::ui) found: Option<(Question, Differences)>,
    /// Whether to select the next ray that differs once it is known.
    pub(in crate::ui) wants_next: bool,
    /// The kept run that stream views show.
    pub(in crate::ui) flipped: Option<RunId>,
    pub(in crate::ui) textures: Textures,
    /// Number of measurements so far.
    pub(in crate::ui) measurements: u64,
    /// The open scene's hash, once it is known.
    pub(in crate::ui) scene: Option<(Weak<Scene>, String)>,
    /// The generation whose scene was to be identified last.
    pub(in crate::ui) identifying: u64,
    /// Whether the session is saved once the scene's hash is known.
    pub(in crate::ui) is_saving: bool,
    /// The hash that the open scene should have.
    pub(in crate::ui) expected: Option<Expected>,
    pub(in crate::ui) opening: Option<Box<Opening>>,
    /// A kept run that is being opened: its edits follow.
    pub(in crate::ui) restoring: Option<Recipe>,
}

/// The hash of the scene that a session or a link was made with.
pub(in crate::ui) struct Expected {
    pub(in crate::ui) hash: String,
    pub(in crate::ui) of: &'static str,
}

impl KeptRuns {
    /// The open scene's hash, if it is known.
    pub(in crate::ui) fn hash(&self, scene: &Arc<Scene>) -> Option<&str> {
        let (known, hash) = self.scene.as_ref()?;
        known.upgrade().is_some_and(|known| Arc::ptr_eq(&known, scene)).then_some(hash)
    }

    /// The scene that has been opened should have the hash of a link, if that has one.
    pub(in crate::ui) fn expect(&mut self, hash: Option<Hash>) {
        self.expected = hash.map(|hash| Expected { hash: hash.to_string(), of: "link" });
    }

    /// Whether a kept run is of the open scene.
    pub(in crate::ui) fn is_of(&self, kept: &Kept, opened: &Opened) -> bool {
        kept.is_of(&opened.scene, self.hash(&opened.scene))
    }

    /// The reference and the run that is compared with it.
    pub(in crate::ui) fn pair(&self) -> Option<[&Kept; 2]> {
        let [a, b] = [self.reference?, self.compared?].map(|id| self.runs.get(id));
        a.zip(b).filter(|(a, b)| a.id != b.id).map(|(a, b)| [a, b])
    }

    /// Why the pair cannot be compared ray by ray, in one sentence; `None` if it can.
    pub(in crate::ui) fn why_not_compared(&self) -> Option<String> {
        let Some([a, b]) = self.pair() else { return Some("Choose two different runs to compare.".into()) };
        if a.hash != b.hash {
            return Some(format!("{} and {} are not compared: they are of different scenes.", a.name, b.name));
        }
        if let Some(why) = a.recipe.other_rays(&b.recipe) {
            return Some(format!("{} and {} are not compared: {why}.", a.name, b.name));
        }
        let missing = [a, b].into_iter().find_map(|kept| kept.picture.as_ref().err().map(|why| (kept, why)));
        missing.map(|(kept, why)| format!("{} has no picture to compare: {why}.", kept.name))
    }

    fn question(&self) -> Option<Question> {
        let [a, b] = self.pair()?;
        self.why_not_compared().is_none().then_some(([(a.id, a.edition), (b.id, b.edition)], self.aspect))
    }

    /// How the pair differs, if that is known.
    pub(in crate::ui) fn differences(&self) -> Option<&(Question, Differences)> {
        let question = self.question()?;
        self.found.as_ref().filter(|(found, _)| *found == question)
    }

    /// Has the pair compared, unless that was done or asked for.
    pub(in crate::ui) fn compare(&mut self, model: &mut Model) {
        let Some(question) = self.question() else { return };
        if self.comparing == Some(question) || self.differences().is_some() || model.opened.is_none() {
            return;
        }
        let Some([Ok(a), Ok(b)]) = self.pair().map(|pair| pair.map(|kept| kept.picture.clone())) else { return };
        self.comparing = Some(question);
        model.ask(Request::Job(COMPARING, job(question, a, b, self.aspect)));
    }

    /// Selects a run for the comparison, if there is room for one.
    pub(in crate::ui) fn choose(&mut self, id: RunId) {
        if self.reference.is_none_or(|reference| self.runs.get(reference).is_none()) {
            self.reference = Some(id);
        } else if self.reference != Some(id) {
            self.compared = Some(id);
        }
    }

    /// Forgets a run.
    pub(in crate::ui) fn remove(&mut self, id: RunId) {
        self.runs.remove(id);
        self.textures.forget(id);
        for chosen in [&mut self.reference, &mut self.compared, &mut self.flipped] {
            *chosen = chosen.filter(|&chosen| chosen != id);
        }
    }
}
