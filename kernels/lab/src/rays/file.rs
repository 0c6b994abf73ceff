//! Rays from files of other programs, read in batches from any stream.
//!
//! | format | content |
//! |---|---|
//! | npy | a NumPy array of float32, little-endian, in C order: N×6 (origin, direction) or N×8 (origin, t_min, direction, t_max); t in multiples of the direction, t_max may be infinite |
//! | f32 | nothing but float32, little-endian, eight per ray: origin, unused, direction, unused |
//!
//! Strata, which say of each ray to which group it belongs, are an npy array of N integers from 0 to 2³² − 1, of any
//! integer type.

mod npy;

use std::io::{self, Read};

use raystep_kernels::named;
use raystep_kernels::options::Ray;

use crate::Hash;
use npy::Header;

/// Rays or strata converted at a time by [`read_all`].
const AT_ONCE: usize = 1 << 16;

/// How rays are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RaysFormat {
    /// A NumPy array.
    #[default]
    Npy,
    /// Eight float32 per ray and nothing else.
    F32,
}

named!(RaysFormat, "npy, f32", Npy "npy", F32 "f32");

/// Why rays cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RaysError {
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
    /// It ends too early.
    #[error("it ends in ray {after} of {}, after {bytes} bytes of it", of(*rays))]
    Truncated {
        /// The ray, numbered from 0.
        after: u64,
        /// Number of rays, if known.
        rays: Option<u64>,
        /// Bytes of that ray that are there.
        bytes: usize,
    },
    /// It has more than its header says.
    #[error("it goes on after its {rays} rays")]
    Extra {
        /// Number of rays.
        rays: u64,
    },
    /// A ray that cannot be traced.
    #[error("ray {index} (counted from 0, of {}): {reason}", of(*rays))]
    Ray {
        /// Its number.
        index: u64,
        /// Number of rays, if known.
        rays: Option<u64>,
        /// What is wrong.
        reason: &'static str,
    },
    /// More rays than the caller has room for.
    #[error("it has {}, at most {most} are read here", of(*rays))]
    TooMany {
        /// Number of rays, if known.
        rays: Option<u64>,
        /// Most rays.
        most: u64,
    },
    /// A problem of the strata.
    #[error("the strata: {0}")]
    Strata(Box<RaysError>),
    /// A stratum out of range.
    #[error("number {index} is {value}: expected 0 to 4294967295")]
    Stratum {
        /// Its place, from 0.
        index: u64,
        /// The number.
        value: i128,
    },
}

/// A number of rays in words.
fn of(rays: Option<u64>) -> String {
    rays.map_or_else(|| "an unknown number".into(), |rays| rays.to_string())
}

/// Reads rays in batches.
pub struct RaysReader<R> {
    input: R,
    /// Numbers per ray.
    columns: usize,
    /// Whether the fourth and eighth of eight numbers are t_min and t_max.
    has_intervals: bool,
    total: Option<u64>,
    done: u64,
    bytes: Vec<u8>,
}

impl<R: Read> RaysReader<R> {
    /// Reads the header of an npy file. `rays` is the number of rays in a format that does not contain it, if known.
    ///
    /// # Errors
    /// If the stream fails, or has no rays in this format.
    pub fn new(mut input: R, format: RaysFormat, rays: Option<u64>) -> Result<Self, RaysError> {
        let (columns, has_intervals, total) = match format {
            RaysFormat::F32 => (8, false, rays),
            RaysFormat::Npy => {
                let header = Header::read(&mut input)?;
                header.expect_type(&["<f4"], "'<f4' (float32, little-endian)")?;
                match header.shape[..] {
                    [rays, columns @ (6 | 8)] => (columns as usize, columns == 8, Some(rays)),
                    _ => return Err(header.wrong_shape("(N, 6) or (N, 8)")),
                }
            }
        };
        Ok(Self { input, columns, has_intervals, total, done: 0, bytes: Vec::new() })
    }

