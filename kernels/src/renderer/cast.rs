//! Casts rays of other programs: a scene's structure is built and uploaded once, then slices of rays are traced through
//! it, one call after the other. Carr, Hall and Hart, *The Ray Engine* (2002), use a GPU in this way, as a coprocessor
//! that intersects rays and triangles for a program on the CPU.

mod hit;

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use raystep_scenes::Scene;

use super::{Device, RenderError, Renderer};
use crate::numbers::parallel::{for_chunks, map_ranges};
use crate::numbers::units::{Units, exp2};
use crate::options::mapping::Mapping;
use crate::options::samples::Samples;
use crate::options::{Accelerator, Options, Order, ProgramName, Ray, RaySource, ScheduleKind};
use crate::plan::{FARTHEST, Plan, PlanError, tiled, why_untraceable};
use crate::program::results::HitOf;
use crate::scene_data::{SceneData, traced_ray};
use crate::shared::constants::NO_TRIANGLE;
use crate::tables::stream::Region;
pub use hit::CastHit;

/// Rays per batch on a GPU, unless it has room for fewer: enough to keep it busy, in about 150 MB.
pub const RAYS_A_BATCH_GPU: u64 = 1 << 20;

/// Rays per batch of the twins, if they take streams: more would fall out of the CPU's caches between two passes over them.
pub const RAYS_A_BATCH_CPU: u64 = 1 << 16;

/// Fewest rays that streams are allocated for on a GPU, which takes as long for one.
const FEWEST_RAYS_GPU: u64 = 1 << 12;

/// The same for the twins, which take longer for each texel.
const FEWEST_RAYS_CPU: u64 = 1 << 4;

/// Rays per task of their check.
const RAYS_A_CHECK: usize = 1 << 12;

/// Rays per task that casts them without streams: enough to be worth scheduling, few enough to balance the load.
const RAYS_A_TASK: usize = 1 << 9;

/// The structure is built for rays that start this many times as far from the world's origin as the scene reaches.
const ORIGINS: f32 = 3.0;

/// A scene on a device, through which rays are cast.
///
/// A slice of any length is traced in batches. Their streams are allocated once for each power of four of rays; a batch
/// takes the smallest that hold it. On a CPU, where one kernel traces a ray from start to end, there are neither: rays stay
/// in registers. The structure's cells or boxes are grown by a bound on rounding errors that depends
/// on where rays start: if a ray starts farther from the world's origin than three times the scene's farthest point, and
/// farther than every ray before, the structure is built anew once. A BVH whose boxes are grown for each ray stays.
///
/// ```
/// use raystep_kernels::{Caster, Device, Ray};
/// use raystep_scenes::Scene;
/// # pollster::block_on(async {
/// let scene = Scene::from_triangles(vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]);
/// // The twins; `Device::Gpu(Gpu::new(&AdapterChoice::Best).await?)` for a GPU.
/// let mut caster = Caster::new(scene, &Caster::options(), &Device::Cpu(None)).await?;
///
/// let down = Ray::new([0.0, 0.0, 3.0], [0.0, 0.0, -2.0]);
/// let hits = caster.cast(&[down, down.between(0.0, 1.0)]).await?;
/// assert_eq!((hits[0].t, hits[0].triangle), (1.5, 0));
/// assert!(!hits[1].is_hit(), "the ray ends before the triangle");
///
/// // Again, with the same structure, and any number of rays.
/// assert_eq!(caster.cast(&vec![down; 10_000]).await?[9_999], hits[0]);
/// # Ok::<(), raystep_kernels::RenderError>(())
/// # }).unwrap();
/// ```
pub struct Caster {
    scene: Arc<Scene>,
    options: Options,
    device: Device,
    plan: Plan,
    data: Arc<SceneData>,
    batch: u64,
    /// Largest coordinate of an origin, in traced units, that the structure is built for.
    farthest_origin: f32,
    /// Runs for different numbers of rays, the smallest first.
    runs: Vec<Renderer>,
    unfinished: u64,
}

/// What rays need of the structure and the kernels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Needs {
    /// Largest coordinate of an origin, in traced units.
    farthest_origin: f32,
    /// Whether their intervals must be looked up.
    intervals: bool,
}

