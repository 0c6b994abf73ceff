// How a smooth surface reflects and refracts light: mirrors, and dielectrics by Fresnel's equations for unpolarised light.

import package::shade_surface::{triangle_materials};
import package::start::{Start};
import package::vector::{dot3};

const DIFFUSE: u32 = 0u;
const MIRROR: u32 = 1u;
const SHEET: u32 = 3u;

struct Optics {
    kind: u32,
    ior: f32,
}

// What a surface sends on of light that arrives along a direction: reversed, what a ray sees there.
struct Split {
    // Directions of length 1.
    reflected: vec3f,
    refracted: vec3f,
    // The share of the light that is reflected.
    reflectance: f32,
}

@group(1) @binding(25) var<storage, read> optics: array<Optics>;

// How a triangle's material scatters light.
fn optics_of(triangle: u32) -> Optics {
    @if(many_materials) return optics[triangle_materials[triangle]];
    @else return optics[0];
}

// Splits light along a direction of length 1 at a surface whose normal is on its side. is_back: the light is inside.
fn split(optic: Optics, direction: vec3f, normal: vec3f, is_back: bool) -> Split {
    let cosine = max(-dot3(normal, direction), 0.0);
    var at: Split;
    at.reflected = direction + normal * (2.0 * cosine);
    at.refracted = direction;
    at.reflectance = 1.0;
    if (optic.kind == MIRROR || cosine == 0.0) {
        return at;
    }
    // The ratio of the index on this side to that on the other; a sheet is entered wherever it is hit.
    let ratio = select(1.0 / optic.ior, optic.ior, is_back && optic.kind != SHEET);
    // Beyond the critical angle all light is reflected: exactly, however a device divides.
    let square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if (square <= 0.0) {
        return at;
    }
    // Of the refracted direction.
    let cosine_beyond = sqrt(square);
    let across = (ratio * cosine - cosine_beyond) / (ratio * cosine + cosine_beyond);
    let along = (cosine - ratio * cosine_beyond) / (cosine + ratio * cosine_beyond);
    at.reflectance = 0.5 * (across * across + along * along);
    if (optic.kind != SHEET) {
        at.refracted = direction * ratio + normal * (ratio * cosine - cosine_beyond);
    }
    return at;
}

// The same at a point of a triangle, by an interpolated normal on its side, unless that would lead a ray to the wrong side of
// the triangle.
fn split_at(optic: Optics, direction: vec3f, normal: vec3f, start: Start) -> Split {
    let at = split(optic, direction, normal, start.is_back);
    if (dot3(at.reflected, start.normal) <= 0.0 || dot3(at.refracted, start.normal) >= 0.0) {
        return split(optic, direction, start.normal, start.is_back);
    }
    return at;
}
