//! The text of a step with the values of the run.

use std::sync::Arc;

use egui::text::LayoutJob;
use egui::{FontSelection, RichText, Ui};
use raystep_kernels::export::trace::Trace;

use super::Lesson;
use super::facts::Facts;
use crate::lesson::{self, Content, Expression, LessonError, Name, Paragraph, Question, Style};
use crate::ui::inspector::Inspector;

/// A paragraph as it is shown.
pub(super) struct Shown {
    is_item: bool,
    parts: Vec<(Style, bool, String)>,
}

/// A question with the values of the run.
pub(super) struct Asked {
    pub(super) text: Shown,
    pub(super) choices: Vec<Offered>,
    /// Which of them is right.
    pub(super) right: usize,
}

/// What can be chosen.
pub(super) struct Offered {
    pub(super) label: String,
    /// What is said if it is chosen, and wrong.
    pub(super) why_not: Option<Shown>,
}

/// The text of a step as it is shown, and what its values are from.
#[derive(Default)]
pub(super) struct StepText {
    /// What comes first; `None` for a paragraph whose values are not known yet.
    pub(super) first: Vec<Option<Shown>>,
    /// The question.
    pub(super) asked: Option<Asked>,
    /// The answer.
    pub(super) answer: Vec<Option<Shown>>,
    /// The ray's history, the generation, and the place.
    from: Option<(Option<Arc<Trace>>, u64, usize)>,
}

impl StepText {
    /// The text as far as it has no values.
    pub(super) fn of(lesson: &lesson::Lesson, step: usize) -> Self {
        let plain =
            |paragraph: &Paragraph| paragraph.values().next().is_none().then(|| shown(paragraph, |_| String::new()));
        Self { first: first(lesson, step).map(plain).collect(), ..Self::default() }
    }

    /// Whether a paragraph waits for its values.
    pub(super) fn is_pending(&self) -> bool {
        self.first.iter().chain(&self.answer).any(Option::is_none)
    }
}

/// The paragraphs that come first in a step; what the lesson is about comes with the first step.
pub(super) fn first(lesson: &lesson::Lesson, step: usize) -> impl Iterator<Item = &Paragraph> {
    let about = lesson.about.iter().filter(move |_| step == 0);
    about.chain(lesson.steps.get(step).into_iter().flat_map(|step| &step.first.text))
}

/// The paragraphs of its answer.
pub(super) fn answer(lesson: &lesson::Lesson, step: usize) -> impl Iterator<Item = &Paragraph> {
    lesson.steps.get(step).into_iter().flat_map(|step| &step.answer.text)
}

fn shown(paragraph: &Paragraph, mut value: impl FnMut(&lesson::Part) -> String) -> Shown {
    let parts = paragraph.parts.iter().map(|part| match &part.content {
        Content::Text(text) => (part.style, false, text.clone()),
        Content::Value(_) => (part.style, true, value(part)),
    });
    Shown { is_item: paragraph.is_item, parts: parts.collect() }
}

/// Fills in values, and collects what is wrong.
struct Teller<'a> {
    lesson: &'a Lesson,
    facts: Facts<'a>,
    problems: Vec<LessonError>,
}

impl Teller<'_> {
    /// Whether an expression has values that are still to be measured.
    fn waits(&self, expression: &Expression) -> bool {
        expression.names().any(|name| match name {
            Name::Measured(of, _) => self.lesson.is_waiting() && !self.lesson.has_measured(of),
            Name::Fact(_) => false,
        })
    }

    /// A paragraph; `None` if it has values that are still to be measured.
    fn tell(&mut self, paragraph: &Paragraph) -> Option<Shown> {
        if paragraph.values().any(|(_, expression)| self.waits(expression)) {
            return None;
        }
        Some(shown(paragraph, |part| {
            let Content::Value(expression) = &part.content else { return String::new() };
            expression.evaluate(|name| self.facts.value(name)).map_or_else(
                |wrong| {
                    self.problems.push(self.lesson.error(part.line, wrong));
                    "?".into()
                },
                |value| value.to_string(),
            )
        }))
    }

    /// The question; `None` if it depends on values that are still to be measured.
    fn ask(&mut self, question: &Question) -> Option<Asked> {
        let conditions = question.conditions().flat_map(|(_, condition)| condition.expressions());
        if conditions.into_iter().any(|expression| self.waits(expression)) {
            return None;
        }
        let right = match question.right(|name| self.facts.value(name)) {
            Ok(right) => right,
            Err((line, wrong)) => {
                self.problems.push(self.lesson.error(line, wrong));
                return None;
            }
        };
        let mut choices = Vec::new();
        for choice in &question.choices {
            let label = self.tell(&choice.label)?.plain();
            let why_not = choice.why_not.as_ref().and_then(|why| self.tell(why));
            choices.push(Offered { label, why_not });
        }
        Some(Asked { text: self.tell(&question.text)?, choices, right })
    }
}

impl Inspector {
    /// Fills the values in, if they are new; `is_first`: whether or not. The values stay when the user goes elsewhere.
    pub(super) fn tell_lesson(&self, lesson: &mut Lesson, is_first: bool) {
        let now = (self.model.history.clone(), self.model.generation, self.model.place);
        let is_same_place = lesson.text.from.as_ref().is_some_and(|(before, generation, place)| {
            let (ray, known) =
                (now.0.as_ref().map(|history| history.pixel), before.as_ref().map(|history| history.pixel));
            (*generation, *place, known) == (now.1, now.2, ray)
                && !matches!((before, &now.0), (Some(a), Some(b)) if Arc::ptr_eq(a, b))
        });
        if !is_first && !is_same_place {
            return;
        }
        let facts = Facts { model: &self.model, measured: &lesson.measured, candidates: lesson.candidates.as_ref() };
        let mut teller = Teller { lesson, facts, problems: Vec::new() };
        let (text, step) = (&lesson.lesson, lesson.step);
        if lesson.is_answered {
            // What came before keeps the values of its own place.
            let filled = answer(text, step).map(|paragraph| teller.tell(paragraph)).collect();
            let new = teller.problems.into_iter().filter(|problem| !lesson.problems.contains(problem));
            let new: Vec<LessonError> = new.collect();
            lesson.text.answer = filled;
            lesson.problems.extend(new);
        } else {
            let first = first(text, step).map(|paragraph| teller.tell(paragraph)).collect();
            let question = text.steps.get(step).and_then(|step| step.question.as_ref());
            let asked = question.and_then(|question| teller.ask(question));
            let problems = teller.problems;
            lesson.text = StepText { first, asked, ..StepText::default() };
            lesson.problems = problems;
        }
        lesson.text.from = Some(now);
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

    /// Its words alone.
    fn plain(&self) -> String {
        self.parts.iter().map(|(.., text)| text.as_str()).collect()
    }

    /// Words in backticks: the screen has to show them.
    pub(super) fn codes(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter(|(style, ..)| style.code).map(|(.., text)| text.as_str())
    }
}
