//! A whole pass of a kernel on the CPU: every thread of every workgroup, with the workgroup's memory, barriers and atomics.
//!
//! The threads of a workgroup run one after the other, each up to the next barrier, and so do workgroups: where the order of
//! threads decides, as with the result of an atomic operation, it is always the same. A thread sees the streams as they were
//! before the pass, with what it has stored itself; after a `textureBarrier`, also with what its workgroup has stored.
//!
//! A device promises no such order. What depends on it is a data race, of which the first is reported: threads that store
//! different values to a component, or of which one loads what another stores; and threads that access a variable of their
//! workgroup between two barriers, one of them by a store that is no atomic operation.

mod columns;
mod followed;
mod group;
mod launched;

use std::sync::atomic::{AtomicU32, Ordering};

use super::work::Work;
use super::{InterpretError, Interpreter, Recording, Site, Stopped};
use crate::numbers::parallel::map_ranges;
use crate::program::Kernel;
use crate::scene_data::SceneData;
use crate::shader::{Noted, Printed, Variant};
use crate::tables::elements::Size;
use crate::tables::stream::{Stream, StreamData};
use columns::{After, Columns, Conflict};
pub(super) use group::Group;
use launched::{Launched, Runner};

/// A kernel's variant, prepared to be interpreted for all threads of a pass.
#[derive(Debug)]
pub struct Pass(Interpreter);

/// What a pass begins with.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// The scene as the kernel reads it.
    pub data: &'a SceneData,
    /// The size of the set that the kernel is launched over.
    pub size: Size,
    /// The value of `launch.parameter`.
    pub parameter: u32,
    /// Its streams before the pass, in the order of [`Pass::streams`].
    pub streams: &'a [StreamData],
}

/// What a pass has done.
#[derive(Clone, Debug)]
pub struct Passed {
    /// The streams that the kernel writes, after the pass.
    pub streams: Vec<StreamData>,
    /// The first data race, by the threads.
    pub race: Option<Race>,
    /// What all threads took together.
    pub work: Work,
    /// What each element of the set has printed, in the order of [`Pass::notes`], one element after the other; empty if the
    /// kernel prints nothing.
    pub noted: Vec<Printed>,
    /// How often all threads ran each statement, in the order of [`Interpreter::statements`].
    pub runs: Vec<u64>,
    /// What elements did at the kernel's stops, of those that came to one, by their place in the set.
    pub stopped: Vec<(usize, Vec<Stopped>)>,
}

/// Two threads whose order decides what a pass does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Race {
    /// The texels of their elements.
    pub texels: [[u32; 2]; 2],
    /// The line of the composed source that stores, from 1.
    pub line: usize,
    /// What they access.
    pub what: Raced,
}

/// What threads access that do not wait for each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Raced {
    /// Both store to a component of a stream, different values.
    Stored {
        /// The stream.
        stream: Stream,
        /// The layer.
        layer: usize,
        /// Column and row.
        texel: [u32; 2],
    },
    /// The first loads a component of a stream, and the second stores another value there.
    Loaded {
        /// The stream.
        stream: Stream,
        /// The layer.
        layer: usize,
        /// Column and row.
        texel: [u32; 2],
    },
    /// Both access a variable of their workgroup.
    Variable(String),
}

impl std::fmt::Display for Race {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [[ax, ay], [bx, by]] = self.texels;
        let both = format!("the elements at {ax},{ay} and {bx},{by}");
        match &self.what {
            Raced::Stored { stream, layer, texel: [x, y] } => {
                let (name, layer) = (stream.name(), stream.info().layers.get(*layer).unwrap_or(&""));
                write!(f, "{both} store different values to {name}.{layer} at {x},{y}")
            }
            Raced::Loaded { stream, layer, texel: [x, y] } => {
                let (name, layer) = (stream.name(), stream.info().layers.get(*layer).unwrap_or(&""));
                write!(f, "the element at {ax},{ay} loads {name}.{layer} at {x},{y}, where that at {bx},{by} stores")
            }
            Raced::Variable(name) => {
                write!(f, "{both} access {name} between two barriers, and one of them stores to it")
            }
        }
    }
}

/// A thread could not be run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{why}, for the element at {},{}", texel[0], texel[1])]
pub struct PassError {
    /// Why.
    pub why: InterpretError,
    /// Column and row of its element.
    pub texel: [u32; 2],
    /// The lines of the composed source, from 1, that it ran last: in the function that ran, in the one that called it, and
    /// so on; none if it did not begin.
    pub lines: Vec<usize>,
}

impl PassError {
    fn before(why: InterpretError) -> Self {
        Self { why, texel: [0; 2], lines: Vec::new() }
    }
}

/// Workgroups whose stores are kept until they are applied.
const BATCH: u32 = 256;
/// Workgroups per task.
const CHUNK: usize = 4;

