//! Twins of kernels that work on every element, whatever its state.

use raystep_scenes::{Camera, generate};

use super::*;
use crate::numbers::real::Real;
use crate::options::{Accelerator, Options, ProgramName, RaySource};
use crate::plan::Limits;
use crate::program::kernel::ElementTwin;
use crate::program::{Home, Instance, Kernel, KernelInfo, Program};
use crate::programs::closest_hit::kernels::GENERATE;
use crate::programs::closest_hit::states::{DONE, UNWRITTEN};
use crate::programs::closest_hit::streams::{COLOR, STATE};
use crate::programs::grid_build::streams::FIRST_SPAN;
use crate::programs::{closest_hit, grid_build};
use crate::tables::texels::Texels;

/// A kernel that takes all states and works on an element at a time, launched over the elements of a program's stream.
fn takes_all(of: &'static Program, stream: Stream, f32: ElementTwin<f32>, f64: ElementTwin<f64>) -> Kernel {
    let home = Box::leak(Box::new(Home { streams: of.streams, states: of.states }));
    let kernel = KernelInfo { takes: &[], sends: &[], twin: Twin::Element { f32, f64 }, home, ..*GENERATE.info() };
    let instance = Instance { kernel, over: stream.info().elements, ..*GENERATE.instance() };
    let kernels = Vec::leak(vec![instance]);
    Kernel::at(Box::leak(Box::new(Program { kernels, ..*of })), 0)
}

fn finish<R: Real>(ray: &mut Texels<'_, R>, _: &SceneData) {
    ray.store(COLOR, 1, R::from_f32(0.5));
    ray.store_u32(STATE, STATE_TAG, DONE);
}

fn mark<R: Real>(triangle: &mut Texels<'_, R>, _: &SceneData) {
    triangle.store_u32(FIRST_SPAN, 0, 77);
}

#[test]
fn a_twin_that_takes_all_states_runs_for_every_ray() {
    let scene = generate::cornell_box();
    let (width, height) = (40, 30);
    let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width, height };
    let (plan, data) = Plan::new(&scene, &Options::new(rays), &Limits::CPU).expect("a plan");
    let mut executor = CpuExecutor::<f32>::new(&Arc::new(plan), None).expect("memory");
    assert_eq!(executor.counts()[UNWRITTEN as usize], 1200);
    let result =
        executor.run(Call::of(takes_all(&closest_hit::PROGRAM, STATE, finish, finish)), &data).expect("a pass");
    assert_eq!((result.threads_launched, result.elements), (1200, 1200));
    assert_eq!(result.counts.map(|counts| counts[DONE as usize]), Some(1200));
    let color = executor.read(COLOR).expect("colours");
    assert!(color.layer(1).iter().all(|&bits| bits == 0.5f32.to_bits()));
}

#[test]
fn a_twin_runs_for_every_element_of_a_program_without_states() {
    let scene = generate::icosphere(3).expect("a sphere");
    let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 8, height: 8 };
    let options = Options { program: ProgramName::GridBuild, accelerator: Accelerator::Grid, ..Options::new(rays) };
    let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
    let mut executor = CpuExecutor::<f64>::new(&Arc::new(plan), None).expect("memory");
    let result =
        executor.run(Call::of(takes_all(&grid_build::PROGRAM, FIRST_SPAN, mark, mark)), &data).expect("a pass");
    assert_eq!(result.threads_launched, 1280, "20 * 4^3 triangles");
    let spans = executor.read(FIRST_SPAN).expect("a stream");
    assert_eq!(spans.bits.iter().filter(|&&word| word == 77).count(), 1280);
}
