//! The rows of a trace that move the ray or test a triangle: the events that F11 steps through.

use raystep_kernels::export::trace::Trace;
use raystep_kernels::program::Path;
use raystep_kernels::scene_data::SceneData;

use super::{coordinates, has_cells, is_same_ray, path_of};

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The ray enters a cell.
    Cell([i32; 3]),
    /// The ray reaches a node.
    Node(u32),
    /// A triangle is tested.
    Test(u32),
    /// The ray has left the grid or the BVH.
    Left,
}

/// An event of the ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// The row of the trace.
    pub row: usize,
    /// Its kind.
    pub kind: EventKind,
}

impl std::fmt::Display for Event {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.kind {
            EventKind::Cell([x, y, z]) => write!(f, "cell ({x}, {y}, {z})"),
            EventKind::Node(node) => write!(f, "node {node}"),
            EventKind::Test(triangle) => write!(f, "triangle {triangle}"),
            EventKind::Left => write!(f, "left"),
        }
    }
}

/// The rows in which the ray moves or tests a triangle, in order.
#[must_use]
pub fn events(trace: &Trace, data: &SceneData) -> Vec<Event> {
    let has_grid = has_cells(data);
    let kind = |row: &raystep_kernels::export::trace::TraceRow| {
        if let Some(triangle) = row.tested {
            return Some(EventKind::Test(triangle));
        }
        if path_of(row) == Path::Stays || !(has_grid || data.features.bvh) {
            return None;
        }
        let (after, index) = (&row.after, row.after.cell_index);
        Some(match (after.is_walking, has_grid) {
            (false, _) => EventKind::Left,
            (true, true) => EventKind::Cell(coordinates(data, index)),
            (true, false) => EventKind::Node(index),
        })
    };
    trace.rows.iter().enumerate().filter_map(|(row, r)| Some(Event { row, kind: kind(r)? })).collect()
}

/// The first event after a row; the first of all without a row.
#[must_use]
pub fn next_event(events: &[Event], row: Option<usize>) -> Option<Event> {
    events.get(events.partition_point(|event| row.is_some_and(|row| event.row <= row))).copied()
}

/// The last event before a row.
#[must_use]
pub fn previous_event(events: &[Event], row: usize) -> Option<Event> {
    events[..events.partition_point(|event| event.row < row)].last().copied()
}

/// The row that a ray is at after this many passes of its run; `None` before its first.
#[must_use]
pub fn row_after_passes(trace: &Trace, passes: usize) -> Option<usize> {
    trace.rows.partition_point(|row| row.is_within(passes)).checked_sub(1)
}

/// The last row of the ray that a pixel has at a row; of its last ray, without one.
#[must_use]
pub fn last_row_of_ray(trace: &Trace, row: Option<usize>) -> usize {
    let here = row.and_then(|row| trace.rows.get(row));
    here.and_then(|here| trace.rows.iter().rposition(|row| is_same_ray(row, here))).unwrap_or(usize::MAX)
}
