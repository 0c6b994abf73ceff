//! Where the cells of a layer lie on the screen.

use egui::{Pos2, Rect, Vec2, pos2, vec2};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::Slice;

/// The two axes of a layer perpendicular to the given one, in the order of [`Slice`].
pub(super) fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis.min(2)]
}

/// Column and row of a cell in a layer; `None` if it is in another layer.
pub(super) fn place_in(slice: &Slice, cell: [i32; 3]) -> Option<[i32; 2]> {
    let [across, up] = others(slice.axis);
    (cell[slice.axis] == slice.index).then(|| [cell[across], slice.height - 1 - cell[up]])
}

/// Width and height of a layer, traced units.
pub(super) fn size(slice: &Slice, data: &SceneData) -> Vec2 {
    let [across, up] = others(slice.axis);
    vec2(slice.width as f32 * data.grid.width[across], slice.height as f32 * data.grid.width[up])
}

/// The screen rectangle of a layer, with the aspect ratio of its cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) rect: Rect,
    cells: [i32; 2],
}

impl Placement {
    /// At this position, with this many points per traced unit.
    pub(super) fn new(slice: &Slice, data: &SceneData, scale: f32, origin: Pos2) -> Self {
        Self { rect: Rect::from_min_size(origin, size(slice, data) * scale), cells: [slice.width, slice.height] }
    }

    /// Points per cell.
    pub(super) fn cell_size(&self) -> Vec2 {
        let [columns, rows] = self.cells;
        vec2(self.rect.width() / columns as f32, self.rect.height() / rows as f32)
    }

    pub(super) fn cell(&self, [column, row]: [i32; 2]) -> Rect {
        let size = self.cell_size();
        Rect::from_min_size(self.rect.min + vec2(column as f32 * size.x, row as f32 * size.y), size)
    }

    pub(super) fn at(&self, at: Pos2) -> Option<[i32; 2]> {
        self.rect.contains(at).then(|| self.nearest(at))
    }

    /// The column and row nearest to a point.
    pub(super) fn nearest(&self, at: Pos2) -> [i32; 2] {
        let [columns, rows] = self.cells;
        let part = (at - self.rect.min) / self.rect.size();
        let index = |part: f32, count: i32| ((part * count as f32) as i32).clamp(0, (count - 1).max(0));
        [index(part.x, columns), index(part.y, rows)]
    }

    /// The first and last column and row of a part of the screen.
    pub(super) fn visible(&self, part: Rect) -> [[i32; 2]; 2] {
        let ([left, top], [right, bottom]) = (self.nearest(part.min), self.nearest(part.max));
        [[left, right], [top, bottom]]
    }

    /// The screen position of a point of the scene, traced units.
    pub(super) fn project(&self, slice: &Slice, data: &SceneData, point: [f64; 3]) -> Pos2 {
        let [across, up] = others(slice.axis);
        let part = |axis: usize, cells: i32| {
            let (corner, width) = (f64::from(data.grid.corner[axis]), f64::from(data.grid.width[axis]));
            ((point[axis] - corner) / (width * f64::from(cells))) as f32
        };
        let (x, y) = (part(across, slice.width), part(up, slice.height));
        pos2(self.rect.left() + x * self.rect.width(), self.rect.bottom() - y * self.rect.height())
    }
}
