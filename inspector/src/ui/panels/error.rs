//! Error against run time: rays not yet resolved, and rays resolved wrongly, over device time.
//!
//! Touches: other, selection, asks.

mod plot;
mod scales;

use std::sync::Arc;

use egui::{Button, Color32, ScrollArea, Sense, Shape, Stroke, Ui, vec2};
use plot::{Curve, Plot};
use raystep_kernels::{Options, Plan, Renderer};
use raystep_lab::human::grouped;
use raystep_lab::judge::{Judgement, judge_passes};
use raystep_lab::reference::Verdict;
use raystep_lab::statistics::proportion::exact_interval;
use raystep_lab::text::counted;

use crate::command::Command;
use crate::session::judged::why_not;
use crate::session::request::{Job, JobContext, Request, answered, flow, job};
use crate::session::{Model, Target};
use crate::ui::pane::{Context, NO_RAYS, Panel, saves};
use crate::ui::style::strong;

/// The engine's job, named while it runs.
const JUDGING: &str = "judging hits";

const ABOUT: &str = "Tests every ray, or a random sample of the rays if there are too many tests, against every \
                     triangle in f64; then repeats the passes, to find when wrong rays were resolved.";

/// The key of a judgement.
#[derive(Clone)]
struct Of {
    plan: Arc<Plan>,
    edition: u64,
}

impl Of {
    fn new(model: &Model) -> Option<Self> {
        Some(Self { plan: model.opened.as_ref()?.plan.clone(), edition: model.edition })
    }

    fn is(&self, model: &Model) -> bool {
        Self::new(model).is_some_and(|of| of.edition == self.edition && Arc::ptr_eq(&of.plan, &self.plan))
    }
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct ErrorOverTime {
    /// Linear instead of logarithmic shares.
    is_linear: bool,
    /// Of run A and of run B.
    judged: [Option<(Of, Judgement)>; 2],
}

/// A second run.
fn job(of: Of) -> Job {
    job!(context, {
        let JobContext { session, device, progress, .. } = context;
        let (plan, data) = (session.renderer().shared_plan(), session.renderer().shared_data());
        if !Arc::ptr_eq(&plan, &of.plan) {
            return Err("the run changed before it was judged".into());
        }
        let options = Options { timings: false, ..session.options().clone() };
        let fail = |e: raystep_kernels::RenderError| e.to_string();
        let mut renderer = Renderer::from_plan(plan, data, &options, &device).await.map_err(fail)?;
        let judgement = judge_passes(&mut renderer, |done, all| flow(progress(done, all)));
        let judgement = judgement.await.map_err(fail)?;
        answered((of, judgement))
    })
}

/// Why a run cannot be judged.
fn refusal(model: &Model) -> Option<&'static str> {
    why_not(&model.opened.as_ref()?.plan, &model.edits, model.twins)
}

/// Has a run judged, if possible.
fn ask(model: &mut Model) {
    if let Some(of) = Of::new(model).filter(|_| refusal(model).is_none()) {
        model.ask(Request::Job(JUDGING, job(of)));
    }
}

/// Takes the answer, and drops those of other runs.
fn take(judged: &mut Option<(Of, Judgement)>, model: Option<&mut Model>) {
    let Some(model) = model else {
        *judged = None;
        return;
    };
    while let Some(answer) = model.take_answer::<(Of, Judgement)>(JUDGING) {
        *judged = Some(*answer);
    }
    if judged.as_ref().is_some_and(|(of, _)| !of.is(model)) {
        *judged = None;
    }
}

/// The colours of run A and run B.
fn colors(ui: &Ui) -> [Color32; 2] {
    let b = if ui.visuals().dark_mode { Color32::from_rgb(240, 150, 60) } else { Color32::from_rgb(190, 85, 0) };
    [ui.visuals().hyperlink_color, b]
}

