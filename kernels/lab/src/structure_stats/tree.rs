//! Statistics of a BVH's nodes, binary or eight-wide.

use raystep_kernels::scene_data::SceneData;
use raystep_kernels::structures::bvh::{MAX_LEAF, MAX_WIDE_LEAF, WideContent};

/// Entries of the histogram of leaf sizes: from 0 (only in the BVH of an empty scene) to the maximum size of a leaf.
const SIZES: usize = 1 + if MAX_LEAF > MAX_WIDE_LEAF { MAX_LEAF } else { MAX_WIDE_LEAF } as usize;

/// Statistics of a BVH. The leaves of a wide BVH are slots of its nodes, and count as leaves, too.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeStats {
    /// Maximum number of children of a node: 2 or 8.
    pub width: u32,
    /// Inner nodes.
    pub inner: u64,
    /// Leaves.
    pub leaves: u64,
    /// How many leaves are at each level; entry 0 is the root's level.
    pub depths: Vec<u64>,
    /// How many leaves have 0, 1, … triangles.
    pub sizes: [u64; SIZES],
    /// Triangles in all leaves; a triangle may be in several.
    pub references: u64,
    /// Expected cost of a ray that hits the root's box, in triangle tests (the surface area heuristic of MacDonald and
    /// Booth, 1990): visits of a node, which cost as much as a test, and tests, weighted by the areas of their boxes.
    /// `None` if the root's box has no area.
    pub sah_cost: Option<f64>,
}

/// A box and its contents.
struct Visit {
    level: usize,
    min: [f64; 3],
    max: [f64; 3],
    content: Content,
}

#[derive(Clone, Copy)]
enum Content {
    Inner(u32),
    Leaf(u32),
}

impl TreeStats {
    /// Statistics of a scene's BVH; `None` without one.
    #[must_use]
    pub fn of(data: &SceneData) -> Option<Self> {
        let is_wide = !data.wide_nodes.is_empty();
        let root = root(data)?;
        let mut stats = Self {
            width: if is_wide { 8 } else { 2 },
            inner: 0,
            leaves: 0,
            depths: Vec::new(),
            sizes: [0; SIZES],
            references: 0,
            sah_cost: None,
        };
        let whole = half_area(&root);
        let mut cost = 0.0;
        let mut waiting = vec![root];
        while let Some(visit) = waiting.pop() {
            match visit.content {
                Content::Inner(node) => {
                    stats.inner += 1;
                    cost += half_area(&visit);
                    waiting.extend(children(data, node, visit.level + 1));
                }
                Content::Leaf(count) => {
                    stats.leaves += 1;
                    stats.references += u64::from(count);
                    stats.sizes[(count as usize).min(SIZES - 1)] += 1;
                    if stats.depths.len() <= visit.level {
                        stats.depths.resize(visit.level + 1, 0);
                    }
                    stats.depths[visit.level] += 1;
                    // A leaf of a binary BVH is a separate node; in a wide BVH it is part of its parent.
                    let visits = if is_wide { 0.0 } else { 1.0 };
                    cost += (visits + f64::from(count)) * half_area(&visit);
                }
            }
        }
        stats.sah_cost = (whole > 0.0 && whole.is_finite()).then(|| cost / whole);
        Some(stats)
    }
}

/// What a BVH has at a point: nodes whose boxes contain it, and triangles in the leaves among them. A ray that ends there
/// can skip none of them. `None` without a BVH.
pub(crate) fn at_point(data: &SceneData, point: [f64; 3]) -> Option<[u64; 2]> {
    let (mut nodes, mut tests) = (0, 0);
    let contains = |visit: &Visit| (0..3).all(|i| (visit.min[i]..=visit.max[i]).contains(&point[i]));
    let is_wide = !data.wide_nodes.is_empty();
    let mut waiting = vec![root(data)?];
    while let Some(visit) = waiting.pop() {
        match visit.content {
            Content::Inner(node) => {
                nodes += 1;
                waiting.extend(children(data, node, 0).into_iter().filter(contains));
            }
            Content::Leaf(count) => {
                nodes += u64::from(!is_wide);
                tests += u64::from(count);
            }
        }
    }
    Some([nodes, tests])
}

fn root(data: &SceneData) -> Option<Visit> {
    if data.wide_nodes.is_empty() { binary(data, 0, 0) } else { wide_root(data) }
}

/// The children of an inner node, at this level.
fn children(data: &SceneData, node: u32, level: usize) -> Vec<Visit> {
    if !data.wide_nodes.is_empty() {
        return wide_children(data, node, level).collect();
    }
    let first = data.bvh_nodes.get(node as usize).map_or(0, |n| n.first);
    [first, first + 1].into_iter().filter_map(|child| binary(data, child, level)).collect()
}

