//! The toolbar: stream, component, colours, range, and their legend.

use egui::{Color32, Label, Rect, RichText, Sense, pos2, vec2};
use raystep_kernels::tables::state::Tag;
use raystep_kernels::tables::stream::Meaning as StreamMeaning;
use raystep_kernels::{Pass, Plan, Stream};
use raystep_lab::layer_stats::{LayerStats, Others, Span};

use super::super::legend::{Entry, line};
use super::StreamView;
use super::telling::{only_value, sentence};
use crate::draw::stream::{Colors, Meaning};
use crate::ui::choice::Choices as _;
use crate::ui::units::{Scale, exact};

impl StreamView {
    pub(super) fn tools(
        &mut self,
        ui: &mut egui::Ui,
        streams: &[Stream],
        stream: Stream,
        layer: Option<usize>,
        meaning: Meaning,
        scale: &Scale,
    ) {
        ui.horizontal_wrapped(|ui| {
            if self.pinned.is_none() {
                let combo = egui::ComboBox::from_id_salt("stream").selected_text(stream.name());
                combo
                    .show_ui(ui, |ui| {
                        for &choice in streams {
                            if ui.choice(choice == stream, choice.name()).clicked() {
                                (self.look.stream, self.look.layer, self.look.range) = (Some(choice), None, None);
                            }
                        }
                    })
                    .response
                    .widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "stream"));
            }
            let names = stream.info().layers;
            if stream.is_color() && ui.choice(layer.is_none(), "rgb").clicked() {
                (self.look.layer, self.look.range) = (None, None);
            }
            for (i, name) in names.iter().enumerate() {
                let is_shown = layer == Some(i) || layer.is_none() && i == 0 && !stream.is_color();
                if ui.choice(is_shown, *name).clicked() {
                    (self.look.layer, self.look.range) = (Some(i), None);
                }
            }
            if matches!(meaning, Meaning::Scalar | Meaning::Count) {
                let now = self.colors(stream, layer.unwrap_or(0));
                egui::ComboBox::from_id_salt("colors")
                    .selected_text(now.name())
                    .width(80.0)
                    .show_ui(ui, |ui| {
                        for choice in Colors::ALL {
                            if ui.choice(choice == now, choice.name()).clicked() {
                                self.look.colors = Some(choice);
                            }
                        }
                    })
                    .response
                    .widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "colours"));
                self.range_fields(ui, in_units(stream, layer.unwrap_or(0), scale));
            }
            if meaning == Meaning::Color {
                let label = ui.label("exposure").id;
                let value = egui::DragValue::new(&mut self.look.exposure).speed(0.02).range(1e-6..=1e6);
                ui.add(value).labelled_by(label);
            }
            let zoom = self.look.zoom.scale.map_or_else(|| "fit".into(), |s| format!("{:.0}%", s * 100.0));
            if ui.button(zoom).on_hover_text("fit to panel (F, double click)").clicked() {
                self.look.zoom.fit();
            }
        });
    }

    /// The ends of the range, as multiples of a unit.
    fn range_fields(&mut self, ui: &mut egui::Ui, (unit, name): (f64, &str)) {
        let mut range = self.range();
        let speed = unit * f64::from((range[1] - range[0]).abs().max(1e-6)) / 100.0;
        for (i, label) in ["from", "to"].into_iter().enumerate() {
            let label = ui.label(label).id;
            let end = &mut range[i];
            let value = egui::DragValue::from_get_set(|new| {
                if let Some(new) = new {
                    *end = (new / unit) as f32;
                }
                unit * f64::from(*end)
            });
            let value = ui.add(value.speed(speed).max_decimals(4)).labelled_by(label).on_hover_text(name);
            if value.changed() {
                self.look.range = Some(range);
            }
        }
    }

    /// Legend of the colours, and counts of special values.
    pub(super) fn legend(
        &self,
        ui: &mut egui::Ui,
        plan: &Plan,
        (stream, layer): (Stream, usize),
        meaning: Meaning,
        scale: &Scale,
        (now, last): (usize, Option<&Pass>),
    ) {
        // Of an earlier place, one value would be a lie.
        let known = self.stats.as_ref().filter(|(_, place, of, l, _)| (*place, *of, *l) == (now, stream, layer));
        let is_there = |tag: Tag| last.and_then(|pass| pass.counts.get(tag as usize)).is_some_and(|&rays| rays > 0);
        ui.horizontal_wrapped(|ui| {
            if meaning == Meaning::Tag {
                let only = known.and_then(|(.., stats)| only_value(stats)?);
                let states = plan.program.states.iter().filter(|state| plan.has_state(state));
                let states = states.filter(|state| only.is_none_or(|only| f64::from(state.tag) == only));
                let entries = states.map(|state| {
                    let [r, g, b] = state.colour;
                    let name = only.map_or_else(|| state.name.into(), |_| sentence(state.name));
                    Entry::new(Color32::from_rgb(r, g, b), name, state.meaning).unless(is_there(state.tag))
                });
                line(ui, &entries.collect::<Vec<_>>());
                return;
            }
            let (unit, name) = in_units(stream, layer, scale);
            let mut texts = Vec::new();
            if matches!(meaning, Meaning::Scalar | Meaning::Count) {
                let (rect, response) = ui.allocate_exact_size(vec2(120.0, 10.0), Sense::hover());
                let colors = self.colors(stream, layer);
                for i in 0..60 {
                    let [r, g, b] = colors.at(f64::from(i) / 59.0);
                    let left = rect.left() + 2.0 * i as f32;
                    let bar = Rect::from_min_size(pos2(left, rect.top()), vec2(2.5, rect.height()));
                    ui.painter().rect_filled(bar, 0.0, Color32::from_rgb(r, g, b));
                }
                if let Some(span) = self.stats.as_ref().and_then(|(.., stats)| stats.span.as_ref()) {
                    response.on_hover_ui(|ui| histogram(ui, span, unit));
                }
                let [lo, hi] = self.range().map(|end| exact(unit * f64::from(end)));
                texts.push(format!("{lo} … {hi} {name}"));
            } else {
                texts.push(stream.info().unit.into());
            }
            if let Some((.., stats)) = &self.stats {
                texts.extend(out_of_the_ordinary(stats));
            }
            if let Some((.., stats)) = known.filter(|_| meaning != Meaning::Color) {
                let text = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| exact(unit * value));
                texts.extend(only_value(stats).map(|only| sentence(&text(only))));
            }
            ui.add(Label::new(RichText::new(texts.join("   ")).small()).truncate());
        });
    }
}

