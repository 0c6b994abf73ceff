//! The values of a PLY file, one after the other.

use super::super::LoadError;
use super::super::text::{number, shown, split_line, split_word};
use super::header::{Element, Encoding, Header, Kind, Property, Type, lines};

/// What follows the header.
pub(super) struct Values<'a> {
    encoding: Encoding,
    bytes: &'a [u8],
    /// What is not read yet.
    rest: &'a [u8],
}

impl<'a> Values<'a> {
    /// `payload` ends the file `bytes`.
    pub(super) fn new(header: &Header<'_>, bytes: &'a [u8], payload: &'a [u8]) -> Self {
        Self { encoding: header.encoding, bytes, rest: payload }
    }

    /// Rejects an element that the file is too short for, before memory is taken for it.
    pub(super) fn expect(&self, element: &Element<'_>) -> Result<(), LoadError> {
        let least = u128::from(element.count) * u128::from(element.least_bytes(self.encoding));
        // The last value of a text may lack its newline.
        if least <= self.rest.len() as u128 + 1 {
            return Ok(());
        }
        let (name, left) = (shown(element.name), self.rest.len());
        let problem =
            format!("the {} of '{name}' take at least {least} bytes, but only {left} are left", element.count);
        Err(LoadError::Container(problem))
    }

    /// The next value, NaN for a word that is no number; `None` at the end of the file.
    pub(super) fn next(&mut self, kind: Type) -> Option<f64> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            return Some(number(word));
        }
        let (value, rest) = self.rest.split_at_checked(kind.bytes())?;
        self.rest = rest;
        let mut bytes = [0; 8];
        bytes.get_mut(..value.len())?.copy_from_slice(value);
        if self.encoding == Encoding::BigEndian {
            bytes.get_mut(..value.len())?.reverse();
        }
        let [a, b, c, d, ..] = bytes;
        Some(match kind {
            Type::I8 => i8::from_le_bytes([a]).into(),
            Type::U8 => a.into(),
            Type::I16 => i16::from_le_bytes([a, b]).into(),
            Type::U16 => u16::from_le_bytes([a, b]).into(),
            Type::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Type::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Type::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Type::F64 => f64::from_le_bytes(bytes),
        })
    }

    /// Ends an entry of an element. In a text, what else is on its line belongs to nothing: some programs write more than
    /// their headers say.
    pub(super) fn end_entry(&mut self) {
        if self.encoding == Encoding::Ascii {
            self.rest = split_line(self.rest).1;
        }
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let (word, rest) = split_word(self.rest);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    /// The length of a list.
    pub(super) fn count(&mut self, kind: Type, element: &Element<'_>, index: u64) -> Result<u64, LoadError> {
        let before = self.rest;
        let count = self.next(kind).ok_or_else(|| element.ends(index))?;
        if count >= 0.0 && count <= u32::MAX.into() && count.fract() == 0.0 {
            return Ok(count as u64);
        }
        if self.encoding == Encoding::Ascii {
            let before = before.trim_ascii_start();
            let problem = format!("'{}' is not the length of a list", shown(split_word(before).0));
            return Err(LoadError::Line { line: 1 + lines(self.bytes, before), problem });
        }
        Err(element.wrong(index, format!("its list has {count} entries; expected a whole number from 0")))
    }

    /// Skips a property of one entry.
    pub(super) fn skip_property(
        &mut self,
        property: &Property<'_>,
        element: &Element<'_>,
        index: u64,
    ) -> Result<(), LoadError> {
        let (count, kind) = match property.kind {
            Kind::Scalar(kind) => (1, kind),
            Kind::List(count, kind) => (self.count(count, element, index)?, kind),
        };
        self.skip_values(count, kind.bytes() as u64).ok_or_else(|| element.ends(index))
    }

    /// Skips all entries of an element.
    pub(super) fn skip(&mut self, element: &Element<'_>) -> Result<(), LoadError> {
        if element.properties.is_empty() {
            // Its entries take no bytes, so there may be any number of them.
            return Ok(());
        }
        for index in 0..element.count {
            for property in &element.properties {
                self.skip_property(property, element, index)?;
            }
            self.end_entry();
        }
        Ok(())
    }

    /// Skips values, which take so many bytes each in a binary file.
    fn skip_values(&mut self, count: u64, bytes: u64) -> Option<()> {
        if self.encoding == Encoding::Ascii {
            return (0..count).try_for_each(|_| self.word().map(drop));
        }
        let bytes = usize::try_from(count.checked_mul(bytes)?).ok()?;
        self.rest = self.rest.get(bytes..)?;
        Some(())
    }
}
