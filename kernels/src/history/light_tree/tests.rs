//! The light tree of every pixel of a room: its sum is the picture, and it is the same however rays are traced.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use raystep_scenes::{Scene, generate};

use super::*;
use crate::history::{Rays, RunSoFar, trace};
use crate::options::{Accelerator, Integrator, Options, ScheduleKind};
use crate::plan::{Limits, Plan};
use crate::program::RayState;
use crate::programs::light::tests::{options, room};
use crate::renderer::{Device, Renderer};
use crate::{Numerics, Samples};

const WIDTH: u32 = 24;
const HEIGHT: u32 = 12;

/// A room, and the background around it.
fn seen_from_afar() -> Scene {
    let mut scene = room();
    scene.cameras.iter_mut().for_each(|camera| camera.eye.z += 2.5);
    scene
}

/// Largest error of a colour, relative to 1: a sum of a few lights, each rounded, times a colour, and the mean of samples.
const ROUNDED: f64 = 32.0 * 0.5 * f32::EPSILON as f64;

/// Every pixel's history and tree.
fn trees(scene: &Scene, options: &Options, limits: &Limits) -> Vec<(Trace, LightTree)> {
    let (plan, data) = Plan::new(scene, options, limits).expect("a small scene");
    let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
    let pixels = (0..WIDTH * HEIGHT).map(|i| [i % WIDTH, i / WIDTH]);
    let tree = |pixel: [u32; 2]| {
        let life = run.follow::<f32>(pixel).expect("a ray");
        let tree = LightTree::of(&life.rows, plan.program, &data).expect("a tree");
        (life, tree)
    };
    pixels.map(tree).collect()
}

fn color(life: &Trace) -> [f32; 3] {
    life.rows.last().and_then(|row| row.after.color).expect("a finished ray")
}

fn assert_adds_up(life: &Trace, tree: &LightTree, label: &str) {
    let (sum, color) = (tree.sum(), color(life));
    for (c, (sum, color)) in sum.iter().zip(color).enumerate() {
        let off = (sum - f64::from(color)).abs();
        assert!(off <= ROUNDED * sum.max(1.0), "{label} {:?}, channel {c}: {sum} for {color}\n{tree:#?}", life.pixel);
    }
}

/// What does not depend on structure and schedule: passes do, and which of several blockers is found.
fn plain(tree: &LightTree) -> Vec<Vertex> {
    let plain = |vertex: &Vertex| {
        let mut vertex = vertex.clone();
        (vertex.cast, vertex.decided, vertex.ended) = (Step::default(), None, None);
        if let Fate::Occluded { .. } = vertex.fate {
            vertex.fate = Fate::Occluded { triangle: 0, point_scene: [0.0; 3] };
            vertex.why.clear();
        }
        vertex
    };
    tree.vertices.iter().map(plain).collect()
}

#[test]
fn contributions_add_up_to_the_picture_and_every_structure_and_schedule_has_the_same_tree() {
    let scene = seen_from_afar();
    let mut first: Option<Vec<Vec<Vertex>>> = None;
    let mut ends = BTreeSet::new();
    for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        for (schedule, steps_per_pass) in
            [(ScheduleKind::First, 1), (ScheduleKind::Second, 1), (ScheduleKind::Compact, 8)]
        {
            let options = Options { accelerator, schedule, steps_per_pass, ..options(&scene, WIDTH, HEIGHT) };
            let label = format!("{accelerator} {schedule}");
            let found = trees(&scene, &options, &Limits::CPU);
            for (life, tree) in &found {
                assert_adds_up(life, tree, &label);
                assert!(tree.vertices.iter().all(|v| v.decided.is_some() && v.ended.is_some()), "{label} {tree:#?}");
                let words =
                    tree.vertices.iter().map(|v| v.why.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned());
                ends.extend(words);
            }
            let found: Vec<_> = found.iter().map(|(_, tree)| plain(tree)).collect();
            let first = first.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{label}");
        }
    }
    let wanted = [
        "all of its light is known",
        "background",
        "faces away from light ",
        "light 1 is visible",
        "light 2 is visible",
        "light 3 is visible",
        "no light is left",
        "occluded by triangle ",
        "outside the cone of light ",
    ];
    assert_eq!(ends.iter().map(String::as_str).collect::<Vec<_>>(), wanted);
}

