//! Measured runs next to each other: threads launched against useful ones, and times.

use egui::{Color32, Rect, Sense, Ui, vec2};

use super::measured::Measured;
use crate::lesson::{Clock, Value};
use crate::ui::style::strong;

const HEIGHT: f32 = 12.0;

/// Colours of useful threads, of idle ones, and of time.
fn colors(ui: &Ui) -> [Color32; 3] {
    if ui.visuals().dark_mode {
        [Color32::from_rgb(90, 180, 120), Color32::from_gray(90), Color32::from_rgb(90, 140, 220)]
    } else {
        [Color32::from_rgb(40, 130, 70), Color32::from_gray(175), Color32::from_rgb(50, 100, 190)]
    }
}

/// Shows the runs with these names.
pub(super) fn show(ui: &mut Ui, all: &[Measured], names: &[String]) {
    let runs: Vec<&Measured> = names.iter().filter_map(|name| all.iter().find(|run| run.name == *name)).collect();
    let most_launched = runs.iter().map(|run| run.launched).max().unwrap_or(0).max(1) as f64;
    // Bars of different clocks would not compare.
    let clock = match runs.iter().all(|run| matches!(run.time(), Some((_, Clock::Device)))) {
        true => Clock::Device,
        false => Clock::Host,
    };
    let time_of = |run: &Measured| match clock {
        Clock::Device => run.device_ns,
        Clock::Host => run.host_ns,
    };
    let most_ns = runs.iter().filter_map(|run| time_of(run)).max().unwrap_or(0).max(1) as f64;
    let [useful, idle, time] = colors(ui);
    for run in &runs {
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            strong(ui, &run.name);
            ui.label(format!("{}, {} passes", run.options, Value::count(run.passes as u64)));
        });
        let (launched, of_useful) = (Value::count(run.launched), Value::count(run.useful));
        let share = Value::share(run.share());
        let threads = match run.drawn {
            Some(drawn) => {
                let draws = Value::count(drawn.draws);
                format!("{draws} draws, {launched} fragments run, {of_useful} with a ray: {share}")
            }
            None => format!("{launched} threads launched, {of_useful} useful: {share}"),
        };
        let parts = [(run.launched as f64 / most_launched, idle), (run.useful as f64 / most_launched, useful)];
        bar(ui, &parts, &format!("{}: {threads}", run.name));
        ui.label(threads);
        if let Some(ns) = time_of(run) {
            let text = Value::time(ns, clock).to_string();
            bar(ui, &[(ns as f64 / most_ns, time)], &format!("{}: {text}", run.name));
            ui.label(text);
        }
    }
    if runs.iter().any(|run| !run.is_gpu) {
        ui.add_space(6.0);
        ui.weak("These runs were on a CPU, which processes one ray after another: threads are those that a GPU would launch for the same passes.");
    }
    let why = runs.iter().find_map(|run| run.why_no_times.as_deref());
    if let Some(why) = why.filter(|_| clock == Clock::Host) {
        ui.weak(format!("Times are by the host's clock, with all waiting: {why}."));
    }
}

/// Bars over each other, as parts of the whole width.
fn bar(ui: &mut Ui, parts: &[(f64, Color32)], about: &str) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    for &(part, color) in parts {
        let width = rect.width() * part.clamp(0.0, 1.0) as f32;
        // What is there must be visible.
        let width = if part > 0.0 { width.max(1.0) } else { 0.0 };
        ui.painter().rect_filled(Rect::from_min_size(rect.min, vec2(width, rect.height())), 0.0, color);
    }
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, about));
}
