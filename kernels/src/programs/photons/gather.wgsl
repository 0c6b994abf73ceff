// Looks for the photons of a map near a hit, in the cell of the hit and those around it, by growing distance: a cell, or a part
// of one, in each step. The kNN-grid (Purcell et al. 2003): a photon is taken while fewer than enough are found, or if it is no
// farther away than the farthest of these. So all are found within some distance, which is at most the radius.
//
// exact: of these, only as many as are wanted. Bisection finds a distance within which there are so many, by searching the
// same cells again, until no number is left between one that is too small and one that is large enough.

import package::constants::{DEPTH, INF, LIST_SIDE, NOBODY, NO_CELL, RECORD};
import package::state::{GATHER, GATHERED};
import package::corners::{vertex};
import package::launch::{texel};
import package::live::{book, tiled_texel};
import package::photon_map::{photon_map, cell_of, distance_to, has_cell, index_of, place_of};
import package::ray::{load_direction};
import package::scene::{scene};
import package::start::{Start, start_of};
import package::vector::{dot3, unit3};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var gathering: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(5) var gathered: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(6) var photon_key: texture_2d_array<u32>;
@group(0) @binding(9) var photon_first: texture_2d_array<u32>;
@group(0) @binding(10) var photon_records: texture_2d_array<u32>;
@group(0) @binding(11) var bounce: texture_2d_array<u32>;

// The cells around a cell, and itself.
const AROUND: u32 = 27u;
// Most photons that are looked at in a step.
const PHOTONS_A_STEP: u32 = 64u;

// How far the search has got.
struct Search {
    // Of the cells around: the one that is searched; before the first, NO_CELL.
    cell: u32,
    // The next of its photons among the sorted ones, and where they end.
    item: u32,
    end: u32,
    // Photons found so far.
    found: u32,
    // How often all cells have been searched.
    sweep: u32,
    map: u32,
    // The cells around that have been searched, a bit each: whoever finds the next one by distances needs no distance of the
    // last.
    visited: u32,
    // What is farther away is not taken; this and what follows are squared.
    limit: f32,
    // Within these there are too few photons, and enough.
    low: f32,
    high: f32,
    // Of what was found.
    farthest: f32,
    // What the photons found carry, and the same times their distances.
    power: vec3f,
    weighted: vec3f,
}

fn load_search(pixel: vec2u) -> Search {
    var search: Search;
    search.cell = textureLoad(gathering, pixel, 0).x;
    search.item = textureLoad(gathering, pixel, 1).x;
    search.end = textureLoad(gathering, pixel, 2).x;
    search.found = textureLoad(gathering, pixel, 3).x;
    search.sweep = textureLoad(gathering, pixel, 4).x;
    search.map = textureLoad(gathering, pixel, 5).x;
    search.visited = textureLoad(gathering, pixel, 7).x;
    search.limit = textureLoad(gathered, pixel, 0).x;
    search.low = textureLoad(gathered, pixel, 1).x;
    search.high = textureLoad(gathered, pixel, 2).x;
    search.farthest = textureLoad(gathered, pixel, 3).x;
    search.power.x = textureLoad(gathered, pixel, 4).x;
    search.power.y = textureLoad(gathered, pixel, 5).x;
    search.power.z = textureLoad(gathered, pixel, 6).x;
    search.weighted.x = textureLoad(gathered, pixel, 7).x;
    search.weighted.y = textureLoad(gathered, pixel, 8).x;
    search.weighted.z = textureLoad(gathered, pixel, 9).x;
    return search;
}

fn store_search(pixel: vec2u, search: Search) {
    textureStore(gathering, pixel, 0, vec4u(search.cell));
    textureStore(gathering, pixel, 1, vec4u(search.item));
    textureStore(gathering, pixel, 2, vec4u(search.end));
    textureStore(gathering, pixel, 3, vec4u(search.found));
    textureStore(gathering, pixel, 4, vec4u(search.sweep));
    textureStore(gathering, pixel, 7, vec4u(search.visited));
    textureStore(gathered, pixel, 0, vec4f(search.limit));
    textureStore(gathered, pixel, 1, vec4f(search.low));
    textureStore(gathered, pixel, 2, vec4f(search.high));
    textureStore(gathered, pixel, 3, vec4f(search.farthest));
    textureStore(gathered, pixel, 4, vec4f(search.power.x));
    textureStore(gathered, pixel, 5, vec4f(search.power.y));
    textureStore(gathered, pixel, 6, vec4f(search.power.z));
    textureStore(gathered, pixel, 7, vec4f(search.weighted.x));
    textureStore(gathered, pixel, 8, vec4f(search.weighted.y));
    textureStore(gathered, pixel, 9, vec4f(search.weighted.z));
}

// How far away a photon may be that is taken next.
fn limit_of(search: Search) -> f32 {
    let has_enough = search.sweep == 0u && search.found >= photon_map.nearest;
    return select(search.limit, search.farthest, has_enough);
}

