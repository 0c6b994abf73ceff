//! Two runs of the same scene side by side: the same stream, the same ray, and the difference.
//!
//! Touches: other, selection, asks.

mod counted;
mod settings;

use crate::ui::panels::zoom::{Placed, Zoom};
use egui::{Color32, ComboBox, Rect, Sense, Stroke, Ui, vec2};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::tables::state::States;
use raystep_kernels::{Stream, StreamData};
use raystep_lab::text::counted;
use smart_default::SmartDefault;

use crate::command::Command;
use crate::draw::stream::{self, Colors, Meaning};
use crate::session::request::Request;
use crate::session::{Model, Target};
use crate::settings::Settings;
use crate::ui::canvas::{Moment, Picture, Still};
use crate::ui::pane::{Context, NO_RAYS, Panel};
use counted::{COUNTING, Counted, Question};
use settings::{edit, text_of};

/// What a side shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    A,
    B,
    Difference,
}

/// The inputs that the pictures were drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drawn {
    runs: [Moment; 2],
    stream: Stream,
    layer: usize,
    range: [f32; 2],
    size: [u32; 2],
    is_swapped: bool,
}

/// The comparison.
#[derive(SmartDefault)]
pub(in crate::ui) struct Compare {
    #[default(streams::HIT)]
    stream: Stream,
    #[default(2)]
    layer: usize,
    pictures: [Picture; 3],
    stills: [Still; 2],
    drawn: [Option<Drawn>; 3],
    /// What the second run's stream was read for, what the first run's engine counts, and the result.
    reading: Option<Question>,
    counting: Option<Question>,
    found: Option<Counted>,
}

impl Panel for Compare {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let (model, selection, asks) = (&mut *cx.model, &mut *cx.selection, &mut *cx.asks);
        let Some(other) = cx.other.as_deref_mut() else {
            ui.weak("a second run of the same scene, beside this one");
            if ui.add_enabled(model.opened.is_some(), egui::Button::new(Command::Compare.name())).clicked() {
                asks.commands.push(Command::Compare);
            }
            return;
        };
        let (Some(a), Some(b)) = (model.opened.clone(), other.opened.clone()) else {
            if other.is_busy() {
                ui.spinner();
            } else {
                ui.label("the second run could not be prepared; see the log");
            }
            if ui.button(Command::EndCompare.name()).clicked() {
                asks.commands.push(Command::EndCompare);
            }
            return;
        };
        ui.horizontal_wrapped(|ui| {
            ui.strong("A").on_hover_text("the run shown in all other panels");
            ui.label(text_of(&a.settings));
            ui.separator();
            ui.strong("B");
            if let Some(settings) = edit(ui, &b.settings) {
                other.ask(Request::Plan(Box::new(settings)));
                other.ask(Request::Step(Target::End));
                if let Some(pixel) = selection.pixel {
                    other.ask(Request::Follow(pixel));
                }
            }
            if ui.button("End").on_hover_text(Command::EndCompare.name()).clicked() {
                asks.commands.push(Command::EndCompare);
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("A after {}, B after {}", counted(model.place, "pass"), counted(other.place, "pass")));
            if ui.button("Run both to the end").clicked() {
                model.ask(Request::Step(Target::End));
                other.ask(Request::Step(Target::End));
            }
            if ui.button("Step both").clicked() {
                model.ask(Request::Step(Target::Next));
                other.ask(Request::Step(Target::Next));
            }
            if ui.button("Move B to A's pass").clicked() {
                other.ask(Request::Step(Target::Pass(model.place)));
            }
        });
        let has = |stream: Stream| a.plan.has_stream(stream) && b.plan.has_stream(stream);
        let streams: Vec<Stream> = a.plan.streams.iter().map(|s| s.what).filter(|&s| has(s)).collect();
        if !streams.contains(&self.stream) {
            let states = a.plan.program.state_stream().filter(|stream| streams.contains(stream));
            (self.stream, self.layer) = (states.or(streams.first().copied()).unwrap_or(self.stream), 0);
        }
        self.choose_stream(ui, &streams);
        let seen = |settings: &Settings| (settings.size, settings.view, settings.ray);
        if seen(&a.settings) != seen(&b.settings) {
            ui.label("the runs have different views");
            if ui.button("Use A's view for B").clicked() {
                let Settings { size, view, ray, .. } = a.settings.clone();
                other.ask(Request::Plan(Box::new(Settings { size, view, ray, ..b.settings.clone() })));
                other.ask(Request::Step(Target::End));
                if let Some(pixel) = selection.pixel {
                    other.ask(Request::Follow(pixel));
                }
            }
            return;
        }
        self.count(model, other);
        if let Some(found) = &self.found {
            for line in &found.lines {
                ui.label(line);
            }
        }
        lives(ui, model.history.as_deref(), other.history.as_deref());
        let is_swapped = ui.input(|input| input.modifiers.shift) && ui.rect_contains_pointer(ui.max_rect());
        let gap = 6.0;
        let room = ui.available_size();
        let width = ((room.x - 2.0 * gap) / 3.0).max(16.0);
        let size = vec2(width, (room.y - 18.0).max(16.0));
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = gap;
            for (i, side) in [Side::A, Side::B, Side::Difference].into_iter().enumerate() {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    let shown = match (side, is_swapped) {
                        (Side::A, true) => Side::B,
                        (Side::B, true) => Side::A,
                        (side, _) => side,
                    };
                    let name = match shown {
                        Side::A => format!("A: {}", a.settings.choices.accelerator),
                        Side::B => format!("B: {}", b.settings.choices.accelerator),
                        Side::Difference => self.legend(),
                    };
                    ui.small(name).on_hover_text("hold Shift to show the other run here");
                    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
                    let plan = [a.plan.width, a.plan.height];
                    let picture = self.draw(ui, cx.canvas, model, other, shown, i, rect, plan);
                    let texel = response.hover_pos().and_then(|at| picture.texel(at));
                    if let Some(texel) = texel {
                        selection.hovered = Some(texel);
                        if response.clicked() {
                            asks.select = Some(texel);
                        }
                    }
                    picture.mark(ui, selection.hovered, 7.0, Stroke::new(1.5, Color32::from_white_alpha(140)));
                    picture.mark(ui, selection.pixel, 7.0, Stroke::new(1.5, Color32::WHITE));
                    let text = format!(
                        "{} of {}",
                        self.stream.name(),
                        match shown {
                            Side::A => "run A",
                            Side::B => "run B",
                            Side::Difference => "difference",
                        }
                    );
                    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
                });
            }
        });
    }
}

