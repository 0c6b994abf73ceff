use raystep_kernels::structures::bvh::BvhNode;
use raystep_kernels::{Accelerator, Limits, Options, Plan, RaySource, ScheduleKind};
use raystep_scenes::{Scene, generate};

use raystep_kernels::scene_data::Contents;

use super::super::TreeStats;
use super::*;

fn bvh_node(min: [f32; 3], max: [f32; 3], first: u32, link: u32) -> BvhNode {
    BvhNode { min, max, first, link }
}

/// A box of 4 x 1 x 1: on the left a leaf of 1.5, on the right an inner node of 3 with leaves of 1 at its ends.
fn small() -> Nodes {
    let across = |from: f32, to: f32, first, link| bvh_node([from, 0.0, 0.0], [to, 1.0, 1.0], first, link);
    let bvh_nodes = vec![
        across(0.0, 4.0, 1, 0),
        across(0.0, 1.5, 0, 3),
        across(1.0, 4.0, 3, 0),
        across(1.0, 2.0, 3, 1),
        across(3.0, 4.0, 4, 2),
    ];
    Nodes::of(&SceneData::from(Contents { bvh_nodes, ..Contents::default() })).expect("a tree")
}

#[test]
fn areas_costs_and_what_lies_below_are_those_of_the_formula() {
    let tree = small();
    let node = |i: u32| *tree.get(i).expect("a node");
    assert_eq!((node(0).below, node(0).leaves, node(2).below, node(2).leaves), (6, 3, 3, 2));
    assert_eq!((node(4).level, node(4).parent, tree.path(4)), (2, Some(2), vec![0, 2, 4]));
    // Half areas: 9, 4, 7, 3, 3.
    assert_eq!((node(0).half_area(), node(3).half_area()), (9.0, 3.0));
    assert_eq!(tree.probability(2), Some(7.0 / 9.0));
    assert_eq!(tree.own_cost(4), Some(3.0 / 9.0 * 3.0));
    let whole = (9.0 + 4.0 * 4.0 + 7.0 + 3.0 * 2.0 + 3.0 * 3.0) / 9.0;
    // Summed in f32.
    assert!((f64::from(node(0).cost) - whole).abs() < 1e-6 * whole, "{} {whole}", node(0).cost);
    assert_eq!((node(1).children(), node(0).children(), node(1).is_leaf()), (0..0, 1..3, true));
}

#[test]
fn empty_and_overlapping_parts_are_shares_of_the_volume() {
    let tree = small();
    assert_eq!(tree.filling(0), Some(Filling { empty: 0.0, overlapping: 0.5 / 4.0 }));
    let gap = tree.filling(2).expect("children");
    assert!((gap.empty - 1.0 / 3.0).abs() < 1e-12 && gap.overlapping == 0.0, "{gap:?}");
    assert_eq!(tree.filling(1), None);
    // What the root's children have in common is 0.5 x 1 x 1: a half area of 2.
    assert_eq!((tree.overlap(0), tree.overlap(2)), (Some(2.0 / 9.0), Some(0.0)));
    assert_eq!(tree.ranked(RankBy::Overlap, 9), [0]);
    assert_eq!(tree.ranked(RankBy::Empty, 9), [2]);
    assert_eq!(tree.ranked(RankBy::Listed, 2), [1, 4]);
    assert_eq!(tree.ranked(RankBy::Level, 1), [3]);
}

#[test]
fn three_boxes_that_overlap_are_not_counted_twice() {
    let unit = |x: f32| [[x, 0.0, 0.0], [x + 2.0, 1.0, 1.0]];
    let found = filling([[0.0; 3], [5.0, 1.0, 1.0]], &[unit(0.0), unit(1.0), unit(1.5)]);
    assert_eq!(found, Some(Filling { empty: 1.5 / 5.0, overlapping: 2.0 / 5.0 }));
    assert_eq!(filling([[0.0; 3], [5.0, 0.0, 1.0]], &[]), None, "no volume");
}

#[test]
fn links_to_nothing_and_backwards_end_the_tree() {
    let point = |first, link| bvh_node([0.0; 3], [1.0; 3], first, link);
    for first in [0, 1, 7, u32::MAX] {
        let tree = Nodes::of(&Contents { bvh_nodes: vec![point(first, 0), point(0, 1)], ..Contents::default() }.into());
        let tree = tree.expect("a tree");
        assert!(tree.get(0).expect("a root").is_leaf() && tree.path(0) == [0] && tree.path(99).len() <= 2);
    }
    assert_eq!(Nodes::of(&SceneData::default()), None);
}

/// The sums of both kinds of trees agree with the statistics of the same scene.
#[test]
fn the_whole_tree_agrees_with_its_statistics() {
    let scenes = [generate::terrain(2000, 1).expect("a scene"), Scene::default(), generate::cornell_box()];
    for (scene, schedule) in scenes.iter().flat_map(|s| [(s, ScheduleKind::Second), (s, ScheduleKind::Fused)]) {
        let materials = generate::cornell_box().materials;
        let scene = Scene { materials, triangle_materials: vec![0; scene.triangles.len()], ..scene.clone() };
        let options = Options {
            accelerator: Accelerator::Bvh,
            schedule,
            shade: false,
            ..Options::new(RaySource::Given(Vec::new()))
        };
        let (_, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
        let (tree, stats) = (Nodes::of(&data).expect("a tree"), TreeStats::of(&data).expect("a tree"));
        let root = tree.get(0).expect("a root");
        assert_eq!(tree.is_wide(), stats.width == 8);
        assert_eq!(u64::from(root.below), stats.references);
        let inner = (0..tree.len() as u32).filter(|&i| tree.get(i).is_some_and(|node| !node.is_leaf())).count();
        // An empty wide root has no children.
        assert_eq!(inner as u64, if scene.triangles.is_empty() { 0 } else { stats.inner }, "{schedule}");
        match stats.sah_cost {
            // Wide boxes are rounded to f32, and costs summed in it.
            Some(cost) => assert!((f64::from(root.cost) / cost - 1.0).abs() < 1e-4, "{} {cost}", root.cost),
            None => assert_eq!(root.cost, 0.0),
        }
    }
}
