//! Mistakes in lessons: the file, the line, and what is right.

use super::{MOST_BYTES, MOST_COMMANDS, MOST_STEPS};
use crate::link::LinkError;

/// A mistake in a lesson.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {wrong}")]
pub struct LessonError {
    /// The name of the file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The mistake.
    pub wrong: Wrong,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Wrong {
    /// The file is too long.
    #[error("the lesson has {0} bytes; the most are {MOST_BYTES}")]
    TooLong(usize),
    /// Not a text.
    #[error("the lesson is not UTF-8")]
    NotUtf8,
    /// It has no title.
    #[error("expected a title: a line such as '# How one ray finds its triangle'")]
    NoTitle,
    /// A second title.
    #[error("a lesson has one title; '## ' begins a step")]
    SecondTitle,
    /// It has no steps.
    #[error("expected a step: a line such as '## The first pass'")]
    NoSteps,
    /// It has too many steps.
    #[error("a lesson has at most {MOST_STEPS} steps")]
    TooManySteps,
    /// A step has too many commands.
    #[error("a step has at most {MOST_COMMANDS} commands")]
    TooManyCommands,
    /// A heading of a third level.
    #[error("expected '# ' for the title or '## ' for a step: lessons have no other headings")]
    Heading,
    /// A block that is not of commands.
    #[error("{0:?}: blocks begin with ```raystep and hold commands")]
    Block(String),
    /// A block without an end.
    #[error("the block that begins here has no end: add a line ```")]
    OpenBlock,
    /// Commands before the first step.
    #[error("commands belong to a step: move them below a '## ' line")]
    NoStep,
    /// A mark in the text without its partner.
    #[error("{0} is not closed in this paragraph")]
    Unclosed(&'static str),
    /// Not a command.
    #[error("{0:?} is not a command; the commands are {known}", known = super::words::names())]
    Command(String),
    /// A command with something wrong.
    #[error("{0}: {1}")]
    Argument(&'static str, String),
    /// A wrong link, or pairs of one.
    #[error("{0}: {1}")]
    Link(&'static str, LinkError),
    /// The first step does not open a scene.
    #[error("the first step has to open a scene: add 'open scene=built-in:cornell-box'")]
    NothingOpen,
    /// Not the name of a value.
    #[error("{0:?} is not a value; the values are {known}", known = super::fact::names())]
    Name(String),
    /// The name of a measurement that does not exist.
    #[error("{0:?} was not measured: add 'measure {0} …' to this step or one before it")]
    NotMeasured(String),
    /// A value of the table of candidates in a step without it.
    #[error("{0}: add the command 'candidates' to this step")]
    NoCandidates(String),
    /// A value that the run does not have.
    #[error("{name}: {why}")]
    Unavailable {
        /// The value.
        name: String,
        /// Why not.
        why: String,
    },
    /// Something that has to hold does not.
    #[error("{0}")]
    Expected(String),
    /// A step could not be set up.
    #[error("not set up: {0}")]
    SetUp(String),
}
