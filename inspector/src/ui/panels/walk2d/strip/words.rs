//! What is under the cursor, in words and numbers.

use raystep_lab::text::counted;

use super::super::Scene;
use crate::walk::{AXES, Entry, Outcome, StripCell, StripNode, TestedTriangle};

/// Describes a cell.
pub(super) fn cell_words(cell: &StripCell, scene: &Scene<'_>) -> String {
    let [from, to] = cell.t.map(|t| scene.t(t));
    let [tx, ty, tz] = cell.tmax.map(|t| t.map_or_else(|| "never".into(), |t| scene.t(t)));
    let axis = AXES[cell.exit_axis];
    let on = match cell.next {
        Some(Entry::Leap { cells: [x, y, z] }) => format!(", then skips {x},{y},{z} cells"),
        Some(Entry::Wrap) => ", then wraps around at the grid's face into another row".into(),
        _ => String::new(),
    };
    format!(
        "{}: {}, t {from} to {to}\ntmax x {tx}, y {ty}, z {tz}: leaves along {axis}{on}\n{} in its \
         list, {} tested",
        cell.letters,
        cell.name,
        counted(cell.listed, "triangle"),
        cell.tests.len()
    )
}

/// Describes the way from a cell to one that is not its neighbour.
pub(super) fn leap_words(cell: &StripCell, scene: &Scene<'_>) -> String {
    let from = scene.t(cell.t[1]);
    match cell.next {
        Some(Entry::Wrap) => format!(
            "wrap at t {from}: at the grid's face, the paper's rules take the index of a cell in the next row for that of \
             the next cell"
        ),
        Some(Entry::Leap { cells: [x, y, z] }) => {
            let why = if scene.walk.has_many_steps { "several steps in one pass" } else { "over empty cells" };
            let to = scene.walk.cells.get(cell.visit + 1).map(|next| scene.t(next.t_in)).unwrap_or_default();
            format!("leap by {x},{y},{z} cells, {why}: t {from} to {to}")
        }
        _ => String::new(),
    }
}

/// Describes a node.
pub(super) fn node_words(node: &StripNode, t: [f64; 2], scene: &Scene<'_>) -> String {
    let kind = if node.is_leaf { "leaf" } else { "node" };
    let met = if node.is_met { "entered" } else { "not entered before the nearest hit" };
    let [near, far] = t.map(|t| scene.t(t));
    format!("{kind} {}, level {}: t {near} to {far}, {met}", node.node, node.depth)
}

/// Describes a test.
pub(super) fn test_words(test: &TestedTriangle, scene: &Scene<'_>) -> String {
    let t = test.t.map_or_else(|| "never meets its plane".into(), |t| format!("t {}", scene.t(t)));
    match test.outcome {
        Outcome::Nearest => format!("triangle {}: hit, {t}", test.triangle),
        Outcome::NotNearest => format!("triangle {}: hit, not accepted ({}), {t}", test.triangle, test.why),
        Outcome::Missed => format!("triangle {}: missed ({}), meets its plane at {t}", test.triangle, test.why),
    }
}

/// A test as a label.
pub(super) fn note_words(test: &TestedTriangle, is_long: bool, scene: &Scene<'_>) -> String {
    let t = test.t.filter(|_| test.outcome.is_hit()).map_or_else(String::new, |t| format!(" t {}", scene.t(t)));
    match (test.outcome, is_long) {
        (Outcome::Nearest, _) => format!("{}: hit{t}", test.triangle),
        (Outcome::NotNearest, true) => format!("{}:{t}, {}", test.triangle, test.why),
        (Outcome::Missed, true) => format!("{}: missed, {}", test.triangle, test.why),
        (Outcome::NotNearest, false) => format!("{}:{t}", test.triangle),
        (Outcome::Missed, false) => test.triangle.to_string(),
    }
}