#[test]
fn with_several_samples_or_light_by_light_the_sum_is_the_picture_too() {
    let scene = seen_from_afar();
    let plain = options(&scene, WIDTH, HEIGHT);
    let samples = Samples { count: 18, ..Samples::default() };
    let few_turns = Limits { turns: 2, ..Limits::CPU };
    for (options, limits, label) in [
        (Options { samples, ..plain.clone() }, Limits::CPU, "samples"),
        (plain.clone(), few_turns, "turns"),
        (Options { numerics: Numerics::Paper, accelerator: Accelerator::Grid, ..plain.clone() }, Limits::CPU, "paper"),
    ] {
        let found = trees(&scene, &options, &limits);
        for (life, tree) in &found {
            assert_adds_up(life, tree, label);
            let cameras = tree.vertices.iter().filter(|vertex| vertex.kind == VertexKind::Camera).count();
            assert_eq!(cameras, options.samples.count as usize, "{label}");
        }
        let waits = |row: &&TraceRow| row.kernel == "illuminate" && row.after.state == "SHADE";
        let waits = found.iter().flat_map(|(life, _)| &life.rows).filter(waits).count();
        assert!((label == "turns") == (waits > 0), "{label}: {waits} waits for another dispatch");
    }
}

#[test]
fn a_walk_in_one_pass_has_the_same_tree() {
    let scene = seen_from_afar();
    let stepped = options(&scene, WIDTH, HEIGHT);
    let wanted = trees(&scene, &stepped, &Limits::CPU);
    let fused = Options { schedule: ScheduleKind::Fused, ..stepped };
    pollster::block_on(async {
        let mut renderer = Renderer::new(&scene, &fused, &Device::Cpu(None)).await.expect("a renderer");
        for i in [0, 40, 100, 136, 200] {
            let go_on = |_: &_| ControlFlow::Continue(());
            let life = trace(&mut renderer, i % WIDTH, i / WIDTH, Rays::One, go_on).await.expect("a history");
            let tree = LightTree::of(&life.rows, renderer.plan().program, renderer.data()).expect("a tree");
            assert_adds_up(&life, &tree, "fused");
            assert_eq!(plain(&tree), plain(&wanted[i as usize].1), "pixel {i}");
        }
    });
}

/// Mirrors and glass send on rays, which make deeper surfaces with lights of their own.
#[test]
fn what_mirrors_and_glass_send_on_adds_up_to_the_picture() {
    let scene = generate::whitted(1).expect("a scene");
    let base = Options { integrator: Integrator::Whitted, ..options(&scene, WIDTH, HEIGHT) };
    let samples = Samples { count: 2, ..Samples::default() };
    let mut ends = BTreeSet::new();
    let (mut first, mut deepest) = (None, 0);
    for (options, label) in [
        (Options { accelerator: Accelerator::Grid, ..base.clone() }, "grid"),
        (Options { accelerator: Accelerator::Bvh, schedule: ScheduleKind::Second, ..base.clone() }, "bvh"),
        (Options { samples, ..base.clone() }, "samples"),
        (Options { max_depth: 1, ..base.clone() }, "depth 1"),
    ] {
        let found = trees(&scene, &options, &Limits::CPU);
        for (life, tree) in &found {
            assert_adds_up(life, tree, label);
            assert!(tree.vertices.iter().all(|v| v.decided.is_some() && v.ended.is_some()), "{label} {tree:#?}");
            let surfaces = tree.vertices.iter().filter(|vertex| vertex.kind == VertexKind::Surface);
            ends.extend(surfaces.map(|vertex| format!("{}: {}", vertex.ray, vertex.why)));
            deepest = tree.vertices.iter().map(|vertex| vertex.depth).fold(deepest, u32::max);
        }
        if label == "grid" {
            first = Some(found.iter().map(|(_, tree)| plain(tree)).collect::<Vec<_>>());
        } else if label == "bvh" {
            assert!(
                first == Some(found.iter().map(|(_, tree)| plain(tree)).collect()),
                "another structure, another tree"
            );
        }
    }
    for wanted in ["camera: reflects", "reflected: no light is left", "refracted: no light is left"] {
        assert!(ends.iter().any(|end| end.starts_with(wanted)), "{wanted}: {ends:?}");
    }
    assert!(ends.iter().any(|end| end.ends_with("at the largest depth, 1: sends no ray on")), "{ends:?}");
    assert!(deepest > 2, "{deepest}");
}

#[test]
fn only_rays_to_lights_make_a_tree() {
    let scene = seen_from_afar();
    let dark = Scene { lights: Vec::new(), ..scene.clone() };
    for (scene, integrator) in [(&scene, Integrator::Local), (&dark, Integrator::Shadows)] {
        let options = Options { integrator, ..options(scene, WIDTH, HEIGHT) };
        let (plan, data) = Plan::new(scene, &options, &Limits::CPU).expect("a small scene");
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let life = run.follow::<f32>([12, 9]).expect("a ray");
        assert_eq!(LightTree::of(&life.rows, plan.program, &data), None, "{integrator:?}");
    }
}

