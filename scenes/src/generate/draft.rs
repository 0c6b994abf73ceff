//! What the generators share: a scene filled triangle by triangle, lights, cameras, materials.

use super::{GenerateError, MAX_TRIANGLES, Parameter};
use crate::{Camera, Light, Material, Projection, Scene};
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

/// A white point light. Equation (1) has no falloff, so `intensity` is for other viewers: the square of a well-lit
/// distance.
pub(super) fn lamp(position: [f32; 3], color: [f32; 3], intensity: f32) -> Light {
    Light::Point { position, color, intensity }
}

/// Whether the light comes from a point or from a surface.
pub(super) const LAMP: Parameter = Parameter {
    name: "lamp",
    summary: "what gives light: a point (0), or a square lamp whose lower side glows, for paths (1)",
    default: 0,
    range: 0..=1,
};

/// The scene as it is (0), or under a square lamp instead of its lights (1).
pub(super) fn under_lamp(
    mut scene: Scene,
    lamp: u64,
    center: Vec3,
    half: f32,
    emissive: [f32; 3],
) -> Result<Scene, GenerateError> {
    check("lamp", &LAMP, lamp)?;
    if lamp == 0 {
        return Ok(scene);
    }
    let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, z]| (center + Vec3::new(x, 0.0, z) * half).to_array());
    scene.triangles.extend([[a, b, c], [a, c, d]]);
    scene.normals.iter_mut().for_each(|normals| normals.extend([[[0.0, -1.0, 0.0]; 3]; 2]));
    scene.triangle_materials.extend([scene.materials.len() as u32; 2]);
    scene.materials.push(Material { emissive, ..matte("lamp", [0.0; 3]) });
    scene.lights.clear();
    Ok(scene)
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
