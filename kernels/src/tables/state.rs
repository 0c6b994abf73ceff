//! Where an element is in a program: the tags of the program's stream of states.
//!
//! Which kernel moves an element from one to the next is in the kernels' rows. The tags become constants of the WGSL
//! module `package::state`, made from the table, so shaders and CPU reference kernels cannot disagree.

/// A state: what layer [`STATE_TAG`](super::stream::STATE_TAG) of the stream of states holds.
pub type Tag = u32;

/// Most states of a program: what the GPU counts for each pass has room for so many.
pub const COUNT: usize = 8;

/// Where a state lies in an element's course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateRole {
    /// There is no ray yet.
    Unborn,
    /// The ray is on its way; what it hits is not known.
    Active,
    /// What it hits is known, its result is not.
    Resolved,
    /// Its result is known.
    Finished,
}

/// A row of a program's table of states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateInfo {
    /// Which state: its place in the table.
    pub tag: Tag,
    /// Its name in WGSL and in reports.
    pub name: &'static str,
    /// Where it lies in an element's course.
    pub role: StateRole,
    /// Its colour in every diagram, sRGB.
    pub colour: [u8; 3],
    /// What an element does there, for people.
    pub meaning: &'static str,
}

/// How many elements are in each state, indexed by tag.
pub type StateCounts = [u32; COUNT];

/// A program's states.
#[derive(Clone, Copy, Debug)]
pub struct States(pub &'static [StateInfo]);

impl States {
    /// Every state.
    pub fn iter(self) -> impl Iterator<Item = &'static StateInfo> {
        self.0.iter()
    }

    /// The name of a tag, or `"?"` for a value that is none.
    #[must_use]
    pub fn name(self, tag: Tag) -> &'static str {
        self.0.get(tag as usize).map_or("?", |state| state.name)
    }

    /// Where a tag lies in an element's course; `None` for a value that is none.
    #[must_use]
    pub fn role(self, tag: Tag) -> Option<StateRole> {
        self.0.get(tag as usize).map(|state| state.role)
    }

    /// Whether a ray in this state may still hit something, or something else.
    #[must_use]
    pub fn is_walking(self, tag: Tag) -> bool {
        self.role(tag) == Some(StateRole::Active)
    }

    /// Whether a ray in this state will hit nothing else any more.
    #[must_use]
    pub fn is_decided(self, tag: Tag) -> bool {
        matches!(self.role(tag), Some(StateRole::Resolved | StateRole::Finished))
    }

    /// Rays whose hit is decided.
    #[must_use]
    pub fn decided(self, counts: &StateCounts) -> u64 {
        sum(counts, |tag| self.is_decided(tag))
    }

    /// Rays that still walk.
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
