//! Twin of `fused.wgsl`: takes each ray from its start to its nearest hit.

use crate::bvh::WIDE_MAX_DEPTH;
use crate::executor::cpu::Texels;
use crate::generate::eye_ray;
use crate::real::{Real, Vec3};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::triangle::{Shear, hit_triangle, is_nearer};
use crate::shared::vector::smallest3;
use crate::shared::wide_walk::{WideGroup, WideRay};
use crate::state::{BACKGROUND, SHADE, TRAV_SETUP, Tag};
use crate::stream::Stream::{Counters, Hit, RayDirection, RayOrigin, State};

/// The ray, what it has hit so far, and what that took.
pub(crate) struct Trace<R> {
    pub(crate) origin: Vec3<R>,
    pub(crate) direction: Vec3<R>,
    shear: Shear<R>,
    pub(crate) t: R,
    pub(crate) u: R,
    pub(crate) v: R,
    pub(crate) triangle: u32,
    pub(crate) cells: u32,
    pub(crate) tests: u32,
    /// Any hit was asked for and found.
    pub(crate) ended: bool,
}

impl<R: Real> Trace<R> {
    /// Nothing hit so far; what lies at `t` or behind does not count.
    pub(crate) fn new(origin: Vec3<R>, direction: Vec3<R>, t: R) -> Self {
        Self {
            origin,
            direction,
            shear: Shear::of(direction),
            t,
            u: R::zero(),
            v: R::zero(),
            triangle: NO_TRIANGLE,
            cells: 0,
            tests: 0,
            ended: false,
        }
    }

    /// The state of a ray whose walk is over.
    pub(crate) fn ended_as(&self) -> Tag {
        if self.triangle == NO_TRIANGLE { BACKGROUND } else { SHADE }
    }

    /// Tests one triangle; the cell is used where hits must lie in it.
    #[inline]
    pub(crate) fn test(&mut self, scene: &SceneData, entry: u32, cell: [i32; 3]) {
        let features = &scene.features;
        let packed = &scene.packed_triangles[entry as usize];
        let id = packed[3];
        let corner = |c: usize| {
            Vec3::from_f32([f32::from_bits(packed[c]), f32::from_bits(packed[c + 1]), f32::from_bits(packed[c + 2])])
        };
        let corners = [corner(0), corner(4), corner(8)];
        let candidate = hit_triangle(features.triangle_rules(), self.origin, self.direction, &self.shear, corners);
        self.tests += 1;
        if !candidate.is_hit {
            return;
        }
        let accepted = if features.in_cell {
            candidate.t < self.t && scene.grid.is_in_cell(self.origin + self.direction * candidate.t, cell)
        } else if features.robust && !features.any_hit {
            is_nearer(candidate.t, id, self.t, self.triangle)
        } else {
            candidate.t < self.t
        };
        if accepted {
            (self.t, self.u, self.v, self.triangle) = (candidate.t, candidate.u, candidate.v, id);
            self.ended = features.any_hit;
        }
    }

    fn through_grid(&mut self, scene: &SceneData) {
        let (grid, features) = (&scene.grid, &scene.features);
        let rules = features.walk_rules();
        let ray = grid.ray(rules, self.origin, self.direction);
        let mut walk = grid.enter(rules, &ray);
        // robust leaves the grid long before; the paper's rules may run over a face again and again.
        let mut bound = 4 * grid.cells.iter().sum::<i32>() + 64;
        while walk.inside {
            let index = grid.cell_index(walk.cell);
            self.cells += 1;
            let distance = if features.skip { scene.empty_distance(index) } else { 0 };
            if distance == 0 {
                let (first, end) = (scene.grid_cells[index as usize], scene.grid_cells[index as usize + 1]);
                for item in first..end {
                    self.test(scene, scene.grid_items[item as usize], walk.cell);
                    if self.ended {
                        return;
                    }
                }
            }
            if !features.in_cell {
                if self.t <= smallest3(walk.tmax) {
                    return;
                }
            } else {
                bound -= 1;
                if self.triangle != NO_TRIANGLE || bound < 0 {
                    return;
                }
            }
            walk = if distance > 1 { grid.leap(walk, distance, &ray) } else { grid.advance(rules, walk, &ray) };
        }
    }

    fn through_tree(&mut self, scene: &SceneData) {
        if scene.info.triangles == 0 {
            return;
        }
        let ray = WideRay::new(self.origin, self.direction);
        let mut stack = [WideGroup::default(); WIDE_MAX_DEPTH as usize];
        let mut height = 0;
        // The root, as the one hit of a group; its slot is the octant's, so that no inner child precedes it.
        let mut group = WideGroup { base: 0, bits: 0x8000_0000 };
        loop {
            let bit = 31 - group.bits.leading_zeros();
            let node = ray.child(group, bit);
            group.bits &= !(1 << bit);
            if group.bits > 0x00ff_ffff {
                stack[height] = group;
                height += 1;
            }
            let (inner, leaves) = ray.visit(&scene.wide_nodes[node as usize], self.t);
            self.cells += 1;
            group = inner;
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
        }
    }

    fn through_all(&mut self, scene: &SceneData) {
        for triangle in 0..scene.info.triangles {
            self.test(scene, triangle, [0; 3]);
            if self.ended {
                return;
            }
        }
    }
}

/// One ray's work.
pub fn fused<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let features = &scene.features;
    if !features.eye_rays && ray.load_u32(State, 0) != TRAV_SETUP {
        return;
    }
    let (origin, direction) = if features.eye_rays {
        eye_ray(scene, ray.x, ray.y)
    } else {
        (ray.load_vec3(RayOrigin), ray.load_vec3(RayDirection))
    };
    let has_end = features.any_hit && !features.eye_rays;
    let t = if has_end { ray.load(State, 1) } else { R::from_f32(INF) };
    let mut trace = Trace::new(origin, direction, t);
    if features.grid {
        trace.through_grid(scene);
    } else if features.bvh {
        trace.through_tree(scene);
    } else {
        trace.through_all(scene);
    }

    ray.store(Hit, 0, trace.u);
    ray.store(Hit, 1, trace.v);
    ray.store_u32(Hit, 2, trace.triangle);
    ray.store_u32(State, 0, trace.ended_as());
    ray.store(State, 1, trace.t);
    if features.counters {
        ray.store_u32(Counters, 0, trace.cells);
        ray.store_u32(Counters, 1, trace.tests);
        ray.store_u32(Counters, 2, 0);
    }
}
