//! Instances of the kernels of other programs: the walk once more, for photons, and what sorts them by cell.

use crate::options::reasons::{Reason, Run};
use crate::program::{Instance, KernelInfo, Renamed};
use crate::programs::closest_hit::elements::{
    ALL_RECORD_TALLIES, MAP_CELLS, PHOTONS, RAYS, RECORD_TALLIES, RECORD_TALLY_BLOCKS, RECORDS, no_bitonic, no_map,
    no_scan,
};
use crate::programs::closest_hit::kernels::{COUNT, DECIDE, KERNELS, SETUP};
use crate::programs::closest_hit::states::ALL;
use crate::programs::light::LISTS as OF_LIGHT;
use crate::programs::primitives::{ADD, HISTOGRAM, SCAN, SCATTER};
use crate::programs::sort::EXCHANGES;
use crate::tables::elements::Elements;
use crate::tables::kernel::ListInfo;

use super::kernels::{OF_EMIT_PHOTONS, OF_GATHER, OF_KEY_PHOTONS, OF_LOOK_UP, OF_SCATTER_PHOTONS, OF_SEARCH_CELLS};

/// The states of a walk, and what they are called for a photon.
const STATES: [(&str, &str); 9] = [
    ("UNWRITTEN", "PHOTON_UNBORN"),
    ("TRAV_SETUP", "PHOTON_SETUP"),
    ("TRAV", "PHOTON_TRAV"),
    ("ISECT_NO_HIT", "PHOTON_NO_HIT"),
    ("ISECT_HIT", "PHOTON_HIT"),
    ("EXACT", "PHOTON_EXACT"),
    ("SHADE", "PHOTON_ARRIVED"),
    ("BACKGROUND", "PHOTON_LEAVES"),
    ("DONE", "PHOTON_DONE"),
];

/// The streams and lists of a walk that photons have of their own.
const BINDS: Binds = &[
    ("ray_origin", "photon_origin"),
    ("ray_direction", "photon_direction"),
    ("state", "photon_state"),
    ("tmax", "photon_tmax"),
    ("control", "photon_control"),
    ("voxel", "photon_voxel"),
    ("previous", "photon_previous"),
    ("hit", "photon_at"),
    ("bounds", "photon_bounds"),
    ("surface", "photon_surface"),
    ("place", "photon_place"),
    ("trail", "photon_trail"),
    ("intersect_list", "photon_intersect_list"),
    ("traverse_list", "photon_traverse_list"),
];

/// Options of the walk of a photon: its cost is not counted, and it may begin anywhere.
const SETS: Sets = &[("counters", false), ("resumes_scan", false), ("clip", true), ("leaves", true), ("apart", true)];
/// Photons are no samples of pixels.
const OF_NO_PIXEL: Sets = &[("samples", false)];

/// Lists of live rays, for each kind of ray, and of photons.
pub(super) const LISTS: [ListInfo; 6] = [
    OF_LIGHT[0],
    OF_LIGHT[1],
    OF_LIGHT[2],
    OF_LIGHT[3],
    ListInfo { name: "photon_intersect_list", slots: ["photon_intersect_list_even", "photon_intersect_list_odd"] },
    ListInfo { name: "photon_traverse_list", slots: ["photon_traverse_list_even", "photon_traverse_list_odd"] },
];

/// The names of the kernels of a walk for photons, why a run does without each, and its colour.
type OfPhotons = (&'static str, fn(&Run<'_>) -> Reason, [u8; 3]);
const WALK: [OfPhotons; 8] = [
    ("photon_setup", absent::<0>, [200, 170, 90]),
    ("photon_traverse_grid", absent::<1>, [110, 130, 70]),
    ("photon_traverse_irregular", absent::<2>, [110, 130, 70]),
    ("photon_traverse_bvh", absent::<3>, [110, 130, 70]),
    ("photon_intersect", absent::<4>, [210, 120, 80]),
    ("photon_walk", absent::<5>, [170, 140, 80]),
    ("photon_fused", absent::<6>, [180, 90, 90]),
    ("photon_decide", absent::<7>, [200, 40, 20]),
];
const _: () = assert!(DECIDE.index() - SETUP.index() + 1 == WALK.len());

/// Why a run does without a kernel of the walk of photons: what it would be needed for, if there are any.
fn absent<const OF: usize>(run: &Run<'_>) -> Reason {
    if run.features.mapped { (KERNELS[SETUP.index() + OF].kernel.why_absent)(run) } else { no_map(run) }
}

