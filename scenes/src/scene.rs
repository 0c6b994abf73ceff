//! A scene prepared for tracing: flattened to world space, one entry per triangle.

use glam::{DVec3, Vec3};

/// A scene in world space. Right-handed, +Y up as in glTF, lengths in scene units.
///
/// Everything per triangle is indexed by the triangle's id, its position in [`triangles`](Self::triangles).
///
/// Positions of triangles, lights and cameras are those of the file minus [`offset`](Self::offset): far from the
/// origin, f32 could not tell the vertices of a small triangle apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// A short name for reports: the file's stem, or the generator's name.
    pub name: String,
    /// Where the scene's origin lies in the file's coordinates; 0 unless all triangles lie far from the file's origin.
    /// See [`offset_for`].
    pub offset: DVec3,
    /// Vertex positions. All are finite.
    pub triangles: Vec<[[f32; 3]; 3]>,
    /// Unit vertex normals, three per triangle; `None` if no mesh has any. If only some meshes have them, the others
    /// have flat normals.
    pub normals: Option<Vec<[[f32; 3]; 3]>>,
    /// Base colour texture coordinates, three per triangle; `None` if no material has a texture.
    pub texcoords: Option<Vec<[[f32; 2]; 3]>>,
    /// Linear vertex colours, three per triangle; `None` if no mesh has any (white if only some do).
    pub colors: Option<Vec<[[f32; 3]; 3]>>,
    /// Index into [`materials`](Self::materials), one per triangle.
    pub triangle_materials: Vec<u32>,
    /// At least one, even if a file has none.
    pub materials: Vec<Material>,
    /// Textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Empty if the file has none; the renderer then places a headlight at the eye.
    pub lights: Vec<Light>,
    /// Empty if the file has none; [`Camera::framing`] then frames the scene.
    pub cameras: Vec<Camera>,
    /// Notes for the user: ignored features, assumed defaults.
    pub notes: Vec<Note>,
}

/// One sentence to the user about how a scene was read, e.g. "skins are shown in their rest pose".
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note(pub String);

/// A Lambertian material, as the paper's equation (1) needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The material's name, or empty.
    pub name: String,
    /// Diffuse colour, linear.
    pub base_color: [f32; 3],
    /// Added to the shaded colour, linear.
    pub emissive: [f32; 3],
    /// Index into [`Scene::textures`]; its colour multiplies `base_color`.
    pub texture: Option<u32>,
    /// Shade the back with the normal turned to the viewer. Rays stop at both sides regardless.
    pub double_sided: bool,
    /// What it does to light besides scattering it in all directions.
    pub optics: Optics,
}

/// How a surface reflects and refracts light, of what a tracer of ideal surfaces distinguishes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Optics {
    /// It scatters light in all directions.
    #[default]
    Diffuse,
    /// A rough metal, or rough glass: drawn as a diffuse surface.
    Rough,
    /// It reflects light as a perfect mirror, by its `base_color`.
    Mirror,
    /// The smooth surface of something transparent, by whose `base_color` passing light is multiplied.
    Dielectric {
        /// Index of refraction, relative to the outside: where its corners are counterclockwise.
        ior: f32,
        /// Both sides of a thin sheet in one: light passes straight through.
        is_thin: bool,
    },
}

impl Optics {
    /// Whether rays go on from it.
    #[must_use]
    pub const fn is_specular(&self) -> bool {
        matches!(self, Self::Mirror | Self::Dielectric { .. })
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 3],
            emissive: [0.0; 3],
            texture: None,
            double_sided: false,
            optics: Optics::Diffuse,
        }
    }
}

/// A base colour texture: 8-bit sRGB texels, row 0 at the top, as glTF's v = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width in texels; at least 1.
    pub width: u32,
    /// Height in texels; at least 1.
    pub height: u32,
    /// `width * height` texels, R G B sRGB-encoded, A linear (unused).
    pub texels: Vec<[u8; 4]>,
    /// What u does outside [0, 1].
    pub wrap_u: Wrap,
    /// What v does outside [0, 1].
    pub wrap_v: Wrap,
    /// Bilinear when true, nearest when false.
    pub linear: bool,
}

/// How a texture is extended outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture repeats.
    Repeat,
    /// Every other copy is mirrored.
    Mirror,
    /// The edge texel is repeated.
    Clamp,
}

