//! The choices that a report compares.

use raystep_kernels::{Accelerator, ScheduleKind};

use super::super::work::Only;
use crate::configuration::{Configuration, numerics_of};

/// Every structure with every schedule, by robust and by the paper's rules, but for what is not wanted.
pub(super) fn configurations(is_quick: bool, only: &Only) -> Vec<Configuration> {
    use Accelerator::{Bvh, Grid, Irregular, None};
    let mut all = Vec::new();
    for accelerator in [Grid, Irregular, Bvh, None].into_iter().filter(|&accelerator| only.has(accelerator)) {
        for &numerics in numerics_of(accelerator) {
            for &schedule in ScheduleKind::ALL.iter().filter(|&&schedule| only.has_schedule(schedule)) {
                // Without a grid or BVH, `second` is the same as `first`; with them, `first` is the slower of the two.
                let unlike = if accelerator == None { ScheduleKind::Second } else { ScheduleKind::First };
                let is_slow = matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
                let is_named = only.schedules.contains(&schedule);
                if schedule != unlike && (is_named || !(is_quick && is_slow && accelerator != Grid)) {
                    all.push(Configuration { numerics, ..Configuration::usual(accelerator, schedule) });
                }
            }
        }
    }
    // If there is no room or time for all of them, the slowest are missing: by schedule, then by how long they take to
    // build or run.
    let by_schedule = |one: &Configuration| match one.schedule {
        ScheduleKind::Fused => 0,
        ScheduleKind::Compact => 1,
        ScheduleKind::First | ScheduleKind::Second => 2,
    };
    let by_structure = |one: &Configuration| [Bvh, Grid, Irregular, None].iter().position(|a| *a == one.accelerator);
    all.sort_by_key(|one| (by_schedule(one), by_structure(one)));
    all
}
