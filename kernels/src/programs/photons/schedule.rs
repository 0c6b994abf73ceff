//! Which kernels run, in what order and until which condition holds.

use super::instances::Own::{
    self, AddCells, AddTallies, CountBack, CountThere, EmitPhotons, Exchange, Gather, KeyPhotons, LookUp, Mark,
    MarkThere, Measure, MoveBack, MoveThere, ScanCellBlocks, ScanCells, ScanTallies, ScanTallyBlocks, ScatterPhotons,
    SearchCells,
};
use super::{of as here, own, photon_kernel, sample_light};
use crate::options::features::Features;
use crate::options::{Options, PhotonSort};
use crate::program::schedule::{Count, Schedule, Step};
use crate::programs::closest_hit::kernels::GENERATE;
use crate::programs::closest_hit::plan::Others;
use crate::programs::closest_hit::schedule as of_rays;
use crate::programs::light::{mapped, shadow_kernel, while_begun};
use crate::programs::primitives::radix::digits_of;
use crate::programs::sort;
use crate::shared::photon_map::PhotonMap;

/// The schedule for a run with these options: photons are emitted and followed, a bounce of all of them after the other, and
/// sorted into the cells of a map; then rays from the camera are followed to a diffuse surface, and the photons near it
/// gathered.
pub(in crate::programs) fn of(options: &Options, features: &Features, others: &Others) -> Schedule {
    if !features.photons {
        return Schedule { steps: mapped(&of_rays::of(options, features).steps, &here) };
    }
    let walk = of_rays::new(options.schedule, features.structure(), true, false, false, features.many_steps).steps;
    let run = |kernel| Step::Run(own(kernel));
    let mut steps = Vec::new();
    if features.mapped {
        let mut bounce = mapped(&walk, &photon_kernel);
        bounce.push(run(ScatterPhotons));
        steps.extend([run(EmitPhotons), while_begun(bounce), run(KeyPhotons)]);
        steps.extend(match options.photons.sort {
            PhotonSort::Bitonic => searched(&others.photon_map),
            PhotonSort::Scan => scanned(&others.photon_map),
        });
    }

    let mut bounce = mapped(&walk, &here);
    bounce.push(Step::Run(sample_light()));
    if features.shadows {
        bounce.push(while_begun(mapped(&walk, &|kernel| shadow_kernel(&super::PROGRAM, kernel))));
    }
    bounce.push(run(LookUp));
    if features.mapped {
        bounce.extend([Step::RunUntilIdle(own(Gather)), run(LookUp)]);
    }
    steps.extend([Step::Run(here(GENERATE)), while_begun(bounce)]);
    Schedule { steps: of_rays::until_idle(steps, features) }
}

/// Sorts the keys of photons by the network, and searches for the first of each cell.
fn searched(map: &PhotonMap) -> Vec<Step> {
    let mut steps = mapped(&sort::schedule(map.records).steps, &|_| own(Exchange));
    steps.push(Step::Run(own(SearchCells)));
    steps
}

/// Sorts them digit by digit, and adds up the lengths of the cells' lists.
fn scanned(map: &PhotonMap) -> Vec<Step> {
    let run = |kernels: &[Own]| kernels.iter().map(|&kernel| Step::Run(own(kernel))).collect::<Vec<_>>();
    // All ones, as which photons count that are in no cell, are larger than any cell in these digits too.
    let digits = digits_of(map.cells + 1);
    let sort = |digit: u32| -> Vec<Step> {
        let [count, place] = if digit.is_multiple_of(2) { [CountThere, MoveThere] } else { [CountBack, MoveBack] };
        let by = |kernel| vec![Step::RunBy(own(kernel), Count { first: digit, by: &[2] })];
        [by(count), run(&[ScanTallies, ScanTallyBlocks, AddTallies]), by(place)].concat()
    };
    let pairs = Step::Repeat("digit pair", Count::always(digits / 2), [sort(0), sort(1)].concat());
    let mut steps = vec![pairs];
    if !digits.is_multiple_of(2) {
        steps.extend(sort(digits - 1));
    }
    let mark = if digits.is_multiple_of(2) { Mark } else { MarkThere };
    steps.extend(run(&[mark, Measure, ScanCells, ScanCellBlocks, AddCells]));
    steps
}
