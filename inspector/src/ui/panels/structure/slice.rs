//! A layer of the grid's cells, coloured by list length.

use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Slider, Stroke, StrokeKind, TextureHandle};
use egui::{TextureOptions, Ui, Vec2, pos2, vec2};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::programs::closest_hit::states;
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::{Slice, triangles_in};
use raystep_lab::text::counted;

use super::picture::{legend, picture};
use crate::ui::pane::Context;
use crate::ui::panels::picked;
use crate::ui::panels::ray::current_row;
use crate::ui::shared::Picked;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Points around a layer, for the axis labels.
const MARGIN: Vec2 = vec2(22.0, 2.0);

/// A layer, and its marks.
#[derive(Default)]
pub(super) struct SliceView {
    /// The axis perpendicular to the layer; `None` for the initial z.
    axis: Option<usize>,
    /// Layer index; `None` follows the selected ray.
    index: Option<i32>,
    /// The cell that was clicked.
    cell: Option<[i32; 3]>,
    /// The selected ray's cell.
    current: Option<[i32; 3]>,
    /// The triangle whose cells are marked.
    triangle: Option<u32>,
    /// What was picked, in any panel, as of the last frame.
    picked: Option<Picked>,
    drawn: Option<(Slice, TextureHandle)>,
    /// Cells of the layer that list the marked triangle, and the key of that result.
    listing: Option<(Listed, Vec<[i32; 2]>)>,
}

/// A triangle, and the axis and index of a layer.
type Listed = (u32, usize, i32);

impl SliceView {
    /// Resets the view for another grid.
    pub(super) fn forget(&mut self) {
        let axis = self.axis;
        *self = Self { axis, ..Self::default() };
    }

    /// Selects a cell, and moves to its layer.
    pub(super) fn select(&mut self, data: &SceneData, cell: [i32; 3]) {
        if data.grid.is_in_grid(cell) {
            (self.cell, self.index) = (Some(cell), Some(cell[self.axis()]));
        }
    }

    /// The triangle whose cells are marked.
    pub(super) fn triangle(&self) -> Option<u32> {
        self.triangle
    }

    /// Marks what was picked, here or in another panel: a cell in its layer, or a triangle's cells.
    pub(super) fn mark(&mut self, data: &SceneData, picked: Option<Picked>) {
        if std::mem::replace(&mut self.picked, picked) == picked {
            return;
        }
        match picked {
            Some(Picked::Cell(cell)) => {
                self.triangle = None;
                // A cell of the layer in view, or of another one.
                if let [Ok(x), Ok(y), Ok(z)] = cell.map(i32::try_from) {
                    self.select(data, [x, y, z]);
                }
            }
            Some(Picked::Triangle(triangle)) => self.triangle = Some(triangle),
            Some(Picked::Node(_)) | None => (self.cell, self.triangle) = (None, None),
        }
    }

    /// The cell whose list is shown: the clicked one, otherwise the selected ray's.
    pub(super) fn cell(&self) -> Option<[i32; 3]> {
        self.cell.or(self.current)
    }

    fn axis(&self) -> usize {
        self.axis.unwrap_or(2).min(2)
    }

