//! The colours of a layer of cells, by the length of their lists.

use egui::{Color32, ColorImage, Rect, Sense, Ui, vec2};
use raystep_lab::structure_stats::Slice;

use crate::draw::stream::Colors;

/// The colour of empty cells.
const EMPTY: Color32 = Color32::from_rgb(22, 22, 28);
/// Most texels per side: in larger layers, one texel represents several cells.
const MOST_TEXELS: i32 = 2048;

/// A layer as an image: one texel per cell, or for a very large layer one for several cells.
pub(super) fn picture(slice: &Slice, longest: u32) -> ColorImage {
    of_at_most(slice, longest, MOST_TEXELS)
}

/// A layer as an image of at most `most` texels per side, each for its longest list.
fn of_at_most(slice: &Slice, longest: u32, most: i32) -> ColorImage {
    let block = |side: i32| (side + most - 1) / most;
    let [bx, by] = [block(slice.width).max(1), block(slice.height).max(1)];
    let size = [(slice.width + bx - 1) / bx, (slice.height + by - 1) / by].map(|side| side as usize);
    let mut lengths = vec![0; size[0] * size[1]];
    for (row, line) in slice.lengths.chunks(slice.width.max(1) as usize).enumerate() {
        let first = row / by as usize * size[0];
        for (column, &length) in line.iter().enumerate() {
            let texel = &mut lengths[first + column / bx as usize];
            *texel = length.max(*texel);
        }
    }
    ColorImage::new(size, lengths.into_iter().map(|length| color(length, longest)).collect())
}

/// Logarithmic, since few lists are long. The same length has the same colour in every layer.
pub(super) fn color(length: u32, longest: u32) -> Color32 {
    if length == 0 {
        return EMPTY;
    }
    let part = if longest > 1 { f64::from(length).ln() / f64::from(longest).ln() } else { 1.0 };
    // The darkest tenth of the map is reserved for empty cells.
    let [r, g, b] = Colors::Viridis.at(0.1 + 0.9 * part);
    Color32::from_rgb(r, g, b)
}

/// The legend of the colours.
pub(super) fn legend(ui: &mut Ui, longest: u32) {
    let steps = 24;
    let (rect, response) = ui.allocate_exact_size(vec2(steps as f32 * 3.0, 10.0), Sense::hover());
    let painter = ui.painter_at(rect);
    for i in 0..steps {
        let length = f64::from(longest.max(1)).powf(f64::from(i - 1) / f64::from(steps - 2));
        let length = if i == 0 { 0 } else { (length.round() as u32).max(1) };
        let bar = Rect::from_min_size(rect.min + vec2(i as f32 * 3.0, 0.0), vec2(3.0, rect.height()));
        painter.rect_filled(bar, 0.0, color(length, longest));
    }
    let about = "triangles per cell: dark for none, otherwise logarithmic up to the grid's longest list";
    response.on_hover_text(about);
    ui.small(format!("0, 1 … {longest}")).on_hover_text(about);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_list_is_lost_where_a_texel_stands_for_several_cells() {
        let mut lengths = vec![0; 7 * 5];
        lengths[2 * 7 + 3] = 9;
        let slice = Slice { axis: 2, index: 0, width: 7, height: 5, lengths };
        let image = of_at_most(&slice, 9, 3);
        assert_eq!(image.size, [3, 3]);
        let lit: Vec<usize> = (0..9).filter(|&i| image.pixels[i] != EMPTY).collect();
        // Blocks of 3 x 2 cells: column 3 is the first of the second ones, and so is row 2.
        assert_eq!(lit, [4]);
        assert_eq!(of_at_most(&slice, 9, 100).size, [7, 5]);
    }

    #[test]
    fn empty_cells_are_told_from_short_lists() {
        assert_eq!(color(0, 100), EMPTY);
        let luma = |c: Color32| u32::from(c.r()) + u32::from(c.g()) + u32::from(c.b());
        assert!([1, 2, 10, 100].map(|n| luma(color(n, 100))).is_sorted());
        assert_ne!(color(1, 100), EMPTY);
        assert_eq!(color(1, 1), color(100, 100));
    }
}
