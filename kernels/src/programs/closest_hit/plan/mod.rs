//! Plans a run of rays: decides the structure, the options of the kernels and what their loops need, and prepares the
//! scene's data.

pub(in crate::programs) mod features;
mod left_out;
mod replaced;
pub(in crate::programs) mod resolve;
mod turns;
mod view;

use raystep_scenes::Scene;

use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::mapping::Until;
use crate::options::reasons::Run;
use crate::options::{Options, RaySource, ScheduleKind};
use crate::plan::allocated::{Allocated, sets_of};

use crate::plan::{
    DrawnPlan, Limits, Plan, PlanError, Sharing, bound_by, check_buffer, check_rays, check_samples, check_scene,
    check_texels, fit_bindings, image_size, variants as variants_of,
};
use crate::program::Program;
use crate::program::live::LIVE_RAYS;
use crate::program::schedule::Schedule;
use crate::scene_data::SceneData;
use crate::shader::Variant;
use crate::shared::photon_map::PhotonMap;
use crate::shared::scene::SceneInfo;
use crate::tables::elements::{Elements, Size};
use left_out::left_out;
use replaced::check_replaced;
pub(crate) use resolve::Built;
use resolve::{Resolved, resolve};
use turns::{Resumes, Walk};

/// The schedule of a run, its kernels as they are compiled, their draws, and the streams that share textures.
type Compiled = (Schedule, Vec<Variant>, Option<DrawnPlan>, Sharing);

/// A program that traces rays, and what differs between these when a run is planned.
#[derive(Clone, Copy)]
pub(in crate::programs) struct Tracer {
    pub(in crate::programs) program: &'static Program,
    /// What it has besides the rays of the image, for a scene with these corners.
    pub(in crate::programs) others: fn(&Options, &Features, &[f32], &Limits) -> Result<Others, PlanError>,
    /// How it orders its kernels.
    pub(in crate::programs) schedule: fn(&Options, &Features, &Others) -> Schedule,
}

