//! The JSON of a glTF file, as far as it is read. Types of the format that have names or numbers are those of the crate
//! `gltf`. Its documents are not used: they hold f32 where f64 is needed, cut indices to 32 bits, and one wrong value
//! costs all of them.
//!
//! A wrong value costs only itself: every property and every element of a list is either a value, or missing, or wrong,
//! and whoever needs it asks with [`Property::get`]. Numbers are f64, exactly as written; integers may be written as
//! `1.0` or `10e-1`, as JSON allows.

mod objects;

pub(super) use objects::*;

use super::json_path::path_of;
use super::{LoadError, at};
use gltf::json::validation::Checked;
use serde::Deserialize;
use serde::de::value::U32Deserializer;
use serde::de::{DeserializeOwned, Deserializer, Error, IntoDeserializer, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;

/// What is wrong with a value: the place within it, empty or beginning with `.` or `[`, and the problem.
#[derive(Debug)]
struct Fault {
    place: String,
    problem: String,
}

/// A property of an object, or an element of a list.
#[derive(Debug)]
pub(super) struct Property<T>(Result<Option<T>, Box<Fault>>);

/// A list whose elements are wrong one by one.
pub(super) type List<T> = Property<Vec<Property<T>>>;

impl<T> Default for Property<T> {
    fn default() -> Self {
        Self(Ok(None))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Property<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Some(raw) = <Option<&'de RawValue>>::deserialize(deserializer)? else { return Ok(Self::default()) };
        Ok(Self(serde_json::from_str(raw.get()).map(Some).map_err(|error| Box::new(fault(raw.get(), &error)))))
    }
}

fn fault(text: &str, error: &serde_json::Error) -> Fault {
    let path = path_of(text, error);
    let place = if path.is_empty() || path.starts_with('[') { path } else { format!(".{path}") };
    // Lines and columns are those of this value, not of the file.
    let problem = error.to_string();
    let problem = problem.rsplit_once(" at line ").map_or(problem.as_str(), |(problem, _)| problem).to_owned();
    Fault { place, problem }
}

impl<T> Property<T> {
    /// The value, if there is one; an error at `path` if it is wrong.
    pub(super) fn get(&self, path: impl FnOnce() -> String) -> Result<Option<&T>, LoadError> {
        match &self.0 {
            Ok(value) => Ok(value.as_ref()),
            Err(fault) => Err(at(format!("{}{}", path(), fault.place), fault.problem.as_str())),
        }
    }

    /// The value, or an error if it is missing or wrong.
    pub(super) fn need(&self, path: impl Fn() -> String) -> Result<&T, LoadError> {
        self.get(&path)?.ok_or_else(|| at(path(), "is missing"))
    }

    /// The value, unless it is missing or wrong: for what does not matter.
    pub(super) fn ok(&self) -> Option<&T> {
        self.0.as_ref().ok()?.as_ref()
    }
}

impl<T> List<T> {
    /// The elements; none if the list is missing or wrong.
    pub(super) fn elements(&self) -> &[Property<T>] {
        self.ok().map_or(&[], Vec::as_slice)
    }

    /// The element that the index at `path` refers to. `name` is the list's, `what` that of an element.
    pub(super) fn at(&self, index: Int, path: &str, (name, what): (&str, &str)) -> Result<&T, LoadError> {
        let elements = self.get(|| name.to_owned())?.map_or(&[][..], Vec::as_slice);
        let Some(element) = elements.get(index.index()) else {
            let count = elements.len();
            return Err(at(path, format!("refers to {what} {index}, but the file has {count} (counted from 0)")));
        };
        element.need(|| format!("{name}[{index}]"))
    }
}

/// A whole number of at least 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Int(pub(super) u64);

impl Int {
    /// The number as an index; one that is too large for this machine is beyond every list.
    pub(super) fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl fmt::Display for Int {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<'de> Deserialize<'de> for Int {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// Up to here, every integer is an f64.
        const EXACT: f64 = (1_u64 << 53) as f64;
        let text = <&RawValue>::deserialize(deserializer)?.get();
        let whole = |value: &f64| value.fract() == 0.0 && (0.0..=EXACT).contains(value);
        let value = text.parse().ok().or_else(|| text.parse().ok().filter(whole).map(|value| value as u64));
        value.map(Self).ok_or_else(|| D::Error::custom(format!("{} is no whole number of at least 0", short(text))))
    }
}

/// A number as it is written, to the nearest f64; infinite beyond those.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number(pub(super) f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = <&RawValue>::deserialize(deserializer)?.get();
        text.parse().map(Self).map_err(|_| D::Error::custom(format!("{} is no number", short(text))))
    }
}