/// The history of the ray in both runs, one line each.
fn lives(ui: &mut Ui, a: Option<&Trace>, b: Option<&Trace>) {
    let line = |history: &Trace| {
        let of = |part: &str| history.rows.iter().filter(|row| row.kernel.starts_with(part)).count();
        let tests = history.rows.iter().filter(|row| row.tested.is_some()).count();
        let hit = history.rows.last().and_then(|row| row.after.triangle.zip(row.after.t));
        let hit = hit.map_or_else(
            || "hits nothing".into(),
            |(id, t)| format!("hits triangle {id} at t {} scene units", f64::from(t) * history.t_scale),
        );
        format!(
            "{}, {} tested, {}: {hit}",
            counted(of("traverse"), "step"),
            counted(tests, "triangle"),
            counted(history.rows.len(), "pass")
        )
    };
    for (name, history) in [("A", a), ("B", b)] {
        if let Some(history) = history {
            let [x, y] = history.pixel;
            ui.small(format!("{name}: ray {x},{y}: {}", line(history)));
        }
    }
}

impl Compare {
    /// The range shared by both pictures.
    fn range(&self) -> [f32; 2] {
        self.found.as_ref().map_or([0.0, 1.0], |found| found.range)
    }

    /// The meaning of the difference's colours.
    fn legend(&self) -> String {
        match Meaning::of(self.stream, Some(self.layer)) {
            Meaning::Scalar | Meaning::Count => format!("A − B, from −{0:.1e} to {0:.1e}", self.spread()),
            _ => "where A and B differ".into(),
        }
    }

    /// The largest difference with a colour of its own: for counts a tenth of their range, for floats a thousandth.
    fn spread(&self) -> f32 {
        let part = if Meaning::of(self.stream, Some(self.layer)) == Meaning::Count { 0.1 } else { 1e-3 };
        let [lo, hi] = self.range();
        (hi - lo).abs().max(f32::MIN_POSITIVE) * part
    }

