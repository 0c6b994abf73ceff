//! A question to the reader: the choices, and for each of them what has to hold for it to be right.

use super::comparison::Comparison;
use super::error::Wrong;
use super::prose::{Paragraph, paragraph};
use super::{Expression, Name, Value};

/// Fewest choices of a question.
const LEAST_CHOICES: usize = 2;
/// Most choices of a question: each has a key.
pub const MOST_CHOICES: usize = 4;

/// A question.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// The line of its command, from 1.
    pub line: usize,
    /// The question.
    pub text: Paragraph,
    /// What the reader can choose.
    pub choices: Vec<Choice>,
}

/// What the reader can choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The line of its command, from 1.
    pub line: usize,
    /// The words of its button.
    pub label: Paragraph,
    /// What holds if it is right: all of this.
    pub conditions: Vec<Comparison>,
    /// What a reader is told who chooses it although it is wrong.
    pub why_not: Option<Paragraph>,
}

impl Question {
    /// Reads `"TEXT"`.
    pub(super) fn parse(line: usize, rest: &str) -> Result<Self, Wrong> {
        let text = prose(line, &super::prose::quoted("question", rest)?)?;
        Ok(Self { line, text, choices: Vec::new() })
    }

    /// Adds a choice.
    pub(super) fn add(&mut self, choice: Choice) -> Result<(), Wrong> {
        if self.choices.len() == MOST_CHOICES {
            return Err(Wrong::Argument("choice", format!("a question has at most {MOST_CHOICES} choices")));
        }
        self.choices.push(choice);
        Ok(())
    }

    /// Whether there is something to choose.
    pub(super) fn check(&self) -> Result<(), Wrong> {
        let count = self.choices.len();
        let why = || format!("{count} choices follow; expected {LEAST_CHOICES} to {MOST_CHOICES}");
        if count < LEAST_CHOICES { Err(Wrong::Argument("question", why())) } else { Ok(()) }
    }

    /// All texts of it.
    pub fn texts(&self) -> impl Iterator<Item = &Paragraph> {
        let of_choices = self.choices.iter().flat_map(|choice| std::iter::once(&choice.label).chain(&choice.why_not));
        std::iter::once(&self.text).chain(of_choices)
    }

    /// What decides, with line numbers.
    pub fn conditions(&self) -> impl Iterator<Item = (usize, &Comparison)> {
        self.choices.iter().flat_map(|choice| choice.conditions.iter().map(|condition| (choice.line, condition)))
    }

    /// Which choices are right: exactly one has to be.
    ///
    /// # Errors
    /// With its line, where `value_of` has no value, or not exactly one choice is right.
    pub fn right(&self, value_of: impl Fn(&Name) -> Result<Value, Wrong>) -> Result<usize, (usize, Wrong)> {
        let mut right = Vec::new();
        for (index, choice) in self.choices.iter().enumerate() {
            if choice.holds(&value_of).map_err(|wrong| (choice.line, wrong))? {
                right.push(index);
            }
        }
        match right[..] {
            [only] => Ok(only),
            _ => Err((self.line, Wrong::Expected(format!("{} choices are right, expected one", right.len())))),
        }
    }
}

impl Choice {
    /// Reads `"LABEL" if VALUE = VALUE, … else "TEXT"`; the last part may be left out.
    pub(super) fn parse(line: usize, rest: &str) -> Result<Self, Wrong> {
        const FORM: &str = "expected \"LABEL\" if VALUE = VALUE else \"WHY NOT\"";
        let wrong = || Wrong::Argument("choice", FORM.into());
        let (label, rest) = rest.strip_prefix('"').and_then(|rest| rest.split_once('"')).ok_or_else(wrong)?;
        let rest = rest.trim().strip_prefix("if ").ok_or_else(wrong)?;
        let (conditions, why_not) = rest.split_once(" else ").map_or((rest, None), |(all, why)| (all, Some(why)));
        let conditions = Comparison::parse_all("choice", conditions)?;
        let why_not = why_not.map(|text| prose(line, &super::prose::quoted("choice", text.trim())?)).transpose()?;
        if label.trim().is_empty() {
            return Err(wrong());
        }
        Ok(Self { line, label: prose(line, label)?, conditions, why_not })
    }

    fn holds(&self, value_of: impl Fn(&Name) -> Result<Value, Wrong>) -> Result<bool, Wrong> {
        for condition in &self.conditions {
            if !condition.holds(&value_of)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Words with values.
fn prose(line: usize, text: &str) -> Result<Paragraph, Wrong> {
    paragraph(&[(line, text)], false).map_err(|(_, wrong)| wrong)
}

impl Paragraph {
    /// The values that it shows, with line numbers.
    pub fn values(&self) -> impl Iterator<Item = (usize, &Expression)> {
        self.parts.iter().filter_map(|part| match &part.content {
            super::Content::Value(expression) => Some((part.line, expression)),
            super::Content::Text(_) => None,
        })
    }
}
