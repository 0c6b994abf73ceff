//! Rays in the faces, along the edges and through the corners of a grid's cells.

use raystep_kernels::GridSize;
use raystep_kernels::options::{Options, Ray, RaySource};
use raystep_kernels::plan::{Limits, Plan};
use raystep_kernels::shared::grid_walk::Grid;
use raystep_scenes::Scene;

use crate::Error;
use crate::rays::Random;
use crate::stability::Workload;
use crate::stability::make::{self, SEED, given, sphere};

/// A grid's planes in scene units; exact, as in traced units.
pub(super) struct Planes {
    grid: Grid,
    unit: f64,
}

impl Planes {
    /// The planes of the grid that a run with these rays has.
    pub(super) fn of(scene: &Scene, rays: Vec<Ray>, cells: [u32; 3]) -> Result<Self, Error> {
        let options = Options { grid: GridSize::Cells(cells), shade: false, ..Options::new(RaySource::Given(rays)) };
        let (_, data) = Plan::new(scene, &options, &Limits::CPU)?;
        Ok(Self { grid: data.grid, unit: data.units.scene_units_per_stream_unit() })
    }

    /// The coordinate of a plane.
    pub(super) fn plane(&self, axis: usize, index: i32) -> f32 {
        let traced = self.grid.corner[axis] + self.grid.width[axis] * index as f32;
        (f64::from(traced) * self.unit) as f32
    }

    /// The diagonal of a cell.
    fn diagonal(&self) -> [f32; 3] {
        self.grid.width
    }
}

/// The number of axes in which a ray's origin lies on a plane.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum On {
    /// One: the ray stays in the face.
    Face,
    /// Two: it runs along the edge.
    Edge,
    /// Three: it goes from corner to corner.
    Corner,
}

const CELLS: u32 = 16;

/// Rays inside a closed sphere.
pub(super) fn on_planes(count: usize, on: On) -> Result<Workload, Error> {
    let scene = sphere(3, |p| p)?;
    let cells = [CELLS; 3];
    // Origins affect the grid's extent: use origins about as far away as those generated below.
    let planes = Planes::of(&scene, make::inside(0.5, count), cells)?;
    let rays = (0..count).map(|i| {
        let mut random = Random::of(i as u32, SEED + 1);
        // Planes within half the sphere's radius.
        let origin = [0, 1, 2].map(|axis| planes.plane(axis, 5 + random.below(CELLS as usize - 9) as i32));
        let free = [0; 3].map(|_| random.unit() as f32 - 0.5);
        let sign = [0, 1, 2].map(|bit| if ((i / 3) >> bit) & 1 == 0 { 1.0 } else { -1.0 });
        let axis = i % 3;
        let (mut o, mut d) = (origin, [0, 1, 2].map(|a| 0.0 * sign[a]));
        match on {
            On::Face => {
                let direction = random.on_sphere().as_vec3().to_array();
                for other in [(axis + 1) % 3, (axis + 2) % 3] {
                    (o[other], d[other]) = (free[other], direction[other]);
                }
            }
            On::Edge => (o[axis], d[axis]) = (free[axis], sign[axis]),
            On::Corner => d = [0, 1, 2].map(|a| planes.diagonal()[a] * sign[a]),
        }
        Ray::new(o, d)
    });
    Ok(Workload { grid: GridSize::Cells(cells), ..given(scene, rays.collect()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_lie_exactly_on_the_planes_of_the_grid_that_is_built() {
        for (on, wanted) in [(On::Face, 1), (On::Edge, 2), (On::Corner, 3)] {
            let Workload { scene, rays: RaySource::Given(rays), grid: GridSize::Cells(cells) } =
                on_planes(64, on).expect("a case")
            else {
                panic!("input rays in a grid of given size");
            };
            let options = Options { grid: GridSize::Cells(cells), ..Options::new(RaySource::Given(rays.clone())) };
            let (_, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
            let plane = |axis: usize, i: i32| data.grid.corner[axis] + data.grid.width[axis] * i as f32;
            for ray in &rays {
                let on_plane =
                    |&axis: &usize| (0..=16).any(|i| plane(axis, i) == data.units.to_traced(ray.origin[axis]));
                assert!((0..3).filter(on_plane).count() >= wanted, "{ray:?}");
            }
        }
    }
}
