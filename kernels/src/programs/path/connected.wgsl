// The light that arrives at a vertex of a path, by either of two strategies: by picking a point of an emitter here, or by
// chance, where the path hits it. mis: both count, each by its weight. by_light: only the first does, but after a mirror or
// glass, whose direction no light can be picked for. Neither: only the second, and only lights without a size are picked.

import package::constants::{DEPTH, INF};
import package::emitters::{pdf_by_area, share_of_hit, weight};
import package::optics::{DIFFUSE, optics_of};
import package::start::{leaving};
import package::toward::{toward_emitter};
import package::vector::{dot3, largest3, unit3};
import package::vertex::{Vertex};

const INVERSE_PI: f32 = 0.318309886;

// What the surface emits along the path, by the pdf of the path's direction.
@if(emissive)
fn emitted(at: Vertex, origin: vec3f, of_direction: f32) -> vec3f {
    let material = at.material;
    if (all(material.emissive == vec3f(0.0)) || (at.start.is_back && material.double_sided == 0u)) {
        return vec3f(0.0);
    }
    let way = at.start.point - origin;
    let of_point = pdf_by_area(material.emissive, material.double_sided) * dot3(way, way)
        / abs(dot3(at.start.normal, at.direction));
    return at.carried * material.emissive * share_of_hit(of_direction, of_point);
}

// A ray to an emitter.
struct Connection {
    // There is one: something of the emitter's light can arrive.
    is_cast: bool,
    origin: vec3f,
    direction: vec3f,
    // The t at which it ends.
    end: f32,
    // What reaches the pixel if nothing is in its way.
    arrives: vec3f,
    // A light, or a triangle, as the table of emitters has it.
    id: u32,
}

@if(shadows)
fn connected(at: Vertex) -> Connection {
    var ray: Connection;
    var is_diffuse = at.depth < DEPTH;
    @if(specular) is_diffuse = is_diffuse && optics_of(at.triangle).kind == DIFFUSE;
    if (!is_diffuse) {
        return ray;
    }
    ray.origin = leaving(at.start);
    let to = toward_emitter(at, ray.origin);
    let cosine = dot3(at.normal, unit3(to.direction));
    if (!to.is_lit || cosine <= 0.0 || dot3(at.start.normal, to.direction) <= 0.0) {
        return ray;
    }
    ray.direction = to.direction;
    ray.end = to.end;
    ray.id = to.id;
    ray.arrives = to.light * (at.carried * at.color * (cosine * INVERSE_PI));
    @if(mis) if (to.pdf > 0.0) {
        ray.arrives *= weight(to.pdf, cosine * INVERSE_PI);
    }
    // A point so near that its pdf is 0 or not finite brings nothing that could be summed.
    ray.is_cast = largest3(ray.arrives) > 0.0 && largest3(ray.arrives) < INF;
    return ray;
}
