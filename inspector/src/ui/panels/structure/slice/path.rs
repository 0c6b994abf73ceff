//! The selected ray in a layer: the cells that it is in, and its path.

use std::sync::Arc;

use egui::{Color32, Painter, Stroke};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::programs::closest_hit::states;
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::Slice;

use super::placement::Placement;
use crate::walk::{WalkGeometry, last_row_of_ray, row_after_passes};

/// A cell that the selected ray is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Visit {
    pub(super) cell: [i32; 3],
    /// Whether that was before the current place.
    pub(super) has_run: bool,
}

/// The cells of a ray's history in order; consecutive rows in the same cell count once.
pub(super) fn visited(history: &Trace, data: &SceneData, place: usize) -> Vec<Visit> {
    let mut visits: Vec<Visit> = Vec::new();
    for row in &history.rows {
        if let Some(cell) = row.cell_before.filter(|&cell| data.grid.is_in_grid(cell))
            && visits.last().is_none_or(|last| last.cell != cell)
        {
            visits.push(Visit { cell, has_run: row.is_within(place) });
        }
    }
    // A pass that brings the ray to a cell has not worked in it yet.
    let now = row_after_passes(history, place)
        .and_then(|i| history.rows.get(i))
        .filter(|row| states::of_any_ray(row.after.tag) > states::TRAV_SETUP);
    if let Some(cell) = now.map(|row| data.grid.cell_of_index(row.after.cell_index))
        && let Some(next) = visits.iter().position(|v| !v.has_run)
        && visits[next].cell == cell
    {
        visits[next].has_run = true;
    }
    visits
}

/// A ray's way through the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    origin: [f64; 3],
    direction: [f64; 3],
    /// From where it enters the grid to its hit, or to where it leaves.
    span: [f64; 2],
}

impl Segment {
    /// The t in which it is between two planes of an axis; `None` if it never is.
    fn between(&self, axis: usize, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
        let (o, d, [from, to]) = (self.origin[axis], self.direction[axis], self.span);
        if d == 0.0 {
            return (low..=high).contains(&o).then_some([from, to]);
        }
        let (a, b) = ((low - o) / d, (high - o) / d);
        let (enter, leave) = (a.min(b).max(from), a.max(b).min(to));
        (enter <= leave).then_some([enter, leave])
    }

    fn point(&self, t: f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.origin[axis] + t * self.direction[axis])
    }
}

/// The selected ray's visits and way, and what they were found for.
#[derive(Default)]
pub(super) struct Path {
    of: Option<(Arc<Trace>, usize)>,
    visits: Vec<Visit>,
    segment: Option<Segment>,
}

impl Path {
    /// Finds them for a ray's history at a place.
    pub(super) fn update(&mut self, history: Option<&Arc<Trace>>, data: &SceneData, place: usize) {
        let now = history.map(|history| (history, place));
        let is_same = match (&self.of, now) {
            (Some((known, at)), Some((history, place))) => Arc::ptr_eq(known, history) && *at == place,
            (None, None) => true,
            _ => false,
        };
        if is_same {
            return;
        }
        self.of = now.map(|(history, place)| (history.clone(), place));
        (self.visits, self.segment) = (Vec::new(), None);
        if let Some((history, place)) = now {
            self.visits = visited(history, data, place);
            let walk = WalkGeometry::new(history, data, last_row_of_ray(history, row_after_passes(history, place)));
            let span = walk.inside.map(|[enter, _]| [enter, walk.last_t().max(enter)]);
            let (origin, direction) = (walk.origin.to_array(), walk.direction.to_array());
            self.segment = span.map(|span| Segment { origin, direction, span });
        }
    }

    pub(super) fn visits(&self) -> &[Visit] {
        &self.visits
    }

    /// The ray's cell.
    pub(super) fn current(&self) -> Option<[i32; 3]> {
        self.visits.iter().rev().find(|visit| visit.has_run).map(|visit| visit.cell)
    }

