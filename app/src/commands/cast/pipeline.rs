//! Reads, casts and writes at the same time: one thread reads the next batches, one writes the last ones, and this one
//! traces. Whoever is ahead waits, so memory stays that of a few batches.

use std::io::Read;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use glam::DVec3;
use raystep_kernels::{AllHits, AllHitsPlace, CastHit, Caster, PlanError, RenderError};
use raystep_lab::Machine;
use raystep_lab::outside::count_outside;
use raystep_lab::rays::file::{BadRays, Batch, RaysError, RaysReader};

use super::hits::HitsWriter;
use crate::error::Error;
use crate::terminal::Progress;

/// Batches that wait between two threads.
const WAITING: usize = 1;

/// Numbers of rays.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts {
    pub(super) rays: u64,
    /// Rays that hit something, or all hits.
    pub(super) hits: u64,
    /// Of all hits, most of a ray.
    pub(super) most: u64,
    pub(super) unfinished: u64,
    /// Those that cannot be traced.
    pub(super) bad: u64,
    /// Those that start outside the grid, which the paper's numerics miss.
    pub(super) outside: u64,
}

/// Everything but the two ends.
pub(super) struct Pipeline<'a> {
    pub(super) caster: Caster,
    pub(super) chosen: &'a Machine,
    pub(super) bad_rays: BadRays,
    /// All hits are wanted.
    pub(super) is_all: bool,
    /// The scene's.
    pub(super) offset: DVec3,
    /// The rays' file, for messages.
    pub(super) name: &'a str,
    pub(super) progress: &'a Progress,
}

/// A batch, or why there is none. An empty one is the end.
type Incoming = Result<Batch, RaysError>;

