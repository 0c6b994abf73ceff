//! Light along paths: from the camera over random bounces, with a shadow ray at each.
//!
//! The program has the kernels, streams and states of [`light`], and three of its own: one picks a light and casts a shadow
//! ray, one picks a direction and sends the path on, and one follows the whole path, for the schedule `fused`. It is the path tracer of Purcell, Buck, Mark and Hanrahan (2002), which
//! estimates the rendering equation (Kajiya 1986), with their shadow caster at each vertex, and multiple importance sampling
//! (Veach and Guibas 1995).
//!
//! Light is in physical units: a point or spot light has its intensity by squared distance, a directional one its illuminance,
//! a surface its radiance, and the background is an environment of constant radiance.
//!
//! What decides a path is a table of pairs of numbers (`random`): at each depth one picks an emitter, one a point of it, one a
//! direction, and one whether glass reflects and whether the path goes on.

pub(super) mod at_hit;
mod breaks;
pub(super) mod connected;
mod densities;
pub(super) mod direction;
pub(super) mod emitters;
pub(super) mod explain;
pub mod fused_path;
pub(super) mod kernels;
pub(super) mod random;
mod rounding;
pub mod sample_bsdf;
pub mod sample_light;
pub(super) mod scattered;
mod schedule;
mod steps;
mod toward;
mod tree;
pub(super) mod vertex;

use std::borrow::Cow;
use std::sync::LazyLock;

use super::closest_hit::states::{BACKGROUND, OF_LIGHT, SHADOW_EXACT, SHADOW_SETUP, VISIBLE};
use super::closest_hit::streams::{ACCUMULATED, ACCUMULATED_SAMPLES};
use super::closest_hit::{self, kernels::KERNELS};
use super::light;
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::program::{Course, Decoding, Instance, Kernel, Program};
use crate::scene_data::SceneData;
use crate::tables::texels::Texels;
use kernels::{OF_FUSED_PATH, OF_SAMPLE_BSDF, OF_SAMPLE_LIGHT};
pub(super) use schedule::{of as schedule, sampled};

/// The program.
pub static PROGRAM: LazyLock<Program> = LazyLock::new(|| {
    let own = [OF_SAMPLE_LIGHT, OF_SAMPLE_BSDF, OF_FUSED_PATH]
        .map(|kernel| Instance::of(kernel, &closest_hit::elements::RAYS));
    let kernels: Vec<Instance> = KERNELS.into_iter().chain(light::shadow_walk()).chain(own).collect();
    let given_up = |tag| if (SHADOW_SETUP..=SHADOW_EXACT).contains(&tag) { VISIBLE } else { BACKGROUND };
    Program {
        name: "path",
        summary: "paths from the camera over random bounces, with a shadow ray at each",
        courses: Box::leak(Box::new([Course { given_up, ..closest_hit::COURSE }])),
        kernels: Vec::leak(kernels),
        rays: closest_hit::PROGRAM.rays.map(|rays| Decoding {
            tree: Some(tree::grow),
            paths: Some(steps::PATHS),
            ..rays
        }),
        states: OF_LIGHT,
        modules,
        ..*light::PROGRAM
    }
});

/// The kernel that is, in this program, one of [`closest_hit`].
fn of(kernel: Kernel) -> Kernel {
    Kernel::at(&PROGRAM, kernel.index())
}

/// One of its own kernels.
fn own(kernel: Own) -> Kernel {
    Kernel::at(&PROGRAM, PROGRAM.kernels.len() - 3 + kernel as usize)
}

/// Its own kernels, in the order of the table.
#[derive(Clone, Copy)]
enum Own {
    SampleLight,
    SampleBsdf,
    FusedPath,
}

/// WGSL modules that kernels import from: those of light, and more.
fn modules(features: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let mut modules = (light::PROGRAM.modules)(features);
    let more = [
        ("at_hit", include_str!("at_hit.wgsl")),
        ("connected", include_str!("connected.wgsl")),
        ("direction", include_str!("direction.wgsl")),
        ("emitters", include_str!("emitters.wgsl")),
        ("random", include_str!("random.wgsl")),
        ("scattered", include_str!("scattered.wgsl")),
        ("toward", include_str!("toward.wgsl")),
        ("vertex", include_str!("vertex.wgsl")),
    ];
    modules.extend(more.map(|(name, source)| (name, Cow::Borrowed(source))));
    modules
}

/// The index of the sample that a pixel is at.
fn next_sample<R: Real>(ray: &Texels<'_, R>, scene: &SceneData) -> u32 {
    if !scene.features.samples {
        return 0;
    }
    let samples: R = ray.load(ACCUMULATED, ACCUMULATED_SAMPLES);
    scene.sampling.first + samples.to_i32() as u32
}

#[cfg(test)]
mod tests;
