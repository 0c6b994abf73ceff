//! How kernels are mapped to a GPU: as compute shaders, or as fragment programs, as GPUs before 2006 ran them.

use std::fmt;
use std::str::FromStr;

use super::ScheduleKind;
use crate::numbers::named::{ParseOptionError, named};

/// How kernels are mapped to a GPU, without the choices of a mapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MappingName {
    /// As compute shaders.
    #[default]
    Compute,
    /// As fragment programs.
    Fragment,
}

/// How kernels are mapped to a GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    pub fn name(self) -> MappingName {
        match self {
            Self::Compute => MappingName::Compute,
            Self::Fragment(_) => MappingName::Fragment,
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// `compute`; or `fragment`, and after each `+` a choice that differs from what goes with the others:
/// `fragment+many+early-z`.
impl fmt::Display for Mapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Fragment(how) = *self else { return f.write_str("compute") };
        let implied = Fragment::of(None, Some(how.update), None, None);
        let until = Fragment::of(None, None, Some(how.cull), None).until;
        f.write_str("fragment")?;
        for (name, is_implied) in [
            (how.targets.name(), how.targets == Targets::default()),
            (how.update.name(), how.update == Update::default()),
            (how.cull.name(), how.cull == implied.cull),
            (how.until.name(), how.until == until),
        ] {
            if !is_implied {
                write!(f, "+{name}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Mapping {
    type Err = ParseOptionError;

    fn from_str(text: &str) -> Result<Self, ParseOptionError> {
        const EXPECTED: &str = "compute, or fragment with choices that go together, such as fragment+many+early-z";
        let wrong = || ParseOptionError::new(text, EXPECTED);
        let mut names = text.split('+');
        match names.next().map(MappingName::from_str) {
            Some(Ok(MappingName::Fragment)) => {}
            Some(Ok(MappingName::Compute)) if text == "compute" => return Ok(Self::Compute),
            _ => return Err(wrong()),
        }
        let (mut targets, mut update, mut cull, mut until) = (None, None, None, None);
        for name in names {
            // A choice is made once.
            let is_new = match (name.parse(), name.parse(), name.parse(), name.parse()) {
                (Ok(choice), ..) => targets.replace(choice).is_none(),
                (_, Ok(choice), ..) => update.replace(choice).is_none(),
                (_, _, Ok(choice), _) => cull.replace(choice).is_none(),
                (.., Ok(choice)) => until.replace(choice).is_none(),
                _ => false,
            };
            if !is_new {
                return Err(wrong());
            }
        }
        let how = Fragment::of(targets, update, cull, until);
        if how.fault().is_some() { Err(wrong()) } else { Ok(Self::Fragment(how)) }
    }
}

named!(MappingName, "compute, fragment", Compute "compute", Fragment "fragment");
named!(Targets, "one, many", One "one", Many "many");
named!(Update, "copy, swap", Copy "copy", Swap "swap");
named!(Cull, "none, discard, early-z", None "none", Discard "discard", EarlyZ "early-z");
named!(Until, "query, count", Query "query", Count "count");

/// Why fragment programs cannot run on the CPU.
pub const NO_GPU: &str = "--mapping fragment draws on a GPU: use --device gpu, which may be a software driver";

/// What an adapter without compute shaders can run.
pub const ONLY_DRAWS: &str = "this adapter has no compute shaders and no storage buffers: use --mapping fragment \
                              --scene-data textures --schedule second, without --until count";

/// Why fragment programs cannot average samples.
pub const ONE_SAMPLE: &str =
    "--mapping fragment takes one sample per pixel: a mean of samples does not fit a texel with four components";

/// Why fragment programs cannot follow a schedule.
#[must_use]
pub fn fault_of(schedule: ScheduleKind) -> Option<&'static str> {
    match schedule {
        ScheduleKind::First | ScheduleKind::Second => None,
        ScheduleKind::Compact => {
            Some("--mapping fragment has no lists of live rays: use --schedule second or first, not compact")
        }
        ScheduleKind::Fused => {
            Some("--mapping fragment is for kernels that take one step: use --schedule second or first, not fused")
        }
    }
}

impl Fragment {
    /// These choices, and for the others what goes with them, or the default.
    #[must_use]
    pub fn of(targets: Option<Targets>, update: Option<Update>, cull: Option<Cull>, until: Option<Until>) -> Self {
        let update = update.unwrap_or_default();
        let cull = cull.unwrap_or(if update == Update::Swap { Cull::None } else { Cull::default() });
        let until = until.unwrap_or(if cull == Cull::None { Until::Count } else { Until::default() });
        Self { targets: targets.unwrap_or_default(), update, cull, until }
    }

    /// All choices that go together.
    pub fn all() -> impl Iterator<Item = Self> {
        let targets = Targets::ALL.iter().map(|&targets| Self { targets, ..Self::default() });
        let updates = targets.flat_map(|how| Update::ALL.iter().map(move |&update| Self { update, ..how }));
        let culls = updates.flat_map(|how| Cull::ALL.iter().map(move |&cull| Self { cull, ..how }));
        let all = culls.flat_map(|how| Until::ALL.iter().map(move |&until| Self { until, ..how }));
        all.filter(|how| how.fault().is_none())
    }

    /// The choice that is at fault if some do not go together.
    pub(super) fn faulty(&self) -> &'static str {
        if self.update == Update::Swap && self.cull != Cull::None { "update" } else { "until" }
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mapping_comes_back_from_its_text() {
        let all: Vec<Mapping> =
            std::iter::once(Mapping::Compute).chain(Fragment::all().map(Mapping::Fragment)).collect();
        for mapping in &all {
            assert_eq!(mapping.to_string().parse(), Ok(*mapping), "{mapping}");
        }
        let texts: std::collections::BTreeSet<String> = all.iter().map(Mapping::to_string).collect();
        assert_eq!(texts.len(), all.len());
        assert_eq!(Mapping::Fragment(Fragment::default()).to_string(), "fragment");
        let swap = Fragment::of(None, Some(Update::Swap), None, None);
        assert_eq!(Mapping::Fragment(swap).to_string(), "fragment+swap");
        for wrong in
            ["", "fragment+", "compute+many", "fragment+many+one", "fragment+swap+discard", "fragment+none+query"]
        {
            assert!(wrong.parse::<Mapping>().is_err(), "{wrong}");
        }
    }
}
