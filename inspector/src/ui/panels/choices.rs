//! The first screen of `raystep report`: which choice is fastest, what it costs, and what it gets wrong.
//!
//! Touches: asks.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use egui::text::LayoutJob;
use egui::{Align, Button, DragValue, Grid, Layout, ScrollArea, TextFormat, TextStyle, Ui};
use raystep_kernels::{Device, GridSize};
use raystep_lab::Hash;
use raystep_lab::machine::now_ns;
use raystep_lab::report::{self, Answer, Extent};
use raystep_lab::reporter::Reporter;
use raystep_lab::subject::Subject;
use raystep_scenes::Scene;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use crate::command::Command;
use crate::session::Model;
use crate::session::measure::Measurement;
use crate::session::request::{Job, JobContext, Request, answered, job};
use crate::settings::{DeviceKind, View};
use crate::ui::host::FileToSave;
use crate::ui::pane::{Context, NO_RAYS, Panel};
use crate::ui::picture;
use crate::ui::style::strong;

/// The engine's job, named while it runs.
const MEASURING: &str = "measuring choices";

const ABOUT: &str = "Traces this view with every structure, schedule and set of rules in turn, and compares the hits \
                     with exact ones. Stepping waits until it is over; Escape cancels it.";

const THOROUGH: &str = "192 × 192 rays and more runs instead of 128 × 128: narrower intervals.";

const SECONDS: &str = "About how long choices, and then rules, may take. Slow choices run once or are left out.";

/// What may be asked for, in seconds.
const RANGE: std::ops::RangeInclusive<u32> = 2..=600;

/// Width from which two diagrams stand side by side.
const SIDE_BY_SIDE: f32 = 1100.0;

/// What was measured.
#[derive(Clone)]
struct Of {
    scene: Arc<Scene>,
    view: View,
    size: [u32; 2],
    grid: GridSize,
    device: DeviceKind,
}

impl Of {
    fn new(model: &Model) -> Option<Self> {
        let opened = model.opened.as_ref()?;
        let settings = &opened.settings;
        let scene = opened.scene.clone();
        Some(Self {
            scene,
            view: settings.view,
            size: settings.size,
            grid: settings.choices.grid,
            device: settings.device,
        })
    }

    /// Whether it is of the same scene, and whether everything else is the same, too.
    fn is(&self, other: &Self) -> [bool; 2] {
        let is_scene = Arc::ptr_eq(&self.scene, &other.scene);
        let is_rest =
            (self.view, self.size, self.grid, self.device) == (other.view, other.size, other.grid, other.device);
        [is_scene, is_scene && is_rest]
    }
}

/// What is asked for.
#[derive(Clone, Copy, Deserialize, PartialEq, Serialize, SmartDefault)]
struct Asked {
    is_thorough: bool,
    #[default(report::SECONDS[0])]
    seconds: u32,
}

/// An answer as far as it is known, from the engine's task.
type SoFar = Arc<Mutex<Option<(Of, Answer)>>>;

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct Choices {
    asked: Asked,
    answer: Option<(Of, Answer)>,
    so_far: SoFar,
}

/// Passes progress on to the engine, and its wish to stop back.
struct Teller<'a>(Mutex<Progress<'a>>);

struct Progress<'a> {
    tell: &'a mut (dyn FnMut(u64, u64) -> bool + Send),
    /// What was last told: runs done, of all.
    last: (u64, u64),
}

impl<'a> Teller<'a> {
    fn lock(&self) -> MutexGuard<'_, Progress<'a>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Reporter for Teller<'_> {
    fn stage(&self, _name: &str) {
        self.lock().last = (0, 0);
    }

    fn part(&self, _what: &str, done: u64, of: u64) {
        self.lock().last = (done, of);
    }

    fn note(&self, _text: &str) {}

    fn is_cancelled(&self) -> bool {
        let mut progress = self.lock();
        let (done, of) = progress.last;
        !(progress.tell)(done, of)
    }
}

fn job(of: Of, asked: Asked, so_far: SoFar) -> Job {
    job!(context, {
        let JobContext { measure, progress, device, .. } = context;
        let device = match device {
            Device::CpuF64(clock) => Device::Cpu(clock),
            // Most choices need compute shaders.
            Device::Gpu(gpu) if !gpu.computes => Device::Cpu(Some(now_ns)),
            device => device,
        };
        let Of { scene, view, size, grid, .. } = of.clone();
        let (camera, scene) = (view.camera(&scene), Scene::clone(&scene));
        let subject = Subject { scene, camera, hash: Hash::default(), file: String::new() };
        let time = Duration::from_secs(asked.seconds.into());
        let extent = Extent { size, grid, is_quick: !asked.is_thorough, time };
        let known = (of.clone(), so_far);
        let ready = Arc::new(move |answer: Answer| {
            let (of, so_far) = &known;
            *so_far.lock().unwrap_or_else(PoisonError::into_inner) = Some((of.clone(), answer));
        });
        let measurement = Measurement { subject, extent, ready, device };
        let teller = Teller(Mutex::new(Progress { tell: progress, last: (0, 0) }));
        let answer = measure(measurement, &teller).await?;
        answered((of, answer))
    })
}

