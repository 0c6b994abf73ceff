//! Rays that the paper's numerics lose because they start outside the grid.

use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Item, Options, Plan, Ray, RaySource};
use raystep_scenes::Scene;

/// Note for users when the paper's numerics miss everything.
pub const MISSES_ALL: &str = "the paper's rules require the eye to be inside the grid: from here, all rays miss; \
                              move the eye inside, or use --numerics robust";

/// The same in a report, whose choices are not the reader's.
pub const ALL_MISS: &str = "with the paper's rules and a grid, rays are lost, because the eye is outside the grid";

/// Whether the paper's numerics, which do not clip rays to the grid, start a camera's rays outside the grid.
#[must_use]
pub fn misses_all(scene: &Scene, options: &Options, plan: &Plan) -> bool {
    let RaySource::Camera { camera, .. } = &options.rays else { return false };
    let (bounds, eye) = (scene.bounds(), camera.eye);
    // --keep-all keeps the clipping code even if the eye is inside.
    let is_inside = eye.cmpgt(bounds.min.as_dvec3()).all() && eye.cmplt(bounds.max.as_dvec3()).all();
    let features = &plan.features;
    features.grid && features.clip && !features.robust && !(options.keep.has(Item::Clipping) && is_inside)
}

/// Why the paper's numerics lose rays of other programs.
pub const MISSES_OUTSIDE: &str = "with a grid, the paper's rules can lose rays that start outside it";

/// How many rays start outside the grid, to which the paper's numerics do not clip them; 0 with other numerics.
#[must_use]
pub fn count_outside(rays: &[Ray], data: &SceneData) -> usize {
    let (features, units, info, grid) = (&data.features, &data.units, &data.info, &data.grid);
    if features.robust || !features.grid || info.triangles == 0 {
        return 0;
    }
    let is_outside = |ray: &&Ray| {
        (0..3).any(|axis| {
            let cell = (units.to_traced(ray.origin[axis]) - grid.corner[axis]) / grid.width[axis];
            !(0.0..grid.cells[axis] as f32).contains(&cell)
        })
    };
    rays.iter().filter(is_outside).count()
}

/// How many that is of all of them, in words, if there is one.
#[must_use]
pub fn share_outside(rays: &[Ray], data: &SceneData) -> Option<&'static str> {
    match count_outside(rays, data) {
        0 => None,
        all if all == rays.len() => Some("all"),
        most if 2 * most > rays.len() => Some("most"),
        _ => Some("some"),
    }
}
