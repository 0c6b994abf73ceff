// Where photons begin: an emitter is picked by its power, a point of it and a direction at random. What each photon carries
// is then the flux of the emitter by the number of photons and the probability that it was picked.

import package::connected::{INVERSE_PI};
import package::constants::{NO_TRIANGLE};
import package::corners::{vertex};
import package::direction::{cosine_weighted, on_circle, perpendicular};
import package::emitters::{PUNCTUAL, cone_of, pdf_by_area, picked};
import package::photon_map::{photon_map};
import package::random::{FOR_CHANCE, FOR_DIRECTION, FOR_EMITTER, FOR_POINT, OF_PHOTONS, decided_by};
import package::shade_light::{lights};
import package::shade_surface::{material_of};
import package::start::{leaving, start_of};
import package::vector::{cross3, dot3, unit3};

struct Emitted {
    origin: vec3f,
    // Length 1.
    direction: vec3f,
    power: vec3f,
    // The triangle that it leaves.
    leaves: u32,
}

// A direction at an angle with this cosine to an axis of length 1.
fn about(axis: vec3f, cosine: f32, turns: f32) -> vec3f {
    let at = on_circle(turns) * sqrt(max(1.0 - cosine * cosine, 0.0));
    return unit3(perpendicular(axis, at) + axis * cosine);
}

fn emitted_photon(index: u32) -> Emitted {
    let emitter = picked(decided_by(OF_PHOTONS, index, 0u, FOR_EMITTER));
    let toward = decided_by(OF_PHOTONS, index, 0u, FOR_DIRECTION);
    let photons = f32(photon_map.photons);
    var photon: Emitted;
    photon.leaves = NO_TRIANGLE;
    if ((emitter.id & PUNCTUAL) != 0u) {
        let light = lights[emitter.id ^ PUNCTUAL];
        photon.power = light.color * (1.0 / (photons * emitter.chance));
        if (light.kind == 1u) {
            // Through a disc that covers the scene.
            let at = on_circle(toward.y) * (sqrt(toward.x) * photon_map.reach);
            photon.direction = unit3(light.direction);
            photon.origin = photon_map.center + perpendicular(photon.direction, at) - photon.direction * photon_map.reach;
            photon.power *= photon_map.reach * photon_map.reach / INVERSE_PI;
            return photon;
        }
        photon.origin = light.position;
        var axis = vec3f(0.0, 0.0, 1.0);
        var least = -1.0;
        @if(spot_lights) if (light.kind == 2u) {
            axis = unit3(light.direction);
            least = light.cos_outer;
        }
        photon.direction = about(axis, 1.0 - toward.x * (1.0 - least), toward.y);
        photon.power *= 2.0 * (1.0 - least) / INVERSE_PI;
        @if(spot_lights) if (light.kind == 2u) {
            photon.power *= cone_of(light, -photon.direction);
        }
        // From outside, it begins where it may first hit something: there, t is as exact as for other rays.
        let ahead = dot3(photon_map.center - photon.origin, photon.direction) - photon_map.reach;
        if (ahead > 0.0) {
            photon.origin += photon.direction * ahead;
        }
        return photon;
    }
    @if(emissive) {
        let a = vertex(emitter.id, 0u);
        let b = vertex(emitter.id, 1u);
        let c = vertex(emitter.id, 2u);
        let by = decided_by(OF_PHOTONS, index, 0u, FOR_POINT);
        let side = sqrt(by.x);
        let material = material_of(emitter.id);
        let is_double = material.double_sided != 0u;
        let front = unit3(cross3(unit3(b - a), unit3(c - a)));
        let is_back = is_double && decided_by(OF_PHOTONS, index, 0u, FOR_CHANCE).x >= 0.5;
        let seen_along = select(-front, front, is_back);
        let start = start_of(a, b, c, side * (1.0 - by.y), side * by.y, seen_along);
        photon.origin = leaving(start);
        photon.direction = cosine_weighted(start.normal, toward);
        // The flux of a side by its area is pi times the radiance, and the pdf that of a point of either side.
        let of_point = pdf_by_area(material.emissive, material.double_sided);
        photon.power = material.emissive * (select(1.0, 2.0, is_double) / (INVERSE_PI * photons * of_point));
        photon.leaves = emitter.id;
    }
    return photon;
}
