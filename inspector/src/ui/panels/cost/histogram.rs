//! The distribution of a cost over rays, in the heatmap's colours.

use egui::{Align2, Color32, FontId, Rect, Sense, Stroke, StrokeKind, Ui, pos2, vec2};
use raystep_lab::text::counted;

use super::scale::{Scale, paint_ticks};
use super::spread::{Bins, Spread};
use crate::ui::panels::chart::log_height;
use crate::ui::style::SMALLEST;

/// Height of a mark's name, points.
const NAME: f32 = 13.0;
/// Points below the bars, for ticks.
const FOOT: f32 = 18.0;

/// The histogram.
pub(super) struct Histogram<'a> {
    pub(super) spread: &'a Spread,
    pub(super) scale: Scale,
    /// What is counted.
    pub(super) unit: &'a str,
    /// The bar shown alone.
    pub(super) picked: Option<usize>,
    /// The selected ray's cost.
    pub(super) selected: Option<u32>,
}

impl Histogram<'_> {
    /// Paints it, and returns the bar that was clicked.
    pub(super) fn show(&self, ui: &mut Ui, height: f32) -> Option<usize> {
        let (bins, most) = (self.spread.bins(self.scale.is_log), self.spread.most);
        let size = vec2(super::seen_width(ui), height.max(120.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let painter = ui.painter_at(rect);
        let field = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - FOOT));
        painter.rect_filled(field, 2.0, ui.visuals().extreme_bg_color);
        let marks = self.marks();
        // Names are above the bars, a line each: they never lie over one another.
        let bars = Rect::from_min_max(pos2(field.left(), field.top() + NAME * marks.len() as f32 + 2.0), field.max);
        let count = bins.edges.len().max(1);
        let under = |at: egui::Pos2| {
            let bin = ((at.x - bars.left()) / bars.width() * count as f32) as usize;
            bin.min(count - 1)
        };
        let hovered = response.hover_pos().map(under);
        let highest = bins.counts.iter().copied().max().unwrap_or(0);
        let strong = ui.visuals().strong_text_color();
        for (i, &rays) in bins.counts.iter().enumerate() {
            let [left, right] = [i, i + 1].map(|i| bars.left() + i as f32 / count as f32 * bars.width());
            let top = bars.bottom() - log_height(rays, highest) * (bars.height() - 2.0);
            let bar = Rect::from_min_max(pos2(left, top), pos2((right - 1.0).max(left + 1.0), bars.bottom()));
            let [from, to] = bins.range(i, most).unwrap_or_default();
            let color = self.scale.color(self.scale.part(f64::from(from.midpoint(to)), most));
            let is_dim = self.picked.is_some_and(|picked| picked != i);
            painter.rect_filled(bar, 0.0, if is_dim { color.gamma_multiply(0.3) } else { color });
            if rays > 0 && (hovered == Some(i) || self.picked == Some(i)) {
                painter.rect_stroke(bar.expand(1.0), 0.0, Stroke::new(1.5, strong), StrokeKind::Outside);
            }
        }
        let x = |value: f64| bars.left() + position(bins, most, value) * bars.width();
        let ink = ui.visuals().text_color();
        let lines =
            || marks.iter().enumerate().map(|(i, (name, value))| (field.top() + NAME * i as f32, name, x(*value)));
        for (top, _, x) in lines() {
            painter.vline(x, top..=bars.bottom(), Stroke::new(1.0, ink));
        }
        for (top, name, x) in lines() {
            let galley = painter.layout_no_wrap(name.clone(), FontId::proportional(SMALLEST), ink);
            // To the left of its line where there is no room at the right.
            let is_right = x + galley.size().x + 4.0 <= field.right().min(ui.clip_rect().right());
            let (align, at) = if is_right { (Align2::LEFT_TOP, x + 3.0) } else { (Align2::RIGHT_TOP, x - 3.0) };
            let place = align.anchor_size(pos2(at, top), galley.size());
            let place = place.translate(vec2((field.right() - 2.0 - place.right()).min(0.0), 0.0));
            // Other marks do not strike it through.
            painter.rect_filled(place, 0.0, ui.visuals().extreme_bg_color);
            painter.galley(place.min, galley, ink);
        }
        if let Some(cost) = self.selected {
            let at = pos2(x(f64::from(cost)), bars.bottom() - 5.0);
            painter.circle(at, 4.0, Color32::WHITE, Stroke::new(1.5, Color32::BLACK));
        }
        let ticks = self.scale.ticks(most, (bars.width() / 60.0) as u32);
        paint_ticks(
            ui,
            &painter,
            &ticks,
            |tick| x(f64::from(tick)),
            Rect::from_x_y_ranges(rect.x_range(), field.bottom()..=rect.bottom()),
        );
        let names = marks.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        let text = format!("rays by {}: {names}", self.unit);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        if let Some((bin, [from, to])) = hovered.and_then(|bin| Some((bin, bins.range(bin, most)?))) {
            let span = if from == to { from.to_string() } else { format!("{from} to {to}") };
            let rays = counted(bins.counts.get(bin).copied().unwrap_or(0), "ray");
            let text = format!("{rays} with {span} {}\nlogarithmic heights; click to show them alone", self.unit);
            response.clone().on_hover_text_at_pointer(text);
        }
        response.interact_pointer_pos().filter(|_| response.clicked()).map(under)
    }

    fn marks(&self) -> [(String, f64); 4] {
        let Spread { mean, median, most_of_95, most, .. } = *self.spread;
        [
            (format!("mean {mean:.1}"), mean),
            (format!("median {median}"), f64::from(median)),
            (format!("95% up to {most_of_95}"), f64::from(most_of_95)),
            (format!("max {most}"), f64::from(most)),
        ]
    }
}

/// Horizontal position of a value in the middle of its own place in its bar, from 0 to 1.
fn position(bins: &Bins, most: u32, value: f64) -> f32 {
    let bin = bins.of(value.max(0.0) as u32).unwrap_or(0);
    let [from, to] = bins.range(bin, most).unwrap_or_default().map(f64::from);
    let within = (value - from + 0.5) / (to - from + 1.0);
    ((bin as f64 + within.clamp(0.0, 1.0)) / bins.edges.len().max(1) as f64) as f32
}

#[cfg(test)]
mod tests {
    use raystep_lab::work::CostOrder;

    use super::*;

    #[test]
    fn a_value_is_marked_in_the_bar_that_counts_it() {
        for costs in [vec![0, 1, 2, 3], (0..500).collect()] {
            let spread = Spread::new(&CostOrder::new(costs.clone()));
            for is_log in [false, true] {
                let bins = spread.bins(is_log);
                for &cost in &costs {
                    let bin = position(bins, spread.most, f64::from(cost)) * bins.edges.len() as f32;
                    assert_eq!(Some(bin as usize), bins.of(cost), "{cost}");
                }
            }
        }
        // Four bars: 1.5 is between the middles of the second and the third.
        let spread = Spread::new(&CostOrder::new(vec![0, 1, 2, 3]));
        assert_eq!(position(spread.bins(false), 3, 1.5), 0.5);
    }
}
