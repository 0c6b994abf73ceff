//! With `--order exact`, the nearest hit is the one that rational arithmetic finds, through every structure, by every
//! schedule and on every device.

use std::collections::BTreeSet;
use std::sync::Arc;

use raystep_kernels::options::mapping::{Fragment, Mapping};
use raystep_kernels::programs::closest_hit::kernels::DECIDE;
use raystep_kernels::shared::exact::values::rounded_values;
use raystep_kernels::{
    Accelerator, Caster, Device, Limits, Numerics, Options, Order, Plan, Ray, RaySource, ScheduleKind,
};
use raystep_lab::rays::Random;
use raystep_lab::reference::Triangles;
use raystep_scenes::Scene;
use raystep_tests::configurations::{FAST, STEPPED};
use raystep_tests::{
    Checked, block_on, check_each, devices, gpu, gpu_of, options, parity, rays, scene, scene_files, thorough,
};

pub(crate) type Corners = [[f32; 3]; 3];

/// Numbers from −1 to 1.
pub(crate) struct Numbers(pub(crate) Random);

impl Numbers {
    pub(crate) fn one(&mut self) -> f32 {
        (2.0 * self.0.unit() - 1.0) as f32
    }

    pub(crate) fn point(&mut self) -> [f32; 3] {
        [self.one(), self.one(), self.one()]
    }

    pub(crate) fn below(&mut self, most: usize) -> usize {
        (self.0.unit() * most as f64) as usize
    }

    /// A ray to a point of a triangle, of one of its edges, or to a corner.
    fn towards(&mut self, origin: [f32; 3], [a, b, c]: Corners) -> Ray {
        let [u, v] = [self.0.unit() as f32, self.0.unit() as f32];
        let [u, v] = [[0.5 * u, 0.5 * v], [u, 0.0], [0.0, 0.0]][self.below(3)];
        let direction = [0, 1, 2].map(|i| a[i] + u * (b[i] - a[i]) + v * (c[i] - a[i]) - origin[i]);
        Ray::new(origin, if direction == [0.0; 3] { [1.0, 0.0, 0.0] } else { direction })
    }
}

fn plus(a: [f32; 3], b: [f32; 3], by: f32) -> [f32; 3] {
    [0, 1, 2].map(|i| a[i] + by * b[i])
}

/// Triangles of one kind, and as many rays as asked for at them.
pub(crate) fn family(kind: &str, count: usize) -> (Vec<Corners>, Vec<Ray>) {
    let mut numbers = Numbers(Random::of(47, kind.len() as u32));
    let n = &mut numbers;
    let mut triangles = Vec::new();
    let mut distance = 2.0;
    for _ in 0..24 {
        let [a, b, c] = [n.point(), n.point(), n.point()];
        match kind {
            // Two corners, and a third that is nearly between them.
            "needles" => triangles.push([a, b, plus(plus(a, [0, 1, 2].map(|i| b[i] - a[i]), 0.4), c, 1e-6)]),
            // The other side is a few roundings away.
            "boards" => {
                let off = n.point();
                triangles.extend([[a, b, c], [a, b, c].map(|corner| plus(corner, off, 2e-7))]);
            }
            "duplicates" => triangles.extend([[a, b, c], [b, c, a], [a, c, b]]),
            // In one tilted plane, as far as f32 has points of it.
            "coplanar" => triangles.push([a, b, c].map(|[x, y, _]| [x, y, 0.3 * x - 0.7 * y])),
            "lattice" => triangles.push([a, b, c].map(|corner| corner.map(|v| (2.5 * v).round()))),
            "far" => triangles.extend([[a, b, c], [b, a, c].map(|corner| plus(corner, [1e-4; 3], 1.0))]),
            other => panic!("{other}"),
        }
    }
    if kind == "far" {
        distance = 1000.0;
    }
    let rays = (0..count).map(|_| {
        let target = triangles[n.below(triangles.len())];
        let origin = match kind {
            "lattice" => n.point().map(|v| (3.0 * v).round()),
            _ => n.point().map(|v| distance * v),
        };
        n.towards(origin, target)
    });
    let rays = rays.collect();
    (triangles, rays)
}