impl Pipeline<'_> {
    /// Casts all rays. `None` if the reader of the hits has closed its pipe.
    pub(super) fn run<R: Read + Send + 'static>(
        mut self,
        reader: RaysReader<R>,
        writer: HitsWriter,
    ) -> Result<Option<Counts>, Error> {
        let (total, offset) = (reader.total(), self.offset);
        let (sender, rays) = sync_channel(WAITING);
        let (used, spare) = sync_channel(WAITING + 2);
        let batch = usize::try_from(self.caster.batch()).unwrap_or(usize::MAX);
        // Not joined: if this thread fails, it may still wait for a pipe.
        thread::Builder::new()
            .name("rays".into())
            .spawn(move || read(reader, batch, offset, &sender, &spare))
            .map_err(failed)?;
        let (sender, hits) = sync_channel(WAITING);
        let writer = thread::Builder::new().name("hits".into()).spawn(move || write(writer, &hits)).map_err(failed)?;
        let cast = self.cast(&rays, &used, &sender, total);
        drop(sender);
        let (writer, is_open) = match writer.join() {
            Ok(written) => written?,
            Err(_) => return Err(Error::failed("the thread that writes hits ended early: a defect of raystep")),
        };
        match cast {
            _ if !is_open => Ok(None),
            Ok(counts) => writer.finish().map(|()| Some(counts)),
            Err(error) => {
                writer.abandon();
                Err(error)
            }
        }
    }

    fn cast(
        &mut self,
        rays: &Receiver<Incoming>,
        used: &SyncSender<Batch>,
        hits: &SyncSender<AllHits>,
        total: Option<u64>,
    ) -> Result<Counts, Error> {
        let mut counts = Counts::default();
        self.progress.cast(0, total);
        loop {
            // The reader sends its error or an empty batch before it ends.
            let mut batch = match rays.recv() {
                Ok(Ok(batch)) => batch,
                Ok(Err(error)) => return Err(Error::failed(format!("{}: {error}", self.name))),
                Err(_) => return Err(Error::failed("the thread that reads rays ended early: a defect of raystep")),
            };
            if batch.rays.is_empty() {
                counts.unfinished = self.caster.unfinished();
                // If there was no ray, the header is still to be written.
                let _ = hits.send(AllHits::default());
                return Ok(counts);
            }
            if self.bad_rays == BadRays::Miss {
                for index in 0..batch.rays.len() {
                    if self.caster.fault(&batch.rays[index]).is_some() {
                        batch.replace(index);
                    }
                }
                batch.bad.sort_unstable();
            }
            let is_open = match self.is_all {
                true => self.cast_all(&batch, hits, &mut counts, total)?,
                false => self.cast_each(&batch, hits, &mut counts, total)?,
            };
            counts.bad += batch.bad.len() as u64;
            counts.rays += batch.rays.len() as u64;
            counts.outside += count_outside(&batch.rays, self.caster.data()) as u64;
            self.progress.cast(counts.rays, total);
            // The other threads may have ended: the writer's result says why.
            let _ = used.try_send(batch);
            if !is_open {
                return Ok(counts);
            }
        }
    }

    /// Finds one hit of each ray. `false` if nobody wants them.
    fn cast_each(
        &mut self,
        batch: &Batch,
        hits: &SyncSender<AllHits>,
        counts: &mut Counts,
        total: Option<u64>,
    ) -> Result<bool, Error> {
        let cast = self.chosen.wait(self.caster.cast(&batch.rays));
        let mut found = cast.map_err(|error| self.explained(error, counts.rays, total))?;
        batch.bad.iter().for_each(|&index| found[index] = CastHit::MISS);
        counts.hits += found.iter().filter(|hit| hit.is_hit()).count() as u64;
        Ok(hits.send(AllHits { rays: Vec::new(), hits: found }).is_ok())
    }

    /// Finds all hits of each ray, some at a time. `false` if nobody wants them.
    fn cast_all(
        &mut self,
        batch: &Batch,
        hits: &SyncSender<AllHits>,
        counts: &mut Counts,
        total: Option<u64>,
    ) -> Result<bool, Error> {
        let mut place = AllHitsPlace::default();
        let mut of_ray = (u64::MAX, 0);
        loop {
            let mut found = AllHits::default();
            let cast = self.chosen.wait(self.caster.cast_some(&batch.rays, &mut place, &mut found));
            let is_more = cast.map_err(|error| self.explained(error, counts.rays, total))?;
            if !batch.bad.is_empty() {
                let is_good: Vec<bool> =
                    found.rays.iter().map(|&ray| batch.bad.binary_search(&(ray as usize)).is_err()).collect();
                let mut of_hits = is_good.iter();
                found.hits.retain(|_| of_hits.next().is_some_and(|&is_good| is_good));
                let mut of_rays = is_good.iter();
                found.rays.retain(|_| of_rays.next().is_some_and(|&is_good| is_good));
            }
            for ray in &mut found.rays {
                of_ray = (*ray, if *ray == of_ray.0 { of_ray.1 + 1 } else { 1 });
                counts.most = counts.most.max(of_ray.1);
                *ray += counts.rays;
            }
            counts.hits += found.hits.len() as u64;
            self.progress.cast(counts.rays + place.rays() as u64, total);
            if hits.send(found).is_err() {
                return Ok(false);
            }
            if !is_more {
                return Ok(true);
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

/// Reads batches until the end, an error, or until nobody wants more.
fn read<R: Read>(
    mut reader: RaysReader<R>,
    most: usize,
    offset: DVec3,
    rays: &SyncSender<Incoming>,
    spare: &Receiver<Batch>,
) {
    loop {
        let mut some = spare.try_recv().unwrap_or_default();
        some.rays.clear();
        some.bad.clear();
        let sent = match reader.read(most, offset, &mut some) {
            Ok(0) => break,
            Ok(_) => rays.send(Ok(some)),
            Err(error) => return drop(rays.send(Err(error))),
        };
        if sent.is_err() {
            return;
        }
    }
    drop(rays.send(reader.finish().map(|()| Batch::default())));
}

/// Writes batches until there are no more: nothing before the first, so that nothing is written if the first ray is wrong.
/// Also returns whether the output is still open.
fn write(mut writer: HitsWriter, hits: &Receiver<AllHits>) -> Result<(HitsWriter, bool), Error> {
    let mut bytes = Vec::new();
    for hits in hits {
        match writer.write(&hits, &mut bytes) {
            Ok(true) => {}
            Ok(false) => return Ok((writer, false)),
            Err(error) => {
                writer.abandon();
                return Err(error);
            }
        }
    }
    Ok((writer, true))
}
