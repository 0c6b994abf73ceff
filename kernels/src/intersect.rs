//! Twin of `intersect.wgsl`: tests the ray against one triangle of its cell.

use bytemuck::{Pod, Zeroable};

use crate::executor::cpu::Texels;
use crate::real::{Real, Vec3};
use crate::scene_data::SceneData;
use crate::shared::triangle::{hit_triangle, is_nearer};
use crate::shared::vector::smallest3;
use crate::state::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::stream::Stream::{Counters, Hit, RayDirection, RayOrigin, State, TMax};

/// The uniform `scene`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct SceneInfo {
    /// Number of triangles.
    pub triangles: u32,
    pub(crate) _pad: [u32; 3],
}

fn is_in_cell<R: Real>(scene: &SceneData, position: Vec3<R>, cell: [i32; 3]) -> bool {
    let low = scene.grid.cell_plane::<R>(cell);
    let high = low + Vec3::from_f32(scene.grid.width);
    position.x >= low.x
        && position.y >= low.y
        && position.z >= low.z
        && position.x <= high.x
        && position.y <= high.y
        && position.z <= high.z
}

/// Whether a cell before this one held the triangle too: walks again from the start.
fn is_repeated<R: Real>(scene: &SceneData, triangle: u32, cell: u32, origin: Vec3<R>, direction: Vec3<R>) -> bool {
    let (grid, rules) = (&scene.grid, scene.features.walk_rules());
    let mut walk = grid.enter(rules, origin, direction);
    let bound = grid.cells[0] + grid.cells[1] + grid.cells[2] + 2;
    let mut step = 0;
    while step < bound && walk.inside {
        let index = grid.cell_index(walk.cell);
        if index == cell {
            return false;
        }
        let (first, end) = (scene.grid_cells[index as usize], scene.grid_cells[index as usize + 1]);
        if scene.grid_items[first as usize..end as usize].contains(&triangle) {
            return true;
        }
        walk = grid.advance(rules, walk, origin, direction);
        step += 1;
    }
    false
}

/// One ray's work.
pub fn intersect<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let mut tag = ray.load_u32(State, 0);
    if tag != ISECT_NO_HIT && tag != ISECT_HIT {
        return;
    }
    let features = &scene.features;

    let mut nearest_t: R = ray.load(State, 1);
    let cell = ray.load_u32(State, 2);
    let mut item = ray.load_u32(State, 3);
    let (first, count) = if features.grid {
        let first = scene.grid_cells[cell as usize];
        (first, scene.grid_cells[cell as usize + 1] - first)
    } else {
        (0, scene.info.triangles)
    };

    let in_list = item < count;
    if in_list {
        let triangle = if features.grid { scene.grid_items[(first + item) as usize] } else { item };
        let origin = ray.load_vec3(RayOrigin);
        let direction = ray.load_vec3(RayDirection);
        let candidate = hit_triangle::<R>(features.robust, origin, direction, scene.corners(triangle));
        let accepted = if features.robust {
            is_nearer(candidate.t, triangle, nearest_t, ray.load_u32(Hit, 2))
        } else if features.grid {
            candidate.t < nearest_t
                && is_in_cell(scene, origin + direction * candidate.t, scene.grid.cell_of_index(cell))
        } else {
            candidate.t < nearest_t
        };
        if candidate.is_hit && accepted {
            ray.store(Hit, 0, candidate.u);
            ray.store(Hit, 1, candidate.v);
            ray.store_u32(Hit, 2, triangle);
            ray.store(State, 1, candidate.t);
            nearest_t = candidate.t;
            tag = ISECT_HIT;
        }
        item += 1;
        if features.counters {
            ray.store_u32(Counters, 1, ray.load_u32(Counters, 1) + 1);
        }
        if features.grid && features.counters {
            let repeated = u32::from(is_repeated(scene, triangle, cell, origin, direction));
            ray.store_u32(Counters, 2, ray.load_u32(Counters, 2) + repeated);
        }
    }

    let ended = if features.robust { item >= count } else { !in_list };
    if ended {
        let is_hit = tag == ISECT_HIT;
        tag = if features.grid && features.robust {
            let exit = smallest3(ray.load_vec3(TMax));
            if is_hit && nearest_t <= exit { SHADE } else { TRAV }
        } else if features.grid {
            if is_hit { SHADE } else { TRAV }
        } else if is_hit {
            SHADE
        } else {
            BACKGROUND
        };
    }
    ray.store_u32(State, 0, tag);
    ray.store_u32(State, 3, item);
}