// Goes on to the nearest cell that is left; to none if that is too far away.
fn next_cell(search: Search, point: vec3f) -> Search {
    let place = place_of(point);
    let cell = cell_of(place);
    var nearest = NO_CELL;
    var distance = INF;
    for (var around = 0u; around < AROUND; around++) {
        let step = vec3i(vec3u(around % 3u, around / 3u % 3u, around / 9u)) - vec3i(1);
        let away = distance_to(place, cell, step);
        let is_visited = ((search.visited >> around) & 1u) != 0u;
        if (has_cell(cell + step) && !is_visited && away < distance) {
            nearest = around;
            distance = away;
        }
    }
    var next = search;
    next.cell = NO_CELL;
    if (nearest != NO_CELL && distance <= limit_of(search)) {
        let step = vec3i(vec3u(nearest % 3u, nearest / 3u % 3u, nearest / 9u)) - vec3i(1);
        let index = index_of(search.map, cell + step);
        let width = textureDimensions(photon_first).x;
        next.cell = nearest;
        next.visited |= 1u << nearest;
        next.item = textureLoad(photon_first, texel(index, width), 0, 0).x;
        next.end = textureLoad(photon_first, texel(index + 1u, width), 0, 0).x;
    }
    return next;
}

fn load_record(at: vec2u, layer: u32) -> vec3f {
    return vec3f(
        bitcast<f32>(textureLoad(photon_records, at, layer, 0).x),
        bitcast<f32>(textureLoad(photon_records, at, layer + 1u, 0).x),
        bitcast<f32>(textureLoad(photon_records, at, layer + 2u, 0).x),
    );
}

// Looks at the next photons of the cell. Those that came from the other side of the surface do not count, nor those that were
// stored at more bounces than the ray leaves them: light bounces as often as along paths.
fn with_photons(search: Search, start: Start, bounces: u32) -> Search {
    var next = search;
    let stop = min(search.end, search.item + PHOTONS_A_STEP);
    for (var item = search.item; item < stop; item++) {
        let record = textureLoad(photon_key, texel(item, textureDimensions(photon_key).x), 1, 0).x;
        let at = texel(record % photon_map.photons, textureDimensions(photon_records).x);
        let bounced = record / photon_map.photons;
        let first = bounced * RECORD;
        let away = load_record(at, first) - start.point;
        let squared = dot3(away, away);
        let is_seen = bounced < bounces && dot3(load_record(at, first + 3u), start.normal) < 0.0;
        if (is_seen && squared <= limit_of(next)) {
            let power = load_record(at, first + 6u);
            next.found += 1u;
            next.farthest = max(next.farthest, squared);
            next.power += power;
            next.weighted += power * sqrt(squared);
        }
    }
    next.item = stop;
    return next;
}

// Whether a search of all cells was the last.
fn is_over(search: Search) -> bool {
    @if(exact) {
        let is_first = search.sweep == 0u;
        let has_too_many = search.found > photon_map.nearest;
        return search.found == photon_map.nearest || (is_first && !has_too_many)
            || (!is_first && search.limit == search.high);
    } @else {
        return true;
    }
}

// The next search of all cells: half-way between distances that are too small and large enough.
@if(exact)
fn next_sweep(search: Search) -> Search {
    var next: Search;
    next.low = search.low;
    next.high = search.high;
    if (search.sweep == 0u || search.found > photon_map.nearest) {
        next.high = search.farthest;
    } else {
        next.low = search.limit;
    }
    let half = 0.5 * (next.low + next.high);
    next.limit = select(next.high, half, next.low < half && half < next.high);
    next.sweep = search.sweep + 1u;
    next.map = search.map;
    next.cell = NO_CELL;
    return next;
}

fn searched(pixel: vec2u) -> u32 {
    if (any(pixel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, pixel, 0).x != GATHER) {
        return NOBODY;
    }
    let u = bitcast<f32>(textureLoad(hit, pixel, 0, 0).x);
    let v = bitcast<f32>(textureLoad(hit, pixel, 1, 0).x);
    let triangle = textureLoad(hit, pixel, 2, 0).x;
    let direction = unit3(load_direction(pixel));
    let start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
    // One bounce is here, and the ray has had others.
    let bounces = textureLoad(bounce, pixel, 0, 0).x + 1u;
    var search = load_search(pixel);
    var tag = GATHER;
    for (var step = 0u; step < scene.steps && tag == GATHER; step++) {
        if (search.item >= search.end) {
            search = next_cell(search, start.point);
        }
        if (search.cell != NO_CELL) {
            search = with_photons(search, start, max(DEPTH, bounces) - bounces);
        } else if (is_over(search)) {
            tag = GATHERED;
        } else {
            @if(exact) search = next_sweep(search);
        }
    }
    store_search(pixel, search);
    textureStore(state, pixel, 0, vec4u(tag));
    return tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn gather(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, searched(tiled_texel(group, lane)));
}