/// The kernels of the walk once more, for photons, and the one that counts these.
pub(super) fn photon_walk() -> impl Iterator<Item = Instance> {
    let count = Instance {
        name: "photon_count",
        over: &PHOTONS,
        binds: &[("state", "photon_state")],
        ..KERNELS[COUNT.index()]
    };
    let walk = KERNELS[SETUP.index()..].iter().zip(WALK);
    walk.filter_map(|(&of, (name, why_absent, colour))| {
        let renamed = Renamed::new(&of.kernel, ALL, &STATES)?.of_existing();
        let kernel = KernelInfo { why_absent, colour, ..of.kernel };
        let renamed = Some(&*Box::leak(Box::new(renamed)));
        Some(Instance { name, kernel, over: &PHOTONS, binds: BINDS, renamed, sets: of.with_sets(SETS), ..of })
    })
    .chain([count])
}

/// How many they are.
pub(super) const IN_WALK: usize = WALK.len() + 1;

type Binds = &'static [(&'static str, &'static str)];
type Sets = &'static [(&'static str, bool)];

const EXCHANGED: Binds = &[("key", "photon_key")];
const THERE: Binds = &[
    ("key_in", "photon_key"),
    ("value_in", "photon_key"),
    ("tally", "photon_tally"),
    ("key_out", "photon_cell"),
    ("value_out", "photon_key_there"),
];
const BACK: Binds = &[
    ("key_in", "photon_key_there"),
    ("value_in", "photon_key_there"),
    ("tally", "photon_tally"),
    ("key_out", "photon_cell"),
    ("value_out", "photon_key"),
];
const TALLIED: Binds = &[("values", "photon_tally"), ("sums", "photon_tally_of_block")];
const ALL_TALLIED: Binds = &[("values", "photon_tally_of_block"), ("sums", "photon_tally_in_all")];

const fn guest(
    name: &'static str,
    kernel: KernelInfo,
    why_absent: fn(&Run<'_>) -> Reason,
    over: &'static Elements,
    binds: Binds,
) -> Instance {
    Instance { name, binds, ..Instance::of(KernelInfo { why_absent, ..kernel }, over) }
}

macro_rules! own {
    ($($id:ident $instance:expr;)*) => {
        /// The program's own kernels and those of others that are no walk, in the order of the table.
        #[derive(Clone, Copy)]
        pub(super) enum Own { $($id),* }

        pub(super) static OWN: [Instance; [$(Own::$id as usize),*].len()] = [$($instance),*];
    };
}

own! {
    EmitPhotons Instance { sets: OF_NO_PIXEL, ..Instance::of(OF_EMIT_PHOTONS, &PHOTONS) };
    ScatterPhotons Instance { sets: OF_NO_PIXEL, ..Instance::of(OF_SCATTER_PHOTONS, &PHOTONS) };
    KeyPhotons Instance::of(OF_KEY_PHOTONS, &RECORDS);
    Exchange guest("exchange_photons", EXCHANGES, no_bitonic, &RECORDS, EXCHANGED);
    CountThere guest("count_photons_there", HISTOGRAM, no_scan, &RECORDS, THERE);
    CountBack guest("count_photons_back", HISTOGRAM, no_scan, &RECORDS, BACK);
    ScanTallies guest("scan_photon_tallies", SCAN, no_scan, &RECORD_TALLIES, TALLIED);
    ScanTallyBlocks guest("scan_photon_tally_blocks", SCAN, no_scan, &RECORD_TALLY_BLOCKS, ALL_TALLIED);
    AddTallies guest("add_photon_tallies", ADD, no_scan, &RECORD_TALLIES, TALLIED);
    MoveThere guest("move_photons_there", SCATTER, no_scan, &RECORDS, THERE);
    MoveBack guest("move_photons_back", SCATTER, no_scan, &RECORDS, BACK);
    SearchCells Instance::of(OF_SEARCH_CELLS, &MAP_CELLS);
    LookUp Instance::of(OF_LOOK_UP, &RAYS);
    Gather Instance::of(OF_GATHER, &RAYS);
}

/// The sets of their elements that are not the image's, in the program's order.
pub(super) const SETS_OF_PHOTONS: [&Elements; 6] =
    [&PHOTONS, &RECORDS, &RECORD_TALLIES, &RECORD_TALLY_BLOCKS, &ALL_RECORD_TALLIES, &MAP_CELLS];
