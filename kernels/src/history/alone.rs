//! One ray on the CPU reference kernels, without the others: its history along the passes of a run, at a microsecond or
//! so per pass, without a device and without moving the run.

use super::{RayState, Trace, TraceGrid, TraceRow, after_all};
use crate::executor::cpu::{Interpreted, OnElement, from_stream_bits, to_stream_bits};
use crate::plan::Plan;
use crate::program::kernel::Precision;
use crate::program::schedule::Cursor;
use crate::program::{Decoding, Kernel, Program, Twin};
use crate::renderer::Pass;
use crate::scene_data::SceneData;
use crate::tables::kernel::Role;
use crate::tables::state::{Population, StateCounts, Tag};
use crate::tables::stream::Stream;
use crate::tables::texels::Layout;

/// A run that a ray may be followed along.
#[derive(Clone, Copy, Debug)]
pub struct RunSoFar<'a> {
    /// Its plan.
    pub plan: &'a Plan,
    /// The scene as its kernels read it.
    pub data: &'a SceneData,
    /// Its passes, as far as they are known.
    pub passes: &'a [Pass],
    /// Whether these are all of them.
    pub is_complete: bool,
}

impl RunSoFar<'_> {
    /// Whether a ray alone tells its history: it needs states, kernels that work on one element at a time, and a kernel
    /// that generates the rays.
    #[must_use]
    pub fn can_be_followed_alone(&self) -> bool {
        let kernels = self.plan.schedule.kernels();
        let is_simple = |kernel: &Kernel| matches!(kernel.info().twin, Twin::Element { .. });
        self.plan.program.rays.is_some()
            && kernels.iter().any(|kernel| kernel.role() == Role::Source)
            && kernels.iter().all(|kernel| is_simple(kernel) && kernel.role() != Role::Whole)
    }

    /// The history of a pixel's ray by the CPU reference kernels in f32 or f64. After the known passes it is predicted
    /// from the ray's own states: such rows have the index of a pass only where [the other rays do not
    /// matter](Plan::can_go_alone). `None` if it [cannot be followed](Self::can_be_followed_alone), or there is no such
    /// pixel.
    #[must_use]
    pub fn follow<R: Precision>(&self, [x, y]: [u32; 2]) -> Option<Trace> {
        if !self.can_be_followed_alone() || x >= self.plan.width || y >= self.plan.height {
            return None;
        }
        let mut ray = Alone::<R>::new(self.plan, self.data, [x, y])?;
        let mut cursor = Cursor::start();
        // Before the first pass all rays are in this ray's state.
        let mut counts = ray.counts();
        let mut rows = Vec::new();
        for pass in self.passes {
            // Keeps the position in the schedule, for what comes after the known passes.
            if cursor.next(&self.plan.schedule, &counts) != Some(pass.kernel) {
                cursor.leave_walk(&self.plan.schedule);
                cursor.next(&self.plan.schedule, &counts);
            }
            counts.in_state.clone_from(&pass.counts);
            rows.extend(ray.run(pass));
        }
        if !self.is_complete {
            self.predict(&mut ray, cursor, &mut rows);
        }
        Some(Trace {
            pixel: [x, y],
            element: None,
            scene_units_per_stream_unit: self.data.units.scene_units_per_stream_unit(),
            scene_offset: self.data.units.offset.to_array(),
            t_scale: self.data.units.scene_units_per_stream_unit(),
            rays: self.plan.rays,
            passes: self.is_complete.then_some(self.passes.len()),
            grid: TraceGrid::of(self.data),
            rows,
        })
    }

    /// A pixel's texels in these streams before a known pass, one after the other, by the CPU reference kernels; f64 is
    /// rounded to f32. `None` as for [`follow`](Self::follow), or if there is no such pass or stream.
    #[must_use]
    pub fn texels_before<R: Precision>(&self, [x, y]: [u32; 2], pass: usize, streams: &[Stream]) -> Option<Vec<u32>> {
        if !self.can_be_followed_alone() || x >= self.plan.width || y >= self.plan.height {
            return None;
        }
        let mut ray = Alone::<R>::new(self.plan, self.data, [x, y])?;
        for pass in self.passes.get(..pass)? {
            ray.run(pass);
        }
        let texels = streams.iter().map(|&stream| {
            let first = ray.streams.contains(&stream).then(|| ray.layout.first[stream.index()]).flatten()?;
            Some((0..stream.layers()).map(move |layer| (stream, layer, first + layer)))
        });
        let components = texels.collect::<Option<Vec<_>>>()?.into_iter().flatten();
        Some(components.map(|(stream, layer, at)| to_stream_bits::<R>(stream, layer, ray.row[at])).collect())
    }

    /// Adds the rows after the known passes.
    fn predict<R: Precision>(&self, ray: &mut Alone<'_, R>, mut cursor: Cursor, rows: &mut Vec<TraceRow>) {
        let schedule = &self.plan.schedule;
        let after_all = after_all(self.plan);
        let kernels_outside = schedule.kernels().len() as u64;
        let is_known = self.plan.can_go_alone();
        let first = self.passes.len();
        // A walk by the paper's rules may never end; the bound is one sample's, with a few passes around its walk.
        let samples = u64::from(self.data.sampling.samples.max(1));
        let most = self.plan.pass_bound.saturating_add(kernels_outside).saturating_mul(samples);
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        for index in first..first.saturating_add(most) {
            let sample = cursor.samples;
            let Some(kernel) = cursor.next(schedule, &ray.counts()) else { break };
            let pass = Pass { index, sample, iteration: cursor.iteration, rays_in: 1, ..Pass::of(kernel) };
            if let Some(mut row) = ray.run(&pass) {
                row.pass = row.pass.filter(|_| is_known && !after_all.contains(&kernel));
                rows.push(row);
            }
        }
    }
}

