//! Twin of `bvh.wgsl`: through an eight-wide BVH.

use super::waiting::Wait;
use crate::numbers::real::Real;
use crate::programs::closest_hit::streams::TRAIL;
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::constants::WIDE_MAX_DEPTH;
use crate::shared::wide_walk::{MOST_LEVELS, NO_CHILD, TRAIL_WORDS, WideGroup, WideRay, trail_child, with_trail_child};
use crate::tables::texels::Texels;

pub(super) fn trace<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &mut Texels<'_, R>, scene: &SceneData) {
    if scene.info.triangles == 0 {
        return;
    }
    let wide_ray = WideRay::new(trace.origin, trace.direction, scene.features.ray_padding);
    let mut stack = [WideGroup::default(); WIDE_MAX_DEPTH as usize];
    let mut height = 0;
    // The root as the only hit of a group; its slot is chosen by the octant, so that no inner child precedes it.
    let mut group = WideGroup { base: 0, bits: 0x8000_0000 };
    let mut path = [0; TRAIL_WORDS];
    if wait.before {
        for (word, bits) in path.iter_mut().enumerate() {
            *bits = ray.load_u32(TRAIL, word);
        }
        // Down to where the ray waits: later siblings whose boxes are met wait on the stack again.
        for level in 0..wait.item {
            let child = trail_child(path[level as usize / 8], level);
            let node = wide_ray.child(group, 24 + child);
            group.bits &= (1 << (24 + child)) - 1;
            if group.bits > 0x00ff_ffff {
                stack[height] = group;
                height += 1;
            }
            group = wide_ray.visit(&scene.wide_nodes[node as usize], trace.farthest()).0;
            group.bits |= (level + 1) << 8;
        }
        let child = trail_child(path[wait.item as usize / 8], wait.item);
        if child != NO_CHILD {
            group.bits &= (1 << (24 + child)) - 1;
        }
        trace.turns += wait.item;
        // The nodes ahead may be behind the nearest hit by now.
        if group.bits <= 0x00ff_ffff {
            if height == 0 {
                return;
            }
            height -= 1;
            group = stack[height];
        }
    }
    loop {
        let bit = 31 - group.bits.leading_zeros();
        let node = wide_ray.child(group, bit);
        group.bits &= !(1 << bit);
        let level = group.bits >> 8 & 0xff;
        path[level as usize / 8] = with_trail_child(path[level as usize / 8], level, bit - 24);
        trace.turns += 1;
        if group.bits > 0x00ff_ffff {
            stack[height] = group;
            height += 1;
        }
        let (inner, leaves) = wide_ray.visit(&scene.wide_nodes[node as usize], trace.farthest());
        trace.cells += 1;
        group = inner;
        if level < MOST_LEVELS {
            group.bits |= (level + 1) << 8;
            let word = (level as usize + 1) / 8;
            path[word] = with_trail_child(path[word], level + 1, NO_CHILD);
        }
        let mut waiting = leaves.bits;
        while waiting != 0 {
            let entry = leaves.entry(waiting.trailing_zeros());
            waiting &= waiting - 1;
            trace.test(scene, entry, [0; 3]);
            if trace.ended {
                return;
            }
        }
        if group.bits <= 0x00ff_ffff {
            if height == 0 {
                return;
            }
            height -= 1;
            group = stack[height];
        }
        if trace.is_spent(scene) {
            for (word, &bits) in path.iter().enumerate() {
                ray.store_u32(TRAIL, word, bits);
            }
            wait.at(node, group.bits >> 8 & 0xff);
            return;
        }
    }
}
