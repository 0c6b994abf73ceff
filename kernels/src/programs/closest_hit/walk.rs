//! Twin of `walk.wgsl`: advances each ray by up to K steps.

use crate::numbers::real::Real;
use crate::programs::closest_hit::grid_lists::list_ended;
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin, load_voxel, store_voxel};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{COUNTERS, HIT, PREVIOUS, STATE, of_walk};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::{TreeRay, Visit, next_node};
use crate::shared::constants::{INF, NO_NODE, NO_TRIANGLE, NODES_A_STEP};
use crate::shared::grid_walk::Walk;
use crate::shared::irregular_walk::VoxelWalk;
use crate::shared::vector::smallest3;
use crate::tables::state::Tag;
use crate::tables::texels::Texels;

/// A ray's position between two passes.
struct Place<R: Real> {
    tag: Tag,
    cell: u32,
    item: u32,
    trace: Trace<R>,
}

impl<R: Real> Place<R> {
    /// The item of its list at which the ray waited; 0 if rays never wait.
    fn waiting_item(&self, scene: &SceneData) -> u32 {
        if scene.features.resumes { self.item } else { 0 }
    }

    fn through_grid(&mut self, ray: &mut Texels<'_, R>, scene: &SceneData) {
        let (grid, features) = (&scene.grid, &scene.features);
        let rules = features.walk_rules();
        let grid_ray = grid.ray(rules, self.trace.origin, self.trace.direction);
        let cell = grid.cell_of_index(self.cell);
        // robust: computed from the cell each time, so there is nothing to keep.
        let is_computed = features.keeps_no_tmax();
        let kept = of_walk(features);
        let per_axis = if is_computed { grid.cell_exit(cell, &grid_ray) } else { ray.load_vec3(kept) };
        let mut walk = Walk { cell, per_axis, inside: true };
        let mut waits = false;
        for _ in 0..scene.info.steps {
            if self.trace.is_spent(scene) {
                break;
            }
            self.trace.turns += 1;
            let distance = if features.skip { scene.empty_distance(self.cell) } else { 0 };
            if distance == 0 {
                let (first, count) = scene.list(self.cell);
                for item in first + self.waiting_item(scene)..first + count {
                    self.trace.test(scene, scene.grid_items[item as usize], walk.cell);
                    if self.trace.ended {
                        self.tag = SHADE;
                        return;
                    }
                    if self.trace.is_spent(scene) && item + 1 < first + count {
                        self.item = item + 1 - first;
                        waits = true;
                        break;
                    }
                }
            }
            if waits {
                if !features.any_hit {
                    self.tag = if self.trace.triangle == NO_TRIANGLE { ISECT_NO_HIT } else { ISECT_HIT };
                }
                break;
            }
            self.item = 0;
            let has_hit = !features.any_hit && self.trace.triangle != NO_TRIANGLE;
            let tag = if has_hit { ISECT_HIT } else { ISECT_NO_HIT };
            let exit = if features.in_cell { R::from_f32(INF) } else { smallest3(walk.per_axis) };
            self.tag = list_ended(features, tag, self.trace.t, exit);
            if features.intervals && !features.in_cell && self.tag == TRAV {
                let is_behind = self.trace.interval[1] <= exit;
                self.tag = if is_behind { BACKGROUND } else { TRAV };
            }
            if self.tag != TRAV {
                break;
            }
            walk =
                if distance > 1 { grid.leap(walk, distance, &grid_ray) } else { grid.advance(rules, walk, &grid_ray) };
            if !walk.inside {
                self.tag = if has_hit { SHADE } else { BACKGROUND };
                break;
            }
            self.tag = tag;
            self.cell = grid.cell_index(walk.cell);
            self.trace.cells += 1;
        }
        if !is_computed {
            ray.store_vec3(kept, walk.per_axis);
        }
    }

