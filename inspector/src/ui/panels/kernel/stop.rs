//! A line to stop at, with a condition: which elements of a pass come to it, and in which pass the first one does.

use std::sync::Arc;

use egui::TextEdit;
use raystep_kernels::Kernel;
use raystep_kernels::shader::{FileLine, Sourced, Stop};
use raystep_lab::passed::Code;
use raystep_lab::stops::{self, Outcome, StopsError, Told};

use crate::session::Model;
use crate::session::request::{Job, JobContext, Opened, Request, answered, flow, job};
use crate::source;
use crate::ui::mask::Mask;
use crate::ui::pane::Context;
use crate::ui::style::strong;

/// The name of looking for elements that stop.
const LOOKING: &str = "looking for elements that stop";
/// Elements that are shown.
const MOST_SHOWN: usize = 6;

/// A line and a condition, for the interpreter.
struct Asked {
    of: Sourced,
    at: FileLine,
    when: Option<String>,
    names: Vec<String>,
    code: Code,
}

/// What was found, of this generation and edition.
struct Found {
    run: (u64, u64),
    asked: Arc<Asked>,
    outcome: Result<Outcome, String>,
}

/// What is told of it.
struct Answer {
    run: (u64, u64),
    text: String,
    /// The first elements: their names, columns and rows, and values.
    elements: Vec<(String, [u32; 2], String)>,
    more: usize,
}

/// The fields, and what was found last.
#[derive(Default)]
pub(super) struct StopAt {
    line: String,
    when: String,
    answer: Option<Answer>,
    /// Why the fields cannot be used.
    wrong: Option<String>,
}

impl StopAt {
    /// Stops at a line of the composed source, from 0.
    pub(super) fn choose(&mut self, model: &Model, kernel: Kernel, line: usize) {
        let Some(opened) = &model.opened else { return };
        let Some(variant) = opened.plan.variant(kernel) else { return };
        let Ok(Some(of)) = opened.plan.sourced(kernel) else { return };
        match source::in_files(&of, variant, &opened.plan.features, line) {
            Some(at) => {
                (self.line, self.wrong) = (format!("{}:{}", short(&of.files[at.file].name), at.line), None);
            }
            None => self.wrong = Some("this line is in no file: no element stops there".into()),
        }
    }

    /// Takes the answer of a search.
    pub(super) fn listen(&mut self, cx: &mut Context<'_>) {
        while let Some(found) = cx.model.take_answer::<Found>(LOOKING) {
            self.answer = Some(tell(cx, &found));
        }
    }

    /// The fields, and what was found; `pass` is the one in view.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>, kernel: Kernel, pass: Option<usize>) {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Stop at").on_hover_text(
                "a file and a line of this kernel, or a line alone; click on a line's number below to choose it",
            );
            let field = TextEdit::singleline(&mut self.line).id_salt("line").hint_text("line").desired_width(150.0);
            let line = ui.add(field).labelled_by(label.id);
            let label = ui
                .label("when")
                .on_hover_text("any expression of WGSL of type bool that can stand before this line; empty: always");
            let field = TextEdit::singleline(&mut self.when).id_salt("when").hint_text("always").desired_width(220.0);
            let when = ui.add(field).labelled_by(label.id);
            let is_done = (line.lost_focus() || when.lost_focus()) && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let can = !cx.model.is_busy() && !self.line.trim().is_empty();
            let here = ui.add_enabled(can && pass.is_some(), egui::Button::new("this pass"));
            if here.on_hover_text("which elements of this pass stop").clicked() || is_done && can {
                self.look(cx.model, kernel, pass);
            }
            let next = ui.add_enabled(can && cx.model.next.is_some(), egui::Button::new("next pass"));
            if next.on_hover_text("run to the next pass of this kernel in which an element stops").clicked() {
                self.look(cx.model, kernel, None);
            }
        });
        if let Some(wrong) = &self.wrong {
            ui.colored_label(ui.visuals().error_fg_color, wrong);
        }
        let now = (cx.model.generation, cx.model.edition);
        let Some(answer) = self.answer.as_ref().filter(|answer| answer.run == now) else { return };
        strong(ui, &answer.text);
        ui.horizontal_wrapped(|ui| {
            for (name, texel, values) in &answer.elements {
                if ui.small_button(name).on_hover_text(format!("select it\n{}", values.trim())).clicked() {
                    cx.asks.select = Some(*texel);
                }
            }
            if answer.more > 0 {
                ui.weak(format!("and {} more", answer.more));
            }
        });
    }

    /// Looks at a pass, or without one for the next.
    fn look(&mut self, model: &mut Model, kernel: Kernel, pass: Option<usize>) {
        let Some(opened) = model.opened.clone() else { return };
        (self.answer, self.wrong) = (None, None);
        match self.asked(&opened, kernel) {
            Ok(asked) => {
                let run = (model.generation, model.edition);
                model.ask(Request::Job(LOOKING, looking(Arc::new(asked), run, pass)));
            }
            Err(wrong) => self.wrong = Some(wrong),
        }
    }

    fn asked(&self, opened: &Opened, kernel: Kernel) -> Result<Asked, String> {
        let of = opened.plan.sourced(kernel).map_err(|error| error.to_string())?;
        let of = of.ok_or_else(|| format!("{} is not part of the run", kernel.name()))?;
        let text = self.line.trim();
        let (file, line) = text.rsplit_once(':').map_or((None, text), |(file, line)| (Some(file), line));
        let line: usize = line
            .trim()
            .parse()
            .map_err(|_| format!("{text}: expected a line, such as {}:20", short(&of.files[0].name)))?;
        let file = match file {
            None => 0,
            Some(name) => of.files.iter().position(|file| file.is_called(name)).ok_or_else(|| {
                let names: Vec<&str> = of.files.iter().map(|file| short(&file.name)).collect();
                format!("{name}: {} has no such file; its files are {}", kernel.name(), names.join(", "))
            })?,
        };
        let at = FileLine { file, line };
        let statement = stops::statement(&of, at).map_err(|error| error.to_string())?;
        let when = Some(self.when.trim().to_owned()).filter(|when| !when.is_empty());
        let stopping = of
            .stopping(&[Stop { statement, when: when.clone() }], false)
            .map_err(|error| format!("condition, column {}: {}", error.column, error.message))?;
        let code = Code::new(&stopping.variant, opened.plan.turns).map_err(|error| error.to_string())?;
        let names = stopping.watched.into_iter().next().unwrap_or_default();
        Ok(Asked { of, at, when, names, code })
    }
}