/// A hilly surface, and rays that graze it.
pub(crate) fn terrain(count: usize) -> (Vec<Corners>, Vec<Ray>) {
    const SIDE: usize = 12;
    let mut numbers = Numbers(Random::of(47, 99));
    let n = &mut numbers;
    let points: Vec<[f32; 3]> =
        (0..SIDE * SIDE).map(|i| [(i % SIDE) as f32, 0.01 * n.one(), (i / SIDE) as f32]).collect();
    let mut triangles = Vec::new();
    for i in (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE) {
        let [a, b, c, d] = [i, i + 1, i + SIDE, i + SIDE + 1].map(|i| points[i]);
        triangles.extend([[a, c, b], [b, c, d]]);
    }
    let rays = (0..count).map(|_| {
        let target = triangles[n.below(triangles.len())];
        let origin = [-3.0, 0.005 * n.one(), 12.0 * n.one()];
        n.towards(origin, target)
    });
    let rays = rays.collect();
    (triangles, rays)
}

pub(crate) const COMBINATIONS: [(Accelerator, ScheduleKind, u32); 11] = [
    (Accelerator::None, ScheduleKind::Fused, 1),
    (Accelerator::None, ScheduleKind::Second, 1),
    (Accelerator::Grid, ScheduleKind::Fused, 1),
    (Accelerator::Grid, ScheduleKind::First, 1),
    (Accelerator::Grid, ScheduleKind::Compact, 8),
    (Accelerator::Irregular, ScheduleKind::Fused, 1),
    (Accelerator::Irregular, ScheduleKind::Compact, 8),
    (Accelerator::Irregular, ScheduleKind::Second, 1),
    (Accelerator::Bvh, ScheduleKind::Fused, 1),
    (Accelerator::Bvh, ScheduleKind::Compact, 8),
    (Accelerator::Bvh, ScheduleKind::Compact, 1),
];

/// All combinations on the CPU; on the GPU, where composing kernels takes longer than a few rays, each with one of the kinds
/// in an ordinary run.
fn runs(place: usize, kinds: usize) -> impl Iterator<Item = ((Accelerator, ScheduleKind, u32), &'static str, Device)> {
    COMBINATIONS.into_iter().enumerate().flat_map(move |(index, combination)| {
        let is_taken = thorough() || index % kinds == place;
        let taken = devices().into_iter().filter(move |(_, device)| is_taken || !device.is_gpu());
        taken.map(move |(name, device)| (combination, name, device))
    })
}

/// The triangles that rays hit.
fn hits(scene: &Arc<Scene>, rays: &[Ray], options: &Options, device: &Device) -> Vec<Option<u32>> {
    let mut caster = block_on(gpu_of(device), Caster::new(scene.clone(), options, device)).expect("a caster");
    let hits = block_on(gpu_of(device), caster.cast(rays)).expect("hits");
    assert_eq!(caster.unfinished(), 0);
    hits.iter().map(|hit| hit.is_hit().then_some(hit.triangle)).collect()
}

#[test]
fn every_combination_hits_what_rational_arithmetic_finds() {
    let count = if thorough() { 150_000 } else { 400 };
    let mut rounded_otherwise = 0;
    let kinds = ["needles", "boards", "duplicates", "coplanar", "lattice", "far", "terrain"];
    for (place, kind) in kinds.into_iter().enumerate() {
        let (triangles, rays) = if kind == "terrain" { terrain(count) } else { family(kind, count) };
        let scene = Arc::new(Scene::from_triangles(triangles));
        let vertices: Vec<f32> = scene.triangles.iter().flatten().flatten().copied().collect();
        let exact = Triangles::new(&vertices);
        let wanted: Vec<Option<u32>> = rays
            .iter()
            .map(|ray| exact.candidates(ray.origin, ray.direction).exact.map(|(triangle, _)| triangle))
            .collect();
        let hit = wanted.iter().flatten().count();
        assert!(4 * hit > count, "{kind}: {hit} of {count} hit anything");
        for ((accelerator, schedule, steps_per_pass), name, device) in runs(place, kinds.len()) {
            let options = Options { accelerator, schedule, steps_per_pass, ..Caster::options() };
            let label = format!("{kind}, {accelerator} {schedule} {steps_per_pass} on {name}");
            let found = hits(&scene, &rays, &Options { order: Order::Exact, ..options.clone() }, &device);
            for (i, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
                assert_eq!(found, wanted, "{label}: {:?}", rays[i]);
            }
            let rounded = hits(&scene, &rays, &options, &device);
            rounded_otherwise += rounded.iter().zip(&wanted).filter(|(found, wanted)| found != wanted).count();
        }
    }
    // Otherwise nothing would have been tested.
    assert!(rounded_otherwise > 500, "rounding changed only {rounded_otherwise} hits");
}

