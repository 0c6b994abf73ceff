//! The choices that a report compares.

use std::fmt;

use raystep_kernels::{Accelerator, Numerics, Options, Ray, RaySource, ScheduleKind};

use super::super::work::{Only, TESTS_PER_PASS, Work};
use crate::ways::numerics_of;

/// A choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Way {
    pub(super) accelerator: Accelerator,
    pub(super) schedule: ScheduleKind,
    pub(super) numerics: Numerics,
}

impl Way {
    pub(super) fn options(self, rays: &[Ray]) -> Options {
        let Self { accelerator, schedule, numerics } = self;
        let base = Options::new(RaySource::Given(rays.to_vec()));
        let steps = if accelerator == Accelerator::None { TESTS_PER_PASS } else { base.steps_per_pass };
        Options { accelerator, schedule, numerics, steps_per_pass: steps, shade: false, ..base }
    }

    pub(super) fn id(self, work: &Work<'_>) -> String {
        work.configuration(&[self.accelerator.name(), self.schedule.name(), self.numerics.name()])
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.accelerator, self.schedule, self.numerics)
    }
}

/// Every structure with every schedule, by robust and by the paper's rules, but for what is not wanted.
pub(super) fn ways(is_quick: bool, only: &Only) -> Vec<Way> {
    use Accelerator::{Bvh, Grid, Irregular, None};
    let mut ways = Vec::new();
    for accelerator in [Grid, Irregular, Bvh, None].into_iter().filter(|&accelerator| only.has(accelerator)) {
        for &numerics in numerics_of(accelerator) {
            for &schedule in ScheduleKind::ALL.iter().filter(|&&schedule| only.has_schedule(schedule)) {
                // Without a grid or BVH, `second` is the same as `first`; with them, `first` is the slower of the two.
                let unlike = if accelerator == None { ScheduleKind::Second } else { ScheduleKind::First };
                let is_slow = matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
                let is_named = only.schedules.contains(&schedule);
                if schedule != unlike && (is_named || !(is_quick && is_slow && accelerator != Grid)) {
                    ways.push(Way { accelerator, schedule, numerics });
                }
            }
        }
    }
    // If there is no room or time for all of them, the slowest are missing: by schedule, then by how long they take to
    // build or run.
    let by_schedule = |way: &Way| match way.schedule {
        ScheduleKind::Fused => 0,
        ScheduleKind::Compact => 1,
        ScheduleKind::First | ScheduleKind::Second => 2,
    };
    let by_structure = |way: &Way| [Bvh, Grid, Irregular, None].iter().position(|a| *a == way.accelerator);
    ways.sort_by_key(|way| (by_schedule(way), by_structure(way)));
    ways
}