impl Panel for ErrorOverTime {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        take(&mut self.judged[0], Some(&mut *cx.model));
        take(&mut self.judged[1], cx.other.as_deref_mut());
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        if cx.model.passes.is_empty() {
            ui.weak("Step a pass to see the rays it resolves.");
            return;
        }
        let bottom = ui.max_rect().bottom();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let has_other = cx.other.as_ref().is_some_and(|other| !other.passes.is_empty());
            self.tools(ui, cx, has_other);
            self.words(ui, cx, has_other);
            let height = (bottom - ui.cursor().top() - 2.0).max(120.0);
            self.plot(ui, cx, height);
        });
    }

    saves!(is_linear);

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if command != Command::Judge {
            return false;
        }
        ask(cx.model);
        if let Some(other) = cx.other.as_deref_mut() {
            ask(other);
        }
        true
    }
}

impl ErrorOverTime {
    fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>, has_other: bool) {
        ui.horizontal_wrapped(|ui| {
            let is_busy = cx.model.is_busy() || cx.other.as_ref().is_some_and(|other| other.is_busy());
            let other_can = cx.other.as_ref().is_some_and(|other| refusal(other).is_none());
            let can = !is_busy && (refusal(cx.model).is_none() || other_can);
            if ui.add_enabled(can, Button::new("Judge")).on_hover_text(ABOUT).clicked() {
                cx.asks.commands.push(Command::Judge);
            }
            let mut is_log = !self.is_linear;
            ui.checkbox(&mut is_log, "log").on_hover_text("Logarithmic axis; zero is drawn at the bottom.");
            self.is_linear = !is_log;
            for (i, color) in colors(ui).into_iter().enumerate().filter(|(i, _)| *i == 0 || has_other) {
                let run = match (has_other, i) {
                    (false, _) => "",
                    (true, 0) => "A: ",
                    (true, _) => "B: ",
                };
                entry(ui, color, false, &format!("{run}not yet resolved"));
                if self.judged[i].as_ref().is_some_and(|(_, judgement)| !judgement.wrong.is_empty()) {
                    entry(ui, color, true, &format!("{run}resolved wrongly (of judged rays)"));
                }
            }
        });
    }

    /// Judgements, one line per run.
    fn words(&self, ui: &mut Ui, cx: &mut Context<'_>, has_other: bool) {
        for (i, name) in ["A", "B"].into_iter().enumerate() {
            let model = if i == 0 { Some(&mut *cx.model) } else { cx.other.as_deref_mut() };
            let Some(model) = model.filter(|model| !model.passes.is_empty()) else { continue };
            let (why, judged) = (refusal(model), self.judged[i].as_ref());
            let rest = (!model.is_complete).then(|| format!("{} known so far", counted(model.passes.len(), "pass")));
            if why.is_none() && judged.is_none() && rest.is_none() {
                continue;
            }
            ui.horizontal_wrapped(|ui| {
                if has_other {
                    strong(ui, name);
                }
                if let Some((_, judgement)) = judged {
                    if let Some((pixel, place)) = verdicts(ui, judgement, model, cx.selection.pixel) {
                        cx.asks.select = Some(pixel);
                        match place {
                            Some(place) if i == 0 => cx.asks.go_to = Some(place),
                            Some(place) => drop(model.ask(Request::Step(Target::Pass(place)))),
                            None => {}
                        }
                    }
                } else if let Some(why) = why {
                    ui.label(why);
                }
                if let Some(rest) = rest {
                    ui.weak(rest).on_hover_text("run to the end to judge the whole run");
                }
            });
        }
    }

    fn plot(&self, ui: &mut Ui, cx: &mut Context<'_>, height: f32) {
        let models = [Some(&*cx.model), cx.other.as_deref()].into_iter().flatten().filter(|m| !m.passes.is_empty());
        let curves = models.zip(&self.judged).zip(colors(ui)).map(|((model, judged), color)| {
            let rays = model.opened.as_ref().map_or(0, |opened| opened.plan.rays);
            let judgement = judged.as_ref().map(|(_, judgement)| judgement);
            Curve::new(&model.passes, model.place, rays, judgement, color)
        });
        let curves: Vec<Curve<'_>> = curves.collect();
        let Some((run, place, is_click)) = Plot::new(curves, !self.is_linear).show(ui, height) else { return };
        // During a drag, one place at a time; intermediate ones are skipped.
        let is_free = |model: &Model| is_click || !model.is_busy();
        if run == 0 {
            cx.asks.go_to = is_free(cx.model).then_some(place).or(cx.asks.go_to);
        } else if let Some(other) = cx.other.as_deref_mut().filter(|other| is_free(other)) {
            other.ask(Request::Step(Target::Pass(place)));
        }
    }
}

