//! Decides which options of the kernels a run needs.

use raystep_scenes::{Light, Optics, Projection, Scene};

use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::keep::Item;
use crate::options::samples::Samples;
use crate::options::{
    Accelerator, Gather, Integrator, Neighbours, Numerics, Options, Order, RaySource, Rule, ScheduleKind, Strategy,
    Traversal,
};
use crate::scene_data::traced_camera;
use crate::shared::samples::Sampler;

/// Decides every option of the kernels.
pub(in crate::programs) fn features(
    scene: &Scene,
    options: &Options,
    accelerator: Accelerator,
    units: Units,
) -> Features {
    let keep = |item| options.keep.has(item);
    let robust = options.numerics == Numerics::Robust;
    let has_grid = accelerator == Accelerator::Grid;
    let inside = match &options.rays {
        RaySource::Camera { camera, width, height } => {
            let c = traced_camera(camera, units, *width, *height);
            let spread = match camera.projection {
                Projection::Perspective { .. } => [0.0; 3],
                Projection::Orthographic { .. } => [0, 1, 2].map(|a| c.right[a].abs() + c.up[a].abs()),
            };
            let bounds = scene.bounds();
            let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
            !bounds.is_empty()
                && (0..3).all(|a| {
                    c.eye[a] - spread[a] > units.to_traced(min[a]) && c.eye[a] + spread[a] < units.to_traced(max[a])
                })
        }
        RaySource::Given(_) => false,
    };
    let is_fused = options.schedule == ScheduleKind::Fused;
    let given = matches!(options.rays, RaySource::Given(_));
    let exact_order = options.order == Order::Exact && robust && options.without.is_none();
    let any_hit = options.any_hit && robust && options.without.is_none();
    let all_hits = options.all_hits && exact_order && given;
    let any_light = |f: fn(&Light) -> bool| scene.lights.iter().any(f);
    let any_material = |f: fn(&raystep_scenes::Material) -> bool| scene.materials.iter().any(f);
    // From a light at the eye, every hit of a camera's ray is visible, but not what these rays see in a mirror.
    let is_lit = options.shade && options.integrator != Integrator::Local;
    let path = is_lit && options.integrator == Integrator::Path;
    let has_mirrors = any_material(|m| m.optics.is_specular());
    let photons = is_lit && options.integrator == Integrator::Photons;
    let is_physical = path || photons;
    let specular = (is_physical || is_lit && options.integrator == Integrator::Whitted) && has_mirrors;
    let glows = any_material(|m| m.emissive != [0.0; 3]);
    // By chance, a path finds only lights that have a size.
    let has_emitters = any_light(shines) || glows && (photons || options.strategy != Strategy::Bsdf);
    Features {
        robust,
        watertight: robust && options.without != Some(Rule::TriangleTest),
        exact_order,
        decides: false,
        contracted: options.contracted && robust,
        drifting: robust && has_grid && options.without == Some(Rule::TMax),
        dda: has_grid && !robust && options.traversal == Traversal::Dda3d,
        in_cell: has_grid && (!robust || options.without == Some(Rule::Acceptance)),
        grid: has_grid,
        irregular: accelerator == Accelerator::Irregular,
        aside: false,
        bvh: accelerator == Accelerator::Bvh,
        ray_padding: keep(Item::RayPadding),
        skip: false,
        wide: false,
        stack: 0,
        live_lists: options.schedule == ScheduleKind::Compact,
        scene_data: options.scene_data,
        fragments: options.mapping.fragment().is_some(),
        many_steps: options.schedule == ScheduleKind::Compact && options.steps_per_pass > 1,
        intervals: has_intervals(&options.rays, any_hit),
        any_hit,
        all_hits,
        leaves: specular || is_physical || all_hits,
        specular,
        dielectric: specular && !is_physical && any_material(|m| matches!(m.optics, Optics::Dielectric { .. })),
        path,
        whole_paths: false,
        mis: path && glows && options.strategy == Strategy::Mis,
        by_light: photons && glows || path && glows && options.strategy == Strategy::Light,
        photons,
        mapped: photons && has_emitters && options.max_depth > 1 && !scene.triangles.is_empty(),
        exact: photons && options.photons.neighbours == Neighbours::Exact,
        gathers_later: photons && options.photons.gather == Gather::Final,
        apart: false,
        depth: if specular || is_physical { options.max_depth } else { 0 },
        eye_rays: is_fused && !options.shade && !given,
        clip: keep(Item::Clipping) || !inside || specular || is_physical,
        perspective: match &options.rays {
            RaySource::Camera { camera, .. } => matches!(camera.projection, Projection::Perspective { .. }),
            RaySource::Given(_) => true,
        },
        counters: options.counters,
        normals: keep(Item::Normals) || scene.normals.is_some(),
        textures: keep(Item::Textures) || scene.texcoords.is_some() && any_material(|m| m.texture.is_some()),
        vertex_colors: keep(Item::VertexColors) || scene.colors.is_some(),
        many_materials: keep(Item::ManyMaterials) || scene.materials.len() > 1,
        emissive: keep(Item::Emission) || glows,
        double_sided: keep(Item::DoubleSided) || any_material(|m| m.double_sided),
        many_lights: keep(Item::ManyLights) || scene.lights.len() > 1,
        directional_lights: keep(Item::DirectionalLights) || any_light(|l| matches!(l, Light::Directional { .. })),
        spot_lights: keep(Item::SpotLights) || any_light(|l| matches!(l, Light::Spot { .. })),
        shadows: is_lit && if is_physical { has_emitters } else { specular || !scene.lights.is_empty() },
        resumes: false,
        resumes_exact: false,
        resumes_scan: false,
        resumes_light: false,
        turns: 0,
        samples: options.samples.are_spread(),
        // Photons are samples of the light, of which there are many in any run.
        sobol: (photons || options.samples.are_spread()) && options.samples.sampler == Sampler::Sobol,
        blocks: options.samples.count > Samples::BLOCK,
    }
}

/// Whether a light gives any.
fn shines(light: &Light) -> bool {
    let (Light::Point { color, intensity, .. }
    | Light::Directional { color, intensity, .. }
    | Light::Spot { color, intensity, .. }) = light;
    *intensity > 0.0 && color.iter().any(|&part| part > 0.0)
}

/// Whether a ray has a t_min or a t_max that the kernels must look up.
fn has_intervals(rays: &RaySource, any_hit: bool) -> bool {
    let RaySource::Given(rays) = rays else { return false };
    rays.iter().any(|ray| ray.needs_interval(any_hit))
}