    /// Shows tools and image in this height, in points. `longest` is the grid's longest list.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, data: &SceneData, longest: u32, height: f32) {
        let top = ui.cursor().top();
        let visits = cx.model.life.as_ref().map_or_else(Vec::new, |life| visited(life, data, cx.model.place));
        let current = visits.iter().rev().find(|v| v.has_run).map(|v| v.cell);
        self.current = current;
        let index = self.tools(ui, data, longest);
        let axis = self.axis();
        if self.drawn.as_ref().is_none_or(|(slice, _)| (slice.axis, slice.index) != (axis, index)) {
            self.drawn = Slice::of(data, axis, index).map(|slice| {
                let image = picture(&slice, longest);
                let texture = ui.ctx().load_texture("slice", image, TextureOptions::NEAREST);
                (slice, texture)
            });
        }
        self.find_triangle(data);
        let Some((slice, texture)) = &self.drawn else { return };
        let room = vec2(ui.available_width().max(60.0), (height - (ui.cursor().top() - top)).max(60.0));
        let room = room.min(vec2(room.x, Placement::height(slice, data, room.x)));
        let (room, response) = ui.allocate_exact_size(room, Sense::click());
        let place = Placement::new(slice, data, room);
        let painter = ui.painter_at(room);
        painter.image(texture.id(), place.rect, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
        painter.rect_stroke(place.rect, 0.0, ui.visuals().widgets.noninteractive.bg_stroke, StrokeKind::Outside);
        let mark = |at: [i32; 2], color: Color32, width: f32| {
            let cell = place.cell(at);
            let cell = Rect::from_center_size(cell.center(), cell.size().max(Vec2::splat(4.0)));
            painter.rect_stroke(cell, 0.0, Stroke::new(width, color), StrokeKind::Inside);
        };
        for &at in self.listing.iter().flat_map(|(_, cells)| cells) {
            mark(at, Color32::from_rgb(255, 120, 80), 1.5);
        }
        for visit in &visits {
            if let Some(at) = place_in(slice, visit.cell) {
                mark(at, if visit.has_run { Color32::WHITE } else { Color32::from_white_alpha(90) }, 1.5);
            }
        }
        if let Some(at) = current.and_then(|cell| place_in(slice, cell)) {
            mark(at, Color32::from_rgb(255, 220, 60), 2.5);
        }
        if let Some(at) = self.cell.and_then(|cell| place_in(slice, cell)) {
            mark(at, picked::color(ui.visuals()), 2.5);
        }
        let [across, up] = others(axis);
        let font = FontId::proportional(11.0);
        let ink = ui.visuals().weak_text_color();
        painter.text(place.rect.right_bottom() + vec2(3.0, 0.0), Align2::LEFT_BOTTOM, AXES[across], font.clone(), ink);
        painter.text(place.rect.left_top() - vec2(3.0, 0.0), Align2::RIGHT_TOP, AXES[up], font, ink);
        let text = format!(
            "list lengths of the {} by {} cells perpendicular to {} at {index}, longest {}",
            slice.width,
            slice.height,
            AXES[axis],
            slice.lengths.iter().max().unwrap_or(&0)
        );
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        if let Some([column, row]) = response.hover_pos().and_then(|at| place.at(at)) {
            let [x, y, z] = slice.cell(column, row);
            let length = slice.lengths.get((row * slice.width + column) as usize).copied().unwrap_or(0);
            response
                .clone()
                .on_hover_text_at_pointer(format!("cell {x},{y},{z}: {} in its list", counted(length, "triangle")));
        }
        if let Some([column, row]) =
            response.interact_pointer_pos().filter(|_| response.clicked()).and_then(|at| place.at(at))
        {
            self.index = Some(index);
            if let Some(picked) = picked::cell(slice.cell(column, row)) {
                picked::toggle(cx.shared, picked);
            }
        }
    }

    /// Chooses axis and layer; returns the layer to show.
    fn tools(&mut self, ui: &mut Ui, data: &SceneData, longest: u32) -> i32 {
        let mut index = 0;
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("across").on_hover_text("the axis perpendicular to the layer");
            for (axis, name) in AXES.into_iter().enumerate() {
                if ui.selectable_label(self.axis() == axis, name).labelled_by(label.id).clicked() {
                    self.axis = Some(axis);
                    self.index = self.index.and(self.cell.map(|cell| cell[axis]));
                }
            }
            let axis = self.axis();
            let last = (data.grid.cells[axis] - 1).max(0);
            index = self.index.or(self.current.map(|cell| cell[axis])).unwrap_or(last / 2).clamp(0, last);
            let label = ui.label("at").id;
            ui.spacing_mut().slider_width = (ui.max_rect().width() - 200.0).clamp(30.0, 160.0);
            let slider = Slider::new(&mut index, 0..=last);
            if ui.add(slider).labelled_by(label).changed() {
                self.index = Some(index);
            }
            let mut follows = self.index.is_none();
            if ui
                .checkbox(&mut follows, "follow the ray")
                .on_hover_text("show the layer of the selected ray's cell")
                .changed()
            {
                (self.index, self.cell) = ((!follows).then_some(index), None);
            }
            legend(ui, longest);
        });
        index
    }

    fn find_triangle(&mut self, data: &SceneData) {
        let (Some(triangle), Some((slice, _))) = (self.triangle, &self.drawn) else {
            self.listing = None;
            return;
        };
        let wanted = (triangle, slice.axis, slice.index);
        if self.listing.as_ref().is_none_or(|(known, _)| *known != wanted) {
            self.listing = Some((wanted, listing(data, slice, triangle)));
        }
    }
}

