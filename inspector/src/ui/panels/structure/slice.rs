//! A layer of the grid's cells, coloured by list length, with the lengths in cells that are large enough.

mod numbers;
mod path;
mod placement;

use crate::ui::canvas::WHOLE;
use crate::ui::choice::Choices as _;
use crate::walk::AXES;
use egui::{Color32, Pos2, Rect, Sense, Slider, Stroke, StrokeKind, TextureHandle, TextureOptions, Ui, Vec2, vec2};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::{Slice, triangles_in};
use raystep_lab::text::counted;

use super::picture::{legend, picture};
use crate::command::Command;
use crate::ui::pane::Context;
use crate::ui::panels::picked;
use crate::ui::panels::zoom::Zoom;
use crate::ui::state::Picked;
use crate::ui::style::strong;
use path::Path;
use placement::{Placement, others, place_in};

/// A layer, and its marks.
#[derive(Default)]
pub(super) struct SliceView {
    /// The axis perpendicular to the layer; `None` for the initial z.
    axis: Option<usize>,
    /// Layer index; `None` follows the selected ray.
    index: Option<i32>,
    /// The cell that was clicked.
    cell: Option<[i32; 3]>,
    /// The triangle whose cells are marked.
    triangle: Option<u32>,
    /// What was picked, in any panel, as of the last frame.
    picked: Option<Picked>,
    path: Path,
    zoom: Zoom,
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

