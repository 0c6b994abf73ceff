//! The header of an npy file (NEP 1, versions 1.0 to 3.0), and arrays of integers.
//!
//! The crates that read npy parse the header with a grammar of Python's literals, and take whatever length it claims.
//! Three keys need little, and a header of a stranger's stream gets no more memory than [`LONGEST`].

use std::io::Read;

use super::{AT_ONCE, RaysError, fill};

/// Longest header, in bytes. That of an array of plain numbers has about a hundred.
const LONGEST: usize = 1 << 16;

/// The description of an array.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    /// The type of its elements.
    descr: String,
    /// Its size along each axis.
    pub(super) shape: Vec<u64>,
}

impl Header {
    /// Reads the header; the array's bytes follow in the stream.
    pub(super) fn read(input: &mut impl Read) -> Result<Self, RaysError> {
        let mut start = [0; 8];
        if fill(input, &mut start)? < start.len() || start[..6] != *b"\x93NUMPY" {
            return Err(RaysError::NotNpy);
        }
        let mut length = [0; 4];
        let width = match start[6..] {
            [1, 0] => 2,
            [2 | 3, 0] => 4,
            _ => return Err(RaysError::Version(start[6], start[7])),
        };
        let cut = || RaysError::Header("is cut off".into());
        if fill(input, &mut length[..width])? < width {
            return Err(cut());
        }
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST {
            return Err(RaysError::Header(format!("has {length} bytes: expected at most {LONGEST}")));
        }
        let mut text = vec![0; length];
        if fill(input, &mut text)? < length {
            return Err(cut());
        }
        let text = String::from_utf8(text).map_err(|_| RaysError::Header("is not text".into()))?;
        let (header, is_fortran) = Parser { rest: &text }.dictionary().ok_or_else(|| {
            RaysError::Header("is not a dictionary of 'descr', 'fortran_order' and 'shape' as NumPy writes it".into())
        })?;
        // An array of one axis is in both orders.
        if is_fortran && header.shape.len() > 1 {
            return Err(RaysError::Fortran);
        }
        Ok(header)
    }

    /// The type of its elements, one of these.
    pub(super) fn expect_type(&self, types: &[&str], expected: &'static str) -> Result<&str, RaysError> {
        if types.contains(&self.descr.as_str()) {
            return Ok(&self.descr);
        }
        let found = format!("'{}'", self.descr);
        Err(RaysError::Type { found, expected })
    }

    /// The error for a shape that is not `expected`.
    pub(super) fn wrong_shape(&self, expected: impl Into<String>) -> RaysError {
        let sizes: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        let found = if sizes.len() == 1 { format!("({},)", sizes[0]) } else { format!("({})", sizes.join(", ")) };
        RaysError::Shape { found, expected: expected.into() }
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

/// Reads an array of `count` integers.
pub(super) fn integers(mut input: &mut dyn Read, count: u64) -> Result<Vec<u32>, RaysError> {
    const TYPES: [&str; 8] = ["|u1", "|i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8"];
    let header = Header::read(&mut input)?;
    header.expect_type(&TYPES, "an integer type, little-endian")?;
    if header.shape != [count] {
        return Err(header.wrong_shape(format!("({count},), one for each ray")));
    }
    let (is_signed, stride) = (header.descr.as_bytes()[1] == b'i', usize::from(header.descr.as_bytes()[2] - b'0'));
    let mut all: Vec<u32> = Vec::new();
    let mut bytes = Vec::new();
    while (all.len() as u64) < count {
        let wanted = AT_ONCE.min((count - all.len() as u64) as usize);
        bytes.resize(wanted * stride, 0);
        let read = fill(&mut input, &mut bytes)?;
        if read < bytes.len() {
            let after = all.len() as u64 + (read / stride) as u64;
            return Err(RaysError::Truncated { after, rays: Some(count), bytes: read % stride });
        }
        for bytes in bytes.chunks_exact(stride) {
            let is_negative = is_signed && bytes[stride - 1] >= 0x80;
            let mut wide = [if is_negative { 0xff } else { 0 }; 16];
            wide[..stride].copy_from_slice(bytes);
            let value = i128::from_le_bytes(wide);
            all.push(u32::try_from(value).map_err(|_| RaysError::Stratum { index: all.len() as u64, value })?);
        }
    }
    match fill(&mut input, &mut [0])? {
        0 => Ok(all),
        _ => Err(RaysError::Extra { rays: count }),
    }
}
