//! Scene data for shading: normals, materials, lights, textures, colours.

use std::f64::consts::PI;

use raystep_scenes::{Light as SceneLight, Optics as SceneOptics, Scene, Texture as SceneTexture, Wrap};

use super::error::{SceneDataError, reserve};
use crate::numbers::srgb::srgb_to_linear;
use crate::numbers::units::Units;
use crate::options::{Environment, Integrator, Options, RaySource, Strategy};
use crate::shared::emitters::{Emission, Emitter, LUMINANCE, PUNCTUAL, table};
use crate::shared::shading::{
    DIELECTRIC, DIFFUSE, DIRECTIONAL, Light, MIRROR, Material, NO_TEXTURE, Optics, POINT, SHEET, SPOT,
};
use crate::shared::texture::Texture;

/// Linear colour of rays that hit nothing.
pub const BACKGROUND: [f32; 3] = [0.015, 0.018, 0.024];

pub(super) fn flat_normal(triangle: &[[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = triangle.map(|p| glam::Vec3::from(p).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
}

pub(super) fn material(m: &raystep_scenes::Material) -> Material {
    Material {
        base_color: m.base_color,
        texture: m.texture.unwrap_or(NO_TEXTURE),
        emissive: m.emissive,
        double_sided: u32::from(m.double_sided),
    }
}

pub(super) fn optics(optics: SceneOptics) -> Optics {
    let (kind, ior) = match optics {
        SceneOptics::Diffuse | SceneOptics::Rough => (DIFFUSE, 1.0),
        SceneOptics::Mirror => (MIRROR, 1.0),
        SceneOptics::Dielectric { ior, is_thin: false } => (DIELECTRIC, ior),
        SceneOptics::Dielectric { ior, is_thin: true } => (SHEET, ior),
    };
    Optics { kind, ior }
}

/// The colour of a ray that hits nothing.
pub(super) fn background(scene: &Scene, options: &Options) -> [f32; 3] {
    let is_dark = || scene.lights.is_empty() && scene.materials.iter().all(|m| m.emissive == [0.0; 3]);
    match options.environment {
        _ if options.integrator != Integrator::Path => BACKGROUND,
        Environment::Black => [0.0; 3],
        Environment::White => [1.0; 3],
        Environment::Auto if is_dark() => [1.0; 3],
        Environment::Auto => BACKGROUND,
    }
}

/// What gives light, and how likely each is to be picked: by its power, as far as that is known.
pub(super) fn emitters(
    scene: &Scene,
    options: &Options,
    lights: &[Light],
    vertices: &[f32],
) -> Result<(Vec<Emitter>, Emission), SceneDataError> {
    let luminance = |rgb: [f32; 3]| (0..3).map(|c| f64::from(rgb[c] * LUMINANCE[c])).sum::<f64>();
    let corner = |first: usize| glam::Vec3::from_slice(&vertices[first..first + 3]).as_dvec3();
    let of_triangle = |triangle: usize| {
        let material = &scene.materials[scene.triangle_materials[triangle] as usize];
        let [a, b, c] = [0, 3, 6].map(|offset| corner(9 * triangle + offset));
        let sides = if material.double_sided { 2.0 } else { 1.0 };
        PI * luminance(material.emissive) * sides * 0.5 * (b - a).cross(c - a).length()
    };
    let has_size = options.strategy != Strategy::Bsdf || options.integrator == Integrator::Photons;
    let glows = |&triangle: &usize| scene.materials[scene.triangle_materials[triangle] as usize].emissive != [0.0; 3];
    let triangles = (0..scene.triangles.len()).filter(|triangle| has_size && glows(triangle));
    // A scene without lights has a headlight for others.
    let count = scene.lights.len();
    let (mut ids, mut weights) = (reserve("emitters", count)?, reserve("emitters", count)?);
    let extent = vertices.iter().fold(0f32, |most, v| most.max(v.abs()));
    for (id, light) in (0..).zip(&lights[..count.min(lights.len())]) {
        ids.push(PUNCTUAL | id);
        let solid_angle = match light.kind {
            // What meets a disc as large as the scene.
            DIRECTIONAL => PI * f64::from(extent).powi(2),
            SPOT => 2.0 * PI * (1.0 - f64::from(light.cos_outer)),
            _ => 4.0 * PI,
        };
        weights.push(solid_angle * luminance(light.color));
    }
    for triangle in triangles {
        ids.push(triangle as u32);
        weights.push(of_triangle(triangle));
    }
    let emitters = table(&ids, &weights);
    let per_luminance = if emitters.is_empty() { 0.0 } else { (PI / weights.iter().sum::<f64>()) as f32 };
    let emission = Emission { count: emitters.len() as u32, per_luminance };
    Ok((emitters, emission))
}

/// The scene's lights in traced units, or a headlight. For paths and photons, their intensity counts, by traced units squared.
pub(super) fn lights(scene: &Scene, options: &Options, units: Units) -> Vec<Light> {
    if scene.lights.is_empty() {
        let position = match &options.rays {
            RaySource::Camera { camera, .. } => camera.eye.to_array().map(|v| units.to_traced_f64(v)),
            RaySource::Given(rays) => rays.first().map_or([0.0; 3], |r| r.origin.map(|v| units.to_traced(v))),
        };
        return vec![Light { position, kind: POINT, color: [1.0; 3], ..Light::default() }];
    }
    // Farther away, only the direction of a light matters.
    let place = |p: &[f32; 3]| p.map(|v| units.to_traced(v).clamp(-1e18, 1e18));
    let traced = |light: &SceneLight| match light {
        SceneLight::Point { position, color, .. } => {
            Light { position: place(position), kind: POINT, color: *color, ..Light::default() }
        }
        SceneLight::Directional { direction, color, .. } => {
            Light { direction: *direction, kind: DIRECTIONAL, color: *color, ..Light::default() }
        }
        SceneLight::Spot { position, direction, color, inner_cone, outer_cone, .. } => {
            let cos_outer = outer_cone.cos();
            // As KHR_lights_punctual recommends: at least 0.001 between the cosines.
            let cone_scale = 1.0 / (inner_cone.cos() - cos_outer).max(0.001);
            Light { position: place(position), kind: SPOT, direction: *direction, cos_outer, color: *color, cone_scale }
        }
    };
    let is_physical = options.integrator.is_physical();
    let with_intensity = |light: &SceneLight| {
        let mut of = traced(light);
        if is_physical {
            let (SceneLight::Point { intensity, .. }
            | SceneLight::Directional { intensity, .. }
            | SceneLight::Spot { intensity, .. }) = *light;
            let unit = if of.kind == DIRECTIONAL { 1.0 } else { units.to_traced(1.0).powi(2) };
            of.color = of.color.map(|part| part * intensity * unit);
        }
        of
    };
    scene.lights.iter().map(with_intensity).collect()
}

/// All texels in one buffer, linear, 16 bits per channel: enough to resolve the darkest steps of 8-bit sRGB.
pub(super) fn textures(textures: &[SceneTexture]) -> Result<(Vec<Texture>, Vec<u32>), SceneDataError> {
    let white = [SceneTexture {
        width: 1,
        height: 1,
        texels: vec![[255; 4]],
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        linear: false,
    }];
    let textures = if textures.is_empty() { &white } else { textures };
    let linear: Vec<u32> = (0..=255u32).map(|v| (srgb_to_linear(v as f32 / 255.0) * 65535.0).round() as u32).collect();
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let texels: usize = textures.iter().map(|t| t.texels.len()).sum();
    let (mut infos, mut words) = (Vec::new(), reserve("texels", 2 * texels)?);
    for t in textures {
        infos.push(Texture {
            first: (words.len() / 2) as u32,
            width: t.width as i32,
            height: t.height as i32,
            sampling: wrap(t.wrap_u) | wrap(t.wrap_v) << 2 | u32::from(t.linear) << 4,
        });
        words.extend(
            t.texels
                .iter()
                .flat_map(|&[r, g, b, _]| [linear[r as usize] | linear[g as usize] << 16, linear[b as usize]]),
        );
    }
    Ok((infos, words))
}
