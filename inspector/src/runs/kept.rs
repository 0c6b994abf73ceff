//! The list of kept runs, with a budget for their pictures.

use std::sync::{Arc, Weak};

use raystep_scenes::Scene;
use smart_default::SmartDefault;

use super::measure::Measured;
use super::outcome::{Outcome, Picture, Recorded};
use super::recipe::{Recipe, RunId};

/// Most runs in the list.
pub const MOST_RUNS: usize = 256;
/// Longest name, in characters.
pub const LONGEST_NAME: usize = 100;
/// Initial budget of pictures, in bytes.
pub const DEFAULT_BUDGET: u64 = 512 << 20;

/// A kept run.
pub struct Kept {
    /// Its identity.
    pub id: RunId,
    /// The user's name for it.
    pub name: String,
    /// The user's note.
    pub note: String,
    /// How to run it again.
    pub recipe: Recipe,
    /// The name by which its scene was opened; empty for a scene without a file.
    pub path: String,
    /// The hash of its scene.
    pub hash: String,
    /// Its scene, while that is open.
    pub scene: Weak<Scene>,
    /// What it came to; `None` until it was run again.
    pub outcome: Option<Arc<Outcome>>,
    /// Its picture, or why there is none.
    pub picture: Result<Arc<Picture>, String>,
    /// Incremented with every picture.
    pub edition: u64,
    /// How long it takes, if that was measured.
    pub measured: Option<Arc<Measured>>,
}

impl Kept {
    /// Bytes that count against the budget.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let outcome = self.outcome.as_ref().map_or(0, |outcome| outcome.bytes());
        outcome + self.picture.as_ref().map_or(0, |picture| picture.bytes())
    }

    /// Whether it is of this scene.
    #[must_use]
    pub fn is_of(&self, scene: &Arc<Scene>, hash: Option<&str>) -> bool {
        self.scene.upgrade().is_some_and(|own| Arc::ptr_eq(&own, scene)) || hash == Some(&self.hash)
    }
}

/// Why a run of a session file has no picture yet.
pub const NOT_RUN: &str = "not run since the session was opened";

/// The kept runs, oldest first.
#[derive(SmartDefault)]
pub struct Runs {
    list: Vec<Kept>,
    #[default(1)]
    next: RunId,
    #[default(DEFAULT_BUDGET)]
    budget: u64,
}

impl Runs {
    /// All runs, oldest first.
    #[must_use]
    pub fn list(&self) -> &[Kept] {
        &self.list
    }

    /// A run.
    #[must_use]
    pub fn get(&self, id: RunId) -> Option<&Kept> {
        self.list.iter().find(|kept| kept.id == id)
    }

    /// A run, for changing its name, its note or its times.
    pub fn get_mut(&mut self, id: RunId) -> Option<&mut Kept> {
        self.list.iter_mut().find(|kept| kept.id == id)
    }

    /// The budget of pictures in bytes.
    #[must_use]
    pub fn budget(&self) -> u64 {
        self.budget
    }

    /// Bytes that all runs take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.list.iter().map(Kept::bytes).sum()
    }

    /// Adds a run that has not been run yet, and returns its identity. `None` if the list is full.
    pub fn add(&mut self, name: &str, recipe: Recipe, path: String, hash: String) -> Option<RunId> {
        if self.list.len() >= MOST_RUNS {
            return None;
        }
        let id = self.next;
        self.next += 1;
        self.list.push(Kept {
            id,
            name: self.unused(name),
            note: String::new(),
            recipe,
            path,
            hash,
            scene: Weak::new(),
            outcome: None,
            picture: Err(NOT_RUN.into()),
            edition: 0,
            measured: None,
        });
        Some(id)
    }

    /// Sets what a run came to. Returns the names of the runs whose pictures were dropped to stay within the budget.
    pub fn set(&mut self, id: RunId, recorded: Recorded) -> Vec<String> {
        let Some(kept) = self.get_mut(id) else { return Vec::new() };
        (kept.scene, kept.hash) = (Arc::downgrade(&recorded.scene), recorded.hash);
        kept.outcome = Some(Arc::new(recorded.outcome));
        kept.picture = recorded.picture.map(Arc::new);
        kept.edition += 1;
        self.thin(Some(id))
    }

    /// Sets the budget. Returns the names of the runs whose pictures were dropped.
    pub fn set_budget(&mut self, bytes: u64) -> Vec<String> {
        self.budget = bytes;
        self.thin(None)
    }

    /// Removes a run.
    pub fn remove(&mut self, id: RunId) {
        self.list.retain(|kept| kept.id != id);
    }

    /// Removes all runs.
    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// Drops the oldest pictures, and last of all that of `newest`.
    fn thin(&mut self, newest: Option<RunId>) -> Vec<String> {
        let mut dropped = Vec::new();
        while self.bytes() > self.budget {
            let has_picture = |kept: &&mut Kept| kept.picture.is_ok();
            let oldest = self.list.iter_mut().filter(has_picture).min_by_key(|kept| (Some(kept.id) == newest, kept.id));
            let Some(kept) = oldest else { break };
            kept.picture = Err("dropped to stay within the budget".into());
            dropped.push(kept.name.clone());
        }
        dropped
    }

    /// The name, with a number if another run has it already.
    fn unused(&self, name: &str) -> String {
        let name: String = name.chars().take(LONGEST_NAME).collect();
        let is_used = |name: &str| self.list.iter().any(|kept| kept.name == name);
        let numbered = (2..).map(|n| format!("{name} {n}"));
        std::iter::once(name.clone()).chain(numbered).find(|name| !is_used(name)).unwrap_or(name)
    }
}