impl Caster {
    /// The options that are fastest for rays of any kind: the structure for the scene and the device, in one kernel.
    #[must_use]
    pub fn options() -> Options {
        let rays = RaySource::Given(Vec::new());
        Options { accelerator: Accelerator::Auto, schedule: ScheduleKind::Fused, ..Options::new(rays) }
    }

    /// Builds the structure. Of `options`, the mapping, rays, shading, samples, counters and timings do not matter; with
    /// [`Options::any_hit`], a ray's result is any hit in its interval instead of the closest; with [`Options::all_hits`], all
    /// hits can be asked for, see [`cast_all`](Self::cast_all).
    ///
    /// # Errors
    /// If the scene or the options do not fit the device, or the device fails.
    pub async fn new(scene: impl Into<Arc<Scene>>, options: &Options, device: &Device) -> Result<Self, RenderError> {
        let scene = scene.into();
        let options = Options {
            program: ProgramName::ClosestHit,
            mapping: Mapping::Compute,
            shade: false,
            counters: false,
            timings: false,
            keep_passes: false,
            samples: Samples::default(),
            rays: RaySource::Given(Vec::new()),
            // All hits have one.
            order: if options.all_hits { Order::Exact } else { options.order },
            ..options.clone()
        };
        let units = Units::of(&scene);
        let (plan, data, farthest_origin) =
            planned(&scene, &options, device, ORIGINS * reach_of(&scene, units)).await?;
        let batch = if device.is_gpu() { RAYS_A_BATCH_GPU } else { RAYS_A_BATCH_CPU };
        let batch = batch.min(device.limits().rays);
        let (device, runs) = (device.clone(), Vec::new());
        let mut caster = Self { scene, options, device, plan, data, batch, farthest_origin, runs, unfinished: 0 };
        if caster.hit_of().is_none() {
            // Uploads the scene, and shows now whether the device takes the kernels.
            caster.run_for(1).await?;
        }
        Ok(caster)
    }

    /// Traces so many rays at a time from now on, or as many as the device has room for if that is fewer.
    pub fn set_batch(&mut self, rays: u64) {
        self.batch = rays.clamp(1, self.device.limits().rays);
    }

    /// Rays that are traced at a time.
    #[must_use]
    pub fn batch(&self) -> u64 {
        self.batch
    }

    /// The plan of the runs, except for the number of their rays.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The scene as the kernels read it.
    #[must_use]
    pub fn data(&self) -> &SceneData {
        &self.data
    }

    /// Number of rays so far that were still walking when the limit of passes was reached, and whose results are what
    /// was found by then. 0 with robust numerics.
    #[must_use]
    pub fn unfinished(&self) -> u64 {
        self.unfinished
    }