/// A file's name without its folders.
fn short(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

fn looking(asked: Arc<Asked>, run: (u64, u64), pass: Option<usize>) -> Job {
    job!(JobContext { session, progress, .. }, {
        let code = &asked.code;
        let found = match pass {
            Some(pass) => match session.begun(pass, code.streams()).await.map_err(|e| e.to_string())? {
                Some(begun) if begun.pass.kernel == code.kernel() => {
                    stops::of_pass(code, &begun, session.renderer().data()).map(Outcome::Stopped)
                }
                Some(begun) => Ok(Outcome::Other(begun.pass.kernel.name())),
                None => Ok(Outcome::Ended(session.place())),
            },
            None => session.run_to_stop(code, &mut |now| flow(progress(now.rays_decided, now.rays))).await,
        };
        let outcome = match found {
            Ok(outcome) => Ok(outcome),
            Err(StopsError::Render(error)) => return Err(error.to_string()),
            Err(StopsError::Failed { pass, failure }) => {
                let place = failure.lines.first().map_or_else(String::new, |&line| asked.of.named_line(line) + ": ");
                let [x, y] = failure.texel;
                Err(format!("pass {pass}, {place}{}, for the element at {x},{y}", failure.why))
            }
        };
        answered(Found { run, asked, outcome })
    })
}

/// Puts what was found into words, and shows it over the image.
fn tell(cx: &mut Context<'_>, found: &Found) -> Answer {
    let Found { run, asked, outcome } = found;
    let kernel = asked.code.kernel();
    let plain = |text| Answer { run: *run, text, elements: Vec::new(), more: 0 };
    let stopped = match outcome {
        Ok(Outcome::Stopped(stopped)) => stopped,
        Ok(Outcome::Never { reached: 0, .. }) => return plain("No element comes to this line from here on.".into()),
        Ok(Outcome::Never { reached, .. }) => {
            return plain(format!("No element stops from here on, of {reached} times that one comes to this line."));
        }
        Ok(Outcome::Other(other)) => {
            return plain(format!("This pass is one of {other}, not of {}.", kernel.name()));
        }
        Ok(Outcome::Ended(_)) => return plain("The run has no such pass.".into()),
        Err(why) => return plain(why.clone()),
    };
    let told = Told {
        found: stopped,
        of: &asked.of,
        at: asked.at,
        when: asked.when.as_deref(),
        names: &asked.names,
        watched: asked.code.interpreter().watched(0),
    };
    if told.is_image() {
        let place = (cx.model.generation, cx.model.place);
        cx.display.mask = Some(Arc::new(Mask::of_stop(place, told.head(), stopped)));
    }
    let width = stopped.size.width.max(1);
    let texel = |element: usize| [element as u32 % width, element as u32 / width];
    let elements: Vec<_> = stopped
        .held()
        .take(MOST_SHOWN)
        .map(|(element, stopped)| (told.name_of(*element), texel(*element), told.element(stopped)))
        .collect();
    let more = stopped.held().count() - elements.len();
    Answer { run: *run, text: told.head(), elements, more }
}
