//! The header of an npy file (NEP 1, versions 1.0 to 3.0).
//!
//! The crates that read npy parse the header with a grammar of Python's literals, and take whatever length it claims.
//! Three keys need little, and a header of a stranger's stream gets no more memory than `LONGEST`.

use std::io::{self, Read};

/// Longest header, in bytes. That of an array of plain numbers has about a hundred.
const LONGEST: usize = 1 << 16;

/// Why a file is not the array that is expected.
#[derive(Debug, thiserror::Error)]
pub enum NpyError {
    /// The stream failed.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is not an npy file.
    #[error("not an npy file: it does not begin with \\x93NUMPY")]
    NotNpy,
    /// A version that is not known.
    #[error("npy version {0}.{1} is not known: expected 1.0, 2.0 or 3.0")]
    Version(u8, u8),
    /// The header cannot be parsed.
    #[error("its npy header {0}")]
    Header(String),
    /// Numbers of another type.
    #[error("its numbers are of type {found}: expected {expected}")]
    Type {
        /// NumPy's name for the type.
        found: String,
        /// The types that are read.
        expected: &'static str,
    },
    /// Column by column.
    #[error("it is in Fortran order: expected C order, as numpy.ascontiguousarray gives")]
    Fortran,
    /// An array of another shape.
    #[error("its shape is {found}: expected {expected}")]
    Shape {
        /// The array's shape, as NumPy writes it.
        found: String,
        /// The shapes that are read.
        expected: String,
    },
}

/// Reads until the buffer is full or the stream ends; returns the number of bytes.
///
/// # Errors
/// If the stream fails.
pub fn fill(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut read = 0;
    while read < buffer.len() {
        match input.read(&mut buffer[read..]) {
            Ok(0) => break,
            Ok(more) => read += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(read)
}

/// The description of an array.
#[derive(Debug, PartialEq)]
pub struct Header {
    /// The type of its elements.
    pub descr: String,
    /// Its size along each axis.
    pub shape: Vec<u64>,
}

impl Header {
    /// Reads the header; the array's bytes follow in the stream.
    ///
    /// # Errors
    /// If it is not the header of an array in C order.
    pub fn read(input: &mut impl Read) -> Result<Self, NpyError> {
        let mut start = [0; 8];
        if fill(input, &mut start)? < start.len() || start[..6] != *b"\x93NUMPY" {
            return Err(NpyError::NotNpy);
        }
        let mut length = [0; 4];
        let width = match start[6..] {
            [1, 0] => 2,
            [2 | 3, 0] => 4,
            _ => return Err(NpyError::Version(start[6], start[7])),
        };
        let cut = || NpyError::Header("is cut off".into());
        if fill(input, &mut length[..width])? < width {
            return Err(cut());
        }
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST {
            return Err(NpyError::Header(format!("has {length} bytes: expected at most {LONGEST}")));
        }
        let mut text = vec![0; length];
        if fill(input, &mut text)? < length {
            return Err(cut());
        }
        let text = String::from_utf8(text).map_err(|_| NpyError::Header("is not text".into()))?;
        let (header, is_fortran) = Parser { rest: &text }.dictionary().ok_or_else(|| {
            NpyError::Header("is not a dictionary of 'descr', 'fortran_order' and 'shape' as NumPy writes it".into())
        })?;
        // An array of one axis is in both orders.
        if is_fortran && header.shape.len() > 1 {
            return Err(NpyError::Fortran);
        }
        Ok(header)
    }

    /// The type of its elements, one of these.
    ///
    /// # Errors
    /// If it is another.
    pub fn expect_type(&self, types: &[&str], expected: &'static str) -> Result<&str, NpyError> {
        if types.contains(&self.descr.as_str()) {
            return Ok(&self.descr);
        }
        let found = format!("'{}'", self.descr);
        Err(NpyError::Type { found, expected })
    }

    /// The error for a shape that is not `expected`.
    #[must_use]
    pub fn wrong_shape(&self, expected: impl Into<String>) -> NpyError {
        let sizes: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        let found = if sizes.len() == 1 { format!("({},)", sizes[0]) } else { format!("({})", sizes.join(", ")) };
        NpyError::Shape { found, expected: expected.into() }
    }
}

/// What is left of a header.
struct Parser<'a> {
    rest: &'a str,
}

impl<'a> Parser<'a> {
    /// The whole header, and whether the array is in Fortran order.
    fn dictionary(mut self) -> Option<(Header, bool)> {
        let (mut descr, mut order, mut shape) = (None, None, None);
        self.take("{")?;
        while self.take("}").is_none() {
            let key = self.string()?;
            self.take(":")?;
            match key {
                "descr" => descr = Some(self.descr()?),
                "fortran_order" => order = Some(self.boolean()?),
                "shape" => shape = Some(self.shape()?),
                _ => return None,
            }
            if self.take(",").is_none() {
                self.take("}")?;
                break;
            }
        }
        self.rest.trim().is_empty().then_some((Header { descr: descr?, shape: shape? }, order?))
    }

    /// Skips white space, then the text if it is next.
    fn take(&mut self, text: &str) -> Option<()> {
        self.rest = self.rest.trim_start().strip_prefix(text)?;
        Some(())
    }

    fn boolean(&mut self) -> Option<bool> {
        if self.take("True").is_some() {
            return Some(true);
        }
        self.take("False").map(|()| false)
    }

    fn string(&mut self) -> Option<&'a str> {
        let rest = self.rest.trim_start();
        let quote = rest.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
        let (text, rest) = rest[1..].split_once(quote)?;
        self.rest = rest;
        Some(text)
    }

    /// A type: its name, or for a structured one its text.
    fn descr(&mut self) -> Option<String> {
        if let Some(name) = self.string() {
            return Some(name.to_owned());
        }
        let rest = self.rest.trim_start().strip_prefix('[')?;
        let (fields, rest) = rest.split_once(']')?;
        self.rest = rest;
        Some(format!("[{fields}]"))
    }

    fn shape(&mut self) -> Option<Vec<u64>> {
        self.take("(")?;
        let mut shape = Vec::new();
        while self.take(")").is_none() {
            let rest = self.rest.trim_start();
            let digits = rest.find(|c: char| !c.is_ascii_digit())?;
            shape.push(rest[..digits].parse().ok()?);
            // Python 2 wrote long integers with an L.
            self.rest = rest[digits..].strip_prefix('L').unwrap_or(&rest[digits..]);
            if self.take(",").is_none() {
                self.take(")")?;
                break;
            }
        }
        Some(shape)
    }
}
