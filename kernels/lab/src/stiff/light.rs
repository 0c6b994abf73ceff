//! Light at the hits of a run: every ray to a light judged in f64, and the light itself compared with the f64 twins'.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::shared::start::start_of;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::state::Tag;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Kernel, RenderError, Renderer, Stream, StreamData};

use crate::reference::{Candidates, Tree, Triangles};
use crate::statistics::{median, quantile};
use crate::tidy::Row;
use crate::tidy::fill::per_million;
use crate::work::{begins_walks, is_shadow};

/// What a run found on its way to the light of each ray.
#[derive(Clone, Debug, Default)]
struct Lit {
    /// Rays to lights.
    cast: u64,
    /// Of these, rays for which f32 cannot decide.
    undecided: u64,
    /// Of these, rays that were decided wrongly.
    wrong: u64,
    /// Of these, rays that begin so near to another surface that rounding may have put their start on its other side.
    close: u64,
    /// For each ray, whether each of its rays to lights was blocked, in their order.
    blocked: Vec<Vec<bool>>,
    /// Each ray's light: r, g, b.
    light: Vec<[f64; 3]>,
}

/// What the light of a point's rays is compared with, made when it is first needed.
#[derive(Default)]
pub(super) struct Reference {
    /// The light of each number of rays in f64, by all rules.
    exact: BTreeMap<usize, Lit>,
    tree: Option<Arc<Tree>>,
}

impl Reference {
    /// Fills a row's columns of light: `found` runs on the device, pass by pass, and `exact` makes the same run in f64.
    pub(super) async fn fill(
        &mut self,
        row: Row,
        found: &mut Renderer,
        exact: impl Future<Output = Result<Renderer, RenderError>>,
    ) -> Result<Row, RenderError> {
        let vertices = found.data().vertices.clone();
        let tree = self.tree.get_or_insert_with(|| Triangles::new(&vertices).tree()).clone();
        let lit = Lit::of(found, Some(&Triangles::with(&vertices, tree))).await?;
        let exact = match self.exact.entry(lit.light.len()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(Lit::of(&mut exact.await?, None).await?),
        };
        Ok(lit.fill(row, exact))
    }
}

/// A ray on its way to a light.
struct Shadow {
    /// The ray that it belongs to.
    ray: usize,
    origin: [f32; 3],
    direction: [f32; 3],
    /// t of the light.
    end: f32,
}

/// Where a plan's rays to lights are.
struct Streams {
    begins: Kernel,
    /// States of those that have not arrived.
    on_their_way: Vec<Tag>,
    origin: Stream,
    direction: Stream,
    t: Stream,
    triangle: Stream,
}

impl Streams {
    /// `None` if the plan casts none.
    fn of(renderer: &Renderer) -> Result<Option<Self>, RenderError> {
        let (plan, results) = (renderer.plan(), renderer.results()?);
        let kernels = plan.variants.iter().map(|variant| variant.kernel);
        let shadow: Vec<Kernel> = kernels.filter(|&k| (begins_walks(k) || k.is_walk()) && is_shadow(k, plan)).collect();
        let on_their_way = shadow.iter().flat_map(|kernel| kernel.takes()).copied().collect();
        let of = |begins: Kernel| {
            let here = |own: Stream| begins.stream(own);
            Some(Self {
                begins,
                on_their_way,
                origin: here(results.origin)?,
                direction: here(results.direction)?,
                t: here(results.t.stream)?,
                triangle: here(results.triangle.stream)?,
            })
        };
        Ok(shadow.iter().copied().find(|&kernel| begins_walks(kernel)).and_then(of))
    }
}

