//! Twin of `photon_map.wgsl`: the grid that photons are sorted into, and what is known of them all.

/// The map of photons that a diffuse surface sent on.
pub const GLOBAL: u32 = 0;
/// The map of those that came by mirrors and glass alone.
pub const CAUSTIC: u32 = 1;

use bytemuck::{Pod, Zeroable};

use crate::numbers::real::{Real, Vec3};

/// Most cells along an axis: a point's place among them is exact to a small part of a cell.
const MOST_ALONG: u64 = 1 << 10;
/// Most cells of a map.
const MOST_CELLS: u64 = 1 << 20;

/// The uniform `photon_map`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PhotonMap {
    /// Of the scene's box, the corner at which the cells begin; traced units.
    pub corner: [f32; 3],
    /// Number of photons.
    pub photons: u32,
    /// Cells along each axis.
    pub size: [u32; 3],
    /// Cells in all, of one map.
    pub cells: u32,
    /// Of the scene's box; traced units.
    pub center: [f32; 3],
    /// A sphere about the center with this radius holds the scene.
    pub reach: f32,
    /// Cells by traced unit.
    pub per_unit: f32,
    /// Width of a cell, traced units.
    pub width: f32,
    /// How far away photons may be that light is estimated from: less than the width.
    pub radius: f32,
    /// How far off a point's place may be by rounding, in cells.
    pub margin: f32,
    /// From how many photons light is estimated.
    pub nearest: u32,
    /// Number of places where photons may be stored.
    pub records: u32,
    /// Photons by row of their texture.
    pub row: u32,
    /// How many maps have these cells: one, or two, if there are mirrors or glass.
    pub maps: u32,
}

impl PhotonMap {
    /// The grid over a scene's box, for photons that fill so many rows and of which each may be stored so often, and for
    /// estimates from so many of them within a radius, a share of the box's diagonal. Cells are cubes a little wider than
    /// the radius, or as wide as it takes for their number to stay within bounds: so all photons within the radius are in
    /// a cell or its neighbours.
    #[must_use]
    pub fn new(
        [low, high]: [[f32; 3]; 2],
        [row, rows, stored]: [u32; 3],
        nearest: u32,
        radius: f64,
        maps: u32,
    ) -> Self {
        let extent = [0, 1, 2].map(|axis| (f64::from(high[axis]) - f64::from(low[axis])).max(0.0));
        let diagonal = extent.iter().map(|side| side * side).sum::<f64>().sqrt().max(1e-6);
        let radius = radius.max(1e-6) * diagonal;
        let longest = extent.into_iter().fold(0.0, f64::max);
        let mut width = (1.002 * radius).max(longest / (MOST_ALONG - 1) as f64);
        let along = |width: f64| extent.map(|side| (side / width) as u64 + 1);
        while along(width).iter().product::<u64>() > MOST_CELLS {
            width *= 1.1;
        }
        let size = along(width).map(|cells| cells as u32);
        let most = size.into_iter().fold(1, u32::max);
        Self {
            corner: low,
            photons: row * rows,
            size,
            cells: size.iter().product(),
            center: [0, 1, 2].map(|axis| (0.5 * (f64::from(low[axis]) + f64::from(high[axis]))) as f32),
            reach: (0.5001 * diagonal) as f32,
            per_unit: (1.0 / width) as f32,
            width: width as f32,
            radius: radius as f32,
            // A difference, a product, and what a point of a triangle is off by, of the size of the place.
            margin: 16.0 / (1 << 24) as f32 * most as f32,
            nearest,
            records: row * rows * stored,
            row,
            maps,
        }
    }

    /// Where a point is among the cells.
    pub fn place_of<R: Real>(&self, point: Vec3<R>) -> Vec3<R> {
        (point - Vec3::from_f32(self.corner)) * R::from_f32(self.per_unit)
    }

    /// The cell there; the nearest if there is none.
    pub fn cell_of<R: Real>(&self, place: Vec3<R>) -> [i32; 3] {
        let [x, y, z] = self.size.map(|cells| cells as i32 - 1);
        let within = |at: R, most: i32| at.floor().to_i32().clamp(0, most);
        [within(place.x, x), within(place.y, y), within(place.z, z)]
    }

