//! One bar per pass, or, if there are more passes than points, one bar per point, as high as the slowest pass in it.

use egui::{Align2, FontId, Rect, Sense, Stroke, Ui, pos2, vec2};
use raystep_kernels::Pass;
use raystep_kernels::export::csv::DrawnPart;
use raystep_lab::text::counted;

use super::{duration, time_of};
use crate::ui::pane::Context;
use crate::ui::panels::chart::kernel_color;
use crate::ui::style::strong;
use crate::walk::Ticks;

/// Points below the bars, for numbers of passes.
const FOOT: f32 = 15.0;
/// Points that a number below a bar needs.
const NUMBER: f32 = 40.0;

/// A bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Column {
    /// The first pass it represents.
    first: usize,
    /// The slowest of them.
    dearest: usize,
    /// The duration of the slowest pass; `None` if none is known.
    ns: Option<u64>,
}

/// Passes as bars, `most` at most.
fn columns(passes: &[Pass], most: usize) -> Vec<Column> {
    let count = passes.len().min(most.max(1));
    let column = |i: usize| {
        let (first, end) = (i * passes.len() / count, (i + 1) * passes.len() / count);
        let dearest = (first..end).rev().max_by_key(|&pass| passes[pass].duration_ns).unwrap_or(first);
        Column { first, dearest, ns: passes[dearest].duration_ns }
    };
    (0..count).map(column).collect()
}

/// Passes whose numbers stand below the bars, and the middles of their bars: round ones, further apart where there is less
/// room.
fn numbers(columns: &[Column], passes: usize, width: f32) -> Vec<(usize, f32)> {
    // No more ticks than passes, so that all are whole numbers.
    let most = ((width / NUMBER) as usize).clamp(1, passes.max(1));
    let round = Ticks::of([0.0, passes as f64], most).values.into_iter().map(|pass| pass as usize);
    let middle = |pass: usize| {
        let column = columns.partition_point(|column| column.first <= pass).saturating_sub(1);
        (column as f32 + 0.5) * width / columns.len().max(1) as f32
    };
    round.filter(|&pass| pass < passes).map(|pass| (pass, middle(pass))).collect()
}

/// Paints them. A click goes to the place after the slowest pass of a bar. `kept` is cleared when passes change.
pub(super) fn show(ui: &mut Ui, height: f32, kept: &mut Vec<Column>, is_log: bool, cx: &mut Context<'_>) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width().max(60.0), height), Sense::click());
    let (passes, place) = (&cx.model.passes, cx.model.place);
    let most = rect.width() as usize;
    if kept.len() != passes.len().min(most.max(1)) {
        *kept = columns(passes, most);
    }
    let painter = ui.painter_at(rect);
    let field = rect.with_max_y(rect.bottom() - FOOT);
    painter.rect_filled(field, 2.0, ui.visuals().extreme_bg_color);
    let (font, weak) = (FontId::proportional(11.0), ui.visuals().weak_text_color());
    let longest = kept.iter().filter_map(|c| c.ns).max().unwrap_or(0).max(1);
    let width = rect.width() / kept.len().max(1) as f32;
    for (i, column) in kept.iter().enumerate() {
        let left = rect.left() + i as f32 * width;
        let pass = &passes[column.dearest];
        let color = kernel_color(pass.kernel);
        let color = if column.first >= place { color.gamma_multiply(0.45) } else { color };
        let gap = if width > 4.0 { 1.0 } else { 0.0 };
        let Some(ns) = column.ns else {
            let middle = pos2(left + 0.5 * width, field.bottom() - 6.0);
            let sign = if pass.below_ns().is_some() { "<" } else { "?" };
            painter.text(middle, Align2::CENTER_CENTER, sign, font.clone(), weak);
            continue;
        };
        let top = field.bottom() - part(ns, longest, is_log) * (field.height() - 16.0);
        painter.rect_filled(Rect::from_min_max(pos2(left, top), pos2(left + width - gap, field.bottom())), 0.0, color);
    }
    let scale = format!("{}{}", duration(longest), if is_log { ", logarithmic" } else { "" });
    painter.text(rect.left_top() + vec2(3.0, 1.0), Align2::LEFT_TOP, scale, font.clone(), weak);
    for (pass, middle) in numbers(kept, passes.len(), rect.width()) {
        let galley = painter.layout_no_wrap(pass.to_string(), font.clone(), weak);
        let most = (rect.width() - galley.size().x).max(0.0);
        let left = rect.left() + (middle - 0.5 * galley.size().x).clamp(0.0, most);
        painter.galley(pos2(left, rect.bottom() - galley.size().y), galley, weak);
    }
    if let Some(current) = place.checked_sub(1) {
        let column = kept.partition_point(|c| c.first <= current).saturating_sub(1);
        let x = rect.left() + (column as f32 + 0.5) * width;
        painter.vline(x, field.y_range(), Stroke::new(1.5, ui.visuals().strong_text_color()));
    }
    let text = format!(
        "durations of {}, the longest {}; after pass {place}",
        counted(passes.len(), "pass"),
        duration(longest)
    );
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, &text));
    let column_at = |x: f32| kept.get(((x - rect.left()) / width).max(0.0) as usize).or(kept.last());
    if let Some(column) = response.hover_pos().and_then(|at| column_at(at.x)) {
        let pass = &passes[column.dearest];
        let draws = cx.model.draws.get(column.dearest).map_or(&[][..], Vec::as_slice);
        let plan = cx.model.opened.as_ref().map(|opened| &opened.plan);
        let parts = plan.map(|plan| DrawnPart::of(plan, pass, draws)).unwrap_or_default();
        response.clone().on_hover_ui_at_pointer(|ui| about(ui, pass, &parts, passes.len() > kept.len()));
    }
    if let Some(column) = response.interact_pointer_pos().filter(|_| response.clicked()).and_then(|at| column_at(at.x))
    {
        cx.asks.go_to = Some(column.dearest + 1);
    }
}

