//! Bounces of a scene with a mirror, glass, lights and a floor that glows, on the CPU.

use raystep_kernels::history::RunSoFar;
use raystep_kernels::history::light_tree::{LightTree, VertexKind};
use raystep_kernels::options::{Integrator, Strategy};
use raystep_kernels::programs::closest_hit::states::DONE;
use raystep_kernels::programs::closest_hit::streams::{BOUNCE, COLOR, STATE};
use raystep_kernels::{Accelerator, Device, Limits, Options, Plan, RaySource, Samples, ScheduleKind};
use raystep_scenes::{Scene, generate};

use super::*;

const SIDE: u32 = 16;

fn scene() -> Scene {
    let mut scene = generate::whitted(1).expect("a scene");
    scene.materials[0].emissive = [0.25, 0.5, 0.0];
    scene
}

fn options(schedule: ScheduleKind, strategy: Strategy, count: u32) -> Options {
    let rays = RaySource::Camera { camera: scene().cameras[0].clone(), width: SIDE, height: SIDE };
    let samples = Samples { count, seed: 3, ..Samples::default() };
    let base = Options::new(rays);
    let steps_per_pass = if schedule == ScheduleKind::Compact { 8 } else { 1 };
    let (integrator, accelerator) = (Integrator::Path, Accelerator::Bvh);
    Options { integrator, accelerator, schedule, steps_per_pass, strategy, max_depth: 5, samples, ..base }
}

fn renderer(options: &Options) -> Renderer {
    pollster::block_on(Renderer::new(&scene(), options, &Device::Cpu(None))).expect("a renderer")
}

fn counted(renderer: &mut Renderer, place: usize) -> Bounces {
    let found = pollster::block_on(bounces(renderer, place, |_| ControlFlow::Continue(())));
    found.expect("a run").expect("paths")
}

/// All that bounces add is the picture, and every path that begins one ends there or begins the next.
#[test]
fn the_light_of_all_bounces_is_that_of_the_picture() {
    for strategy in [Strategy::Mis, Strategy::Light, Strategy::Bsdf] {
        let mut renderer = renderer(&options(ScheduleKind::Compact, strategy, 1));
        let found = counted(&mut renderer, 0);
        let color = pollster::block_on(renderer.values(COLOR)).expect("colours");
        let of = |ray| luminance([0, 1, 2].map(|c| f64::from(color.get_f32(c, ray))));
        let mean = (0..(SIDE * SIDE) as usize).map(of).sum::<f64>() / f64::from(SIDE * SIDE);
        // Each pixel's sum has a rounding for each of up to a dozen vertices.
        assert!((found.light() - mean).abs() < 1e-6 * mean && mean > 0.1, "{} {mean}", found.light());
        assert_eq!((found.rows[0].paths, found.rows.len()), (u64::from(SIDE * SIDE), 6));
        assert!((found.rows[0].throughput() - 1.0).abs() < 1e-6);
        let mut left = found.rows[0].paths;
        for (depth, row) in found.rows.iter().enumerate() {
            assert_eq!(row.paths, left, "{depth}");
            left -= row.ended.iter().sum::<u64>();
            assert!(row.occluded <= row.shadow_rays && row.shadow_rays <= row.paths, "{row:?}");
        }
        assert_eq!(left, 0);
        let sum = |of: &dyn Fn(&Bounce) -> u64| found.rows.iter().map(of).sum::<u64>();
        for why in [Ending::Escape, Ending::Depth, Ending::Roulette] {
            assert!(sum(&|row| row.ended[why as usize]) > 0, "{why:?}: {:?}", found.rows);
        }
        assert!(sum(&|row| row.occluded) > 10);
    }
}

/// Bounces do not depend on how steps are grouped into passes; each begins where the table says.
#[test]
fn every_schedule_has_the_same_bounces() {
    let mut first: Option<Bounces> = None;
    for schedule in [ScheduleKind::First, ScheduleKind::Second, ScheduleKind::Compact] {
        let mut renderer = renderer(&options(schedule, Strategy::Mis, 2));
        let place = |renderer: &mut Renderer| {
            renderer.restart();
            pollster::block_on(renderer.run_to_sample(1, |_| ControlFlow::Continue(()))).expect("a sample");
            renderer.passes().iter().position(|pass| pass.sample == 1)
        };
        let place = place(&mut renderer).unwrap_or(renderer.pass_count());
        let mut found = counted(&mut renderer, place);
        assert_eq!(found.sample, 1, "{schedule}");
        for (depth, row) in found.rows.iter_mut().enumerate() {
            let alive = pollster::block_on(async {
                renderer.restart();
                renderer.run_to(row.place, |_| ControlFlow::Continue(())).await.expect("a run");
                let [state, bounce] = [renderer.values(STATE).await, renderer.values(BOUNCE).await];
                let (state, bounce) = (state.expect("states"), bounce.expect("bounces"));
                let is_there = |&ray: &usize| {
                    let is_done = depth > 0 && state.get(0, ray) == DONE;
                    !is_done && bounce.get(0, ray) == depth as u32
                };
                (0..(SIDE * SIDE) as usize).filter(is_there).count()
            });
            assert_eq!(alive as u64, row.paths, "{schedule}, {depth}");
            row.place = 0;
        }
        found.brightest.iter_mut().for_each(|brightest| brightest.place = 0);
        let first = first.get_or_insert_with(|| found.clone());
        assert_eq!(*first, found, "{schedule}");
    }
}

