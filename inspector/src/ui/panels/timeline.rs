//! The passes as a scrubber: rays in each state, by pass or by time on the device; the turns of loops, the selected ray's
//! events, bookmarks and thumbnails. Dragging goes through the passes, and the pictures follow.
//!
//! Touches: selection, display, asks, bookmarks.

mod axis;
mod bands;
mod columns;
mod flags;
mod height;
mod inset;
mod strip;
mod ticks;

use axis::{Axis, Scale};
use bands::Bands;
use columns::Columns;
use egui::{EventFilter, FontId, Key, Modifiers, Rect, Response, Sense, Stroke, Ui, Vec2, pos2, vec2};
use flags::Flags;
use raystep_lab::human::round_up;
use raystep_lab::text::counted;
use serde::{Deserialize, Serialize};
use ticks::{Mark, Tick, Ticks};

use super::legend::{Entry, line};
use crate::command::Command;
use crate::ui::choice::Choices as _;
use crate::ui::pane::{Context, Panel};
use crate::ui::style::SMALLEST;

/// Points left of the chart, for numbers of rays. Dragging into them goes to the start.
const LEFT: f32 = 40.0;
/// Points at the right, so that the last pass can be reached.
const RIGHT: f32 = 6.0;
/// Height of the lane of the ray's events.
const EVENTS: f32 = 13.0;
/// Height of the labels below the chart.
const FOOT: f32 = 14.0;
/// Points between two of them.
const LABEL: f64 = 64.0;
/// There are no thumbnails if the chart is lower than this.
const ROOM_FOR_STRIP: f32 = 58.0;

/// The saved part of the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Look {
    scale: Scale,
    is_log: bool,
    is_walk_only: bool,
}

/// The timeline.
#[derive(Default)]
pub(in crate::ui) struct Timeline {
    look: Look,
    axis: Axis,
    /// The inputs of the axis, and how often they have changed.
    known: Option<(u64, u64, usize, Look)>,
    version: u64,
    bands: Bands,
    columns: Columns,
    ticks: Ticks,
    flags: Flags,
}

/// Where the parts of the panel are.
struct Lanes {
    events: Rect,
    bands: Rect,
    field: Rect,
    strip: Option<Rect>,
}