/// A cell that the selected ray is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Visit {
    cell: [i32; 3],
    /// Whether that was before the current place.
    has_run: bool,
}

/// The cells of a ray's history in order; consecutive rows in the same cell count once.
fn visited(life: &Trace, data: &SceneData, place: usize) -> Vec<Visit> {
    let mut visits: Vec<Visit> = Vec::new();
    for row in &life.rows {
        if let Some(cell) = row.cell.filter(|&cell| data.grid.is_in_grid(cell))
            && visits.last().is_none_or(|last| last.cell != cell)
        {
            visits.push(Visit { cell, has_run: row.is_within(place) });
        }
    }
    // A pass that brings the ray to a cell has not worked in it yet.
    let now = current_row(life, place).and_then(|i| life.rows.get(i)).filter(|row| row.after.tag > states::TRAV_SETUP);
    if let Some(cell) = now.map(|row| data.grid.cell_of_index(row.after.cell_index))
        && let Some(next) = visits.iter().position(|v| !v.has_run)
        && visits[next].cell == cell
    {
        visits[next].has_run = true;
    }
    visits
}

/// The two axes of a layer perpendicular to the given one, in the order of [`Slice`].
fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis.min(2)]
}

/// Column and row of a cell in a layer; `None` if it is in another layer.
fn place_in(slice: &Slice, cell: [i32; 3]) -> Option<[i32; 2]> {
    let [across, up] = others(slice.axis);
    (cell[slice.axis] == slice.index).then(|| [cell[across], slice.height - 1 - cell[up]])
}

/// Cells of a layer that list a triangle, as columns and rows.
fn listing(data: &SceneData, slice: &Slice, triangle: u32) -> Vec<[i32; 2]> {
    let all = (0..slice.height).flat_map(|row| (0..slice.width).map(move |column| [column, row]));
    let lists = |&[column, row]: &[i32; 2]| {
        // Lists are in ascending order.
        triangles_in(data, data.grid.cell_index(slice.cell(column, row))).binary_search(&triangle).is_ok()
    };
    all.filter(lists).collect()
}

/// The screen rectangle of a layer, with the aspect ratio of its cells.
struct Placement {
    rect: Rect,
    cells: [i32; 2],
}

impl Placement {
    fn new(slice: &Slice, data: &SceneData, room: Rect) -> Self {
        let size = Self::size(slice, data);
        let room = room.shrink2(MARGIN);
        let scale = (room.width() / size.x).min(room.height() / size.y);
        let size = if scale.is_finite() && scale > 0.0 { size * scale } else { room.size() };
        Self {
            rect: Rect::from_min_size(room.min + 0.5 * (room.size() - size), size),
            cells: [slice.width, slice.height],
        }
    }

    /// Width and height of a layer, traced units.
    fn size(slice: &Slice, data: &SceneData) -> Vec2 {
        let [across, up] = others(slice.axis);
        vec2(slice.width as f32 * data.grid.width[across], slice.height as f32 * data.grid.width[up])
    }

