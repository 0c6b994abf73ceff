// Exercise 8: a shadow ray. Write shadow_ray; 8-shadow.md says where it begins and ends.
//
// This is the kernel illuminate. For a ray that has hit a surface, it casts a shadow ray to the next light, and adds what the
// one before has brought.

import package::constants::{INF, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::corners::{vertex};
import package::live::{book, tiled_texel};
import package::ray::{load_direction, load_origin};
import package::shade_light::{lights, received, shading};
import package::shade_surface::{diffuse_color, material_of, surface_normal};
import package::start::{Start, end_before, leaving, start_of};
import package::state::{BACKGROUND, DONE, OCCLUDED, SHADE, SHADOW_SETUP, VISIBLE};
import package::vector::{dot3};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(5) var pending: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(6) var light: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(7) var blocker: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(8) var surface: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(9) var shadow_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(10) var shadow_direction: texture_storage_2d_array<r32float, write>;

// A ray from a surface towards a light: a triangle that it hits before t = end keeps the light off.
struct ShadowRay {
    origin: vec3f,
    direction: vec3f,
    end: f32,
    // Whether it has to be traced: not if the light is behind the surface.
    is_cast: bool,
}

// The shadow ray from a point of a surface to light i.
//
// start: the point. start.point: vec3f is where it is, and start.normal: vec3f, of length 1, points to the side from which it is
// seen. leaving(start) is the same point, moved off the surface by more than rounding can be wrong: a ray that begins there
// cannot hit the surface that it leaves.
// The light: lights[i].kind is 1 for one that is infinitely far away, whose light travels along lights[i].direction; any other
// is at lights[i].position.
// end_before(light_position, direction): the t just before the light, for a direction that reaches the light at t = 1.
fn shadow_ray(start: Start, i: u32) -> ShadowRay {
    // HOLE: the ray ends where it begins, so nothing is in its way.
    return ShadowRay(leaving(start), vec3f(0.0, 1.0, 0.0), 0.0, true);
}

fn load_three(texel: vec2u, of_color: bool) -> vec3f {
    if (of_color) {
        return vec3f(textureLoad(color, texel, 0).x, textureLoad(color, texel, 1).x, textureLoad(color, texel, 2).x);
    }
    return vec3f(textureLoad(pending, texel, 0).x, textureLoad(pending, texel, 1).x, textureLoad(pending, texel, 2).x);
}

fn store_color(texel: vec2u, rgb: vec3f) {
    textureStore(color, texel, 0, vec4f(rgb.x));
    textureStore(color, texel, 1, vec4f(rgb.y));
    textureStore(color, texel, 2, vec4f(rgb.z));
}

// Stores a shadow ray, and the light that it brings if nothing is in its way.
fn send_off(texel: vec2u, ray: ShadowRay, i: u32, rgb: vec3f) {
    textureStore(shadow_origin, texel, 0, vec4f(ray.origin.x));
    textureStore(shadow_origin, texel, 1, vec4f(ray.origin.y));
    textureStore(shadow_origin, texel, 2, vec4f(ray.origin.z));
    textureStore(shadow_direction, texel, 0, vec4f(ray.direction.x));
    textureStore(shadow_direction, texel, 1, vec4f(ray.direction.y));
    textureStore(shadow_direction, texel, 2, vec4f(ray.direction.z));
    textureStore(pending, texel, 0, vec4f(rgb.x));
    textureStore(pending, texel, 1, vec4f(rgb.y));
    textureStore(pending, texel, 2, vec4f(rgb.z));
    textureStore(surface, texel, 0, vec4u(textureLoad(hit, texel, 2, 0).x));
    textureStore(blocker, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(light, texel, 0, vec4u(i + 1u));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(ray.end)));
}

// Returns the state in which the ray goes on.
fn next_light(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag == BACKGROUND) {
        store_color(texel, shading.background);
        textureStore(state, texel, 0, vec4u(DONE));
        return DONE;
    }
    if (tag != SHADE && tag != OCCLUDED && tag != VISIBLE) {
        return NOBODY;
    }

    // The first light, and no light yet; or the light after that of the last shadow ray, and what has arrived so far.
    var first = 0u;
    var sum = vec3f(0.0);
    var t_bits = textureLoad(state, texel, 1).x;
    if (tag == SHADE) {
        textureStore(light, texel, 1, vec4u(t_bits));
    } else {
        first = textureLoad(light, texel, 0).x;
        t_bits = textureLoad(light, texel, 1).x;
        sum = load_three(texel, true);
        if (tag == VISIBLE) {
            sum += load_three(texel, false);
        }
    }
    let u = bitcast<f32>(textureLoad(hit, texel, 0, 0).x);
    let v = bitcast<f32>(textureLoad(hit, texel, 1, 0).x);
    let triangle = textureLoad(hit, texel, 2, 0).x;
    let material = material_of(triangle);
    let direction = load_direction(texel);
    let position = load_origin(texel) + direction * bitcast<f32>(t_bits);
    var normal = surface_normal(triangle, u, v);
    if (material.double_sided != 0u && dot3(normal, direction) > 0.0) {
        normal = -normal;
    }
    for (var i = first; i < shading.lights; i++) {
        let rgb = received(lights[i], position, normal);
        if (all(rgb == vec3f(0.0))) {
            continue;
        }
        let start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
        let ray = shadow_ray(start, i);
        if (ray.is_cast) {
            send_off(texel, ray, i, rgb);
            store_color(texel, sum);
            textureStore(state, texel, 0, vec4u(SHADOW_SETUP));
            return SHADOW_SETUP;
        }
    }
    store_color(texel, sum * diffuse_color(material, triangle, u, v) + material.emissive);
    textureStore(state, texel, 1, vec4u(t_bits));
    textureStore(state, texel, 0, vec4u(DONE));
    return DONE;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn illuminate(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_light(tiled_texel(group, lane)));
}
