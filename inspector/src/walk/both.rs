//! Two walks of the same ray, through different structures: what each of them visited and tested.

use std::collections::BTreeSet;

use raystep_lab::text::counted;

use super::{Strip, Structure, WalkGeometry};

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
        let range = strips.map(|strip| strip.t);
        Self {
            t: [range[0][0].min(range[1][0]), range[0][1].max(range[1][1])],
            work: walks.map(Work::of),
            only: [a.difference(&b).copied().collect(), b.difference(&a).copied().collect()],
            shared: a.intersection(&b).copied().collect(),
        }
    }
}

fn tested(walk: &WalkGeometry) -> BTreeSet<u32> {
    walk.tested.iter().map(|test| test.triangle).collect()
}
