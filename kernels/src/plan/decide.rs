//! Decides which options of the kernels a run needs, and why it does without the rest.

use raystep_scenes::{Light, Projection, Scene};

use super::{Because, LeftOut, Plan};
use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::keep::Item;
use crate::options::reasons::{Reason, Run};
use crate::options::samples::Samples;
use crate::options::{Accelerator, Numerics, Options, RaySource, Rule, ScheduleKind, Traversal};
use crate::scene_data::traced_camera;
use crate::shared::samples::Sampler;

/// Decides every option of the kernels.
pub(super) fn features(scene: &Scene, options: &Options, accelerator: Accelerator, units: Units) -> Features {
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
    let any_hit = options.any_hit && robust && options.without.is_none();
    let any_light = |f: fn(&Light) -> bool| scene.lights.iter().any(f);
    let any_material = |f: fn(&raystep_scenes::Material) -> bool| scene.materials.iter().any(f);
    Features {
        robust,
        watertight: robust && options.without != Some(Rule::TriangleTest),
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
        stack: 0,
        live_lists: options.schedule == ScheduleKind::Compact,
        scene_data: options.scene_data,
        fragments: options.mapping.fragment().is_some(),
        many_steps: options.schedule == ScheduleKind::Compact && options.steps_per_pass > 1,
        intervals: has_intervals(&options.rays, any_hit),
        any_hit,
        eye_rays: is_fused && !options.shade && !given,
        clip: keep(Item::Clipping) || !inside,
        perspective: match &options.rays {
            RaySource::Camera { camera, .. } => matches!(camera.projection, Projection::Perspective { .. }),
            RaySource::Given(_) => true,
        },
        counters: options.counters,
        normals: keep(Item::Normals) || scene.normals.is_some(),
        textures: keep(Item::Textures) || scene.texcoords.is_some() && any_material(|m| m.texture.is_some()),
        vertex_colors: keep(Item::VertexColors) || scene.colors.is_some(),
        many_materials: keep(Item::ManyMaterials) || scene.materials.len() > 1,
        emissive: keep(Item::Emission) || any_material(|m| m.emissive != [0.0; 3]),
        double_sided: keep(Item::DoubleSided) || any_material(|m| m.double_sided),
        many_lights: keep(Item::ManyLights) || scene.lights.len() > 1,
        directional_lights: keep(Item::DirectionalLights) || any_light(|l| matches!(l, Light::Directional { .. })),
        spot_lights: keep(Item::SpotLights) || any_light(|l| matches!(l, Light::Spot { .. })),
        resumes: false,
        resumes_scan: false,
        resumes_light: false,
        turns: 0,
        samples: options.samples.are_spread(),
        sobol: options.samples.are_spread() && options.samples.sampler == Sampler::Sobol,
        blocks: options.samples.count > Samples::BLOCK,
    }
}

/// Whether a ray has a t_min or a t_max that the kernels must look up.
fn has_intervals(rays: &RaySource, any_hit: bool) -> bool {
    let RaySource::Given(rays) = rays else { return false };
    rays.iter().any(|ray| ray.needs_interval(any_hit))
}

/// Everything in the program's tables that the plan leaves out.
pub(super) fn absent(plan: &Plan, options: &Options) -> Vec<LeftOut> {
    let mut all = Vec::new();
    let mut add = |what: String, (because, reason): Reason, item: Option<Item>| {
        // What the options do without, no item puts back.
        let item = item.filter(|_| because == Because::Scene);
        all.push(LeftOut { what, because, reason, item });
    };
    let run = Run { options, features: &plan.features, accelerator: plan.accelerator };
    let program = plan.program;
    for kernel in program.kernels().filter(|&kernel| plan.variant(kernel).is_none()) {
        add(format!("kernel {}", kernel.name()), (kernel.info().why_absent)(&run), None);
    }
    for stream in program.streams().filter(|&stream| !plan.has_stream(stream)) {
        add(format!("stream {}", stream.name()), (stream.info().why_absent)(&run), None);
    }
    for b in program.buffers.iter().filter(|b| !plan.buffers.iter().any(|p| p.what == b.name)) {
        add(format!("buffer {}", b.name), (b.why_absent)(&run), b.item);
    }
    all
}

/// Everything that a run of rays leaves out: rows of the tables, and code.
pub(super) fn left_out(plan: &Plan, scene: &Scene, options: &Options) -> Vec<LeftOut> {
    let mut all = absent(plan, options);
    let f = &plan.features;
    let one_light = if scene.lights.is_empty() { "no light: one headlight" } else { "one light" };
    let code = [
        (
            Item::Clipping,
            f.structure().has_cells() && f.robust,
            "code that clips rays to the grid",
            "the camera is inside the grid",
        ),
        (
            Item::RayPadding,
            f.bvh && options.without != Some(Rule::BoxPadding),
            "code that grows boxes by their distance",
            "growth by the reach of the scene hardly enlarges boxes",
        ),
        (Item::ManyLights, options.shade, "code for more than one light", one_light),
        (Item::DirectionalLights, options.shade, "code for directional lights", "no directional light"),
        (Item::SpotLights, options.shade, "code for spot lights", "no spot light"),
        (Item::Emission, options.shade, "code for emitted light", "no emissive material"),
        (Item::DoubleSided, options.shade, "code for double-sided materials", "no double-sided material"),
    ];
    for (item, _, what, reason) in code.into_iter().filter(|&(item, has_place, ..)| has_place && !f.has(item)) {
        all.push(LeftOut { what: what.into(), because: Because::Scene, reason, item: Some(item) });
    }
    // What this scene does without is what a reader wants to know.
    all.sort_by_key(|item| item.because != Because::Scene);
    all
}
