//! The geometry against traces of known rays.

use std::ops::ControlFlow;

use raystep_kernels::export::trace::{Rays, trace};
use raystep_kernels::options::Integrator;
use raystep_kernels::{Accelerator, Device, Numerics, Options, RaySource, Renderer, Skip};
use raystep_scenes::{Camera, LoadOptions, NoFiles, Scene};

use super::*;

pub(crate) const CORNELL: &str = "cornell-box.gltf";
pub(crate) const TEAPOT: &str = "teapot.glb";

/// A scene of the repository's.
pub(crate) fn scene(file: &str) -> Scene {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(file);
    let bytes = std::fs::read(path).expect("a scene of the repository's");
    raystep_scenes::load("scene", &bytes, &NoFiles, &LoadOptions::default()).expect("a scene")
}

pub(crate) fn options(scene: &Scene) -> Options {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
    Options { steps_per_pass: 1, skip: Skip::Off, ..Options::new(RaySource::Camera { camera, width: 64, height: 64 }) }
}

/// Traces one pixel's ray by the twins.
pub(crate) fn traced(scene: &Scene, options: &Options, [x, y]: [u32; 2]) -> (Trace, SceneData) {
    pollster::block_on(async {
        let mut renderer = Renderer::new(scene, options, &Device::Cpu(None)).await.expect("a run");
        let trace = trace(&mut renderer, x, y, Rays::All, |_| ControlFlow::Continue(())).await.expect("a trace");
        (trace, renderer.data().clone())
    })
}

/// Rays of several kinds: a wall, a box, a corner, the light's surroundings.
const PIXELS: [[u32; 2]; 5] = [[20, 40], [44, 50], [3, 3], [32, 8], [60, 33]];

pub(super) fn whole(trace: &Trace, data: &SceneData) -> WalkGeometry {
    WalkGeometry::new(trace, data, usize::MAX)
}

#[test]
fn cells_follow_each_other_and_their_intervals_meet() {
    let scene = scene(CORNELL);
    for numerics in [Numerics::Robust, Numerics::Paper] {
        for pixel in PIXELS {
            let (trace, data) = traced(&scene, &Options { numerics, ..options(&scene) }, pixel);
            let walk = whole(&trace, &data);
            assert!(walk.cells.len() > 2 || numerics == Numerics::Paper, "{pixel:?}");
            for pair in walk.cells.windows(2) {
                let [from, to] = pair else { continue };
                let Entry::Face { axis, step } = to.entry else { panic!("{pixel:?}: {:?}", to.entry) };
                let mut next = from.cell;
                next[axis] += step;
                assert_eq!((next, axis), (to.cell, from.exit_axis));
                assert_eq!(from.t_out, to.t_in);
                assert!(to.t_in <= to.t_out);
            }
            for (i, crossing) in walk.crossings.iter().enumerate() {
                let from = &walk.cells[crossing.from];
                assert_eq!((crossing.from, Some(crossing.t)), (i, from.tmax[crossing.axis]));
                let plane = if walk.direction[crossing.axis] > 0.0 { from.bounds.max } else { from.bounds.min };
                // The bound by which cells are grown: 40 roundings of the largest distance, in a walk that does not
                // accumulate.
                let most = if numerics == Numerics::Robust { f64::from(data.growth) } else { 1e-5 };
                let off = (crossing.point - plane)[crossing.axis].abs();
                assert!(off <= most, "{pixel:?}: {off}");
                for axis in (0..3).filter(|&axis| axis != crossing.axis) {
                    assert!(crossing.point[axis] >= from.bounds.min[axis] - most);
                    assert!(crossing.point[axis] <= from.bounds.max[axis] + most);
                }
            }
        }
    }
}

