//! The header of a PLY file.

use super::super::budget::Budget;
use super::super::text::{self, shown, split_line, split_word};
use super::super::{LoadError, at};

/// How values are written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// The size of a binary value.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    pub(super) fn is_unsigned(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// The largest integer of this type; 1 for floats.
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// One value, or a list with the type of its length.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Scalar(Type),
    List(Type, Type),
}

pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    pub(super) kind: Kind,
}

pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
}

impl Element<'_> {
    /// The type of the first of these properties that is no list.
    pub(super) fn scalar(&self, names: &[&str]) -> Option<Type> {
        self.properties.iter().find_map(|property| match property.kind {
            Kind::Scalar(kind) if names.iter().any(|name| name.as_bytes() == property.name) => Some(kind),
            _ => None,
        })
    }

    /// The place of the property that lists vertices.
    pub(super) fn corners(&self) -> Option<usize> {
        let is_corners = |property: &Property<'_>| {
            matches!(property.name, b"vertex_indices" | b"vertex_index") && matches!(property.kind, Kind::List(..))
        };
        self.properties.iter().position(is_corners)
    }

    /// The smallest size of an entry, with empty lists.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let bytes = self.properties.iter().map(|property| match (encoding, property.kind) {
            // A digit and a blank.
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(kind) | Kind::List(kind, _)) => kind.bytes() as u64,
        });
        bytes.sum()
    }

    /// The error for a file that ends before this entry does.
    pub(super) fn ends(&self, index: u64) -> LoadError {
        self.wrong(index, format!("the file ends before it; the header promises {}", self.count))
    }

    pub(super) fn wrong(&self, index: u64, problem: String) -> LoadError {
        at(format!("{} {index}", shown(self.name)), problem)
    }
}

pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element<'a>>,
}

impl<'a> Header<'a> {
    /// The header, and the bytes after it.
    pub(super) fn read(bytes: &'a [u8], budget: &Budget) -> Result<(Self, &'a [u8]), LoadError> {
        let mut rest = text::trimmed(bytes);
        let mut number = 1 + lines(bytes, rest);
        // A binary payload may start with the other half of "\r\n", so the first line decides what ends a line.
        let (first, after) = split_line(rest);
        if first.trim_ascii() != b"ply" {
            return Err(LoadError::Container("the file does not start with a line 'ply'".into()));
        }
        let ends_by_cr = rest.get(first.len()) == Some(&b'\r') && rest.get(first.len() + 1) != Some(&b'\n');
        rest = after;
        let mut encoding = None;
        let mut elements: Vec<Element<'a>> = Vec::new();
        loop {
            if rest.is_empty() {
                return Err(LoadError::Container("the file ends before the line 'end_header'".into()));
            }
            let end = if ends_by_cr { b'\r' } else { b'\n' };
            let length = rest.iter().position(|&byte| byte == end).unwrap_or(rest.len());
            let (line, after) = (rest.get(..length).unwrap_or_default(), rest.get(length + 1..).unwrap_or_default());
            (rest, number) = (after, number + 1);
            let wrong = |problem: String| LoadError::Line { line: number, problem };
            let (keyword, arguments) = split_word(line);
            match keyword {
                b"end_header" => break,
                b"format" => encoding = Some(format(arguments).map_err(wrong)?),
                b"element" => {
                    budget.push(&mut elements, element(arguments).map_err(wrong)?, "the header")?;
                }
                b"property" => {
                    let property = property(arguments).map_err(wrong)?;
                    let element = elements.last_mut().ok_or_else(|| wrong("a property before any element".into()))?;
                    budget.push(&mut element.properties, property, "the header")?;
                }
                // Comments, and what nobody needs.
                _ => {}
            }
        }
        let encoding = encoding.ok_or_else(|| LoadError::Container("the header has no line 'format'".into()))?;
        Ok((Self { encoding, elements }, rest))
    }
}

/// How many lines end before `rest`, which ends the file.
pub(super) fn lines(bytes: &[u8], rest: &[u8]) -> usize {
    let mut before = bytes.get(..bytes.len() - rest.len()).unwrap_or_default();
    let mut count = 0;
    while before.iter().any(|byte| matches!(byte, b'\n' | b'\r')) {
        before = split_line(before).1;
        count += 1;
    }
    count
}

fn format(arguments: &[u8]) -> Result<Encoding, String> {
    match split_word(arguments).0 {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        other => Err(format!(
            "'{}' is not a format; expected ascii, binary_little_endian or binary_big_endian",
            shown(other)
        )),
    }
}

fn element(arguments: &[u8]) -> Result<Element<'_>, String> {
    let (name, rest) = split_word(arguments);
    let count = split_word(rest).0;
    match std::str::from_utf8(count).ok().and_then(|count| count.parse().ok()) {
        Some(count) => Ok(Element { name, count, properties: Vec::new() }),
        None => Err(format!("'{}' is not a number of elements", shown(count))),
    }
}

fn property(arguments: &[u8]) -> Result<Property<'_>, String> {
    let known = |name| Type::of(name).ok_or_else(|| format!("'{}' is not a type of numbers", shown(name)));
    let (first, rest) = split_word(arguments);
    if first != b"list" {
        return Ok(Property { name: split_word(rest).0, kind: Kind::Scalar(known(first)?) });
    }
    let (count, rest) = split_word(rest);
    let (kind, rest) = split_word(rest);
    Ok(Property { name: split_word(rest).0, kind: Kind::List(known(count)?, known(kind)?) })
}