    fn choose_stream(&mut self, ui: &mut Ui, streams: &[Stream]) {
        ui.horizontal_wrapped(|ui| {
            let shown = ComboBox::from_id_salt("compared stream").selected_text(self.stream.name());
            let response = shown.show_ui(ui, |ui| {
                for &choice in streams {
                    if ui.selectable_label(choice == self.stream, choice.name()).clicked() {
                        (self.stream, self.layer) = (choice, 0);
                    }
                }
            });
            response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "compared stream"));
            self.layer = self.layer.min(self.stream.layers() - 1);
            for (i, name) in self.stream.info().layers.iter().enumerate() {
                ui.selectable_value(&mut self.layer, i, *name);
            }
        });
    }

    /// Compares both streams once per pair of places: the second run's is read, and the first run's engine counts.
    fn count(&mut self, model: &mut Model, other: &mut Model) {
        let moments = [(model.edition, model.place), (other.edition, other.place)];
        let question = (moments, self.stream, self.layer);
        while let Some(counted) = model.take_answer::<Counted>(COUNTING) {
            self.found = Some(*counted);
        }
        let is_known = self.found.as_ref().is_some_and(|found| found.question == question);
        if is_known || self.counting == Some(question) || model.is_busy() || other.is_busy() {
            return;
        }
        let read = other.texels.iter().position(|t| t.stream == self.stream && t.place == other.place);
        if let Some(read) = read {
            let texels = other.texels.swap_remove(read);
            let [_, _, width, height] = texels.region;
            let right = StreamData { stream: texels.stream, width, height, bits: texels.bits };
            model.ask(Request::Job(COUNTING, counted::job(question, right)));
            self.counting = Some(question);
        } else if self.reading != Some(question) {
            self.reading = Some(question);
            other.ask(Request::ReadAll(self.stream));
        }
    }

    #[expect(clippy::too_many_arguments)]
    fn draw(
        &mut self,
        ui: &Ui,
        canvas: &std::sync::Arc<crate::ui::canvas::Canvas>,
        model: &Model,
        other: &Model,
        side: Side,
        slot: usize,
        rect: Rect,
        plan: [u32; 2],
    ) -> Placed {
        let placed = Zoom::default().place(rect, plan);
        let size = Picture::pixels(ui, rect);
        let drawn = Drawn {
            runs: [(model.edition, model.place), (other.edition, other.place)],
            stream: self.stream,
            layer: self.layer,
            range: self.range(),
            size,
            is_swapped: side == Side::B,
        };
        let largest = self.spread();
        for (still, run) in self.stills.iter_mut().zip([model, other]) {
            if let Some(texture) = run.drawn(self.stream) {
                still.take(canvas, (run.edition, run.place), self.stream, texture);
            }
        }
        let of = |i: usize| self.stills[i].of(self.stream).filter(|(moment, _)| moment.0 == drawn.runs[i].0);
        let stills = of(0).zip(of(1));
        let drawn = Drawn { runs: stills.map_or(drawn.runs, |(a, b)| [a.0, b.0]), ..drawn };
        if stills.is_none() || drawn.runs != [(model.edition, model.place), (other.edition, other.place)] {
            ui.ctx().request_repaint();
        }
        let target = self.pictures[slot].target(canvas, size, self.drawn[slot] != Some(drawn));
        if let Some((((_, a), (_, b)), target)) = stills.zip(target) {
            let is_difference = side == Side::Difference;
            let meaning = Meaning::of(self.stream, Some(self.layer));
            let states = model.opened.as_ref().map_or(States(&[]), |opened| opened.plan.program.states);

            let picture = stream::Picture {
                stream: self.stream,
                states,
                texture: if side == Side::B { b } else { a },
                minus: is_difference.then_some(b),
                layer: self.layer,
                meaning,
                range: if is_difference { [-largest, largest] } else { drawn.range },
                exposure: 1.0,
                colors: if is_difference { Colors::Diverging } else { Colors::Viridis },
                offset: placed.offset(ui),
                scale: placed.scale * ui.pixels_per_point(),
            };
            canvas.streams.draw(&picture, target);
            self.drawn[slot] = Some(drawn);
        }
        self.pictures[slot].show(ui, rect);
        placed
    }
}
