//! Bar charts shared by several panels, and the colours of kernels.

use egui::{Align2, Color32, FontId, Rect, Response, Sense, Ui, pos2, vec2};
use raystep_kernels::Kernel;

/// Points below the bars, for labels.
const FOOT: f32 = 14.0;
/// Points that a number below a bar needs.
const LABEL: f32 = 34.0;

/// The colour of a kernel: the same in every panel, readable on light and dark backgrounds.
pub(in crate::ui) fn kernel_color(kernel: Kernel) -> Color32 {
    let [r, g, b] = kernel.info().colour;
    Color32::from_rgb(r, g, b)
}

/// A histogram over 0, 1, …, with logarithmic heights, so that a count of one is visible beside a million.
pub(in crate::ui) struct Histogram<'a> {
    /// The counts; trailing zeros are omitted.
    pub counts: &'a [u64],
    /// What is counted, for screen readers.
    pub name: &'a str,
    /// Describes a bar from its index and count.
    pub about: &'a dyn Fn(usize, u64) -> String,
    /// Whether the last entry also includes everything beyond it.
    pub is_open: bool,
}

impl Histogram<'_> {
    /// Paints it.
    pub(in crate::ui) fn show(&self, ui: &mut Ui, height: f32) -> Response {
        let counts = without_zeros(self.counts);
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width().max(60.0), height), Sense::hover());
        let painter = ui.painter_at(rect);
        let field = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - FOOT));
        painter.rect_filled(field, 2.0, ui.visuals().extreme_bg_color);
        let width = rect.width() / counts.len().max(1) as f32;
        let most = counts.iter().copied().max().unwrap_or(0);
        let every = (LABEL / width).ceil().max(1.0) as usize;
        let hovered =
            response.hover_pos().map(|at| ((at.x - rect.left()) / width) as usize).filter(|&i| i < counts.len());
        let (font, weak) = (FontId::proportional(11.0), ui.visuals().weak_text_color());
        for (i, &count) in counts.iter().enumerate() {
            let left = rect.left() + i as f32 * width;
            let top = field.bottom() - log_height(count, most) * (field.height() - 4.0);
            let bar = Rect::from_min_max(pos2(left, top), pos2(left + (width - 1.0).max(width * 0.6), field.bottom()));
            let color = match hovered == Some(i) {
                true => ui.visuals().strong_text_color(),
                false => ui.visuals().selection.bg_fill,
            };
            painter.rect_filled(bar, 0.0, color);
            if i % every == 0 {
                let is_rest = self.is_open && i + 1 == self.counts.len();
                let text = if is_rest { format!("{i}+") } else { i.to_string() };
                let at = pos2(left + 0.5 * width.min(LABEL), rect.bottom());
                painter.text(at, Align2::CENTER_BOTTOM, text, font.clone(), weak);
            }
        }
        let text = format!("{}: {} bars, the highest {most}", self.name, counts.len());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        match hovered {
            Some(i) => response.on_hover_text_at_pointer((self.about)(i, counts[i])),
            None => response,
        }
    }
}

fn without_zeros(counts: &[u64]) -> &[u64] {
    let end = counts.iter().rposition(|&count| count > 0).map_or(0, |last| last + 1);
    &counts[..end]
}

/// Height from 0 for none to 1 for the maximum; a single one is visible.
pub(in crate::ui) fn log_height(count: u64, most: u64) -> f32 {
    if count == 0 { 0.0 } else { ((count as f64 + 1.0).ln() / (most.max(count) as f64 + 1.0).ln()) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_of_one_is_visible_beside_a_bar_of_a_million() {
        assert_eq!((log_height(0, 1_000_000), log_height(1_000_000, 1_000_000), log_height(1, 1)), (0.0, 1.0, 1.0));
        assert!(log_height(1, 1_000_000) > 0.04);
        assert_eq!(without_zeros(&[0, 3, 0, 0]), [0, 3]);
        assert!(without_zeros(&[0, 0]).is_empty());
    }
}