/// The legend of a line.
fn entry(ui: &mut Ui, color: Color32, is_dashed: bool, text: &str) {
    // Kept together when a line wraps.
    let line = ui.painter().layout_no_wrap(text.to_owned(), egui::TextStyle::Small.resolve(ui.style()), color);
    if ui.available_size_before_wrap().x < 18.0 + 2.0 * ui.spacing().item_spacing.x + line.size().x {
        ui.end_row();
    }
    let (rect, _) = ui.allocate_exact_size(vec2(18.0, 10.0), Sense::hover());
    let (ends, stroke) = ([rect.left_center(), rect.right_center()], Stroke::new(2.0, color));
    if is_dashed {
        ui.painter().extend(Shape::dashed_line(&ends, stroke, 4.0, 3.0));
    } else {
        ui.painter().line_segment(ends, stroke);
    }
    ui.small(text);
}

/// Describes a judgement; also returns the wrong ray to show next, and the place after which it was resolved.
fn verdicts(
    ui: &mut Ui,
    judgement: &Judgement,
    model: &Model,
    selected: Option<[u32; 2]>,
) -> Option<([u32; 2], Option<usize>)> {
    let width = model.opened.as_ref().map_or(1, |opened| opened.plan.width.max(1)) as usize;
    let pixel_of = |ray: usize| [(ray % width) as u32, (ray / width) as u32];
    let (wrong, judged) = (judgement.wrong.len(), judgement.counts.rays());
    let text = format!("{} of {} judged rays wrong", grouped(wrong as u64), grouped(judged));
    let mut chosen = None;
    if wrong == 0 {
        ui.label(text);
    } else {
        let kinds = [
            (Verdict::Missed, "missed: hit nothing, or a triangle farther away"),
            (Verdict::False, "false: hit where there is nothing"),
            (Verdict::Wrong, "hit another triangle, or wrong t"),
        ];
        let kinds = kinds.map(|(verdict, what)| format!("{} {what}", grouped(judgement.counts.of(verdict))));
        let about = format!("{}\nclick to select the first of them, and again for the next", kinds.join("\n"));
        if ui.link(text).on_hover_text(about).clicked() {
            let at = judgement.wrong.iter().position(|wrong| Some(pixel_of(wrong.ray)) == selected);
            let next = &judgement.wrong[at.map_or(0, |at| (at + 1) % wrong)];
            chosen = Some((pixel_of(next.ray), next.resolved_by));
        }
    }
    let undecided = format!("{} undecided", grouped(judgement.counts.ties));
    ui.label(undecided).on_hover_text(
        "f32 cannot decide which of several triangles is hit; any of them is \
                                       acceptable",
    );
    ui.label(format!("{} right", grouped(judgement.counts.same)));
    let unresolved = judgement.wrong.iter().filter(|wrong| wrong.resolved_by.is_none()).count();
    if unresolved > 0 {
        ui.label(format!("{} of the wrong rays never resolved", grouped(unresolved as u64)));
    }
    if judged < judgement.rays {
        let between = exact_interval(wrong as u64, judged).map_or_else(String::new, |[low, high]| {
            format!("{:.1} to {:.1} wrong per million rays, with 95% confidence", 1e6 * low, 1e6 * high)
        });
        ui.label(format!("a random sample of {} rays", grouped(judgement.rays))).on_hover_text(between);
    }
    chosen
}