    /// Number of rays, if it is known before the end.
    #[must_use]
    pub fn total(&self) -> Option<u64> {
        self.total
    }

    /// Number of rays read so far.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Appends up to `most` rays; returns how many, 0 at the end. Takes memory for `most` rays, or for all that are
    /// left if those are fewer.
    ///
    /// # Errors
    /// If the stream fails or ends within a ray, or a ray cannot be traced in any scene.
    pub fn read(&mut self, most: usize, rays: &mut Vec<Ray>) -> Result<usize, RaysError> {
        let left = self.total.map_or(u64::MAX, |total| total - self.done);
        let wanted = most.min(usize::try_from(left).unwrap_or(usize::MAX));
        let stride = 4 * self.columns;
        self.bytes.resize(wanted * stride, 0);
        let read = fill(&mut self.input, &mut self.bytes)?;
        let (count, rest) = (read / stride, read % stride);
        rays.reserve(count);
        for ray in self.bytes[..count * stride].chunks_exact(stride) {
            let ray = self.ray(ray);
            if let Some(reason) = ray.fault() {
                return Err(RaysError::Ray { index: self.done, rays: self.total, reason });
            }
            rays.push(ray);
            self.done += 1;
        }
        if rest > 0 || (count < wanted && self.total.is_some()) {
            return Err(RaysError::Truncated { after: self.done, rays: self.total, bytes: rest });
        }
        Ok(count)
    }

    /// The ray in these bytes.
    fn ray(&self, bytes: &[u8]) -> Ray {
        let number =
            |i: usize| f32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
        let three = |i: usize| [number(i), number(i + 1), number(i + 2)];
        match (self.columns, self.has_intervals) {
            (6, _) => Ray::new(three(0), three(3)),
            (_, true) => Ray::new(three(0), three(4)).between(number(3), number(7)),
            (_, false) => Ray::new(three(0), three(4)),
        }
    }

    /// Checks that nothing follows the last ray.
    ///
    /// # Errors
    /// If something does, or the stream fails.
    pub fn finish(mut self) -> Result<(), RaysError> {
        match fill(&mut self.input, &mut [0])? {
            0 => Ok(()),
            _ => Err(RaysError::Extra { rays: self.done }),
        }
    }
}

/// Reads until the buffer is full or the stream ends; returns the number of bytes.
fn fill(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
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

/// All rays of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct RaysFile {
    /// The rays.
    pub rays: Vec<Ray>,
    /// The stratum of each ray, if there is a file of them.
    pub strata: Option<Vec<u32>>,
    /// Hash of the rays' numbers: origin, t_min, direction, t_max. The same rays have the same hash in every format.
    pub hash: Hash,
}

/// Reads all rays of a file, and their strata, if there are at most `most`.
///
/// # Errors
/// As for [`RaysReader`]; if there are too many rays, or not as many strata as rays.
pub fn read_all(
    rays: impl Read,
    format: RaysFormat,
    strata: Option<&mut dyn Read>,
    most: u64,
) -> Result<RaysFile, RaysError> {
    let mut reader = RaysReader::new(rays, format, None)?;
    let (mut all, mut hash) = (Vec::new(), Hash::default());
    loop {
        let total = reader.total().unwrap_or(all.len() as u64);
        if total.max(all.len() as u64) > most {
            return Err(RaysError::TooMany { rays: reader.total(), most });
        }
        let first = all.len();
        if reader.read(AT_ONCE, &mut all)? == 0 {
            break;
        }
        for ray in &all[first..] {
            let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.direction);
            for number in [ox, oy, oz, ray.t_min, dx, dy, dz, ray.t_max] {
                hash.add(&number.to_le_bytes());
            }
        }
    }
    reader.finish()?;
    let strata = strata.map(|strata| npy::integers(strata, all.len() as u64)).transpose();
    let strata = strata.map_err(|error| RaysError::Strata(Box::new(error)))?;
    Ok(RaysFile { rays: all, strata, hash })
}

#[cfg(test)]
mod tests;
