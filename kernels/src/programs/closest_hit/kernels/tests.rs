//! Checks the rows against the WGSL.

use super::*;
use crate::options::features::Features;
use crate::program::live;
use crate::programs::closest_hit::PROGRAM;

#[test]
fn workgroups_are_those_of_the_wgsl() {
    let features = Features { robust: true, watertight: true, grid: true, ..Features::default() };
    for kernel in PROGRAM.kernels() {
        let info = kernel.info();
        let features = Features { bvh: kernel == TRAVERSE_BVH, irregular: kernel == TRAVERSE_IRREGULAR, ..features };
        let grid = !features.bvh && !features.irregular;
        let features = Features { grid, samples: info.role == Role::Sample, ..features };
        let is_walk = info.role == Role::Walk;
        let features = Features { live_lists: is_walk, many_steps: is_walk, ..features };
        let variant =
            crate::shader::Variant::new(kernel, &features, &live::lists(&[kernel], &features)).expect("a variant");
        let module = naga::front::wgsl::parse_str(&variant.source).expect("valid");
        let entry = module.entry_points.iter().find(|entry| entry.name == info.name).expect("its entry point");
        assert_eq!(entry.workgroup_size[0] * entry.workgroup_size[1], info.workgroup.pow(2), "{}", info.name);
    }
}