fn about(ui: &mut Ui, pass: &Pass, parts: &[DrawnPart], is_dearest: bool) {
    strong(ui, format!("pass {}: {}", pass.index, pass.kernel.name()));
    let what = if is_dearest { "slowest in this bar, " } else { "" };
    ui.label(time_of(pass).map_or_else(|| "duration unknown".into(), |time| format!("{what}{time}")));
    ui.label(format!("processed {}", counted(pass.rays_in, "ray")));
    for part in parts {
        let time = part.time.duration_ns.map_or_else(|| "duration unknown".into(), duration);
        ui.weak(format!("{}: {time}", part.name()));
    }
}

/// Height of a bar, from 0 to 1.
fn part(ns: u64, longest: u64, is_log: bool) -> f32 {
    let (ns, longest) = (ns as f64, longest as f64);
    if is_log { ((ns + 1.0).ln() / (longest + 1.0).ln()) as f32 } else { (ns / longest) as f32 }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;

    use super::*;
    use crate::ui::panels::timings::tests::pass;

    #[test]
    fn the_dearest_pass_of_a_column_is_never_lost() {
        let mut passes: Vec<Pass> = (0..1000).map(|i| pass(i, kernels::INTERSECT, 1, Some(10))).collect();
        passes[777].duration_ns = Some(5000);
        passes[3].duration_ns = None;
        let all = columns(&passes, 100);
        assert_eq!((all.len(), all[77]), (100, Column { first: 770, dearest: 777, ns: Some(5000) }));
        assert_eq!(all.iter().filter(|c| c.ns == Some(5000)).count(), 1);
        // Of equal ones, the first.
        assert_eq!((all[0], all[99].first), (Column { first: 0, dearest: 0, ns: Some(10) }, 990));
        let few = columns(&passes[..4], 100);
        assert_eq!(few.len(), 4);
        assert_eq!(few[3], Column { first: 3, dearest: 3, ns: None });
        assert_eq!((columns(&[], 100), columns(&passes, 0).len()), (Vec::new(), 1));
    }

    #[test]
    fn numbers_of_passes_are_round_and_give_way_where_there_is_little_room() {
        let passes: Vec<Pass> = (0..35).map(|i| pass(i, kernels::INTERSECT, 1, Some(10))).collect();
        let of = |width: f32| numbers(&columns(&passes, width as usize), passes.len(), width);
        let shown = |width: f32| of(width).into_iter().map(|(pass, _)| pass).collect::<Vec<_>>();
        assert_eq!(shown(1500.0).len(), 35);
        assert_eq!([shown(300.0), shown(100.0), shown(20.0)], [vec![0, 5, 10, 15, 20, 25, 30], vec![0, 20], vec![0]]);
        for width in [20.0, 60.0, 333.0, 1500.0] {
            let all = of(width);
            assert!(all.windows(2).all(|pair| pair[1].1 - pair[0].1 >= NUMBER - 2.0), "{width}: {all:?}");
            assert!(all.iter().all(|(_, middle)| (0.0..width).contains(middle)), "{width}: {all:?}");
        }
        assert_eq!((of(350.0)[1], numbers(&[], 0, 100.0)), ((5, 55.0), vec![]));
    }

    #[test]
    fn the_longest_duration_has_the_full_height() {
        assert_eq!([part(50, 100, false), part(100, 100, true), part(0, 100, true)], [0.5, 1.0, 0.0]);
        assert!(part(10, 100, true) > 0.5);
    }
}
