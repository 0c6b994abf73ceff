//! What the generators share: a scene filled triangle by triangle, lights, cameras, materials.

use super::{GenerateError, MAX_TRIANGLES, Parameter};
use crate::{Camera, Light, Material, Optics, Projection, Scene};
use glam::{DVec3, Vec3};

/// Attributes of a draft in addition to positions and materials.
#[derive(Clone, Copy)]
pub(super) struct Attributes {
    pub(super) normals: bool,
    pub(super) colors: bool,
}

/// Checks `value` against its parameter's range.
pub(super) fn check(generator: &'static str, p: &Parameter, value: u64) -> Result<(), GenerateError> {
    let (min, max) = (*p.range.start(), *p.range.end());
    if p.range.contains(&value) {
        return Ok(());
    }
    Err(GenerateError::OutOfRange { generator, parameter: p.name, value, min, max })
}

/// An empty scene with room for `triangles`: allocates all the memory, or none.
pub(super) fn draft(
    generator: &'static str,
    triangles: u64,
    attributes: Attributes,
    materials: Vec<Material>,
) -> Result<Scene, GenerateError> {
    if triangles > MAX_TRIANGLES {
        return Err(GenerateError::TooManyTriangles { generator, triangles });
    }
    let per_triangle = 40 + 36 * u64::from(attributes.normals) + 36 * u64::from(attributes.colors);
    let refused = || GenerateError::OutOfMemory { generator, triangles, bytes: triangles * per_triangle };
    let count = usize::try_from(triangles).map_err(|_| refused())?;
    let room = || {
        let mut v = Vec::new();
        v.try_reserve_exact(count).map_err(|_| refused())?;
        Ok(v)
    };
    let mut triangle_materials = Vec::new();
    triangle_materials.try_reserve_exact(count).map_err(|_| refused())?;
    Ok(Scene {
        name: generator.to_owned(),
        triangles: room()?,
        normals: attributes.normals.then(room).transpose()?,
        colors: attributes.colors.then(room).transpose()?,
        triangle_materials,
        materials,
        ..Scene::default()
    })
}

/// A material of one colour, linear.
pub(super) fn matte(name: &str, base_color: [f32; 3]) -> Material {
    Material { name: name.to_owned(), base_color, ..Material::default() }
}

/// A material through which, or from which, rays go on.
pub(super) fn specular(name: &str, base_color: [f32; 3], optics: Optics) -> Material {
    Material { optics, ..matte(name, base_color) }
}

/// Adds a triangle to a draft with normals.
pub(super) fn add(scene: &mut Scene, material: u32, corners: [Vec3; 3], normals: [Vec3; 3]) {
    scene.triangles.push(corners.map(<[f32; 3]>::from));
    scene.normals.get_or_insert_default().push(normals.map(<[f32; 3]>::from));
    scene.triangle_materials.push(material);
}

/// A white point light. Equation (1) has no falloff, so `intensity` is for other viewers: the square of a well-lit
/// distance.
pub(super) fn lamp(position: [f32; 3], color: [f32; 3], intensity: f32) -> Light {
    Light::Point { position, color, intensity }
}

/// A light that shines along `direction` (any length but 0).
pub(super) fn sun(direction: Vec3, color: [f32; 3]) -> Light {
    Light::Directional { direction: direction.normalize_or(Vec3::NEG_Y).to_array(), color, intensity: 3.0 }
}

/// A perspective camera, upright. `eye` and `target` must differ.
pub(super) fn camera(name: &str, eye: DVec3, target: DVec3, fov_deg: f64) -> Option<Camera> {
    let projection = Projection::Perspective { vertical_fov: fov_deg.to_radians() };
    Camera::look_at(eye, target, DVec3::Y, projection).map(|c| Camera { name: name.to_owned(), ..c })
}
