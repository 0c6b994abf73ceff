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

/// The same where a thread has so few loop turns a dispatch that walks, searches and sums of light wait for the next.
#[must_use]
pub fn compare_in_turns(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, turns: u32) -> Parity {
    run(gpu, scene, options, &Limits { turns, ..Limits::from(&**gpu) }, |_| {}, |_| false)
}

/// The same after `change` had its way with the plan.
#[must_use]
pub fn compare_changed(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), change, |_| false)
}

/// The same, up to the first pass that differs: a comparison that cannot fail proves nothing.
#[must_use]
pub fn compare_broken(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), change, Parity::is_broken)
}

/// The same with few loop turns a dispatch.
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
