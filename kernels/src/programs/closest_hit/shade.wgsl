// Colours the ray: emitted light plus the paper's equation (1), C_diff <N, L>, summed over the lights,
// or the background. No falloff with distance, no shadows.
//
// resumes_light: there are more lights than a dispatch has loop iterations. The sum so far waits in color, and the
// number of lights in it, marked by LIGHTS_SUMMED, in the state's item.

import package::constants::{WORKGROUP, TURNS, LIGHTS_SUMMED};
import package::state::{SHADE, BACKGROUND, DONE};
import package::ray::{load_origin, load_direction};
import package::vector::{dot3};
import package::shade_surface::{material_of, surface_normal, diffuse_color};
import package::shade_light::{lights, received, shading};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@if(!resumes_light) @group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@if(resumes_light) @group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn shade(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag != SHADE && tag != BACKGROUND) {
        return;
    }

    var rgb = shading.background;
    if (tag == SHADE) {
        let t = bitcast<f32>(textureLoad(state, texel, 1).x);
        let u = bitcast<f32>(textureLoad(hit, texel, 0, 0).x);
        let v = bitcast<f32>(textureLoad(hit, texel, 1, 0).x);
        let triangle = textureLoad(hit, texel, 2, 0).x;
        let material = material_of(triangle);
        let direction = load_direction(texel);
        let position = load_origin(texel) + direction * t;
        let diffuse = diffuse_color(material, triangle, u, v);
        var normal = surface_normal(triangle, u, v);
        @if(double_sided) {
            if (material.double_sided != 0u && dot3(normal, direction) > 0.0) {
                normal = -normal;
            }
        }
        @if(many_lights) {
            rgb = vec3f(0.0);
            var first = 0u;
            var end = shading.lights;
            @if(resumes_light) {
                let item = textureLoad(state, texel, 3).x;
                if (item >= LIGHTS_SUMMED) {
                    first = item - LIGHTS_SUMMED;
                    rgb.x = textureLoad(color, texel, 0).x;
                    rgb.y = textureLoad(color, texel, 1).x;
                    rgb.z = textureLoad(color, texel, 2).x;
                }
                end = min(end, first + TURNS);
            }
            for (var i = first; i < end; i++) {
                rgb += received(lights[i], position, normal);
            }
            @if(resumes_light) if (end < shading.lights) {
                textureStore(color, texel, 0, vec4f(rgb.x));
                textureStore(color, texel, 1, vec4f(rgb.y));
                textureStore(color, texel, 2, vec4f(rgb.z));
                textureStore(state, texel, 3, vec4u(LIGHTS_SUMMED + end));
                return;
            }
        }
        @else {
            rgb = received(lights[0], position, normal);
        }
        rgb = rgb * diffuse;
        @if(emissive) {
            rgb = rgb + material.emissive;
        }
    }
    textureStore(color, texel, 0, vec4f(rgb.x));
    textureStore(color, texel, 1, vec4f(rgb.y));
    textureStore(color, texel, 2, vec4f(rgb.z));
    textureStore(state, texel, 0, vec4u(DONE));
}
