// What gives light: lights, and triangles that glow. One of them is picked by its power, with the alias method (Walker 1974).

import package::shade_light::{Light};
import package::vector::{dot3};

// The mark of a light among emitters.
const PUNCTUAL: u32 = 0x80000000u;

struct Emitter {
    // The row stands for itself below this number, else for another.
    keep: f32,
    other: u32,
    // A triangle, or a light, marked by PUNCTUAL.
    id: u32,
    // The probability that it is picked.
    chance: f32,
}

struct Emission {
    count: u32,
    // The pdf of a point of a triangle that glows, by area, divided by the luminance of its sides.
    per_luminance: f32,
}

@group(1) @binding(26) var<storage, read> emitters: array<Emitter>;
@group(1) @binding(27) var<uniform> emission: Emission;

// By a pair of numbers from 0 to below 1.
fn picked(by: vec2f) -> Emitter {
    let row = min(u32(by.x * f32(emission.count)), emission.count - 1u);
    let emitter = emitters[row];
    if (by.y < emitter.keep) {
        return emitter;
    }
    return emitters[emitter.other];
}

// The pdf of a point of a triangle, by area.
fn pdf_by_area(emissive: vec3f, double_sided: u32) -> f32 {
    let luminance = dot3(emissive, vec3f(0.2126, 0.7152, 0.0722));
    return luminance * emission.per_luminance * select(1.0, 2.0, double_sided != 0u);
}

// The weight of a sample by one of two strategies (Veach and Guibas 1995): their power heuristic, by squares.
fn weight(pdf: f32, other: f32) -> f32 {
    // By a ratio: squares of pdfs overflow.
    let ratio = other / pdf;
    return 1.0 / (1.0 + ratio * ratio);
}

// The share of the light that counts where a path hits a triangle by chance, with the pdfs of its direction and of that point,
// by solid angle. Without a pdf, there was one direction.
fn share_of_hit(of_direction: f32, of_point: f32) -> f32 {
    @if(mis) return select(weight(of_direction, of_point), 1.0, of_direction == 0.0);
    @else @if(by_light) return select(0.0, 1.0, of_direction == 0.0);
    @else return 1.0;
}

// What arrives from a spot along a direction of length 1, as a share of its intensity.
@if(spot_lights)
fn cone_of(light: Light, towards: vec3f) -> f32 {
    let cone = clamp((dot3(-towards, light.direction) - light.cos_outer) * light.cone_scale, 0.0, 1.0);
    return cone * cone;
}