impl Panel for Choices {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let so_far = self.so_far.lock().unwrap_or_else(PoisonError::into_inner).take();
        self.answer = so_far.or(self.answer.take());
        while let Some(answer) = cx.model.take_answer::<(Of, Answer)>(MEASURING) {
            self.answer = Some(*answer);
        }
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let Some(now) = Of::new(cx.model) else {
            ui.weak("Open a scene to find out which structure, schedule and rules suit it.");
            return;
        };
        let [is_scene, is_same] = self.answer.as_ref().map_or([true; 2], |(of, _)| of.is(&now));
        if !is_scene {
            self.answer = None;
        }
        ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            self.tools(ui, cx, is_same);
            match &self.answer {
                Some((_, answer)) => show(ui, answer),
                None => drop(ui.label(
                    "Which structure, schedule and rules are fastest for this view, and how often is each wrong?",
                )),
            }
        });
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.asked).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        let asked: Asked = serde_json::from_str(saved).unwrap_or_default();
        self.asked = Asked { seconds: asked.seconds.clamp(*RANGE.start(), *RANGE.end()), ..asked };
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if command == Command::Measure
            && let Some(of) = Of::new(cx.model)
        {
            cx.model.ask(Request::Job(MEASURING, job(of, self.asked, self.so_far.clone())));
        }
        command == Command::Measure
    }
}

impl Choices {
    fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>, is_same: bool) {
        ui.horizontal_wrapped(|ui| {
            if ui.add_enabled(!cx.model.is_busy(), Button::new("Measure")).on_hover_text(ABOUT).clicked() {
                cx.asks.commands.push(Command::Measure);
            }
            let asked = &mut self.asked;
            if ui.checkbox(&mut asked.is_thorough, "thorough").on_hover_text(THOROUGH).changed() {
                asked.seconds = report::SECONDS[usize::from(asked.is_thorough)];
            }
            ui.add(DragValue::new(&mut asked.seconds).range(RANGE).suffix(" s")).on_hover_text(SECONDS);
            let Some((_, answer)) = &self.answer else { return };
            ui.menu_button("Save", |ui| {
                for (name, bytes) in &answer.files {
                    if ui.button(name).clicked() {
                        let holds = "measured choices".to_owned();
                        cx.asks.files.push(FileToSave { name: name.clone(), bytes: bytes.clone(), holds });
                    }
                }
            });
            if !is_same {
                ui.label("measured with another view, grid or device");
            }
        });
    }
}

fn show(ui: &mut Ui, answer: &Answer) {
    for sentence in &answer.sentences {
        ui.label(layout(ui, sentence));
        ui.add_space(4.0);
    }
    let width = ui.available_width();
    if width >= SIDE_BY_SIDE && answer.figures.len() > 1 {
        let count = answer.figures.len();
        ui.columns(count, |columns| {
            columns.iter_mut().zip(&answer.figures).for_each(|(ui, figure)| drawn(ui, figure));
        });
    } else {
        answer.figures.iter().for_each(|figure| drawn(ui, figure));
    }
    table(ui, answer);
    for note in &answer.notes {
        ui.label(note);
    }
}

fn drawn(ui: &mut Ui, (picture, caption): &(raystep_lab::plots::picture::Picture, String)) {
    picture::show(ui, picture, caption);
    ui.add(egui::Label::new(egui::RichText::new(caption).small()).wrap());
    ui.add_space(4.0);
}

/// A sentence, with what is emphasised in strong text.
fn layout(ui: &Ui, sentence: &[(String, bool)]) -> LayoutJob {
    let font = TextStyle::Body.resolve(ui.style());
    let mut job = LayoutJob::default();
    for (text, is_strong) in sentence {
        let color = if *is_strong { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
        job.append(text, 0.0, TextFormat::simple(font.clone(), color));
    }
    job
}

/// Names to the left, numbers to the right.
fn table(ui: &mut Ui, answer: &Answer) {
    ScrollArea::horizontal().id_salt("choices").show(ui, |ui| {
        Grid::new("choices").striped(true).num_columns(answer.columns.len() + 1).spacing([16.0, 3.0]).show(ui, |ui| {
            for (i, name) in answer.columns.iter().enumerate() {
                aligned(ui, i, |ui| strong(ui, *name));
            }
            ui.label("");
            ui.end_row();
            for row in &answer.rows {
                for (i, cell) in row.iter().enumerate() {
                    aligned(ui, i, |ui| ui.label(cell));
                }
                // The last cell takes all the width that is left.
                ui.label("");
                ui.end_row();
            }
        });
    });
}

fn aligned(ui: &mut Ui, column: usize, add: impl FnOnce(&mut Ui) -> egui::Response) {
    let layout = if column == 0 { Layout::left_to_right(Align::Center) } else { Layout::right_to_left(Align::Center) };
    ui.with_layout(layout, add);
}
