//! Two walks of the same ray, through different structures: what each of them visited and tested.

use std::collections::BTreeSet;

use raystep_lab::text::counted;

use super::{Strip, Structure, WalkGeometry};

/// How much farther than the hit a strip goes, as a share of the way there.
const BEYOND: f64 = 0.25;

/// The work of a walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Cells visited, or nodes whose boxes were tested.
    pub visited: usize,
    /// Tests of triangles.
    pub tests: usize,
    /// Different triangles among them.
    pub triangles: usize,
}

impl Work {
    /// Of a walk.
    #[must_use]
    pub fn of(walk: &WalkGeometry) -> Self {
        let visited = walk.cells.len().max(walk.nodes.len());
        Self { visited, tests: walk.tested.len(), triangles: tested(walk).len() }
    }

    /// As words.
    #[must_use]
    pub fn text(&self, structure: Structure) -> String {
        let visited = match structure {
            Structure::Grid => counted(self.visited, "cell") + " visited, ",
            Structure::Tree => counted(self.visited, "node") + " tested, ",
            Structure::Nothing => String::new(),
        };
        let again = if self.tests == self.triangles { String::new() } else { format!(" in {} tests", self.tests) };
        format!("{visited}{} tested{again}", counted(self.triangles, "triangle"))
    }
}

/// Two walks.
#[derive(Clone, Debug, PartialEq)]
pub struct Both {
    /// The range of t that both strips have in common.
    pub t: [f64; 2],
    /// What each did.
    pub work: [Work; 2],
    /// Triangles that only one of them tested, in order of id.
    pub only: [Vec<u32>; 2],
    /// Triangles that both tested.
    pub shared: Vec<u32>,
}

impl Both {
    /// Compares two walks with their strips.
    #[must_use]
    pub fn of(walks: [&WalkGeometry; 2], strips: [&Strip; 2]) -> Self {
        let [a, b] = walks.map(tested);
        let first = strips[0].t[0].min(strips[1].t[0]);
        let end = |i: usize| end_of(walks[i], strips[i], first);
        Self {
            t: [first, end(0).max(end(1))],
            work: walks.map(Work::of),
            only: [a.difference(&b).copied().collect(), b.difference(&a).copied().collect()],
            shared: a.intersection(&b).copied().collect(),
        }
    }
}

/// Where a walk's strip may end: nothing happens far behind a final hit, although boxes go on.
fn end_of(walk: &WalkGeometry, strip: &Strip, first: f64) -> f64 {
    let hit = walk.hit.filter(|_| walk.is_over && walk.structure != Structure::Grid);
    hit.map_or(strip.t[1], |hit| strip.t[1].min(hit.t + (hit.t - first).max(0.0) * BEYOND))
}

fn tested(walk: &WalkGeometry) -> BTreeSet<u32> {
    walk.tested.iter().map(|test| test.triangle).collect()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Options};

    use super::super::Spacing;
    use super::super::tests::{TEAPOT, options, scene, traced, whole};
    use super::*;

    #[test]
    fn two_walks_of_a_ray_are_drawn_on_one_scale_and_what_only_one_tested_is_told() {
        let scene = scene(TEAPOT);
        let walks = [Accelerator::Grid, Accelerator::Bvh].map(|accelerator| {
            let (trace, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, [32, 32]);
            whole(&trace, &data)
        });
        let strips = walks.each_ref().map(Strip::new);
        let both = Both::of([&walks[0], &walks[1]], [&strips[0], &strips[1]]);
        for (walk, strip) in walks.iter().zip(&strips) {
            let end = if walk.structure == Structure::Grid { strip.t[1] } else { walk.hit.expect("a hit").t };
            assert!(both.t[0] <= strip.t[0] && end <= both.t[1], "{:?}", both.t);
            assert_eq!(both.work[usize::from(walk.structure == Structure::Tree)], Work::of(walk));
        }
        // The hit is at the same place of both strips.
        let hit = walks[0].hit.expect("a hit");
        let aligned = strips.clone().map(|strip| strip.over(both.t).place(hit.t, Spacing::ByT));
        assert_eq!(walks[1].hit.map(|hit| hit.triangle), Some(hit.triangle));
        assert!(aligned[0] == aligned[1] && aligned[0] > 0.0 && aligned[0] < 1.0, "{aligned:?}");
        let is_in = |walk: &WalkGeometry, id: u32| walk.tested.iter().any(|test| test.triangle == id);
        assert!(both.only[0].iter().all(|&id| is_in(&walks[0], id) && !is_in(&walks[1], id)));
        assert!(both.only[1].iter().all(|&id| !is_in(&walks[0], id) && is_in(&walks[1], id)));
        assert!(both.shared.iter().all(|&id| is_in(&walks[0], id) && is_in(&walks[1], id)) && !both.shared.is_empty());
        for (i, work) in both.work.iter().enumerate() {
            assert_eq!(both.only[i].len() + both.shared.len(), work.triangles);
            assert!(work.tests >= work.triangles);
        }
    }
}
