//! The options of how kernels are mapped to a GPU.

use clap::Args;
use raystep_kernels::ScheduleKind;
use raystep_kernels::options::mapping::{self, Cull, Fragment, Mapping, MappingName, Targets, Until, Update};

use crate::args::{DeviceArgs, DeviceKind, named};
use crate::error::Error;

/// How kernels are mapped to a GPU.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Tracing")]
pub(crate) struct MappingArgs {
    /// How kernels run on a GPU: as compute shaders (compute), or as fragment programs that draw into streams, as on GPUs
    /// before 2006 (fragment); fragment takes --schedule second or first
    #[arg(long, default_value = "compute", value_parser = named(MappingName::ALL, MappingName::name))]
    pub(crate) mapping: MappingName,
    /// Streams that a draw writes: one, so that a kernel is drawn once for each of its outputs, or as many as the adapter
    /// allows (many) [default: one]
    #[arg(long, value_parser = named(Targets::ALL, Targets::name))]
    pub(crate) targets: Option<Targets>,
    /// How a kernel reads a stream that it also writes: from a copy made before (copy), or from one of two textures that
    /// take turns (swap) [default: copy]
    #[arg(long, value_parser = named(Update::ALL, Update::name))]
    pub(crate) update: Option<Update>,
    /// How a kernel avoids rays in other states: not at all, so that every fragment runs and writes (none); each fragment
    /// runs, and discards itself (discard); or a depth test excludes it first (early-z) [default: discard; none with
    /// --update swap]
    #[arg(long, value_parser = named(Cull::ALL, Cull::name))]
    pub(crate) cull: Option<Cull>,
    /// What ends the loops of the schedule: occlusion queries (query), or the numbers of rays in each state, counted by a
    /// compute shader (count) [default: query; count with --cull none]
    #[arg(long, value_parser = named(Until::ALL, Until::name))]
    pub(crate) until: Option<Until>,
}

impl From<Mapping> for MappingArgs {
    fn from(mapping: Mapping) -> Self {
        let Some(Fragment { targets, update, cull, until }) = mapping.fragment() else { return Self::default() };
        Self {
            mapping: MappingName::Fragment,
            targets: Some(targets),
            update: Some(update),
            cull: Some(cull),
            until: Some(until),
        }
    }
}

impl MappingArgs {
    /// Whether kernels are drawn.
    pub(crate) fn is_fragment(self) -> bool {
        self.mapping == MappingName::Fragment
    }

    /// The mapping, with what follows from the choices that were made.
    pub(crate) fn mapping(self) -> Mapping {
        let Self { targets, update, cull, until, .. } = self;
        match self.mapping {
            MappingName::Compute => Mapping::Compute,
            MappingName::Fragment => Mapping::Fragment(Fragment::of(targets, update, cull, until)),
        }
    }

    /// Refuses options that would have no effect, and what does not go together.
    pub(crate) fn check(self, schedule: ScheduleKind, device: DeviceKind) -> Result<(), Error> {
        let Self { targets, update, cull, until, .. } = self;
        let given = [
            ("--targets", targets.is_some()),
            ("--update", update.is_some()),
            ("--cull", cull.is_some()),
            ("--until", until.is_some()),
        ];
        if let Some((option, _)) = given.iter().find(|(_, is_given)| *is_given && !self.is_fragment()) {
            return Err(Error::usage(format!("{option} is for fragment programs: omit it, or add --mapping fragment")));
        }
        let Some(how) = self.mapping().fragment() else { return Ok(()) };
        let fault = match device {
            DeviceKind::Cpu => Some(mapping::NO_GPU),
            _ => how.fault().or(mapping::fault_of(schedule)),
        };
        fault.map_or(Ok(()), |fault| Err(Error::usage(fault)))
    }

    /// Where passes run: fragment programs need a GPU, if only one in software.
    pub(crate) fn device(self, device: &DeviceArgs) -> DeviceArgs {
        let mut device = device.clone();
        if self.is_fragment() && device.device == DeviceKind::Auto && device.adapter.is_none() {
            device.device = DeviceKind::Gpu;
        }
        device
    }
}
