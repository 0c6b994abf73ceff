//! Where two light trees of a pixel part: those of its rays on a device, and by the CPU reference kernels in f32 and f64.
//!
//! Each follows its own rays from the camera on, so that rounding adds up from bounce to bounce, unlike in
//! [`divergence`](super::divergence), which begins anew with every pass.

use raystep_kernels::history::light_tree::{Fate, LightTree, Vertex};

/// Two values are apart if they differ by more than this part of the larger. A bounce has at most some hundred roundings of
/// 6·10⁻⁸, which curved surfaces enlarge by one or two orders of magnitude; in a picture, less than this is not seen.
pub const APART: f64 = 1e-3;

/// How two light trees of a pixel compare.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// The largest relative difference between values of the vertices before they part.
    pub rounding: f64,
    /// Where they part.
    pub first: Option<Part>,
}

/// The first vertex in which they differ by more than rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The vertex in the first tree; of a vertex that only the second has, its parent.
    pub vertex: usize,
    /// Its sample, from 0.
    pub sample: u32,
    /// Its bounce: surfaces before it.
    pub depth: u32,
    /// What differs, of the first tree and of the second.
    pub what: String,
}

impl Apart {
    /// Compares two trees.
    #[must_use]
    pub fn of(a: &LightTree, b: &LightTree) -> Self {
        let mut rounding = 0.0;
        for (vertex, (ours, theirs)) in a.vertices.iter().zip(&b.vertices).enumerate() {
            let part = |what| Part { vertex, sample: ours.sample, depth: ours.depth, what };
            match differs(ours, theirs) {
                Ok(off) => rounding = off.max(rounding),
                Err(what) => return Self { rounding, first: Some(part(what)) },
            }
        }
        let both = a.vertices.len().min(b.vertices.len());
        let more = a.vertices.get(both).map(|vertex| (vertex, false)).or(b.vertices.get(both).map(|v| (v, true)));
        let first = more.map(|(vertex, is_of_second)| Part {
            vertex: if is_of_second { vertex.parent.unwrap_or(both.saturating_sub(1)) } else { both },
            sample: vertex.sample,
            depth: vertex.depth,
            what: if is_of_second { format!("none, {}", vertex.name()) } else { format!("{}, none", vertex.name()) },
        });
        Self { rounding, first }
    }

    /// In a sentence, with the names of the two.
    #[must_use]
    pub fn sentence(&self, names: [&str; 2], samples: u32) -> String {
        let [ours, theirs] = names;
        let Some(Part { sample, depth, what, .. }) = &self.first else {
            return match self.rounding == 0.0 {
                true => format!("{ours} and {theirs} have the same light tree, with the same values."),
                false => format!(
                    "{ours} and {theirs} have the same light tree; values differ by rounding, at most {:.1e} of their size.",
                    self.rounding
                ),
            };
        };
        let sample = if samples > 1 { format!(" of sample {}", sample + 1) } else { String::new() };
        format!(
            "{ours} and {theirs} part at depth {depth}{sample}: {what}. Before it, values differ by at most {:.1e} of their size.",
            self.rounding
        )
    }
}

/// The relative difference of two vertices' values; the error says in what they are apart.
fn differs(a: &Vertex, b: &Vertex) -> Result<f64, String> {
    if (a.kind, a.sample, a.depth, a.triangle, a.light) != (b.kind, b.sample, b.depth, b.triangle, b.light) {
        return Err(format!("{}, {}", a.name(), b.name()));
    }
    let is_occluded = |vertex: &Vertex| matches!(vertex.fate, Fate::Occluded { .. });
    if is_occluded(a) != is_occluded(b) {
        return Err(format!("{} is reached in one and occluded in the other: {}; {}", a.name(), a.why, b.why));
    }
    let mut most = 0.0_f64;
    let wide = |rgb: [f32; 3]| rgb.map(f64::from);
    let values = [
        ("throughput", a.throughput.map(wide).zip(b.throughput.map(wide))),
        ("light that arrives", a.arrives.map(wide).zip(b.arrives.map(wide))),
        ("light that is added", Some((a.contribution, b.contribution))),
    ];
    for (name, values) in values {
        let Some((ours, theirs)) = values else { continue };
        let off = relative(ours, theirs);
        if off > APART {
            let text = |rgb: [f64; 3]| rgb.map(|c| format!("{c:.5}")).join(" ");
            return Err(format!("{name} at {}: {}, {}", a.name(), text(ours), text(theirs)));
        }
        most = most.max(off);
    }
    // The same vertex, but only one path goes on.
    if a.why != b.why && !is_occluded(a) {
        return Err(format!("at {}: {}, {}", a.name(), a.why, b.why));
    }
    Ok(most)
}

