// The light that a point receives.

import package::vector::{dot3, unit3};

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

// What arrives where nothing is hit, and how many lights there are.
struct Shading {
    background: vec3f,
    lights: u32,
}

@group(1) @binding(11) var<storage, read> lights: array<Light>;
@group(1) @binding(14) var<uniform> shading: Shading;

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
