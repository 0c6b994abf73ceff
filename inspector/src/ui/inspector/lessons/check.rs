//! Checks that what a step speaks of is on the screen.

use egui::epaint::{ClippedShape, Shape, TextShape};
use egui::{Rect, Vec2};

use super::Lesson;
use super::facts::Facts;
use crate::lesson::command::panel_name;
use crate::lesson::{Expect, LessonError, Paragraph, Wrong};
use crate::ui::inspector::Inspector;

/// A step that was set up and checked.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedStep {
    /// Its number, from 0.
    pub step: usize,
    /// Its title.
    pub title: String,
    /// How many things were checked: values, words in backticks, and what it expects.
    pub checked: usize,
    /// What is wrong.
    pub problems: Vec<LessonError>,
    /// Threads that a GPU would have launched for all that the step has traced: what the reader waits for.
    pub work: u64,
}

impl CheckedStep {
    /// Adds what a check of the same step found later.
    pub fn add(&mut self, later: Self) {
        self.checked += later.checked;
        self.problems.extend(later.problems);
        self.work = self.work.max(later.work);
    }
}

impl Inspector {
    /// Checks the lesson's current step once it is set up; `shapes` are those of the last frame, in a window of this
    /// size. `None` without a lesson.
    #[must_use]
    pub fn check_step(&self, shapes: &[ClippedShape], size: Vec2) -> Option<CheckedStep> {
        let lesson = self.lesson.as_ref()?;
        let step = lesson.lesson.steps.get(lesson.step)?;
        let mut problems = lesson.problems.clone();
        let mut checked = 0;
        if problems.is_empty() && lesson.is_waiting() {
            problems.push(lesson.error(step.line, Wrong::SetUp("it is still in progress".into())));
        }
        if problems.is_empty() && lesson.is_cancelled {
            problems.push(lesson.error(step.line, Wrong::SetUp("it was cancelled".into())));
        }
        // A step that is not set up fails for that reason alone.
        if problems.is_empty() {
            let seen = Seen::new(shapes, size, lesson.dock);
            let section = if lesson.is_answered { &step.answer } else { &step.first };
            checked += if lesson.is_answered {
                super::step_text::answer(&lesson.lesson, lesson.step).flat_map(Paragraph::values).count()
            } else {
                super::step_text::first(&lesson.lesson, lesson.step).flat_map(Paragraph::values).count()
            };
            let shown = if lesson.is_answered { &lesson.text.answer } else { &lesson.text.first };
            for code in shown.iter().flatten().flat_map(|paragraph| paragraph.codes()) {
                checked += 1;
                if !seen.shows(code) {
                    let what = format!("the text refers to `{code}`, which cannot be read outside of the lesson");
                    problems.push(lesson.error(step.line, Wrong::Expected(what)));
                }
            }
            // What is expected holds once nothing goes on by itself any more.
            for (line, expect) in section.expects.iter().filter(|_| !lesson.plays()) {
                checked += 1;
                if let Err(wrong) = self.expect(lesson, expect, &seen) {
                    problems.push(lesson.error(*line, wrong));
                }
            }
        }
        Some(CheckedStep { step: lesson.step, title: step.title.clone(), checked, problems, work: lesson.work })
    }

    fn expect(&self, lesson: &Lesson, expect: &Expect, seen: &Seen) -> Result<(), Wrong> {
        let facts = Facts { model: &self.model, measured: &lesson.measured, candidates: lesson.candidates.as_ref() };
        match expect {
            Expect::Panel(kind) if self.panes_in_view().contains(kind) => Ok(()),
            Expect::Panel(kind) => Err(Wrong::Expected(format!("the panel {} is not in view", panel_name(*kind)))),
            Expect::Text(text) if seen.shows(text) => Ok(()),
            Expect::Text(text) => Err(Wrong::Expected(format!("{text:?} cannot be read outside of the lesson"))),
            Expect::Values(comparison) => comparison.check(|name| facts.value(name)),
        }
    }
}

/// The painted texts outside of the lesson, without what is cut off or covered by an edge.
struct Seen {
    texts: Vec<String>,
}

impl Seen {
    fn new(shapes: &[ClippedShape], size: Vec2, dock: Rect) -> Self {
        let screen = Rect::from_min_size(egui::Pos2::ZERO, size);
        let mut seen = Self { texts: Vec::new() };
        for clipped in shapes {
            seen.add(&clipped.shape, clipped.clip_rect.intersect(screen), dock);
        }
        seen
    }

    fn add(&mut self, shape: &Shape, clip: Rect, dock: Rect) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| self.add(shape, clip, dock)),
            Shape::Text(text) if !dock.contains(text.visual_bounding_rect().center()) => {
                self.texts.push(readable(text, clip));
            }
            _ => {}
        }
    }

    /// Whether a text is on the screen, as a whole.
    fn shows(&self, text: &str) -> bool {
        let wanted = text.split_whitespace().collect::<Vec<_>>().join(" ");
        self.texts.iter().any(|shown| shown.contains(&wanted))
    }
}

/// What stands for a letter that cannot be seen: no text to look for contains it.
const HIDDEN: char = '\u{fffd}';

/// The letters of a text that are within `clip`, line by line, with single spaces between words.
fn readable(text: &TextShape, clip: Rect) -> String {
    // Rounding to pixels may put a letter a fraction of a point over the edge.
    let clip = clip.expand(1.0);
    let mut letters = String::new();
    for row in &text.galley.rows {
        if !letters.is_empty() {
            letters.push(' ');
        }
        for glyph in &row.row.glyphs {
            let place = Rect::from_min_size(
                text.pos + row.pos.to_vec2() + glyph.pos.to_vec2() - egui::vec2(0.0, glyph.font_ascent),
                egui::vec2(glyph.advance_width, glyph.font_height),
            );
            let is_seen = glyph.chr.is_whitespace() || clip.contains_rect(place);
            letters.push(if is_seen { glyph.chr } else { HIDDEN });
        }
    }
    letters.split_whitespace().collect::<Vec<_>>().join(" ")
}
