//! The tree that always works: halved at the median centre along the longest axis, with a depth of log2 of its leaves.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;

/// Nodes of a tree over the boxes: the root first, children in pairs after their parents; a leaf refers to one box.
pub(super) fn halve(boxes: &[Aabb]) -> Vec<Bvh2Node> {
    if boxes.is_empty() {
        return Vec::new();
    }
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default(); 2 * boxes.len() - 1];
    let mut used = 1;
    let mut waiting = vec![(0, 0..boxes.len())];
    // Twice the centre has the same order as the centre.
    let center = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
    while let Some((node, range)) = waiting.pop() {
        if range.len() == 1 {
            let i = order[range.start];
            nodes[node] = Bvh2Node::new(boxes[i as usize], 1, i);
            continue;
        }
        let part = &mut order[range.clone()];
        let (low, high) = part
            .iter()
            .map(|&i| center(i))
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)));
        let extent = high - low;
        let axis = (0..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |&a, &b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(&b)));
        nodes[node] = Bvh2Node::new(Aabb::default(), 0, used as u32);
        let middle = range.start + half;
        waiting.push((used, range.start..middle));
        waiting.push((used + 1, middle..range.end));
        used += 2;
    }
    for i in (0..nodes.len()).rev() {
        if !nodes[i].is_leaf() {
            let first = nodes[i].first_index as usize;
            let both = nodes[first].aabb().union(nodes[first + 1].aabb());
            nodes[i].set_aabb(both);
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::super::tree::depth;
    use super::*;

    #[test]
    fn halves_are_as_shallow_as_can_be_and_name_every_box_once() {
        for count in [1usize, 2, 3, 64, 1000, 4097] {
            // Nested boxes, so that no axis separates them.
            let boxes: Vec<Aabb> =
                (1..=count).map(|i| Aabb::new(Vec3A::splat(-(i as f32)), Vec3A::splat(i as f32))).collect();
            let nodes = halve(&boxes);
            assert_eq!(depth(&nodes), count.next_power_of_two().ilog2() + 1, "{count} boxes");
            let mut named: Vec<u32> = nodes.iter().filter(|n| n.is_leaf()).map(|n| n.first_index).collect();
            named.sort_unstable();
            assert!(named.iter().copied().eq(0..count as u32), "{count} boxes");
            assert_eq!(nodes[0].aabb(), &boxes[count - 1], "{count} boxes");
        }
        assert!(halve(&[]).is_empty());
    }
}