    /// Why a ray cannot be traced in this scene, if it cannot: a number is not finite, its direction is 0, or it starts
    /// too far away.
    #[must_use]
    pub fn fault(&self, ray: &Ray) -> Option<&'static str> {
        why_untraceable(ray, self.data.units)
    }

    /// The results of these rays, in their order.
    ///
    /// # Errors
    /// If a ray cannot be traced, with its index, in which case none is; or the device fails.
    pub async fn cast(&mut self, rays: &[Ray]) -> Result<Vec<CastHit>, RenderError> {
        let mut hits = Vec::new();
        self.cast_into(rays, &mut hits).await?;
        Ok(hits)
    }

    /// As [`cast`](Self::cast), with the results appended to `hits`.
    ///
    /// # Errors
    /// As for `cast`; `hits` may then have the results of some batches.
    pub async fn cast_into(&mut self, rays: &[Ray], hits: &mut Vec<CastHit>) -> Result<(), RenderError> {
        let needs = self.needs(rays)?;
        self.make_room_for(needs).await?;
        self.cast_after(rays, &[], hits).await
    }

    /// Casts rays for which there is room, each for its next hit after that on a triangle, if all hits are wanted; without
    /// triangles, each for its first.
    pub(super) async fn cast_after(
        &mut self,
        rays: &[Ray],
        last: &[u32],
        hits: &mut Vec<CastHit>,
    ) -> Result<(), RenderError> {
        let first = hits.len();
        if let Some(hit_of) = self.hit_of() {
            self.cast_at_once(hit_of, (rays, last), hits);
        } else {
            hits.reserve(rays.len());
            let most = usize::try_from(self.batch).unwrap_or(usize::MAX);
            for (index, batch) in rays.chunks(most).enumerate() {
                let last = last.chunks(most).nth(index).unwrap_or(&[]);
                self.cast_batch(batch, last, hits).await?;
            }
        }
        if self.plan.features.exact_order && !matches!(self.device, Device::CpuF64(_)) {
            for_chunks(&mut hits[first..], RAYS_A_TASK, |begin, hits| {
                for (hit, ray) in hits.iter_mut().zip(&rays[begin..]) {
                    hit.round(ray, &self.data);
                }
            });
        }
        Ok(())
    }

    /// Checks the rays, and finds what they need.
    pub(super) fn needs(&self, rays: &[Ray]) -> Result<Needs, PlanError> {
        let (units, any_hit) = (self.data.units, self.plan.features.any_hit);
        let of_part = |range: Range<usize>| {
            let mut needs = Needs::default();
            for (index, ray) in range.clone().zip(&rays[range]) {
                let farthest = ray.origin.iter().fold(0.0, |m: f32, &v| m.max(units.to_traced(v).abs()));
                if (ray.fault().is_some() || f64::from(farthest) > FARTHEST)
                    && let Some(reason) = self.fault(ray)
                {
                    return Err(PlanError::Ray { index, reason });
                }
                needs.farthest_origin = needs.farthest_origin.max(farthest);
                needs.intervals |= ray.needs_interval(any_hit);
            }
            Ok(needs)
        };
        map_ranges(rays.len(), RAYS_A_CHECK, of_part).into_iter().try_fold(Needs::default(), |all, part| {
            let part = part?;
            let farthest_origin = all.farthest_origin.max(part.farthest_origin);
            Ok(Needs { farthest_origin, intervals: all.intervals || part.intervals })
        })
    }

    /// Builds the structure or composes the kernels anew if rays need it.
    pub(super) async fn make_room_for(&mut self, needs: Needs) -> Result<(), RenderError> {
        let farthest = needs.farthest_origin;
        let has_intervals = self.plan.features.intervals;
        // Boxes that are grown for each ray serve all of them.
        let serves_all = self.plan.features.bvh && self.plan.features.ray_padding;
        if farthest > self.farthest_origin && !serves_all {
            self.runs.clear();
            (self.plan, self.data, self.farthest_origin) =
                planned(&self.scene, &self.options, &self.device, farthest).await?;
            if has_intervals {
                self.plan.read_intervals(Arc::make_mut(&mut self.data))?;
            }
        }
        if !self.plan.features.intervals && needs.intervals {
            self.runs.clear();
            self.plan.read_intervals(Arc::make_mut(&mut self.data))?;
        }
        Ok(())
    }

    /// The run for this many rays or somewhat more.
    async fn run_for(&mut self, rays: u64) -> Result<&mut Renderer, RenderError> {
        let mut room = if self.device.is_gpu() { FEWEST_RAYS_GPU } else { FEWEST_RAYS_CPU };
        while room < rays {
            room *= 4;
        }
        let room = room.min(self.batch).max(rays);
        let place = self.runs.partition_point(|run| run.plan().rays < room);
        if self.runs.get(place).is_none_or(|run| run.plan().rays != room) {
            let plan = Arc::new(self.plan.for_rays(room, &self.data, &self.device.limits())?);
            let beside = self.runs.first();
            let run = Renderer::for_later(plan, self.data.clone(), &self.options, &self.device, beside).await?;
            self.runs.insert(place, run);
        }
        Ok(&mut self.runs[place])
    }

    /// What a ray hits, if the twins can keep it in registers from its start to its hit.
    fn hit_of(&self) -> Option<HitOf> {
        let Plan { program, features, .. } = &self.plan;
        let is_at_once = self.options.schedule == ScheduleKind::Fused && !features.resumes;
        let [in_f32, in_f64] = program.results.filter(|_| is_at_once && self.plan.replaced().is_empty())?.hit_of;
        match self.device {
            #[cfg(feature = "gpu")]
            Device::Gpu(_) => None,
            Device::Cpu(_) => Some(in_f32),
            Device::CpuF64(_) => Some(in_f64),
        }
    }

    /// Casts all rays on all cores, without streams.
    fn cast_at_once(&self, hit_of: HitOf, (rays, last): (&[Ray], &[u32]), hits: &mut Vec<CastHit>) {
        let first = hits.len();
        hits.resize(first + rays.len(), CastHit::MISS);
        for_chunks(&mut hits[first..], RAYS_A_TASK, |begin, hits| {
            for (index, hit) in (begin..).zip(hits) {
                let (traced, exponent) = traced_ray(&rays[index], self.data.units);
                let last = last.get(index).copied().unwrap_or(NO_TRIANGLE);
                if let Some((triangle, values)) = hit_of(&traced, last, &self.data) {
                    *hit = CastHit::in_scene(&self.scene, triangle, values, exp2(exponent));
                }
            }
        });
    }

    async fn cast_batch(&mut self, rays: &[Ray], last: &[u32], hits: &mut Vec<CastHit>) -> Result<(), RenderError> {
        if rays.is_empty() {
            return Ok(());
        }
        let (scene, any_unfinished, is_gpu) = (self.scene.clone(), self.unfinished, self.device.is_gpu());
        let run = self.run_for(rays.len() as u64).await?;
        let in_row = run.plan().width as usize;
        // CPU threads do not wait for their neighbours.
        let place = |ray| if is_gpu { tiled(ray, in_row, rays.len()) } else { ray };
        if is_gpu {
            let (mut placed, mut last_placed) = (rays.to_vec(), last.to_vec());
            for (index, ray) in rays.iter().enumerate() {
                placed[place(index)] = *ray;
            }
            for (index, last) in last.iter().enumerate() {
                last_placed[place(index)] = *last;
            }
            run.give(&placed, &last_placed);
        } else {
            run.give(rays, last);
        }
        run.run(|_| ControlFlow::Continue(())).await?;
        let results = run.results()?;
        let width = run.plan().width;
        let rows = Region { x: 0, y: 0, width, height: (rays.len() as u64).div_ceil(u64::from(width)) as u32 };
        let hit = run.region(results.triangle.stream, rows).await?;
        let state = run.region(results.t.stream, rows).await?;
        hits.extend((0..rays.len()).map(place).map(|ray| {
            let Some((triangle, t)) = results.hit(&state, &hit, ray) else { return CastHit::MISS };
            let [u, v] = results.weights.map(|layer| hit.get_f32(layer, ray));
            CastHit::in_scene(&scene, triangle, [t, u, v], run.t_scale(ray))
        }));
        self.unfinished = any_unfinished + run.unfinished();
        Ok(())
    }
}

