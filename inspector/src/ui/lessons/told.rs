//! The text of a step with the values of the run.

use std::sync::Arc;

use egui::text::LayoutJob;
use egui::{FontSelection, RichText, Ui};
use raystep_kernels::export::trace::Trace;

use super::Lesson;
use super::facts::Facts;
use crate::lesson::{self, Content, LessonError, Paragraph, Style};
use crate::ui::Inspector;

/// A paragraph as it is shown.
pub(super) struct Shown {
    is_item: bool,
    parts: Vec<(Style, bool, String)>,
}

/// The text of a step as it is shown, and what its values are from.
#[derive(Default)]
pub(super) struct Told {
    pub(super) paragraphs: Vec<Shown>,
    /// The ray's history, the generation, and the place.
    from: Option<(Option<Arc<Trace>>, u64, usize)>,
}

impl Told {
    /// The text without values.
    pub(super) fn of(lesson: &lesson::Lesson, step: usize) -> Self {
        let paragraphs = paragraphs(lesson, step).map(|paragraph| shown(paragraph, |_| "…".into())).collect();
        Self { paragraphs, from: None }
    }
}

/// The paragraphs of a step; what the lesson is about comes with the first one.
pub(super) fn paragraphs(lesson: &lesson::Lesson, step: usize) -> impl Iterator<Item = &Paragraph> {
    let about = lesson.about.iter().filter(move |_| step == 0);
    about.chain(lesson.steps.get(step).into_iter().flat_map(|step| &step.text))
}

fn shown(paragraph: &Paragraph, mut value: impl FnMut(&lesson::Part) -> String) -> Shown {
    let parts = paragraph.parts.iter().map(|part| match &part.content {
        Content::Text(text) => (part.style, false, text.clone()),
        Content::Value(_) => (part.style, true, value(part)),
    });
    Shown { is_item: paragraph.is_item, parts: parts.collect() }
}

impl Inspector {
    /// Fills the values in, if they are new; `is_first`: whether or not. The values stay when the user goes elsewhere.
    pub(super) fn tell_lesson(&self, lesson: &mut Lesson, is_first: bool) {
        let now = (self.model.life.clone(), self.model.generation, self.model.place);
        let is_same_place = lesson.told.from.as_ref().is_some_and(|(before, generation, place)| {
            let (ray, known) = (now.0.as_ref().map(|life| life.pixel), before.as_ref().map(|life| life.pixel));
            (*generation, *place, known) == (now.1, now.2, ray)
                && !matches!((before, &now.0), (Some(a), Some(b)) if Arc::ptr_eq(a, b))
        });
        if !is_first && !is_same_place {
            return;
        }
        let facts = Facts { model: &self.model, measured: &lesson.measured, candidates: lesson.candidates.as_ref() };
        let mut problems: Vec<LessonError> = Vec::new();
        let told = paragraphs(&lesson.lesson, lesson.step).map(|paragraph| {
            shown(paragraph, |part| {
                let Content::Value(expression) = &part.content else { return String::new() };
                expression.evaluate(|name| facts.value(name)).map_or_else(
                    |wrong| {
                        problems.push(lesson.error(part.line, wrong));
                        "?".into()
                    },
                    |value| value.to_string(),
                )
            })
        });
        let paragraphs = told.collect();
        lesson.told = Told { paragraphs, from: Some(now) };
        lesson.problems = problems;
    }
}

impl Shown {
    /// A label's text.
    pub(super) fn job(&self, ui: &Ui) -> LayoutJob {
        let mut job = LayoutJob::default();
        let mut add =
            |words: RichText| words.append_to(&mut job, ui.style(), FontSelection::Default, egui::Align::Center);
        if self.is_item {
            add(RichText::new("• "));
        }
        for (style, is_value, text) in &self.parts {
            let mut words = RichText::new(text);
            if style.strong || *is_value {
                words = words.strong();
            }
            if style.code {
                words = words.code();
            }
            if style.emphasis {
                words = words.italics();
            }
            add(words);
        }
        job
    }

    /// Words in backticks: the screen has to show them.
    pub(super) fn codes(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter(|(style, ..)| style.code).map(|(.., text)| text.as_str())
    }
}