    /// Shows a cell's list, and its layer.
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
        self.cell.or(self.path.current())
    }

    fn axis(&self) -> usize {
        self.axis.unwrap_or(2).min(2)
    }

    fn last(&self, data: &SceneData) -> i32 {
        (data.grid.cells[self.axis()] - 1).max(0)
    }

    /// The layer that is shown.
    fn index(&self, data: &SceneData) -> i32 {
        let last = self.last(data);
        self.index.or(self.path.current().map(|cell| cell[self.axis()])).unwrap_or(last / 2).clamp(0, last)
    }

    /// Performs a command about the layer.
    pub(super) fn command(&mut self, command: Command, data: &SceneData) {
        let index = self.index(data);
        match command {
            Command::NextSlice => self.index = Some((index + 1).min(self.last(data))),
            Command::PreviousSlice => self.index = Some((index - 1).max(0)),
            _ => self.turn((self.axis() + 1) % 3),
        }
    }

    /// Shows layers perpendicular to another axis; the picked cell stays in view.
    fn turn(&mut self, axis: usize) {
        self.axis = Some(axis);
        self.index = self.index.and(self.cell.map(|cell| cell[axis]));
        self.zoom.fit();
    }

    /// Shows tools and image in this height, in points. `longest` is the grid's longest list.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, data: &SceneData, longest: u32, height: f32) {
        let top = ui.cursor().top();
        self.path.update(cx.model.history.as_ref(), data, cx.model.place);
        self.tools(ui, data, longest);
        let (axis, index) = (self.axis(), self.index(data));
        if self.drawn.as_ref().is_none_or(|(slice, _)| (slice.axis, slice.index) != (axis, index)) {
            self.drawn = Slice::of(data, axis, index).map(|slice| {
                let image = picture(&slice, longest);
                let texture = ui.ctx().load_texture("slice", image, TextureOptions::NEAREST);
                (slice, texture)
            });
        }
        self.find_triangle(data);
        let Some((slice, texture)) = &self.drawn else { return };
        let [across, up] = others(axis);
        let text = format!(
            "layer {index} of {} along {}: {} to the right, {} up; numbers are triangles per cell",
            data.grid.cells[axis], AXES[axis], AXES[across], AXES[up]
        );
        ui.label(text);
        let room = vec2(ui.available_width().max(60.0), (height - (ui.cursor().top() - top)).max(80.0));
        let (room, response) = ui.allocate_exact_size(room, Sense::click_and_drag());
        let (view, size) = (numbers::beside_axes(room), placement::size(slice, data));
        self.zoom.follow(ui, &response, view, size);
        let (scale, origin) = self.zoom.placement(view, size);
        let place = Placement::new(slice, data, scale, origin);
        let painter = ui.painter_at(view);
        painter.rect_filled(view, 0.0, ui.visuals().extreme_bg_color);
        painter.image(texture.id(), place.rect, WHOLE, Color32::WHITE);
        numbers::axes(ui, &ui.painter_at(room), slice, &place, room, view);
        numbers::lengths(&painter, slice, &place, view, longest);
        let mark = |at: [i32; 2], color: Color32, width: f32| {
            let cell = place.cell(at);
            let cell = Rect::from_center_size(cell.center(), cell.size().max(Vec2::splat(4.0)));
            painter.rect_stroke(cell, 0.0, Stroke::new(width, color), StrokeKind::Inside);
        };
        for &at in self.listing.iter().flat_map(|(_, cells)| cells) {
            mark(at, Color32::from_rgb(255, 120, 80), 1.5);
        }
        for visit in self.path.visits() {
            if let Some(at) = place_in(slice, visit.cell) {
                mark(at, if visit.has_run { Color32::WHITE } else { Color32::from_white_alpha(90) }, 1.5);
            }
        }
        self.path.draw(&painter, slice, &place, data);
        if let Some(at) = self.path.current().and_then(|cell| place_in(slice, cell)) {
            mark(at, Color32::from_rgb(255, 220, 60), 2.5);
        }
        if let Some(at) = self.cell.and_then(|cell| place_in(slice, cell)) {
            mark(at, picked::color(ui.visuals()), 2.5);
        }
        let text = format!(
            "list lengths of the {} by {} cells perpendicular to {} at {index}, longest {}; {} to the right, {} up",
            slice.width,
            slice.height,
            AXES[axis],
            slice.lengths.iter().max().unwrap_or(&0),
            AXES[across],
            AXES[up]
        );
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        let in_view = |at: &Pos2| view.contains(*at);
        if let Some([column, row]) = response.hover_pos().filter(in_view).and_then(|at| place.at(at)) {
            let cell = slice.cell(column, row);
            let length = slice.lengths.get((row * slice.width + column) as usize).copied().unwrap_or(0);
            response.clone().on_hover_ui_at_pointer(|ui| about(ui, data, cell, length));
        }
        let clicked = response.interact_pointer_pos().filter(|at| response.clicked() && in_view(at));
        if let Some([column, row]) = clicked.and_then(|at| place.at(at)) {
            self.index = Some(index);
            if let Some(picked) = picked::cell(slice.cell(column, row)) {
                picked::toggle(cx.selection, picked);
            }
        }
    }

    /// Chooses axis and layer.
    fn tools(&mut self, ui: &mut Ui, data: &SceneData, longest: u32) {
        ui.horizontal_wrapped(|ui| {
            let key = |command: Command| command.key_text(ui.ctx());
            let keys = format!(
                "the axis perpendicular to the layer  {}; next and previous layer  {}, {}",
                key(Command::SliceAxis),
                key(Command::NextSlice),
                key(Command::PreviousSlice)
            );
            ui.label("across").on_hover_text(keys);
            for (axis, name) in AXES.into_iter().enumerate() {
                if ui.choice(self.axis() == axis, name).clicked() {
                    self.turn(axis);
                }
            }
            let mut index = self.index(data);
            let label = ui.label("at").id;
            ui.spacing_mut().slider_width = (ui.max_rect().width() - 200.0).clamp(30.0, 160.0);
            let slider = Slider::new(&mut index, 0..=self.last(data));
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
            if !self.zoom.is_fit() && ui.button("fit").on_hover_text("show the whole layer (double click)").clicked() {
                self.zoom.fit();
            }
        });
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

/// A cell's list and its box.
fn about(ui: &mut Ui, data: &SceneData, cell: [i32; 3], length: u32) {
    let [x, y, z] = cell;
    strong(ui, format!("cell {x},{y},{z}: {} in its list", counted(length, "triangle")));
    let bounds = crate::walk::Aabb::of_cells(&data.grid, cell, [1; 3]);
    for (name, corner) in [("from", bounds.min), ("to", bounds.max)] {
        let [x, y, z] = data.units.in_file(corner.to_array());
        ui.monospace(format!("{name:<4} {x:>11.5} {y:>11.5} {z:>11.5}"));
    }
    ui.weak("scene units; click to see its list");
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

#[cfg(test)]
mod tests {
    use egui::pos2;
    use raystep_kernels::{GridSize, Limits, Options, Plan, RaySource};
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
            let place = Placement::new(&slice, &data, 90.0, pos2(7.0, 9.0));
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
    fn keys_move_through_layers_and_axes_and_stay_in_the_grid() {
        let data = room();
        let mut view = SliceView::default();
        let mut now = |command: Command| {
            view.command(command, &data);
            (view.axis(), view.index(&data))
        };
        assert_eq!(now(Command::NextSlice), (2, 2));
        assert_eq!(now(Command::NextSlice), (2, 2), "three layers");
        assert_eq!((now(Command::PreviousSlice), now(Command::SliceAxis)), ((2, 1), (0, 2)));
        assert_eq!((now(Command::SliceAxis), now(Command::NextSlice)), ((1, 1), (1, 2)), "four layers");
        assert_eq!(now(Command::SliceAxis), (2, 1));
    }
}
