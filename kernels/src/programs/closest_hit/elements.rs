//! The elements of this program, and of those with photons.

use crate::options::reasons::{Because, NO_SHADE, On, Passes, Reason, Run};
use crate::options::{Integrator, PhotonSort};
use crate::programs::primitives::{blocks, tallies};
use crate::tables::elements::{Count, Elements};

/// One ray per pixel, or per input ray.
pub static RAYS: Elements = Elements { name: "rays", count: Count::Image };

/// Photons that are emitted: as many as fill whole rows.
pub static PHOTONS: Elements = Elements { name: "photons", count: Count::Given };
/// Places where photons are stored: the first bounce of all of them, then the second, …
pub static RECORDS: Elements = Elements { name: "records", count: Count::Given };
/// Digits of the cells of these.
pub static RECORD_TALLIES: Elements = tallies("record_tallies", "records");
/// Blocks in which these are summed.
pub static RECORD_TALLY_BLOCKS: Elements = blocks("record_tally_blocks", "record_tallies");
/// The block of these.
pub static ALL_RECORD_TALLIES: Elements = blocks("all_record_tallies", "record_tally_blocks");
/// Cells of the maps, and one more, where the last list ends.
pub static MAP_CELLS: Elements = Elements { name: "map_cells", count: Count::Given };

/// Why no photon is emitted, or none gathered.
pub(in crate::programs) fn no_map(run: &Run<'_>) -> Reason {
    match (run.options.shade, run.options.integrator) {
        (false, _) => NO_SHADE,
        (_, Integrator::Photons) => (Because::Scene, "nothing gives light, or no photon may bounce"),
        _ => (Because::Options, "needed only with --integrator photons"),
    }
}

/// Why what only one way to sort photons needs is left out: because the run sorts them in this way.
fn by_other(run: &Run<'_>, other: PhotonSort, needed: &'static str) -> Reason {
    if run.features.mapped && run.options.photons.sort == other { (Because::Options, needed) } else { no_map(run) }
}

/// Why there is no bitonic sort.
pub(in crate::programs) fn no_bitonic(run: &Run<'_>) -> Reason {
    by_other(run, PhotonSort::Scan, "needed only with --photon-map bitonic")
}

/// Why there is no radix sort.
pub(in crate::programs) fn no_scan(run: &Run<'_>) -> Reason {
    by_other(run, PhotonSort::Bitonic, "needed only with --photon-map scan")
}

/// Why what a photon's walk keeps is left out.
pub(super) fn no_photon_walk(run: &Run<'_>) -> Reason {
    if run.features.mapped { run.needed_only(On::Any, Passes::OneStep) } else { no_map(run) }
}