impl Lit {
    /// Runs from the start to the end, and judges every ray to a light by these triangles, if there are any: of a run in f64,
    /// streams have rounded rays.
    async fn of(renderer: &mut Renderer, judge: Option<&Triangles<'_>>) -> Result<Self, RenderError> {
        let (results, rays) = (renderer.results()?, renderer.plan().rays as usize);
        let mut lit = Self { blocked: vec![Vec::new(); rays], ..Self::default() };
        if let Some(streams) = Streams::of(renderer)? {
            let mut on_way: Vec<Shadow> = Vec::new();
            while let Some(kernel) = renderer.next_kernel() {
                let is_after_walk = kernel.role() == Role::Finish;
                if is_after_walk && !on_way.is_empty() {
                    let tags = renderer.values(streams.t).await?;
                    let found = renderer.values(streams.triangle).await?;
                    let hits = renderer.values(results.triangle.stream).await?;
                    let is_on_way = |shadow: &Shadow| streams.on_their_way.contains(&tags.get(STATE_TAG, shadow.ray));
                    let (left, arrived) = on_way.into_iter().partition(is_on_way);
                    on_way = left;
                    for shadow in arrived {
                        let [blocker, own] = [&found, &hits].map(|s| s.get(results.triangle.layer, shadow.ray));
                        lit.arrived(&shadow, blocker, own, judge);
                        if let Some(triangles) = judge {
                            let corners = renderer.data().corners(own);
                            lit.close += u64::from(begins_close(shadow.origin, (own, corners), triangles));
                        }
                    }
                }
                renderer.step().await?;
                if is_after_walk {
                    let state = renderer.values(streams.t).await?;
                    let is_cast = |ray: &usize| streams.begins.takes().contains(&state.get(STATE_TAG, *ray));
                    if !(0..rays).any(|ray| is_cast(&ray)) {
                        continue;
                    }
                    let (origin, direction) =
                        (renderer.values(streams.origin).await?, renderer.values(streams.direction).await?);
                    let vector = |of: &StreamData, ray: usize| [0, 1, 2].map(|layer| of.get_f32(layer, ray));
                    let shadow = |ray: usize| Shadow {
                        ray,
                        origin: vector(&origin, ray),
                        direction: vector(&direction, ray),
                        end: state.get_f32(results.t.layer, ray),
                    };
                    on_way.extend((0..rays).filter(is_cast).map(shadow));
                }
            }
        } else {
            while renderer.step().await?.is_some() {}
        }
        let color = renderer.values(results.color).await?;
        let value = |layer: usize, ray: usize| {
            let wide = renderer.cpu_f64().and_then(|e| e.component(results.color, layer, ray));
            wide.unwrap_or_else(|| f64::from(color.get_f32(layer, ray)))
        };
        lit.light = (0..rays).map(|ray| [0, 1, 2].map(|layer| value(layer, ray))).collect();
        Ok(lit)
    }

    /// Counts a ray to a light that leaves the triangle `own`, and ended at `blocker` or at none.
    fn arrived(&mut self, shadow: &Shadow, blocker: u32, own: u32, triangles: Option<&Triangles<'_>>) {
        let is_blocked = blocker != NO_TRIANGLE;
        self.cast += 1;
        self.blocked[shadow.ray].push(is_blocked);
        if let Some(triangles) = triangles {
            let may_hit = triangles.candidates(shadow.origin, shadow.direction).within([0.0, f64::from(shadow.end)]);
            let (wrong, undecided) = verdict(&may_hit, is_blocked.then_some(blocker), own);
            self.wrong += u64::from(wrong);
            self.undecided += u64::from(undecided);
        }
    }

    /// Fills the columns of light; `exact` is the same run in f64.
    fn fill(&self, row: Row, exact: &Self) -> Row {
        let largest = |rgb: [f64; 3]| rgb.into_iter().fold(0.0, f64::max);
        let is_same = |ray: &usize| self.blocked[*ray] == exact.blocked[*ray];
        let error = |ray: usize| {
            let (found, exact) = (self.light[ray], exact.light[ray]);
            let off = [0, 1, 2].map(|c: usize| (found[c] - exact[c]).abs());
            (largest(exact) > 0.0).then(|| largest(off) / largest(exact))
        };
        let errors: Vec<f64> = (0..self.light.len()).filter(is_same).filter_map(error).collect();
        row.set("shadow_rays", self.cast)
            .set("undecided_shadow_rays", self.undecided)
            .set("wrong_shadow_rays", self.wrong)
            .set("wrong_shadow_per_million", per_million(self.wrong, self.cast))
            .set("close_shadow_starts", self.close)
            .set("light_error_median", median(&errors))
            .set("light_error_largest", quantile(&errors, 1.0))
            .set("lit_otherwise_rays", (0..self.light.len()).filter(|ray| !is_same(ray)).count())
    }
}

