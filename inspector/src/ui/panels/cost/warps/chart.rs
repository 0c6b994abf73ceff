//! The share of useful lanes, pass by pass.

use egui::{Align2, FontId, Rect, Sense, Stroke, Ui, pos2, vec2};
use raystep_kernels::{Kernel, Pass, Plan};
use raystep_lab::work::{Launch, PassLanes, threads};

use crate::ui::panels::chart::kernel_color;
use crate::ui::style::{SMALLEST, strong};

/// Threads of a row of workgroups that take their rays from a list: whole rows are launched.
const LIST_ROW: u64 = 256 * raystep_kernels::shared::constants::LIST_GROUPS as u64;
/// Points at the left, for the axis.
const AXIS: f32 = 40.0;

/// A pass as a bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bar {
    pub(super) kernel: Kernel,
    pub(super) rays: u64,
    /// Of the lanes of warps with any work; unknown before they were counted.
    pub(super) useful: Option<f64>,
    /// Of all lanes launched.
    pub(super) of_all: f64,
    /// Of the loop turns of a warp, those that a lane worked in.
    pub(super) turns: Option<f64>,
}

/// What the records of passes tell: the share of all lanes that a GPU would launch.
pub(super) fn bars_of_passes(passes: &[Pass], plan: &Plan) -> Vec<Bar> {
    let mut launched: Vec<(Kernel, u64)> = Vec::new();
    let bar = |pass: &Pass| {
        let rays = u64::from(pass.rays_in);
        let lanes = match Launch::of(pass.kernel, &plan.features) {
            Launch::List => rays.div_ceil(LIST_ROW) * LIST_ROW,
            Launch::Tiles => match launched.iter().find(|(kernel, _)| *kernel == pass.kernel) {
                Some((_, lanes)) => *lanes,
                None => {
                    let lanes = threads(pass.kernel, [plan.width, plan.height]).len() as u64;
                    launched.push((pass.kernel, lanes));
                    lanes
                }
            },
        };
        let of_all = rays as f64 / lanes.max(1) as f64;
        Bar { kernel: pass.kernel, rays, useful: None, of_all, turns: None }
    };
    passes.iter().map(bar).collect()
}

/// What was counted.
pub(super) fn bars_of_lanes(passes: &[PassLanes], lanes: usize) -> Vec<Bar> {
    let bar = |pass: &PassLanes| Bar {
        kernel: pass.kernel,
        rays: pass.working,
        useful: Some(pass.useful(lanes)),
        of_all: pass.useful_of_all(lanes),
        turns: pass.turns.map(|[taken, waited]| taken as f64 / waited.max(1) as f64),
    };
    passes.iter().map(bar).collect()
}

/// Mean shares of a kernel, weighted by the lanes of its passes.
pub(super) struct OfKernel {
    pub(super) kernel: Kernel,
    pub(super) passes: usize,
    pub(super) useful: Option<f64>,
    pub(super) of_all: f64,
}

pub(super) fn by_kernel(bars: &[Bar]) -> Vec<OfKernel> {
    let mut kernels: Vec<Kernel> = Vec::new();
    for bar in bars {
        if !kernels.contains(&bar.kernel) {
            kernels.push(bar.kernel);
        }
    }
    let of = |kernel: Kernel| {
        let of_kernel = || bars.iter().filter(move |bar| bar.kernel == kernel && bar.rays > 0);
        // Rays per share are lanes.
        let mean = |share: &dyn Fn(&Bar) -> Option<f64>| {
            let lanes = of_kernel().map(|bar| Some(bar.rays as f64 / share(bar)?)).sum::<Option<f64>>()?;
            Some(of_kernel().map(|bar| bar.rays as f64).sum::<f64>() / lanes.max(1.0))
        };
        OfKernel {
            kernel,
            passes: of_kernel().count(),
            useful: mean(&|bar| bar.useful),
            of_all: mean(&|bar| Some(bar.of_all)).unwrap_or(0.0),
        }
    };
    kernels.into_iter().map(of).collect()
}

