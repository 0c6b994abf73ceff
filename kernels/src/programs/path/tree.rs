//! How a pass adds to a pixel's light tree: a path is a branch of surfaces, with a sampled emitter at each.

use super::densities::{of_background, of_emitter_hit, of_light_sample};
use super::explain::why_ended;
use crate::program::RayState;
use crate::program::light_tree::{Fate, Grower, Place, Vertex, VertexKind};
use crate::program::ray_state::Bounce;
use crate::programs::closest_hit::states::{ALL, BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, SHADOW_SETUP, VISIBLE};
use crate::scene_data::SceneData;
use crate::shared::emitters::PUNCTUAL;
use crate::shared::shading::DIRECTIONAL;
use crate::tables::state::StateRole;

/// From the ray before and after a pass of any kernel.
pub(super) fn grow(tree: &mut Grower, data: &SceneData, before: &RayState, after: &RayState) {
    if !data.features.path || before.tag == DONE {
        return;
    }
    let was_decided = ALL.role(before.tag) == Some(StateRole::Resolved);
    match before.tag {
        SHADE | BACKGROUND => sampled_light(tree, data, before, after),
        OCCLUDED | VISIBLE | SCATTER => sampled_bsdf(tree, after),
        _ if !was_decided && before.light.is_none() => {
            tree.from_camera(after.samples.unwrap_or_default(), after.origin);
        }
        _ => {}
    }
    if !was_decided && matches!(after.tag, OCCLUDED | VISIBLE) {
        decided(tree, data, after);
    }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| f64::from(a[c]) - f64::from(b[c]))
}

/// The light that was divided by what a path carries; 0 where it carries none.
fn arriving(light: [f32; 3], bounce: Bounce) -> [f32; 3] {
    [0, 1, 2].map(|c| if bounce.throughput[c] > 0.0 { light[c] / bounce.throughput[c] } else { 0.0 })
}

/// What a surface or the background emits is added, and perhaps a shadow ray is cast.
fn sampled_light(tree: &mut Grower, data: &SceneData, before: &RayState, after: &RayState) {
    let [from, to] = [before, after].map(|ray| ray.bounce.unwrap_or_default());
    // The sum so far begins with a path.
    let so_far = if from.depth == 0 { [0.0; 3] } else { from.radiance };
    let contribution = difference(to.radiance, so_far);
    let emitted = arriving(contribution.map(|c| c as f32), from);
    let (depth, arrives) = (from.depth, Some(emitted).filter(|&rgb| rgb != [0.0; 3]));
    let throughput = Some(from.throughput);
    let Some((triangle, [u, v])) = before.triangle.zip(before.barycentric) else {
        let place = Place::Direction(before.direction.map(f64::from));
        let why = "background".into();
        let density = Some(of_background(before));
        let background = Vertex::new(VertexKind::Background, place);
        tree.add(Vertex { depth, arrives, throughput, density, contribution, why, ..background });
        return;
    };
    if triangle >= data.info.triangles {
        return;
    }
    let [a, b, c] = data.corners::<f64>(triangle);
    let point = (a + ((b - a) * f64::from(u) + (c - a) * f64::from(v))).to_f64();
    let surface = Vertex::new(VertexKind::Surface, Place::Point(point));
    let density = arrives.and_then(|_| of_emitter_hit(data, before));
    let triangle = Some(triangle);
    tree.hit(before, Vertex { depth, triangle, arrives, throughput, density, contribution, ..surface });
    if after.tag == SHADOW_SETUP {
        let id = after.light.unwrap_or_default();
        let index = (id & PUNCTUAL != 0).then_some((id ^ PUNCTUAL) as usize);
        let is_far = index.and_then(|i| data.lights.get(i)).is_some_and(|light| light.kind == DIRECTIONAL);
        let place = match is_far {
            true => Place::Direction(after.direction.map(f64::from)),
            false => Place::Point([0, 1, 2].map(|c| f64::from(after.origin[c]) + f64::from(after.direction[c]))),
        };
        tree.add(Vertex {
            depth,
            fate: Fate::Open,
            arrives: Some(arriving(after.pending.unwrap_or_default(), from)),
            throughput,
            density: of_light_sample(data, before, after),
            why: "its shadow ray is on its way".into(),
            light: index.and_then(|i| u32::try_from(i + 1).ok()),
            triangle: index.is_none().then_some(id),
            ..Vertex::new(VertexKind::Light, place)
        });
    }
}

/// A shadow ray was stopped, or was not.
fn decided(tree: &mut Grower, data: &SceneData, ray: &RayState) {
    let blocker = ray.triangle.filter(|&triangle| ray.tag == OCCLUDED && triangle < data.info.triangles);
    if let Some((triangle, [u, v])) = blocker.zip(ray.barycentric) {
        let [a, b, c] = data.corners::<f64>(triangle);
        let point_scene = (a + ((b - a) * f64::from(u) + (c - a) * f64::from(v))).to_f64();
        let why = format!("occluded by triangle {triangle}");
        return tree.decide(Fate::Occluded { triangle, point_scene }, [0.0; 3], why);
    }
    let what = super::explain::emitter(ray);
    tree.decide(Fate::Reached, ray.pending.unwrap_or_default().map(f64::from), format!("{what} is visible"));
}

/// The path goes on, or ends.
fn sampled_bsdf(tree: &mut Grower, after: &RayState) {
    let bounce = after.bounce.unwrap_or_default();
    let why = if after.tag == DONE { why_ended(bounce.ended) } else { "the path goes on" };
    if let Some((surface, _)) = tree.surface() {
        tree.end(surface, why);
    }
    if after.tag == DONE {
        tree.end_sample();
    } else {
        tree.cast_ray(if bounce.pdf > 0.0 { "scattered" } else { "reflected or refracted" });
    }
}
