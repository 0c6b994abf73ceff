//! What of a walk is under the cursor in the 3D view.

use glam::{DVec2, DVec3};

use crate::orbit::Orbit;
use crate::ui::panels::picked::cell;
use crate::ui::state::Picked;
use crate::walk::WalkGeometry;

/// Most boxes or triangles of a walk that are considered, the latest.
const MOST: usize = 20_000;

/// A part of the walk under the cursor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) what: Picked,
    /// The row of the ray's history that visited or tested it first.
    pub(super) row: usize,
    /// Its diagonal or longest side, and its distance from the eye.
    size: f64,
    depth: f64,
}

/// What is under a pixel: small things before large ones, which are around or behind them; of the same size, the nearer
/// ones first. What lies nearer to the eye than `cut`, along the view, is not seen.
pub(super) fn under(walk: &WalkGeometry, camera: &Orbit, pixel: DVec2, size_px: DVec2, cut: Option<f64>) -> Vec<Found> {
    let [origin, direction] = camera.ray(pixel, size_px);
    let forward = camera.pose.axes()[2];
    let is_seen = |t: f64| cut.is_none_or(|cut| (origin + direction * t).dot(forward) >= cut);
    let mut found: Vec<Found> = Vec::new();
    let latest = |count: usize| count.saturating_sub(MOST);
    for visit in &walk.cells[latest(walk.cells.len())..] {
        if let (Some([t, _]), Some(what)) = (visit.bounds.interval(origin, direction), cell(visit.cell)) {
            found.push(Found { what, row: visit.row, size: 2.0 * visit.bounds.radius(), depth: t });
        }
    }
    for visit in walk.nodes[latest(walk.nodes.len())..].iter().filter(|visit| visit.is_met) {
        if let Some([t, _]) = visit.bounds.interval(origin, direction) {
            let (what, size) = (Picked::Node(visit.node), 2.0 * visit.bounds.radius());
            found.push(Found { what, row: visit.row, size, depth: t });
        }
    }
    for test in &walk.tested[latest(walk.tested.len())..] {
        if let Some(t) = meets(test.corners, origin, direction).filter(|&t| is_seen(t)) {
            let [a, b, c] = test.corners;
            let size = (b - a).length().max((c - b).length()).max((a - c).length());
            found.push(Found { what: Picked::Triangle(test.triangle), row: test.row, size, depth: t });
        }
    }
    // Sides of equal cells differ by roundings.
    let class = |found: &Found| (found.size.max(f64::MIN_POSITIVE).log2() * 4.0).round();
    found.sort_by(|a, b| class(a).total_cmp(&class(b)).then(a.depth.total_cmp(&b.depth)).then(a.row.cmp(&b.row)));
    let mut seen = std::collections::HashSet::new();
    found.retain(|found| seen.insert(found.what));
    found
}

/// The one that a click picks: the first, or the one after what is picked already; `None` after the last.
pub(super) fn chosen(found: &[Found], picked: Option<Picked>) -> Option<Found> {
    let now = picked.and_then(|picked| found.iter().position(|found| found.what == picked));
    found.get(now.map_or(0, |now| now + 1)).copied()
}

/// Where a ray meets a triangle in front of its origin (Möller and Trumbore, 1997).
fn meets([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (ab, ac, from) = (b - a, c - a, origin - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let q = from.cross(ab);
    let [u, v, t] = [from.dot(p), direction.dot(q), ac.dot(q)].map(|x| x / determinant);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t.is_finite()).then_some(t)
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::super::super::walked::tests::history;
    use super::*;

    const SIZE: DVec2 = DVec2::new(900.0, 600.0);

    fn seen(walk: &WalkGeometry) -> Orbit {
        let mut camera = Orbit::framing(&walk.bounds, 1.5);
        camera.frame_from_side(&walk.extent(), walk.direction, 1.5, 0.1);
        camera
    }

    #[test]
    fn every_cell_and_node_is_under_the_pixel_of_its_middle() {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
            let (history, data) = history(accelerator);
            let walk = WalkGeometry::new(&history, &data, usize::MAX);
            let camera = seen(&walk);
            let cells =
                walk.cells.iter().filter_map(|visit| Some((cell(visit.cell)?, visit.bounds.center(), visit.row)));
            let nodes = walk.nodes.iter().filter(|node| node.is_met);
            let nodes = nodes.map(|visit| (Picked::Node(visit.node), visit.bounds.center(), visit.row));
            let all: Vec<_> = cells.chain(nodes).collect();
            assert!(all.len() > 2, "{accelerator:?}");
            for (what, middle, row) in all {
                let (pixel, _) = camera.pixel(middle, SIZE).expect("in the picture");
                let found = under(&walk, &camera, pixel, SIZE, None);
                assert!(found.iter().any(|found| (found.what, found.row) == (what, row)), "{what:?}: {found:?}");
                let mut sorted = found.clone();
                sorted.sort_by(|a, b| (a.size / 1.3).total_cmp(&b.size));
                let small = found.iter().map(|f| f.size).fold(f64::INFINITY, f64::min);
                assert!(found[0].size <= small * 1.2, "the smallest comes first: {found:?}");
            }
        }
    }

    #[test]
    fn a_tested_triangle_is_under_its_middle_unless_it_is_cut_away() {
        let (history, data) = history(Accelerator::Grid);
        let walk = WalkGeometry::new(&history, &data, usize::MAX);
        let camera = seen(&walk);
        let test =
            walk.tested.iter().find(|test| Some(test.triangle) == walk.hit.map(|hit| hit.triangle)).expect("a test");
        let middle = (test.corners[0] + test.corners[1] + test.corners[2]) / 3.0;
        let (pixel, _) = camera.pixel(middle, SIZE).expect("in the picture");
        let has = |cut: Option<f64>| {
            under(&walk, &camera, pixel, SIZE, cut).iter().any(|found| found.what == Picked::Triangle(test.triangle))
        };
        let depth = middle.dot(camera.pose.axes()[2]);
        assert!(has(None) && has(Some(depth - 1e-6)) && !has(Some(depth + 1e-6)));
        // Far from everything.
        assert!(under(&walk, &camera, DVec2::splat(-1e5), SIZE, None).is_empty());
    }

    #[test]
    fn clicks_go_through_what_lies_behind_and_end() {
        let found = |node| Found { what: Picked::Node(node), row: 0, size: 1.0, depth: 1.0 };
        let all = [found(5), found(7)];
        assert_eq!(chosen(&all, None), Some(all[0]));
        assert_eq!(chosen(&all, Some(Picked::Node(5))), Some(all[1]));
        assert_eq!(chosen(&all, Some(Picked::Node(7))), None);
        assert_eq!(chosen(&all, Some(Picked::Triangle(5))), Some(all[0]));
        assert_eq!(chosen(&[], Some(Picked::Node(5))), None);
    }
}