/// What a component is a multiple of, and its name.
fn in_units(stream: Stream, layer: usize, scale: &Scale) -> (f64, &'static str) {
    let (info, unit) = (stream.info(), stream.info().unit);
    // A unit for each component, or one for all of them.
    let own = unit.split(", ").nth(layer).filter(|_| unit.split(", ").count() == info.layers.len());
    match info.meaning.get(layer) {
        Some(StreamMeaning::Distance) => (scale.t64(1.0), scale.units.t_name()),
        _ => (1.0, own.unwrap_or(unit)),
    }
}

/// Counts of values that are outside the colour map.
fn out_of_the_ordinary(stats: &LayerStats) -> Vec<String> {
    let counts: &[(u64, &str)] = match stats.others {
        Others::Float { nan, pos_inf, neg_inf, at_inf } => {
            &[(nan, "NaN"), (pos_inf, "+Inf"), (neg_inf, "−Inf"), (at_inf, "never")]
        }
        Others::Integer { none, .. } => &[(none, "none")],
    };
    counts.iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}")).collect()
}

/// Histogram of the values.
fn histogram(ui: &mut egui::Ui, span: &Span, unit: f64) {
    let (rect, _) = ui.allocate_exact_size(vec2(256.0, 72.0), Sense::hover());
    let most = span.histogram.iter().copied().max().unwrap_or(0).max(1) as f32;
    let width = rect.width() / span.histogram.len().max(1) as f32;
    for (i, &count) in span.histogram.iter().enumerate().filter(|(_, count)| **count > 0) {
        // A few rays must remain visible.
        let height = (count as f32 / most * rect.height()).max(1.0);
        let left = rect.left() + i as f32 * width;
        let bar = Rect::from_min_max(pos2(left, rect.bottom() - height), pos2(left + width, rect.bottom()));
        ui.painter().rect_filled(bar, 0.0, ui.visuals().text_color());
    }
    let number = |value: f64| exact(unit * value);
    let [first, median, last] = span.percentiles.map(number);
    ui.small(format!("from {} to {}", number(span.min), number(span.max)));
    ui.small(format!("1% up to {first}, median {median}, 99% up to {last}"));
}