    /// Draws the way of the ray: thin where it is in front of or behind the layer, thick inside.
    pub(super) fn draw(&self, painter: &Painter, slice: &Slice, place: &Placement, data: &SceneData) {
        let Some(segment) = self.segment else { return };
        let line = |[from, to]: [f64; 2], width: f32, color: Color32| {
            let ends = [from, to].map(|t| place.project(slice, data, segment.point(t)));
            if ends.iter().all(|end| end.is_finite()) {
                painter.line_segment(ends, Stroke::new(width + 2.0, Color32::from_black_alpha(150)));
                painter.line_segment(ends, Stroke::new(width, color));
            }
        };
        line(segment.span, 1.0, Color32::from_rgb(190, 190, 190));
        if let Some(inside) = self.inside(slice, data) {
            line(inside, 3.0, Color32::from_rgb(255, 220, 60));
            let [from, to] = inside.map(|t| place.project(slice, data, segment.point(t)));
            // A ray along the axis is a point.
            if (to - from).length() < 3.0 {
                painter.circle_filled(from, 4.0, Color32::from_rgb(255, 220, 60));
            }
        }
    }

    /// The t in which the ray is in the layer.
    pub(super) fn inside(&self, slice: &Slice, data: &SceneData) -> Option<[f64; 2]> {
        let (corner, width) = (f64::from(data.grid.corner[slice.axis]), f64::from(data.grid.width[slice.axis]));
        let planes = [slice.index, slice.index + 1].map(|index| corner + width * f64::from(index));
        self.segment?.between(slice.axis, planes)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::export::trace::{Rays, TraceRow, trace};
    use raystep_kernels::{Device, GridSize, Options, RaySource, Renderer, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    fn followed() -> (Trace, Arc<SceneData>) {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options {
            grid: GridSize::Cells([5, 4, 6]),
            schedule: ScheduleKind::Second,
            ..Options::new(RaySource::Camera { camera, width: 8, height: 8 })
        };
        pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let history =
                trace(&mut renderer, 3, 4, Rays::All, |_| ControlFlow::Continue(())).await.expect("a history");
            (history, renderer.shared_data())
        })
    }

    #[test]
    fn a_ray_visits_cell_after_cell_and_those_ahead_are_told_from_those_behind() {
        let (history, data) = followed();
        let passes = history.passes.expect("the whole run");
        let count = |place: usize| visited(&history, &data, place).iter().filter(|v| v.has_run).count();
        let visits = visited(&history, &data, passes);
        assert!(visits.len() > 2, "the ray goes through the room");
        for pair in visits.windows(2) {
            let steps: i32 = (0..3).map(|axis| (pair[0].cell[axis] - pair[1].cell[axis]).abs()).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
        assert_eq!((count(0), count(passes)), (0, visits.len()));
        // Set-up moves the ray to its first cell, and the first step to the second.
        let step = history.rows.iter().find(|row| row.kernel == "traverse_grid").expect("a step");
        let at = |row: &TraceRow| count(row.place().expect("a pass"));
        assert_eq!((at(&history.rows[1]), at(step)), (1, 2));
        assert!((0..passes).all(|place| count(place) <= count(place + 1)));
    }

    /// The ray is in exactly the layers of the cells that it visited.
    #[test]
    fn the_path_is_in_the_layers_of_its_cells() {
        let (history, data) = followed();
        let (history, mut path) = (Arc::new(history), Path::default());
        path.update(Some(&history), &data, usize::MAX);
        for axis in 0..3 {
            for index in 0..data.grid.cells[axis] {
                let slice = Slice::of(&data, axis, index).expect("a slice");
                let is_visited = path.visits().iter().any(|visit| visit.cell[axis] == index);
                let length = path.inside(&slice, &data).map_or(0.0, |[from, to]| to - from);
                // Where the ray only touches a plane, rounding decides.
                assert!(length < 1e-6 || is_visited, "axis {axis}, layer {index}: {length}");
                let grown = [(0, -1e-6), (1, 1e-6)].map(|(next, by)| {
                    let at = f64::from(index + next);
                    f64::from(data.grid.corner[axis]) + at * f64::from(data.grid.width[axis]) + by
                });
                let comes_near = path.segment.expect("a segment").between(axis, grown).is_some();
                assert!(comes_near || !is_visited, "axis {axis}, layer {index}");
            }
        }
        path.update(None, &data, 0);
        assert!(path.visits().is_empty() && path.current().is_none());
    }
}
