//! A stream after a pass: zoomable to single texels with their values; range, exposure, colours, component.
//!
//! Touches: selection, display, asks, runs.

mod kept;
mod look;
mod magnifier;
mod mask;
mod numbers;
mod paint;
mod telling;
mod tile;
mod tools;
mod values;

use crate::ui::panels::zoom::Zoom;
use egui::{Color32, Sense, vec2};
use look::Look;
use paint::Drawn;
use raystep_kernels::programs::own;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::stream::Meaning as StreamMeaning;
use raystep_kernels::{Kernel, Plan, Stream};
use raystep_lab::layer_stats::{LayerStats, Others};
use raystep_lab::text::counted;

use crate::command::Command;
use crate::draw::stream::{Colors, Meaning};
use crate::exports::EXPORTING;
use crate::link::{LinkStream, Shown};
use crate::session::request::Request;
use crate::session::{Pinned, Subject};
use crate::ui::canvas::{Picture, Still, png};
use crate::ui::pane::{Context, Panel};
use crate::ui::state::kept_runs::Flipped;
use crate::ui::units::Scale;

/// The smallest and the largest scale, points per texel.
const ZOOM: [f32; 2] = [0.01, 256.0];

/// A view of a stream.
#[derive(Default)]
pub(in crate::ui) struct StreamView {
    look: Look,
    picture: Picture,
    still: Still,
    drawn: Option<Drawn>,
    /// The range of the values, and which values.
    stats: Option<(u64, usize, Stream, usize, LayerStats)>,
    asked: Option<(u64, usize, Stream, usize)>,
    /// The edition and place at which all rays are in one cell or node.
    alike: Option<(u64, usize)>,
    /// A copy shown instead of the current stream.
    pinned: Option<Pinned>,
    mask: mask::Overlay,
    /// The result of a user's program, and of which generation.
    result: (u64, Option<&'static str>),
    /// A kept run shown instead of the current stream.
    kept: Option<Flipped>,
    magnifier: magnifier::Magnifier,
}

impl Panel for StreamView {
    fn title(&self) -> Option<String> {
        match &self.pinned {
            Some(pinned) => Some(format!("{} after {}", pinned.stream.name(), pinned.place)),
            None => self.look.stream.map(|stream| stream.name().into()),
        }
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        // Who has chosen a stream sees no other picture in its place.
        let may_preview = self.pinned.is_none() && self.look.stream.is_none_or(Stream::is_color);
        if let Some(preview) = cx.display.preview.as_ref().filter(|_| may_preview) {
            preview.show(ui, cx.model);
            return;
        }
        let Some(opened) = &cx.model.opened else {
            self.welcome(ui, cx);
            return;
        };
        let (plan, generation) = (opened.plan.clone(), cx.model.generation);
        let in_units = Scale::in_scene(cx.display.units, &opened.data);
        if self.pinned.as_ref().is_some_and(|pinned| pinned.generation != generation) {
            self.pinned = None;
        }
        if self.pinned.is_none()
            && let Some(show) = cx.asks.show.take()
        {
            (self.look.stream, self.look.layer, self.look.range) = (Some(show.stream.stream), show.stream.layer, None);
            let center = show.pan.unwrap_or(self.look.zoom.center);
            self.look.zoom = Zoom { scale: show.zoom, center };
        }
        let is_counted = |stream: &Stream| cx.model.texture(*stream).is_some();
        let streams: Vec<Stream> = plan.streams.iter().map(|s| s.what).filter(is_counted).collect();
        let last = cx.model.last_pass().map(|pass| pass.kernel);
        let result = self.result(cx);
        // Colours of elements with states are there when a pass has written them.
        let is_there = |stream: &Stream| {
            let writes = |kernel| plan.variant(kernel).is_some_and(|v| v.written_streams().any(|s| s == *stream));
            !stream.is_color() || plan.program.state_stream().is_none() || last.is_some_and(writes)
        };
        let result = streams.iter().copied().find(|stream| Some(stream.name()) == result && is_there(stream));
        let Some(default) = result.or_else(|| default_stream(&plan, &streams, last)) else { return };
        let telling = self.telling(&plan, &streams, default, cx.model);
        let stream = telling.map_or_else(|| self.stream(&streams, default), |(stream, _)| stream);
        cx.display.stream = Some(stream);
        if self.pinned.is_none() {
            let (zoom, pan) = (self.look.zoom.scale, Some(self.look.zoom.center));
            let shown = |stream| Shown { stream: LinkStream { stream, layer: self.look.layer }, zoom, pan };
            cx.display.shown = self.look.stream.map(shown);
        }
        let layer = self.look.layer.filter(|&l| l < stream.layers());
        let layer = layer.or(telling.and_then(|(_, layer)| layer));
        let meaning = Meaning::of(stream, layer);
        let (was, is_other) = (self.look.layer, stream != default);
        self.tools(ui, &streams, stream, layer, meaning, &in_units);
        if is_other && self.look.layer != was && self.look.stream.is_none() {
            // A component that is chosen is one of the stream in view.
            self.look.stream = Some(stream);
        }
        let stats_of = layer.unwrap_or(0);
        self.read_range(cx, stream, stats_of);
        self.find_alike(cx.model, stream, stats_of);
        let now = self.pinned.as_ref().map_or(cx.model.place, |pinned| pinned.place);
        self.legend(ui, &plan, (stream, stats_of), meaning, &in_units, (now, cx.model.last_pass()));
        mask::legend(ui, cx);
        let (rect, response) =
            ui.allocate_exact_size(ui.available_size().max(vec2(16.0, 16.0)), Sense::click_and_drag());
        self.take_kept(cx, stream);
        let texture = self.pinned.as_ref().map(|pinned| &pinned.texture).or_else(|| cx.model.texture(stream));
        let size = texture.map_or([plan.width, plan.height], |texture| [texture.width(), texture.height()]);
        // What is selected is an element of the first set, or of another one whose elements have histories, too.
        let set = stream.info().elements;
        let can_select = set == plan.program.elements[0];
        let can_follow = !can_select && plan.program.decoding_of(set).is_some();
        let texels = vec2(size[0] as f32, size[1] as f32);
        self.look.zoom.follow_within(ui, &response, rect, texels, ZOOM);
        let placed = self.look.zoom.place(rect, size);
        self.paint(ui, cx, &placed, stream, layer, meaning);
        self.mask.draw(ui, cx, &placed);
        let under = response.hover_pos().and_then(|at| placed.texel(at));
        if under.is_some() && can_select {
            cx.selection.hovered = under;
        }
        let clicked = response.interact_pointer_pos().filter(|_| response.clicked());
        let clicked = clicked.and_then(|at| placed.texel(at));
        cx.asks.select = clicked.filter(|_| can_select).or(cx.asks.select);
        let element = clicked.filter(|_| can_follow).map(|texel| Subject { set: Some(set), texel });
        cx.asks.follow = element.or(cx.asks.follow);
        numbers::draw(ui, cx, &placed, stream, self.whose(stream));
        if can_select {
            placed.mark_clearly(ui, cx.selection.pixel, Color32::WHITE);
        } else {
            let selected = cx.selection.element.filter(|element| element.set == Some(set));
            placed.mark_clearly(ui, selected.map(|element| element.texel), Color32::WHITE);
        }
        if !response.hovered() && can_select {
            placed.mark_clearly(ui, cx.selection.hovered, Color32::from_white_alpha(120));
        }
        let what = format!(
            "{}{} after {}{}",
            self.kept_label(ui, rect),
            stream.name(),
            counted(self.pinned.as_ref().map_or(cx.model.place, |p| p.place), "pass"),
            cx.selection.pixel.map_or_else(String::new, |[x, y]| format!("; pixel {x},{y}"))
        );
        let value = under.map(|texel| self.magnify(ui, cx, stream, texel, &response, &placed));
        let what = what + value.as_deref().unwrap_or_default();
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &what));
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look.clone().finite()).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        if let Ok(look) = serde_json::from_str(saved) {
            self.look = look;
        }
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        let range = self.range();
        let span = range[1] - range[0];
        match command {
            Command::ExposureUp => self.look.exposure *= 2.0,
            Command::ExposureDown => self.look.exposure /= 2.0,
            Command::OffsetUp | Command::OffsetDown => {
                let by = if command == Command::OffsetUp { 0.1 } else { -0.1 };
                if self.look.is_color(cx.display.stream) {
                    self.look.offset += by;
                } else {
                    self.look.range = Some(range.map(|v| v + by * span));
                }
            }
            Command::Normalise => self.look.range = None,
            Command::ResetRange => (self.look.range, self.look.exposure, self.look.offset) = (None, 1.0, 0.0),
            Command::Fit => self.look.zoom.fit(),
            Command::ExportTexels => self.export(cx, self.texels(cx)),
            Command::ExportView => self.export(cx, self.picture.texture().cloned()),
            Command::Pin => {
                if let Some(stream) = cx.display.stream {
                    cx.model.ask(Request::Pin(stream));
                }
            }
            _ => return false,
        }
        true
    }
}