/// Paints bars for passes; returns the pass that was clicked. `only` hides other kernels, `place` is marked.
pub(super) fn show(ui: &mut Ui, bars: &[Bar], only: Option<Kernel>, place: usize, height: f32) -> Option<usize> {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width().max(80.0), height.max(60.0)), Sense::click());
    let painter = ui.painter_at(rect);
    let field = Rect::from_min_max(pos2(rect.left() + AXIS, rect.top() + 6.0), rect.max - vec2(2.0, 6.0));
    painter.rect_filled(field, 0.0, ui.visuals().extreme_bg_color);
    let (ink, count) = (ui.visuals().text_color(), bars.len().max(1));
    for share in [0.0, 0.5, 1.0] {
        let y = field.bottom() - share * field.height();
        painter.hline(field.x_range(), y, Stroke::new(0.5, ui.visuals().weak_text_color().gamma_multiply(0.5)));
        let at = pos2(field.left() - 4.0, y);
        painter.text(at, Align2::RIGHT_CENTER, format!("{:.0}%", share * 100.0), FontId::proportional(SMALLEST), ink);
    }
    // At most one bar per point: of several passes, the first one that is shown.
    let columns = count.min(field.width().max(1.0) as usize).max(1);
    let x = |column: usize| field.left() + column as f32 / columns as f32 * field.width();
    let pass_in = |column: usize| {
        let passes = column * count / columns..((column + 1) * count / columns).min(bars.len());
        let is_shown = |&pass: &usize| only.is_none_or(|only| bars[pass].kernel == only);
        passes.into_iter().find(is_shown)
    };
    for column in 0..columns {
        let Some(bar) = pass_in(column).map(|pass| bars[pass]) else { continue };
        let color = kernel_color(bar.kernel);
        let [left, right] = [column, column + 1].map(x);
        let right = if right - left > 3.0 { right - 1.0 } else { right };
        let fill = |share: f64, color| {
            let top = field.bottom() - share.clamp(0.0, 1.0) as f32 * field.height();
            painter.rect_filled(Rect::from_min_max(pos2(left, top), pos2(right, field.bottom())), 0.0, color);
        };
        fill(bar.useful.unwrap_or(0.0), color.gamma_multiply(0.5));
        fill(bar.of_all, color);
    }
    if let Some(last) = place.checked_sub(1).filter(|&last| last < bars.len()) {
        let x = field.left() + (last as f32 + 0.5) / count as f32 * field.width();
        painter.vline(x, rect.y_range(), Stroke::new(1.5, ui.visuals().strong_text_color()));
    }
    response.widget_info(|| {
        let text = format!("share of lanes with work in {count} passes; after {place} of them");
        egui::WidgetInfo::labeled(egui::Role::Image, true, text)
    });
    let under = |at: egui::Pos2| {
        let column = ((at.x - field.left()) / field.width() * columns as f32).max(0.0) as usize;
        pass_in(column.min(columns - 1)).filter(|_| !bars.is_empty())
    };
    if let Some((pass, bar)) = response.hover_pos().and_then(under).and_then(|pass| Some((pass, bars.get(pass)?))) {
        response.clone().on_hover_ui_at_pointer(|ui| {
            strong(ui, format!("pass {pass}: {}", bar.kernel.name()));
            ui.label(format!("{} rays, {:.1}% of all lanes launched", bar.rays, bar.of_all * 100.0));
            if let Some(useful) = bar.useful {
                ui.label(format!("{:.1}% of the lanes of warps with any work", useful * 100.0));
            }
            if let Some(turns) = bar.turns {
                ui.label(format!("{:.1}% of the loop iterations of their warps", turns * 100.0));
            }
            ui.weak("click to go there");
        });
    }
    response.interact_pointer_pos().filter(|_| response.clicked()).and_then(under)
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels::{INTERSECT, SETUP, TRAVERSE_GRID};
    use raystep_kernels::{Limits, Options, RaySource, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    fn bar(kernel: Kernel, rays: u64, useful: f64, of_all: f64) -> Bar {
        Bar { kernel, rays, useful: Some(useful), of_all, turns: None }
    }

    #[test]
    fn the_mean_of_a_kernel_is_that_of_its_lanes() {
        // 64 of 128 lanes and 32 of 32: 96 of 160. Of all launched: 96 of 512.
        let bars = [bar(INTERSECT, 64, 0.5, 0.25), bar(SETUP, 5, 1.0, 1.0), bar(INTERSECT, 32, 1.0, 0.125)];
        let kernels = by_kernel(&bars);
        assert_eq!(kernels.iter().map(|of| (of.kernel, of.passes)).collect::<Vec<_>>(), [(INTERSECT, 2), (SETUP, 1)]);
        assert_eq!((kernels[0].useful, kernels[0].of_all), (Some(96.0 / 160.0), 96.0 / 512.0));
        let unknown = [Bar { useful: None, ..bars[0] }];
        assert_eq!(by_kernel(&unknown)[0].useful, None);
    }

    #[test]
    fn records_tell_the_share_of_all_lanes_that_a_gpu_launches() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options {
            schedule: ScheduleKind::Compact,
            ..Options::new(RaySource::Camera { camera, width: 20, height: 8 })
        };
        let (plan, _) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
        let pass = |kernel, rays_in| Pass { rays_in, ..Pass::of(kernel) };
        let bars = bars_of_passes(&[pass(SETUP, 160), pass(TRAVERSE_GRID, 100), pass(INTERSECT, 3000)], &plan);
        // Two workgroups of 16 x 16; one row of workgroups; two.
        let shares: Vec<f64> = bars.iter().map(|bar| bar.of_all).collect();
        assert_eq!(shares, [160.0 / 512.0, 100.0 / 2048.0, 3000.0 / 4096.0]);
    }
}
