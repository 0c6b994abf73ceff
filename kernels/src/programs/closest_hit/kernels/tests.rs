//! The rows against each other and against the WGSL.

use super::*;
use crate::programs::closest_hit::kernels;

#[test]
fn the_table_is_in_the_order_of_the_enum() {
    for (i, info) in KERNELS.iter().enumerate() {
        assert_eq!(info.kernel as usize, i, "{}", info.name);
    }
}

#[test]
fn every_row_sends_what_it_takes_and_no_state_is_a_dead_end() {
    let taken: Vec<Tag> = KERNELS.iter().flat_map(|info| info.takes).copied().collect();
    for info in KERNELS {
        for &tag in info.takes {
            assert!(info.sends.iter().any(|s| s.from == tag), "{} keeps {tag}", info.name);
        }
        for send in info.sends {
            // The fused kernel also takes rays that nothing has made yet, where it makes them itself.
            let is_own = info.takes.contains(&send.from) || (info.kernel, send.from) == (kernels::FUSED, UNWRITTEN);
            assert!(is_own && taken.contains(&send.to), "{}: {send:?}", info.name);
        }
        if let Some(to) = info.kernel.sends_all_to() {
            assert!(info.sends.iter().all(|s| s.to == to || s.to == s.from), "{}", info.name);
        }
    }
}

#[test]
fn workgroups_are_those_of_the_wgsl() {
    let features = Features { robust: true, watertight: true, grid: true, ..Features::default() };
    for info in KERNELS {
        let features = Features { bvh: info.kernel == kernels::TRAVERSE_BVH, ..features };
        let features = Features { grid: !features.bvh, samples: info.role == Role::Sample, ..features };
        let is_walk = info.role == Role::Walk;
        let features = Features { live_lists: is_walk, many_steps: is_walk, ..features };
        let variant = crate::shader::Variant::new(info.kernel, &features).expect("a variant");
        let module = naga::front::wgsl::parse_str(&variant.source).expect("valid");
        let entry = module.entry_points.iter().find(|entry| entry.name == info.name).expect("its entry point");
        assert_eq!(entry.workgroup_size[0] * entry.workgroup_size[1], info.workgroup.pow(2), "{}", info.name);
    }
}
