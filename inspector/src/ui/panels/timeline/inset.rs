//! What is under the cursor: a pass, the ray's event, a bookmark, and the nearest thumbnail, above the timeline.

use egui::{Align2, Area, Color32, Frame, Order, Pos2, RichText, Sense, Ui, vec2};
use raystep_kernels::Pass;
use raystep_kernels::tables::state::StateInfo;
use raystep_lab::text::counted;

use crate::ui::pane::Context;
use crate::ui::panels::timings::time_of;
use crate::ui::style::strong;

/// Height of the thumbnail.
const PICTURE: f32 = 96.0;
/// Width of its texts.
const WIDTH: f32 = 300.0;

/// Shows it above `at`; about a turn instead of a pass if there are lines about one.
pub(super) fn show(ui: &Ui, cx: &Context<'_>, at: Pos2, place: usize, turn: &[String], event: Option<&str>) {
    let area = Area::new(ui.scope_id().with("inset")).order(Order::Tooltip).interactable(false).fade_in(false);
    area.pivot(Align2::CENTER_BOTTOM).fixed_pos(at).constrain(true).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width(WIDTH + 140.0);
            ui.horizontal_top(|ui| {
                picture(ui, cx, place);
                ui.vertical(|ui| {
                    ui.set_max_width(WIDTH);
                    match turn {
                        [] => about(ui, cx, place),
                        [name, more @ ..] => {
                            strong(ui, name);
                            more.iter().for_each(|line| _ = ui.label(line));
                        }
                    }
                    if let Some(event) = event {
                        ui.label(event);
                    }
                    if let Some(bookmark) = cx.bookmarks.at(place).and_then(|i| cx.bookmarks.list.get(i)) {
                        ui.label(format!("bookmark: {}", bookmark.name));
                    }
                });
            });
        });
    });
}

fn picture(ui: &mut Ui, cx: &Context<'_>, place: usize) {
    let Some(thumb) = cx.display.thumbs.nearest(place) else { return };
    ui.vertical(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(thumb.width(PICTURE), PICTURE), Sense::hover());
        thumb.paint(ui.painter(), rect, Color32::WHITE);
        let text = format!("after {}", counted(thumb.place, "pass"));
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("thumbnail {text}")));
        // Where this pass was never shown, it is another one's.
        let text = if thumb.place == place { text } else { format!("nearest: {text}") };
        ui.label(RichText::new(text).small());
    });
}

fn about(ui: &mut Ui, cx: &Context<'_>, place: usize) {
    let Some(pass) = place.checked_sub(1).and_then(|index| cx.model.passes.get(index)) else {
        strong(ui, "before the first pass");
        return;
    };
    strong(ui, format!("pass {}: {}", pass.index, pass.kernel.name()));
    ui.label(format!("processed {}", counted(pass.rays_in, if cx.has_rays() { "ray" } else { "element" })));
    if let Some(time) = time_of(pass) {
        ui.label(format!("{time} on the device"));
    }
    for (count, state) in counted_states(pass) {
        ui.label(format!("{count} {}: {}", state.name, state.meaning));
    }
}

/// The states that rays are in after a pass, and how many rays.
fn counted_states(pass: &Pass) -> impl Iterator<Item = (u32, &'static StateInfo)> {
    let count = |state: &StateInfo| pass.counts.get(state.tag as usize).copied().unwrap_or(0);
    pass.kernel.program().states.iter().map(move |state| (count(state), state)).filter(|(count, _)| *count > 0)
}

/// The rays in each state after a pass, in words.
pub(super) fn states(pass: &Pass) -> Option<String> {
    let texts: Vec<String> = counted_states(pass).map(|(count, state)| format!("{count} {}", state.name)).collect();
    (!texts.is_empty()).then(|| format!("after it {}", texts.join(", ")))
}
