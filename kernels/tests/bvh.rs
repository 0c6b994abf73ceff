//! BVHs contain what they claim, find everything that a ray can hit, and build for any scene.

mod rays;
mod scenes;

use std::time::Instant;

use raystep_kernels::structures::bvh::{
    self, BvhData, BvhError, BvhFault, BvhOptions, BvhQuality, EMPTY, MAX_LEAF, NO_NODE, Padding, TreeShape,
    WIDE_MAX_DEPTH, WideBvhData, build, build_wide,
};
use scenes::{needles, nested, scenes, soup};

fn options(quality: BvhQuality) -> BvhOptions {
    BvhOptions { quality, ..BvhOptions::default() }
}

#[test]
fn trees_of_all_scenes_and_qualities_keep_what_they_promise() {
    for (name, vertices) in scenes() {
        for quality in BvhQuality::ALL {
            let fixed = [0.0, 1e-30, 1e-6, 0.01, 3.0].map(Padding::Fixed);
            for padding in fixed.into_iter().chain([Padding::PerRay]) {
                let tree = build(&vertices, padding, &options(quality)).expect("a tree");
                assert_eq!(tree.check(&vertices), Ok(()), "{name}, {quality:?}, {padding:?}: binary");
                assert!(tree.nodes.iter().all(|n| n.count() <= MAX_LEAF), "{name}, {quality:?}");
                assert!(tree.references as usize <= vertices.len() / 9 * 13 / 10, "{name}: {}", tree.references);
                let wide = build_wide(&vertices, padding, &options(quality)).expect("a tree");
                assert_eq!(wide.check(&vertices), Ok(()), "{name}, {quality:?}, {padding:?}: wide");
                assert_eq!(wide.references, tree.references, "{name}, {quality:?}");
                assert!(wide.nodes.iter().flat_map(|n| n.exponents).all(|e| (1..=254).contains(&e)), "{name}");
                assert!(tree.cost.is_finite() && wide.cost.is_finite(), "{name}");
            }
        }
    }
}

/// Exponents are the smallest for which the planes suffice: half the spacing would not.
#[test]
fn wide_boxes_are_as_fine_as_they_can_be() {
    let vertices = soup(3000, 0.05, [1.0; 3], 0.0);
    let wide = build_wide(&vertices, 1e-6, &BvhOptions::default()).expect("a tree");
    for (i, node) in wide.nodes.iter().enumerate() {
        for axis in 0..3 {
            let highest = node.children().map(|c| node.planes[axis][1][c.slot]).max().expect("a child");
            let lowest = node.children().map(|c| node.planes[axis][0][c.slot]).min().expect("a child");
            assert!(highest > 127, "node {i}, axis {axis}: planes up to {highest} only");
            assert_eq!(lowest, 0, "node {i}, axis {axis}");
        }
    }
}

/// Slots give the order in which a ray enters children.
#[test]
fn children_lie_where_their_slots_say() {
    let wide = build_wide(&soup(3000, 0.02, [1.0; 3], 0.0), 0.0, &BvhOptions::default()).expect("a tree");
    let (mut right, mut wrong) = (0, 0);
    for node in &wide.nodes {
        let children: Vec<_> = node.children().collect();
        for octant in 0..8 {
            let along = |slot: usize| {
                let child = children.iter().find(|c| c.slot == slot)?;
                let sign = |a: usize| if octant >> (2 - a) & 1 == 1 { -1.0 } else { 1.0 };
                Some((0..3).map(|a| sign(a) * (child.min[a] + child.max[a])).sum::<f64>())
            };
            // First and last in the documented order.
            if let (Some(first), Some(last)) = (along(octant), along(7 ^ octant)) {
                if first <= last { right += 1 } else { wrong += 1 }
            }
        }
    }
    assert!(right > 50 * wrong.max(1), "{right} in order, {wrong} out of order");
}

#[test]
fn a_tree_without_triangles_has_one_node_that_no_ray_hits() {
    let tree = build(&[], 1.0, &BvhOptions::default()).expect("a tree");
    assert_eq!((tree.nodes.len(), tree.nodes[0].link, tree.items.len()), (1, EMPTY, 1));
    assert_eq!(tree.parents, [NO_NODE]);
    assert!(!tree.nodes[0].is_inner() && tree.nodes[0].count() == 0);
    let wide = build_wide(&[], 1.0, &BvhOptions::default()).expect("a tree");
    assert_eq!((wide.nodes.len(), wide.triangles.len()), (1, 1));
    assert_eq!(wide.nodes[0].children().count(), 0);
}