/// A pixel's brightest vertex is that of its light tree.
#[test]
fn the_brightest_vertex_is_one_of_the_light_tree() {
    for strategy in [Strategy::Mis, Strategy::Light] {
        let mut renderer = renderer(&options(ScheduleKind::Compact, strategy, 1));
        let found = counted(&mut renderer, 0);
        assert!(found.brightest.is_sorted_by(|a, b| a.luminance() >= b.luminance()));
        assert!(found.brightest.len() > 200);
        let (plan, data) = (renderer.shared_plan(), renderer.shared_data());
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let mut techniques = [0; 3];
        for brightest in &found.brightest {
            let life = run.follow::<f32>(brightest.pixel).expect("a ray");
            let tree = LightTree::of(&life.rows, plan.program, &data).expect("a tree");
            let most =
                tree.vertices.iter().max_by(|a, b| luminance(a.contribution).total_cmp(&luminance(b.contribution)));
            let most = most.expect("a vertex");
            assert_eq!((most.contribution, most.depth), (brightest.light, brightest.depth), "{brightest:?}");
            let kind = match brightest.technique {
                Technique::EmitterHit => VertexKind::Surface,
                Technique::LightSample => VertexKind::Light,
                Technique::Background => VertexKind::Background,
            };
            assert_eq!(most.kind, kind, "{brightest:?}");
            techniques[brightest.technique as usize] += 1;
        }
        assert!(techniques.iter().all(|&count| count > 5), "{techniques:?}");
    }
}

/// What emitters bring is weighted as the densities tell: where a path hits one, and where a shadow ray reaches one, beside the
/// same ray of a run in which nothing is weighted.
#[test]
fn weights_are_those_by_which_light_was_counted() {
    let glow = [0.25f32, 0.5, 0.0];
    let mut scene = generate::cornell_box();
    scene.lights.clear();
    scene.materials[0].emissive = glow;
    let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: SIDE, height: SIDE };
    let trees = |strategy| {
        let options = Options { rays: rays.clone(), ..options(ScheduleKind::Compact, strategy, 1) };
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let of_pixel = |ray| {
            let life = run.follow::<f32>([ray % SIDE, ray / SIDE]).expect("a ray");
            LightTree::of(&life.rows, plan.program, &data).expect("a tree")
        };
        (0..SIDE * SIDE).map(of_pixel).collect::<Vec<_>>()
    };
    let [mis, light] = [Strategy::Mis, Strategy::Light].map(trees);
    // Some dozen roundings of 6e-8, and one of a sum of up to 1 that is divided by a throughput of 0.03 and more.
    let is_near = |a: f64, b: f64| (a - b).abs() < 1e-5 + 1e-4 * b;
    let mut seen = [0; 2];
    for (mis, light) in mis.iter().zip(&light) {
        for vertex in &mis.vertices {
            let Some((density, arrives)) = vertex.density.zip(vertex.arrives) else { continue };
            assert!((0.0..=1.0).contains(&density.weight), "{vertex:?}");
            if vertex.kind == VertexKind::Surface {
                let share = f64::from(arrives[1] / glow[1]);
                assert!(is_near(share, density.weight), "{share}: {vertex:?}");
                seen[0] += usize::from(density.pdf.is_some() && density.weight < 0.999);
            }
        }
        // The first shadow ray is the same.
        let first =
            |tree: &LightTree| tree.vertices.iter().find(|v| v.kind == VertexKind::Light && v.depth == 0).cloned();
        let Some((weighted, whole)) = first(mis).zip(first(light)) else { continue };
        let (density, of_whole) = weighted.density.zip(whole.density).expect("densities");
        assert_eq!((density.pdf, of_whole.weight), (of_whole.pdf, 1.0));
        let [weighted, whole] = [&weighted, &whole].map(|vertex| f64::from(vertex.arrives.expect("light")[1]));
        assert!(is_near(weighted / whole, density.weight), "{weighted} of {whole}: {density:?}");
        seen[1] += usize::from(density.weight < 0.999);
    }
    assert!(seen.iter().all(|&count| count > 5), "{seen:?}");
}

#[test]
fn a_run_without_paths_has_no_bounces_and_a_count_can_be_stopped() {
    let path = options(ScheduleKind::Compact, Strategy::Mis, 1);
    let mut whitted = renderer(&Options { integrator: Integrator::Whitted, ..path.clone() });
    assert!(!has_bounces(whitted.plan()));
    let found = pollster::block_on(bounces(&mut whitted, 0, |_| ControlFlow::Continue(())));
    assert_eq!(found.expect("nothing to run"), None);
    let mut renderer = renderer(&path);
    assert!(has_bounces(renderer.plan()));
    let mut calls = 0;
    let stopped = pollster::block_on(bounces(&mut renderer, 0, |_| {
        calls += 1;
        if calls == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }));
    assert!(matches!(stopped, Err(RenderError::Cancelled { passes: 3 })), "{stopped:?}");
}
