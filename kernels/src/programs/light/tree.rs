//! How a pass adds to a pixel's light tree.
//!
//! What brought light is taken from the streams. Why a light cost no ray is found again by the kernel's own functions.

use super::optics::optics_of;
use crate::numbers::real::Vec3;
use crate::program::RayState;
use crate::program::light_tree::{Fate, Grower, Place, Vertex, VertexKind};
use crate::programs::closest_hit::shade::light::received;
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{ALL, BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, SHADOW_SETUP, VISIBLE};
use crate::scene_data::SceneData;
use crate::shared::constants::LIGHTS_SUMMED;
use crate::shared::shading::{DIFFUSE, DIRECTIONAL, Light, SPOT};
use crate::shared::start::start_of;
use crate::shared::vector::{dot3, unit3};
use crate::tables::state::StateRole;

const BLACK: [f32; 3] = [0.0; 3];

/// From the ray before and after a pass of any kernel.
pub(super) fn grow(tree: &mut Grower, data: &SceneData, before: &RayState, after: &RayState) {
    if !data.features.shadows || before.tag == DONE {
        return;
    }
    let was_decided = ALL.role(before.tag) == Some(StateRole::Resolved);
    match before.tag {
        SHADE | OCCLUDED | VISIBLE => illuminated(tree, data, before, after),
        SCATTER => scattered(tree, data, before, after),
        _ if !was_decided && before.light.is_none() => {
            tree.from_camera(after.samples.unwrap_or_default(), after.origin);
        }
        _ => {}
    }
    match after.tag {
        SHADE if !was_decided => hit(tree, data, after),
        BACKGROUND if !was_decided => {
            let rgb = data.shading.background;
            let place = Place::Direction(after.direction.map(f64::from));
            let (arrives, contribution, why) = (Some(rgb), carried(after, rgb.map(f64::from)), "background".into());
            let depth = depth(after);
            tree.add(Vertex { depth, arrives, contribution, why, ..Vertex::new(VertexKind::Background, place) });
        }
        OCCLUDED | VISIBLE if !was_decided => decided(tree, data, after),
        DONE => tree.end_sample(),
        _ => {}
    }
}

/// How many surfaces sent on a ray.
fn depth(ray: &RayState) -> u32 {
    ray.bounce.map_or(0, |bounce| bounce.depth)
}

/// The part of a ray's light that reaches the pixel.
fn carried(ray: &RayState, light: [f64; 3]) -> [f64; 3] {
    let share = ray.bounce.map_or([1.0; 3], |bounce| bounce.throughput);
    [0, 1, 2].map(|c| light[c] * f64::from(share[c]))
}

/// The rays that go on from a surface were found, and the next one is cast: from there, or one that waits.
fn scattered(tree: &mut Grower, data: &SceneData, before: &RayState, after: &RayState) {
    let [from, to] = [before, after].map(|ray| ray.bounce.unwrap_or_default());
    let is_ended = after.tag == DONE;
    let from_here = !is_ended && to.waiting | from.waiting == to.waiting;
    let here = tree.surface().filter(|_| before.triangle.is_some_and(|triangle| triangle < data.info.triangles));
    let mut ray = "refracted";
    if let (Some((surface, hit)), Some(triangle)) = (here, before.triangle) {
        let kind = optics_of(data, triangle).kind;
        let came = Vec3::from_f32(hit.direction);
        let normal = start_of(data.corners::<f64>(triangle), [1.0 / 3.0; 2], came).normal;
        let is_back = dot3(normal, Vec3::from_f32(after.direction)) > 0.0;
        if from_here && (to.waiting != from.waiting || is_back) {
            ray = "reflected";
        }
        let why = match (from_here, to.waiting != from.waiting) {
            _ if kind == DIFFUSE => "no light is left".into(),
            (true, true) => "reflects and refracts".into(),
            (true, false) if ray == "reflected" => "reflects".into(),
            (true, false) => "refracts".into(),
            (false, _) if depth(before) >= data.features.depth => {
                format!("at the largest depth, {}: sends no ray on", data.features.depth)
            }
            (false, _) => "what it would send on is black".into(),
        };
        tree.end(surface, &why);
    }
    if !is_ended {
        tree.cast_ray(ray);
    }
}

/// The point of a triangle that a ray hit; `None` if the scene has no such triangle.
fn point_of(data: &SceneData, ray: &RayState) -> Option<(u32, [f64; 3])> {
    let (triangle, [u, v]) = (ray.triangle?, ray.barycentric?.map(f64::from));
    if triangle >= data.info.triangles {
        return None;
    }
    let [a, b, c] = data.corners::<f64>(triangle);
    Some((triangle, (a + ((b - a) * u + (c - a) * v)).to_f64()))
}

/// A ray hits a surface, which may emit light.
fn hit(tree: &mut Grower, data: &SceneData, ray: &RayState) {
    let Some((triangle, point)) = point_of(data, ray) else { return };
    let emitted = if data.features.emissive { material_of(data, triangle).emissive } else { BLACK };
    let (depth, contribution) = (depth(ray), carried(ray, emitted.map(f64::from)));
    let (triangle, arrives) = (Some(triangle), Some(emitted).filter(|&rgb| rgb != BLACK));
    tree.hit(
        ray,
        Vertex { depth, triangle, arrives, contribution, ..Vertex::new(VertexKind::Surface, Place::Point(point)) },
    );
}