/// What a program has besides the rays of the image.
#[derive(Default)]
pub(in crate::programs) struct Others {
    /// Sets of elements whose sizes are known.
    pub(in crate::programs) sets: Vec<(&'static Elements, Size)>,
    /// The grid that photons are sorted into.
    pub(in crate::programs) photon_map: PhotonMap,
}

impl Tracer {
    /// A program that has nothing but rays.
    pub(in crate::programs) fn of_rays(
        program: &'static Program,
        schedule: fn(&Options, &Features, &Others) -> Schedule,
    ) -> Self {
        Self { program, others: |_, _, _, _| Ok(Others::default()), schedule }
    }
}

/// Steps per pass of what is no walk, with the schedule `fused`.
const STEPS_OF_WHOLE: u32 = 64;

/// Whether rays can be sent on from their hits.
fn check_scattering(features: &Features) -> Result<(), PlanError> {
    if !(features.specular || features.path || features.photons) {
        return Ok(());
    }
    let name = match features {
        Features { photons: true, .. } => "photons",
        Features { path: true, .. } => "path",
        _ => "whitted",
    };
    let why = match features {
        Features { fragments: true, .. } => {
            "what is kept of a ray's way does not fit the outputs of a fragment program: use --mapping compute, or \
             --integrator shadows"
        }
        Features { intervals: true, .. } => {
            "rays with a t_min or a t_max cannot be reflected or refracted: omit these, or use --integrator shadows"
        }
        _ => return Ok(()),
    };
    let why = format!("--integrator {name}: {why}");
    Err(PlanError::Refused(why))
}

/// Plans a run of rays by a program, with the schedule that it has for options; `built` is the grid that the options ask for, if it is built already.
pub(in crate::programs) fn plan(
    tracer: Tracer,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
    built: Option<Built>,
) -> Result<(Plan, SceneData), PlanError> {
    let program = tracer.program;
    let units = Units::of(scene);
    let (width, height, rays) = image_size(options, limits)?;
    check_scene(scene, units)?;
    check_rays(options, units)?;
    check_samples(options)?;
    let given = matches!(options.rays, RaySource::Given(_));
    let Resolved { accelerator, mut features, structure, vertices, extent } =
        resolve(program, scene, options, units, limits, (width, height), built)?;

    check_scattering(&features)?;
    // The last options of the kernels to be decided are those that depend on iterations of loops.
    let is_fused = options.schedule == ScheduleKind::Fused;
    let triangles = scene.triangles.len() as u64;
    let lights = if options.shade { scene.lights.len().max(1) as u64 } else { 0 };
    let walk = Walk { features: &features, structure: &structure, triangles };
    let resumes = Resumes::of(&walk, is_fused, options.steps_per_pass, lights, limits);
    // A path has two rays at each of its hits.
    let of_path = 2 * (u64::from(features.depth) + 1);
    // A path cannot wait for integers in the middle.
    let may_be_whole = features.path && is_fused && !features.exact_order;
    let whole_paths = may_be_whole && !resumes.walk && walk.fits(of_path, limits);
    features.whole_paths = whole_paths;
    (features.resumes, features.resumes_exact) = (resumes.walk, resumes.exact);
    (features.resumes_scan, features.resumes_light) = (resumes.scan, resumes.light);
    features.turns = if resumes == Resumes::default() { 0 } else { limits.turns };
    let pass_bound = Walk { features: &features, structure: &structure, triangles }.most_passes(is_fused);
    // A query finds out with a pass that a kernel has no rays.
    let is_queried = options.mapping.fragment().is_some_and(|how| how.until == Until::Query);
    let pass_bound = if is_queried { pass_bound.saturating_mul(2).saturating_add(4) } else { pass_bound };

    // The walks of shadow rays follow that of the ray, and a pixel's rays are a list or a binary tree.
    let of_shadows = if features.path || features.photons { 1 } else { lights };
    let pass_bound = if features.shadows { pass_bound.saturating_mul(1 + of_shadows) } else { pass_bound };
    let rays_of_pixel = if features.dielectric { (2 << features.depth) - 1 } else { 1 + u64::from(features.depth) };
    let pass_bound = pass_bound.saturating_mul(rays_of_pixel);
    // Photons bounce as often as rays. What sorts and gathers them always ends.
    let pass_bound = if features.mapped { pass_bound.saturating_mul(2).saturating_add(1 << 20) } else { pass_bound };
    let others = (tracer.others)(options, &features, &vertices, limits)?;

    let compiled = |features: &Features| -> Result<Compiled, PlanError> {
        let schedule = (tracer.schedule)(options, features, &others);
        let variants = variants_of(program, &schedule, features, &options.replaced)?;
        let drawn =
            options.mapping.fragment().map(|how| DrawnPlan::new(how, &variants, features, limits)).transpose()?;
        let sharing = fit_bindings(program, &variants, drawn.as_ref(), features.scene_data, limits)?;
        Ok((schedule, variants, drawn, sharing))
    };
    let mut outcome = compiled(&features);
    // A kernel that does everything also binds everything.
    let does_not_fit = |error: &PlanError| !matches!(error, PlanError::Shader(_));
    if features.whole_paths && outcome.as_ref().is_err_and(does_not_fit) {
        features.whole_paths = false;
        outcome = compiled(&features);
    }
    let (schedule, variants, drawn, sharing) = outcome?;
    check_replaced(program, &variants, &Run { options, features: &features, accelerator })?;
    // What the kernels that were replaced bind is there, too: to compare with them.
    let own = if options.replaced.is_empty() { Vec::new() } else { variants_of(program, &schedule, &features, &[])? };
    let mut bound = bound_by(&variants);
    bound.extend(bound_by(&own));
    if bound.contains("texels") {
        check_texels(scene, options.scene_data, limits)?;
    }
    let info = SceneInfo {
        triangles: triangles as u32,
        // Where walks are whole, searches for photons are, unless they are long.
        steps: if is_fused { options.steps_per_pass.max(STEPS_OF_WHOLE) } else { options.steps_per_pass },
        rays: rays as u32,
        size: [width, height],
        ..SceneInfo::default()
    };
    let is_bound = |name: &str| bound.contains(name);
    let mut data = SceneData::of(scene, options, features, units, (vertices, structure), info, is_bound)?;
    (data.bounds, data.reach) = (extent.bounds, extent.reach);
    data.photon_map = others.photon_map;

    let size = Size { width, height, count: rays as u32 };
    let sets = sets_of(program, size, &others.sets, limits.image_side)?;
    let Allocated { sets, streams, buffers } =
        Allocated::new(program, sets, &bound, &data, given, limits, drawn.as_ref())?;
    // There may be more of other elements than rays.
    if let Some(live) = buffers.iter().find(|buffer| buffer.what == LIVE_RAYS) {
        check_buffer(LIVE_RAYS, live.bytes, limits)?;
    }
    let mut plan = Plan {
        program,
        sets,
        image_side: limits.image_side,
        most_elements: limits.rays,
        width,
        height,
        rays,
        triangles,
        accelerator,
        is_gpu: limits.is_gpu,
        features,
        schedule,
        variants,
        sharing,
        drawn,
        streams,
        buffers,
        left_out: Vec::new(),
        turns: limits.turns_of_users(),
        pass_bound,
    };
    plan.left_out = left_out(&plan, scene, options);
    Ok((plan, data))
}
