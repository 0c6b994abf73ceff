//! How kernels are mapped to a GPU: as compute shaders, or as fragment programs, as GPUs before 2006 ran them.

use crate::numbers::named::named;

/// How kernels are mapped to a GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mapping {
    /// As compute shaders, which update streams in place.
    #[default]
    Compute,
    /// As fragment programs over a quad of the image's size, which draw into streams (Purcell et al. 2002; the paper's
    /// §4).
    Fragment(Fragment),
}

impl Mapping {
    /// Its name: the value of `--mapping`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Compute => "compute",
            Self::Fragment(_) => "fragment",
        }
    }

    /// The choices of the fragment mapping; `None` for compute shaders.
    #[must_use]
    pub fn fragment(self) -> Option<Fragment> {
        match self {
            Self::Compute => None,
            Self::Fragment(fragment) => Some(fragment),
        }
    }
}

/// The choices of the fragment mapping. The default is what the paper's hardware allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Fragment {
    /// `--targets`
    pub targets: Targets,
    /// `--update`
    pub update: Update,
    /// `--cull`
    pub cull: Cull,
    /// `--until`
    pub until: Until,
}

/// How many streams a draw writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Targets {
    /// One: a kernel is drawn once for each of its output streams (the paper's §4.4.1).
    #[default]
    One,
    /// As many as the adapter allows: multiple render targets.
    Many,
}

/// How a kernel reads a stream that it also writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Update {
    /// From a copy that is made before (the paper's §4.4.2).
    #[default]
    Copy,
    /// Two textures take turns: one is read, the other is written, in every texel.
    Swap,
}

/// How a kernel avoids rays that are in none of its states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cull {
    /// Not at all: every fragment runs and writes, what it leaves unchanged too.
    None,
    /// A fragment runs, and discards itself.
    #[default]
    Discard,
    /// A depth test before the kernel: a draw turns the states into depths first.
    EarlyZ,
}

/// What ends the loops of a schedule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Until {
    /// Occlusion queries: whether the last draw of a kernel wrote any fragment.
    #[default]
    Query,
    /// The number of rays in each state, counted by a compute shader.
    Count,
}

named!(Targets, "one, many", One "one", Many "many");
named!(Update, "copy, swap", Copy "copy", Swap "swap");
named!(Cull, "none, discard, early-z", None "none", Discard "discard", EarlyZ "early-z");
named!(Until, "query, count", Query "query", Count "count");

impl Fragment {
    /// Why these choices do not go together.
    #[must_use]
    pub fn fault(&self) -> Option<&'static str> {
        if self.update == Update::Swap && self.cull != Cull::None {
            return Some("--update swap needs --cull none: a texel that a fragment discards would keep an older value");
        }
        if self.cull == Cull::None && self.until == Until::Query {
            return Some("--cull none needs --until count: every fragment writes, so that no query ever counts none");
        }
        None
    }
}