/// A shadow ray was stopped, or was not.
fn decided(tree: &mut Grower, data: &SceneData, ray: &RayState) {
    let light = ray.light.unwrap_or_default();
    if ray.tag == OCCLUDED
        && let Some((triangle, point_scene)) = point_of(data, ray)
    {
        let why = format!("occluded by triangle {triangle}");
        return tree.decide(Fate::Occluded { triangle, point_scene }, [0.0; 3], why);
    }
    let Some((_, surface)) = tree.surface() else { return };
    let (Some(triangle), Some([u, v])) = (surface.triangle, surface.barycentric.map(|uv| uv.map(f64::from))) else {
        return;
    };
    let diffuse = diffuse_color(data, material_of(data, triangle), triangle, [u, v]);
    let rgb = diffuse * Vec3::from_f32(ray.pending.unwrap_or_default());
    tree.decide(Fate::Reached, carried(&surface, rgb.to_f64()), format!("light {light} is visible"));
}

/// The kernel went on from light to light: to one that it cast a shadow ray to, or past the last.
fn illuminated(tree: &mut Grower, data: &SceneData, before: &RayState, after: &RayState) {
    let Some((surface, hit)) = tree.surface() else { return };
    let is_diffuse = |triangle| !data.features.specular || optics_of(data, triangle).kind == DIFFUSE;
    let first = match before.tag {
        // A mirror and a transparent surface have no light but what they send on.
        SHADE if !hit.triangle.is_some_and(is_diffuse) => u32::MAX,
        SHADE => before.item.saturating_sub(LIGHTS_SUMMED),
        _ => before.light.unwrap_or_default(),
    };
    let cast = after.light.filter(|_| after.tag == SHADOW_SETUP).and_then(|next| next.checked_sub(1));
    let end = cast.unwrap_or(if after.tag == SHADE { after.item.saturating_sub(LIGHTS_SUMMED) } else { u32::MAX });
    let number = |i: usize| u32::try_from(i + 1).unwrap_or(u32::MAX);
    for (i, light) in data.lights.iter().enumerate().take(end as usize).skip(first as usize) {
        let (arrives, why) = why_no_ray(data, &hit, light, number(i));
        let fate = Fate::NotCast;
        tree.add(Vertex { fate, arrives: Some(arrives), why, light: Some(number(i)), ..sampled(light, depth(&hit)) });
    }
    if let Some((i, light)) = cast.and_then(|i| Some((i as usize, data.lights.get(i as usize)?))) {
        let why = "its shadow ray is on its way".into();
        tree.add(Vertex {
            fate: Fate::Open,
            arrives: after.pending,
            why,
            light: Some(number(i)),
            ..sampled(light, depth(&hit))
        });
    }
    if after.tag == DONE {
        tree.end(surface, "no light is left");
    }
}

/// The vertex of a light.
fn sampled(light: &Light, depth: u32) -> Vertex {
    let place = match light.kind {
        DIRECTIONAL => Place::Direction(light.direction.map(|d| -f64::from(d))),
        _ => Place::Point(light.position.map(f64::from)),
    };
    Vertex { depth, ..Vertex::new(VertexKind::Light, place) }
}

/// Why no shadow ray was cast to a light, and what it would have brought.
fn why_no_ray(data: &SceneData, hit: &RayState, light: &Light, number: u32) -> ([f32; 3], String) {
    let (Some(triangle), Some([u, v]), Some(t)) = (hit.triangle, hit.barycentric, hit.t) else {
        return (BLACK, String::new());
    };
    let [origin, direction] = [hit.origin, hit.direction].map(Vec3::<f32>::from_f32);
    let position = origin + direction * t;
    let mut normal = surface_normal(data, triangle, u, v);
    let is_double_sided = data.features.double_sided && material_of(data, triangle).double_sided != 0;
    if is_double_sided && dot3(normal, direction) > 0.0 {
        normal = -normal;
    }
    let rgb = received(light, position, normal).to_array();
    let travels = Vec3::<f32>::from_f32(light.direction);
    let to_light = if light.kind == DIRECTIONAL { -travels } else { Vec3::from_f32(light.position) - position };
    let across = start_of(data.corners::<f32>(triangle), [u, v], direction).normal;
    let is_outside = light.kind == SPOT && dot3(-unit3(to_light), travels) <= light.cos_outer;
    let why = match () {
        () if light.color == BLACK => format!("light {number} is black"),
        () if dot3(normal, to_light) <= 0.0 => format!("faces away from light {number}"),
        () if is_outside => format!("outside the cone of light {number}"),
        () if dot3(across, to_light) <= 0.0 => {
            format!("triangle {triangle} faces away from light {number}; its shading normal does not")
        }
        () => format!("too little of light {number} arrives"),
    };
    (rgb, why)
}
