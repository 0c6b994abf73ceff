// The way from a point to an emitter that is picked at random, and to a point of it.

import package::constants::{INF};
import package::corners::{vertex};
import package::emitters::{PUNCTUAL, cone_of, pdf_by_area, picked};
import package::random::{FOR_EMITTER, FOR_POINT, decided_by};
import package::shade_light::{lights};
import package::shade_surface::{material_of};
import package::start::{end_before};
import package::vector::{cross3, dot3, unit3};
import package::vertex::{Vertex};

struct Toward {
    // A light, or a triangle, as the table has it.
    id: u32,
    // To a point at t = 1, or against the direction of a light without a place.
    direction: vec3f,
    // The t at which a shadow ray ends.
    end: f32,
    // Radiance by the pdf; of a light without a size, its illuminance by the probability that it was picked.
    light: vec3f,
    // By solid angle; 0 without a size.
    pdf: f32,
    // The side of a triangle glows that is seen.
    is_lit: bool,
}

fn toward_emitter(at: Vertex, origin: vec3f) -> Toward {
    let emitter = picked(decided_by(at.texel, at.sample, at.depth, FOR_EMITTER));
    var to: Toward;
    to.id = emitter.id;
    to.end = INF;
    to.is_lit = true;
    if ((emitter.id & PUNCTUAL) != 0u) {
        let index = emitter.id ^ PUNCTUAL;
        to.light = lights[index].color * (1.0 / emitter.chance);
        to.direction = -lights[index].direction;
        if (lights[index].kind != 1u) {
            to.direction = lights[index].position - origin;
            to.end = end_before(lights[index].position, to.direction);
            to.light *= 1.0 / dot3(to.direction, to.direction);
        }
        @if(spot_lights) if (lights[index].kind == 2u) {
            to.light *= cone_of(lights[index], unit3(to.direction));
        }
        return to;
    }
    @if(emissive) {
        let a = vertex(emitter.id, 0u);
        let ab = vertex(emitter.id, 1u) - a;
        let ac = vertex(emitter.id, 2u) - a;
        let by = decided_by(at.texel, at.sample, at.depth, FOR_POINT);
        let side = sqrt(by.x);
        let point = a + (ab * (side * (1.0 - by.y)) + ac * (side * by.y));
        to.direction = point - origin;
        to.end = end_before(point, to.direction);
        let material = material_of(emitter.id);
        let facing = -dot3(unit3(cross3(unit3(ab), unit3(ac))), unit3(to.direction));
        let cosine = select(facing, abs(facing), material.double_sided != 0u);
        to.is_lit = cosine > 0.0;
        to.pdf = pdf_by_area(material.emissive, material.double_sided) * dot3(to.direction, to.direction) / cosine;
        to.light = material.emissive * (1.0 / to.pdf);
    }
    return to;
}
