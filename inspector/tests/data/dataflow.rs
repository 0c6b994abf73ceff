//! The data flow graph: it agrees with the paper's Table 1, and nothing overlaps.

use raystep_inspector::dataflow::{Access, DataFlow, Edge, Node, NodeKind};
use raystep_kernels::options::mapping::{Fragment, Mapping};
use raystep_kernels::programs::closest_hit::{kernels, streams};
use raystep_kernels::{Accelerator, Keep, Kernel, Limits, Options, Plan, ScheduleKind, Stream};
use raystep_scenes::generate;

use crate::data::common::{options, scenes};

fn graph(options: &Options, scene: &raystep_scenes::Scene) -> DataFlow {
    DataFlow::new(&Plan::new(scene, options, &Limits::CPU).expect("a plan").0)
}

/// The paper's Table 1, with commented deviations.
#[test]
fn the_papers_schedule_is_drawn_as_table_1_says() {
    use Access::{Update, Write};
    use streams::{COLOR, HIT, RAY_DIRECTION, RAY_ORIGIN, STATE, TMAX};
    let scene = generate::cornell_box();
    let graph = graph(&options(&scene, Accelerator::Grid, ScheduleKind::Second, [8, 8]), &scene);
    let table: [(Kernel, &[(Stream, Access)]); 5] = [
        // Hit is set to "no triangle" when the ray is generated, and state is read so that a ray is generated once; the
        // paper discards fragments instead.
        (kernels::GENERATE, &[(RAY_ORIGIN, Write), (RAY_DIRECTION, Write), (STATE, Update), (HIT, Write)]),
        // The paper's setup copies the ray to a second pair of textures; in-place streams need no copy.
        (kernels::SETUP, &[(STATE, Update), (TMAX, Write)]),
        // In the paper every pass writes hit; here only passes that find a nearer triangle.
        (kernels::INTERSECT, &[(STATE, Update), (HIT, Update)]),
        (kernels::TRAVERSE_GRID, &[(STATE, Update), (TMAX, Update)]),
        // The state becomes DONE, so that the ray counts tell when the image is complete.
        (kernels::SHADE, &[(STATE, Update), (COLOR, Write)]),
    ];
    let kernels: Vec<_> =
        graph.nodes.iter().map_while(|n| if let NodeKind::Kernel(k) = n.kind { Some(k) } else { None }).collect();
    assert_eq!(kernels, table.map(|(kernel, _)| kernel), "in the order of the schedule");
    for (kernel, expected) in table {
        let written = graph.of(kernel).filter_map(|(node, access)| match node.kind {
            NodeKind::Stream(stream) if access != Access::Read => Some((stream, access)),
            _ => None,
        });
        let mut written: Vec<_> = written.collect();
        let mut expected = expected.to_vec();
        written.sort();
        expected.sort();
        assert_eq!(written, expected, "{kernel:?}");
    }
    let reads = |kernel, label: &str| graph.of(kernel).any(|(n, access)| n.label == label && access == Access::Read);
    assert!(reads(kernels::INTERSECT, "ray_origin") && reads(kernels::INTERSECT, "vertices"));
    assert!(reads(kernels::TRAVERSE_GRID, "grid") && !reads(kernels::TRAVERSE_GRID, "grid_items"));
    assert!(!graph.nodes.iter().any(|n| n.label == "sent" || n.label == "fill"), "the executor's buffers are shown");
}

/// The same with fragment programs, as in 2004: what a kernel reads and writes, it reads from a copy.
#[test]
fn fragment_programs_read_copies_of_what_they_draw() {
    use streams::{HIT, RAY_DIRECTION, STATE, TMAX};
    let scene = generate::cornell_box();
    let mapping = Mapping::Fragment(Fragment::default());
    let options = Options { mapping, ..options(&scene, Accelerator::Grid, ScheduleKind::Second, [8, 8]) };
    let limits = Limits { color_bytes: 32, ..Limits::CPU };
    let graph = DataFlow::new(&Plan::new(&scene, &options, &limits).expect("a plan").0);
    let redrawn = |kernel| {
        let of = graph.of(kernel).filter(|(_, access)| *access == Access::Redraw).map(|(node, _)| node.kind);
        of.collect::<Vec<_>>()
    };
    let streams = |streams: &[Stream]| streams.iter().map(|&s| NodeKind::Stream(s)).collect::<Vec<_>>();
    assert_eq!(redrawn(kernels::GENERATE), streams(&[STATE]));
    assert_eq!(redrawn(kernels::INTERSECT), streams(&[STATE, HIT]));
    assert_eq!(redrawn(kernels::TRAVERSE_GRID), streams(&[STATE, TMAX]));
    let detail = |stream: Stream| graph.nodes.iter().find(|n| n.kind == NodeKind::Stream(stream)).map(|n| &*n.detail);
    assert_eq!((detail(TMAX), detail(RAY_DIRECTION)), (Some("x y z, 2 textures"), Some("x y z")));
    assert_is_readable(&graph, "fragment programs");
}

fn is_inside([x, y]: [f32; 2], node: &Node) -> bool {
    x > node.min[0] && x < node.max[0] && y > node.min[1] && y < node.max[1]
}