/// Boxes of an irregular grid may overlap, but the ray is in each of them from where it left the one before.
#[test]
fn boxes_of_an_irregular_grid_follow_each_other() {
    let scene = scene(TEAPOT);
    for steps_per_pass in [1, 8] {
        for pixel in PIXELS {
            let options = Options { accelerator: Accelerator::Irregular, steps_per_pass, ..options(&scene) };
            let (trace, data) = traced(&scene, &options, pixel);
            let walk = whole(&trace, &data);
            let most = f64::from(data.growth);
            for (i, cell) in walk.cells.iter().enumerate() {
                let [low, high] = data.irregular_cells[cell.index as usize].corners();
                assert_eq!((cell.cell, cell.name()), (low, format!("cell {}", cell.index)));
                assert_eq!(cell.bounds, Aabb::of_cells(&data.grid, low, [0, 1, 2].map(|a| high[a] - low[a])));
                assert_eq!(listed(&data, cell.index).count() as u32, cell.listed);
                for t in [cell.t_in, cell.t_out] {
                    let point = walk.point(t);
                    let outside = (cell.bounds.min - point).max(point - cell.bounds.max).max_element();
                    assert!(outside <= most, "{pixel:?}: {outside} outside of cell {i}");
                }
                let before = i.checked_sub(1).map(|before| &walk.cells[before]);
                if let Some(before) = before.filter(|_| steps_per_pass == 1) {
                    let step = if walk.direction[before.exit_axis] < 0.0 { -1 } else { 1 };
                    assert_eq!(cell.entry, Entry::Face { axis: before.exit_axis, step });
                    assert_eq!(before.t_out, cell.t_in);
                }
            }
            assert!(trace.rows.last().expect("rows").after.triangle.is_none() || !walk.cells.is_empty());
        }
    }
}

#[test]
fn the_walk_grows_row_by_row_to_the_hit_of_the_trace() {
    let scene = scene(CORNELL);
    for accelerator in [Accelerator::Grid, Accelerator::Irregular] {
        let (trace, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, [20, 40]);
        the_walk_grows(&trace, &data);
    }
}

/// At a row of a shadow ray, the walk is that of this ray; at the end, that of the ray from the eye.
#[test]
fn a_shadow_ray_has_a_walk_of_its_own() {
    let scene = scene(CORNELL);
    for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        let options = Options { integrator: Integrator::Shadows, accelerator, ..options(&scene) };
        let (trace, data) = traced(&scene, &options, [15, 43]);
        let first = trace.rows.iter().position(|row| row.kernel == "shadow_setup").expect("a shadow ray");
        let last = last_row_of_ray(&trace, Some(first));
        assert_eq!((trace.rows[last].kernel, trace.rows[last].after.state), ("shadow_intersect", "OCCLUDED"));
        let walk = WalkGeometry::new(&trace, &data, last);
        let rows = |walk: &WalkGeometry| -> Vec<usize> {
            let visits = walk.cells.iter().map(|cell| cell.row).chain(walk.nodes.iter().map(|node| node.row));
            visits.chain(walk.tested.iter().map(|test| test.row)).collect()
        };
        assert_eq!((walk.origin, walk.is_over), (to_f64(trace.rows[first].after.origin), true));
        assert!(rows(&walk).len() > 10 && rows(&walk).iter().all(|&row| row >= first), "{accelerator}: {walk:?}");
        assert_eq!(walk.hit.map(|hit| hit.triangle), trace.rows[last].after.triangle);
        let of_eye = whole(&trace, &data);
        assert_eq!(of_eye.origin, to_f64(trace.rows[0].after.origin));
        assert!(rows(&of_eye).len() > 10 && rows(&of_eye).iter().all(|&row| row < first), "{accelerator}: {of_eye:?}");
        assert!(
            walk.nodes.iter().all(|node| !node.is_leaf) || walk.nodes.iter().any(|node| node.is_leaf && node.is_met)
        );
    }
}

