// Where a photon goes on from a surface, or that it is absorbed: by Russian roulette with the albedo, so that photons differ
// little in what they carry (Arvo and Kirk 1990). What goes on is never more than what arrived.

import package::direction::{cosine_weighted};
import package::optics::{DIFFUSE, MIRROR, optics_of, split_at};
import package::random::{FOR_CHANCE, FOR_DIRECTION, decided_by};
import package::scattered::{BY_ABSORPTION, BY_ROULETTE, BY_SURFACE, Next};
import package::start::{leaving, through};
import package::vector::{dot3, largest3};
import package::vertex::{Vertex};

@if(specular)
fn is_diffuse(triangle: u32) -> bool {
    return optics_of(triangle).kind == DIFFUSE;
}

@if(!specular)
fn is_diffuse(triangle: u32) -> bool {
    return true;
}

fn reflected_photon(at: Vertex) -> Next {
    // The first decisions are those of its emission.
    let chance = decided_by(at.texel, at.sample, at.depth + 1u, FOR_CHANCE);
    var next: Next;
    next.origin = leaving(at.start);
    var albedo = at.color;
    if (is_diffuse(at.triangle)) {
        next.direction = cosine_weighted(at.normal, decided_by(at.texel, at.sample, at.depth + 1u, FOR_DIRECTION));
        if (dot3(at.normal, next.direction) <= 0.0 || dot3(at.start.normal, next.direction) <= 0.0) {
            next.ended = BY_SURFACE;
        }
    } else {
        @if(specular) {
            let optic = optics_of(at.triangle);
            let split = split_at(optic, at.direction, at.normal, at.start);
            next.direction = split.reflected;
            if (optic.kind != MIRROR) {
                if (chance.x < split.reflectance) {
                    albedo = vec3f(1.0);
                } else {
                    next.origin = through(at.start);
                    next.direction = split.refracted;
                }
            }
        }
    }
    let goes_on = min(largest3(albedo), 1.0);
    if (!(goes_on > 0.0)) {
        next.ended = BY_ABSORPTION;
        return next;
    }
    next.throughput = at.carried * min(albedo * (1.0 / goes_on), vec3f(1.0));
    if (chance.y >= goes_on && next.ended == 0u) {
        next.ended = BY_ROULETTE;
    }
    return next;
}
