//! Passes of our own kernels whose elements read each other, interpreted: the same streams as the twins' after every pass.

use std::collections::BTreeSet;
use std::sync::Arc;

use raystep_scenes::{Camera, Scene, generate};

use super::*;
use crate::options::{Accelerator, GridSize, Integrator, Options, PhotonSort, Photons, ProgramName, RaySource};
use crate::plan::{Limits, Plan};
use crate::program::schedule::Cursor;
use crate::program::{Kernel, Twin};
use crate::programs::all;
use crate::shader::Variant;
use crate::tables::state::Population;

/// Interprets a plan's kernels whose elements read each other.
fn interpreting<R: Precision>(plan: &Arc<Plan>, data: &SceneData) -> [CpuExecutor<R>; 2] {
    let executor = || {
        let mut executor = CpuExecutor::<R>::new(plan, None).expect("memory");
        assert!(data.inputs.iter().all(|input| executor.write(input)), "inputs");
        executor
    };
    let mut interpreted = executor();
    let is_pass = |variant: &&Variant| matches!(variant.kernel.info().twin, Twin::Pass(_));
    interpreted.interpreted = plan.variants.iter().filter(is_pass).map(|v| Interpreted::new(v, u32::MAX)).collect();
    [executor(), interpreted]
}

/// Runs a plan by its twins and by the interpreter, and compares all streams after every pass. Returns the kernels that ran.
pub(crate) fn agree<R: Precision>(plan: Plan, data: &SceneData) -> BTreeSet<Kernel> {
    let plan = Arc::new(plan);
    let [mut twins, mut interpreted] = interpreting::<R>(&plan, data);
    let (mut cursor, mut ran) = (Cursor::start(), BTreeSet::new());
    let mut population = Population { sets: plan.program.elements, ..Population::default() };
    population.in_set = twins.sizes().counts();
    while let Some(kernel) = cursor.next(&plan.schedule, &population) {
        let call = Call { kernel, parameter: cursor.parameter };
        let result = twins.run(call, data).expect("a pass of the twin");
        let other = interpreted.run(call, data).unwrap_or_else(|why| panic!("{kernel:?}: {why}"));
        assert_eq!((&result.sizes, result.threads_launched), (&other.sizes, other.threads_launched), "{kernel:?}");
        assert_eq!(interpreted.race(), None);
        for stream in plan.streams.iter().map(|planned| planned.what) {
            let same = twins.read(stream) == interpreted.read(stream);
            assert!(same, "{kernel:?}, parameter {}: other values in {stream:?}", call.parameter);
        }
        population.in_set = result.sizes;
        population.in_state = result.counts.unwrap_or_default();
        ran.insert(kernel);
    }
    ran
}

fn planned(scene: &Scene, options: &Options) -> (Plan, SceneData) {
    Plan::new(scene, options, &Limits::CPU).expect("a plan")
}

fn options(program: ProgramName) -> Options {
    Options { program, ..Options::new(RaySource::Given(Vec::new())) }
}

#[test]
fn every_kernel_whose_elements_read_each_other_is_interpreted_as_its_twin_computes() {
    let mut ran = BTreeSet::new();
    for elements in [1, 2, 700] {
        let (plan, data) = planned(&Scene::default(), &Options { elements, ..options(ProgramName::Sort) });
        ran.extend(agree::<f32>(plan, &data));
    }
    let build = options(ProgramName::GridBuild);
    let irregular = Options { accelerator: Accelerator::Irregular, ..build.clone() };
    let cells = |cells| Options { grid: GridSize::Cells(cells), ..build.clone() };
    let room = generate::cornell_box();
    for (scene, options) in [
        (&room, &build),
        (&room, &cells([13, 7, 29])),
        (&room, &irregular),
        (&generate::soup(60, 4).expect("soup"), &irregular),
        (&generate::tiny_in_room(200, 100).expect("a room"), &irregular),
        (&Scene { materials: room.materials.clone(), ..Scene::default() }, &build),
    ] {
        let (plan, data) = planned(scene, options);
        ran.extend(agree::<f32>(plan, &data));
    }
    let glass = generate::whitted(0).expect("a scene");
    let rays = RaySource::Camera { camera: Camera::framing(&glass.bounds()), width: 8, height: 8 };
    for &sort in PhotonSort::ALL {
        let photons = Photons { count: 64, sort, nearest: 8, radius: 100, ..Photons::default() };
        let options = Options { integrator: Integrator::Photons, photons, ..Options::new(rays.clone()) };
        let (plan, data) = planned(&glass, &options);
        ran.extend(agree::<f32>(plan, &data));
    }
    let is_pass = |kernel: &Kernel| matches!(kernel.info().twin, Twin::Pass(_));
    let left = all().flat_map(|program| program.kernels()).filter(is_pass).filter(|k| !ran.contains(k));
    // These scenes do not reach it.
    assert_eq!(left.map(|kernel| kernel.name()).collect::<Vec<_>>(), ["finish_leaves"], "not run");
}
