//! The rays in each state after every pass, as columns; without states, the elements that every pass works on.

use std::sync::Arc;

use egui::{Color32, Mesh, Painter, Rect, Shape, Stroke, pos2};
use raystep_kernels::Pass;
use raystep_kernels::tables::state::{StateInfo, StateRole};

use super::axis::Axis;
use super::height::Height;
use crate::ui::panels::chart::kernel_color;

/// The colour of a state.
pub(super) fn color(state: &StateInfo) -> Color32 {
    let [r, g, b] = state.colour;
    Color32::from_rgb(r, g, b)
}

/// The states whose rays are shown, from the bottom: the active ones below, so that the remaining work shrinks
/// downwards; those that are resolved on top, unless only the walk is shown.
pub(super) fn states(pass: &Pass, is_walk_only: bool) -> impl Iterator<Item = &'static StateInfo> + use<> {
    pass.kernel.program().states.iter().filter(move |state| match state.role {
        StateRole::Active => true,
        StateRole::Resolved => !is_walk_only,
        StateRole::Unborn | StateRole::Finished => false,
    })
}

/// The parts of a pass's column, from the bottom.
fn parts(pass: &Pass, is_walk_only: bool) -> Vec<(u64, Color32)> {
    if pass.kernel.program().states.0.is_empty() {
        return vec![(u64::from(pass.rays_in), kernel_color(pass.kernel))];
    }
    let count = |state: &StateInfo| pass.counts.get(state.tag as usize).map_or(0, |&rays| u64::from(rays));
    states(pass, is_walk_only).map(|state| (count(state), color(state))).collect()
}

/// The vertical axis for these passes: to all rays, or to those of the walk at its beginning.
pub(super) fn height(passes: &[Pass], axis: &Axis, is_walk_only: bool, is_log: bool) -> Height {
    let whole = |pass: &Pass| -> u64 {
        if is_walk_only || pass.kernel.program().states.0.is_empty() {
            parts(pass, is_walk_only).iter().map(|(count, _)| count).sum()
        } else {
            pass.counts.iter().map(|&rays| u64::from(rays)).sum()
        }
    };
    let shown = (0..axis.len()).filter_map(|at| passes.get(axis.pass(at)?));
    Height { most: shown.map(whole).max().unwrap_or(0), is_log }
}

/// The columns, kept while nothing changes.
#[derive(Default)]
pub(super) struct Columns {
    of: Option<(Rect, Height, u64)>,
    mesh: Arc<Mesh>,
}

impl Columns {
    /// Paints them. `version` changes with the axis.
    pub(super) fn paint(
        &mut self,
        painter: &Painter,
        field: Rect,
        (passes, axis, height): (&[Pass], &Axis, Height),
        is_walk_only: bool,
        version: u64,
    ) {
        if self.of != Some((field, height, version)) {
            self.of = Some((field, height, version));
            self.mesh = Arc::new(mesh(field, passes, axis, height, is_walk_only));
        }
        if !self.mesh.is_empty() {
            painter.add(Shape::mesh(self.mesh.clone()));
        }
    }
}

fn mesh(field: Rect, passes: &[Pass], axis: &Axis, height: Height, is_walk_only: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let columns = field.width().ceil().max(1.0) as usize;
    let x = |part: f64| field.left() + (part * f64::from(field.width())) as f32;
    let mut add = |left: f32, right: f32, at: usize| {
        let Some(pass) = axis.pass(at).and_then(|index| passes.get(index)) else { return };
        let (mut count, mut bottom) = (0, field.bottom());
        for (rays, color) in parts(pass, is_walk_only).into_iter().filter(|(rays, _)| *rays > 0) {
            count += rays;
            let top = field.bottom() - height.of(count) * field.height();
            mesh.add_colored_rect(Rect::from_min_max(pos2(left, top), pos2(right.max(left + 0.5), bottom)), color);
            bottom = top;
        }
    };
    if axis.len() <= columns {
        for at in 0..axis.len() {
            let [begin, end] = axis.span(at);
            add(x(begin), x(end), at);
        }
    } else {
        // One column per point if there are more passes than points.
        for c in 0..columns {
            let left = field.left() + c as f32;
            add(left, left + 1.0, axis.at((c as f64 + 0.5) / columns as f64));
        }
    }
    mesh
}

/// Lines for numbers of rays, with labels at the left.
pub(super) fn marks(ui: &egui::Ui, painter: &Painter, field: Rect, height: Height) {
    let (ink, font) = (ui.visuals().text_color(), egui::FontId::proportional(crate::ui::style::SMALLEST));
    for mark in height.marks(field.height()) {
        let y = field.bottom() - height.of(mark) * field.height();
        painter.hline(field.x_range(), y, Stroke::new(0.5, ui.visuals().weak_text_color().gamma_multiply(0.5)));
        let at = pos2(field.left() - 4.0, y.max(field.top() + 5.0));
        painter.text(at, egui::Align2::RIGHT_CENTER, super::height::short(mark), font.clone(), ink);
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::{kernels, states};

    use super::super::axis::Scale;
    use super::*;

    fn pass(index: usize, walking: u32, resolved: u32) -> Pass {
        let mut counts = [0; 8];
        (counts[states::TRAV as usize], counts[states::SHADE as usize]) = (walking, resolved);
        let kernel = if index == 2 { kernels::SHADE } else { kernels::TRAVERSE_GRID };
        Pass {
            index,
            iteration: 1,
            rays_in: walking,
            counts: counts.into_iter().collect(),
            threads_launched: 1,
            ..Pass::of(kernel)
        }
    }

    #[test]
    fn the_axis_ends_at_all_rays_or_at_those_of_the_walk() {
        let passes = [pass(0, 600, 400), pass(1, 3, 997), pass(2, 0, 1000)];
        for (is_walk_only, most, shown) in [(false, 1000, 3), (true, 600, 2)] {
            let axis = Axis::new(&passes, Scale::Passes, is_walk_only);
            assert_eq!((height(&passes, &axis, is_walk_only, true).most, axis.len()), (most, shown));
        }
    }

    #[test]
    fn the_tail_of_a_run_is_seen_on_a_logarithmic_axis() {
        let passes = [pass(0, 262_144, 0), pass(1, 12, 262_132)];
        let axis = Axis::new(&passes, Scale::Passes, true);
        let field = Rect::from_min_max(pos2(0.0, 0.0), pos2(100.0, 50.0));
        let top = |is_log| {
            let mesh = mesh(field, &passes, &axis, height(&passes, &axis, true, is_log), true);
            assert_eq!(mesh.vertices.len(), 8, "one rectangle per pass");
            mesh.vertices[4..].iter().map(|vertex| vertex.pos.y).fold(f32::INFINITY, f32::min)
        };
        assert!(top(false) > 49.9 && top(true) < 45.0, "{} {}", top(false), top(true));
    }

    #[test]
    fn there_is_no_more_than_a_column_per_point() {
        let passes: Vec<Pass> = (0..5000).map(|i| Pass { kernel: kernels::TRAVERSE_GRID, ..pass(i, 1, 1) }).collect();
        let axis = Axis::new(&passes, Scale::Passes, false);
        let field = Rect::from_min_max(pos2(10.0, 0.0), pos2(110.0, 50.0));
        let mesh = mesh(field, &passes, &axis, Height { most: 2, is_log: false }, false);
        assert_eq!(mesh.vertices.len(), 100 * 2 * 4);
    }
}