/// The stream that is shown if none was chosen, in a program that does not name its result: the image once it is shaded, before that the rays' states; in a program
/// without states the last stream that the last pass has written.
fn default_stream(plan: &Plan, streams: &[Stream], last: Option<Kernel>) -> Option<Stream> {
    let own = match plan.program.state_stream() {
        Some(_) if last.is_some_and(|kernel| kernel.role() == Role::Finish) => {
            streams.iter().copied().find(|stream| stream.is_color())
        }
        Some(states) => Some(states),
        None => last.and_then(|kernel| plan.variant(kernel)?.written_streams().last()),
    };
    own.filter(|stream| streams.contains(stream)).or(streams.first().copied())
}

impl StreamView {
    /// The name of the stream that a user's program calls its result: read once for each run.
    fn result(&mut self, cx: &Context<'_>) -> Option<&'static str> {
        if self.result.0 != cx.model.generation {
            let folder = cx.model.opened.as_ref().and_then(|opened| opened.settings.folder.as_ref());
            let result = folder.and_then(|folder| own::read(folder).ok()?.result);
            self.result = (cx.model.generation, result.map(|result| result.stream.name()));
        }
        self.result.1
    }

    fn export(&self, cx: &mut Context<'_>, picture: Option<wgpu::Texture>) {
        if let Some(picture) = picture {
            let name = self.title().unwrap_or_else(|| "Stream".into());
            cx.model.ask(Request::Job(EXPORTING, png(cx.canvas, &picture, name)));
        }
    }

    /// A view of a copy.
    pub(in crate::ui) fn pinned(copy: Pinned) -> Self {
        let look = Look { stream: Some(copy.stream), ..Look::default() };
        Self { look, pinned: Some(copy), ..Self::default() }
    }

    fn welcome(&self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        if cx.model.is_busy() {
            ui.centered_and_justified(|ui| ui.spinner());
            return;
        }
        ui.vertical_centered(|ui| {
            ui.add_space(ui.available_height() * 0.25);
            ui.heading("raystep");
            ui.label("Drop a scene file here, or");
            if ui.button(Command::OpenScene.name()).clicked() {
                cx.asks.commands.push(Command::OpenScene);
            }
            if let Some(link) = &cx.display.last_place
                && ui.button("Resume where you left off").on_hover_text(link).clicked()
            {
                cx.asks.visit = Some(link.clone());
            }
            if !cx.display.recent.is_empty() {
                ui.add_space(8.0);
                ui.weak("recent");
            }
            for path in cx.display.recent.iter().take(5) {
                if ui.link(path).clicked() {
                    cx.asks.open = Some(path.clone());
                }
            }
            ui.add_space(8.0);
            ui.weak("or start with a lesson");
            for index in 0..crate::lesson::built_in::LESSONS.len() {
                let lesson = Command::Lesson(index);
                if ui.link(lesson.name().trim_start_matches("Lesson: ")).clicked() {
                    cx.asks.commands.push(lesson);
                }
            }
        });
    }

    fn stream(&self, streams: &[Stream], default: Stream) -> Stream {
        let wanted = match (&self.pinned, self.look.stream) {
            (Some(pinned), _) => Some(pinned.stream),
            (None, chosen) => chosen,
        };
        wanted.filter(|s| streams.contains(s)).unwrap_or(default)
    }

    fn colors(&self, stream: Stream, layer: usize) -> Colors {
        self.look.colors.unwrap_or(match stream.info().meaning.get(layer) {
            Some(StreamMeaning::Distance) => Colors::Magma,
            _ => Colors::Viridis,
        })
    }

    /// The effective range.
    fn range(&self) -> [f32; 2] {
        let from_values = || self.stats.as_ref().map_or([0.0, 1.0], |(.., stats)| view_range(stats));
        self.look.range.unwrap_or_else(from_values)
    }

    /// Requests values when they have changed, and takes their range once they arrive.
    fn read_range(&mut self, cx: &mut Context<'_>, stream: Stream, layer: usize) {
        let (edition, place) = (cx.model.edition, cx.model.place);
        let is_dragging = cx.asks.scrub.wanted().is_some();
        let is_known = self.pinned.is_some() || self.asked == Some((edition, place, stream, layer));
        if !is_known && !is_dragging && !cx.model.is_busy() {
            self.asked = Some((edition, place, stream, layer));
            cx.model.ask(Request::Count(stream, layer));
        }
        let is_shown = |place: usize| self.pinned.as_ref().is_none_or(|pinned| pinned.place == place);
        let read = cx.model.texels.iter().find(|t| t.stream == stream && is_shown(t.place));
        if let Some(texels) = read {
            let known = self.stats.as_ref().map(|(g, p, s, l, _)| (*g, *p, *s, *l));
            let now = (edition, texels.place, stream, layer);
            if known != Some(now) {
                // Counting a large stream takes longer than a frame, so the engine does it, except for a copy, which is
                // counted once.
                let counted = texels.counted.as_ref().filter(|(counted, _)| *counted == layer).map(|(_, s)| s.clone());
                let count = || LayerStats::of(stream, layer, texels.layer(layer));
                let stats = counted.or_else(|| self.pinned.is_some().then(count));
                if let Some(stats) = stats {
                    self.stats = Some((now.0, now.1, now.2, now.3, stats));
                }
            }
        }
    }
}

/// From the first to the last percentile for floats; the full range for counts.
fn view_range(stats: &LayerStats) -> [f32; 2] {
    let Some(span) = &stats.span else { return [0.0, 1.0] };
    let [first, _, last] = span.percentiles;
    let is_float = matches!(stats.others, Others::Float { .. });
    let (lo, hi) = if is_float && first < last { (first, last) } else { (span.min, span.max) };
    [lo as f32, hi as f32]
}