#[cfg(test)]
mod tests {
    use raystep_scenes::generate::cornell_box;

    use super::*;
    use crate::ray_text::GivenRay;
    use crate::runs::outcome::tests::picture;
    use crate::settings::{DeviceKind, Settings};

    fn recipe() -> Recipe {
        Recipe { settings: Settings { size: [8, 8], ..Settings::default() }, edits: Vec::new(), twins: None }
    }

    /// Adds a run with a picture; returns the names of those whose pictures were dropped.
    fn keep(runs: &mut Runs) -> Vec<String> {
        let scene = cornell_box();
        let id = runs.add("run", recipe(), String::new(), "hash".into()).expect("room");
        let outcome = Outcome { passes: Vec::new(), rays: 64, hits: None, device: String::new(), why_no_times: None };
        let picture = Ok(picture(&scene, &recipe().settings));
        let (scene, hash, recipe) = (Arc::new(scene), "hash".into(), recipe());
        runs.set(id, Recorded { again: None, recipe, scene, hash, outcome, picture })
    }

    #[test]
    fn the_oldest_pictures_are_dropped_and_that_is_told() {
        let mut runs = Runs::default();
        assert!(keep(&mut runs).is_empty() && keep(&mut runs).is_empty());
        let each = runs.bytes() / 2;
        assert_eq!(each, 64 * 4 * 13);
        runs.set_budget(2 * each + each / 2);
        assert_eq!(keep(&mut runs), ["run"]);
        let has_picture = |runs: &Runs| runs.list().iter().map(|kept| kept.picture.is_ok()).collect::<Vec<_>>();
        assert_eq!(has_picture(&runs), [false, true, true]);
        assert!(runs.list()[0].outcome.is_some() && runs.bytes() <= runs.budget());
        assert_eq!(runs.set_budget(0), ["run 2", "run 3"]);
        assert_eq!((runs.bytes(), runs.list().len()), (0, 3));
        // Run again, the first is the newest.
        runs.set_budget(each);
        let (scene, hash) = (Arc::new(cornell_box()), "hash".into());
        let outcome = Outcome { passes: Vec::new(), rays: 64, hits: None, device: String::new(), why_no_times: None };
        let picture = Ok(picture(&scene, &recipe().settings));
        let id = runs.list()[0].id;
        let recorded = Recorded { again: Some(id), recipe: recipe(), scene, hash, outcome, picture };
        assert!(runs.set(id, recorded).is_empty());
        assert_eq!(has_picture(&runs), [true, false, false]);
    }

    #[test]
    fn names_of_kept_runs_are_distinct_and_their_number_is_limited() {
        let mut runs = Runs::default();
        let long = "x".repeat(1000);
        for name in ["a", "a", "a 2", &long] {
            runs.add(name, recipe(), String::new(), String::new());
        }
        let names: Vec<&str> = runs.list().iter().map(|kept| kept.name.as_str()).collect();
        assert_eq!(names[..3], ["a", "a 2", "a 2 2"]);
        assert_eq!(names[3].len(), LONGEST_NAME);
        while runs.add("b", recipe(), String::new(), String::new()).is_some() {}
        assert_eq!(runs.list().len(), MOST_RUNS);
    }

    #[test]
    fn rays_are_the_same_where_view_size_and_samples_are() {
        let of = |change: fn(&mut Settings)| {
            let mut other = recipe();
            change(&mut other.settings);
            recipe().other_rays(&other)
        };
        assert_eq!(
            of(|s| (s.choices.accelerator, s.device) = (raystep_kernels::Accelerator::Bvh, DeviceKind::CpuF64)),
            None
        );
        assert_eq!(of(|s| s.size = [8, 9]), Some("they have different sizes"));
        assert_eq!(of(|s| s.view = crate::settings::View::Scene(1)), Some("they have different views"));
        assert_eq!(of(|s| s.ray = Some(GivenRay([0.0; 6]))), Some("they have different views"));
        assert_eq!(of(|s| s.choices.samples.count = 2), Some("they have different samples"));
    }
}
