//! Lessons: Markdown files with a text and commands for each step. The inspector sets a step up, fills in the numbers of
//! its text from the run, and can check that what the text speaks of is on the screen.
//!
//! ````text
//! # Title
//!
//! What the lesson is about.
//!
//! ## Title of a step
//!
//! Prose with **strong** words, `code`, *emphasis* and values: the ray hits triangle {{ray.triangle}}.
//!
//! ```raystep
//! open scene=built-in:cornell-box size=256x256 pixel=96,180
//! row "beyond the exit"
//! only stream ray / unfolded-walk
//! expect ray.triangle = 17
//! ```
//! ````
//!
//! A step continues from the one before, back to the last `open`: [`Lesson::set_up`] is the whole of it, so that a step
//! is set up in the same way from wherever the reader comes. [`command`] has the commands, [`fact`] the values.
//!
//! A step may ask a [`Question`]. What follows the block with the question is its answer: the text, and the commands of
//! further blocks. The reader gets it after choosing what is right, which is worked out from the run.

pub mod built_in;
pub mod command;
mod comparison;
mod error;
mod expression;
pub mod fact;
mod prose;
mod question;
mod read;
mod set_up;
mod value;
pub mod words;

pub use command::{Action, Expect, Goal, Values};
pub use comparison::{Comparison, Condition, Operand};
pub use error::{LessonError, Wrong};
pub use expression::{Expression, Sign};
pub use fact::{Fact, Field, Name};
pub use prose::{Content, Paragraph, Part, Style};
pub use question::{Choice, MOST_CHOICES, Question};
pub use set_up::{Measurement, SetUp};
pub use value::{Clock, Value};

/// Most bytes of a file.
pub const MOST_BYTES: usize = 1 << 18;
/// Most steps of a lesson.
pub const MOST_STEPS: usize = 64;
/// Most commands of a step.
pub const MOST_COMMANDS: usize = 64;

/// A lesson.
#[derive(Clone, Debug, PartialEq)]
pub struct Lesson {
    /// The name of its file, for errors.
    pub file: String,
    /// Its title.
    pub title: String,
    /// What it is about, shown with the first step.
    pub about: Vec<Paragraph>,
    /// Its steps, at least one.
    pub steps: Vec<Step>,
}

/// A step of a lesson.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// The line of its title, from 1.
    pub line: usize,
    /// Its title.
    pub title: String,
    /// What the reader gets at first.
    pub first: Section,
    /// The question that it asks, if it asks one.
    pub question: Option<Question>,
    /// What the reader gets once the question is answered.
    pub answer: Section,
}

/// A text, and what belongs to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// The text.
    pub text: Vec<Paragraph>,
    /// What it sets up, with line numbers.
    pub actions: Vec<(usize, Action)>,
    /// What has to hold once it is set up, with line numbers.
    pub expects: Vec<(usize, Expect)>,
}

impl Step {
    /// Both of its sections.
    pub fn sections(&self) -> [&Section; 2] {
        [&self.first, &self.answer]
    }

    /// The section to which the next lines of the file belong.
    fn last_mut(&mut self) -> &mut Section {
        if self.question.is_some() { &mut self.answer } else { &mut self.first }
    }

    /// How many commands it has.
    fn commands(&self) -> usize {
        let asked = self.question.as_ref().map_or(0, |question| 1 + question.choices.len());
        asked + self.sections().iter().map(|section| section.actions.len() + section.expects.len()).sum::<usize>()
    }
}

impl Lesson {
    /// Reads a lesson; `file` is its name in errors.
    ///
    /// # Errors
    /// The first mistake, with its line.
    pub fn parse(file: &str, text: &str) -> Result<Self, LessonError> {
        read::lesson(file, text)
    }

    /// The links of all scenes that it opens, with their lines: the host decides what their scenes mean.
    pub fn links_mut(&mut self) -> impl Iterator<Item = (usize, &mut crate::link::Link)> {
        let sections = self.steps.iter_mut().flat_map(|step| [&mut step.first, &mut step.answer]);
        sections.flat_map(|section| &mut section.actions).filter_map(|(line, action)| match action {
            Action::Open(link) => Some((*line, &mut **link)),
            _ => None,
        })
    }
}