/// Whether another surface is within the bound by which a ray's origin is off the triangle that it leaves, to either side
/// along the normal. The bound is also that of the point itself, so the origin may be on the wrong side of it.
fn begins_close(origin: [f32; 3], (own, corners): (u32, [Vec3<f64>; 3]), triangles: &Triangles<'_>) -> bool {
    let start = start_of(corners, [1.0 / 3.0; 2], Vec3::splat(0.0));
    [start.normal, -start.normal].into_iter().any(|way| {
        let way = way.to_array().map(|c| c as f32);
        let near = triangles.candidates(origin, way).within([0.0, 2.0 * start.distance]);
        near.possible.iter().any(|possible| possible.triangle != own)
    })
}

/// Whether a ray to a light was decided wrongly, and whether f32 cannot decide it. The surface that it leaves is no tie: the
/// ray goes away from it.
fn verdict(may_hit: &Candidates, blocker: Option<u32>, own: u32) -> (bool, bool) {
    let surely = may_hit.possible.iter().any(|possible| possible.is_definite);
    let is_undecided = !surely && may_hit.possible.iter().any(|possible| possible.triangle != own);
    match blocker {
        None => (surely, is_undecided),
        Some(by) => (by == own || !may_hit.possible.iter().any(|possible| possible.triangle == by), is_undecided),
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::options::Integrator;
    use raystep_kernels::{Accelerator, Device, Options, Plan, RaySource, ScheduleKind};
    use raystep_scenes::{Light, Scene};

    use super::*;
    use crate::stiff::COLUMNS;

    /// A square under a light, a smaller one between them, and rays from above beside that.
    fn scene() -> (Scene, RaySource) {
        let square = |half: f32, y: f32| {
            let [a, b, c, d] = [[-half, -half], [-half, half], [half, half], [half, -half]].map(|[x, z]| [x, y, z]);
            [[a, b, c], [a, c, d]]
        };
        let mut scene = crate::stability::make::scene_of([square(1.0, 0.0), square(0.3, 0.5)].concat());
        scene.lights = vec![Light::Point { position: [0.0, 1.0, 0.0], color: [1.0; 3], intensity: 1.0 }];
        let ray = |i: u32| {
            let target = [-0.95 + 0.05 * i as f32, 0.0, 0.013 * i as f32 - 0.4];
            // From the side, below the smaller square.
            raystep_kernels::Ray::new([target[0] + 0.2, 0.4, target[2]], [-0.2, -0.4, 0.0])
        };
        (scene, RaySource::Given((0..38).map(ray).collect()))
    }

    fn lit(device: &Device, judges: bool, accelerator: Accelerator, schedule: ScheduleKind, off: f32) -> Lit {
        let (scene, rays) = scene();
        let options = Options { integrator: Integrator::Shadows, accelerator, schedule, ..Options::new(rays) };
        let (plan, mut data) = Plan::new(&scene, &options, &raystep_kernels::Limits::CPU).expect("a plan");
        for light in &mut data.lights {
            light.color = light.color.map(|of| of * (1.0 + off));
        }
        pollster::block_on(async {
            let mut renderer = Renderer::from_plan(plan, data, &options, device).await.expect("a renderer");
            let vertices = renderer.data().vertices.clone();
            let triangles = Triangles::new(&vertices);
            Lit::of(&mut renderer, judges.then_some(&triangles)).await.expect("a run")
        })
    }

    #[test]
    fn every_ray_to_the_light_is_judged_and_its_light_compared() {
        let exact = lit(&Device::CpuF64(None), false, Accelerator::Bvh, ScheduleKind::Fused, 0.0);
        assert_eq!((exact.cast, exact.wrong, exact.undecided), (38, 0, 0));
        let blocked = exact.blocked.iter().filter(|of| of[..] == [true]).count();
        assert!((10..30).contains(&blocked), "{blocked}");
        for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
            for schedule in [ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused] {
                let found = lit(&Device::Cpu(None), true, accelerator, schedule, 0.0);
                assert_eq!((found.cast, found.wrong), (38, 0), "{accelerator} {schedule}");
                let row = found.fill(Row::new(COLUMNS), &exact);
                assert_eq!((row.get("shadow_rays"), row.get("lit_otherwise_rays")), ("38", "0"));
                // A few roundings.
                let error = row.number("light_error_largest").expect("an error");
                assert!(error > 0.0 && error < 1e-6, "{accelerator} {schedule}: {error}");
            }
        }
        let brighter = lit(&Device::Cpu(None), true, Accelerator::Bvh, ScheduleKind::Fused, 0.01);
        let row = brighter.fill(Row::new(COLUMNS), &exact);
        assert!((row.number("light_error_median").expect("an error") - 0.01).abs() < 1e-5, "{row:?}");
        // A ray that was decided otherwise has another light, which is no error of arithmetic.
        let mut other = brighter;
        other.blocked[3] = vec![!other.blocked[3][0]];
        assert_eq!(other.fill(Row::new(COLUMNS), &exact).get("lit_otherwise_rays"), "1");
    }

    /// Of two sheets, the rays from one begin close to the other only if it is within f32's bound on a point, above or below.
    #[test]
    fn starts_within_their_bound_of_another_surface_are_counted() {
        for (gap, is_close) in [(1e-7, true), (-1e-7, true), (1e-5, false), (-1e-5, false)] {
            let square = |y: f32| {
                [[[-1.0, y, -1.0], [-1.0, y, 1.0], [1.0, y, 1.0]], [[-1.0, y, -1.0], [1.0, y, 1.0], [1.0, y, -1.0]]]
            };
            let scene = crate::stability::make::scene_of([square(0.0), square(gap)].concat());
            let vertices: Vec<f32> = scene.triangles.iter().flatten().flatten().copied().collect();
            let corners = scene.triangles[0].map(Vec3::<f64>::from_f32);
            let triangles = Triangles::new(&vertices);
            let start = start_of(corners, [0.25; 2], Vec3::splat(0.0));
            let origin = (start.point + start.normal * start.distance).to_array().map(|c| c as f32);
            assert_eq!(begins_close(origin, (0, corners), &triangles), is_close, "{gap}");
        }
    }

    #[test]
    fn what_blocks_a_ray_must_be_possible_and_what_surely_blocks_it_must_be_found() {
        let (scene, _) = scene();
        let vertices: Vec<f32> = scene.triangles.iter().flatten().flatten().copied().collect();
        let triangles = Triangles::new(&vertices);
        let of = |x: f32, end: f64, blocker: Option<u32>, own: u32| {
            let may_hit = triangles.candidates([x, 0.0, 0.1], [0.0, 1.0, 0.0]).within([0.0, end]);
            verdict(&may_hit, blocker, own)
        };
        let blocked_by = if of(0.0, 1.0, Some(2), 0).0 { 3 } else { 2 };
        assert_eq!(of(0.0, 1.0, Some(blocked_by), 0), (false, false));
        assert_eq!(of(0.0, 1.0, None, 0), (true, false), "a leak");
        assert_eq!(of(0.0, 1.0, Some(1), 0), (true, false), "not in its way");
        assert_eq!(of(0.0, 1.0, Some(blocked_by), blocked_by), (true, false), "what it leaves");
        assert_eq!(of(0.8, 1.0, None, 0), (false, false));
        assert_eq!(of(0.8, 1.0, Some(2), 0), (true, false), "a false shadow");
        assert_eq!(of(0.0, 0.4, None, 0), (false, false), "behind the light");
        assert_eq!((of(0.0, 0.5, None, 0), of(0.0, 0.5, Some(blocked_by), 0)), ((false, true), (false, true)), "a tie");
    }
}