/// The smallest t of a ray in its interval, each being the exact one rounded.
fn nearest_between(triangles: &[Corners], ray: &Ray) -> Option<f32> {
    let values = triangles.iter().filter_map(|corners| rounded_values(ray.origin, ray.direction, *corners));
    values.map(|[t, _, _]| t).filter(|t| ray.t_min < *t && *t < ray.t_max).min_by(f32::total_cmp)
}

/// Values are the exact ones, rounded once, and it is these that have to lie in an interval.
#[test]
fn rounded_values_are_reported_and_lie_between_the_ends_of_rays() {
    let count = if thorough() { 20_000 } else { 200 };
    let kinds = ["needles", "boards", "coplanar", "lattice", "far", "terrain"];
    for (place, kind) in kinds.into_iter().enumerate() {
        let (triangles, rays) = if kind == "terrain" { terrain(count) } else { family(kind, count) };
        let scene = Arc::new(Scene::from_triangles(triangles.clone()));
        // From a hit, to it, and from and to the next numbers.
        let rays: Vec<Ray> = rays
            .iter()
            .flat_map(|ray| {
                let t = nearest_between(&triangles, ray).unwrap_or(1.0);
                let ends = [(0.0, t), (t, f32::INFINITY), (0.0, t.next_up()), (t.next_down(), f32::INFINITY)];
                [*ray].into_iter().chain(ends.map(|(near, far)| ray.between(near, far)))
            })
            .collect();
        let wanted: Vec<Option<f32>> = rays.iter().map(|ray| nearest_between(&triangles, ray)).collect();
        for ((accelerator, schedule, steps_per_pass), name, device) in runs(place, kinds.len()) {
            let options = Options { accelerator, schedule, steps_per_pass, ..Caster::options() };
            let options = Options { order: Order::Exact, ..options };
            let mut caster =
                block_on(gpu_of(&device), Caster::new(scene.clone(), &options, &device)).expect("a caster");
            let hits = block_on(gpu_of(&device), caster.cast(&rays)).expect("hits");
            for ((hit, wanted), ray) in hits.iter().zip(&wanted).zip(&rays) {
                let label = format!("{kind}, {accelerator} {schedule} {steps_per_pass} on {name}: {ray:?} {hit:?}");
                assert_eq!(hit.is_hit().then_some(hit.t), *wanted, "{label}");
                if hit.is_hit() {
                    let corners = triangles[hit.triangle as usize];
                    let values = rounded_values(ray.origin, ray.direction, corners);
                    assert_eq!(values, Some([hit.t, hit.u, hit.v]), "{label}");
                }
            }
        }
    }
}

/// Whether anything is hit before a ray's end is decided by exact t, too.
#[test]
fn every_combination_finds_what_is_before_the_end_of_a_ray() {
    let count = if thorough() { 50_000 } else { 150 };
    let mut rounded_otherwise = 0;
    let kinds = ["needles", "boards", "coplanar", "lattice"];
    for (place, kind) in kinds.into_iter().enumerate() {
        let (triangles, rays) = family(kind, count);
        let scene = Arc::new(Scene::from_triangles(triangles));
        let vertices: Vec<f32> = scene.triangles.iter().flatten().flatten().copied().collect();
        let exact = Triangles::new(&vertices);
        let (mut until, mut wanted) = (Vec::new(), Vec::new());
        for (i, ray) in rays.into_iter().enumerate() {
            let candidates = exact.candidates(ray.origin, ray.direction);
            let t = candidates.exact.map_or(1.0, |(_, t)| t as f32);
            // At the nearest hit, as far as f32 has its t, and around that.
            let end = [t.next_down(), t, t.next_up()][i % 3].max(f32::MIN_POSITIVE);
            wanted.push(exact.are_hit_before(end, ray.origin, ray.direction, &candidates));
            until.push(ray.between(0.0, end));
        }
        for ((accelerator, schedule, steps_per_pass), name, device) in runs(place, kinds.len()) {
            let options = Options { accelerator, schedule, steps_per_pass, any_hit: true, ..Caster::options() };
            let label = format!("{kind}, {accelerator} {schedule} {steps_per_pass} on {name}");
            let found = hits(&scene, &until, &Options { order: Order::Exact, ..options.clone() }, &device);
            for (i, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
                assert_eq!(found.is_some(), *wanted, "{label}: {:?}", until[i]);
            }
            let rounded = hits(&scene, &until, &options, &device);
            rounded_otherwise +=
                rounded.iter().zip(&wanted).filter(|(found, wanted)| found.is_some() != **wanted).count();
        }
    }
    // Otherwise nothing would have been tested.
    assert!(rounded_otherwise > 100, "rounding changed only {rounded_otherwise} answers");
}

