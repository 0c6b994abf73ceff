//! Three rows, ordered to reduce edge crossings (Sugiyama, Tagawa and Toda 1981: by the mean position of the
//! neighbours; then by swapping neighbours while that helps).

use super::{DataFlow, Edge, Node, NodeKind};

/// Points per character of a label, at most.
pub(crate) const CHARACTER: f32 = 7.5;
/// Points inside a node beside its label.
const PADDING: f32 = 12.0;
/// Minimum distance between two nodes of a row, points.
const GAP: f32 = 18.0;
/// Height of a node, points: two lines.
pub(crate) const HEIGHT: f32 = 40.0;
/// Points between two rows.
const BETWEEN_ROWS: f32 = 130.0;
/// Margin, points.
const MARGIN: f32 = 16.0;

/// Orders and places nodes and the ends of edges.
pub(super) fn place(nodes: Vec<Node>, edges: Vec<Edge>) -> DataFlow {
    let row = |wanted: fn(&NodeKind) -> bool| (0..nodes.len()).filter(|&i| wanted(&nodes[i].kind)).collect::<Vec<_>>();
    let kernels = row(|kind| matches!(kind, NodeKind::Kernel(_)));
    let streams = ordered(row(|kind| matches!(kind, NodeKind::Stream(_))), &edges);
    let buffers = ordered(row(|kind| matches!(kind, NodeKind::Buffer(_))), &edges);

    let rows = [streams.as_slice(), &kernels, &buffers];
    let needed = |row: &[usize]| row.iter().map(|&i| width(&nodes[i]) + GAP).sum::<f32>();
    let inner = rows.iter().map(|row| needed(row)).fold(0.0, f32::max);
    let size = [inner + 2.0 * MARGIN, 3.0 * HEIGHT + 2.0 * BETWEEN_ROWS + 2.0 * MARGIN];

    // Each row is spread over the whole width.
    let mut rects = vec![[[0.0; 2]; 2]; nodes.len()];
    for (r, row) in rows.iter().enumerate() {
        let gap = (inner - needed(row)) / row.len().max(1) as f32 + GAP;
        let y = MARGIN + r as f32 * (HEIGHT + BETWEEN_ROWS);
        let mut x = MARGIN + gap / 2.0;
        for &i in *row {
            rects[i] = [[x, y], [x + width(&nodes[i]), y + HEIGHT]];
            x += width(&nodes[i]) + gap;
        }
    }
    in_order(nodes, edges, &rects, &[kernels, streams, buffers].concat(), size)
}

fn width(node: &Node) -> f32 {
    // A kernel's second line is a number of rays.
    let detail = if matches!(node.kind, NodeKind::Kernel(_)) { 13 } else { node.detail.chars().count() };
    node.label.chars().count().max(detail) as f32 * CHARACTER + 2.0 * PADDING
}

/// Orders one row to reduce crossings of edges to the kernels. `row` is the initial order, which breaks ties.
fn ordered(mut row: Vec<usize>, edges: &[Edge]) -> Vec<usize> {
    let kernels = |node: usize| edges.iter().filter(move |e| e.data == node).map(|e| e.kernel);
    let mean = |&node: &usize| kernels(node).sum::<usize>() as f32 / kernels(node).count().max(1) as f32;
    row.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
    // Crossings of two nodes' edges, `left` left of `right`.
    let crossings =
        |left: usize, right: usize| kernels(left).map(|a| kernels(right).filter(|&b| b < a).count()).sum::<usize>();
    let mut has_changed = true;
    while has_changed {
        has_changed = false;
        for i in 1..row.len() {
            if crossings(row[i], row[i - 1]) < crossings(row[i - 1], row[i]) {
                row.swap(i - 1, i);
                has_changed = true;
            }
        }
    }
    row
}

/// Nodes in a new order, with everything in fractions of `size`.
fn in_order(
    nodes: Vec<Node>,
    mut edges: Vec<Edge>,
    rects: &[[[f32; 2]; 2]],
    order: &[usize],
    size: [f32; 2],
) -> DataFlow {
    let unit = |[x, y]: [f32; 2]| [x / size[0], y / size[1]];
    for edge in &mut edges {
        let place = |node: usize| order.iter().position(|&i| i == node).unwrap_or(node);
        (edge.kernel, edge.data) = (place(edge.kernel), place(edge.data));
    }
    let moved = |&i: &usize| Node { min: unit(rects[i][0]), max: unit(rects[i][1]), ..nodes[i].clone() };
    let nodes: Vec<Node> = order.iter().map(moved).collect();
    edges.sort_by_key(|e| (e.kernel, e.data));

    // The ends along a side follow the order of their other ends.
    let port = |node: usize, other: usize| {
        let is_above = |i: usize| nodes[i].max[1] <= nodes[node].min[1];
        let mut side: Vec<usize> = edges
            .iter()
            .filter_map(|e| (e.kernel == node).then_some(e.data).or((e.data == node).then_some(e.kernel)))
            .filter(|&i| is_above(i) == is_above(other))
            .collect();
        side.sort_unstable();
        let at = side.iter().position(|&i| i == other).unwrap_or(0);
        let Node { min, max, .. } = &nodes[node];
        let x = min[0] + (max[0] - min[0]) * (at + 1) as f32 / (side.len() + 1) as f32;
        [x, if is_above(other) { min[1] } else { max[1] }]
    };
    let ends: Vec<_> = edges.iter().map(|e| (port(e.kernel, e.data), port(e.data, e.kernel))).collect();
    for (edge, (at_kernel, at_data)) in edges.iter_mut().zip(ends) {
        (edge.at_kernel, edge.at_data) = (at_kernel, at_data);
    }
    DataFlow { nodes, edges, size }
}
