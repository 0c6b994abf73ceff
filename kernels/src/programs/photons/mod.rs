//! Light by photon maps: photons from all lights are followed, stored where they arrive, and gathered near what is seen.
//!
//! The program has the kernels, streams and states of [`path`], the kernels of the walk a third time, for photons, and
//! kernels of its own. Its passes are those of Purcell, Donner, Cammarano, Jensen and Hanrahan, *Photon Mapping on
//! Programmable Graphics Hardware* (2003):
//!
//! 1. `emit_photons` emits all photons, each from an emitter picked by its power. They are followed breadth first: the walk,
//!    then `scatter_photons`, which stores each at diffuse surfaces, but for its first, and reflects or absorbs it by Russian
//!    roulette with the albedo. What light comes straight from an emitter, shadow rays find.
//! 2. `key_photons` finds the cell of each record, and they are sorted by it: by a bitonic sort and a binary search for the
//!    first record of each cell, as in the paper; or by a radix sort, from [`primitives`], and the same
//!    search. The lists are the same, bit for bit.
//! 3. Rays from the camera are followed through mirrors and glass to a diffuse surface, whose direct light is that of
//!    `sample_light`, as along paths. `gather` looks for the photons near it, a cell in each pass, and `look_up` adds the
//!    light that they bring: their density by Jensen's cone filter (1996), of those that came from the side that is seen.
//!    Photons that came by mirrors and glass alone have a map of their own, that of caustics.
//!
//! With final gathering, only caustics are looked up there, and a ray is sent on to where both maps are. With iterations, all
//! of that is repeated with other photons, and the radius of each pixel shrinks (Hachisuka and Jensen 2009).
//!
//! A photon's power is its emitter's by the number of photons and the probability of the emitter. Every photon is a sample of
//! one sequence, so photons are spread evenly over emitters, points and directions. What photons carry, what surfaces have
//! absorbed and what has left the scene adds up to what was emitted, photon by photon, after every pass.

mod begins;
mod breaks;
mod emission;
pub mod emit_photons;
mod explain;
pub mod gather;
mod instances;
mod kernels;
pub mod key_photons;
pub mod look_up;
mod plan;
mod ray_state;
mod reflected;
mod rounding;
pub mod scatter_photons;
mod schedule;
pub mod search_cells;
mod searches;
pub mod stored;

use std::borrow::Cow;
use std::sync::LazyLock;

use super::closest_hit::buffers::BUFFERS;
use super::closest_hit::elements::{RAYS, no_map};
use super::closest_hit::kernels::{KERNELS, SETUP};
use super::closest_hit::states::{
    ALL, BACKGROUND, PHOTON_DONE, PHOTON_LEAVES, PHOTON_SETUP, PHOTON_UNBORN, SHADOW_EXACT, SHADOW_SETUP, VISIBLE,
};
use super::closest_hit::streams::{PHOTON_STATE, STREAMS};
use super::path::kernels::OF_SAMPLE_LIGHT;
use super::{closest_hit, light, path, primitives};
use crate::options::features::Features;
use crate::program::{Course, Instance, Kernel, Program};
use crate::scene_data::buffer::uniform;
use instances::{IN_WALK, LISTS, OWN, Own, SETS_OF_PHOTONS, photon_walk};
pub(super) use plan::others;
pub(super) use schedule::of as schedule;

/// The course of a photon.
const OF_PHOTONS: Course = Course {
    stream: PHOTON_STATE,
    inputs: &[],
    unborn: PHOTON_UNBORN,
    born: PHOTON_SETUP,
    given_up: |_| PHOTON_LEAVES,
    done: PHOTON_DONE,
};

/// The program.
pub static PROGRAM: LazyLock<Program> = LazyLock::new(|| {
    let sample_light = Instance::of(OF_SAMPLE_LIGHT, &RAYS);
    let kernels = KERNELS.into_iter().chain(light::shadow_walk()).chain(photon_walk()).chain([sample_light]).chain(OWN);
    let given_up = |tag| if (SHADOW_SETUP..=SHADOW_EXACT).contains(&tag) { VISIBLE } else { BACKGROUND };
    let map = uniform(
        "photon_map",
        "cells over the scene, their width, numbers of photons, radius of the search; traced units",
        |data| bytemuck::bytes_of(&data.photon_map),
        no_map,
    );
    Program {
        name: "photons",
        summary: "photons from all lights, stored where they arrive, and gathered near what is seen",
        elements: Vec::leak([&RAYS].into_iter().chain(SETS_OF_PHOTONS).collect()),
        streams: &STREAMS,
        states: ALL,
        lists: &LISTS,
        courses: Box::leak(Box::new([Course { given_up, ..closest_hit::COURSE }, OF_PHOTONS])),
        buffers: Vec::leak(BUFFERS.iter().copied().chain([map]).collect()),
        kernels: Vec::leak(kernels.collect()),
        rays: Some(ray_state::decoding()),
        modules,
        ..*path::PROGRAM
    }
});

/// The kernel that is, in this program, one of [`closest_hit`].
fn of(kernel: Kernel) -> Kernel {
    Kernel::at(&PROGRAM, kernel.index())
}

/// A kernel of the walk, for photons.
fn photon_kernel(kernel: Kernel) -> Kernel {
    Kernel::at(&PROGRAM, before_own() - IN_WALK + kernel.index() - SETUP.index())
}

/// The kernel that casts shadow rays.
fn sample_light() -> Kernel {
    Kernel::at(&PROGRAM, before_own())
}

/// One of its own kernels.
fn own(kernel: Own) -> Kernel {
    Kernel::at(&PROGRAM, before_own() + 1 + kernel as usize)
}

/// Kernels before the one that casts shadow rays, and its own.
fn before_own() -> usize {
    PROGRAM.kernels.len() - OWN.len() - 1
}

/// WGSL modules that kernels import from: those of paths, and more.
fn modules(features: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let mut modules = (path::PROGRAM.modules)(features);
    let own = [
        ("begins", include_str!("begins.wgsl")),
        ("emission", include_str!("emission.wgsl")),
        ("reflected", include_str!("reflected.wgsl")),
        ("searches", include_str!("searches.wgsl")),
    ];
    let more = own.iter().chain(primitives::MODULES);
    modules.extend(more.map(|&(name, source)| (name, Cow::Borrowed(source))));
    modules
}

#[cfg(test)]
mod tests;
