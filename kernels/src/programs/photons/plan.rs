//! How many photons a run has, where they are stored, and how the map's grid divides the scene.

use crate::options::features::Features;
use crate::options::{Options, Photons, RaySource};
use crate::plan::over::in_rows;
use crate::plan::{Limits, PlanError};
use crate::programs::closest_hit::elements::{MAP_CELLS, PHOTONS, RECORDS};
use crate::programs::closest_hit::plan::Others;
use crate::shared::photon_map::PhotonMap;
use crate::structures::grid;
use crate::tables::elements::Size;

/// What does not go together with photons yet.
fn check(options: &Options, features: &Features) -> Result<(), PlanError> {
    let why = match options {
        _ if options.shade && !features.shadows => {
            "nothing in the scene gives light that photons could carry: use --integrator path, which shows it in a white \
             environment"
        }
        Options { rays: RaySource::Given(_), .. } => "rays are the camera's: input rays cannot be used",
        Options { any_hit: true, .. } => "rays need their nearest hits: any hit does not do",
        Options { samples, .. } if samples.first > 0 => {
            "an iteration depends on those before it: it cannot be shared among machines"
        }
        _ => return Ok(()),
    };
    Err(PlanError::Refused(format!("--integrator photons: {why}")))
}

/// The sets of photons, and their map.
pub(in crate::programs) fn others(
    options: &Options,
    features: &Features,
    vertices: &[f32],
    limits: &Limits,
) -> Result<Others, PlanError> {
    if features.photons {
        check(options, features)?;
    }
    if !features.mapped {
        return Ok(Others::default());
    }
    let Photons { count, nearest, radius, .. } = options.photons;
    // The last bounce is where photons are looked up.
    let (stored, most) = (features.depth - 1, Photons::MOST);
    let too_many = |photons: u64| {
        PlanError::Refused(format!(
            "--photons {count}: {photons} photons, each stored at up to {stored} bounces, are too many here: at most {most} \
             places fit; use fewer photons, or a smaller --max-depth"
        ))
    };
    let Some(Size { width, height, .. }) = Size::folded(count.max(1).into(), limits.image_side) else {
        return Err(too_many(count.into()));
    };
    // Whole rows, so that every texel has a photon.
    let photons = u64::from(width) * u64::from(height);
    let records = photons * u64::from(stored);
    let in_all = photons * u64::from(options.samples.count);
    if in_all > 1 << u32::BITS {
        let why = format!(
            "--photons {count} --iterations {}: {in_all} photons in all are too many to be told apart by 32 bits",
            options.samples.count
        );
        return Err(PlanError::Refused(why));
    }
    if records > most.into() || photons > limits.rays {
        return Err(too_many(photons));
    }
    let rows = [width, height, stored];
    let maps = if features.specular { 2 } else { 1 };
    let photon_map = PhotonMap::new(grid::bounds(vertices), rows, nearest, f64::from(radius) / 1000.0, maps);
    let size = Size { width, height, count: photons as u32 };
    let sets = vec![
        (&PHOTONS, size),
        in_rows(&RECORDS, records, limits).map_err(|_| too_many(photons))?,
        in_rows(&MAP_CELLS, u64::from(photon_map.cells_in_all()) + 1, limits)?,
    ];
    Ok(Others { sets, photon_map })
}
