// At the hit of a photon: stores it if it has come by a bounce, and sends it on, or ends it. What a surface takes of it, and
// what leaves the scene, are added up: at any time, what was emitted is the sum of these and of what photons carry.
//
// Light that comes straight from an emitter is not stored: shadow rays find it.

import package::begins::{photon_direction, photon_state, photon_at, photon_power, photon_bounce, begin_way, store_power};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, RECORD};
import package::state::{PHOTON_ARRIVED, PHOTON_LEAVES, PHOTON_DONE};
import package::live::{book, tiled_texel};
import package::photon_map::{photon_map};
import package::random::{OF_PHOTONS};
import package::reflected::{is_diffuse, reflected_photon};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next};
import package::vector::{unit3};
import package::vertex::{Vertex, vertex_at};

@group(0) @binding(6) var photon_energy: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(8) var photon_records: texture_storage_2d_array<r32uint, write>;

fn load_power(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(photon_power, texel, 0).x,
        textureLoad(photon_power, texel, 1).x,
        textureLoad(photon_power, texel, 2).x,
    );
}

// Adds to what surfaces have taken, from layer 3 on, or to what has left the scene, from layer 6 on.
fn book_energy(texel: vec2u, first: u32, power: vec3f) {
    for (var part = 0u; part < 3u; part++) {
        let before = textureLoad(photon_energy, texel, first + part).x;
        textureStore(photon_energy, texel, first + part, vec4f(before + power[part]));
    }
}

fn photon_vertex(texel: vec2u, hits: u32, power: vec3f) -> Vertex {
    let u = bitcast<f32>(textureLoad(photon_at, texel, 0).x);
    let v = bitcast<f32>(textureLoad(photon_at, texel, 1).x);
    let triangle = textureLoad(photon_at, texel, 2).x;
    let direction = unit3(vec3f(
        textureLoad(photon_direction, texel, 0).x,
        textureLoad(photon_direction, texel, 1).x,
        textureLoad(photon_direction, texel, 2).x,
    ));
    var at = vertex_at(texel, hits, triangle, u, v, direction, power);
    at.texel = OF_PHOTONS;
    let emissions = textureLoad(photon_bounce, texel, 3).x - 1u;
    at.sample = emissions * photon_map.photons + texel.y * textureDimensions(photon_state).x + texel.x;
    return at;
}

// The photon as it arrived, and why it ended there, or 0.
fn record(texel: vec2u, at: Vertex, is_caustic: u32, ended: u32) {
    let first = (at.depth - 1u) * RECORD;
    for (var axis = 0u; axis < 3u; axis++) {
        textureStore(photon_records, texel, first + axis, vec4u(bitcast<u32>(at.start.point[axis])));
        textureStore(photon_records, texel, first + axis + 3u, vec4u(bitcast<u32>(at.direction[axis])));
        textureStore(photon_records, texel, first + axis + 6u, vec4u(bitcast<u32>(at.carried[axis])));
    }
    textureStore(photon_records, texel, first + 9u, vec4u(is_caustic));
    textureStore(photon_records, texel, first + 10u, vec4u(ended));
}

fn end(texel: vec2u, why: u32) -> u32 {
    store_power(texel, vec3f(0.0));
    textureStore(photon_bounce, texel, 2, vec4u(why));
    textureStore(photon_state, texel, 0, vec4u(PHOTON_DONE));
    return PHOTON_DONE;
}

fn next_way(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(photon_state))) {
        return NOBODY;
    }
    let tag = textureLoad(photon_state, texel, 0).x;
    if (tag != PHOTON_ARRIVED && tag != PHOTON_LEAVES) {
        return NOBODY;
    }
    let power = load_power(texel);
    if (tag == PHOTON_LEAVES) {
        book_energy(texel, 6u, power);
        return end(texel, BY_ESCAPE);
    }
    let hits = textureLoad(photon_bounce, texel, 0).x;
    let specular = textureLoad(photon_bounce, texel, 1).x;
    let at = photon_vertex(texel, hits, power);
    let is_matte = is_diffuse(at.triangle);
    var next: Next;
    next.ended = BY_DEPTH;
    // The last bounce is where photons are looked up.
    if (hits + 1u < DEPTH) {
        next = reflected_photon(at);
    }
    if (is_matte && hits > 0u) {
        record(texel, at, specular, next.ended);
    }
    if (next.ended != 0u) {
        book_energy(texel, 3u, power);
        return end(texel, next.ended);
    }
    book_energy(texel, 3u, power - next.throughput);
    let all_specular = select(specular, 0u, is_matte);
    return begin_way(texel, next.origin, next.direction, next.throughput, at.triangle, hits + 1u, all_specular);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn scatter_photons(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_way(tiled_texel(group, lane)));
}