/// A light of KHR_lights_punctual. Equation (1) has no falloff, so `intensity` and range are kept
/// for information only.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Shines in all directions from `position`.
    Point {
        /// World position.
        position: [f32; 3],
        /// Linear colour.
        color: [f32; 3],
        /// Candela, as in the file.
        intensity: f32,
    },
    /// Shines along `direction` everywhere.
    Directional {
        /// Unit vector in which the light travels.
        direction: [f32; 3],
        /// Linear colour.
        color: [f32; 3],
        /// Lux, as in the file.
        intensity: f32,
    },
    /// A point light within a cone.
    Spot {
        /// World position.
        position: [f32; 3],
        /// Unit vector along the cone's axis, away from the light.
        direction: [f32; 3],
        /// Linear colour.
        color: [f32; 3],
        /// Candela, as in the file.
        intensity: f32,
        /// Half angle of full light, radians, `0 <= inner < outer`.
        inner_cone: f32,
        /// Half angle where the light ends, radians, `outer <= pi/2`.
        outer_cone: f32,
    },
}

/// Where rays start. The three axes are orthonormal and right-handed: right × up = −forward.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The camera's name, or empty.
    pub name: String,
    /// World position.
    pub eye: DVec3,
    /// Unit vector to the right of the image.
    pub right: DVec3,
    /// Unit vector to the top of the image.
    pub up: DVec3,
    /// Unit vector into the image.
    pub forward: DVec3,
    /// Directions of rays across pixels.
    pub projection: Projection,
}

/// Perspective or orthographic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays start at the eye and diverge.
    Perspective {
        /// Full vertical angle of view, radians, in (0, pi).
        vertical_fov: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the image's height in scene units, above 0. The width follows from the image's aspect.
        half_height: f64,
    },
}

/// An axis-aligned box. Empty when any `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The empty box.
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// Whether the box contains no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }
}

/// The point that is subtracted, in f64, from the coordinates of a file whose vertices have these bounds: 0 on an axis
/// where they come near the origin, compared with their extent, and otherwise near their centre. Coordinates stay as
/// they are, to the bit, unless f32 would represent them at least four times more coarsely than around the origin. The
/// result has few bits, so that subtracting it adds no rounding error of its own.
#[must_use]
pub fn offset_for(min: DVec3, max: DVec3) -> DVec3 {
    /// Distances from the origin up to this multiple of the extent are left alone.
    const NEAR: f64 = 4.0;
    let extent = (max - min).max_element();
    if !(extent > 0.0 && extent.is_finite()) {
        return DVec3::ZERO;
    }
    // An eighth to a sixteenth of the extent: a power of two, unless that would be subnormal.
    let step = (extent / 8.0).log2().floor().exp2().max(f64::MIN_POSITIVE);
    let of_axis = |min: f64, max: f64| {
        let center = min + (max - min) / 2.0;
        if min.abs().max(max.abs()) > NEAR * extent { (center / step).round() * step } else { 0.0 }
    };
    let offset = DVec3::new(of_axis(min.x, max.x), of_axis(min.y, max.y), of_axis(min.z, max.z));
    if offset.is_finite() { offset } else { DVec3::ZERO }
}

impl Scene {
    /// A scene of triangles only, in scene units: grey, matt, and lit from the eye.
    ///
    /// ```
    /// let scene = raystep_scenes::Scene::from_triangles(vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    /// assert_eq!(scene.triangle_materials, [0]);
    /// ```
    #[must_use]
    pub fn from_triangles(triangles: Vec<[[f32; 3]; 3]>) -> Self {
        let triangle_materials = vec![0; triangles.len()];
        Self { triangles, triangle_materials, materials: vec![Material::default()], ..Self::default() }
    }

    /// The same from f64, minus an offset where they lie far from the origin: see [`offset_for`]. `None` if a coordinate
    /// is not finite, or not in f32.
    #[must_use]
    pub fn from_triangles_f64(triangles: &[[[f64; 3]; 3]]) -> Option<Self> {
        let corners = || triangles.iter().flatten().map(|&corner| DVec3::from(corner));
        let bounds = corners().fold(None, |bounds: Option<[DVec3; 2]>, p| {
            Some(bounds.map_or([p, p], |[min, max]| [min.min(p), max.max(p)]))
        });
        let offset = bounds.map_or(DVec3::ZERO, |[min, max]| offset_for(min, max));
        let local = |corner: [f64; 3]| (DVec3::from(corner) - offset).as_vec3().to_array();
        let triangles: Vec<_> = triangles.iter().map(|corners| corners.map(local)).collect();
        let are_finite = triangles.as_flattened().as_flattened().iter().all(|v| v.is_finite());
        are_finite.then(|| Self { offset, ..Self::from_triangles(triangles) })
    }

