//! The light tree of a pixel as lines in space.

use glam::DVec3;
use raystep_kernels::export::light_tree::{Fate, LightTree, Place, VertexKind};
use raystep_kernels::export::trace::Trace;

use super::Aabb;

/// A ray of the tree, in traced units.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Where it begins.
    pub from: DVec3,
    /// How far it came: to its vertex, or to what is in its way.
    pub to: DVec3,
    /// Where its vertex is, if it did not come that far.
    pub beyond: Option<DVec3>,
    /// What its vertex is.
    pub kind: VertexKind,
    /// The linear light that it brings, or would bring, from a light.
    pub light: Option<[f32; 3]>,
    /// Its vertex in words: `light 2: occluded by triangle 5`.
    pub name: String,
}

/// The rays that were cast. One to something infinitely far away goes on for a while after it leaves the scene's box.
#[must_use]
pub fn branches(tree: &LightTree, trace: &Trace, scene: &Aabb) -> Vec<Branch> {
    let point = |at: [f64; 3]| DVec3::from_array(trace.traced(at));
    let ray = |vertex: &raystep_kernels::export::light_tree::Vertex| {
        let parent = tree.vertices.get(vertex.parent?)?;
        let Place::Point(from) = parent.place else { return None };
        let from = point(from);
        let end = match vertex.place {
            Place::Point(at) => point(at),
            Place::Direction(direction) => {
                let direction = DVec3::from_array(direction).normalize_or_zero();
                let leaves = scene.interval(from, direction).map_or(0.0, |[_, leaves]| leaves);
                from + direction * (leaves + 0.3 * scene.radius())
            }
        };
        let (to, beyond) = match vertex.fate {
            Fate::NotCast => return None,
            Fate::Reached => (end, None),
            Fate::Open => (from, Some(end)),
            Fate::Occluded { point_scene, .. } => (point(point_scene), Some(end)),
        };
        let is_light = vertex.kind == VertexKind::Light;
        let name = match vertex.fate {
            Fate::Occluded { .. } => format!("{}: {}", vertex.name(), vertex.why),
            _ => vertex.name(),
        };
        let light = vertex.arrives.filter(|_| is_light);
        let is_finite = from.is_finite() && end.is_finite() && to.is_finite();
        is_finite.then_some(Branch { from, to, beyond, kind: vertex.kind, light, name })
    };
    tree.vertices.iter().filter_map(ray).collect()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Options;
    use raystep_kernels::options::Integrator;
    use raystep_kernels::programs::light::PROGRAM;

    use super::super::tests::{options, scene, traced};
    use super::*;

    #[test]
    fn lines_end_where_rays_did() {
        let scene = scene("lights.gltf");
        let options = Options { integrator: Integrator::Shadows, ..options(&scene) };
        let (mut occluded, mut reached) = (0, 0);
        for pixel in [[20, 40], [32, 50], [40, 44], [32, 32], [3, 3]] {
            let (trace, data) = traced(&scene, &options, pixel);
            let tree = LightTree::of(&trace.rows, &PROGRAM, &data).expect("a tree");
            let bounds = Aabb::of_vertices(&data.vertices);
            let lines = branches(&tree, &trace, &bounds);
            let cast = tree.vertices.iter().filter(|vertex| vertex.parent.is_some() && vertex.fate != Fate::NotCast);
            assert_eq!(lines.len(), cast.count());
            let ray = trace.rows[0].after;
            let origin = DVec3::from_array(ray.origin.map(f64::from));
            assert!((lines[0].from - origin).length() < 1e-6, "{lines:?}");
            for line in &lines[1..] {
                assert!((line.from - lines[0].to).length() < 1e-6, "a shadow ray leaves the hit: {line:?}");
                let Some(end) = line.beyond else {
                    reached += 1;
                    continue;
                };
                // The blocker is on the way.
                let (way, part) = (end - line.from, line.to - line.from);
                assert!(way.normalize().dot(part.normalize()) > 1.0 - 1e-6 && part.length() < way.length(), "{line:?}");
                occluded += 1;
            }
        }
        assert!(occluded > 0 && reached > 2, "{occluded} occluded, {reached} not");
    }
}
