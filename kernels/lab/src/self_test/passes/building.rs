//! Grids built on the device, pass by pass beside the CPU reference kernels, and against the host's.

use std::ops::ControlFlow;

use raystep_kernels::options::ProgramName;
use raystep_kernels::programs::registered;
use raystep_kernels::{Accelerator, Device, GridSize, Kernel, Limits, Options, Plan, RaySource, RenderError, Renderer};
use raystep_scenes::{Camera, Scene, generate};

use super::{ALL, findings};
use crate::Error;
use crate::built::Built;
use crate::lockstep::{Lockstep, lockstep};
use crate::self_test::{Bench, Finding, Found, Group, Step, Verdict};
use crate::stability::Ceiling;

type Make = fn() -> Result<Scene, Error>;

/// Grids: of few cells; of more cells than a block of a scan has; of two levels; irregular; and around triangles that
/// are set aside.
const GRIDS: [(&str, Make, Accelerator, GridSize); 5] = [
    ("the Cornell box's grid", || Ok(generate::cornell_box()), Accelerator::Grid, GridSize::Auto),
    ("a fine grid", || Ok(generate::soup(60, 4)?), Accelerator::Grid, GridSize::Cells([32; 3])),
    ("a grid of two levels", crowd, Accelerator::Grid, GridSize::Auto),
    ("an irregular grid", || Ok(generate::cornell_box()), Accelerator::Irregular, GridSize::Auto),
    (
        "an irregular grid in a large room",
        || Ok(generate::tiny_in_room(100, 100)?),
        Accelerator::Irregular,
        GridSize::Auto,
    ),
];

/// Triangles all over a cube, and as many at one place in it.
fn crowd() -> Result<Scene, Error> {
    let mut scene = generate::soup(600, 4)?;
    let mut knot = scene.triangles.clone();
    knot.iter_mut().flatten().flatten().for_each(|v| *v = 0.3 + 0.01 * *v);
    scene.triangles.extend(knot);
    let materials = scene.triangle_materials.clone();
    scene.triangle_materials.extend(materials);
    Ok(scene)
}

pub(in crate::self_test) fn steps() -> Vec<Step> {
    let step = |(name, make, accelerator, grid): (&'static str, Make, Accelerator, GridSize)| {
        Step::new(Group::Building, name, &[ALL], move |bench| build(bench, name, &make()?, accelerator, grid))
    };
    let sorts = Step::new(Group::Building, "5,000 keys sorted", &[ALL], sort);
    GRIDS.into_iter().map(step).chain([sorts]).collect()
}

/// Sorts keys: a number that is no power of two.
fn sort(bench: &mut Bench) -> Found {
    let rays = RaySource::Camera { camera: Camera::framing(&Scene::default().bounds()), width: 1, height: 1 };
    let options = Options { program: ProgramName::Sort, elements: 5_000, ..Options::new(rays) };
    run(bench, "5,000 keys sorted", &Scene::default(), &options)
}

fn build(bench: &mut Bench, name: &str, scene: &Scene, accelerator: Accelerator, grid: GridSize) -> Found {
    let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 8, height: 8 };
    let options = Options { program: ProgramName::GridBuild, accelerator, grid, ..Options::new(rays) };
    run(bench, name, scene, &options)
}

fn run(bench: &mut Bench, name: &str, scene: &Scene, options: &Options) -> Found {
    let (found, is_hosts) = bench.machine.wait(beside(bench, scene, options))?;
    let done = Finding::new(Group::Building, ALL, Verdict::Right, "").counting(&[("configurations", 1)]);
    // A wrong pass is a finding of its kernel.
    let wrong = (!is_hosts && found.first.is_none()).then(|| format!("{name}: not what the host makes"));
    let wrong_of = |kernel: Kernel| {
        let first = found.first.iter().filter(|first| first.kernel == kernel);
        first.map(|first| format!("{name}: {first}")).collect()
    };
    let none = Ceiling { share: 0.0, because: "a build is the same on every device" };
    let kernels = findings(Group::Building, name, none, &found.compared, wrong_of);
    Ok((std::iter::once(done.wrong_by(wrong.into_iter().collect())).chain(kernels).collect(), Vec::new()))
}

/// Builds on the device and by the CPU reference kernels; then on the host.
async fn beside(bench: &Bench, scene: &Scene, options: &Options) -> Result<(Lockstep, bool), Error> {
    let (mut plan, data) = Plan::new(scene, options, &Limits::from(&*bench.gpu)).map_err(RenderError::from)?;
    let mut twins = Renderer::from_plan(plan.clone(), data.clone(), options, &Device::Cpu(None)).await?;
    (bench.faults.plan)(&mut plan);
    let mut ours = Renderer::from_plan(plan, data, options, &bench.machine.device).await?;
    let found = lockstep(&mut ours, &mut twins, |_| ControlFlow::Continue(())).await?;
    let is_hosts = found.first.is_none()
        && match &registered(options.program).alone {
            Some(alone) => (alone.are_right)(options, &ours.values(alone.results).await?),
            None => match Built::on_host(&ours, bench.machine.limits().storage_bytes / 4) {
                Ok(host) => Built::of(&ours).await? == host,
                Err(_) => false,
            },
        };
    Ok((found, is_hosts))
}