    /// The area of all triangles, in scene units squared.
    #[must_use]
    pub fn area(&self) -> f64 {
        let twice = self.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| Vec3::from(corner).as_dvec3());
            (b - a).cross(c - a).length()
        });
        // A sum of nothing would be -0.
        twice.fold(0.0, |sum, area| sum + area) / 2.0
    }

    /// The box of all vertices in the file's coordinates, smallest and largest; `None` without triangles.
    #[must_use]
    pub fn bounds_in_file(&self) -> Option<[DVec3; 2]> {
        let Bounds { min, max } = Some(self.bounds()).filter(|bounds| !bounds.is_empty())?;
        Some([min, max].map(|corner| self.offset + corner.as_dvec3()))
    }

    /// The box of all vertices; [`Bounds::EMPTY`] without triangles.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.triangles.iter().flatten().fold(Bounds::EMPTY, |b, &p| {
            let p = Vec3::from(p);
            Bounds { min: b.min.min(p), max: b.max.max(p) }
        })
    }
}

impl Camera {
    /// A camera at `eye` that looks at `target`. `None` if the two coincide or are not finite;
    /// an `up` parallel to the view is replaced by another axis.
    #[must_use]
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, projection: Projection) -> Option<Self> {
        let forward = (target - eye).try_normalize().filter(|v| v.is_finite())?;
        let right = [up, DVec3::Y, DVec3::Z]
            .into_iter()
            .filter_map(DVec3::try_normalize)
            .map(|up| forward.cross(up))
            .find(|r| r.length() > 1e-6)?
            .normalize();
        Some(Self { name: String::new(), eye, right, up: right.cross(forward), forward, projection })
    }

    /// A camera that frames `bounds` from the front, slightly above and to the right, for scenes without cameras. Also
    /// works for empty, flat and single-point bounds.
    #[must_use]
    pub fn framing(bounds: &Bounds) -> Self {
        const FOV_DEG: f64 = 40.0;
        let (center, radius) = if bounds.is_empty() {
            (DVec3::ZERO, 1.0)
        } else {
            let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
            let radius = (max - min).length() * 0.5;
            let center = (min + max) * 0.5;
            // A single point has no size; its distance from the origin is the only scale.
            (center, if radius > 0.0 { radius } else { center.length().max(1.0) * 1e-3 })
        };
        let vertical_fov = FOV_DEG.to_radians();
        let distance = radius / (vertical_fov * 0.5).sin() * 1.05;
        let eye = center + DVec3::new(0.35, 0.3, 1.0).normalize() * distance;
        let projection = Projection::Perspective { vertical_fov };
        Self::look_at(eye, center, DVec3::Y, projection).unwrap_or(Self {
            name: String::new(),
            eye,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            projection,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_scenes_far_from_the_origin_for_their_size_have_an_offset() {
        let offset = |min: [f64; 3], size: f64| offset_for(DVec3::from(min), DVec3::from(min) + size);
        assert_eq!(offset([0.0, -1.0, 2.9], 1.0), DVec3::ZERO);
        assert_eq!(offset([1e7, 0.0, -1e7], 1000.0), DVec3::new(1e7 + 512.0, 0.0, -1e7 + 512.0));
        assert_eq!(offset([f64::MAX, 0.0, 0.0], 1.0), DVec3::ZERO, "no extent is left at that distance");
        for (min, size) in [(-f64::MAX, f64::INFINITY), (f64::NAN, 1.0), (1e-310, 1e-315), (5e-324, 5e-324)] {
            let offset = offset([min; 3], size);
            assert!(offset.is_finite(), "{min} {size}: {offset}");
        }
    }

    #[test]
    fn what_is_left_of_a_coordinate_is_exact_and_small() {
        let (min, size) = (12_958_095.124_851_028, 0.4);
        let offset = offset_for(DVec3::splat(min), DVec3::splat(min + size)).x;
        // The nearest f64 of the difference, computed another way: both numbers are multiples of 2^-29.
        let scale = 29.0_f64.exp2();
        let exact = (min * scale) as i64 - (offset * scale) as i64;
        assert_eq!((min - offset) * scale, exact as f64);
        assert!((min - offset).abs() <= size, "{offset}");
    }
}
