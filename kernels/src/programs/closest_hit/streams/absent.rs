//! Why streams are left out.

use crate::options::reasons::{Because, NO_SHADE, On, Passes, Reason, Run};
use crate::options::{Integrator, Numerics};
use crate::programs::closest_hit::elements::no_map;

/// No ray waits for another dispatch.
pub(super) const NO_WALK_WAITS: Reason =
    (Because::Options, "needed only if a walk may take more loop turns than one dispatch allows");

/// Why a stream that only passes of steps need is left out.
pub(super) fn of_steps(run: &Run<'_>) -> Reason {
    run.needed_only(On::Any, Passes::Stepped)
}

/// Why nothing is kept of what rounding leaves open.
pub(super) fn of_bounds(run: &Run<'_>) -> Reason {
    match run.features.exact_order {
        true => of_steps(run),
        false => without_order(run)[usize::from(run.is_fused())],
    }
}

/// The same of photons.
pub(super) fn of_photon_bounds(run: &Run<'_>) -> Reason {
    if run.features.mapped { of_bounds(run) } else { no_map(run) }
}

/// Why integers decide nothing.
pub(in crate::programs) fn no_exact_order(run: &Run<'_>) -> Reason {
    without_order(run)[0]
}

/// The same, and for what only passes of steps need.
fn without_order(run: &Run<'_>) -> [Reason; 2] {
    macro_rules! needed {
        ($with:literal) => {
            [
                concat!("needed only with ", $with, "--order exact"),
                concat!("needed only with ", $with, "--order exact and --schedule first, second or compact"),
            ]
        };
    }
    let reasons = match (run.options.numerics, run.features.fragments) {
        (Numerics::Paper, _) => needed!("--numerics robust "),
        (_, true) => needed!("--mapping compute "),
        _ => needed!(""),
    };
    reasons.map(|reason| (Because::Options, reason))
}

/// Why no ray leaves a triangle, or a hit behind it.
pub(super) fn of_surface(run: &Run<'_>) -> Reason {
    match run.options.integrator {
        Integrator::Local => {
            (Because::Options, "needed only with --integrator shadows, whitted, path or photons, or for all hits")
        }
        _ => no_shadows(run),
    }
}

pub(super) fn of_tmax(run: &Run<'_>) -> Reason {
    if run.features.dda && !run.is_fused() {
        return (Because::Options, "needed only with --traversal amanatides-woo");
    }
    // Robust rules compute it from the cell; the paper's accumulate it from pass to pass.
    run.needed_only(On::Cells, if run.features.robust { Passes::OneStep } else { Passes::Stepped })
}

pub(super) fn of_control(run: &Run<'_>) -> Reason {
    match run.is_fused() {
        true if run.features.dda => run.needed_only(On::Any, Passes::Stepped),
        true => (
            Because::Options,
            "needed only with --accelerator grid --numerics paper --traversal 3d-dda and --schedule first, second or compact",
        ),
        false => (Because::Options, "needed only with --accelerator grid --numerics paper --traversal 3d-dda"),
    }
}

/// Why nothing casts a shadow ray.
pub(in crate::programs) fn no_shadows(run: &Run<'_>) -> Reason {
    if run.features.whole_paths && run.features.shadows {
        return of_steps(run);
    }
    match (run.options.integrator, run.options.shade) {
        (Integrator::Local, _) => (Because::Options, "needed only with --integrator shadows, whitted, path or photons"),
        (Integrator::Path | Integrator::Photons, true) => {
            (Because::Scene, "nothing gives light that a shadow ray could be cast to")
        }
        (_, true) => (Because::Scene, "no light: one headlight at the eye, from where every hit is visible"),
        (_, false) => NO_SHADE,
    }
}

/// Why no ray goes on from a hit.
pub(in crate::programs) fn no_specular(run: &Run<'_>) -> Reason {
    match (run.options.integrator, run.options.shade) {
        (Integrator::Local | Integrator::Shadows, _) => {
            (Because::Options, "needed only with --integrator whitted, path or photons")
        }
        (_, true) => (Because::Scene, "no mirror and no transparent surface"),
        (_, false) => NO_SHADE,
    }
}

/// Why what a pixel's rays carry from one to the next is not kept.
pub(super) fn no_bounces(run: &Run<'_>) -> Reason {
    if run.features.whole_paths { of_steps(run) } else { no_specular(run) }
}

/// Why no ray is split in two.
pub(super) fn no_dielectric(run: &Run<'_>) -> Reason {
    match run.features.specular {
        true if run.options.integrator.is_physical() => {
            (Because::Options, "needed only with --integrator whitted: a path goes one way")
        }
        true => (Because::Scene, "no transparent surface: a mirror reflects one ray"),
        false => no_specular(run),
    }
}

/// Why the cost of the rays before is not kept.
pub(super) fn no_spent(run: &Run<'_>) -> Reason {
    match (run.features.specular || run.features.path || run.features.photons) && !run.features.whole_paths {
        true => (Because::Options, "needed only with --counters"),
        false => no_bounces(run),
    }
}

/// Why nothing is followed along paths.
pub(super) fn no_path(run: &Run<'_>) -> Reason {
    match run.options.shade {
        true if run.features.whole_paths => of_steps(run),
        true => (Because::Options, "needed only with --integrator path or photons"),
        false => NO_SHADE,
    }
}

/// Why no emitter is picked.
pub(in crate::programs) fn no_emitters(run: &Run<'_>) -> Reason {
    if run.options.integrator.is_physical() { no_shadows(run) } else { no_path(run) }
}

/// Why the cost of shadow rays is not counted.
pub(super) fn no_shadow_counters(run: &Run<'_>) -> Reason {
    match run.features.shadows && !run.features.whole_paths {
        true => (Because::Options, "needed only with --counters"),
        false => no_shadows(run),
    }
}

/// Why no radius shrinks.
pub(super) fn no_iterations(run: &Run<'_>) -> Reason {
    if run.features.mapped { (Because::Options, "needed only with --iterations") } else { no_map(run) }
}