impl Panel for Timeline {
    fn least(&self) -> Vec2 {
        // A strip below other panels: the chart needs little height.
        vec2(240.0, 96.0)
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if cx.model.passes.is_empty() {
            let rays = "Step a pass to see how many rays are in each state.";
            ui.weak(if cx.has_rays() { rays } else { "Step a pass to see how many elements each pass works on." });
            return;
        }
        let look = self.tools(ui, cx);
        let passes = &cx.model.passes;
        let known = (cx.model.generation, cx.model.edition, passes.len(), look);
        if self.known != Some(known) {
            self.axis = Axis::new(passes, look.scale, look.is_walk_only);
            self.bands = Bands::new(passes);
            (self.known, self.version) = (Some(known), self.version + 1);
        }
        let size = ui.available_size().max(vec2(LEFT + RIGHT + 40.0, 40.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let has_flags = !cx.bookmarks.list.is_empty();
        let lanes = lanes(rect, has_flags, has_events(cx), &self.bands, cx.display.thumbs.shown().next().is_some());
        let axis = &self.axis;
        let (left, width) = (lanes.field.left(), f64::from(lanes.field.width().max(1.0)));
        let at = |part: f64| left + (part * width) as f32;
        let part = |x: f32| f64::from(x - left) / width;
        let middle = |place: usize| axis.middle_of(place).map(at);
        let run = cx.model.opened.as_ref().map(|opened| (&*opened.data, opened.plan.program.states));
        let ticks = self.ticks.of(cx.model.history.as_ref(), run);
        let thumbs = lanes.strip.map(|lane| strip::placed(lane, &cx.display.thumbs, middle)).unwrap_or_default();

        // A mark, a thumbnail or a turn is met, or the pass under the cursor.
        let pointer = response.interact_pointer_pos().or(response.hover_pos());
        let is_drag = response.dragged() || response.drag_stopped();
        let tick = pointer
            .filter(|pos| lanes.events.contains(*pos) && !is_drag)
            .and_then(|pos| ticks::nearest(ticks, pos.x, middle));
        let thumb = pointer
            .filter(|_| !is_drag)
            .and_then(|pos| thumbs.iter().find(|(rect, _)| rect.contains(pos)).map(|(_, place)| *place));
        let turn = pointer
            .filter(|_| !is_drag)
            .and_then(|pos| self.bands.at(lanes.bands, pos, axis.pass(axis.at(part(pos.x)))));
        let met = tick.map(|tick| tick.place).or(thumb).or(turn.map(|(_, [first, _])| first + 1));
        let under = pointer.map(|pos| met.unwrap_or_else(|| axis.place_at(part(pos.x))));
        let is_held = response.is_pointer_button_down_on() && ui.input(|input| input.pointer.primary_down());
        match (under, turn) {
            (_, Some((_, [_, end]))) if response.double_clicked() => cx.asks.scrub.go(end),
            (Some(place), _) if is_held => cx.asks.scrub.hold(place),
            (Some(place), _) if response.clicked() || response.drag_stopped() => cx.asks.scrub.go(place),
            _ => {}
        }
        keys(ui, &response, cx, axis);

        let shown = cx.asks.scrub.wanted().unwrap_or(cx.model.place);
        let painter = ui.painter_at(rect);
        painter.rect_filled(lanes.field, 0.0, ui.visuals().extreme_bg_color);
        let passes = &cx.model.passes;
        let height = columns::height(passes, axis, look.is_walk_only, look.is_log);
        self.columns.paint(&painter, lanes.field, (passes, axis, height), look.is_walk_only, self.version);
        columns::marks(ui, &painter, lanes.field, height);
        let schedule = cx.model.opened.as_ref().map(|opened| &opened.plan.schedule);
        schedule.into_iter().for_each(|of| self.bands.paint(ui, lanes.bands, (passes, axis), of, shown));
        feet(ui, lanes.field, axis, look.scale);
        let colors = [ui.visuals().text_color(), ui.visuals().selection.stroke.color];
        ticks::paint(&painter, lanes.events, ticks, shown, colors, middle);
        strip::paint(&painter, &thumbs, &cx.display.thumbs, shown);
        playhead(ui, rect, &lanes, at(axis.part_of(shown)));
        if let Some(pos) = pointer.filter(|pos| rect.contains(*pos) || is_held) {
            painter.vline(pos.x.clamp(left, rect.right()), lanes.field.y_range(), Stroke::new(1.0, colors[0]));
        }
        if response.has_focus() {
            painter.rect_stroke(rect, 2.0, Stroke::new(2.0, colors[1]), egui::StrokeKind::Inside);
        }
        if let Some((pos, place)) = pointer.zip(under).filter(|_| !egui::Popup::is_any_open(ui.ctx())) {
            let turn = turn.zip(schedule).map(|(turn, of)| Bands::about(turn, passes, of)).unwrap_or_default();
            let event = event_at(cx, ticks, tick, place).filter(|_| turn.is_empty());
            inset::show(ui, cx, pos2(pos.x, rect.top() - 2.0), place, &turn, event.as_deref());
        }
        let text = self.text(cx, shown, look);
        let value = Some(shown as f64);
        response
            .widget_info(|| egui::WidgetInfo { value, ..egui::WidgetInfo::labeled(egui::Role::Slider, true, &text) });
        let axis = &self.axis;
        let lane = Rect::from_min_max(rect.min, pos2(rect.right(), rect.top() + flags::LANE));
        self.flags.show(ui, cx, lane, lanes.field.bottom(), |place| at(axis.part_of(place)));
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        // Formerly only the scale was saved.
        let only_scale = |_| serde_json::from_str(saved).map(|scale| Look { scale, ..Look::default() });
        self.look = serde_json::from_str(saved).or_else(only_scale).unwrap_or_default();
    }
}

impl Timeline {
    /// The scales, as far as this run has them, and the legend.
    fn tools(&mut self, ui: &mut Ui, cx: &Context<'_>) -> Look {
        let passes = &cx.model.passes;
        let has_times = passes.iter().any(|pass| pass.duration_ns.is_some());
        let has_walk = passes.iter().any(axis::is_of_walk);
        let why_no_times = cx.model.opened.as_ref().and_then(|opened| opened.why_no_times.clone());
        ui.horizontal_wrapped(|ui| {
            ui.choice_of(&mut self.look.scale, Scale::Passes, "by pass");
            ui.add_enabled_ui(has_times, |ui| ui.choice_of(&mut self.look.scale, Scale::Time, "by device time"))
                .inner
                .on_disabled_hover_text(why_no_times.unwrap_or_else(|| "no pass has a time".into()));
            ui.checkbox(&mut self.look.is_log, "log")
                .on_hover_text("logarithmic scale, which also shows small numbers of rays");
            ui.add_enabled_ui(has_walk, |ui| ui.checkbox(&mut self.look.is_walk_only, "walk only"))
                .inner
                .on_hover_text("hide passes before and after the walk, and rays that have left it")
                .on_disabled_hover_text("this run has no passes of a walk");
            ui.separator();
            if let Some(pass) = passes.first() {
                let now = cx.model.last_pass().unwrap_or(pass);
                let opened = cx.model.opened.as_ref();
                let states = columns::states(pass, self.look.is_walk_only && has_walk)
                    .filter(|state| opened.is_none_or(|opened| opened.plan.has_state(state)));
                let entries = states.map(|state| {
                    let is_there = now.counts.get(state.tag as usize).is_some_and(|&rays| rays > 0);
                    Entry::new(columns::color(state), state.name, state.meaning).unless(is_there)
                });
                line(ui, &entries.collect::<Vec<_>>());
            }
            if has_events(cx) {
                ui.separator();
                let color = ui.visuals().text_color();
                line(
                    ui,
                    &Mark::ALL.map(|(mark, name, about)| {
                        Entry::painted(name, about, move |painter, rect| mark.paint(painter, rect.center(), color))
                    }),
                );
            }
        });
        Look {
            scale: if has_times { self.look.scale } else { Scale::Passes },
            is_walk_only: self.look.is_walk_only && has_walk,
            ..self.look
        }
    }

    /// For screen readers.
    fn text(&self, cx: &Context<'_>, place: usize, look: Look) -> String {
        let known = cx.model.passes.len();
        let mut text = format!("after {place} of {known} known passes");
        if let Some(pass) = place.checked_sub(1).and_then(|last| cx.model.passes.get(last)) {
            let turns = cx.model.opened.as_ref().map(|opened| self.bands.words(pass, &opened.plan.schedule));
            let turns = turns.unwrap_or_default();
            text += &format!("; pass {}: {}{turns}, processed {}", pass.index, pass.kernel.name(), pass.rays_in);
            text += &inset::states(pass).map_or_else(String::new, |states| format!(", {states}"));
        }
        if !cx.bookmarks.list.is_empty() {
            text += &format!("; {}", counted(cx.bookmarks.list.len(), "bookmark"));
        }
        text += if look.scale == Scale::Time { "; by device time" } else { "; by pass" };
        text + if look.is_log { ", logarithmic" } else { "" } + if look.is_walk_only { ", walk only" } else { "" }
    }
}

/// Whether a ray is selected that some pass processes.
fn has_events(cx: &Context<'_>) -> bool {
    cx.model.history.as_ref().is_some_and(|history| !history.rows.is_empty())
}

fn lanes(rect: Rect, has_flags: bool, has_events: bool, bands: &Bands, has_thumbs: bool) -> Lanes {
    let top = rect.top() + if has_flags { flags::LANE } else { 2.0 };
    let above = top + if has_events { EVENTS } else { 0.0 };
    let foot = rect.bottom() - FOOT;
    let below = above + bands.height(foot - above);
    let strip = (has_thumbs && foot - below > ROOM_FOR_STRIP).then(|| (0.4 * (foot - below)).min(64.0));
    let bottom = (foot - strip.map_or(0.0, |height| height + 2.0)).max(below + 8.0);
    let (left, right) = (rect.left() + LEFT, rect.right() - RIGHT);
    let lane = |top: f32, bottom: f32| Rect::from_min_max(pos2(left, top), pos2(right, bottom));
    // Marks of the first pass are cut off at the field's edge otherwise.
    let events = lane(top, above).expand2(vec2(RIGHT, 0.0));
    let bands = lane(above, below);
    Lanes { events, bands, field: lane(below, bottom), strip: strip.map(|height| lane(foot - height, foot)) }
}

/// The keys of a slider, while it has the focus.
fn keys(ui: &Ui, response: &Response, cx: &mut Context<'_>, axis: &Axis) {
    let id = response.id;
    let asked = |action| ui.input(|input| input.num_accesskit_action_requests(id, action)) as i64;
    let mut by = asked(egui::accesskit::Action::Increment) - asked(egui::accesskit::Action::Decrement);
    if response.has_focus() {
        let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
        ui.input_mut(|input| {
            // With Shift first: without it, it is allowed too.
            for (modifiers, far) in [(Modifiers::SHIFT, 10), (Modifiers::NONE, 1)] {
                let mut count = |key| input.count_and_consume_key(modifiers, key) as i64;
                by += far * (count(Key::ArrowRight) - count(Key::ArrowLeft));
            }
            for (key, command) in [(Key::Home, Command::Start), (Key::End, Command::End)] {
                if input.consume_key(Modifiers::NONE, key) {
                    cx.asks.commands.push(command);
                }
            }
        });
    }
    if by != 0 {
        let from = cx.asks.scrub.wanted().unwrap_or(cx.model.place);
        cx.asks.scrub.go(axis.step(from, by));
    }
}

/// The place that is shown, or on its way: a line, with a handle below the chart.
fn playhead(ui: &Ui, rect: Rect, lanes: &Lanes, x: f32) {
    let painter = ui.painter().with_clip_rect(rect);
    let x = x.clamp(lanes.field.left() + 1.0, lanes.field.right() - 1.0);
    let bottom = lanes.strip.map_or(lanes.field.bottom(), |strip| strip.bottom());
    // With an edge, it is visible over every colour.
    painter.vline(x, lanes.field.top()..=bottom, Stroke::new(4.0, ui.visuals().extreme_bg_color));
    painter.vline(x, lanes.field.top()..=bottom, Stroke::new(2.0, ui.visuals().strong_text_color()));
}

/// Indices of passes, or times, below the chart.
fn feet(ui: &Ui, field: Rect, axis: &Axis, scale: Scale) {
    let bottom = ui.max_rect().bottom();
    let (ink, font) = (ui.visuals().text_color(), FontId::proportional(SMALLEST));
    let painter = ui.painter();
    let step = round_up(axis.total * LABEL / f64::from(field.width().max(1.0)));
    let label = |part: f64, text: String| {
        let x = field.left() + (part * f64::from(field.width())) as f32;
        let galley = painter.layout_no_wrap(text, font.clone(), ink);
        let left = (x - 0.5 * galley.size().x).min(field.right() + RIGHT - galley.size().x);
        painter.galley(pos2(left, bottom - galley.size().y), galley, ink);
    };
    match scale {
        Scale::Passes => {
            let every = step.max(1.0) as usize;
            let marked = (0..axis.len()).filter_map(|at| Some((at, axis.pass(at)?)));
            for (at, pass) in marked.filter(|(_, pass)| pass.is_multiple_of(every)) {
                let [begin, end] = axis.span(at);
                label(0.5 * (begin + end), pass.to_string());
            }
        }
        Scale::Time => {
            let (unit, of) = match axis.total {
                ns if ns < 2e6 => ("µs", 1e3),
                ns if ns < 2e9 => ("ms", 1e6),
                _ => ("s", 1e9),
            };
            let digits = (-(step / of).log10()).ceil().clamp(0.0, 9.0) as usize;
            let count = (axis.total / step).floor().min(1000.0) as usize;
            for i in 0..=count {
                let ns = i as f64 * step;
                label(ns / axis.total.max(1.0), format!("{:.digits$} {unit}", ns / of));
            }
        }
    }
}

/// The ray's event in the pass under the cursor, in words.
fn event_at(cx: &Context<'_>, ticks: &[Tick], tick: Option<Tick>, place: usize) -> Option<String> {
    let tick = tick.or_else(|| ticks.iter().find(|tick| tick.place == place).copied())?;
    let row = cx.model.history.as_ref()?.rows.get(tick.row)?;
    Some(format!("the selected ray: {}", row.why))
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Pass;
    use raystep_kernels::programs::sort;

    use super::*;

    #[test]
    fn what_is_saved_comes_back_also_from_before_there_was_more_than_a_scale() {
        let look = Look { scale: Scale::Time, is_log: true, is_walk_only: true };
        let timeline = Timeline { look, ..Timeline::default() };
        let saved = timeline.save();
        let mut other = Timeline::default();
        other.load(&saved);
        assert_eq!(other.look, timeline.look);
        other.load("\"Time\"");
        assert_eq!(other.look, Look { scale: Scale::Time, ..Look::default() });
        other.load("nonsense");
        assert_eq!(other.look, Look::default());
    }

    #[test]
    fn lanes_lie_in_the_panel_however_small_it_is() {
        for height in [40.0, 60.0, 90.0, 130.0, 400.0] {
            let rect = Rect::from_min_size(pos2(5.0, 7.0), vec2(300.0, height));
            for bits in 0..16 {
                let turns = if bits & 8 > 0 { 2 } else { 0 };
                let turn = |turn| Pass { loops: vec![turn; 2], ..Pass::of(sort::EXCHANGE) };
                let bands = Bands::new(&(0..turns).map(turn).collect::<Vec<_>>());
                let lanes = lanes(rect, bits & 1 > 0, bits & 2 > 0, &bands, bits & 4 > 0);
                assert!(lanes.field.height() >= 8.0 && rect.contains_rect(lanes.field), "{height}, {bits}");
                assert!(lanes.events.bottom() <= lanes.bands.top() && lanes.bands.bottom() <= lanes.field.top());
                assert!(lanes.bands.is_positive() == (bits & 8 > 0) || height < 60.0, "{height}, {bits}");
                if let Some(strip) = lanes.strip {
                    assert!(strip.top() > lanes.field.bottom() && strip.bottom() <= rect.bottom(), "{height}, {bits}");
                    assert!(height >= ROOM_FOR_STRIP);
                }
            }
        }
    }
}