/// While a run is stepped, the tree is that of the passes so far.
#[test]
fn a_tree_grows_with_the_rows_and_knows_whose_pass_each_is() {
    let scene = seen_from_afar();
    let options = options(&scene, WIDTH, HEIGHT);
    let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
    let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
    let life = run.follow::<f32>([12, 9]).expect("a ray");
    let whole = LightTree::of(&life.rows, plan.program, &data).expect("a tree");
    let (mut vertices, mut open) = (0, 0);
    for row in 0..life.rows.len() {
        let tree = LightTree::of(&life.rows[..=row], plan.program, &data).expect("a tree");
        assert!(tree.vertices.len() >= vertices);
        vertices = tree.vertices.len();
        open += usize::from(tree.vertices.iter().any(|vertex| vertex.fate == Fate::Open));
        let at = whole.at_row(row).map(|at| &whole.vertices[at]).expect("a vertex");
        let is_shadow = life.rows[row].after.light.is_some();
        assert_eq!(is_shadow, at.kind == VertexKind::Light && at.fate != Fate::NotCast, "row {row}: {at:?}");
        if let Some(light) = life.rows[row].after.light {
            assert_eq!(at.light, Some(light), "row {row}");
        }
    }
    assert_eq!(vertices, whole.vertices.len());
    assert!(open > 3, "{open} rows with a shadow ray on its way");
    let text = whole.table(&life, Units::Scene);
    let names: Vec<&str> = text
        .lines()
        .skip(5)
        .map(|line| line.split("  ").find(|word| !word.is_empty()).unwrap_or(""))
        .take_while(|name| !name.is_empty())
        .collect();
    assert_eq!(names.len(), whole.vertices.len(), "{text}");
}

#[test]
fn texels_that_were_edited_make_no_tree_that_panics() {
    let scene = seen_from_afar();
    let (plan, data) = Plan::new(&scene, &options(&scene, WIDTH, HEIGHT), &Limits::CPU).expect("a small scene");
    let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
    let life = run.follow::<f32>([12, 9]).expect("a ray");
    for edit in [
        (|ray: &mut RayState| ray.triangle = Some(u32::MAX)) as fn(&mut RayState),
        |ray| ray.light = ray.light.map(|_| u32::MAX),
        |ray| ray.light = Some(0),
        |ray| ray.item = u32::MAX,
        |ray| ray.barycentric = None,
        |ray| ray.samples = Some(u32::MAX),
        |ray| ray.tag = ray.tag.wrapping_mul(2_654_435_761) % 14,
    ] {
        for from in 0..life.rows.len() {
            let mut rows = life.rows.clone();
            rows[from..].iter_mut().for_each(|row| edit(&mut row.after));
            let tree = LightTree::of(&rows, plan.program, &data);
            let told = tree.map(|tree| tree.table(&life, Units::Traced) + &tree.sentence(0));
            assert!(told.is_none_or(|told| told.contains("light tree")));
        }
    }
}

/// A camera, two surfaces one after the other, and rays from the first again: as a program does that reflects and refracts.
#[test]
fn deeper_surfaces_are_below_those_that_their_rays_left() {
    let data = SceneData::default();
    let mut grower = Grower::new(&data);
    let ray = (crate::programs::light::PROGRAM.rays.expect("rays").decode)(&|_| None);
    let at = |depth: u32| Vertex { depth, ..Vertex::new(VertexKind::Surface, Place::Point([0.0; 3])) };
    let light =
        |of: f64| Vertex { contribution: [of; 3], ..Vertex::new(VertexKind::Light, Place::Direction([1.0; 3])) };
    let step = |row: usize| Step { row, pass: Some(row) };
    grower.go_to(step(0));
    grower.from_camera(0, [0.0; 3]);
    for (row, depth, of) in [(1, 0, 1.0), (3, 1, 2.0), (5, 2, 4.0), (7, 1, 8.0)] {
        grower.go_to(step(row));
        grower.hit(&ray, at(depth));
        grower.go_to(step(row + 1));
        grower.add(light(of));
        grower.cast_ray("reflected");
    }
    grower.add(Vertex {
        depth: 2,
        contribution: [16.0; 3],
        ..Vertex::new(VertexKind::Background, Place::Direction([1.0; 3]))
    });
    let tree = grower.finish().expect("a tree");
    let parents: Vec<_> = tree.vertices.iter().map(|vertex| vertex.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(1), Some(1), Some(3), Some(3), Some(5), Some(1), Some(7), Some(7)]);
    let branches: Vec<f64> = tree.branches().iter().map(|rgb| rgb[0]).collect();
    assert_eq!(branches, [31.0, 31.0, 1.0, 6.0, 2.0, 4.0, 4.0, 24.0, 8.0, 16.0]);
    let order = tree.in_order();
    assert!(order.iter().map(|&(i, _)| i).eq(0..10), "{order:?}");
    let levels: Vec<_> = order.iter().map(|&(_, level)| level).collect();
    assert_eq!(levels, [0, 1, 2, 2, 3, 3, 4, 2, 3, 3]);
    assert_eq!(tree.vertices[5].cast, step(4), "its ray left the surface after its light was sampled");
}