fn binary(data: &SceneData, index: u32, level: usize) -> Option<Visit> {
    let node = data.bvh_nodes.get(index as usize)?;
    let content = if node.is_inner() { Content::Inner(index) } else { Content::Leaf(node.count()) };
    Some(Visit { level, min: node.min.map(f64::from), max: node.max.map(f64::from), content })
}

fn wide_children(data: &SceneData, index: u32, level: usize) -> impl Iterator<Item = Visit> + '_ {
    let children = data.wide_nodes.get(index as usize).into_iter().flat_map(|node| node.children());
    children.map(move |child| {
        let content = match child.content {
            WideContent::Inner(node) => Content::Inner(node),
            WideContent::Leaf { count, .. } => Content::Leaf(count),
        };
        Visit { level, min: child.min, max: child.max, content }
    })
}

/// A wide node has only its children's boxes; the root's own is their union.
fn wide_root(data: &SceneData) -> Option<Visit> {
    data.wide_nodes.first()?;
    let empty = Visit { level: 0, min: [0.0; 3], max: [0.0; 3], content: Content::Inner(0) };
    let union = |a: Visit, b: Visit| Visit {
        min: [0, 1, 2].map(|i| a.min[i].min(b.min[i])),
        max: [0, 1, 2].map(|i| a.max[i].max(b.max[i])),
        ..a
    };
    let root = wide_children(data, 0, 0).reduce(union).unwrap_or(empty);
    Some(Visit { content: Content::Inner(0), ..root })
}

fn half_area(visit: &Visit) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| visit.max[i] - visit.min[i]);
    x * y + y * z + z * x
}

#[cfg(test)]
mod tests {
    use raystep_kernels::export::structure::BvhSummary;
    use raystep_kernels::{Accelerator, Limits, Options, Plan, RaySource, ScheduleKind};
    use raystep_scenes::{Scene, generate};

    use super::*;

    fn planned(scene: &Scene, schedule: ScheduleKind) -> (Plan, SceneData) {
        let rays = RaySource::Given(Vec::new());
        let accelerator = Accelerator::Bvh;
        let options = Options { accelerator, schedule, shade: false, ..Options::new(rays) };
        Plan::new(scene, &options, &Limits::CPU).expect("a small scene")
    }

    #[test]
    fn every_node_is_counted_once() {
        let scene = generate::terrain(2000, 1).expect("a scene");
        for schedule in [ScheduleKind::Second, ScheduleKind::Fused] {
            let (plan, data) = planned(&scene, schedule);
            let (stats, known) = (TreeStats::of(&data).expect("a tree"), BvhSummary::of(&plan, &data).expect("a tree"));
            let is_wide = schedule == ScheduleKind::Fused;
            assert_eq!(stats.width, known.width);
            assert_eq!(stats.inner + if is_wide { 0 } else { stats.leaves }, known.nodes, "{schedule}");
            assert_eq!(stats.references, known.references);
            // The leaves of a wide node are one level below it.
            assert_eq!(stats.depths.len() as u32, known.depth + u32::from(is_wide));
            assert_eq!(stats.depths.iter().sum::<u64>(), stats.leaves);
            assert_eq!(stats.sizes.iter().sum::<u64>(), stats.leaves);
            let cost = stats.sah_cost.expect("an area");
            assert!(cost > 1.0 && cost < 100.0, "{cost}");
        }
    }

    #[test]
    fn the_cost_is_that_of_the_formula() {
        let scene = generate::cornell_box();
        let (_, data) = planned(&scene, ScheduleKind::Second);
        let area = |i: usize| {
            let node = &data.bvh_nodes[i];
            let [x, y, z] = [0, 1, 2].map(|a| f64::from(node.max[a]) - f64::from(node.min[a]));
            x * y + y * z + z * x
        };
        let expected: f64 =
            (0..data.bvh_nodes.len()).map(|i| (1.0 + f64::from(data.bvh_nodes[i].count())) * area(i) / area(0)).sum();
        let cost = TreeStats::of(&data).and_then(|s| s.sah_cost).expect("an area");
        assert!((cost - expected).abs() < 1e-9 * expected, "{cost} {expected}");
    }

    #[test]
    fn an_empty_scene_has_a_leaf_without_triangles_or_no_tree() {
        let empty = Scene { materials: generate::cornell_box().materials, ..Scene::default() };
        let stats = TreeStats::of(&planned(&empty, ScheduleKind::Second).1).expect("a tree");
        assert_eq!((stats.leaves, stats.references, stats.sizes[0], stats.sah_cost), (1, 0, 1, None));
        let wide = TreeStats::of(&planned(&empty, ScheduleKind::Fused).1).expect("a tree");
        assert_eq!((wide.inner, wide.leaves, wide.sah_cost), (1, 0, None));
        assert_eq!(TreeStats::of(&SceneData::default()), None);
    }
}
