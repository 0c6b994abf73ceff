//! What an option of a run is: its name, its values, what it does, and where it applies.

use std::fmt;
use std::str::FromStr;

use super::{Choices, ParseOptionError};

/// One option.
#[derive(Clone, Copy)]
pub struct Row {
    /// Its name: `--name` on the command line, `name=` in a link, and with `_` for `-` a column's.
    pub name: &'static str,
    /// Another name for it.
    pub alias: Option<&'static str>,
    /// Its values.
    pub values: Values,
    /// What it does, for `--help`.
    pub help: &'static str,
    /// Its label in a panel, and what it does in a few words; `None` if panels do not offer it as it is.
    pub panel: Option<(&'static str, &'static str)>,
    /// Where it has a meaning; panels show it only there.
    pub applies: fn(&Choices) -> bool,
    /// Why this value is refused, in a sentence for the command line.
    pub refused: fn(&Choices) -> Option<Refusal>,
    /// Its value, for a link or a panel.
    get: Get,
    /// Chooses a value, and what goes with it.
    set: Set,
    /// Its value in JSON and tables; `None` if they do not have it, or another option's value includes it.
    recorded: Option<Get>,
    /// Whether it is a column of `passes.csv`.
    pub is_column: bool,
    /// Whether links have it.
    pub is_linked: bool,
}

pub(super) type Get = fn(&Choices) -> Value;
pub(super) type Set = fn(&mut Choices, &str) -> Result<(), String>;

/// What values an option has.
#[derive(Clone, Copy)]
pub enum Values {
    /// One of these names.
    Names(fn() -> Vec<&'static str>),
    /// An integer from the first to the second.
    Whole(u32, u32),
    /// Yes or no; an option without a value on the command line.
    Switch,
    /// `auto`, or numbers of cells along x, y and z.
    Cells,
}

/// The value of an option.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
pub enum Value {
    /// None: it has no meaning with the other options.
    Nothing,
    /// A name, or another text.
    Text(String),
    /// A number.
    Number(u32),
    /// Yes or no.
    Flag(bool),
}

/// Why a value of an option is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It does not go together with the other options.
    Impossible(String),
    /// It would have no effect.
    Idle(String),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => Ok(()),
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => number.fmt(f),
            Self::Flag(flag) => flag.fmt(f),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Impossible(why) | Self::Idle(why)) = self;
        f.write_str(why)
    }
}

impl Refusal {
    /// Why the options do not go together, if that is it.
    #[must_use]
    pub fn impossible(self) -> Option<String> {
        match self {
            Self::Impossible(why) => Some(why),
            Self::Idle(_) => None,
        }
    }
}

impl Row {
    /// A row with nothing but names, to which the table adds.
    pub(super) const fn new(name: &'static str, values: Values, get: Get, set: Set, help: &'static str) -> Self {
        Self {
            name,
            alias: None,
            values,
            help,
            panel: None,
            applies: |_| true,
            refused: |_| None,
            get,
            set,
            recorded: Some(get),
            is_column: false,
            is_linked: true,
        }
    }

    pub(super) const fn alias(self, alias: &'static str) -> Self {
        Self { alias: Some(alias), ..self }
    }

    pub(super) const fn panel(self, label: &'static str, about: &'static str) -> Self {
        Self { panel: Some((label, about)), ..self }
    }

    pub(super) const fn applies(self, applies: fn(&Choices) -> bool) -> Self {
        Self { applies, ..self }
    }

    pub(super) const fn refused(self, refused: fn(&Choices) -> Option<Refusal>) -> Self {
        Self { refused, ..self }
    }

    pub(super) const fn in_tables(self, recorded: Option<Get>) -> Self {
        Self { recorded, ..self }
    }

    pub(super) const fn column(self) -> Self {
        Self { is_column: true, ..self }
    }

    pub(super) const fn unlinked(self) -> Self {
        Self { is_linked: false, ..self }
    }

    /// Its value.
    #[must_use]
    pub fn get(&self, choices: &Choices) -> Value {
        (self.get)(choices)
    }

    /// Chooses a value, and what goes with it.
    ///
    /// # Errors
    /// What would be right, if the option has no such value.
    pub fn set(&self, choices: &mut Choices, text: &str) -> Result<(), String> {
        (self.set)(choices, text)
    }

    /// Its name in JSON and tables.
    #[must_use]
    pub fn key(&self) -> String {
        self.name.replace('-', "_")
    }

    /// Its value there; `None` if it is not there.
    #[must_use]
    pub fn recorded(&self, choices: &Choices) -> Option<Value> {
        Some((self.recorded?)(choices))
    }
}

/// A value as text.
pub(super) fn text(value: impl fmt::Display) -> Value {
    Value::Text(value.to_string())
}

/// Reads a value that has a name.
pub(super) fn parse<T: FromStr<Err = ParseOptionError>>(value: &str, to: &mut T) -> Result<(), String> {
    *to = value.parse().map_err(|e: ParseOptionError| e.to_string())?;
    Ok(())
}

/// Reads an integer within bounds.
pub(super) fn whole(value: &str, least: u32, most: u32) -> Result<u32, String> {
    let number = value.parse().ok().filter(|n| (least..=most).contains(n));
    number.ok_or_else(|| format!("expected an integer from {least} to {most}"))
}
