//! Which kernels run, in what order and until which condition holds.

use super::instances::Own::{
    self, AddTallies, CountBack, CountThere, EmitPhotons, Exchange, Gather, KeyPhotons, LookUp, MoveBack, MoveThere,
    ScanTallies, ScanTallyBlocks, ScatterPhotons, SearchCells,
};
use super::{of as here, own, photon_kernel, sample_light};
use crate::options::features::Features;
use crate::options::{Options, PhotonSort};
use crate::program::schedule::{Count, Schedule, Step};
use crate::programs::closest_hit::kernels::GENERATE;
use crate::programs::closest_hit::plan::Others;
use crate::programs::closest_hit::schedule as of_rays;
use crate::programs::light::{mapped, shadow_kernel, while_begun};
use crate::programs::path;
use crate::programs::primitives::radix::digits_of;
use crate::programs::sort;
use crate::shared::photon_map::PhotonMap;

/// The schedule for a run with these options: photons are emitted and followed, a bounce of all of them after the other, and
/// sorted into the cells of a map; then rays from the camera are followed to a diffuse surface, and the photons near it
/// gathered. All of that for every iteration.
pub(in crate::programs) fn of(options: &Options, features: &Features, others: &Others) -> Schedule {
    if !features.photons {
        return Schedule { steps: mapped(&of_rays::of(options, features).steps, &here) };
    }
    let walk = of_rays::new(options.schedule, features, true, false).steps;
    let run = |kernel| Step::Run(own(kernel));
    let mut steps = Vec::new();
    if features.mapped {
        let mut bounce = mapped(&walk, &photon_kernel);
        bounce.push(run(ScatterPhotons));
        steps.extend([run(EmitPhotons), while_begun(bounce), run(KeyPhotons)]);
        steps.extend(match options.photons.sort {
            PhotonSort::Bitonic => mapped(&sort::schedule(others.photon_map.records).steps, &|_| own(Exchange)),
            PhotonSort::Scan => by_digits(&others.photon_map),
        });
        steps.push(run(SearchCells));
    }

    let mut bounce = mapped(&walk, &here);
    bounce.push(Step::Run(sample_light()));
    if features.shadows {
        bounce.push(while_begun(mapped(&walk, &|kernel| shadow_kernel(&super::PROGRAM, kernel))));
    }
    bounce.push(run(LookUp));
    if features.mapped {
        // From one map after the other.
        for _ in 0..others.photon_map.maps {
            bounce.extend([Step::RunUntilIdle(own(Gather)), run(LookUp)]);
        }
    }
    steps.extend([Step::Run(here(GENERATE)), while_begun(bounce)]);
    Schedule { steps: path::sampled(of_rays::until_idle(steps, features), features, &here) }
}

/// Sorts the keys of photons by a pair of digits after the other: there and back.
fn by_digits(map: &PhotonMap) -> Vec<Step> {
    let run = |kernel| Step::Run(own(kernel));
    let sort = |digit: u32, count: Own, place: Own| -> [Step; 5] {
        let by = |kernel| Step::RunBy(own(kernel), Count { first: digit, by: &[2] });
        [by(count), run(ScanTallies), run(ScanTallyBlocks), run(AddTallies), by(place)]
    };
    // All ones, as which photons count that are in no cell, are larger than any cell in these digits too.
    let pairs = digits_of(map.cells_in_all() + 1).div_ceil(2);
    let pair = [sort(0, CountThere, MoveThere), sort(1, CountBack, MoveBack)].concat();
    vec![Step::Repeat("digit pair", Count::always(pairs), pair)]
}