fn the_walk_grows(trace: &Trace, data: &SceneData) {
    let mut before = WalkGeometry::new(trace, data, 0);
    assert!(before.cells.is_empty() && before.tested.is_empty() && !before.is_over);
    for row in 1..trace.rows.len() {
        let walk = WalkGeometry::new(trace, data, row);
        assert!(walk.t >= before.t, "{row}: {} {}", walk.t, before.t);
        assert!(walk.cells.len() - before.cells.len() <= 1 && walk.tested.len() - before.tested.len() <= 1);
        if let Some(cell) = walk.current_cell() {
            assert_eq!(cell.index, trace.rows[row].after.cell_index);
            assert_eq!(listed(data, cell.index).count() as u32, cell.listed);
            assert_eq!(walk.cells.iter().filter(|cell| cell.is_current).count(), 1);
            assert_eq!(walk.next_crossings().len(), cell.tmax.iter().flatten().count());
        }
        before = walk;
    }
    let end = &trace.rows.last().expect("rows").after;
    let hit = before.hit.expect("the box is closed behind");
    assert_eq!((Some(hit.triangle), Some(hit.t as f32)), (end.triangle, end.t));
    assert!(before.is_over && before.t == hit.t);
    let [u, v] = hit.barycentric;
    let on_triangle = hit.corners[0] * (1.0 - u - v) + hit.corners[1] * u + hit.corners[2] * v;
    assert!((on_triangle - hit.point).length() < 1e-6);
    let nearest = before.tested.iter().rev().find(|test| test.outcome == Outcome::Nearest).expect("a hit");
    assert_eq!((nearest.triangle, nearest.t), (hit.triangle, Some(hit.t)));
    assert!(before.tested.iter().any(|test| test.outcome == Outcome::Missed));
    for test in &before.tested {
        assert!(listed(data, before.cells[test.visit.expect("a cell")].index).any(|id| id == test.triangle));
    }
}

#[test]
fn a_node_is_visited_after_the_node_above_it_was_met() {
    for (file, pixel) in [(CORNELL, [20, 40]), (TEAPOT, [32, 32])] {
        let scene = scene(file);
        let (trace, data) = traced(&scene, &Options { accelerator: Accelerator::Bvh, ..options(&scene) }, pixel);
        let walk = whole(&trace, &data);
        assert_eq!((walk.nodes[0].node, walk.nodes[0].parent, walk.nodes[0].depth), (0, None, 0));
        assert!(walk.nodes.len() > 8);
        let mut seen = std::collections::BTreeSet::new();
        for (i, node) in walk.nodes.iter().enumerate() {
            assert!(seen.insert(node.node), "node {} is visited once", node.node);
            if let Some(parent) = node.parent {
                let above = walk.nodes[..i].iter().find(|above| above.node == parent).expect("visited before");
                assert!(above.is_met && !above.is_leaf && above.depth + 1 == node.depth);
            }
            assert!(!node.is_met || node.inside.is_some(), "node {}: met, but not in f64", node.node);
            assert_eq!(node.is_leaf, listed(&data, node.node).count() > 0);
        }
        let in_leaves = walk.tested.iter().all(|test| {
            let leaf = &walk.nodes[test.visit.expect("a leaf")];
            leaf.is_leaf && leaf.is_met && listed(&data, leaf.node).any(|id| id == test.triangle)
        });
        assert!(in_leaves && !walk.tested.is_empty());
        // Every row of the tree's walk either tests a box or comes back up.
        let steps = trace.rows.iter().filter(|row| row.kernel == "traverse_bvh").count();
        assert!(walk.nodes.len() <= steps && steps <= 2 * walk.nodes.len() + walk.tested.len());
        let strip = Strip::new(&walk);
        let bars: Vec<_> = strip.nodes.iter().filter_map(|node| Some((node, node.t?))).collect();
        for (i, (a, [start, end])) in bars.iter().enumerate() {
            for (b, [from, to]) in &bars[..i] {
                assert!(a.line != b.line || (a.depth == b.depth && (end <= from || to <= start)), "{a:?} on {b:?}");
                assert!(a.depth <= b.depth || a.line > b.line);
            }
        }
        assert!(strip.lines() > 4);
        assert_eq!(whole(&trace, &data).hit.map(|hit| hit.triangle), trace.rows.last().expect("rows").after.triangle);
    }
}

#[test]
fn without_grid_and_tree_only_triangles_are_tested() {
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &Options { accelerator: Accelerator::None, ..options(&scene) }, [20, 40]);
    let walk = whole(&trace, &data);
    assert_eq!((walk.cells.len(), walk.nodes.len(), walk.tested.len()), (0, 0, scene.triangles.len()));
    assert!(walk.hit.is_some() && walk.bounds.radius() > 0.5);
}

