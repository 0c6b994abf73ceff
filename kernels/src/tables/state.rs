//! States of a program's elements: the tags in the program's stream of states.
//!
//! The kernels' rows say which kernel moves an element from one state to the next. The tags become constants of the
//! WGSL module `package::state`, generated from the table, so shaders and CPU reference kernels cannot disagree.

use std::ops::{Deref, DerefMut};

use super::elements::Elements;

/// A state: the value in layer [`STATE_TAG`](super::stream::STATE_TAG) of the stream of states.
pub type Tag = u32;

/// Most states of a program: the GPU's counters of each pass have room for this many, and for nine more words, which tell of
/// loops without end and of assertions that do not hold.
pub const MOST_STATES: usize = 55;

/// Most lists of a program: the GPU's bind groups are kept by a bit for each.
pub const MOST_LISTS: usize = 64;

/// How far an element in a state has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateRole {
    /// The ray has not been generated.
    Unborn,
    /// The ray is active: its hit is not known.
    Active,
    /// Its hit is known, its result is not.
    Resolved,
    /// Its result is known.
    Finished,
}

/// A row of a program's table of states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateInfo {
    /// The state: its index in the table.
    pub tag: Tag,
    /// Its name in WGSL and in reports.
    pub name: &'static str,
    /// How far an element in this state has got.
    pub role: StateRole,
    /// Its colour in all diagrams, sRGB.
    pub colour: [u8; 3],
    /// What an element in this state does, for people.
    pub meaning: &'static str,
}

/// Number of elements in each state, indexed by tag.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StateCounts(Vec<u32>);

impl StateCounts {
    /// No elements, in a program with these states.
    #[must_use]
    pub fn none(states: States) -> Self {
        Self(vec![0; states.0.len()])
    }

    /// Adds elements to a state. A value that is not a tag has no count.
    pub fn add(&mut self, tag: Tag, elements: u32) {
        if let Some(count) = self.0.get_mut(tag as usize) {
            *count += elements;
        }
    }

    /// Sets the number of elements in these states to 0.
    pub fn clear(&mut self, tags: impl IntoIterator<Item = Tag>) {
        for tag in tags {
            self.0.get_mut(tag as usize).into_iter().for_each(|count| *count = 0);
        }
    }

    /// Number of elements in these states.
    #[must_use]
    pub fn in_any(&self, tags: &[Tag]) -> u32 {
        tags.iter().filter_map(|&tag| self.0.get(tag as usize)).sum()
    }
}

/// How many elements a run has between two passes: what its schedule goes by.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Population {
    /// Number of elements in each state.
    pub in_state: StateCounts,
    /// The program's sets.
    pub sets: &'static [&'static Elements],
    /// Number of elements in each of them; 0 in one that has not been counted.
    pub in_set: Vec<u32>,
}

impl Population {
    /// Number of elements in a set.
    #[must_use]
    pub fn of(&self, elements: &Elements) -> u32 {
        let of = self.sets.iter().zip(&self.in_set).find(|(set, _)| set.name == elements.name);
        of.map_or(0, |(_, &count)| count)
    }

    /// How many elements are in which states, or in which sets if none has states.
    #[must_use]
    pub fn told(&self, states: States) -> String {
        let in_states = (0..).zip(&self.in_state.0).map(|(tag, &count)| (states.name(tag), count));
        let in_sets = self.sets.iter().map(|set| set.name).zip(self.in_set.iter().copied());
        let told = |all: Vec<(&str, u32)>| {
            let some = all.into_iter().filter(|(_, count)| *count > 0);
            some.map(|(name, count)| format!("{count} in {name}")).collect::<Vec<_>>().join(", ")
        };
        let text = told(in_states.collect());
        format!("with {}", if text.is_empty() { told(in_sets.collect()) } else { text })
    }
}

impl From<StateCounts> for Population {
    fn from(in_state: StateCounts) -> Self {
        Self { in_state, ..Self::default() }
    }
}

impl<'a> IntoIterator for &'a StateCounts {
    type Item = &'a u32;
    type IntoIter = std::slice::Iter<'a, u32>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl FromIterator<u32> for StateCounts {
    fn from_iter<I: IntoIterator<Item = u32>>(counts: I) -> Self {
        Self(counts.into_iter().collect())
    }
}

impl Deref for StateCounts {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.0
    }
}

impl DerefMut for StateCounts {
    fn deref_mut(&mut self) -> &mut [u32] {
        &mut self.0
    }
}

/// A program's states.
#[derive(Clone, Copy, Debug)]
pub struct States(pub &'static [StateInfo]);

impl States {
    /// Every state.
    pub fn iter(self) -> impl Iterator<Item = &'static StateInfo> {
        self.0.iter()
    }

    /// The name of a tag, or `"?"` for a value that is not a tag.
    #[must_use]
    pub fn name(self, tag: Tag) -> &'static str {
        self.0.get(tag as usize).map_or("?", |state| state.name)
    }

    /// The tag of the state with this name.
    #[must_use]
    pub fn tag(self, name: &str) -> Option<Tag> {
        self.iter().find(|state| state.name == name).map(|state| state.tag)
    }

    /// How far an element with a tag has got; `None` for a value that is not a tag.
    #[must_use]
    pub fn role(self, tag: Tag) -> Option<StateRole> {
        self.0.get(tag as usize).map(|state| state.role)
    }

    /// Whether a ray in this state may still find a hit, or a nearer one.
    #[must_use]
    pub fn is_walking(self, tag: Tag) -> bool {
        self.role(tag) == Some(StateRole::Active)
    }

    /// Whether the hit of a ray in this state is final.
    #[must_use]
    pub fn is_decided(self, tag: Tag) -> bool {
        matches!(self.role(tag), Some(StateRole::Resolved | StateRole::Finished))
    }

    /// Number of rays whose hit is decided.
    #[must_use]
    pub fn decided(self, counts: &StateCounts) -> u64 {
        sum(counts, |tag| self.is_decided(tag))
    }

    /// Number of rays that are still walking.
    #[must_use]
    pub fn walking(self, counts: &StateCounts) -> u64 {
        sum(counts, |tag| self.is_walking(tag))
    }

    /// The WGSL module `package::state`.
    #[must_use]
    pub fn wgsl_module(self) -> String {
        let tags = self.iter().map(|StateInfo { tag, name, .. }| format!("const {name}: u32 = {tag}u;\n"));
        tags.chain([format!("const STATES: u32 = {}u;\n", self.0.len())]).collect()
    }
}

fn sum(counts: &StateCounts, is_counted: impl Fn(Tag) -> bool) -> u64 {
    (0..).zip(counts.iter()).filter(|&(tag, _)| is_counted(tag)).map(|(_, &rays)| u64::from(rays)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_population_is_told_by_its_states() {
        let state = |tag, name| StateInfo { tag, name, role: StateRole::Active, colour: [0; 3], meaning: "" };
        let states = States(Vec::leak(vec![state(0, "WARM"), state(1, "HOT"), state(2, "STILL")]));
        let mut in_state = StateCounts::none(states);
        in_state.add(0, 3);
        in_state.add(2, 61);
        assert_eq!(Population::from(in_state).told(states), "with 3 in WARM, 61 in STILL");
    }
}
