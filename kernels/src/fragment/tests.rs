use super::*;
use crate::options::features::Features;
use crate::options::mapping::{Fragment, Targets};
use crate::programs::closest_hit::{kernels, streams};

/// Options of the kernels that change what a fragment program reads or writes.
fn features() -> Vec<Features> {
    let robust = Features { fragments: true, robust: true, watertight: true, perspective: true, ..Features::default() };
    let paper = Features { robust: false, watertight: false, in_cell: true, grid: true, ..robust };
    let all = [
        robust,
        paper,
        Features { grid: true, clip: true, ..robust },
        Features { grid: true, counters: true, ..robust },
        Features { grid: true, intervals: true, any_hit: true, ..robust },
        Features { irregular: true, clip: true, ..robust },
        Features { bvh: true, ..robust },
        Features { bvh: true, ray_padding: true, counters: true, ..robust },
        Features { normals: true, many_lights: true, resumes_light: true, turns: 100, ..robust },
    ];
    all.to_vec()
}

fn kernels_of(features: &Features) -> Vec<Kernel> {
    let step = match features {
        Features { grid: true, .. } => Some(kernels::TRAVERSE_GRID),
        Features { irregular: true, .. } => Some(kernels::TRAVERSE_IRREGULAR),
        Features { bvh: true, .. } => Some(kernels::TRAVERSE_BVH),
        _ => None,
    };
    [kernels::GENERATE, kernels::SETUP, kernels::INTERSECT, kernels::SHADE].into_iter().chain(step).collect()
}

#[test]
fn every_kernel_becomes_valid_draws_of_all_its_streams() {
    for features in features() {
        for kernel in kernels_of(&features) {
            let variant = Variant::new(kernel, &features, &[]).expect("a variant");
            for how in Fragment::all() {
                for most in [1, 2, 4] {
                    let drawn =
                        DrawnKernel::new(&variant, how, most).unwrap_or_else(|e| panic!("{features:?} {how:?}: {e}"));
                    let targets: Vec<Stream> = drawn.draws.iter().flat_map(|draw| &draw.targets).copied().collect();
                    let mut wanted: Vec<Stream> = variant.written_streams().collect();
                    assert_eq!(targets.last(), Some(&streams::STATE), "{kernel:?}: the states are written last");
                    wanted.sort();
                    let mut all = targets.clone();
                    all.sort();
                    assert_eq!(all, wanted, "{kernel:?}");
                    let at_once = if how.targets == Targets::One { 1 } else { most };
                    assert_eq!(drawn.draws.len(), wanted.len().div_ceil(at_once), "{kernel:?}");
                }
            }
        }
    }
}
