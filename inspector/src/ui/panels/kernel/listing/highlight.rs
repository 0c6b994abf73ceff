//! The words of a line in their colours.

use egui::text::{LayoutJob, TextFormat};
use egui::{Color32, FontId, Stroke};

use crate::source::{Class, Line, Mark};
use crate::ui::style::towards;

/// A line with highlighting.
pub(super) fn job(line: &Line, font: &FontId, visuals: &egui::Visuals, is_marked: bool) -> LayoutJob {
    let mut job = LayoutJob::default();
    // How much of the colour gives way to that of weak text: fainter text would be hard to read.
    let faintness = match line.mark {
        Mark::Run => 0.0,
        // Comments and declarations between lines that ran are less prominent.
        Mark::Plain => {
            if is_marked {
                0.4
            } else {
                0.0
            }
        }
        Mark::NotRun => 0.85,
        Mark::LeftOut => 1.0,
    };
    let strike = if line.mark == Mark::LeftOut { visuals.weak_text_color() } else { Color32::TRANSPARENT };
    for (range, class) in &line.spans {
        let Some(text) = line.text.get(range.clone()) else { continue };
        let color = towards(color(*class, visuals), visuals.weak_text_color(), faintness);
        // Indentation is not struck through.
        let (space, words) = text.split_at(text.len() - text.trim_start().len());
        for (text, strikethrough) in [(space, Stroke::NONE), (words, Stroke::new(1.0, strike))] {
            if !text.is_empty() {
                job.append(
                    text,
                    0.0,
                    TextFormat { font_id: font.clone(), color, strikethrough, ..TextFormat::default() },
                );
            }
        }
    }
    job
}

fn color(class: Class, visuals: &egui::Visuals) -> Color32 {
    let [r, g, b] = match (class, visuals.dark_mode) {
        (Class::Plain, _) => return visuals.strong_text_color(),
        (Class::Keyword, true) => [205, 145, 230],
        (Class::Keyword, false) => [130, 30, 150],
        (Class::Type, true) => [90, 205, 190],
        (Class::Type, false) => [0, 115, 110],
        (Class::Number, true) => [240, 170, 105],
        (Class::Number, false) => [165, 75, 0],
        (Class::Comment, true) => [140, 155, 140],
        (Class::Comment, false) => [85, 110, 85],
        (Class::Attribute, true) => [225, 205, 120],
        (Class::Attribute, false) => [125, 100, 0],
        (Class::Function, true) => [120, 180, 250],
        (Class::Function, false) => [20, 80, 185],
    };
    Color32::from_rgb(r, g, b)
}