    /// The height of a layer of this width, including margins.
    fn height(slice: &Slice, data: &SceneData, width: f32) -> f32 {
        let size = Self::size(slice, data);
        let height = (width - 2.0 * MARGIN.x) * size.y / size.x;
        // Both axis labels must be readable.
        if height.is_finite() { height.max(24.0) + 2.0 * MARGIN.y } else { f32::INFINITY }
    }

    fn cell(&self, [column, row]: [i32; 2]) -> Rect {
        let [columns, rows] = self.cells;
        let size = vec2(self.rect.width() / columns as f32, self.rect.height() / rows as f32);
        Rect::from_min_size(self.rect.min + vec2(column as f32 * size.x, row as f32 * size.y), size)
    }

    fn at(&self, at: Pos2) -> Option<[i32; 2]> {
        let [columns, rows] = self.cells;
        let part = (at - self.rect.min) / self.rect.size();
        self.rect.contains(at).then(|| {
            let index = |part: f32, count: i32| ((part * count as f32) as i32).clamp(0, count - 1);
            [index(part.x, columns), index(part.y, rows)]
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::export::trace::{Rays, TraceRow, trace};
    use raystep_kernels::{Device, GridSize, Limits, Options, Plan, RaySource, Renderer, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    fn room() -> SceneData {
        let options =
            Options { grid: GridSize::Cells([5, 4, 3]), shade: false, ..Options::new(RaySource::Given(Vec::new())) };
        Plan::new(&generate::cornell_box(), &options, &Limits::CPU).expect("a small scene").1
    }

    #[test]
    fn a_cell_is_found_where_it_is_drawn() {
        let data = room();
        for axis in 0..3 {
            let slice = Slice::of(&data, axis, 1).expect("a slice");
            let place = Placement::new(&slice, &data, Rect::from_min_size(pos2(7.0, 9.0), vec2(300.0, 200.0)));
            for row in 0..slice.height {
                for column in 0..slice.width {
                    let cell = slice.cell(column, row);
                    assert_eq!(place_in(&slice, cell), Some([column, row]));
                    assert_eq!(place.at(place.cell([column, row]).center()), Some([column, row]));
                }
            }
            let mut elsewhere = slice.cell(0, 0);
            elsewhere[axis] = 0;
            assert_eq!((place_in(&slice, elsewhere), place.at(pos2(0.0, 0.0))), (None, None));
        }
    }

    #[test]
    fn cells_of_a_triangle_are_those_that_list_it() {
        let data = room();
        let mut found = 0;
        for index in 0..3 {
            found += listing(&data, &Slice::of(&data, 2, index).expect("a slice"), 0).len();
        }
        assert_eq!(found, data.grid_items.iter().filter(|&&triangle| triangle == 0).count());
        assert!(found > 0);
    }

    #[test]
    fn a_ray_visits_cell_after_cell_and_those_ahead_are_told_from_those_behind() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options {
            grid: GridSize::Cells([5, 4, 6]),
            schedule: ScheduleKind::Second,
            ..Options::new(RaySource::Camera { camera, width: 8, height: 8 })
        };
        let (life, data) = pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let life = trace(&mut renderer, 3, 4, Rays::All, |_| ControlFlow::Continue(())).await.expect("a life");
            (life, renderer.shared_data())
        });
        let passes = life.passes.expect("the whole run");
        let count = |place: usize| visited(&life, &data, place).iter().filter(|v| v.has_run).count();
        let visits = visited(&life, &data, passes);
        assert!(visits.len() > 2, "the ray goes through the room");
        for pair in visits.windows(2) {
            let steps: i32 = (0..3).map(|axis| (pair[0].cell[axis] - pair[1].cell[axis]).abs()).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
        assert_eq!((count(0), count(passes)), (0, visits.len()));
        // Set-up moves the ray to its first cell, and the first step to the second.
        let step = life.rows.iter().find(|row| row.kernel == "traverse_grid").expect("a step");
        let at = |row: &TraceRow| count(row.place().expect("a pass"));
        assert_eq!((at(&life.rows[1]), at(step)), (1, 2));
        assert!((0..passes).all(|place| count(place) <= count(place + 1)));
    }
}