/// The largest difference of components, by the largest of all; values that are not finite are apart unless they are equal.
fn relative(a: [f64; 3], b: [f64; 3]) -> f64 {
    let size = a.iter().chain(&b).fold(0.0, |most: f64, c| most.max(c.abs()));
    let off =
        a.iter().zip(&b).map(|(a, b)| if a == b || (a.is_nan() && b.is_nan()) { 0.0 } else { (a - b).abs() / size });
    off.fold(0.0, |most: f64, off| if off.is_nan() { f64::INFINITY } else { most.max(off) })
}

#[cfg(test)]
mod tests {
    use raystep_kernels::history::RunSoFar;
    use raystep_kernels::options::Integrator;
    use raystep_kernels::plan::Limits;
    use raystep_kernels::{Accelerator, Options, Plan, RaySource};
    use raystep_scenes::generate;

    use super::*;

    /// The trees of all pixels of a path tracer's run, in f32 and in f64.
    fn trees() -> Vec<[LightTree; 2]> {
        let mut scene = generate::whitted(2).expect("a scene");
        scene.materials[0].emissive = [0.25, 0.5, 0.0];
        let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 24, height: 24 };
        let base = Options::new(rays);
        let options = Options { integrator: Integrator::Path, accelerator: Accelerator::Bvh, ..base };
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let all = (0..24 * 24).map(|ray| {
            let pixel = [ray % 24, ray / 24];
            let lives = [run.follow::<f32>(pixel), run.follow::<f64>(pixel)].map(|life| life.expect("a ray"));
            lives.map(|life| LightTree::of(&life.rows, plan.program, &data).expect("a tree"))
        });
        all.collect()
    }

    #[test]
    fn f32_and_f64_follow_the_same_path_within_rounding_until_they_part() {
        let trees = trees();
        let found: Vec<Apart> = trees.iter().map(|[single, double]| Apart::of(single, double)).collect();
        let same = found.iter().filter(|apart| apart.first.is_none()).count();
        assert!(same > 400, "{same} of {}", found.len());
        for ([single, double], apart) in trees.iter().zip(&found) {
            assert!(apart.rounding <= APART);
            let Some(part) = &apart.first else {
                let (a, b) = (single.sum(), double.sum());
                assert!(relative(a, b) <= APART, "{a:?} {b:?}");
                continue;
            };
            // All vertices before are of the same surfaces.
            let before = single.vertices.iter().zip(&double.vertices).take(part.vertex);
            assert!(before.clone().all(|(a, b)| (a.kind, a.triangle) == (b.kind, b.triangle)), "{part:?}");
            assert_eq!(single.vertices[part.vertex].sample, part.sample);
        }
        assert!(found.iter().any(|apart| apart.rounding > 0.0));
    }

    #[test]
    fn a_vertex_of_another_triangle_is_where_trees_part() {
        let trees = trees();
        let deep = trees.iter().find(|[tree, _]| tree.vertices.iter().any(|v| v.depth == 2 && v.triangle.is_some()));
        let [tree, _] = deep.expect("a path of two bounces");
        assert_eq!(Apart::of(tree, tree), Apart { rounding: 0.0, first: None });
        assert!(Apart::of(tree, tree).sentence(["a", "b"], 1).contains("the same values"));
        let at = tree.vertices.iter().position(|v| v.depth == 2 && v.triangle.is_some()).expect("a vertex");
        let mut other = tree.clone();
        other.vertices[at].triangle = Some(9_999);
        let part = Apart::of(tree, &other).first.expect("a difference");
        assert_eq!((part.vertex, part.depth), (at, 2));
        assert!(part.what.ends_with("triangle 9999"), "{part:?}");
        let mut other = tree.clone();
        let throughput = other.vertices[at].throughput.as_mut().expect("a throughput");
        *throughput = throughput.map(|c| c * 1.01);
        let apart = Apart::of(tree, &other);
        let part = apart.first.as_ref().expect("a difference");
        assert_eq!((part.vertex, part.depth), (at, 2));
        assert!(
            apart.sentence(["f32", "f64"], 2).starts_with("f32 and f64 part at depth 2 of sample 1: throughput at")
        );
        // A rounding is no difference.
        let mut other = tree.clone();
        let throughput = other.vertices[at].throughput.as_mut().expect("a throughput");
        *throughput = throughput.map(|c| c * 1.000_001);
        let apart = Apart::of(tree, &other);
        assert!(apart.first.is_none() && apart.rounding > 0.0, "{apart:?}");
        let mut shorter = tree.clone();
        shorter.vertices.truncate(at);
        assert_eq!(Apart::of(tree, &shorter).first.map(|part| part.vertex), Some(at));
    }
}