    fn through_irregular(&mut self, ray: &mut Texels<'_, R>, scene: &SceneData) {
        let (irregular, features) = (scene.irregular(), &scene.features);
        let grid_ray = scene.grid.ray(features.walk_rules(), self.trace.origin, self.trace.direction);
        let mut walk = VoxelWalk { voxel: load_voxel(ray), cell: self.cell, inside: true };
        for _ in 0..scene.info.steps {
            if self.trace.is_spent(scene) {
                break;
            }
            // One to find the next cell in each level of the map, at most.
            self.trace.turns += 1 + scene.grid.levels;
            let (first, count) = scene.list(self.cell);
            let mut waits = false;
            for item in first + self.waiting_item(scene)..first + count {
                self.trace.test(scene, scene.listed(item), [0; 3]);
                if self.trace.ended {
                    self.tag = SHADE;
                    return;
                }
                if self.trace.is_spent(scene) && item + 1 < first + count {
                    self.item = item + 1 - first;
                    waits = true;
                    break;
                }
            }
            if waits {
                if !features.any_hit {
                    self.tag = if self.trace.triangle == NO_TRIANGLE { ISECT_NO_HIT } else { ISECT_HIT };
                }
                break;
            }
            self.item = 0;
            let has_hit = !features.any_hit && self.trace.triangle != NO_TRIANGLE;
            let tag = if has_hit { ISECT_HIT } else { ISECT_NO_HIT };
            let exit = irregular.exit(&walk, &grid_ray);
            self.tag = list_ended(features, tag, self.trace.t, smallest3(exit));
            if features.intervals && self.tag == TRAV && self.trace.interval[1] <= smallest3(exit) {
                self.tag = BACKGROUND;
            }
            if self.tag != TRAV {
                break;
            }
            walk = irregular.step(&walk, exit, &grid_ray);
            if !walk.inside {
                self.tag = if has_hit { SHADE } else { BACKGROUND };
                break;
            }
            self.tag = tag;
            self.cell = walk.cell;
            self.trace.cells += 1;
        }
        store_voxel(ray, walk.voxel);
    }

    fn through_tree(&mut self, ray: &mut Texels<'_, R>, scene: &SceneData) {
        let (origin, direction) = (self.trace.origin, self.trace.direction);
        let tree_ray = TreeRay::new(origin, direction, scene.features.ray_padding);
        let mut at = Visit { node: self.cell, previous: ray.load_u32(PREVIOUS, 0), in_leaf: false };
        let mut step = 0;
        let mut waits = false;
        while step < NODES_A_STEP * scene.info.steps && at.node != NO_NODE {
            if self.trace.is_spent(scene) {
                break;
            }
            self.trace.turns += 1;
            // A ray that waits at an item is already in its leaf.
            at.in_leaf = self.waiting_item(scene) > 0;
            if !at.in_leaf {
                at = next_node(&scene.bvh_nodes, &scene.bvh_parents, at, &tree_ray, self.trace.farthest());
                self.trace.cells += 1;
            }
            if at.in_leaf {
                let (first, count) = scene.list(at.node);
                for item in first + self.waiting_item(scene)..first + count {
                    self.trace.test(scene, item, [0; 3]);
                    if self.trace.ended {
                        self.tag = SHADE;
                        return;
                    }
                    if self.trace.is_spent(scene) && item + 1 < first + count {
                        self.item = item + 1 - first;
                        waits = true;
                        break;
                    }
                }
            }
            if waits {
                break;
            }
            self.item = 0;
            step += 1;
        }
        if at.node == NO_NODE {
            self.tag = self.trace.ended_as();
        } else {
            self.cell = at.node;
            ray.store_u32(PREVIOUS, 0, at.previous);
        }
    }

    fn through_all(&mut self, scene: &SceneData) {
        let end = scene.info.triangles.min(self.item.saturating_add(scene.info.steps));
        while self.item < end {
            if self.trace.is_spent(scene) {
                break;
            }
            self.trace.test(scene, self.item, [0; 3]);
            if self.trace.ended {
                self.tag = SHADE;
                return;
            }
            self.item += 1;
        }
        if self.item >= scene.info.triangles {
            self.tag = self.trace.ended_as();
        }
    }
}

/// Processes one ray.
pub fn walk<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != TRAV && tag != ISECT_NO_HIT && tag != ISECT_HIT {
        return;
    }
    let features = &scene.features;
    let interval = load_interval(ray, features);
    let mut trace = Trace::new(load_origin(ray), load_direction(ray), interval, ray.load(STATE, 1));
    trace.triangle = ray.load_u32(HIT, 2);
    let before = (trace.triangle, trace.t);
    let mut place = Place { tag, cell: ray.load_u32(STATE, 2), item: ray.load_u32(STATE, 3), trace };
    if features.grid {
        place.through_grid(ray, scene);
    } else if features.irregular {
        place.through_irregular(ray, scene);
    } else if features.bvh {
        place.through_tree(ray, scene);
    } else {
        place.through_all(scene);
    }

    let trace = &place.trace;
    if (trace.triangle, trace.t) != before {
        ray.store(HIT, 0, trace.u);
        ray.store(HIT, 1, trace.v);
        ray.store_u32(HIT, 2, trace.triangle);
        ray.store(STATE, 1, trace.t);
    }
    ray.store_u32(STATE, 0, place.tag);
    let is_through_all = !features.grid && !features.irregular && !features.bvh;
    if !is_through_all {
        ray.store_u32(STATE, 2, place.cell);
    }
    if features.resumes || is_through_all {
        ray.store_u32(STATE, 3, place.item);
    }
    if features.counters {
        ray.store_u32(COUNTERS, 0, ray.load_u32(COUNTERS, 0) + trace.cells);
        ray.store_u32(COUNTERS, 1, ray.load_u32(COUNTERS, 1) + trace.tests);
    }
}
