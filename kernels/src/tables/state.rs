//! States of a program's elements: the tags in the program's stream of states.
//!
//! The kernels' rows say which kernel moves an element from one state to the next. The tags become constants of the
//! WGSL module `package::state`, generated from the table, so shaders and CPU reference kernels cannot disagree.

/// A state: the value in layer [`STATE_TAG`](super::stream::STATE_TAG) of the stream of states.
pub type Tag = u32;

/// Most states of a program: the GPU's counters of each pass have room for this many.
pub const COUNT: usize = 8;

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
pub type StateCounts = [u32; COUNT];

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
        self.iter().map(|StateInfo { tag, name, .. }| format!("const {name}: u32 = {tag}u;\n")).collect()
    }
}

fn sum(counts: &StateCounts, is_counted: impl Fn(Tag) -> bool) -> u64 {
    (0..).zip(counts).filter(|&(tag, _)| is_counted(tag)).map(|(_, &rays)| u64::from(rays)).sum()
}
