use super::*;
use crate::options::features::Features;
use crate::options::mapping::{Cull, Fragment, Targets, Until, Update};
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

fn choices() -> Vec<Fragment> {
    let mut all = Vec::new();
    for &targets in Targets::ALL {
        for &cull in Cull::ALL {
            for &update in Update::ALL {
                let until = if cull == Cull::None { Until::Count } else { Until::Query };
                all.push(Fragment { targets, update, cull, until });
            }
        }
    }
    all.retain(|how| how.fault().is_none());
    all
}

#[test]
fn every_kernel_becomes_valid_draws_of_all_its_streams() {
    for features in features() {
        for kernel in kernels_of(&features) {
            let variant = Variant::new(kernel, &features).expect("a variant");
            for how in choices() {
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

#[test]
fn show() {
    let features = features()[2];
    let variant = Variant::new(kernels::INTERSECT, &features).expect("a variant");
    for targets in [Targets::One, Targets::Many] {
        let how = Fragment { targets, ..Fragment::default() };
        for draw in DrawnKernel::new(&variant, how, 2).expect("draws").draws {
            println!("=== {:?}\n{}", draw.targets, draw.shader.source);
        }
    }
    let count = Variant::new(kernels::COUNT, &features).expect("count");
    println!("{}", reader(&count).expect("a reader").source);
    println!("{}", depths(streams::STATE, &kernels_of(&features)).source);
}
