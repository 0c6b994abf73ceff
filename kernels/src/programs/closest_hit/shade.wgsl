// Colours the ray: emitted light plus the paper's equation (1), C_diff <N, L>, summed over the lights,
// or the background. No falloff with distance, no shadows.
//
// resumes_light: there are more lights than a dispatch has loop iterations. The sum so far waits in color, and the
// number of lights in it, marked by LIGHTS_SUMMED, in the state's item.

import package::constants::{WORKGROUP, TURNS, LIGHTS_SUMMED};
import package::state::{SHADE, BACKGROUND, DONE};
import package::corners::{vertex};
import package::ray::{load_origin, load_direction};
import package::vector::{dot3, cross3, unit3};
import package::texture::{sample_texture};

struct Material {
    base_color: vec3f,
    // Index into textures, 0xffffffff for none.
    texture: u32,
    emissive: vec3f,
    double_sided: u32,
}

struct Light {
    position: vec3f,
    // 0 point, 1 directional, 2 spot.
    kind: u32,
    // Direction in which the light travels.
    direction: vec3f,
    // Cosine of the half angle of a spot's outer cone, beyond which it is dark.
    cos_outer: f32,
    color: vec3f,
    // 1 / (cosine of the inner half angle - cos_outer).
    cone_scale: f32,
}

struct Shading {
    background: vec3f,
    lights: u32,
}

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@if(!resumes_light) @group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@if(resumes_light) @group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;
@group(1) @binding(14) var<uniform> shading: Shading;
@if(normals) @group(1) @binding(6) var<storage, read> normals: array<f32>;
@if(textures) @group(1) @binding(7) var<storage, read> texcoords: array<f32>;
@if(vertex_colors) @group(1) @binding(8) var<storage, read> vertex_colors: array<f32>;
@if(many_materials) @group(1) @binding(9) var<storage, read> triangle_materials: array<u32>;
@group(1) @binding(10) var<storage, read> materials: array<Material>;
@group(1) @binding(11) var<storage, read> lights: array<Light>;

@if(!normals)
fn surface_normal(triangle: u32, u: f32, v: f32) -> vec3f {
    let a = vertex(triangle, 0u);
    // Each edge is normalised first: the product of two tiny ones would underflow.
    return unit3(cross3(unit3(vertex(triangle, 1u) - a), unit3(vertex(triangle, 2u) - a)));
}

@if(normals)
fn corner_normal(triangle: u32, corner: u32) -> vec3f {
    let first = 9u * triangle + 3u * corner;
    return vec3f(normals[first], normals[first + 1u], normals[first + 2u]);
}

@if(normals)
fn surface_normal(triangle: u32, u: f32, v: f32) -> vec3f {
    let w = 1.0 - u - v;
    return unit3(corner_normal(triangle, 0u) * w + corner_normal(triangle, 1u) * u + corner_normal(triangle, 2u) * v);
}

@if(vertex_colors)
fn corner_color(triangle: u32, corner: u32) -> vec3f {
    let first = 9u * triangle + 3u * corner;
    return vec3f(vertex_colors[first], vertex_colors[first + 1u], vertex_colors[first + 2u]);
}

// <N, L> of one light times its colour.
fn received(light: Light, position: vec3f, normal: vec3f) -> vec3f {
    @if(directional_lights) {
        if (light.kind == 1u) {
            return light.color * max(dot3(normal, -light.direction), 0.0);
        }
    }
    let to_light = unit3(light.position - position);
    let amount = max(dot3(normal, to_light), 0.0);
    @if(spot_lights) {
        if (light.kind == 2u) {
            let cone = clamp((dot3(-to_light, light.direction) - light.cos_outer) * light.cone_scale, 0.0, 1.0);
            return light.color * (amount * cone * cone);
        }
    }
    return light.color * amount;
}

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
        @if(many_materials) let material = materials[triangle_materials[triangle]];
        @else let material = materials[0];
        let direction = load_direction(texel);
        let position = load_origin(texel) + direction * t;

        var diffuse = material.base_color;
        @if(vertex_colors) {
            let w = 1.0 - u - v;
            diffuse = diffuse
                * (corner_color(triangle, 0u) * w + corner_color(triangle, 1u) * u + corner_color(triangle, 2u) * v);
        }
        @if(textures) {
            if (material.texture != 0xffffffffu) {
                let w = 1.0 - u - v;
                let first = 6u * triangle;
                let s = texcoords[first] * w + texcoords[first + 2u] * u + texcoords[first + 4u] * v;
                let r = texcoords[first + 1u] * w + texcoords[first + 3u] * u + texcoords[first + 5u] * v;
                diffuse = diffuse * sample_texture(material.texture, s, r);
            }
        }
        var normal = surface_normal(triangle, u, v);
        @if(double_sided) {
            if (material.double_sided != 0u && dot3(normal, direction) > 0.0) {
                normal = -normal;
            }
        }

        @if(many_lights) {
            rgb = vec3f(0.0);
            @if(!resumes_light) for (var i = 0u; i < shading.lights; i++) {
                rgb += received(lights[i], position, normal);
            }
            @if(resumes_light) var first = textureLoad(state, texel, 3).x;
            @if(resumes_light) {
                if (first >= LIGHTS_SUMMED) {
                    first -= LIGHTS_SUMMED;
                    rgb.x = textureLoad(color, texel, 0).x;
                    rgb.y = textureLoad(color, texel, 1).x;
                    rgb.z = textureLoad(color, texel, 2).x;
                } else {
                    first = 0u;
                }
            }
            @if(resumes_light) let end = min(first + TURNS, shading.lights);
            @if(resumes_light) for (var i = first; i < end; i++) {
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
        @if(!many_lights) {
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
