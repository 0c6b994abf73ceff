//! Two runs of the same scene side by side: the same stream, the same ray, and the difference.
//!
//! Touches: other, selection, asks.

mod counted;
mod pictures;
mod settings;

use egui::{ComboBox, Ui, Vec2, vec2};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Stream, StreamData};
use raystep_lab::text::counted;
use smart_default::SmartDefault;

use crate::command::Command;
use crate::runs::differ::next_ray;
use crate::session::request::Request;
use crate::session::{Model, Target};
use crate::settings::Settings;
use crate::ui::canvas::{Picture, Still};
use crate::ui::choice::Choices as _;
use crate::ui::pane::{Context, NO_RAYS, Panel};
use crate::ui::state::Asks;
use crate::ui::style::strong;
use counted::{COUNTING, Counted, Question};
use pictures::{Drawn, Look};
use settings::{edit, text_of};

/// The comparison.
#[derive(SmartDefault)]
pub(in crate::ui) struct Compare {
    #[default(streams::HIT)]
    stream: Stream,
    #[default(2)]
    layer: usize,
    look: Look,
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
            welcome(ui, model.opened.is_some(), asks);
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
            strong(ui, "A").on_hover_text("the run shown in all other panels");
            ui.label(text_of(&a.settings));
            ui.separator();
            strong(ui, "B");
            if let Some(settings) = edit(ui, &b.settings) {
                other.ask(Request::Plan(Box::new(settings)));
                other.ask(Request::Step(Target::End));
                if let Some(pixel) = selection.pixel {
                    other.ask(Request::Follow(pixel.into()));
                }
            }
            if ui.button(Command::EndCompare.name()).clicked() {
                asks.commands.push(Command::EndCompare);
            }
        });
        let has = |stream: Stream| a.plan.has_stream(stream) && b.plan.has_stream(stream);
        let streams: Vec<Stream> = a.plan.streams.iter().map(|s| s.what).filter(|&s| has(s)).collect();
        if !streams.contains(&self.stream) {
            let states = a.plan.program.state_stream().filter(|stream| streams.contains(stream));
            (self.stream, self.layer) = (states.or(streams.first().copied()).unwrap_or(self.stream), 0);
        }
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
            ui.separator();
            self.choose_stream(ui, &streams);
        });
        let seen = |settings: &Settings| (settings.size, settings.view, settings.ray);
        if seen(&a.settings) != seen(&b.settings) {
            ui.label("the runs have different views");
            if ui.button("Use A's view for B").clicked() {
                let Settings { size, view, ray, .. } = a.settings.clone();
                other.ask(Request::Plan(Box::new(Settings { size, view, ray, ..b.settings.clone() })));
                other.ask(Request::Step(Target::End));
                if let Some(pixel) = selection.pixel {
                    other.ask(Request::Follow(pixel.into()));
                }
            }
            return;
        }
        self.count(model, other);
        if let Some(found) = &self.found {
            let sentence = strong(ui, &found.sentence);
            if !found.lines.is_empty() {
                sentence.on_hover_text(found.lines.join("\n"));
            }
        }
        lives(ui, model.history.as_deref(), other.history.as_deref());
        self.views(ui, asks);
        let names = [&a.settings, &b.settings].map(|settings| settings.choices.accelerator.to_string());
        self.pictures(ui, cx, &names, [a.plan.width, a.plan.height]);
    }

    fn least(&self) -> Vec2 {
        // Pictures below what is said of them.
        vec2(360.0, 380.0)
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        let look: Look = serde_json::from_str(saved).unwrap_or_default();
        self.look = Look { zoom: look.zoom.finite(), ..look };
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        match (command, &self.found) {
            (Command::NextDifferingRay, Some(found)) => {
                cx.asks.select = next_ray(&found.rays, found.width, cx.selection.pixel).or(cx.asks.select);
                true
            }
            (Command::Fit, _) => {
                self.look.zoom.fit();
                true
            }
            _ => false,
        }
    }
}

/// In the middle of an empty panel: what is compared, and how to begin.
fn welcome(ui: &mut Ui, has_scene: bool, asks: &mut Asks) {
    ui.add_space((ui.available_height() * 0.35).max(0.0));
    ui.vertical_centered(|ui| {
        ui.label("Run the scene a second time with other options, and see where the results differ.");
        ui.add_space(6.0);
        if ui.add_enabled(has_scene, egui::Button::new(Command::Compare.name())).clicked() {
            asks.commands.push(Command::Compare);
        }
    });
}

/// The history of the ray in both runs, on one line.
fn lives(ui: &mut Ui, a: Option<&Trace>, b: Option<&Trace>) {
    let line = |history: &Trace| {
        let of = |part: &str| history.rows.iter().filter(|row| row.kernel.starts_with(part)).count();
        let tests = history.rows.iter().filter(|row| row.tested.is_some()).count();
        let hit = history.rows.last().and_then(|row| row.after.triangle.zip(row.after.t));
        let hit = hit.map_or_else(
            || "hits nothing".into(),
            |(id, t)| {
                let t = f64::from(t) * history.t_scale;
                format!("hits triangle {id} at t {t:.*} scene units", crate::ui::units::decimals(t.abs()))
            },
        );
        format!(
            "{}, {} tested, {}: {hit}",
            counted(of("traverse"), "step"),
            counted(tests, "triangle"),
            counted(history.rows.len(), "pass")
        )
    };
    let lives = [("A", a), ("B", b)].map(|(name, history)| {
        let history = history?;
        Some(format!("{name}: ray of {}: {}", history.name(), line(history)))
    });
    let lives: Vec<String> = lives.into_iter().flatten().collect();
    if !lives.is_empty() {
        ui.small(lives.join("   "));
    }
}

impl Compare {
    fn choose_stream(&mut self, ui: &mut Ui, streams: &[Stream]) {
        let shown = ComboBox::from_id_salt("compared stream").selected_text(self.stream.name());
        let response = shown.show_ui(ui, |ui| {
            for &choice in streams {
                if ui.choice(choice == self.stream, choice.name()).clicked() {
                    (self.stream, self.layer) = (choice, 0);
                }
            }
        });
        response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "compared stream"));
        self.layer = self.layer.min(self.stream.layers() - 1);
        for (i, name) in self.stream.info().layers.iter().enumerate() {
            ui.choice_of(&mut self.layer, i, *name);
        }
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::panels::zoom::Zoom;

    #[test]
    fn a_saved_place_that_is_not_finite_shows_all_of_the_pictures() {
        let mut panel = Compare::default();
        panel.load(r#"{"one": "A", "zoom": {"scale": 2, "center": [1e39, 0]}}"#);
        assert_eq!((panel.look.one, panel.look.zoom), (Some(pictures::Side::A), Zoom::default()));
        panel.load(r#"{"zoom": {"scale": 2, "center": [3, 4]}}"#);
        assert_eq!((panel.look.one, panel.look.zoom), (None, Zoom { scale: Some(2.0), center: [3.0, 4.0] }));
    }
}
