//! Light that reaches what the rays of [`closest_hit`] hit.
//!
//! The program has that one's kernels, streams and states, and the kernels of its walk once more, for shadow rays: under
//! names of their own, bound to the streams and states of shadow rays, and compiled so that any hit ends a ray. What they
//! share stays shared: a pixel's rays are traced one after the other, so they need the tag, tMax and the like only once.
//!
//! It is the shadow caster of Purcell, Buck, Mark and Hanrahan (2002), whose shading kernel emits a ray for each light, and
//! with mirrors and transparent surfaces the tracer of Whitted (1980), whose rays make a tree. A pixel's tree is traced depth
//! first, so what it needs is known before the run: a ray for each depth.

pub(super) mod bounced;
mod breaks;
mod explain;
pub mod illuminate;
mod kernels;
pub(super) mod optics;
mod rounding;
pub mod scatter;
mod schedule;
mod tree;

use std::borrow::Cow;
use std::sync::LazyLock;

use super::closest_hit::kernels::{KERNELS, SETUP};
use super::closest_hit::states::{BACKGROUND, OF_LIGHT, SHADOW_EXACT, SHADOW_SETUP, VISIBLE};
use super::closest_hit::{self, streams};
use crate::options::features::Features;
use crate::program::{Course, Decoding, Instance, Kernel, Program};
pub(super) use kernels::LISTS;
use kernels::{OF_ILLUMINATE, OF_SCATTER, SHADOWS, for_shadow_rays};
pub(super) use schedule::{mapped, of as schedule, while_begun};

/// The program.
pub static PROGRAM: LazyLock<Program> = LazyLock::new(|| {
    let own = [OF_ILLUMINATE, OF_SCATTER].map(|kernel| Instance::of(kernel, &closest_hit::elements::RAYS));
    let kernels: Vec<Instance> = KERNELS.into_iter().chain(shadow_walk()).chain(own).collect();
    let given_up = |tag| if (SHADOW_SETUP..=SHADOW_EXACT).contains(&tag) { VISIBLE } else { BACKGROUND };
    Program {
        name: "light",
        summary: "every ray to its closest hit, and from there shadow rays to the lights, and rays that are reflected and refracted",
        streams: streams::OF_LIGHT,
        states: OF_LIGHT,
        lists: &LISTS,
        rays: closest_hit::PROGRAM.rays.map(|rays| Decoding { tree: Some(tree::grow), ..rays }),
        courses: Box::leak(Box::new([Course { given_up, ..closest_hit::COURSE }])),
        kernels: Vec::leak(kernels),
        modules,
        ..closest_hit::PROGRAM
    }
});

/// The kernel that is, in this program, one of [`closest_hit`].
fn of(kernel: Kernel) -> Kernel {
    Kernel::at(&PROGRAM, kernel.index())
}

/// The kernels of the walk once more, for shadow rays.
pub(super) fn shadow_walk() -> impl Iterator<Item = Instance> {
    KERNELS[SETUP.index()..].iter().zip(SHADOWS).filter_map(|(&of, shadow)| for_shadow_rays(of, shadow))
}

/// A kernel of the walk, for shadow rays, in a program that begins with the kernels of [`closest_hit`] and these.
pub(super) fn shadow_kernel(program: &'static Program, kernel: Kernel) -> Kernel {
    Kernel::at(program, KERNELS.len() + kernel.index() - SETUP.index())
}

/// The kernel that casts shadow rays.
fn illuminating() -> Kernel {
    Kernel::at(&PROGRAM, PROGRAM.kernels.len() - 2)
}

/// The kernel that sends rays on from their hits.
fn scattering() -> Kernel {
    Kernel::at(&PROGRAM, PROGRAM.kernels.len() - 1)
}

/// WGSL modules that kernels import from: those of the walk, and more.
fn modules(features: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let mut modules = (closest_hit::PROGRAM.modules)(features);
    let more = [("bounced", include_str!("bounced.wgsl")), ("optics", include_str!("optics.wgsl"))];
    modules.extend(more.map(|(name, source)| (name, Cow::Borrowed(source))));
    modules
}

#[cfg(test)]
pub(crate) mod tests;
