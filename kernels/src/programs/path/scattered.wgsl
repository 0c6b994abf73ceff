// Where a path goes on from a vertex, in a direction that the surface's BSDF decides. What it carries is then the product of
// the BSDF and the cosine, by the pdf.
//
// A path that carries little ends by chance, and one that goes on carries more in turn: Russian roulette.

import package::connected::{INVERSE_PI};
import package::direction::{cosine_weighted};
import package::optics::{DIFFUSE, MIRROR, optics_of, split_at};
import package::random::{FOR_CHANCE, FOR_DIRECTION, decided_by};
import package::start::{leaving, through};
import package::vector::{dot3, largest3};
import package::vertex::{Vertex};

// Bounces before a path may end by chance, and the largest chance to go on.
const ROULETTE_DEPTH: u32 = 3u;
const MOST_CHANCE: f32 = 0.95;

// Why a path ended.
const BY_ESCAPE: u32 = 1u;
const BY_DEPTH: u32 = 2u;
const BY_ABSORPTION: u32 = 3u;
const BY_SURFACE: u32 = 4u;
const BY_ROULETTE: u32 = 5u;

// Where a path goes on.
struct Next {
    origin: vec3f,
    direction: vec3f,
    // What it carries.
    throughput: vec3f,
    // The pdf of the direction, by solid angle; 0 if there was no other.
    pdf: f32,
    // Why it ends instead, or 0.
    ended: u32,
}

fn scattered(at: Vertex) -> Next {
    var next: Next;
    let chance = decided_by(at.texel, at.sample, at.depth, FOR_CHANCE);
    next.origin = leaving(at.start);
    next.throughput = at.carried * at.color;
    var is_diffuse = true;
    @if(specular) {
        let optic = optics_of(at.triangle);
        is_diffuse = optic.kind == DIFFUSE;
        if (!is_diffuse) {
            let split = split_at(optic, at.direction, at.normal, at.start);
            next.direction = split.reflected;
            if (optic.kind != MIRROR) {
                if (chance.x < split.reflectance) {
                    next.throughput = at.carried;
                } else {
                    next.origin = through(at.start);
                    next.direction = split.refracted;
                }
            }
        }
    }
    if (is_diffuse) {
        next.direction = cosine_weighted(at.normal, decided_by(at.texel, at.sample, at.depth, FOR_DIRECTION));
        next.pdf = dot3(at.normal, next.direction) * INVERSE_PI;
        if (next.pdf <= 0.0 || dot3(at.start.normal, next.direction) <= 0.0) {
            next.ended = BY_SURFACE;
        }
    }
    let most = largest3(next.throughput);
    if (!(most > 0.0)) {
        next.ended = BY_ABSORPTION;
    } else if (at.depth >= ROULETTE_DEPTH) {
        let goes_on = min(most, MOST_CHANCE);
        next.throughput *= 1.0 / goes_on;
        if (chance.y >= goes_on && next.ended == 0u) {
            next.ended = BY_ROULETTE;
        }
    }
    return next;
}