#[test]
fn leaps_and_passes_of_many_steps_are_said_to_be_leaps() {
    let scene = scene(TEAPOT);
    for (skip, steps_per_pass) in [(Skip::Off, 1), (Skip::On, 1), (Skip::Off, 8), (Skip::On, 8)] {
        let (trace, data) = traced(&scene, &Options { skip, steps_per_pass, ..options(&scene) }, [32, 32]);
        let walk = whole(&trace, &data);
        let which = format!("{skip:?}, {steps_per_pass} steps");
        let mut leaps = 0;
        for pair in walk.cells.windows(2) {
            let [from, to] = pair else { continue };
            let way = [0, 1, 2].map(|axis| to.cell[axis] - from.cell[axis]);
            let far: i32 = way.iter().map(|n| n.abs()).sum();
            let axis = way.iter().position(|&n| n != 0).expect("another cell");
            let wanted = if far == 1 { Entry::Face { axis, step: way[axis] } } else { Entry::Leap { cells: way } };
            assert_eq!(to.entry, wanted, "{which}: {:?} to {:?}", from.cell, to.cell);
            leaps += usize::from(far > 1);
            // A pass of one step goes farther only over cells that list nothing: those in which the ray is between.
            if steps_per_pass == 1 && far > 1 {
                let passed = cells_between(&walk, &data, from, to);
                assert!(passed.iter().all(|&cell| listed(&data, cell).count() == 0), "{which}: {passed:?}");
                assert!(!passed.is_empty(), "{which}: a leap over nothing");
            }
        }
        assert_eq!(leaps > 0, skip == Skip::On || steps_per_pass > 1, "{which}: {leaps} leaps");
        assert_eq!(walk.cells[0].entry, Entry::Start);
        for cell in &walk.cells {
            let [enter, leave] = cell.bounds.interval(walk.origin, walk.direction).unwrap_or([cell.t_in; 2]);
            let off = (cell.t_in - enter).abs().max((cell.t_out - leave).abs());
            assert!(off < 1e-5, "{which}, {:?}: {off}", cell.cell);
        }
    }
}

/// The numbers of the cells that the ray passes between two others, at points a twentieth of a cell apart, and not
/// within a thousandth of a cell of any plane: there it may be in either.
fn cells_between(walk: &WalkGeometry, data: &SceneData, from: &CellVisit, to: &CellVisit) -> Vec<u32> {
    let step = walk.cell_size.min_element() / walk.direction.length() / 20.0;
    let count = ((to.t_in - from.t_out) / step).max(0.0) as usize;
    let mut cells = Vec::new();
    for t in (1..count).map(|i| from.t_out + step * i as f64) {
        let place = (walk.point(t) - walk.bounds.min) / walk.cell_size;
        let is_inside = (place - place.round()).abs().min_element() > 1e-3;
        let cell = place.floor().as_ivec3().to_array();
        if is_inside && cell != from.cell && cell != to.cell {
            let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] as u32);
            cells.push(x + data.grid.cells[0] as u32 * (y + data.grid.cells[1] as u32 * z));
        }
    }
    cells.dedup();
    cells
}

#[test]
fn a_ray_that_misses_and_an_empty_trace_have_a_walk_too() {
    let scene = scene(TEAPOT);
    let (mut trace, data) = traced(&scene, &options(&scene), [0, 0]);
    let walk = whole(&trace, &data);
    assert!(walk.is_over && walk.hit.is_none() && walk.last_t() > 0.0);
    trace.rows.clear();
    let nothing = whole(&trace, &data);
    assert!(nothing.row.is_none() && nothing.cells.is_empty());
    assert!(Strip::new(&nothing).cells.is_empty() && Projected::new(&nothing).squares.is_empty());
}