fn overlap(a: &Node, b: &Node) -> bool {
    (0..2).all(|axis| a.min[axis] < b.max[axis] && b.min[axis] < a.max[axis])
}

fn assert_is_readable(graph: &DataFlow, what: &str) {
    for (i, node) in graph.nodes.iter().enumerate() {
        assert!(
            (0..2).all(|a| node.min[a] > 0.0 && node.max[a] < 1.0 && node.min[a] < node.max[a]),
            "{what}: {node:?}"
        );
        assert!(!graph.nodes[..i].iter().any(|other| overlap(node, other)), "{what}: {} overlaps another", node.label);
        let is_drawn = graph.edges.iter().any(|e| e.kernel == i || e.data == i);
        assert!(is_drawn, "{what}: nothing leads to {}", node.label);
    }
    for edge in &graph.edges {
        let Edge { at_kernel: [x0, y0], at_data: [x1, y1], .. } = *edge;
        for step in 1..1000 {
            let s = step as f32 / 1000.0;
            let at = [x0 + (x1 - x0) * s, y0 + (y1 - y0) * s];
            let through = graph.nodes.iter().find(|n| is_inside(at, n));
            assert!(through.is_none(), "{what}: an edge runs through {through:?}");
        }
        let ends_at = |node: &Node, [x, y]: [f32; 2]| {
            x > node.min[0] && x < node.max[0] && (y == node.min[1] || y == node.max[1])
        };
        assert!(ends_at(&graph.nodes[edge.kernel], [x0, y0]) && ends_at(&graph.nodes[edge.data], [x1, y1]), "{what}");
        let twice = graph.edges.iter().filter(|e| e.at_kernel == [x0, y0] || e.at_data == [x1, y1]).count();
        assert_eq!(twice, 1, "{what}: two edges end at one place");
    }
}

#[test]
fn the_graph_is_readable_for_any_scene_structure_and_schedule() {
    let is_thorough = std::env::var_os("RAYSTEP_THOROUGH").is_some_and(|value| !value.is_empty());
    for (place, (name, scene)) in scenes().into_iter().enumerate() {
        let ways = Accelerator::ALL.iter().flat_map(|a| ScheduleKind::ALL.iter().map(|s| (*a, *s)));
        for (row, (accelerator, schedule)) in ways.enumerate() {
            // Every way is drawn for the Cornell box and for a third of the others; in the full suite, for every scene.
            if !is_thorough && name != "cornell-box.gltf" && (row + place) % 3 > 0 {
                continue;
            }
            let what = format!("{name} {accelerator} {schedule}");
            let mut options = options(&scene, accelerator, schedule, [8, 8]);
            let all = graph(&options, &scene);
            assert_is_readable(&all, &what);
            if name == "cornell-box.gltf" {
                assert_eq!(graph(&options, &scene), all, "{what}: the layout is not reproducible");
            }
            (options.counters, options.keep) = (true, Keep::ALL);
            if schedule == ScheduleKind::Compact {
                options.steps_per_pass = 8;
            }
            assert_is_readable(&graph(&options, &scene), &format!("{what} keep-all"));
        }
    }
}

/// The number of crossings among edges to a row in this order.
fn crossings(row: &[usize], edges: &[Edge]) -> usize {
    let rank = |e: &Edge| row.iter().position(|&node| node == e.data);
    let pairs = edges.iter().flat_map(|a| edges.iter().map(move |b| (a, b)));
    pairs.filter(|(a, b)| a.kernel < b.kernel && rank(b).is_some_and(|b| rank(a).is_some_and(|a| a > b))).count()
}

/// The minimum over all orders (Heap's algorithm).
fn fewest(row: &mut Vec<usize>, permuted: usize, edges: &[Edge]) -> usize {
    if permuted <= 1 {
        return crossings(row, edges);
    }
    let mut least = fewest(row, permuted - 1, edges);
    for i in 0..permuted - 1 {
        row.swap(if permuted.is_multiple_of(2) { i } else { 0 }, permuted - 1);
        least = least.min(fewest(row, permuted - 1, edges));
    }
    least
}

#[test]
fn as_few_edges_cross_as_any_order_of_the_streams_allows() {
    let scene = generate::cornell_box();
    for (accelerator, schedule) in Accelerator::ALL.iter().flat_map(|a| ScheduleKind::ALL.iter().map(|s| (*a, *s))) {
        let graph = graph(&options(&scene, accelerator, schedule, [8, 8]), &scene);
        let row = |of: fn(&NodeKind) -> bool| -> Vec<usize> {
            (0..graph.nodes.len()).filter(|&i| of(&graph.nodes[i].kind)).collect()
        };
        let streams = row(|kind| matches!(kind, NodeKind::Stream(_)));
        let drawn = crossings(&streams, &graph.edges);
        assert_eq!(drawn, fewest(&mut streams.clone(), streams.len(), &graph.edges), "{accelerator} {schedule}");
        let buffers = crossings(&row(|kind| matches!(kind, NodeKind::Buffer(_))), &graph.edges);
        assert_eq!(graph.crossings(), drawn + buffers, "the count differs from the drawing");
    }
}
