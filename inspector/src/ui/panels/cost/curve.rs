//! Cost by rank, on logarithmic axes.

use egui::{Align2, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use raystep_lab::work::CostOrder;

/// Points of the curve at most.
const POINTS: usize = 240;
/// Points below the field, for the ranks.
const FOOT: f32 = 13.0;

/// Ranks to plot, dense for the most expensive rays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Curve {
    /// Rank from 0, and cost.
    points: Vec<(usize, u32)>,
}

impl Curve {
    pub(super) fn new(order: &CostOrder) -> Self {
        let rays = order.rays();
        let mut ranks: Vec<usize> = (0..POINTS).map(|i| rank_at(i as f64 / (POINTS - 1) as f64, rays.len())).collect();
        ranks.dedup();
        let point = |rank: usize| Some((rank, order.cost(*rays.get(rank)? as usize)?));
        Self { points: ranks.into_iter().filter_map(point).collect() }
    }

    /// Paints it and returns the rank that was clicked. `selected` is the marked rank.
    pub(super) fn show(&self, ui: &mut Ui, height: f32, order: &CostOrder, selected: Option<usize>) -> Option<usize> {
        let size = vec2(ui.available_width().max(60.0), height.max(60.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let painter = ui.painter_at(rect);
        // What is above may be wider than the panel, and the curve ends where the panel is seen to end.
        let rect = rect.intersect(ui.clip_rect().expand2(vec2(0.0, f32::INFINITY)));
        let field = Rect::from_min_max(rect.min, pos2(rect.right(), rect.bottom() - FOOT));
        painter.rect_filled(field, 2.0, ui.visuals().extreme_bg_color);
        let (rays, most) = (order.rays().len(), self.points.first().map_or(0, |p| p.1));
        let inner = field.shrink(4.0);
        let at = |rank: usize, cost: u32| {
            let (x, y) = (part_of(rank, rays) as f32, cost_part(cost, most) as f32);
            pos2(inner.left() + x * inner.width(), inner.bottom() - y * inner.height())
        };
        let (ink, font) = (ui.visuals().weak_text_color(), FontId::proportional(11.0));
        // A line for every power of ten.
        let mut power = 1usize;
        while power <= rays {
            let x = at(power - 1, 0).x;
            painter.vline(x, field.y_range(), Stroke::new(0.5, ink.gamma_multiply(0.4)));
            let label = painter.layout_no_wrap(power.to_string(), font.clone(), ink);
            // The first and the last stay inside.
            let size = label.size();
            let left = (x - 0.5 * size.x).min(rect.right() - size.x).max(rect.left());
            painter.galley(pos2(left, rect.bottom() - size.y), label, ink);
            power = power.saturating_mul(10);
            if power == usize::MAX {
                break;
            }
        }
        let line: Vec<Pos2> = self.points.iter().map(|&(rank, cost)| at(rank, cost)).collect();
        painter.add(Shape::line(line, Stroke::new(1.5, ui.visuals().hyperlink_color)));
        let scales = format!("cost up to {most} by rank, logarithmic axes");
        painter.text(field.left_bottom() + vec2(4.0, -2.0), Align2::LEFT_BOTTOM, scales, font, ink);
        let cost_of = |rank: usize| order.rays().get(rank).and_then(|&ray| order.cost(ray as usize)).unwrap_or(0);
        if let Some(rank) = selected {
            painter.circle_filled(at(rank, cost_of(rank)), 4.0, ui.visuals().strong_text_color());
        }
        let text = format!("cost by rank of {rays} rays, at most {most}");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        let rank_under = |at: Pos2| rank_at(f64::from((at.x - inner.left()) / inner.width()), rays);
        if let Some(rank) = response.hover_pos().map(rank_under) {
            let text = format!("ray {} of {rays} by cost: {}\nclick to select it", rank + 1, cost_of(rank));
            response.clone().on_hover_text_at_pointer(text);
        }
        response.interact_pointer_pos().filter(|_| response.clicked()).map(rank_under)
    }
}

/// The rank at a fraction of the width, 0 to 1.
fn rank_at(part: f64, rays: usize) -> usize {
    let rank = (part.clamp(0.0, 1.0) * (rays.max(1) as f64).ln()).exp().round() as usize;
    rank.saturating_sub(1).min(rays.saturating_sub(1))
}

/// Horizontal position of a rank, from 0 to 1.
fn part_of(rank: usize, rays: usize) -> f64 {
    if rays > 1 { ((rank + 1) as f64).ln() / (rays as f64).ln() } else { 0.0 }
}

/// Height of a cost, from 0 to 1.
fn cost_part(cost: u32, most: u32) -> f64 {
    if most == 0 { 0.0 } else { (f64::from(cost) + 1.0).ln() / (f64::from(most) + 1.0).ln() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_has_the_first_and_the_last_ray_and_falls() {
        let order = CostOrder::new((0..10_000).map(|i| i * 7 % 1013).collect());
        let curve = Curve::new(&order);
        assert_eq!((curve.points[0], curve.points.last()), ((0, 1012), Some(&(9999, 0))));
        assert!(curve.points.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 >= w[1].1));
        assert!(curve.points.iter().take(10).map(|p| p.0).eq(0..10), "all of the most expensive are there");
        assert!(Curve::new(&CostOrder::new(Vec::new())).points.is_empty());
        assert_eq!(Curve::new(&CostOrder::new(vec![5])).points, [(0, 5)]);
    }

    #[test]
    fn ranks_and_places_are_inverse() {
        for rays in [1, 2, 17, 100_000] {
            for rank in [0, 1, 16, 99_999].into_iter().filter(|&rank| rank < rays) {
                assert_eq!(rank_at(part_of(rank, rays), rays), rank);
            }
        }
        assert_eq!((rank_at(-3.0, 10), rank_at(9.0, 10), rank_at(0.5, 0)), (0, 9, 0));
        assert_eq!([cost_part(0, 9), cost_part(9, 9), cost_part(0, 0)], [0.0, 1.0, 0.0]);
    }
}
