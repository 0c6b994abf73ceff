//! Interprets a kernel's WGSL for one ray on the CPU, statement by statement, and records every decision: which
//! conditions were reached, how they came out, and the values on both sides, in f32 and in f64.
//!
//! It runs what the device is given: the composed source, as naga parses it. A run needs the ray's texels before a pass
//! and the scene data, and returns its texels after it; a test compares these with the CPU reference kernels, bit for
//! bit. Every float carries a *shadow*: the same operations in f64, from the same f32 inputs. Control flow follows f32;
//! where a comparison of shadows comes out differently, the decision says so. Integers have no shadow, nor has a float
//! that was made from the bits of another.
//!
//! What concerns other rays is left out: a kernel's texel is given instead of being found in a list, and the rays sent
//! to each state are not counted.

mod booked;
mod code;
mod compile;
mod compute;
mod deciding;
mod error;
mod flow;
mod invocation;
mod lines;
mod machine;
mod many;
mod memory;
mod non_finite;
mod operators;
pub mod pass;
mod ran;
mod recording;
mod steps;
mod stopped;
mod stops;
mod streams;
mod trace;
mod vectors;
mod view;
mod work;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};

use crate::program::{Kernel, Twin};
use crate::scene_data::SceneData;
use crate::shader::{Noted, Notes, Printed, Variant};
use crate::tables::stream::{STATE_TAG, Stream};
use crate::tables::texels::Layout;
use code::Code;
pub use code::{Kind, Site, SiteKind, Watched};
pub use error::{Absentee, InterpretError};
pub use lines::LineWork;
use machine::Machine;
pub use many::{FailedAt, Many};
pub use recording::{Comparison, Decision, NonFinite, Operation, Recording, Value};
pub use steps::Followed;
pub use stopped::Stopped;
pub use trace::Step;
pub use view::{FrameView, Shown, StreamView, Variable, View};
pub use work::Work;

/// The element of a set that a kernel is interpreted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    /// Column and row of its texel.
    pub texel: [u32; 2],
    /// Columns and rows of the streams.
    pub size: [u32; 2],
}

/// How the conditions of a kernel came out for one ray: a bit for each of the first [`MOST_SITES`] sites.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcomes {
    /// It was reached.
    pub reached: u128,
    /// It was true at least once.
    pub taken: u128,
    /// In f64 it would have come out differently at least once.
    pub differs: u128,
}

/// Number of sites in [`Outcomes`].
pub const MOST_SITES: usize = 128;

/// Steps after which a ray is given up: statements and expressions. The longest walks take a few million.
const MOST_STEPS: u64 = 200_000_000;

/// A kernel's variant, prepared to be interpreted.
#[derive(Debug)]
pub struct Interpreter {
    kernel: Kernel,
    source: String,
    module: Module,
    info: ModuleInfo,
    /// The index of its entry point.
    entry: usize,
    code: Code,
    streams: Vec<Stream>,
    layout: Layout,
    /// Streams that the variant updates in place, whose integers are what the ray has found before.
    kept: Vec<Stream>,
    written: Vec<Stream>,
    /// For all threads of a pass, not for one element.
    is_whole: bool,
    /// Threads of a workgroup along x, y and z.
    workgroup: [u32; 3],
    /// Most turns of all of its loops.
    turns: u32,
    /// What it prints and asserts.
    notes: Notes,
    /// Whether its WGSL is a user's.
    is_users: bool,
    /// Whether a function of ours says which element a thread has.
    is_tiled: bool,
}

impl Interpreter {
    /// Prepares a variant.
    ///
    /// # Errors
    /// If its elements read each other, or if its source is not valid.
    pub fn new(variant: &Variant) -> Result<Self, InterpretError> {
        Self::compiled(variant, false)
    }