    /// Cells of all maps.
    #[must_use]
    pub fn cells_in_all(&self) -> u32 {
        self.maps * self.cells
    }

    /// The 1-D index of a cell of a map: those of the second follow those of the first.
    #[must_use]
    pub fn index_of(&self, map: u32, [x, y, z]: [i32; 3]) -> u32 {
        map * self.cells + (z as u32 * self.size[1] + y as u32) * self.size[0] + x as u32
    }

    /// The photon that a place is of, and which of its places it is.
    #[must_use]
    pub fn photon_of(&self, record: u32) -> (u32, u32) {
        let photons = self.photons.max(1);
        (record % photons, record / photons)
    }

    /// Whether there is such a cell.
    #[must_use]
    pub fn has_cell(&self, cell: [i32; 3]) -> bool {
        cell.into_iter().zip(self.size).all(|(at, cells)| at >= 0 && at < cells as i32)
    }

    /// At most the squared distance from a place to the cell a step away from its own, in traced units.
    pub fn distance_to<R: Real>(&self, place: Vec3<R>, cell: [i32; 3], step: [i32; 3]) -> R {
        let margin = R::from_f32(self.margin);
        let along = |at: R, cell: i32, step: i32| {
            let below = at - R::from_i32(cell);
            let away = match step {
                0 => R::zero(),
                ..0 => below,
                _ => R::one() - below,
            };
            (away - margin).max(R::zero()) * R::from_f32(self.width)
        };
        let [x, y, z] =
            [along(place.x, cell[0], step[0]), along(place.y, cell[1], step[1]), along(place.z, cell[2], step[2])];
        x * x + y * y + z * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_as_wide_as_the_radius_and_never_too_many() {
        for (high, radius) in
            [([1.0, 1.0, 1.0], 0.015), ([2.0, 1e-3, 0.0], 0.001), ([0.0; 3], 0.5), ([1.0, 0.5, 1e-9f32], 1e-6)]
        {
            let map = PhotonMap::new([[0.0; 3], high], [32, 16, 5], 50, radius, 2);
            let diagonal = high.iter().map(|side| f64::from(*side).powi(2)).sum::<f64>().sqrt();
            assert!(f64::from(map.width) > radius * diagonal && map.margin < 0.002, "{map:?}");
            assert!(u64::from(map.cells) <= MOST_CELLS && map.records == 2560, "{map:?}");
            assert_eq!(map.cells, map.size.iter().product::<u32>());
            let last = map.cell_of(map.place_of(Vec3::<f32>::from_f32(high)));
            assert_eq!(map.index_of(GLOBAL, last), map.cells - 1, "{map:?}");
            assert_eq!(map.index_of(CAUSTIC, last), map.cells_in_all() - 1, "{map:?}");
            assert!(map.has_cell(last) && !map.has_cell([last[0] + 1, 0, 0]) && !map.has_cell([0, -1, 0]));
        }
    }

    /// No point of a cell is nearer than the distance to it.
    #[test]
    fn the_distance_to_a_cell_is_a_lower_bound() {
        let map = PhotonMap::new([[-1.0, 0.5, 0.0], [0.5, 1.5, 1.25]], [32, 16, 1], 50, 0.02, 1);
        let mut random = fastrand::Rng::with_seed(1);
        let mut near = 0;
        for _ in 0..20_000 {
            let mut point = |spread: f32, about: [f32; 3]| {
                Vec3::from_f32([0, 1, 2].map(|axis: usize| about[axis] + spread * (random.f32() - 0.5)))
            };
            let a: Vec3<f32> = point(0.9, [-0.25, 1.0, 0.6]);
            let b = point(4.0 * map.width, a.to_array());
            let [from, to] = [a, b].map(|p| map.cell_of(map.place_of(p)));
            let step = [0, 1, 2].map(|axis| to[axis] - from[axis]);
            let squared: f64 = (b - a).to_f64().iter().map(|side| side * side).sum();
            if step.iter().all(|step| step.abs() < 2) {
                near += 1;
                assert!(f64::from(map.distance_to(map.place_of(a), from, step)) <= squared, "{a:?} {b:?}");
            } else {
                assert!(squared > f64::from(map.radius).powi(2), "{a:?} {b:?}");
            }
        }
        assert!(near > 1000, "{near}");
    }
}
