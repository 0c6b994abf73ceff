// Searches for the photons of a map near a hit: how they begin, and the light that they have found.
//
// samples: with every iteration, the radius of each pixel shrinks (progressive photon mapping, Hachisuka and Jensen 2009). Of
// the photons found, it keeps a share, as if they had been found in the smaller circle: so their number grows, and the circle
// still shrinks to nothing. Their estimate, by sums that shrink as well, is the mean of those of the iterations.

import package::bounced::{state};
import package::connected::{INVERSE_PI};
import package::constants::{DEPTH, NO_CELL};
import package::photon_map::{photon_map};
import package::state::{GATHER};

@group(0) @binding(17) var gathering: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(18) var gathered: texture_storage_2d_array<r32float, read_write>;
@if(samples) @group(0) @binding(19) var shrunk: texture_storage_2d_array<r32float, read_write>;

// The maps.
const GLOBAL: u32 = 0u;
const CAUSTIC: u32 = 1u;
// Of the photons found in an iteration, the share that counts in the next.
const KEPT: f32 = 0.6666667;

// The map of a pixel's latest search.
fn map_of(texel: vec2u) -> u32 {
    return textureLoad(gathering, texel, 5).x;
}

// Whether the pixel's ray was sent on from a diffuse surface.
fn is_sent_on(texel: vec2u) -> u32 {
    return textureLoad(gathering, texel, 6).x;
}

fn set_sent_on(texel: vec2u, is_sent: u32) {
    textureStore(gathering, texel, 6, vec4u(is_sent));
}

// The squared radius of a search in a map that earlier iterations have left, or 0. Places that are seen directly and by way of
// a diffuse surface have their own.
fn radius_before(texel: vec2u, map: u32, is_sent: u32) -> f32 {
    @if(samples) return textureLoad(shrunk, texel, 4u * is_sent + 2u * map + 1u).x;
    @else return 0.0;
}

fn begin_search(texel: vec2u, map: u32, is_sent: u32) -> u32 {
    let before = radius_before(texel, map, is_sent);
    let whole = photon_map.radius * photon_map.radius;
    // With a radius of its own, all photons within it count, in one search.
    let has_radius = before > 0.0;
    let limit = select(whole, before, has_radius);
    textureStore(gathering, texel, 0, vec4u(NO_CELL));
    textureStore(gathering, texel, 1, vec4u(0u));
    textureStore(gathering, texel, 2, vec4u(0u));
    textureStore(gathering, texel, 3, vec4u(0u));
    textureStore(gathering, texel, 4, vec4u(select(0u, 1u, has_radius)));
    textureStore(gathering, texel, 5, vec4u(map));
    textureStore(gathering, texel, 6, vec4u(is_sent));
    textureStore(gathering, texel, 7, vec4u(0u));
    for (var layer = 0u; layer < 10u; layer++) {
        textureStore(gathered, texel, layer, vec4f(select(0.0, limit, layer == 0u || layer == 2u)));
    }
    textureStore(state, texel, 0, vec4u(GATHER));
    return GATHER;
}

// The map to look in first, or none, if the ray is sent on at once.
fn first_map(depth: u32, is_sent: u32) -> u32 {
    @if(specular) return CAUSTIC;
    @else @if(gathers_later) return select(GLOBAL, NO_CELL, is_sent == 0u && depth < DEPTH);
    @else return GLOBAL;
}

// The flux by area that photons bring: each counts less the farther away it is, nothing at the edge of the circle in which
// they were found. A cone (Jensen 1996), whose mean over the circle is 1/3.
fn irradiance(texel: vec2u, map: u32, is_sent: u32) -> vec3f {
    let power = vec3f(
        textureLoad(gathered, texel, 4).x,
        textureLoad(gathered, texel, 5).x,
        textureLoad(gathered, texel, 6).x,
    );
    let weighted = vec3f(
        textureLoad(gathered, texel, 7).x,
        textureLoad(gathered, texel, 8).x,
        textureLoad(gathered, texel, 9).x,
    );
    // With fewer photons than wanted, there are no others within the radius.
    let whole = photon_map.radius * photon_map.radius;
    let before = radius_before(texel, map, is_sent);
    let found = textureLoad(gathering, texel, 3).x;
    let of_search = select(whole, textureLoad(gathered, texel, 3).x, found >= photon_map.nearest);
    let squared = max(select(of_search, before, before > 0.0), whole * 1e-6);
    @if(samples) {
        let slot = 4u * is_sent + 2u * map;
        let enough = textureLoad(shrunk, texel, slot).x;
        let kept = enough + KEPT * f32(found);
        let all = enough + f32(found);
        textureStore(shrunk, texel, slot, vec4f(kept));
        textureStore(shrunk, texel, slot + 1u, vec4f(select(squared, squared * (kept / all), found > 0u)));
    }
    return max(power - weighted * (1.0 / sqrt(squared)), vec3f(0.0)) * (3.0 * INVERSE_PI / squared);
}
