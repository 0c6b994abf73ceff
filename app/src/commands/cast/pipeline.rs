//! Reads, casts and writes at the same time: one thread reads the next batches, one writes the last ones, and this one
//! traces. Whoever is ahead waits, so memory stays that of a few batches.

use std::io::Read;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use raystep_kernels::export::npy::{HITS_HEADER_BYTES, write_hits, write_hits_header};
use raystep_kernels::{CastHit, Caster, PlanError, Ray, RenderError};
use raystep_lab::Machine;
use raystep_lab::rays::file::{RaysError, RaysReader};
use raystep_lab::ways::count_outside;

use crate::error::Error;
use crate::output::Stream;
use crate::terminal::Progress;

/// Batches that wait between two threads.
const WAITING: usize = 1;

/// Numbers of rays.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts {
    pub(super) rays: u64,
    pub(super) hits: u64,
    pub(super) unfinished: u64,
    /// Those that start outside the grid, which the paper's numerics miss.
    pub(super) outside: u64,
}

/// Everything but the two ends.
pub(super) struct Pipeline<'a> {
    pub(super) caster: Caster,
    pub(super) chosen: &'a Machine,
    /// The rays' file, for messages.
    pub(super) name: &'a str,
    pub(super) progress: &'a Progress,
}

/// A batch, or why there is none. An empty one is the end.
type Batch = Result<Vec<Ray>, RaysError>;

impl Pipeline<'_> {
    /// Casts all rays. `None` if the reader of the hits has closed its pipe.
    pub(super) fn run<R: Read + Send + 'static>(
        mut self,
        reader: RaysReader<R>,
        stream: Stream,
    ) -> Result<Option<Counts>, Error> {
        let total = reader.total();
        let (sender, rays) = sync_channel(WAITING);
        let (used, spare) = sync_channel(WAITING + 2);
        let batch = usize::try_from(self.caster.batch()).unwrap_or(usize::MAX);
        // Not joined: if this thread fails, it may still wait for a pipe.
        thread::Builder::new()
            .name("rays".into())
            .spawn(move || read(reader, batch, &sender, &spare))
            .map_err(failed)?;
        let (sender, hits) = sync_channel(WAITING);
        let writer = thread::Builder::new()
            .name("hits".into())
            .spawn(move || write(stream, &header(total.unwrap_or(0)), &hits))
            .map_err(failed)?;
        let cast = self.cast(&rays, &used, &sender, total);
        drop(sender);
        let (mut stream, is_open) = match writer.join() {
            Ok(written) => written?,
            Err(_) => return Err(Error::failed("the thread that writes hits ended early: a defect of raystep")),
        };
        match cast {
            _ if !is_open => Ok(None),
            Ok(counts) => {
                if total.is_none() {
                    stream.replace_begin(&header(counts.rays))?;
                }
                stream.finish().map(|()| Some(counts))
            }
            Err(error) => {
                stream.abandon();
                Err(error)
            }
        }
    }

    fn cast(
        &mut self,
        rays: &Receiver<Batch>,
        used: &SyncSender<Vec<Ray>>,
        hits: &SyncSender<Vec<CastHit>>,
        total: Option<u64>,
    ) -> Result<Counts, Error> {
        let mut counts = Counts::default();
        self.progress.cast(0, total);
        loop {
            // The reader sends its error or an empty batch before it ends.
            let batch = match rays.recv() {
                Ok(Ok(batch)) => batch,
                Ok(Err(error)) => return Err(Error::failed(format!("{}: {error}", self.name))),
                Err(_) => return Err(Error::failed("the thread that reads rays ended early: a defect of raystep")),
            };
            if batch.is_empty() {
                counts.unfinished = self.caster.unfinished();
                // If there was no ray, the header is still to be written.
                let _ = hits.send(Vec::new());
                return Ok(counts);
            }
            let cast = self.chosen.wait(self.caster.cast(&batch));
            let found = cast.map_err(|error| self.explained(error, counts.rays, total))?;
            counts.rays += found.len() as u64;
            counts.hits += found.iter().filter(|hit| hit.is_hit()).count() as u64;
            counts.outside += count_outside(&batch, self.caster.data()) as u64;
            self.progress.cast(counts.rays, total);
            // The other threads may have ended: the writer's result says why.
            let _ = used.try_send(batch);
            if hits.send(found).is_err() {
                return Ok(counts);
            }
        }
    }

    /// A ray's number counts from the first of all.
    fn explained(&self, error: RenderError, before: u64, rays: Option<u64>) -> Error {
        match error {
            RenderError::Plan(PlanError::Ray { index, reason }) => {
                let error = RaysError::Ray { index: before + index as u64, rays, reason };
                Error::failed(format!("{}: {error}", self.name))
            }
            error => error.into(),
        }
    }
}

fn failed(error: std::io::Error) -> Error {
    Error::failed(format!("cannot start a thread: {error}"))
}

fn header(rays: u64) -> Vec<u8> {
    let mut header = Vec::with_capacity(HITS_HEADER_BYTES);
    write_hits_header(&mut header, rays);
    header
}

/// Reads batches until the end, an error, or until nobody wants more.
fn read<R: Read>(mut reader: RaysReader<R>, batch: usize, rays: &SyncSender<Batch>, spare: &Receiver<Vec<Ray>>) {
    loop {
        let mut some = spare.try_recv().unwrap_or_default();
        some.clear();
        let sent = match reader.read(batch, &mut some) {
            Ok(0) => break,
            Ok(_) => rays.send(Ok(some)),
            Err(error) => return drop(rays.send(Err(error))),
        };
        if sent.is_err() {
            return;
        }
    }
    drop(rays.send(reader.finish().map(|()| Vec::new())));
}

/// Writes the header with the first batch, so that nothing is written if the first ray is wrong, and batches until there
/// are no more. Also returns whether the output is still open.
fn write(mut stream: Stream, header: &[u8], hits: &Receiver<Vec<CastHit>>) -> Result<(Stream, bool), Error> {
    let mut bytes = header.to_vec();
    for hits in hits {
        write_hits(&mut bytes, &hits);
        match stream.write(&bytes) {
            Ok(true) => bytes.clear(),
            Ok(false) => return Ok((stream, false)),
            Err(error) => {
                stream.abandon();
                return Err(error);
            }
        }
    }
    Ok((stream, true))
}
