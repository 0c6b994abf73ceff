//! Rays from files of other programs, read in batches from any stream.
//!
//! | format | content |
//! |---|---|
//! | npy | a NumPy array of float32 or float64, little-endian, in C order: N×6 (origin, direction) or N×8 (origin, t_min, direction, t_max); t in multiples of the direction, t_max may be infinite |
//! | f32 | nothing but float32, little-endian, eight per ray: origin, unused, direction, unused |
//!
//! Strata, which say of each ray to which group it belongs, are an npy array of N integers from 0 to 2³² − 1, of any
//! integer type.

mod npy;

use std::io::{self, Read};

use glam::DVec3;
use raystep_kernels::named;
use raystep_kernels::numbers::npy::{Header, NpyError, fill};
pub use raystep_kernels::options::FileRay;
use raystep_kernels::options::{Ray, RayColumns, RayLayout};
use raystep_scenes::Scene;

use crate::Hash;

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

/// What becomes of a ray that cannot be traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BadRays {
    /// An error.
    #[default]
    Error,
    /// It hits nothing, and is counted.
    Miss,
}

named!(BadRays, "error, miss", Error "error", Miss "miss");

/// Rays of a file in a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// The rays.
    pub rays: Vec<Ray>,
    /// The indices of those that cannot be traced, ascending: others stand there in their place.
    pub bad: Vec<usize>,
}

impl Batch {
    /// Replaces a ray that cannot be traced.
    pub fn replace(&mut self, index: usize) {
        self.rays[index] = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
        self.bad.push(index);
    }
}

/// Why rays cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RaysError {
    /// The stream failed.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is not the array of an npy file that is expected.
    #[error(transparent)]
    Npy(#[from] NpyError),
    /// It ends too early.
    #[error("it ends {bytes} bytes into ray {after} (counted from 0, of {})", of(*rays))]
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
    layout: RayLayout,
    bad_rays: BadRays,
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
        let (layout, total) = match format {
            RaysFormat::F32 => (RayLayout { is_wide: false, columns: RayColumns::Padded }, rays),
            RaysFormat::Npy => {
                let header = Header::read(&mut input)?;
                let types = ["<f4", "<f8"];
                let found = header.expect_type(&types, "'<f4' or '<f8' (float32 or float64, little-endian)")?;
                let is_wide = found == types[1];
                match header.shape[..] {
                    [rays, 6] => (RayLayout { is_wide, columns: RayColumns::Plain }, Some(rays)),
                    [rays, 8] => (RayLayout { is_wide, columns: RayColumns::WithInterval }, Some(rays)),
                    _ => return Err(header.wrong_shape("(N, 6) or (N, 8)").into()),
                }
            }
        };
        Ok(Self { input, layout, bad_rays: BadRays::default(), total, done: 0, bytes: Vec::new() })
    }

    /// What becomes of rays that cannot be traced in any scene.
    #[must_use]
    pub fn with_bad_rays(self, bad_rays: BadRays) -> Self {
        Self { bad_rays, ..self }
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

    /// Appends up to `most` rays in a scene with this offset; returns how many, 0 at the end. Takes memory for `most`
    /// rays, or for all that are left if those are fewer.
    ///
    /// # Errors
    /// If the stream fails or ends within a ray, or a ray cannot be traced in any scene.
    pub fn read(&mut self, most: usize, offset: DVec3, batch: &mut Batch) -> Result<usize, RaysError> {
        let (count, end) = self.fill(most)?;
        let first = batch.rays.len();
        self.layout.rays_in_scene(&self.bytes[..count * self.layout.stride()], offset, &mut batch.rays);
        let mut from = first;
        while let Some((index, reason)) = Ray::first_fault(&batch.rays[from..]) {
            if self.bad_rays == BadRays::Error {
                return Err(self.wrong(from + index - first, reason));
            }
            batch.replace(from + index);
            from += index + 1;
        }
        self.done += count as u64;
        end.map(|()| count)
    }

    /// Hands on up to `most` rays, and ends with an error where `take` tells one.
    fn read_each(
        &mut self,
        most: usize,
        mut take: impl FnMut(FileRay) -> Option<&'static str>,
    ) -> Result<usize, RaysError> {
        let (count, end) = self.fill(most)?;
        for (index, ray) in self.bytes.chunks_exact(self.layout.stride()).take(count).enumerate() {
            if let Some(reason) = take(self.layout.ray(ray)) {
                return Err(self.wrong(index, reason));
            }
        }
        self.done += count as u64;
        end.map(|()| count)
    }

    /// Reads the bytes of up to `most` rays. Returns how many are complete, and the error if there should be more.
    fn fill(&mut self, most: usize) -> Result<(usize, Result<(), RaysError>), RaysError> {
        let left = self.total.map_or(u64::MAX, |total| total - self.done);
        let wanted = most.min(usize::try_from(left).unwrap_or(usize::MAX));
        let stride = self.layout.stride();
        self.bytes.resize(wanted * stride, 0);
        let read = fill(&mut self.input, &mut self.bytes)?;
        let (count, bytes) = (read / stride, read % stride);
        let is_short = bytes > 0 || (count < wanted && self.total.is_some());
        let truncated = RaysError::Truncated { after: self.done + count as u64, rays: self.total, bytes };
        Ok((count, if is_short { Err(truncated) } else { Ok(()) }))
    }

    /// The error of a ray among those that were read last.
    fn wrong(&self, index: usize, reason: &'static str) -> RaysError {
        RaysError::Ray { index: self.done + index as u64, rays: self.total, reason }
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

/// All rays of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct RaysFile {
    /// The rays.
    pub rays: Vec<FileRay>,
    /// The stratum of each ray, if there is a file of them.
    pub strata: Option<Vec<u32>>,
    /// Hash of the rays' numbers: origin, t_min, direction, t_max. The same rays have the same hash in every format.
    pub hash: Hash,
}

impl RaysFile {
    /// The rays in a scene.
    #[must_use]
    pub fn in_scene(&self, scene: &Scene) -> Vec<Ray> {
        self.rays.iter().map(|ray| ray.in_scene(scene.offset)).collect()
    }
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
        let read = reader.read_each(AT_ONCE, |ray| {
            let ([ox, oy, oz], [dx, dy, dz], [t_min, t_max]) = (ray.origin, ray.direction, ray.interval);
            for number in [ox, oy, oz, t_min.into(), dx.into(), dy.into(), dz.into(), t_max.into()] {
                // What f32 represents has the same hash in both widths.
                let short = number as f32;
                match f64::from(short).to_bits() == number.to_bits() {
                    true => hash.add(&short.to_le_bytes()),
                    false => hash.add(&number.to_le_bytes()),
                }
            }
            all.push(ray);
            ray.in_scene(DVec3::ZERO).fault()
        })?;
        if read == 0 {
            break;
        }
    }
    reader.finish()?;
    let strata = strata.map(|strata| npy::integers(strata, all.len() as u64)).transpose();
    let strata = strata.map_err(|error| RaysError::Strata(Box::new(error)))?;
    Ok(RaysFile { rays: all, strata, hash })
}

#[cfg(test)]
mod tests;
