//! Twin of `look_up.wgsl`: adds the light at a hit, and sends the ray on, begins the search for photons, or ends it.

use super::reflected::is_diffuse;
use super::searches::{begin_search, irradiance, is_sent_on, map_of, set_sent_on};
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::states::{GATHERED, OCCLUDED, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{BOUNCE, HIT, PDF, RADIANCE, STATE};
use crate::programs::light::bounced::{carried_at, spend};
use crate::programs::path::at_hit::{cost_of_shadow, end, go_on, light_so_far, vertex_of_hit};
use crate::programs::path::connected::INVERSE_PI;
use crate::programs::path::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
use crate::programs::path::vertex::Vertex;
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::photon_map::{CAUSTIC, GLOBAL};
use crate::tables::texels::Texels;

/// Why a pixel's latest ray ended, besides the reasons of a path.
pub(super) const BY_GATHERING: u32 = 6;

fn done<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, why: u32, sum: Vec3<R>) {
    if scene.features.mapped {
        set_sent_on(ray, 0);
    }
    end(ray, why, sum);
}

fn next_ray<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, next: &Next<R>, triangle: u32, depth: u32) {
    go_on(ray, next, triangle, depth);
    // A lamp that a mirror shows to a diffuse surface is in the map of caustics there: as if light had been picked for it.
    if scene.features.mapped && scene.features.gathers_later && is_sent_on(ray) != 0 {
        ray.store(PDF, 0, R::one());
    }
}

/// Sends a ray on from its first diffuse surface.
fn send_on<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, at: &Vertex<'_, R>, sum: Vec3<R>) {
    let next = scattered(at, scene);
    if next.ended != 0 {
        return done(ray, scene, next.ended, sum);
    }
    set_sent_on(ray, 1);
    next_ray(ray, scene, &next, at.triangle, at.depth);
}

/// After a search: adds what its photons bring, and looks in the other map, or sends the ray on, or ends it.
fn after_search<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, at: &Vertex<'_, R>, before: Vec3<R>) {
    let features = &scene.features;
    let (map, is_sent) = (map_of(ray), is_sent_on(ray));
    let sum = before + at.carried * at.color * (irradiance(ray, scene, map, is_sent) * R::from_f32(INVERSE_PI));
    if !features.specular || map != CAUSTIC {
        return done(ray, scene, BY_GATHERING, sum);
    }
    ray.store_vec3(RADIANCE, sum);
    if features.gathers_later && is_sent == 0 && at.depth < features.depth {
        return send_on(ray, scene, at, sum);
    }
    begin_search(ray, scene, GLOBAL, is_sent);
}

/// Processes one ray.
pub fn look_up<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if ![SCATTER, OCCLUDED, VISIBLE, GATHERED].contains(&tag) {
        return;
    }
    let features = &scene.features;
    let depth = ray.load_u32(BOUNCE, 0);
    let carried = carried_at(ray, depth);
    let sum = light_so_far(ray, scene, tag);
    let triangle = ray.load_u32(HIT, 2);
    if features.mapped && tag == GATHERED {
        let at = vertex_of_hit(ray, scene, depth, triangle, carried);
        return after_search(ray, scene, &at, sum);
    }
    let is_specular = triangle != NO_TRIANGLE && !is_diffuse(scene, triangle);
    let next = (is_specular && depth < features.depth)
        .then(|| scattered(&vertex_of_hit(ray, scene, depth, triangle, carried), scene));
    let ended = match &next {
        Some(next) => next.ended,
        None if triangle == NO_TRIANGLE => BY_ESCAPE,
        None if is_specular => BY_DEPTH,
        None => BY_GATHERING,
    };
    if features.counters {
        spend(ray, cost_of_shadow(ray, scene, tag), depth == 0, ended != 0);
    }
    if features.mapped && ended == BY_GATHERING {
        let is_sent = is_sent_on(ray);
        if features.gathers_later && !features.specular && is_sent == 0 && depth < features.depth {
            return send_on(ray, scene, &vertex_of_hit(ray, scene, depth, triangle, carried), sum);
        }
        return begin_search(ray, scene, if features.specular { CAUSTIC } else { GLOBAL }, is_sent);
    }
    match next {
        Some(next) if ended == 0 => next_ray(ray, scene, &next, triangle, depth),
        _ => done(ray, scene, ended, sum),
    }
}
