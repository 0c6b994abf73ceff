//! Rays, and where a run's rays come from.

use glam::DVec3;
use raystep_scenes::Camera;

/// A ray in scene units: `origin + t * direction`. A hit counts if `t_min < t < t_max`: neither end does, as in DXR and
/// Vulkan, so a ray with the `t_min` of an earlier hit finds what is behind that hit. t is compared as a
/// [`CastHit`](crate::CastHit) has it, so this also holds where f32 cannot hold the exact t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Direction; any length but 0.
    pub direction: [f32; 3],
    /// Hits count beyond this t, in multiples of the direction: 0 or more, and finite.
    pub t_min: f32,
    /// Hits count before this t, in multiples of the direction: at least `t_min`; infinite for a ray without an end.
    pub t_max: f32,
}

impl Ray {
    /// A ray whose hits count at every t > 0.
    #[must_use]
    pub const fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The same in the coordinates of a scene's file, with f64's precision: a scene's offset (see [`raystep_scenes::Scene`]) is subtracted before the
    /// numbers are rounded to f32.
    #[must_use]
    pub fn in_file(origin: [f64; 3], direction: [f64; 3], offset: DVec3) -> Self {
        let origin = DVec3::from_array(origin) - offset;
        Self::new(origin.as_vec3().to_array(), direction.map(|d| d as f32))
    }

    /// What is wrong with the ray in any scene: a component that is not finite, a direction of 0, an empty interval.
    #[must_use]
    #[inline]
    pub fn fault(&self) -> Option<&'static str> {
        // Without branches between the numbers: every ray of a file is asked.
        let are_finite = |[x, y, z]: [f32; 3]| x.is_finite() & y.is_finite() & z.is_finite();
        let [x, y, z] = self.direction;
        if !(are_finite(self.origin) & are_finite(self.direction)) {
            Some("a component is not finite")
        } else if (x == 0.0) & (y == 0.0) & (z == 0.0) {
            Some("its direction is 0")
        } else if !self.t_min.is_finite() || self.t_min < 0.0 {
            Some("its t_min is not a finite number from 0 on")
        } else if self.t_max.is_nan() || self.t_max < self.t_min {
            Some("its t_max is below its t_min, or not a number")
        } else {
            None
        }
    }

    /// The first of these rays with a [`fault`](Self::fault), and what is wrong. Here, as crates that read many rays may be
    /// compiled for size.
    #[must_use]
    pub fn first_fault(rays: &[Self]) -> Option<(usize, &'static str)> {
        rays.iter().enumerate().find_map(|(index, ray)| Some((index, ray.fault()?)))
    }

    /// Whether the kernels must look up its interval. The t_max of a ray that ends at any hit is its initial t.
    pub(crate) fn needs_interval(&self, any_hit: bool) -> bool {
        self.t_min > 0.0 || (self.t_max < f32::INFINITY && !any_hit)
    }

    /// The same ray, with hits between two t only.
    #[must_use]
    pub const fn between(self, t_min: f32, t_max: f32) -> Self {
        Self { t_min, t_max, ..self }
    }
}

/// The source of rays.
#[derive(Clone, Debug, PartialEq)]
pub enum RaySource {
    /// One ray through the centre of each pixel.
    Camera {
        /// The camera.
        camera: Camera,
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Input rays. They fill texels row by row; the last row may be partly unused.
    Given(Vec<Ray>),
}

impl RaySource {
    /// The same source with input rays that end at `t_max`, or earlier if they did: with 1, rays from a point to a
    /// light. A camera's rays have no end.
    #[must_use]
    pub fn until(mut self, t_max: f32) -> Self {
        if let Self::Given(rays) = &mut self {
            rays.iter_mut().for_each(|ray| ray.t_max = ray.t_max.min(t_max));
        }
        self
    }
}

/// A ray as a file has it, in the coordinates of a scene's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileRay {
    /// Where it starts.
    pub origin: [f64; 3],
    /// Direction; any length but 0.
    pub direction: [f32; 3],
    /// The t between which hits count.
    pub interval: [f32; 2],
}

impl FileRay {
    /// The ray in a scene with this offset, see [`raystep_scenes::Scene::offset`].
    #[must_use]
    #[inline(always)]
    pub fn in_scene(&self, offset: DVec3) -> Ray {
        let [t_min, t_max] = self.interval;
        let origin = (DVec3::from_array(self.origin) - offset).as_vec3().to_array();
        Ray::new(origin, self.direction).between(t_min, t_max)
    }
}

/// How a file has its rays: floats of 4 or 8 bytes, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayLayout {
    /// Whether they have 8 bytes.
    pub is_wide: bool,
    /// Numbers of a ray.
    pub columns: RayColumns,
}

/// The numbers of a ray in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayColumns {
    /// Six: origin, direction.
    Plain,
    /// Eight: origin, t_min, direction, t_max.
    WithInterval,
    /// Eight, the fourth and the last unused.
    Padded,
}

impl RayLayout {
    /// Bytes of a ray.
    #[must_use]
    #[inline(always)]
    pub fn stride(self) -> usize {
        let columns = if self.columns == RayColumns::Plain { 6 } else { 8 };
        columns * if self.is_wide { 8 } else { 4 }
    }

    /// The ray in [`stride`](Self::stride) bytes.
    #[must_use]
    #[inline(always)]
    pub fn ray(self, bytes: &[u8]) -> FileRay {
        let mut numbers = [0.0; 8];
        if self.is_wide {
            let each = bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
            numbers.iter_mut().zip(each).for_each(|(number, read)| *number = read);
        } else {
            let each = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes).into());
            numbers.iter_mut().zip(each).for_each(|(number, read)| *number = read);
        }
        let [x, y, z, fourth, fifth, sixth, seventh, last] = numbers;
        let (direction, interval) = match self.columns {
            RayColumns::Plain => ([fourth, fifth, sixth], [0.0, f64::INFINITY]),
            RayColumns::WithInterval => ([fifth, sixth, seventh], [fourth, last]),
            RayColumns::Padded => ([fifth, sixth, seventh], [0.0, f64::INFINITY]),
        };
        let [dx, dy, dz] = direction;
        let [t_min, t_max] = interval;
        FileRay {
            origin: [x, y, z],
            direction: [dx as f32, dy as f32, dz as f32],
            interval: [t_min as f32, t_max as f32],
        }
    }

    /// Appends all rays in these bytes, in a scene with this offset. Here, as crates that convert them may be compiled
    /// for size.
    pub fn rays_in_scene(self, bytes: &[u8], offset: DVec3, rays: &mut Vec<Ray>) {
        // A loop for each layout, which is known in it.
        macro_rules! each {
            ($($is_wide:literal $columns:ident),+) => {
                match (self.is_wide, self.columns) {
                    $(($is_wide, RayColumns::$columns) => {
                        let layout = Self { is_wide: $is_wide, columns: RayColumns::$columns };
                        let each = bytes.chunks_exact(layout.stride());
                        rays.extend(each.map(|bytes| layout.ray(bytes).in_scene(offset)));
                    })+
                }
            };
        }
        each!(false Plain, false WithInterval, false Padded, true Plain, true WithInterval, true Padded);
    }
}
