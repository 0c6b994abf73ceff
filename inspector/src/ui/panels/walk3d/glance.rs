//! The ray under the cursor, as a thin line from its origin to its hit.

use egui::{Color32, Painter, Pos2, Rect, Stroke, Visuals, vec2};
use glam::{DVec2, DVec3};
use raystep_kernels::export::trace::Trace;

use crate::orbit::Orbit;
use crate::walk::{Aabb, to_f64};

/// Parts of the line: those that the camera does not see are left out.
const PARTS: usize = 64;

/// The ends of the ray in traced units: its hit, or where it leaves the scene; and whether it hits.
fn ends(trace: &Trace, bounds: &Aabb) -> Option<([DVec3; 2], bool)> {
    let ray = &trace.rows.first()?.after;
    let [origin, direction] = [ray.origin, ray.direction].map(to_f64);
    let last = &trace.rows.last()?.after;
    let hit = last.triangle.and(last.t).map(f64::from);
    let beyond = || bounds.interval(origin, direction).map_or(1.0, |[_, out]| out);
    let end = origin + direction * hit.unwrap_or_else(beyond);
    (origin.is_finite() && end.is_finite()).then_some(([origin, end], hit.is_some()))
}

/// Draws it. The camera and `bounds`, the scene's box, are in traced units.
pub(super) fn draw(painter: &Painter, visuals: &Visuals, rect: Rect, trace: &Trace, camera: &Orbit, bounds: &Aabb) {
    let Some(([origin, end], is_hit)) = ends(trace, bounds) else { return };
    let size = DVec2::new(rect.width().into(), rect.height().into());
    let seen = |at: DVec3| -> Option<Pos2> {
        let (pixel, _) = camera.pixel(at, size)?;
        Some(rect.min + vec2(pixel.x as f32, pixel.y as f32))
    };
    let color = if visuals.dark_mode { Color32::from_white_alpha(170) } else { Color32::from_black_alpha(170) };
    let points: Vec<_> = (0..=PARTS).map(|i| seen(origin.lerp(end, i as f64 / PARTS as f64))).collect();
    for pair in points.windows(2) {
        if let [Some(from), Some(to)] = *pair {
            painter.line_segment([from, to], Stroke::new(1.0, color));
        }
    }
    if let Some(at) = points.last().copied().flatten().filter(|_| is_hit) {
        painter.circle_stroke(at, 3.0, Stroke::new(1.0, color));
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::super::super::walked::tests::history;
    use super::*;

    #[test]
    fn the_line_ends_at_the_hit_or_where_the_ray_leaves_the_scene() {
        let (mut trace, data) = history(Accelerator::Grid);
        let bounds = Aabb::of_vertices(&data.vertices);
        let ([origin, end], is_hit) = ends(&trace, &bounds).expect("a line");
        let ray = trace.rows[0].after;
        let direction = to_f64(ray.direction);
        let t = (end - origin).dot(direction) / direction.length_squared();
        assert!(is_hit);
        let last = trace.rows.last_mut().expect("a row");
        let hit_t = f64::from(last.after.t.expect("a hit"));
        assert!((t - hit_t).abs() < 1e-12 * hit_t.max(1.0), "{t} {hit_t}");
        (last.after.triangle, last.after.t) = (None, None);
        let ([_, beyond], is_hit) = ends(&trace, &bounds).expect("a line");
        // The Cornell box is closed behind its hits.
        assert!(!is_hit && beyond.distance(origin) >= end.distance(origin) - 1e-6);
        trace.rows.clear();
        assert!(ends(&trace, &bounds).is_none());
    }
}
