// At the hit of a path: adds the light that the surface emits, picks a light or a point of a triangle that glows, and casts a
// shadow ray to it, with what arrives if nothing is in its way. Without a hit, the path has left the scene, and sees the
// background, which is around it at any distance.
//
// Light from a triangle may be found by either of two strategies: by picking a point of it here, or by chance, where the path
// hits it. mis: both count, each by its weight. by_light: only the first does, but after a mirror or glass, whose direction no
// light can be picked for. Neither: only the second, and only lights without a size are picked.

import package::constants::{DEPTH, INF, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{SHADE, BACKGROUND, SHADOW_SETUP, SCATTER};
import package::corners::{vertex};
import package::emitters::{pdf_by_area, share_of_hit, weight};
import package::toward::{toward_emitter};
import package::live::{book, tiled_texel};
import package::optics::{DIFFUSE, optics_of};
import package::random::{next_sample};
import package::ray::{load_origin, load_direction};
import package::shade_surface::{material_of, surface_normal, diffuse_color};
import package::start::{Start, start_of, on_side, leaving};
import package::vector::{dot3, unit3};

struct Shading {
    background: vec3f,
    lights: u32,
}

const INVERSE_PI: f32 = 0.318309886;

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var bounce: texture_2d_array<u32>;
@group(0) @binding(5) var throughput: texture_2d_array<f32>;
@group(0) @binding(6) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(7) var primary: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(8) var light: texture_storage_2d_array<r32uint, write>;
@if(emissive) @group(0) @binding(9) var pdf: texture_2d_array<f32>;
@if(shadows) @group(0) @binding(10) var pending: texture_storage_2d_array<r32float, write>;
@if(shadows) @group(0) @binding(11) var blocker: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(12) var surface: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(13) var shadow_origin: texture_storage_2d_array<r32float, write>;
@if(shadows) @group(0) @binding(14) var shadow_direction: texture_storage_2d_array<r32float, write>;
@group(1) @binding(14) var<uniform> shading: Shading;

// The pixel's first ray and its hit: those of the last path are put back when it ends.
fn keep_primary(texel: vec2u) {
    let origin = bitcast<vec3u>(load_origin(texel));
    let direction = bitcast<vec3u>(load_direction(texel));
    textureStore(primary, texel, 0, vec4u(origin.x));
    textureStore(primary, texel, 1, vec4u(origin.y));
    textureStore(primary, texel, 2, vec4u(origin.z));
    textureStore(primary, texel, 3, vec4u(direction.x));
    textureStore(primary, texel, 4, vec4u(direction.y));
    textureStore(primary, texel, 5, vec4u(direction.z));
    textureStore(primary, texel, 6, textureLoad(state, texel, 1));
    textureStore(primary, texel, 7, textureLoad(hit, texel, 0, 0));
    textureStore(primary, texel, 8, textureLoad(hit, texel, 1, 0));
    textureStore(primary, texel, 9, textureLoad(hit, texel, 2, 0));
}

// Casts a shadow ray from a hit to an emitter, unless nothing of its light can arrive. carried: what of light that is
// reflected reaches the pixel, times the surface's colour.
@if(shadows)
fn is_cast(texel: vec2u, depth: u32, start: Start, normal: vec3f, carried: vec3f) -> bool {
    let origin = leaving(start);
    let to = toward_emitter(texel, next_sample(texel), depth, origin);
    let cosine = dot3(normal, unit3(to.direction));
    if (!to.is_lit || cosine <= 0.0 || dot3(start.normal, to.direction) <= 0.0) {
        return false;
    }
    var arrives = to.light * (carried * (cosine * INVERSE_PI));
    @if(mis) if (to.pdf > 0.0) {
        arrives *= weight(to.pdf, cosine * INVERSE_PI);
    }
    // A point so near that its pdf is 0 or not finite brings nothing that could be summed.
    if (!(largest(arrives) > 0.0 && largest(arrives) < INF)) {
        return false;
    }
    textureStore(shadow_origin, texel, 0, vec4f(origin.x));
    textureStore(shadow_origin, texel, 1, vec4f(origin.y));
    textureStore(shadow_origin, texel, 2, vec4f(origin.z));
    textureStore(shadow_direction, texel, 0, vec4f(to.direction.x));
    textureStore(shadow_direction, texel, 1, vec4f(to.direction.y));
    textureStore(shadow_direction, texel, 2, vec4f(to.direction.z));
    textureStore(pending, texel, 0, vec4f(arrives.x));
    textureStore(pending, texel, 1, vec4f(arrives.y));
    textureStore(pending, texel, 2, vec4f(arrives.z));
    textureStore(surface, texel, 0, textureLoad(hit, texel, 2, 0));
    textureStore(blocker, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(light, texel, 0, vec4u(to.id));
    textureStore(light, texel, 1, textureLoad(state, texel, 1));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(to.end)));
    textureStore(state, texel, 0, vec4u(SHADOW_SETUP));
    return true;
}

fn largest(a: vec3f) -> f32 {
    return max(max(a.x, a.y), a.z);
}

fn at_hit(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag != SHADE && tag != BACKGROUND) {
        return NOBODY;
    }
    let depth = textureLoad(bounce, texel, 0, 0).x;
    var carried = vec3f(1.0);
    var sum = vec3f(0.0);
    if (depth == 0u) {
        keep_primary(texel);
    } else {
        carried.x = textureLoad(throughput, texel, 0, 0).x;
        carried.y = textureLoad(throughput, texel, 1, 0).x;
        carried.z = textureLoad(throughput, texel, 2, 0).x;
        sum.x = textureLoad(radiance, texel, 0).x;
        sum.y = textureLoad(radiance, texel, 1).x;
        sum.z = textureLoad(radiance, texel, 2).x;
    }
    let triangle = textureLoad(hit, texel, 2, 0).x;
    if (tag == BACKGROUND) {
        sum += carried * shading.background;
    }
    var is_sent = false;
    if (tag == SHADE) {
        let u = bitcast<f32>(textureLoad(hit, texel, 0, 0).x);
        let v = bitcast<f32>(textureLoad(hit, texel, 1, 0).x);
        let direction = unit3(load_direction(texel));
        let material = material_of(triangle);
        let start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
        @if(emissive) {
            if (any(material.emissive != vec3f(0.0)) && (!start.is_back || material.double_sided != 0u)) {
                let way = start.point - load_origin(texel);
                let of_point = pdf_by_area(material.emissive, material.double_sided) * dot3(way, way)
                    / abs(dot3(start.normal, direction));
                let share = share_of_hit(textureLoad(pdf, texel, 0, 0).x, of_point);
                sum += carried * material.emissive * share;
            }
        }
        @if(shadows) {
            var is_diffuse = depth < DEPTH;
            @if(specular) is_diffuse = is_diffuse && optics_of(triangle).kind == DIFFUSE;
            if (is_diffuse) {
                let normal = on_side(start, surface_normal(triangle, u, v));
                is_sent = is_cast(texel, depth, start, normal, carried * diffuse_color(material, triangle, u, v));
            }
        }
    }
    textureStore(radiance, texel, 0, vec4f(sum.x));
    textureStore(radiance, texel, 1, vec4f(sum.y));
    textureStore(radiance, texel, 2, vec4f(sum.z));
    if (is_sent) {
        return SHADOW_SETUP;
    }
    textureStore(state, texel, 0, vec4u(SCATTER));
    return SCATTER;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn sample_light(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, at_hit(tiled_texel(group, lane)));
}