#[test]
fn a_trace_of_another_scene_shows_nothing_that_is_not_there() {
    let (teapot, cornell) = (scene(TEAPOT), scene(CORNELL));
    let (foreign, _) = traced(&teapot, &options(&teapot), [32, 32]);
    assert!(foreign.rows.iter().filter_map(|row| row.tested).any(|id| id as usize >= cornell.triangles.len()));
    let nothing = whole(&foreign, &SceneData::default());
    assert_eq!((nothing.structure, nothing.row), (Structure::Nothing, Some(foreign.rows.len() - 1)));
    assert!(nothing.cells.is_empty() && nothing.nodes.is_empty() && nothing.tested.is_empty());
    assert_eq!(nothing.hit, None);
    let (_, data) = traced(&cornell, &options(&cornell), [20, 40]);
    let walk = whole(&foreign, &data);
    let in_scene = |triangle: u32| (triangle as usize) < cornell.triangles.len();
    assert!(walk.tested.iter().all(|test| in_scene(test.triangle)));
    assert!(walk.hit.is_none_or(|hit| in_scene(hit.triangle)));
    let lists = data.grid_cells.len() as u32 - 1;
    assert!(!walk.cells.is_empty() && walk.cells.iter().all(|cell| cell.index < lists || cell.listed == 0));
}

#[test]
fn events_are_the_moves_and_tests_in_order() {
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &options(&scene), [20, 40]);
    let events = events(&trace, &data);
    let walk = whole(&trace, &data);
    assert_eq!(events.iter().filter(|e| matches!(e.kind, EventKind::Cell(_))).count(), walk.cells.len());
    assert_eq!(events.iter().filter(|e| matches!(e.kind, EventKind::Test(_))).count(), walk.tested.len());
    let mut row = None;
    for &event in &events {
        assert_eq!(next_event(&events, row), Some(event));
        row = Some(event.row);
    }
    assert_eq!(next_event(&events, row), None);
    assert_eq!(previous_event(&events, events[1].row), Some(events[0]));
    assert_eq!(previous_event(&events, events[0].row), None);
    assert_eq!(row_after_passes(&trace, 0), None);
    assert_eq!(row_after_passes(&trace, 1), Some(0));
    assert_eq!(row_after_passes(&trace, usize::MAX), Some(trace.rows.len() - 1));
}

#[test]
fn the_strip_lays_cells_side_by_side_along_t() {
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &options(&scene), [20, 40]);
    let walk = whole(&trace, &data);
    let strip = Strip::new(&walk);
    for spacing in [Spacing::ByT, Spacing::Equal] {
        let columns = strip.columns(spacing);
        assert_eq!((columns[0][0], columns.len()), (0.0, walk.cells.len()));
        assert!(columns.windows(2).all(|pair| (pair[0][1] - pair[1][0]).abs() < 1e-12), "{spacing:?}");
        assert!((columns[columns.len() - 1][1] - 1.0).abs() < 1e-12);
        // The eye lies on two planes of the grid: its first cells are left at once.
        for (cell, [left, right]) in strip.cells.iter().zip(columns).filter(|(cell, _)| cell.t[1] > cell.t[0]) {
            let middle = strip.place((cell.t[0] + cell.t[1]) * 0.5, spacing);
            assert!((left..=right).contains(&middle), "{spacing:?}: {left} {middle} {right}");
        }
    }
    let tests: usize = strip.cells.iter().map(|cell| cell.tests.len()).sum();
    assert_eq!(tests, walk.tested.len());
    for cell in &strip.cells {
        let least = cell.tmax.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(cell.tmax[cell.exit_axis], Some(least));
    }
    assert_eq!([0, 25, 26, 701, 702].map(unfolded::letters), ["a", "z", "aa", "zz", "aaa"]);
}

#[test]
fn the_picture_shows_the_two_axes_along_which_the_ray_moves_most() {
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &options(&scene), [3, 34]);
    let walk = whole(&trace, &data);
    let picture = Projected::new(&walk);
    assert_eq!(picture.axes, [0, 2], "{}", walk.direction);
    let visits: Vec<usize> = picture.squares.iter().flat_map(|square| square.visits.clone()).collect();
    assert_eq!(visits, (0..walk.cells.len()).collect::<Vec<_>>());
    for (point, axis) in &picture.crossings {
        let on = picture.lines[usize::from(*axis == picture.axes[1])]
            .iter()
            .any(|line| (line - point[usize::from(*axis == picture.axes[1])]).abs() < 1e-5);
        assert!(on, "{point} of {axis} on a line of {:?}", picture.lines);
    }
    assert!(picture.hit.is_some_and(|hit| hit.cmpge(picture.min).all() && hit.cmple(picture.max).all()));
}