/// Ids and corners survive bit for bit.
#[test]
fn wide_entries_have_the_bits_of_ids_and_corners() {
    let vertices = [-0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let wide = build_wide(&vertices, 0.5, &BvhOptions::default()).expect("a tree");
    let v = vertices.map(f32::to_bits);
    assert_eq!(wide.triangles, [[v[0], v[1], v[2], 0, v[3], v[4], v[5], 0, v[6], v[7], v[8], 0]]);
    assert_eq!(std::mem::size_of_val(&wide.nodes[0]), 80);
    let words: [u32; 20] = bytemuck::cast(wide.nodes[0]);
    assert_eq!(words[4..6], [1, 0], "no inner child, the first entry");
    assert_eq!(words[3], u32::from_le_bytes([127 - 5, 127 - 5, 127 - 5, 0]), "255 times 2^-5 reaches 7, half does not");
}

#[test]
fn a_million_identical_triangles_build_in_seconds() {
    let vertices = soup(1, 0.5, [1.0; 3], 0.0).repeat(1_000_000);
    let start = Instant::now();
    let tree = build(&vertices, 1e-6, &BvhOptions::default()).expect("a tree");
    let wide = build_wide(&vertices, 1e-6, &BvhOptions::default()).expect("a tree");
    assert!(tree.depth <= 32 && wide.depth <= WIDE_MAX_DEPTH, "{} and {} levels", tree.depth, wide.depth);
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

/// Clustering would join only one pair per round here.
#[test]
fn a_hundred_thousand_nested_boxes_build_in_seconds() {
    for outermost_first in [true, false] {
        let vertices = nested(100_000, outermost_first);
        let start = Instant::now();
        let tree = build(&vertices, 0.0, &BvhOptions::default()).expect("a tree");
        let wide = build_wide(&vertices, 0.0, &BvhOptions::default()).expect("a tree");
        assert!(tree.depth <= bvh::MAX_DEPTH && wide.depth <= WIDE_MAX_DEPTH, "{} and {}", tree.depth, wide.depth);
        assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    }
}

#[test]
fn a_hundred_thousand_triangles_that_fill_the_scene_build_in_seconds() {
    let vertices = soup(100_000, 1.0, [1.0; 3], 0.0);
    let start = Instant::now();
    let wide = build_wide(&vertices, 0.0, &options(BvhQuality::High)).expect("a tree");
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    assert_eq!(wide.shape, TreeShape::Optimised);
}

#[test]
fn better_qualities_cost_less_to_trace() {
    for vertices in [needles(20_000), soup(20_000, 0.03, [1.0; 3], 0.0)] {
        let [fast, balanced, high] =
            BvhQuality::ALL.map(|quality| build_wide(&vertices, 0.0, &options(quality)).expect("a tree").cost);
        assert!(high < balanced && balanced < fast, "{high} {balanced} {fast}");
    }
}

#[test]
fn what_cannot_be_built_is_refused() {
    let mut vertices = soup(10, 0.1, [1.0; 3], 0.0);
    for bad in [f32::NAN, f32::INFINITY, -1e13] {
        vertices[9 * 7 + 3] = bad;
        assert_eq!(build(&vertices, 0.0, &BvhOptions::default()), Err(BvhError::Corner { triangle: 7 }));
        assert_eq!(build_wide(&vertices, 0.0, &BvhOptions::default()), Err(BvhError::Corner { triangle: 7 }));
    }
    vertices[9 * 7 + 3] = 0.0;
    for growth in [-1.0, f32::INFINITY] {
        assert_eq!(build(&vertices, growth, &BvhOptions::default()), Err(BvhError::Growth(growth)));
    }
    assert!(matches!(build(&vertices, f32::NAN, &BvhOptions::default()), Err(BvhError::Growth(_))));
    let small = BvhOptions { most_words: 30, ..options(BvhQuality::Fast) };
    let words = 12 * 10;
    assert_eq!(
        build_wide(&vertices, 0.0, &small),
        Err(BvhError::TooLarge { buffer: "packed_triangles", words, limit: 30 })
    );
    assert!(matches!(build(&vertices, 0.0, &small), Err(BvhError::TooLarge { buffer: "bvh_nodes", limit: 30, .. })));
}

/// Breaks each guarantee once; `check` must report which.
#[test]
fn check_finds_what_is_broken() {
    let vertices = soup(200, 0.1, [1.0; 3], 0.0);
    let good = build(&vertices, 1e-3, &options(BvhQuality::Fast)).expect("a tree");
    let leaf = good.nodes.iter().position(|n| !n.is_inner()).expect("a leaf");
    let broken = |f: &dyn Fn(&mut BvhData)| {
        let mut tree = good.clone();
        f(&mut tree);
        tree.check(&vertices)
    };
    let triangle = good.items[good.nodes[leaf].first as usize];
    let lower = |tree: &mut BvhData| tree.nodes[leaf].max[1] = tree.nodes[leaf].max[1].next_down();
    assert!(matches!(broken(&lower), Err(BvhFault::Uncovered(_) | BvhFault::Order(_))), "{:?}", broken(&lower));
    assert_eq!(broken(&|t| t.padding = Padding::Fixed(2e-3)), Err(BvhFault::Uncovered(0)));
    assert_eq!(broken(&|t| t.parents[5] ^= 1), Err(BvhFault::Parent(5)));
    // Another axis; there are three, and the fourth value marks an empty BVH.
    let turned = |t: &mut BvhData| t.nodes[0].link = ((t.nodes[0].axis() as u32 + 1) % 3) << 30;
    assert_eq!(broken(&turned), Err(BvhFault::Order(0)));
    assert_eq!(broken(&|t| t.nodes.swap(1, 2)), Err(BvhFault::Order(0)));
    assert_eq!(broken(&|t| t.nodes[0].first = 1 << 20), Err(BvhFault::Link(0)));
    assert_eq!(broken(&|t| t.depth += 1), Err(BvhFault::Depth(good.depth)));
    assert!(broken(&|t| t.items[t.nodes[leaf].first as usize] = triangle ^ 1).is_err());

    let good = build_wide(&vertices, 1e-3, &options(BvhQuality::Fast)).expect("a tree");
    let broken = |f: &dyn Fn(&mut WideBvhData)| {
        let mut tree = good.clone();
        f(&mut tree);
        tree.check(&vertices)
    };
    for axis in 0..3 {
        let slot = good.nodes[0].children().find(|c| good.nodes[0].planes[axis][1][c.slot] > 0).expect("one").slot;
        let fault = broken(&|t| t.nodes[0].planes[axis][1][slot] -= 1);
        assert!(matches!(fault, Err(BvhFault::Uncovered(_))), "{fault:?}");
    }
    assert_eq!(broken(&|t| t.triangles[3][9] ^= 1), Err(BvhFault::Corners(3)));
    assert_eq!(broken(&|t| t.depth -= 1), Err(BvhFault::Depth(good.depth)));
    assert!(matches!(broken(&|t| t.nodes[0].child_base += 1), Err(BvhFault::Link(_) | BvhFault::Uncovered(_))));
    assert!(broken(&|t| t.nodes[0].contents ^= 1 << 24).is_err());

    // A triangle was cut and has lost one of its pieces.
    let vertices = needles(1000);
    let good = build_wide(&vertices, 0.0, &options(BvhQuality::High)).expect("a tree");
    assert_eq!(good.check(&vertices), Ok(()));
    let mut counts = vec![0; 1000];
    good.triangles.iter().for_each(|entry| counts[entry[3] as usize] += 1);
    let most = (0..1000).max_by_key(|&i| counts[i]).expect("some") as u32;
    let mut tree = good.clone();
    let at = tree.triangles.iter().position(|entry| entry[3] == most).expect("listed");
    let other = *tree.triangles.iter().find(|entry| entry[3] != most).expect("another");
    tree.triangles[at] = other;
    assert_eq!(tree.check(&vertices), Err(BvhFault::Uncovered(most)), "{} pieces", counts[most as usize]);
}
