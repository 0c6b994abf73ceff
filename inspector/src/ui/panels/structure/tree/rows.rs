//! The visible rows of a tree: the nodes whose ancestors are all expanded.

use std::collections::HashSet;

use raystep_lab::structure_stats::Nodes;

/// Most rows: more would be slow to build, and nobody scrolls through them.
const MOST_ROWS: usize = 200_000;

/// The order of the children of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Order {
    #[default]
    Stored,
    Area,
    Triangles,
    Cost,
}

impl Order {
    pub(super) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Stored, "as stored", "as they lie in memory: along the axis in which their centres differ most"),
        (Self::Area, "by area", "the larger box first"),
        (Self::Triangles, "by triangles", "the one with more triangles below first"),
        (Self::Cost, "by cost", "the more expensive subtree first"),
    ];
}

/// The rows.
#[derive(Debug, Default)]
pub(super) struct Rows {
    open: HashSet<u32>,
    order: Order,
    rows: Vec<u32>,
    is_built: bool,
}

impl Rows {
    /// Builds the rows anew after a change.
    pub(super) fn build(&mut self, nodes: &Nodes) {
        if std::mem::replace(&mut self.is_built, true) {
            return;
        }
        self.rows.clear();
        let mut waiting = vec![0];
        while let Some(index) = waiting.pop().filter(|_| self.rows.len() < MOST_ROWS) {
            let Some(node) = nodes.get(index) else { continue };
            self.rows.push(index);
            if self.open.contains(&index) {
                let mut children: Vec<u32> = node.children().collect();
                let of = |child: &u32| nodes.get(*child);
                match self.order {
                    Order::Stored => {}
                    Order::Area => children.sort_by(|a, b| {
                        let area = |child: &u32| of(child).map_or(0.0, |node| node.half_area());
                        area(b).total_cmp(&area(a))
                    }),
                    Order::Triangles => {
                        children.sort_by_key(|child| std::cmp::Reverse(of(child).map(|node| node.below)))
                    }
                    Order::Cost => children.sort_by(|a, b| {
                        let cost = |child: &u32| of(child).map_or(0.0, |node| node.cost);
                        cost(b).total_cmp(&cost(a))
                    }),
                }
                waiting.extend(children.into_iter().rev());
            }
        }
    }

    pub(super) fn rows(&self) -> &[u32] {
        &self.rows
    }

    pub(super) fn order(&self) -> Order {
        self.order
    }

    pub(super) fn set_order(&mut self, order: Order) {
        (self.order, self.is_built) = (order, false);
    }

    pub(super) fn is_open(&self, node: u32) -> bool {
        self.open.contains(&node)
    }

    pub(super) fn toggle(&mut self, node: u32) {
        if !self.open.remove(&node) {
            self.open.insert(node);
        }
        self.is_built = false;
    }

    /// Expands a node, and all above it.
    pub(super) fn expand(&mut self, nodes: &Nodes, node: u32) {
        self.open.extend(nodes.path(node));
        self.is_built = false;
    }

    /// Expands all nodes above one, so that it has a row.
    pub(super) fn reveal(&mut self, nodes: &Nodes, node: u32) {
        if let Some(parent) = nodes.get(node).and_then(|node| node.parent) {
            self.expand(nodes, parent);
        }
    }

    pub(super) fn collapse(&mut self) {
        self.open.clear();
        self.is_built = false;
    }
}

#[cfg(test)]
pub(super) mod tests {
    use raystep_kernels::scene_data::{Contents, SceneData};
    use raystep_kernels::structures::bvh::BvhNode;

    use super::*;

    /// The root 0 with leaf 1 and node 2; that one with leaf 3 (1 triangle) and leaf 4 (2 triangles, larger).
    pub(in super::super) fn small() -> SceneData {
        let across =
            |from: f32, to: f32, first, link| BvhNode { min: [from, 0.0, 0.0], max: [to, 1.0, 1.0], first, link };
        let bvh_nodes = vec![
            across(0.0, 4.0, 1, 0),
            across(0.0, 1.5, 0, 3),
            across(1.0, 4.0, 3, 0),
            across(1.0, 1.5, 3, 1),
            across(3.0, 4.0, 4, 2),
        ];
        Contents { bvh_nodes, ..Contents::default() }.into()
    }

    #[test]
    fn rows_are_those_of_expanded_nodes_in_the_chosen_order() {
        let nodes = Nodes::of(&small()).expect("a tree");
        let mut rows = Rows::default();
        let mut now = |act: &mut dyn FnMut(&mut Rows)| {
            act(&mut rows);
            rows.build(&nodes);
            rows.rows().to_vec()
        };
        assert_eq!(now(&mut |_| ()), [0]);
        assert_eq!(now(&mut |rows| rows.toggle(0)), [0, 1, 2]);
        assert_eq!(now(&mut |rows| rows.reveal(&nodes, 4)), [0, 1, 2, 3, 4]);
        assert_eq!(now(&mut |rows| rows.set_order(Order::Area)), [0, 2, 4, 3, 1]);
        assert_eq!(now(&mut |rows| rows.set_order(Order::Triangles)), [0, 1, 2, 4, 3]);
        assert_eq!(now(&mut |rows| rows.toggle(2)), [0, 1, 2]);
        assert_eq!(now(&mut |rows| rows.collapse()), [0]);
        assert_eq!(now(&mut |rows| rows.reveal(&nodes, 99)), [0], "no such node");
        assert_eq!(now(&mut |rows| rows.expand(&nodes, 2)).len(), 5);
    }

    /// Rows of a large tree are built only where it is expanded.
    #[test]
    fn a_million_nodes_are_one_row_until_they_are_expanded() {
        let leaves = 1u32 << 19;
        let link = |i: u32| if i < leaves - 1 { (2 * i + 1, 0) } else { (0, 1) };
        let node = |i: u32| {
            let (first, link) = link(i);
            BvhNode { min: [0.0; 3], max: [1.0; 3], first, link }
        };
        let bvh_nodes = (0..2 * leaves - 1).map(node).collect();
        let nodes = Nodes::of(&SceneData::from(Contents { bvh_nodes, ..Contents::default() })).expect("a tree");
        assert_eq!((nodes.len(), nodes.get(0).map(|root| root.leaves)), (1_048_575, Some(leaves)));
        let mut rows = Rows::default();
        rows.build(&nodes);
        assert_eq!(rows.rows().len(), 1);
        rows.reveal(&nodes, 2 * leaves - 2);
        rows.build(&nodes);
        // Two more for each of the 19 levels below the root.
        assert_eq!(rows.rows().len(), 1 + 2 * 19);
    }
}
