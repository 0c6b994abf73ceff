//! How the conditions of a kernel came out for many rays in one pass, and what it took.

use std::ops::Range;

use super::{Counter, Element, InterpretError, Interpreter, Outcomes, Stopped, Work};
use crate::numbers::parallel::map_ranges;
use crate::scene_data::SceneData;
use crate::shader::Printed;
use crate::tables::kernel::Role;
use crate::tables::stream::StreamData;

/// The streams of all rays before a pass.
#[derive(Clone, Copy, Debug)]
pub struct Many<'a> {
    /// The kernel.
    pub kernel: &'a Interpreter,
    /// The scene as the kernel reads it.
    pub data: &'a SceneData,
    /// Its streams, in the order of [`Interpreter::streams`].
    pub streams: &'a [StreamData],
}

/// An element could not be run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{why}")]
pub struct FailedAt {
    /// Why.
    pub why: InterpretError,
    /// Which element of its set.
    pub element: usize,
    /// The lines of the composed source, from 1, that it ran last: in the function that ran, in the one that called it, and
    /// so on.
    pub lines: Vec<usize>,
}

/// Rays per task.
const CHUNK: usize = 256;

impl Many<'_> {
    /// Columns and rows of the streams.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.streams.first().map_or([0; 2], |stream| [stream.width, stream.height])
    }

    /// How conditions came out for consecutive rays, on all cores; `None` for a ray that the kernel does not work on.
    ///
    /// # Errors
    /// As [`Interpreter::record`], for the first such ray.
    pub fn outcomes(&self, rays: Range<usize>) -> Result<Vec<Option<Outcomes>>, InterpretError> {
        self.outcomes_and_runs(rays).map(|(outcomes, _)| outcomes)
    }

    /// The same, and how often the rays ran each statement together, in the order of [`Interpreter::statements`].
    ///
    /// # Errors
    /// As [`Interpreter::record`], for the first such ray.
    pub fn outcomes_and_runs(&self, rays: Range<usize>) -> Result<(Vec<Option<Outcomes>>, Vec<u64>), InterpretError> {
        let chunks = self.in_chunks(rays, |rays, counter| {
            let mut texels = vec![0; self.kernel.components()];
            let outcomes = rays.map(|ray| self.one(ray, counter, &mut texels)).collect::<Result<Vec<_>, _>>()?;
            Ok((outcomes, counter.runs().to_vec()))
        })?;
        let (mut outcomes, mut sum) = (Vec::new(), vec![0; self.kernel.statements().len()]);
        for (of_chunk, runs) in chunks {
            outcomes.extend(of_chunk);
            sum.iter_mut().zip(runs).for_each(|(sum, runs)| *sum += runs);
        }
        Ok((outcomes, sum))
    }

    /// What consecutive rays print, on all cores, in the order of [`Interpreter::notes`]: the last value of each note, and how
    /// often it was printed. Nothing for a ray that the kernel does not work on.
    ///
    /// # Errors
    /// As [`Interpreter::record`], for the first such ray.
    pub fn noted(&self, rays: Range<usize>) -> Result<Vec<Vec<Printed>>, InterpretError> {
        let none = vec![([0; 4], 0); self.kernel.notes().len()];
        let chunks = self.in_chunks(rays, |rays, counter| {
            let mut texels = vec![0; self.kernel.components()];
            let one = |ray| {
                let is_worked_on = self.one(ray, counter, &mut texels)?.is_some();
                Ok(if is_worked_on { counter.noted().to_vec() } else { none.clone() })
            };
            rays.map(one).collect::<Result<Vec<_>, _>>()
        })?;
        Ok(chunks.concat())
    }

    /// The number of consecutive rays that the kernel works on, and what they took together, on all cores.
    ///
    /// # Errors
    /// As [`Interpreter::record`], for the first such ray.
    pub fn work(&self, rays: Range<usize>) -> Result<(u64, Work), InterpretError> {
        let chunks = self.in_chunks(rays, |rays, counter| {
            let (mut texels, mut count) = (vec![0; self.kernel.components()], 0);
            for ray in rays {
                count += u64::from(self.one(ray, counter, &mut texels)?.is_some());
            }
            Ok((count, counter.work()))
        })?;
        Ok(chunks.iter().fold((0, Work::default()), |(rays, mut sum), (count, work)| {
            sum.add(work, 1);
            (rays + count, sum)
        }))
    }

    /// How often consecutive rays ran each statement, in the order of [`Interpreter::statements`], and the number of rays that
    /// the kernel works on, on all cores.
    ///
    /// # Errors
    /// As [`Interpreter::record`], for the first such ray.
    pub fn runs(&self, rays: Range<usize>) -> Result<(u64, Vec<u64>), InterpretError> {
        let (outcomes, runs) = self.outcomes_and_runs(rays)?;
        Ok((outcomes.iter().flatten().count() as u64, runs))
    }

    /// What consecutive rays did at the kernel's stops, on all cores: of those that came to one.
    ///
    /// # Errors
    /// As [`Interpreter::record`], for the first such ray: with its index, and the lines that it ran last, see
    /// [`Counter::lines`].
    pub fn stopped(&self, rays: Range<usize>) -> Result<Vec<(usize, Vec<Stopped>)>, FailedAt> {
        let chunks = self.in_chunks(rays, |rays, counter| {
            let mut texels = vec![0; self.kernel.components()];
            let mut all = Vec::new();
            for ray in rays {
                match self.one(ray, counter, &mut texels) {
                    Ok(None) => {}
                    Ok(Some(_)) if counter.stopped().is_empty() => {}
                    Ok(Some(_)) => all.push((ray, counter.stopped().to_vec())),
                    Err(why) => return Ok(Err(FailedAt { why, element: ray, lines: counter.lines() })),
                }
            }
            Ok(Ok(all))
        });
        let chunks = chunks.map_err(|why| FailedAt { why, element: 0, lines: Vec::new() })?;
        let mut all = Vec::new();
        for chunk in chunks {
            all.extend(chunk?);
        }
        Ok(all)
    }

    /// Hands chunks of rays to `each`, on all cores, each with a counter of its own.
    fn in_chunks<T: Send>(
        &self,
        rays: Range<usize>,
        each: impl Fn(Range<usize>, &mut Counter<'_>) -> Result<T, InterpretError> + Sync,
    ) -> Result<Vec<T>, InterpretError> {
        let size = self.size();
        let is_complete = self.streams.iter().map(|stream| stream.stream).eq(self.kernel.streams.iter().copied());
        let is_even = self.streams.iter().all(|stream| [stream.width, stream.height] == size);
        let given = self.streams.iter().map(|stream| stream.stream.layers()).sum();
        if !is_complete || !is_even {
            return Err(InterpretError::Texels { given, needed: self.kernel.components() });
        }
        let count = size[0] as usize * size[1] as usize;
        let rays = rays.start.min(count)..rays.end.min(count);
        let chunks = map_ranges(rays.len(), CHUNK, |range| {
            each(rays.start + range.start..rays.start + range.end, &mut self.kernel.counter(self.data))
        });
        chunks.into_iter().collect()
    }

    fn one(
        &self,
        ray: usize,
        counter: &mut Counter<'_>,
        texels: &mut [u32],
    ) -> Result<Option<Outcomes>, InterpretError> {
        let size = self.size();
        let own = self.streams.iter().flat_map(|data| (0..data.stream.layers()).map(move |layer| data.get(layer, ray)));
        texels.iter_mut().zip(own).for_each(|(texel, bits)| *texel = bits);
        let tag = self.kernel.tag().and_then(|tag| texels.get(tag).copied());
        if !self.is_worked_on(tag) {
            return Ok(None);
        }
        let column = (ray % size[0].max(1) as usize) as u32;
        let element = Element { texel: [column, (ray / size[0].max(1) as usize) as u32], size };
        counter.run(element, texels).map(Some)
    }

    /// Whether the kernel works on a ray in this state; `None` in a kernel that does not read the state.
    fn is_worked_on(&self, tag: Option<u32>) -> bool {
        let kernel = self.kernel.kernel;
        let generates = kernel.role() == Role::Whole && self.data.features.eye_rays;
        let unborn = kernel.course().map(|course| course.unborn);
        tag.is_none_or(|tag| kernel.takes().contains(&tag) || generates && unborn == Some(tag))
    }
}
