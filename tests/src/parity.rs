//! One-step parity on the tests' GPU; see [`raystep_lab::parity`].

use std::sync::Arc;

use raystep_kernels::{Gpu, Limits, Options, Plan};
use raystep_lab::parity::compare as compare_each;
pub use raystep_lab::parity::{Breach, Parity};
use raystep_scenes::Scene;

use crate::block_on;

/// Runs a scene on the GPU and compares every pass with the twin.
#[must_use]
pub fn compare(gpu: &Arc<Gpu>, scene: &Scene, options: &Options) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), |_| {}, |_| false)
}

/// The same with so few loop iterations per dispatch that walks, searches and sums of light continue in the next one.
#[must_use]
pub fn compare_in_turns(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, turns: u32) -> Parity {
    run(gpu, scene, options, &Limits { turns, ..Limits::from(&**gpu) }, |_| {}, |_| false)
}

/// The same after `change` has modified the plan.
#[must_use]
pub fn compare_changed(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), change, |_| false)
}

/// The same, up to the first pass that differs. A deliberately broken plan shows that the comparison can fail.
#[must_use]
pub fn compare_broken(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), change, Parity::is_broken)
}

/// The same with few loop iterations per dispatch.
#[must_use]
pub fn compare_broken_in_turns(
    gpu: &Arc<Gpu>,
    scene: &Scene,
    options: &Options,
    turns: u32,
    change: impl FnOnce(&mut Plan),
) -> Parity {
    run(gpu, scene, options, &Limits { turns, ..Limits::from(&**gpu) }, change, Parity::is_broken)
}

fn run(
    gpu: &Arc<Gpu>,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
    change: impl FnOnce(&mut Plan),
    is_enough: impl Fn(&Parity) -> bool,
) -> Parity {
    block_on(Some(gpu), compare_each(gpu, scene, options, limits, change, is_enough)).expect("a comparison")
}
