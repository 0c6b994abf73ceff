//! Twin of `fused.wgsl`: traces each ray from its start to its nearest hit, in several dispatches if one allows too few
//! loop iterations.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin, load_voxel, store_voxel};
use crate::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT, TRAV, TRAV_SETUP, UNWRITTEN};
use crate::programs::closest_hit::streams::{self, COUNTERS, HIT, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::camera::eye_ray;
use crate::shared::constants::{INF, NO_TRIANGLE, WIDE_MAX_DEPTH};
use crate::shared::grid_walk::{GridRay, Walk};
use crate::shared::irregular_walk::VoxelWalk;
use crate::shared::vector::smallest3;
use crate::shared::wide_walk::{MOST_LEVELS, NO_CHILD, TRAIL_WORDS, WideGroup, WideRay, trail_child, with_trail_child};
use crate::tables::texels::Texels;

impl<R: Real> Trace<R> {
    fn through_grid(&mut self, ray: &mut Texels<'_, R>, wait: &mut Wait, scene: &SceneData) {
        let (grid, features) = (&scene.grid, &scene.features);
        let rules = features.walk_rules();
        let grid_ray = grid.ray(rules, self.origin, self.direction);
        let mut walk = wait.resumed(ray, &grid_ray, scene);
        // robust leaves the grid long before; with the paper's rules a ray may wrap over a face again and again.
        let mut bound = 4 * grid.cells.iter().sum::<i32>() + 64;
        if features.in_cell && !features.keeps_no_tmax() && wait.before {
            bound = ray.load_u32(streams::PLACE, 3) as i32;
        }
        while walk.inside {
            let index = grid.cell_index(walk.cell);
            if self.is_spent(scene) {
                keep_place(ray, scene, &walk, bound);
                wait.at(index, 0);
                return;
            }
            self.turns += 1;
            self.cells += u32::from(wait.item == 0);
            let distance = if features.skip { scene.empty_distance(index) } else { 0 };
            if distance == 0 {
                let (first, end) = (scene.grid_cells[index as usize], scene.grid_cells[index as usize + 1]);
                for item in first + wait.item..end {
                    self.test(scene, scene.grid_items[item as usize], walk.cell);
                    if self.ended {
                        return;
                    }
                    if self.is_spent(scene) && item + 1 < end {
                        keep_place(ray, scene, &walk, bound);
                        wait.at(index, item + 1 - first);
                        return;
                    }
                }
            }
            wait.item = 0;
            if !features.in_cell {
                if self.t <= smallest3(walk.per_axis) {
                    return;
                }
                if features.intervals && self.interval[1] <= smallest3(walk.per_axis) {
                    return;
                }
            } else {
                bound -= 1;
                if self.triangle != NO_TRIANGLE || bound < 0 {
                    return;
                }
            }
            walk =
                if distance > 1 { grid.leap(walk, distance, &grid_ray) } else { grid.advance(rules, walk, &grid_ray) };
        }
    }

    fn through_irregular(&mut self, ray: &mut Texels<'_, R>, wait: &mut Wait, scene: &SceneData) {
        let (irregular, features) = (scene.irregular(), &scene.features);
        let rules = features.walk_rules();
        let grid_ray = scene.grid.ray(rules, self.origin, self.direction);
        let mut walk = match wait.before {
            true => VoxelWalk { voxel: load_voxel(ray), cell: wait.cell, inside: true },
            false => irregular.enter(rules, &grid_ray),
        };
        let mut item = if wait.before { wait.item } else { 0 };
        self.cells += u32::from(walk.inside && !wait.before);
        while walk.inside {
            let (first, count) = scene.list(walk.cell);
            if item < count {
                self.test(scene, scene.listed(first + item), [0; 3]);
                if self.ended {
                    return;
                }
                item += 1;
            }
            if item == count {
                let exit = irregular.exit(&walk, &grid_ray);
                let t = smallest3(exit);
                if self.t <= t || features.intervals && self.interval[1] <= t {
                    return;
                }
                walk = irregular.step(&walk, exit, &grid_ray);
                item = 0;
                self.cells += u32::from(walk.inside);
                self.turns += 1 + scene.grid.levels;
            }
            if self.is_spent(scene) && walk.inside {
                store_voxel(ray, walk.voxel);
                wait.at(walk.cell, item);
                return;
            }
        }
    }

    fn through_tree(&mut self, ray: &mut Texels<'_, R>, wait: &mut Wait, scene: &SceneData) {
        if scene.info.triangles == 0 {
            return;
        }
        let wide_ray = WideRay::new(self.origin, self.direction, scene.features.ray_padding);
        let mut stack = [WideGroup::default(); WIDE_MAX_DEPTH as usize];
        let mut height = 0;
        // The root as the only hit of a group; its slot is chosen by the octant, so that no inner child precedes it.
        let mut group = WideGroup { base: 0, bits: 0x8000_0000 };
        // A restart trail (Laine, 2010): for each level's group, 4 bits with the child that was entered last, or
        // NO_CHILD. A group's level is in bits 8-15 of its word.
        let mut path = [0; TRAIL_WORDS];
        if wait.before {
            for (word, bits) in path.iter_mut().enumerate() {
                *bits = ray.load_u32(streams::TRAIL, word);
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
                group = wide_ray.visit(&scene.wide_nodes[node as usize], self.farthest()).0;
                group.bits |= (level + 1) << 8;
            }
            let child = trail_child(path[wait.item as usize / 8], wait.item);
            if child != NO_CHILD {
                group.bits &= (1 << (24 + child)) - 1;
            }
            self.turns += wait.item;
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
            self.turns += 1;
            if group.bits > 0x00ff_ffff {
                stack[height] = group;
                height += 1;
            }
            let (inner, leaves) = wide_ray.visit(&scene.wide_nodes[node as usize], self.farthest());
            self.cells += 1;
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
                self.test(scene, entry, [0; 3]);
                if self.ended {
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
            if self.is_spent(scene) {
                for (word, &bits) in path.iter().enumerate() {
                    ray.store_u32(streams::TRAIL, word, bits);
                }
                wait.at(node, group.bits >> 8 & 0xff);
                return;
            }
        }
    }

    fn through_all(&mut self, wait: &mut Wait, scene: &SceneData) {
        for triangle in wait.item..scene.info.triangles {
            self.test(scene, triangle, [0; 3]);
            if self.ended {
                return;
            }
            if self.is_spent(scene) && triangle + 1 < scene.info.triangles {
                wait.at(0, triangle + 1);
                return;
            }
        }
    }
}

/// A ray's position between two dispatches.
#[derive(Default)]
struct Wait {
    /// Whether it waited before this dispatch.
    before: bool,
    /// Whether it waits after it.
    after: bool,
    /// As in the stream `state`: the cell and the item in its list, or the node and its level, or the triangle.
    cell: u32,
    item: u32,
}

impl Wait {
    fn at(&mut self, cell: u32, item: u32) {
        (self.after, self.cell, self.item) = (true, cell, item);
    }

    /// The first cell, or the one at which the ray waits.
    fn resumed<R: Real>(&self, ray: &Texels<'_, R>, grid_ray: &GridRay<R>, scene: &SceneData) -> Walk<R> {
        let grid = &scene.grid;
        if !self.before {
            return grid.enter(scene.features.walk_rules(), grid_ray);
        }
        if scene.features.keeps_no_tmax() {
            let cell = grid.cell_of_index(self.cell);
            return Walk { cell, per_axis: grid.cell_exit(cell, grid_ray), inside: true };
        }
        let cell = [0, 1, 2].map(|layer| ray.load_u32(streams::PLACE, layer) as i32);
        let [x, y, z] = [4, 5, 6].map(|layer| ray.load(streams::PLACE, layer));
        Walk { cell, per_axis: Vec3::new(x, y, z), inside: true }
    }
}

/// Stores what cannot be computed from the cell's index: the coordinates if a ray wrapped over a face with the paper's
/// rules, tmax if it is accumulated or control terms, and how many more cells are allowed.
fn keep_place<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, walk: &Walk<R>, left: i32) {
    if scene.features.keeps_no_tmax() {
        return;
    }
    for (layer, cell) in walk.cell.into_iter().enumerate() {
        ray.store_u32(streams::PLACE, layer, cell as u32);
    }
    ray.store_u32(streams::PLACE, 3, if scene.features.in_cell { left as u32 } else { 0 });
    for (layer, value) in (4..).zip(walk.per_axis.to_array()) {
        ray.store(streams::PLACE, layer, value);
    }
}

/// Processes one ray.
pub fn fused<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let features = &scene.features;
    let mut wait = Wait::default();
    if features.resumes {
        let tag = ray.load_u32(STATE, 0);
        wait.before = tag == TRAV || tag == ISECT_NO_HIT || tag == ISECT_HIT;
        let is_new = tag == if features.eye_rays { UNWRITTEN } else { TRAV_SETUP };
        if !wait.before && !is_new {
            return;
        }
    } else if !features.eye_rays && ray.load_u32(STATE, 0) != TRAV_SETUP {
        return;
    }
    let (origin, direction) = if features.eye_rays {
        eye_ray(&scene.camera, features.perspective, ray.x, ray.y)
    } else {
        (load_origin(ray), load_direction(ray))
    };
    let has_end = features.any_hit && !features.eye_rays;
    let t = if has_end { ray.load(STATE, 1) } else { R::from_f32(INF) };
    let mut trace = Trace::new(origin, direction, load_interval(ray, features), t);
    if wait.before {
        (trace.t, trace.u, trace.v) = (ray.load(STATE, 1), ray.load(HIT, 0), ray.load(HIT, 1));
        trace.triangle = ray.load_u32(HIT, 2);
        (wait.cell, wait.item) = (ray.load_u32(STATE, 2), ray.load_u32(STATE, 3));
        if features.counters {
            (trace.cells, trace.tests) = (ray.load_u32(COUNTERS, 0), ray.load_u32(COUNTERS, 1));
        }
    }
    if features.grid {
        trace.through_grid(ray, &mut wait, scene);
    } else if features.irregular {
        trace.through_irregular(ray, &mut wait, scene);
    } else if features.bvh {
        trace.through_tree(ray, &mut wait, scene);
    } else {
        trace.through_all(&mut wait, scene);
    }

    ray.store(HIT, 0, trace.u);
    ray.store(HIT, 1, trace.v);
    ray.store_u32(HIT, 2, trace.triangle);
    let tag = if !wait.after {
        trace.ended_as()
    } else if features.bvh {
        TRAV
    } else if trace.triangle == NO_TRIANGLE {
        ISECT_NO_HIT
    } else {
        ISECT_HIT
    };
    if wait.after {
        ray.store_u32(STATE, 2, wait.cell);
        ray.store_u32(STATE, 3, wait.item);
    }
    ray.store_u32(STATE, 0, tag);
    ray.store(STATE, 1, trace.t);
    if features.counters {
        ray.store_u32(COUNTERS, 0, trace.cells);
        ray.store_u32(COUNTERS, 1, trace.tests);
        ray.store_u32(COUNTERS, 2, 0);
    }
}
