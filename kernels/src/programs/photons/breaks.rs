//! Deliberate defects of the program's own kernels.

use crate::options::{Neighbours, Options};
use crate::program::breaks::{Break, as_it_is};

fn counted(options: &mut Options) {
    options.counters = true;
}

/// Rays in glass have bounced as often as they may.
fn shallow(options: &mut Options) {
    options.max_depth = 1;
}

fn exact(options: &mut Options) {
    (options.photons.neighbours, options.photons.nearest) = (Neighbours::Exact, 5);
}

pub(super) const OF_EMIT_PHOTONS: &[Break] = &[
    Break::new(as_it_is, "1.0 / (photons * emitter.chance)", "1.0 / photons"),
    Break::new(as_it_is, "record * RECORD + 9u", "record * RECORD + 8u"),
    Break::new(as_it_is, "side * (1.0 - by.y)", "side * by.y"),
    Break::new(as_it_is, "photon.leaves, 0u, 1u", "photon.leaves, 0u, 0u"),
];

pub(super) const OF_SCATTER_PHOTONS: &[Break] = &[
    Break::new(as_it_is, "book_energy(texel, 6u, power)", "book_energy(texel, 3u, power)"),
    Break::new(as_it_is, "power - next.throughput", "power"),
    Break::new(as_it_is, "chance.y >= goes_on", "chance.y < goes_on"),
    Break::new(as_it_is, "is_matte && hits > 0u", "is_matte && hits > 1u"),
    Break::new(as_it_is, "if (hits + 1u < DEPTH)", "if (hits < DEPTH)"),
    Break::new(as_it_is, "select(specular, 0u, is_matte)", "specular"),
    Break::new(as_it_is, "albedo * (1.0 / goes_on)", "albedo"),
];

pub(super) const OF_KEY_PHOTONS: &[Break] = &[
    Break::new(as_it_is, "i / photon_map.photons * RECORD", "0u"),
    Break::new(as_it_is, "map != NO_CELL", "map == NO_CELL"),
];

pub(super) const OF_SEARCH_CELLS: &[Break] = &[Break::new(as_it_is, "0, 0).x < cell", "0, 0).x <= cell")];

pub(super) const OF_LOOK_UP: &[Break] = &[
    Break::new(as_it_is, "if (tag == VISIBLE)", "if (tag == OCCLUDED)"),
    Break::new(as_it_is, "power - weighted", "power"),
    Break::new(as_it_is, "3.0 * INVERSE_PI / squared", "INVERSE_PI / squared"),
    Break::new(shallow, "depth < DEPTH", "depth <= DEPTH"),
    Break::new(as_it_is, "textureStore(ended, texel, 0, vec4u(why))", ""),
    Break::new(counted, "if (tag != SCATTER) {", "if (tag == SCATTER) {"),
];

pub(super) const OF_GATHER: &[Break] = &[
    Break::new(as_it_is, "dot3(load_record(at, first + 3u), start.normal) < 0.0", "true"),
    Break::new(as_it_is, "search.found >= photon_map.nearest", "false"),
    Break::new(as_it_is, "index + 1u", "index"),
    Break::new(as_it_is, "power * sqrt(squared)", "power * squared"),
    Break::new(as_it_is, "next.visited |= 1u << nearest", ""),
    Break::new(exact, "next.low = search.limit", "next.low = 0.0"),
];
