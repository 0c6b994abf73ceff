//! The walk unfolded: visits arranged along t, regardless of their direction in space.

use super::{Entry, Outcome, Structure, WalkGeometry};

/// The width of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spacing {
    /// Proportional to the length along the ray.
    #[default]
    ByT,
    /// Equal, so that cells that the ray barely touches are visible.
    Equal,
}

/// A test, with its position on the strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripTest {
    /// Index into [`WalkGeometry::tested`].
    pub test: usize,
    /// The triangle.
    pub triangle: u32,
    /// The outcome.
    pub outcome: Outcome,
    /// Where the ray meets the triangle's plane.
    pub t: Option<f64>,
}

/// A cell of the strip.
#[derive(Clone, Debug, PartialEq)]
pub struct StripCell {
    /// Index into [`WalkGeometry::cells`].
    pub visit: usize,
    /// Its letter, see [`letters`].
    pub letters: String,
    /// Cell coordinates.
    pub cell: [i32; 3],
    /// Its name, see [`CellVisit::name`](super::CellVisit::name).
    pub name: String,
    /// t at which the ray enters and leaves.
    pub t: [f64; 2],
    /// The axis across which it leaves.
    pub exit_axis: usize,
    /// tmax per axis; `None` for an axis that is never crossed.
    pub tmax: [Option<f64>; 3],
    /// Triangles in its list.
    pub listed: u32,
    /// The tests made in it.
    pub tests: Vec<StripTest>,
    /// How the ray went from here to the next cell; `None` if it has not.
    pub next: Option<Entry>,
    /// Whether the ray is here.
    pub is_current: bool,
}

/// A node of the strip: a bar from where the ray enters its box to where it leaves, below the bar of its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct StripNode {
    /// Index into [`WalkGeometry::nodes`].
    pub visit: usize,
    /// The node.
    pub node: u32,
    /// Levels below the root.
    pub depth: u32,
    /// The row of its bar, from 0: every level of the BVH has enough rows to avoid overlap.
    pub line: usize,
    /// The t interval in which the ray is in the box; `None` if it misses it: it has no bar.
    pub t: Option<[f64; 2]>,
    /// Whether the device entered the node.
    pub is_met: bool,
    /// Whether it is a leaf.
    pub is_leaf: bool,
    /// The tests made in it.
    pub tests: Vec<StripTest>,
    /// Whether the ray is here.
    pub is_current: bool,
}

/// The walk along t.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// The visible range of t.
    pub t: [f64; 2],
    /// Progress of the ray.
    pub at: f64,
    /// Cells in the order of the walk; empty without a grid.
    pub cells: Vec<StripCell>,
    /// Nodes in the order of the walk; empty without a BVH.
    pub nodes: Vec<StripNode>,
    /// Tests outside cells and nodes.
    pub tests: Vec<StripTest>,
    /// t of the nearest hit so far.
    pub hit: Option<f64>,
    /// Where cells of equal width begin, in widths of a cell: between two that are not neighbours there is a gap.
    starts: Vec<f64>,
}

/// Width of the gap for a leap between cells of equal width, in widths of a cell.
const GAP: f64 = 0.7;

impl Strip {
    /// Arranges a walk.
    #[must_use]
    pub fn new(walk: &WalkGeometry) -> Self {
        let mut of_visit = vec![Vec::new(); walk.cells.len().max(walk.nodes.len())];
        let mut loose = Vec::new();
        for (i, tested) in walk.tested.iter().enumerate() {
            let test = StripTest { test: i, triangle: tested.triangle, outcome: tested.outcome, t: tested.t };
            match tested.visit.and_then(|visit| of_visit.get_mut(visit)) {
                Some(tests) => tests.push(test),
                None => loose.push(test),
            }
        }
        let mut of_visit = of_visit.into_iter();
        let mut tests = || of_visit.next().unwrap_or_default();
        let cells: Vec<StripCell> = (walk.cells.iter().enumerate())
            .map(|(visit, cell)| StripCell {
                visit,
                letters: letters(visit),
                cell: cell.cell,
                name: cell.name(),
                t: [cell.t_in, cell.t_out.max(cell.t_in)],
                exit_axis: cell.exit_axis,
                tmax: cell.tmax,
                listed: cell.listed,
                tests: if walk.structure == Structure::Grid { tests() } else { Vec::new() },
                next: walk.cells.get(visit + 1).map(|next| next.entry),
                is_current: cell.is_current,
            })
            .collect();
        let mut nodes: Vec<StripNode> = (walk.nodes.iter().enumerate())
            .map(|(visit, node)| StripNode {
                visit,
                node: node.node,
                depth: node.depth,
                line: 0,
                t: node.inside,
                is_met: node.is_met,
                is_leaf: node.is_leaf,
                tests: if walk.structure == Structure::Tree { tests() } else { Vec::new() },
                is_current: walk.current_node == Some(node.node),
            })
            .collect();
        put_on_lines(&mut nodes);
        let first = cells.first().map(|cell| cell.t[0]).or(walk.inside.map(|[enter, _]| enter)).unwrap_or(0.0);
        let last = match walk.structure {
            Structure::Grid => cells.last().map_or(first, |cell| cell.t[1]).max(walk.hit.map_or(first, |hit| hit.t)),
            _ => walk.inside.map_or_else(|| walk.last_t(), |[_, leave]| leave),
        };
        let gap = |cell: &StripCell| if cell.is_left_by_a_leap() { 1.0 + GAP } else { 1.0 };
        let starts = std::iter::once(0.0).chain(cells.iter().scan(0.0, |end, cell| {
            *end += gap(cell);
            Some(*end)
        }));
        let starts = starts.collect();
        let hit = walk.hit.map(|hit| hit.t);
        Self { t: [first, last.max(first)], at: walk.t, cells, nodes, tests: loose, hit, starts }
    }