#[test]
fn no_ray_of_a_scene_is_left_undecided() {
    for file in scene_files() {
        let scene = scene(&file);
        if scene.triangles.is_empty() || scene.triangles.len() > 2000 {
            continue;
        }
        let side = if thorough() { 512 } else { 56 };
        let count = if thorough() { 10_000 } else { 300 };
        let pictures = options(&scene, side, side);
        let random = Options::new(RaySource::Given(rays::random(&scene, count, 8)));
        for options in [pictures, random] {
            let options = Options { order: Order::Exact, shade: false, ..options };
            for (configurations, device) in [(&FAST[..], Device::Gpu(gpu())), (&[STEPPED][..], Device::Cpu(None))] {
                for Checked { configuration, report, .. } in check_each(&scene, &options, configurations, &device) {
                    let label = format!("{file} {configuration}: {report}");
                    assert_eq!((report.errors(), report.counts.ties), (0, 0), "{label}\n{:#?}", report.mistakes);
                }
            }
        }
    }
}

/// Pass by pass, a device leaves what the CPU reference kernels leave, also where rays wait for another dispatch.
#[test]
fn integers_decide_alike_on_a_device_and_on_the_cpu() {
    let count = if thorough() { 400 } else { 80 };
    let mut seen = BTreeSet::new();
    for kind in ["needles", "coplanar", "terrain"] {
        let (triangles, rays) = if kind == "terrain" { terrain(count) } else { family(kind, count) };
        let scene = Scene::from_triangles(triangles);
        for (accelerator, schedule, steps_per_pass) in COMBINATIONS {
            let rays = RaySource::Given(rays.clone());
            let options = Options { accelerator, schedule, steps_per_pass, order: Order::Exact, ..Options::new(rays) };
            let options = Options { shade: false, counters: true, ..options };
            let label = format!("{kind}, {accelerator} {schedule} {steps_per_pass}");
            // Software Vulkan ends loops that take more.
            for turns in [40, 2048] {
                let found = parity::compare_in_turns(&gpu(), &scene, &options, turns);
                assert_eq!((found.breaches, found.miscounts), (vec![], vec![]), "{label}, {turns} turns");
                seen.extend(found.transitions.into_iter().filter(|(_, kernel, _)| *kernel == DECIDE));
            }
        }
    }
    let listed: BTreeSet<_> = DECIDE.sends().iter().map(|sent| (sent.from, DECIDE, sent.to)).collect();
    assert_eq!(seen, listed, "where decided rays go");
}

#[test]
fn only_runs_by_exact_t_have_rays_that_wait_for_integers() {
    let scene = scene("whitted.glb");
    let has = |order, name| {
        let plan =
            Plan::new(&scene, &Options { order, ..options(&scene, 8, 8) }, &Limits::from(&*gpu())).expect("a plan").0;
        let state = plan.program.states.iter().find(|state| state.name == name).expect("a state");
        plan.has_state(state)
    };
    assert_eq!([Order::Rounded, Order::Exact].map(|order| has(order, "EXACT")), [false, true]);
    assert!(["UNWRITTEN", "ISECT_HIT", "DONE"].into_iter().all(|name| has(Order::Rounded, name)));
}

#[test]
fn what_has_no_exact_order_is_refused_before_anything_is_built() {
    let scene = scene("whitted.glb");
    let exact = Options { order: Order::Exact, schedule: ScheduleKind::Second, ..options(&scene, 8, 8) };
    let limits = Limits::from(&*gpu());
    for (options, says) in [
        (Options { numerics: Numerics::Paper, ..exact.clone() }, "--numerics robust"),
        (Options { mapping: Mapping::Fragment(Fragment::default()), ..exact }, "--mapping compute"),
    ] {
        let refused = Plan::new(&scene, &options, &limits).expect_err("no exact order").to_string();
        assert!(refused.starts_with("--order exact: ") && refused.ends_with(says), "{refused}");
    }
}
