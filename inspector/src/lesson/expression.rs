//! A value, or the ratio or difference of two.

use std::fmt;

use super::error::Wrong;
use super::{Name, Value};

/// What connects two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Their ratio.
    Ratio,
    /// Their difference.
    Difference,
}

/// A value, or two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expression {
    /// The first.
    pub first: Name,
    /// The second, and what connects them.
    pub second: Option<(Sign, Name)>,
}

impl Expression {
    /// Reads `A`, `A / B` or `A - B`.
    ///
    /// # Errors
    /// What is not the name of a value.
    pub fn parse(text: &str) -> Result<Self, Wrong> {
        let name = |text: &str| Name::parse(text.trim()).ok_or_else(|| Wrong::Name(text.trim().to_owned()));
        for (mark, sign) in [(" / ", Sign::Ratio), (" - ", Sign::Difference)] {
            if let Some((first, second)) = text.split_once(mark) {
                return Ok(Self { first: name(first)?, second: Some((sign, name(second)?)) });
            }
        }
        Ok(Self { first: name(text)?, second: None })
    }

    /// Its names.
    pub fn names(&self) -> impl Iterator<Item = &Name> {
        std::iter::once(&self.first).chain(self.second.as_ref().map(|(_, name)| name))
    }

    /// Its value.
    ///
    /// # Errors
    /// Where `value_of` has none, or two values do not go together.
    pub fn evaluate(&self, value_of: impl Fn(&Name) -> Result<Value, Wrong>) -> Result<Value, Wrong> {
        let first = value_of(&self.first)?;
        let Some((sign, name)) = &self.second else { return Ok(first) };
        let second = value_of(name)?;
        let fail = |why: &str| Wrong::Unavailable { name: self.to_string(), why: why.to_owned() };
        let (Some(a), Some(b)) = (first.number(), second.number()) else {
            return Err(fail("only numbers have a ratio or a difference"));
        };
        if first.clock() != second.clock() {
            return Err(fail("the two times are from different clocks"));
        }
        match sign {
            Sign::Ratio if b == 0.0 => Err(fail("the second value is 0")),
            Sign::Ratio => Ok(Value::ratio(a / b)),
            Sign::Difference => Ok(match first.clock() {
                Some(_) if a < b => return Err(fail("the first time is shorter")),
                Some(clock) => Value::time((a - b) as u64, clock),
                None if a.fract() == 0.0 && b.fract() == 0.0 && a >= b => Value::count((a - b) as u64),
                None => Value::small(a - b),
            }),
        }
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.first)?;
        match &self.second {
            Some((Sign::Ratio, name)) => write!(f, " / {name}"),
            Some((Sign::Difference, name)) => write!(f, " - {name}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lesson::{Clock, Fact, Field};

    fn value_of(name: &Name) -> Result<Value, Wrong> {
        Ok(match name {
            Name::Fact(Fact::Passes) => Value::count(73),
            Name::Fact(Fact::RayPasses) => Value::count(43),
            Name::Fact(Fact::Misses) => Value::count(0),
            Name::Measured(of, Field::Time) if of == "a" => Value::time(3_000, Clock::Host),
            Name::Measured(_, Field::Time) => Value::time(2_000, Clock::Host),
            Name::Measured(..) => Value::time(2_000, Clock::Device),
            _ => Value::text("a text"),
        })
    }

    #[test]
    fn differences_and_ratios_of_values_are_values() {
        let show = |text: &str| {
            Expression::parse(text).and_then(|e| {
                assert_eq!(e.to_string(), text);
                e.evaluate(value_of).map(|value| value.to_string())
            })
        };
        assert_eq!(show("passes"), Ok("73".into()));
        assert_eq!(show("passes - ray.passes"), Ok("30".into()));
        assert_eq!(show("passes / ray.passes"), Ok("1.70".into()));
        assert_eq!(show("a.time / b.time"), Ok("1.50".into()));
        assert_eq!(show("a.time - b.time"), Ok("1.0 µs (host time)".into()));
        for (text, why) in [
            ("passes / misses", "is 0"),
            ("passes / kernel", "only numbers"),
            ("a.time / b.device-time", "different clocks"),
            ("passes / a.time", "different clocks"),
        ] {
            let error = show(text).expect_err(text).to_string();
            assert!(error.contains(why) && error.starts_with(text), "{error}");
        }
        assert_eq!(show("passes / speed"), Err(Wrong::Name("speed".into())));
    }
}