/// The start of a value, for messages.
fn short(text: &str) -> Cow<'_, str> {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        None => text.into(),
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or_default()).into(),
    }
}

/// A value of one of the format's enumerations, by its number in the file.
fn known_number<T>(code: Int) -> Option<T>
where
    Checked<T>: DeserializeOwned,
{
    let code: U32Deserializer<serde::de::value::Error> = u32::try_from(code.0).ok()?.into_deserializer();
    match Checked::<T>::deserialize(code).ok()? {
        Checked::Valid(value) => Some(value),
        Checked::Invalid => None,
    }
}

impl Property<Int> {
    /// The value of an enumeration whose number this is, or `default`; an error with the expected ones if it is unknown.
    pub(super) fn known_or<T>(&self, default: T, path: impl Fn() -> String, expected: &str) -> Result<T, LoadError>
    where
        Checked<T>: DeserializeOwned,
    {
        let Some(code) = self.get(&path)? else { return Ok(default) };
        known_number(*code).ok_or_else(|| at(path(), format!("is {code}; expected {expected}")))
    }
}

impl<T: Copy> Property<Checked<T>> {
    /// The value, if there is one; an error with the expected ones if it is unknown.
    pub(super) fn known(&self, path: impl Fn() -> String, expected: &str) -> Result<Option<T>, LoadError> {
        match self.get(&path)? {
            None => Ok(None),
            Some(Checked::Valid(value)) => Ok(Some(*value)),
            Some(Checked::Invalid) => Err(at(path(), format!("is not a known value; expected {expected}"))),
        }
    }

    /// The same where it must not be missing.
    pub(super) fn need_known(&self, path: impl Fn() -> String, expected: &str) -> Result<T, LoadError> {
        self.known(&path, expected)?.ok_or_else(|| at(path(), "is missing"))
    }
}

impl Property<Number> {
    /// The number, or `default` if there is none. Not finite or wrong is an error.
    pub(super) fn number(&self, default: f64, path: impl Fn() -> String) -> Result<f64, LoadError> {
        let value = self.get(&path)?.map_or(default, |value| value.0);
        finite(value, path)
    }
}

impl Property<Vec<Number>> {
    /// Exactly `N` finite numbers, if there are any.
    pub(super) fn numbers<const N: usize>(&self, path: impl Fn() -> String) -> Result<Option<[f64; N]>, LoadError> {
        let Some(values) = self.get(&path)? else { return Ok(None) };
        if values.len() != N {
            return Err(at(path(), format!("has {} numbers; expected {N}", values.len())));
        }
        self.first_numbers(path)
    }

    /// The first `N` numbers, if there are any; those after them do not matter.
    pub(super) fn first_numbers<const N: usize>(
        &self,
        path: impl Fn() -> String,
    ) -> Result<Option<[f64; N]>, LoadError> {
        let Some(values) = self.get(&path)? else { return Ok(None) };
        let Some(values) = values.first_chunk::<N>() else {
            return Err(at(path(), format!("has {} numbers; expected {N}", values.len())));
        };
        for value in values {
            finite(value.0, &path)?;
        }
        Ok(Some(values.map(|value| value.0)))
    }
}

fn finite(value: f64, path: impl Fn() -> String) -> Result<f64, LoadError> {
    if value.is_finite() { Ok(value) } else { Err(at(path(), format!("{value} is not a finite number"))) }
}

/// A string, without a copy where it has no escape sequences.
#[derive(Debug)]
pub(super) struct Text<'a>(pub(super) Cow<'a, str>);

impl<'de: 'a, 'a> Deserialize<'de> for Text<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Borrowed;

        impl<'de> Visitor<'de> for Borrowed {
            type Value = Text<'de>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a string")
            }

            fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Self::Value, E> {
                Ok(Text(Cow::Borrowed(text)))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
                Ok(Text(Cow::Owned(text.to_owned())))
            }
        }

        deserializer.deserialize_str(Borrowed)
    }
}

/// Reads the whole text.
pub(super) fn read(text: &str) -> Result<Root<'_>, LoadError> {
    serde_json::from_str(text).map_err(|error| {
        let path = path_of(text, &error);
        LoadError::Json(if path.is_empty() { error.to_string() } else { format!("{path}: {error}") })
    })
}