    /// The same over another range of t, to which positions by t refer.
    #[must_use]
    pub fn over(self, t: [f64; 2]) -> Self {
        Self { t, ..self }
    }

    /// The position of each cell, from 0 at the strip's left end to 1 at its right.
    #[must_use]
    pub fn columns(&self, spacing: Spacing) -> Vec<[f64; 2]> {
        (0..self.cells.len()).map(|i| self.column(i, spacing)).collect()
    }

    fn column(&self, i: usize, spacing: Spacing) -> [f64; 2] {
        match (spacing, self.cells.get(i)) {
            (Spacing::ByT, Some(cell)) => cell.t.map(|t| self.share(t)),
            _ => {
                // The last entry is the end of the last cell.
                let whole = self.starts.last().copied().unwrap_or(1.0).max(1.0);
                let start = self.starts.get(i).copied().unwrap_or(whole);
                [start / whole, (start + 1.0) / whole]
            }
        }
    }

    /// The position of a t on the strip, from 0 to 1.
    #[must_use]
    pub fn place(&self, t: f64, spacing: Spacing) -> f64 {
        if spacing == Spacing::ByT || self.cells.is_empty() {
            return self.share(t);
        }
        let i = self.cells.partition_point(|cell| cell.t[1] < t).min(self.cells.len() - 1);
        let [left, right] = self.column(i, spacing);
        let [from, to] = self.cells[i].t;
        if let Some(before) = i.checked_sub(1).filter(|_| t < from) {
            // In a gap.
            let start = self.column(before, spacing)[1];
            return between(t, [self.cells[before].t[1], from], [start, left]);
        }
        between(t, [from, to], [left, right])
    }

    /// The height of a tmax bar: 0 at the strip's first t, 1 at one and a half times its range. Above 1, the bar is
    /// truncated, as for an axis along which the ray hardly moves.
    #[must_use]
    pub fn tmax_height(&self, tmax: f64) -> f64 {
        let range = (self.t[1] - self.t[0]) * 1.5;
        if range > 0.0 { ((tmax - self.t[0]) / range).max(0.0) } else { 0.0 }
    }

    /// Rows for the bars of nodes.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.nodes.iter().map(|node| node.line + 1).max().unwrap_or(0)
    }

    fn share(&self, t: f64) -> f64 {
        let range = self.t[1] - self.t[0];
        if range > 0.0 { ((t - self.t[0]) / range).clamp(0.0, 1.0) } else { 0.0 }
    }
}

impl StripCell {
    /// Whether the next cell is not a neighbour.
    #[must_use]
    pub fn is_left_by_a_leap(&self) -> bool {
        matches!(self.next, Some(Entry::Leap { .. } | Entry::Wrap))
    }
}

fn between(t: f64, [from, to]: [f64; 2], [left, right]: [f64; 2]) -> f64 {
    let share = if to > from { ((t - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    left + share * (right - left)
}

/// Level by level, each bar in the first row of its level where it does not overlap an earlier one.
fn put_on_lines(nodes: &mut [StripNode]) {
    let deepest = nodes.iter().map(|node| node.depth).max().unwrap_or(0);
    let mut levels = vec![Vec::new(); deepest as usize + 1];
    for (i, node) in nodes.iter().enumerate().filter(|(_, node)| node.t.is_some()) {
        levels[node.depth as usize].push(i);
    }
    let mut first_line = 0;
    for level in levels {
        let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
        for i in level {
            let Some([from, to]) = nodes[i].t else { continue };
            let is_free = |taken: &Vec<[f64; 2]>| taken.iter().all(|&[start, end]| to <= start || end <= from);
            let line = lines.iter().position(is_free).unwrap_or(lines.len());
            if line == lines.len() {
                lines.push(Vec::new());
            }
            lines[line].push([from, to]);
            nodes[i].line = first_line + line;
        }
        first_line += lines.len();
    }
}

/// The name of the nth cell of a walk, as in the paper's Figure 3, where cells are visited in alphabetical order: a to
/// z, then aa to zz, and so on.
#[must_use]
pub fn letters(n: usize) -> String {
    let mut name = Vec::new();
    let mut left = n + 1;
    while left > 0 {
        left -= 1;
        name.push(char::from(b'a' + (left % 26) as u8));
        left /= 26;
    }
    name.iter().rev().collect()
}
