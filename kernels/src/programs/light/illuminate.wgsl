// Casts a shadow ray from the hit to the next light that could add to its colour, and adds what the ray before brought: the
// paper's equation (1), C_diff <N, L>, summed over the lights that are visible. Without another light, the sum is the
// ray's colour; without a hit, the background.
//
// A light on the other side of the surface, or a spot beyond its cone, costs no ray and adds nothing.
//
// resumes_light: there are more lights than a dispatch has loop iterations. Without a ray to cast among these, the number of
// the next light waits in the state's item, marked by LIGHTS_SUMMED.
//
// specular: a mirror or transparent surface has no diffuse colour, so no light is considered; and rays may go on from the hit.

import package::constants::{INF, LIGHTS_SUMMED, LIST_SIDE, NOBODY, NO_TRIANGLE, TURNS};
import package::state::{SHADE, BACKGROUND, DONE, SHADOW_SETUP, OCCLUDED, VISIBLE, SCATTER};
import package::corners::{vertex};
import package::live::{book, tiled_texel};
import package::optics::{DIFFUSE, optics_of};
import package::ray::{load_origin, load_direction};
import package::shade_light::{lights, received, shading};
import package::shade_surface::{material_of, surface_normal, diffuse_color};
import package::start::{Start, start_of, leaving, end_before};
import package::vector::{dot3};

// Where a ray goes whose light is known.
@if(specular) const LIT: u32 = SCATTER;
@else const LIT: u32 = DONE;

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(5) var pending: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(6) var light: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(7) var blocker: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(8) var surface: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(9) var shadow_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(10) var shadow_direction: texture_storage_2d_array<r32float, write>;
@if(counters) @group(0) @binding(11) var counters: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(12) var shadow_counters: texture_2d_array<u32>;

fn load_color(texel: vec2u) -> vec3f {
    return vec3f(textureLoad(color, texel, 0).x, textureLoad(color, texel, 1).x, textureLoad(color, texel, 2).x);
}

fn store_color(texel: vec2u, rgb: vec3f) {
    textureStore(color, texel, 0, vec4f(rgb.x));
    textureStore(color, texel, 1, vec4f(rgb.y));
    textureStore(color, texel, 2, vec4f(rgb.z));
}

// The light that has arrived so far. The pixel's cost includes that of its shadow rays.
fn arrived(texel: vec2u, tag: u32) -> vec3f {
    var sum = load_color(texel);
    if (tag == VISIBLE) {
        sum += vec3f(textureLoad(pending, texel, 0).x, textureLoad(pending, texel, 1).x, textureLoad(pending, texel, 2).x);
    }
    @if(counters) {
        let cells = textureLoad(counters, texel, 0).x + textureLoad(shadow_counters, texel, 0, 0).x;
        let tests = textureLoad(counters, texel, 1).x + textureLoad(shadow_counters, texel, 1, 0).x;
        let repeated = textureLoad(counters, texel, 2).x + textureLoad(shadow_counters, texel, 2, 0).x;
        textureStore(counters, texel, 0, vec4u(cells));
        textureStore(counters, texel, 1, vec4u(tests));
        textureStore(counters, texel, 2, vec4u(repeated));
    }
    return sum;
}

// Casts the shadow ray of light i, which brings rgb, unless the surface itself is in its way.
fn is_cast(texel: vec2u, start: Start, i: u32, rgb: vec3f) -> bool {
    let origin = leaving(start);
    var direction = -lights[i].direction;
    var end = INF;
    if (lights[i].kind != 1u) {
        direction = lights[i].position - origin;
        end = end_before(lights[i].position, direction);
    }
    if (dot3(start.normal, direction) <= 0.0) {
        return false;
    }
    textureStore(shadow_origin, texel, 0, vec4f(origin.x));
    textureStore(shadow_origin, texel, 1, vec4f(origin.y));
    textureStore(shadow_origin, texel, 2, vec4f(origin.z));
    textureStore(shadow_direction, texel, 0, vec4f(direction.x));
    textureStore(shadow_direction, texel, 1, vec4f(direction.y));
    textureStore(shadow_direction, texel, 2, vec4f(direction.z));
    textureStore(pending, texel, 0, vec4f(rgb.x));
    textureStore(pending, texel, 1, vec4f(rgb.y));
    textureStore(pending, texel, 2, vec4f(rgb.z));
    textureStore(surface, texel, 0, vec4u(textureLoad(hit, texel, 2, 0).x));
    textureStore(blocker, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(light, texel, 0, vec4u(i + 1u));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(end)));
    return true;
}

fn next_light(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag == BACKGROUND) {
        store_color(texel, shading.background);
        textureStore(state, texel, 0, vec4u(LIT));
        return LIT;
    }
    if (tag != SHADE && tag != OCCLUDED && tag != VISIBLE) {
        return NOBODY;
    }

    var first = 0u;
    var sum = vec3f(0.0);
    var t_bits = textureLoad(state, texel, 1).x;
    if (tag == SHADE) {
        textureStore(light, texel, 1, vec4u(t_bits));
        @if(resumes_light) {
            let item = textureLoad(state, texel, 3).x;
            if (item >= LIGHTS_SUMMED) {
                first = item - LIGHTS_SUMMED;
                sum = load_color(texel);
            }
        }
    } else {
        first = textureLoad(light, texel, 0).x;
        sum = arrived(texel, tag);
        t_bits = textureLoad(light, texel, 1).x;
    }
    let t = bitcast<f32>(t_bits);
    let u = bitcast<f32>(textureLoad(hit, texel, 0, 0).x);
    let v = bitcast<f32>(textureLoad(hit, texel, 1, 0).x);
    let triangle = textureLoad(hit, texel, 2, 0).x;
    let material = material_of(triangle);
    let direction = load_direction(texel);
    let position = load_origin(texel) + direction * t;
    var normal = surface_normal(triangle, u, v);
    @if(double_sided) {
        if (material.double_sided != 0u && dot3(normal, direction) > 0.0) {
            normal = -normal;
        }
    }

    @if(specular) if (optics_of(triangle).kind != DIFFUSE) {
        first = shading.lights;
    }
    var end = shading.lights;
    @if(resumes_light) end = min(end, first + TURNS);
    for (var i = first; i < end; i++) {
        let rgb = received(lights[i], position, normal);
        if (all(rgb == vec3f(0.0))) {
            continue;
        }
        let start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
        if (is_cast(texel, start, i, rgb)) {
            store_color(texel, sum);
            textureStore(state, texel, 0, vec4u(SHADOW_SETUP));
            return SHADOW_SETUP;
        }
    }
    @if(resumes_light) if (end < shading.lights) {
        store_color(texel, sum);
        textureStore(state, texel, 0, vec4u(SHADE));
        textureStore(state, texel, 1, vec4u(t_bits));
        textureStore(state, texel, 3, vec4u(LIGHTS_SUMMED + end));
        return SHADE;
    }
    var rgb = sum * diffuse_color(material, triangle, u, v);
    @if(emissive) {
        rgb = rgb + material.emissive;
    }
    store_color(texel, rgb);
    textureStore(state, texel, 1, vec4u(t_bits));
    textureStore(state, texel, 0, vec4u(LIT));
    return LIT;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn illuminate(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_light(tiled_texel(group, lane)));
}
