//! Two values, and how they have to compare.

use super::error::Wrong;
use super::expression::Expression;
use super::{Name, Value};

/// How values compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// Equal.
    Equal,
    /// Not equal.
    Unequal,
    /// Less.
    Less,
    /// Greater.
    Greater,
    /// The first, as text, contains the second.
    Contains,
}

/// What a value is compared with.
#[derive(Clone, Debug, PartialEq)]
pub enum Operand {
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Another value.
    Value(Expression),
}

/// Two values, and how they have to compare.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The first.
    pub first: Expression,
    /// How.
    pub condition: Condition,
    /// The second.
    pub second: Operand,
}

impl Condition {
    const ALL: [(&'static str, Self); 5] = [
        (" = ", Self::Equal),
        (" != ", Self::Unequal),
        (" < ", Self::Less),
        (" > ", Self::Greater),
        (" contains ", Self::Contains),
    ];

    fn word(self) -> &'static str {
        match self {
            Self::Equal => "",
            Self::Unequal => "anything but",
            Self::Less => "less than",
            Self::Greater => "more than",
            Self::Contains => "a text with",
        }
    }

    /// Whether two values compare so: numbers as numbers, everything else as text.
    fn holds(self, first: &Value, second: &Value) -> bool {
        if self == Self::Contains {
            return first.to_string().contains(&second.to_string());
        }
        let (Some(a), Some(b)) = (first.number(), second.number()) else {
            let is_same = first.to_string() == second.to_string();
            return matches!((self, is_same), (Self::Equal, true) | (Self::Unequal, false));
        };
        match self {
            Self::Equal => a == b,
            Self::Unequal => a != b,
            Self::Less => a < b,
            _ => a > b,
        }
    }
}

impl Comparison {
    /// Reads `A = B`, with any of the conditions; `word` is the command, for errors.
    pub(super) fn parse(word: &'static str, text: &str, others: &str) -> Result<Self, Wrong> {
        let found = Condition::ALL.into_iter().find_map(|(mark, condition)| Some((text.split_once(mark)?, condition)));
        let Some(((first, second), condition)) = found else {
            let wanted = format!("expected {others}two values with =, !=, <, > or contains between them");
            return Err(Wrong::Argument(word, wanted));
        };
        let second = second.trim();
        let second = match second.parse::<f64>() {
            Ok(number) if number.is_finite() => Operand::Number(number),
            _ if second.starts_with('"') => Operand::Text(super::prose::quoted(word, second)?),
            _ => Operand::Value(Expression::parse(second)?),
        };
        Ok(Self { first: Expression::parse(first.trim())?, condition, second })
    }

    /// Reads several of them, with commas between them; `word` is the command, for errors.
    pub(super) fn parse_all(word: &'static str, text: &str) -> Result<Vec<Self>, Wrong> {
        let mut is_quoted = false;
        let is_end = |c: char| {
            is_quoted ^= c == '"';
            c == ',' && !is_quoted
        };
        text.split(is_end).map(|part| Self::parse(word, part, "")).collect()
    }

    /// The values that it compares.
    pub fn expressions(&self) -> impl Iterator<Item = &Expression> {
        let second = match &self.second {
            Operand::Value(second) => Some(second),
            Operand::Number(_) | Operand::Text(_) => None,
        };
        std::iter::once(&self.first).chain(second)
    }

    /// Whether it holds.
    ///
    /// # Errors
    /// Where `value_of` has no value.
    pub fn holds(&self, value_of: impl Fn(&Name) -> Result<Value, Wrong>) -> Result<bool, Wrong> {
        self.values(value_of).map(|[first, second]| self.condition.holds(&first, &second))
    }

    /// The two values.
    fn values(&self, value_of: impl Fn(&Name) -> Result<Value, Wrong>) -> Result<[Value; 2], Wrong> {
        let second = match &self.second {
            Operand::Number(number) => Value::double(*number),
            Operand::Text(text) => Value::text(text),
            Operand::Value(second) => second.evaluate(&value_of)?,
        };
        Ok([self.first.evaluate(&value_of)?, second])
    }

    /// That it holds.
    ///
    /// # Errors
    /// Where it does not, or `value_of` has no value.
    pub fn check(&self, value_of: impl Fn(&Name) -> Result<Value, Wrong>) -> Result<(), Wrong> {
        let [first, second] = self.values(value_of)?;
        if self.condition.holds(&first, &second) {
            return Ok(());
        }
        let (name, word) = (&self.first, self.condition.word());
        Err(Wrong::Expected(format!("{name} is {first}, expected {word} {second}")))
    }
}