/// A ray's texels, and what its kernels read.
struct Alone<'a, R: Precision> {
    data: &'a SceneData,
    program: &'static Program,
    rays: Decoding,
    streams: Vec<Stream>,
    layout: Layout,
    row: Vec<R::Bits>,
    pixel: [u32; 2],
    state: RayState,
    /// Columns and rows of the run's streams.
    size: [u32; 2],
    interpreted: Vec<Interpreted>,
}

impl<'a, R: Precision> Alone<'a, R> {
    /// Before the first pass; `None` for a program without states.
    fn new(plan: &Plan, data: &'a SceneData, pixel: [u32; 2]) -> Option<Self> {
        let (rays, elements) = (plan.program.rays?, plan.program.state_stream()?.info().elements.name);
        let streams = plan.streams.iter().map(|s| s.what).filter(|s| s.info().elements.name == elements);
        let streams: Vec<Stream> = streams.collect();
        let layout = Layout::of(plan.program.streams, streams.iter().copied());
        let mut row = Vec::with_capacity(layout.stride);
        for &stream in &streams {
            let unwritten = stream.info().unwritten.iter().enumerate();
            row.extend(unwritten.map(|(layer, &bits)| from_stream_bits::<R>(stream, layer, bits)));
        }
        let state = (rays.decode)(&|_| None);
        let (size, interpreted) = ([plan.width, plan.height], Interpreted::of(plan));
        let mut ray = Self { data, program: plan.program, rays, streams, layout, row, pixel, state, size, interpreted };
        ray.state = ray.decoded();
        Some(ray)
    }

    fn decoded(&self) -> RayState {
        let components = self.streams.iter().flat_map(|&stream| (0..stream.layers()).map(move |layer| (stream, layer)));
        let of = |((stream, layer), &bits): ((Stream, usize), &R::Bits)| to_stream_bits::<R>(stream, layer, bits);
        let bits: Vec<u32> = components.zip(&self.row).map(of).collect();
        (self.rays.decode)(&|stream| {
            let first = self.streams.contains(&stream).then(|| self.layout.first[stream.index()]).flatten()?;
            Some(&bits[first..first + stream.layers()])
        })
    }

    /// The number of rays in each state: this one.
    fn counts(&self) -> Population {
        let mut counts = StateCounts::none(self.program.states);
        counts.add(self.state.tag, 1);
        counts.into()
    }

    /// What a pass does to the ray; `None` if it does not work on it.
    fn run(&mut self, pass: &Pass) -> Option<TraceRow> {
        let tag: Tag = self.state.tag;
        pass.kernel.takes().contains(&tag).then_some(())?;
        let [x, y] = self.pixel;
        let data = pass.kernel.reads(self.data);
        let on_element = OnElement::<R>::new(pass.kernel, &self.interpreted, &self.layout)?;
        let mut runner = on_element.runner(&data, self.size);
        runner.run(&mut self.row, x, y).ok()?;
        let notes = runner.told();
        drop(runner);
        let before = self.state;
        self.state = self.decoded();
        Some(TraceRow { notes, ..TraceRow::new(pass, self.data, &before, &self.state) })
    }
}
