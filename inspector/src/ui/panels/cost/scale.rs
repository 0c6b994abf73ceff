//! The axis of a cost: its position, colour and ticks.

use egui::{Color32, FontId, Painter, Rect, Ui, pos2, vec2};
use serde::{Deserialize, Serialize};

use crate::draw::stream::Colors;
use crate::ui::style::SMALLEST;

/// Height of the coloured strip, points.
const STRIP: f32 = 10.0;
/// Height of the strip with its numbers, points.
pub(in crate::ui::panels) const HEIGHT: f32 = STRIP + 16.0;

/// Where values lie between 0 and the largest, and their colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(in crate::ui::panels) struct Scale {
    pub(in crate::ui::panels) colors: Colors,
    /// Logarithmic, of 1 + the value.
    pub(in crate::ui::panels) is_log: bool,
}

impl Scale {
    /// From 0 for 0 to 1 for the largest value.
    pub(in crate::ui::panels) fn part(self, value: f64, most: u32) -> f64 {
        let most = f64::from(most);
        let part = if self.is_log { (value + 1.0).ln() / (most + 1.0).ln() } else { value / most };
        if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The value at a position.
    pub(super) fn value(self, part: f64, most: u32) -> u32 {
        let (part, most) = (part.clamp(0.0, 1.0), f64::from(most));
        let value = if self.is_log { ((most + 1.0).ln() * part).exp() - 1.0 } else { part * most };
        value.round() as u32
    }

    pub(super) fn color(self, part: f64) -> Color32 {
        let [r, g, b] = self.colors.at(part);
        Color32::from_rgb(r, g, b)
    }

    /// Round values for an axis, with 0 and at most `count` others, all up to `most`.
    pub(super) fn ticks(self, most: u32, count: u32) -> Vec<u32> {
        let round = |k: u32| 10u32.checked_pow(k / 3)?.checked_mul([1, 2, 5][k as usize % 3]);
        if self.is_log {
            // 1, 10, 100, … or fewer.
            let decades = most.max(1).ilog10() + 1;
            let every = 3 * decades.div_ceil(count.max(1)).max(1);
            return std::iter::once(0)
                .chain((0..28).step_by(every as usize).map_while(round))
                .take_while(|&v| v <= most)
                .collect();
        }
        let step = (0..28).map_while(round).find(|step| most / step <= count.max(1)).unwrap_or(most.max(1));
        (0..=most / step).map(|i| i * step).collect()
    }

    /// Paints colours and ticks below each other in the width of `rect`.
    pub(in crate::ui::panels) fn paint(self, ui: &Ui, painter: &Painter, rect: Rect, most: u32) {
        let strip = Rect::from_min_size(rect.min, vec2(rect.width(), STRIP));
        let bars = (strip.width() / 2.0).ceil().max(1.0) as usize;
        for i in 0..bars {
            let part = i as f64 / bars.saturating_sub(1).max(1) as f64;
            let left = strip.left() + strip.width() * i as f32 / bars as f32;
            let bar =
                Rect::from_min_max(pos2(left, strip.top()), pos2((left + 2.5).min(strip.right()), strip.bottom()));
            painter.rect_filled(bar, 0.0, self.color(part));
        }
        let ticks = self.ticks(most, (strip.width() / 60.0) as u32);
        let x = |tick: u32| strip.left() + self.part(f64::from(tick), most) as f32 * strip.width();
        paint_ticks(ui, painter, &ticks, x, Rect::from_min_max(strip.left_bottom(), rect.max));
    }
}

/// Paints ticks and their numbers at the top of `rect`, leaving out numbers that would overlap.
pub(super) fn paint_ticks(ui: &Ui, painter: &Painter, ticks: &[u32], x: impl Fn(u32) -> f32, rect: Rect) {
    let (ink, font) = (ui.visuals().text_color(), FontId::proportional(SMALLEST));
    let mut free = f32::NEG_INFINITY;
    for &tick in ticks {
        let galley = painter.layout_no_wrap(tick.to_string(), font.clone(), ink);
        let wanted = x(tick) - 0.5 * galley.size().x;
        let left = wanted.clamp(rect.left(), (rect.right() - galley.size().x).max(rect.left()));
        if left < free {
            continue;
        }
        free = left + galley.size().x + 4.0;
        painter.vline(x(tick), rect.top()..=rect.top() + 3.0, (1.0, ink));
        painter.galley(pos2(left, rect.top() + 3.0), galley, ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINEAR: Scale = Scale { colors: Colors::Viridis, is_log: false };
    const LOG: Scale = Scale { is_log: true, ..LINEAR };

    #[test]
    fn ticks_are_round_and_few_and_within_the_range() {
        assert_eq!(LINEAR.ticks(61, 6), [0, 10, 20, 30, 40, 50, 60]);
        assert_eq!(LINEAR.ticks(61, 5), [0, 20, 40, 60]);
        assert_eq!(LINEAR.ticks(5, 6), [0, 1, 2, 3, 4, 5]);
        assert_eq!(LINEAR.ticks(0, 6), [0]);
        assert_eq!(LOG.ticks(2500, 6), [0, 1, 10, 100, 1000]);
        for scale in [LINEAR, LOG] {
            for most in [0, 1, 7, 99, 12_345, u32::MAX] {
                for count in [0, 1, 6] {
                    let ticks = scale.ticks(most, count);
                    assert!(
                        ticks.len() <= count.max(1) as usize + 2 && ticks.iter().all(|&t| t <= most),
                        "{most} {ticks:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn positions_and_values_are_inverse() {
        for scale in [LINEAR, LOG] {
            for value in [0, 1, 30, 61] {
                assert_eq!(scale.value(scale.part(f64::from(value), 61), 61), value);
            }
            assert_eq!((scale.part(0.0, 0), scale.part(9.0, 3)), (0.0, 1.0));
        }
        assert!(LOG.part(7.0, 63) == 0.5 && LINEAR.part(7.0, 63) < 0.2);
    }
}