impl Pass {
    /// Prepares a variant.
    ///
    /// # Errors
    /// If its source is not valid, or has what the interpreter does not know.
    pub fn new(variant: &Variant) -> Result<Self, InterpretError> {
        Ok(Self(Interpreter::compiled(variant, true)?))
    }

    /// The same, with a limit for the turns of all loops of a thread.
    #[must_use]
    pub fn limited(self, turns: u32) -> Self {
        Self(self.0.limited(turns))
    }

    /// The kernel's code, which names what a recording has.
    #[must_use]
    pub fn code(&self) -> &Interpreter {
        &self.0
    }

    /// The kernel.
    #[must_use]
    pub fn kernel(&self) -> Kernel {
        self.0.kernel()
    }

    /// The streams that it reads or writes.
    #[must_use]
    pub fn streams(&self) -> &[Stream] {
        self.0.streams()
    }

    /// What it prints.
    #[must_use]
    pub fn notes(&self) -> &[Noted] {
        self.0.notes()
    }

    /// Its conditions, in no particular order.
    #[must_use]
    pub fn sites(&self) -> &[Site] {
        self.0.sites()
    }

    /// Interprets all threads of a pass, on all cores.
    ///
    /// # Errors
    /// If a thread does what a device need not define, such as an access outside of a texture or of an array, or a barrier
    /// that only some threads reach; if it does not end; or if the streams do not belong to the kernel: for the first such
    /// thread.
    pub fn run(&self, given: &Given<'_>) -> Result<Passed, PassError> {
        let is_seen = self.0.code.barriers.contains(naga::Barrier::TEXTURE);
        let columns = Columns::new(&self.0, given.streams, !is_seen).map_err(PassError::before)?;
        let launched = Launched::new(&self.0, given, &columns).map_err(PassError::before)?;
        let mut after = After::new(&columns, &self.0.written).map_err(PassError::before)?;
        let (mut race, mut stopped) = (None, Vec::new());
        let mut runs = columns::filled(0, self.0.statements().len()).map_err(PassError::before)?;
        let notes = self.notes().len();
        let mut noted =
            columns::filled(([0; 4], 0), given.size.texels() as usize * notes).map_err(PassError::before)?;
        let groups = launched.groups();
        let failed = AtomicU32::new(u32::MAX);
        for first in (0..groups).step_by(BATCH as usize) {
            let batch = BATCH.min(groups - first);
            let chunks = map_ranges(batch as usize, CHUNK, |range| {
                let mut runner = Runner::new(&launched);
                for group in range.map(|at| first + at as u32) {
                    if failed.load(Ordering::Relaxed) < group {
                        break;
                    }
                    if let Err(why) = runner.run(group, None) {
                        failed.fetch_min(group, Ordering::Relaxed);
                        return Err(why);
                    }
                }
                Ok(runner.done())
            });
            for chunk in chunks {
                let done = chunk?;
                for (group, stored) in done.groups {
                    after.apply(launched.first_thread(group), &stored);
                }
                race = race.or(done.race);
                runs.iter_mut().zip(&done.runs).for_each(|(sum, runs)| *sum += runs);
                stopped.extend(done.stopped);
                for (element, printed) in done.noted {
                    if let Some(of_element) = noted.get_mut(element * notes..(element + 1) * notes) {
                        of_element.copy_from_slice(&printed);
                    }
                }
            }
        }
        let (streams, conflict) = after.end();
        let conflict = conflict.map(|conflict| launched.race_of(&conflict));
        let order = |race: &Race| {
            let [a, b] = race.texels.map(|[x, y]| [y, x]);
            [a.min(b), a.max(b)]
        };
        let race = [race, conflict].into_iter().flatten().min_by_key(order);
        stopped.sort_by_key(|(element, _)| *element);
        let work = self.0.code.work(&runs);
        Ok(Passed { streams, race, work, noted, runs, stopped })
    }

    /// Interprets the workgroup of an element, and records the element's thread. Components of the recording are those of the
    /// element's own texel in [`streams`](Self::streams).
    ///
    /// # Errors
    /// As [`run`](Self::run), and if no thread has this element.
    pub fn record(&self, given: &Given<'_>, texel: [u32; 2]) -> Result<Recording, PassError> {
        let columns = Columns::new(&self.0, given.streams, false).map_err(PassError::before)?;
        let launched = Launched::new(&self.0, given, &columns).map_err(PassError::before)?;
        let (group, lane) = launched.thread_of(texel).ok_or_else(|| {
            let what = format!("the {} columns and {} rows of the elements", given.size.width, given.size.height);
            let index = u64::from(texel[1]) * u64::from(given.size.width) + u64::from(texel[0]);
            PassError { texel, ..PassError::before(InterpretError::OutOfBounds { index, what }) }
        })?;
        let mut runner = Runner::new(&launched);
        runner.run(group, Some(lane))?;
        runner.recorded(lane, texel)
    }
}

#[cfg(test)]
mod tests;
