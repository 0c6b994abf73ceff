//! What rays can find in a BVH: every triangle whose box they pierce.

use std::collections::BTreeSet;

use raystep_kernels::structures::bvh::{BvhData, BvhQuality, WideBvhData, WideContent, build, build_wide};

use super::options;
use super::scenes::{Random, needles, soup};

/// A ray for the slab tests: an origin, and 1 / direction.
struct Ray {
    origin: [f64; 3],
    inverse: [f64; 3],
}

impl Ray {
    fn random(random: &mut Random, center: [f32; 3], extent: f32) -> Self {
        let origin = random.vector().map(|v| f64::from(v * extent * 1.5));
        let target = random.vector().map(|v| f64::from(v * extent));
        let origin = [0, 1, 2].map(|a| origin[a] + f64::from(center[a]));
        let target = [0, 1, 2].map(|a| target[a] + f64::from(center[a]));
        Self { origin, inverse: [0, 1, 2].map(|a| 1.0 / (target[a] - origin[a])) }
    }

    /// Whether it pierces a box grown by `margin`; a triangle's box is shrunk by it, so that f64's rounding errors in
    /// this test do not appear as a fault of the BVH.
    fn pierces(&self, min: [f64; 3], max: [f64; 3], margin: f64) -> bool {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for a in 0..3 {
            let t = [min[a] - margin, max[a] + margin].map(|plane| (plane - self.origin[a]) * self.inverse[a]);
            enter = enter.max(t[0].min(t[1]));
            leave = leave.min(t[0].max(t[1]));
        }
        enter <= leave
    }
}

/// Triangles that a ray finds in the binary BVH.
fn binary_hits(tree: &BvhData, ray: &Ray, margin: f64) -> BTreeSet<u32> {
    let mut hits = BTreeSet::new();
    let mut waiting = vec![0u32];
    while let Some(i) = waiting.pop() {
        let node = &tree.nodes[i as usize];
        if !ray.pierces(node.min.map(f64::from), node.max.map(f64::from), margin) {
            continue;
        }
        if node.is_inner() {
            waiting.extend([node.first, node.first + 1]);
        } else {
            hits.extend(&tree.items[node.first as usize..(node.first + node.count()) as usize]);
        }
    }
    hits
}

/// Triangles that a ray finds in the wide BVH.
fn wide_hits(tree: &WideBvhData, ray: &Ray, margin: f64) -> BTreeSet<u32> {
    let mut hits = BTreeSet::new();
    let mut waiting = vec![0u32];
    while let Some(i) = waiting.pop() {
        for child in tree.nodes[i as usize].children().filter(|c| ray.pierces(c.min, c.max, margin)) {
            match child.content {
                WideContent::Inner(node) => waiting.push(node),
                WideContent::Leaf { first, count } => {
                    hits.extend(tree.triangles[first as usize..(first + count) as usize].iter().map(|entry| entry[3]));
                }
            }
        }
    }
    hits
}

/// A triangle's box, grown.
fn grown_box(v: &[f32], growth: f64) -> ([f64; 3], [f64; 3]) {
    let side = |a: usize, f: fn(f32, f32) -> f32| f64::from(f(f(v[a], v[a + 3]), v[a + 6]));
    ([0, 1, 2].map(|a| side(a, f32::min) - growth), [0, 1, 2].map(|a| side(a, f32::max) + growth))
}

#[test]
fn rays_meet_every_triangle_whose_grown_box_they_pierce() {
    let cases = [([0.0; 3], 1.0, soup(800, 0.1, [1.0; 3], 0.0)), ([1e3; 3], 1.0, soup(800, 0.1, [1.0; 3], 1e3))];
    for (center, extent, vertices) in cases {
        // Only whole triangles: if one is cut, parts of its box are missing, as they should be.
        let options = options(BvhQuality::Fast);
        let growth = 1e-4f32;
        let tree = build(&vertices, growth, &options).expect("a tree");
        let wide = build_wide(&vertices, growth, &options).expect("a tree");
        let mut random = Random::new(3);
        let (mut met, mut needed) = (0, 0);
        for _ in 0..2000 {
            let ray = Ray::random(&mut random, center, extent);
            let (binary, wide) = (binary_hits(&tree, &ray, 1e-9), wide_hits(&wide, &ray, 1e-9));
            for (triangle, v) in vertices.chunks_exact(9).enumerate() {
                let (min, max) = grown_box(v, f64::from(growth));
                if ray.pierces(min, max, 0.0) {
                    assert!(binary.contains(&(triangle as u32)), "binary: triangle {triangle}");
                    assert!(wide.contains(&(triangle as u32)), "wide: triangle {triangle}");
                    needed += 1;
                }
            }
            met += binary.len();
        }
        assert!(needed > 2000 && met < 8 * needed, "{met} met, {needed} needed");
    }
}

/// Points in triangles that are cut into pieces: a ray through one must find the triangle.
#[test]
fn rays_meet_triangles_that_were_cut() {
    let vertices = needles(1000);
    let options = options(BvhQuality::High);
    let tree = build(&vertices, 0.0, &options).expect("a tree");
    let wide = build_wide(&vertices, 0.0, &options).expect("a tree");
    assert!(tree.references > 1020, "{} references: hardly any cuts", tree.references);
    let mut random = Random::new(4);
    for (triangle, v) in vertices.chunks_exact(9).enumerate() {
        for _ in 0..20 {
            let (mut b, mut c) = (f64::from(random.unit().abs()), f64::from(random.unit().abs()));
            if b + c > 1.0 {
                (b, c) = (1.0 - b, 1.0 - c);
            }
            let point =
                [0, 1, 2].map(|a| f64::from(v[a]) * (1.0 - b - c) + f64::from(v[a + 3]) * b + f64::from(v[a + 6]) * c);
            let inverse = random.vector().map(|d| 1.0 / f64::from(d));
            let ray = Ray { origin: point, inverse };
            assert!(binary_hits(&tree, &ray, 1e-9).contains(&(triangle as u32)), "binary: triangle {triangle}");
            assert!(wide_hits(&wide, &ray, 1e-9).contains(&(triangle as u32)), "wide: triangle {triangle}");
        }
    }
}