    fn compiled(variant: &Variant, is_whole: bool) -> Result<Self, InterpretError> {
        let kernel = variant.kernel;
        let is_alone = matches!(kernel.info().twin, Twin::Element { .. }) && kernel.course().is_some();
        if !is_whole && !is_alone {
            return Err(InterpretError::NotAlone(kernel.name()));
        }
        let source = variant.source.clone();
        let invalid = |message| InterpretError::Invalid { kernel: kernel.name(), message };
        let module = naga::front::wgsl::parse_str(&source).map_err(|e| invalid(e.emit_to_string(&source)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|e| invalid(e.emit_to_string(&source)))?;
        let entry = module
            .entry_points
            .iter()
            .position(|e| e.stage == ShaderStage::Compute && e.name == kernel.info().name)
            .ok_or_else(|| invalid(format!("no compute entry point named {}", kernel.info().name)))?;
        if is_whole && !invocation::are_known(&module, &module.entry_points[entry].function) {
            return Err(InterpretError::Unsupported { what: "an argument of the kernel".into(), line: 0 });
        }
        let code = compile::compile(variant, &module, &info, entry, is_whole)?;
        let mut streams: Vec<Stream> = Vec::new();
        let (mut kept, mut written) = (Vec::new(), Vec::new());
        for (stream, binding) in variant.streams() {
            if !streams.contains(&stream) {
                streams.push(stream);
            }
            written.extend(Some(stream).filter(|_| binding.writes));
            kept.extend(Some(stream).filter(|_| binding.reads && binding.writes));
        }
        let layout = Layout::of(kernel.program().streams, streams.iter().copied());
        let notes = variant.replaced.as_ref().map(|replaced| replaced.notes.clone()).unwrap_or_default();
        let workgroup = module.entry_points.get(entry).map_or([1; 3], |point| point.workgroup_size);
        let turns = u32::MAX;
        let is_tiled = compile::finds_elements(&module);
        Ok(Self {
            kernel,
            source,
            module,
            info,
            entry,
            code,
            streams,
            layout,
            kept,
            written,
            is_whole,
            workgroup,
            turns,
            notes,
            is_users: variant.replaced.is_some(),
            is_tiled,
        })
    }

    /// The same, with a limit for the turns of all loops of an element.
    #[must_use]
    pub fn limited(self, turns: u32) -> Self {
        Self { turns, ..self }
    }

    /// The kernel.
    #[must_use]
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The composed source that spans refer to.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The streams that it reads or writes: a ray's texels in them, one after the other, are its input and output.
    #[must_use]
    pub fn streams(&self) -> &[Stream] {
        &self.streams
    }

    /// Number of components of a ray in those streams.
    #[must_use]
    pub fn components(&self) -> usize {
        self.layout.stride
    }

    /// The component with the state's tag.
    #[must_use]
    pub fn tag(&self) -> Option<usize> {
        let stream = self.kernel.course()?.stream;
        self.layout.first[stream.index()].map(|first| first + STATE_TAG)
    }

    /// What it prints.
    #[must_use]
    pub fn notes(&self) -> &[Noted] {
        &self.notes.noted
    }

    /// Its conditions, in no particular order.
    #[must_use]
    pub fn sites(&self) -> &[Site] {
        &self.code.sites
    }

    /// Statements of the source, as byte ranges without the blocks inside of them, in no particular order.
    #[must_use]
    pub fn statements(&self) -> &[std::ops::Range<usize>] {
        &self.code.statements
    }

    /// Interprets one element's pass, and records it. `texels` are the element's components in
    /// [`streams`](Self::streams) before the pass, and after it on return.
    ///
    /// # Errors
    /// If the source has what the interpreter does not know, an index is out of bounds, or it does not end.
    pub fn record(&self, data: &SceneData, element: Element, texels: &mut [u32]) -> Result<Recording, InterpretError> {
        let mut machine = Machine::new(self, data, Some(Recording::new(&self.code)));
        machine.run(element, texels)?;
        machine.finish()
    }

    /// A run of it over many elements, which only keeps how conditions came out.
    #[must_use]
    pub fn counter<'a>(&'a self, data: &'a SceneData) -> Counter<'a> {
        Counter { machine: Machine::new(self, data, None) }
    }
}

/// Interprets elements one after the other.
pub struct Counter<'a> {
    machine: Machine<'a>,
}

impl Counter<'_> {
    /// Interprets one element's pass, as [`record`](Interpreter::record).
    ///
    /// # Errors
    /// As [`record`](Interpreter::record).
    pub fn run(&mut self, element: Element, texels: &mut [u32]) -> Result<Outcomes, InterpretError> {
        self.machine.run(element, texels)?;
        Ok(self.machine.outcomes)
    }

    /// The lines of the composed source, from 1, that were run last: in the function that ran, in the one that called it, and
    /// so on.
    #[must_use]
    pub fn lines(&self) -> Vec<usize> {
        self.machine.lines()
    }

    /// What the last element has printed, in the order of [`Interpreter::notes`]: the last value of each, and how often it was
    /// printed.
    #[must_use]
    pub fn noted(&self) -> &[Printed] {
        &self.machine.thread.noted
    }

    /// The same in words, of those that were printed.
    #[must_use]
    pub fn told(&self) -> Vec<String> {
        let notes = self.machine.kernel.notes.noted.iter().zip(&self.machine.thread.noted);
        notes.filter_map(|(note, &noted)| note.told(noted)).collect()
    }

    /// What all elements so far took together.
    #[must_use]
    pub fn work(&self) -> Work {
        self.machine.kernel.code.work(&self.machine.runs)
    }

    /// How often all elements so far ran each statement, in the order of [`Interpreter::statements`].
    #[must_use]
    pub fn runs(&self) -> &[u64] {
        &self.machine.runs
    }

    /// What the last element did at the kernel's stops; fewer if it came to none of the last.
    #[must_use]
    pub fn stopped(&self) -> &[Stopped] {
        &self.machine.thread.stopped
    }
}