/// Largest coordinate of a scene, in traced units.
fn reach_of(scene: &Scene, units: Units) -> f32 {
    let bounds = scene.bounds();
    if bounds.is_empty() { 0.0 } else { units.to_traced(bounds.min.abs().max(bounds.max.abs()).max_element()) }
}

/// Plans runs of rays whose origins have coordinates of at most `farthest` traced units. Also returns the largest
/// coordinate that the structure is built for, which may be larger.
async fn planned(
    scene: &Scene,
    options: &Options,
    device: &Device,
    farthest: f32,
) -> Result<(Plan, Arc<SceneData>, f32), RenderError> {
    let units = Units::of(scene);
    let most = f64::from(farthest).min(FARTHEST) * units.scene_units_per_stream_unit();
    let origin = most.min(f64::from(f32::MAX)) as f32;
    let farthest = units.to_traced(origin);
    let rays = RaySource::Given([-origin, origin].map(|v| Ray::new([v; 3], [1.0, 0.0, 0.0])).to_vec());
    let (plan, data) = Plan::on(scene, &Options { rays, ..options.clone() }, device).await?;
    // What a structure is grown for is a power of two, so there may be room for farther origins.
    let [low, high] = data.bounds;
    let room = data.reach - (0..3).map(|axis| high[axis].max(-low[axis])).fold(0.0, f32::max);
    Ok((plan, Arc::new(data), farthest.max(room.next_down())))
}
