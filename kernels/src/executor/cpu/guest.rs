//! Runs a kernel on one element of a program: its twin, as the twin's own program has it or as an instance has renamed it; or a
//! user's WGSL, by the interpreter.

use std::borrow::Cow;

use super::{from_stream_bits, to_stream_bits};
use crate::interpret::pass::Pass;
use crate::interpret::{Counter, Element, InterpretError, Interpreter};
use crate::plan::Plan;
use crate::program::kernel::{ElementTwin, Precision};
use crate::program::{Kernel, Twin};
use crate::scene_data::SceneData;
use crate::shader::Variant;
use crate::tables::elements::Count;
use crate::tables::state::Tag;
use crate::tables::stream::{STATE_TAG, Stream};
use crate::tables::texels::{Layout, Texels};

/// A user's WGSL failed on an element.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {why}, for {whose} {},{}", pixel[0], pixel[1])]
pub struct Failed {
    /// File and line.
    pub place: String,
    /// What is at the pixel.
    pub whose: &'static str,
    /// Column and row of the element.
    pub pixel: [u32; 2],
    /// What happened.
    pub why: InterpretError,
}

/// What a user's WGSL is interpreted by.
#[derive(Debug)]
pub(super) enum By {
    /// One element after the other.
    Element(Interpreter),
    /// A pass as a whole: its elements read each other.
    Pass(Pass),
}

/// A user's kernel, by the interpreter.
#[derive(Debug)]
pub(crate) struct Interpreted {
    /// The kernel, and what names lines of its source.
    variant: Variant,
    /// Or why it cannot be interpreted.
    pub(super) code: Result<By, InterpretError>,
}

impl Interpreted {
    /// Those of a plan.
    pub(crate) fn of(plan: &Plan) -> Vec<Self> {
        let replaced = plan.variants.iter().filter(|variant| variant.replaced.is_some());
        replaced.map(|variant| Self::new(variant, plan.turns)).collect()
    }

    /// One, with a limit for the turns of all loops of a thread.
    pub(super) fn new(variant: &Variant, turns: u32) -> Self {
        let code = match variant.kernel.info().twin {
            Twin::Element { .. } => Interpreter::new(variant).map(|code| By::Element(code.limited(turns))),
            Twin::Pass(_) | Twin::Interpreted => Pass::new(variant).map(|code| By::Pass(code.limited(turns))),
        };
        Self { variant: variant.clone(), code }
    }

    /// The kernel's code, if it prints anything.
    pub(crate) fn printing(own: &[Self], kernel: Kernel) -> Option<&Interpreter> {
        match &Self::find(own, kernel)?.code {
            Ok(By::Element(code)) if !code.notes().is_empty() => Some(code),
            _ => None,
        }
    }

    pub(super) fn find(own: &[Self], kernel: Kernel) -> Option<&Self> {
        own.iter().find(|own| own.variant.kernel == kernel)
    }

    /// A line of the composed source as its author knows it.
    pub(super) fn named_line(&self, line: usize) -> String {
        self.variant.named_line(line)
    }

    /// `lines` are the one that failed and those that called it.
    pub(super) fn failed(&self, lines: &[usize], pixel: [u32; 2], why: InterpretError) -> Failed {
        let (line, why) = match why {
            InterpretError::Unsupported { what, line } => (Some(line), InterpretError::Unsupported { what, line: 0 }),
            why => (None, why),
        };
        let is_own = |line: &usize| {
            let place = self.variant.replaced.as_ref().and_then(|replaced| replaced.place_of_line(*line));
            place.is_some_and(|place| place.line > 0)
        };
        let own = lines.iter().copied().find(is_own).or(lines.first().copied());
        let kernel = self.variant.kernel;
        let is_ray = kernel.program().rays.is_some() && kernel.instance().over.count == Count::Image;
        let whose = if is_ray { "the ray of pixel" } else { "the element at" };
        Failed { place: self.variant.named_line(line.or(own).unwrap_or(0)), whose, pixel, why }
    }
}

/// What computes an element.
enum Computed<'a, R: Precision> {
    Twin(ElementTwin<R>),
    Wgsl(&'a Interpreted),
}

/// A kernel for elements whose texels are laid out in some way.
pub(crate) struct OnElement<'a, R: Precision> {
    by: Computed<'a, R>,
    /// The layout by the streams that the twin names, or the program.
    layout: Cow<'a, Layout>,
    /// Where the tag is, and pairs of a tag in the program and the one that the twin means, if they differ.
    renamed: Option<(usize, Vec<(Tag, Tag)>)>,
}

impl<'a, R: Precision> OnElement<'a, R> {
    /// For the layout of a set's streams in the kernel's program; `None` if the kernel's elements read each other.
    pub(crate) fn new(kernel: Kernel, interpreted: &'a [Interpreted], layout: &'a Layout) -> Option<Self> {
        if let Some(own) = Interpreted::find(interpreted, kernel) {
            if let Ok(By::Pass(_)) = &own.code {
                return None;
            }
            // Its WGSL has the program's tags and streams.
            return Some(Self { by: Computed::Wgsl(own), layout: Cow::Borrowed(layout), renamed: None });
        }
        let Twin::Element { f32, f64 } = kernel.info().twin else { return None };
        let by = Computed::Twin(R::twin(f32, f64));
        let renamed = kernel.instance().renamed.and_then(|renamed| {
            let tag = layout.first[kernel.course()?.stream.index()]? + STATE_TAG;
            Some((tag, renamed.tags.iter().map(|&(own, here)| (here, own)).collect()))
        });
        if kernel.is_at_home() {
            return Some(Self { by, layout: Cow::Borrowed(layout), renamed });
        }
        let table = kernel.info().home.streams;
        let mut own = Layout { table, stride: layout.stride, ..Layout::of(table, std::iter::empty()) };
        for info in table {
            own.first[info.index] = kernel.stream(Stream::of(info)).and_then(|bound| layout.first[bound.index()]);
        }
        Some(Self { by, layout: Cow::Owned(own), renamed })
    }

    /// Whether it is a user's.
    pub(crate) fn is_interpreted(&self) -> bool {
        matches!(self.by, Computed::Wgsl(_))
    }

    /// Runs it on elements of a set with so many columns and rows, one after the other.
    pub(crate) fn runner<'b>(&'b self, scene: &'b SceneData, size: [u32; 2]) -> Runner<'a, 'b, R> {
        let counter = match &self.by {
            Computed::Wgsl(Interpreted { code: Ok(By::Element(code)), .. }) => Some(code.counter(scene)),
            _ => None,
        };
        Runner { on: self, scene, size, counter, texels: Vec::new() }
    }
}

/// Runs a kernel on elements, one after the other.
pub(crate) struct Runner<'a, 'b, R: Precision> {
    on: &'b OnElement<'a, R>,
    scene: &'b SceneData,
    size: [u32; 2],
    counter: Option<Counter<'b>>,
    texels: Vec<u32>,
}

impl<R: Precision> Runner<'_, '_, R> {
    /// Runs the kernel on the element at this texel.
    ///
    /// # Errors
    /// If it is a user's, and fails.
    pub(crate) fn run(&mut self, row: &mut [R::Bits], x: u32, y: u32) -> Result<(), Failed> {
        let OnElement { by, layout, renamed } = self.on;
        let twin = match by {
            Computed::Twin(twin) => twin,
            Computed::Wgsl(own) => return self.interpret(own, row, [x, y]),
        };
        let Some((at, tags)) = renamed else {
            twin(&mut Texels::new(row, layout, x, y), self.scene);
            return Ok(());
        };
        // The twin has no work for elements in states that it does not know.
        let Some((_, own)) = tags.iter().find(|(here, _)| *here == R::bits_to_u32(row[*at])) else { return Ok(()) };
        row[*at] = R::bits_from_u32(*own);
        twin(&mut Texels::new(row, layout, x, y), self.scene);
        let left = R::bits_to_u32(row[*at]);
        if let Some((here, _)) = tags.iter().find(|(_, own)| *own == left) {
            row[*at] = R::bits_from_u32(*here);
        }
        Ok(())
    }

    /// What the last element has printed.
    pub(crate) fn told(&self) -> Vec<String> {
        self.counter.as_ref().map(Counter::told).unwrap_or_default()
    }

    fn interpret(&mut self, own: &Interpreted, row: &mut [R::Bits], texel: [u32; 2]) -> Result<(), Failed> {
        let (code, counter) = match (&own.code, &mut self.counter) {
            (Ok(By::Element(code)), Some(counter)) => (code, counter),
            (Ok(_), _) => return Ok(()),
            (Err(why), _) => return Err(own.failed(&[], texel, why.clone())),
        };
        let layout = &self.on.layout;
        let places = || {
            code.streams().iter().flat_map(|&stream| {
                let first = layout.first[stream.index()];
                (0..stream.layers()).map(move |layer| (stream, layer, first.map(|first| first + layer)))
            })
        };
        let load = |(stream, layer, at): (Stream, usize, Option<usize>)| {
            at.map_or(0, |at| to_stream_bits::<R>(stream, layer, row[at]))
        };
        self.texels.clear();
        self.texels.extend(places().map(load));
        let before = self.texels.clone();
        let ran = counter.run(Element { texel, size: self.size }, &mut self.texels);
        ran.map_err(|why| own.failed(&counter.lines(), texel, why))?;
        for ((stream, layer, at), (&after, before)) in places().zip(self.texels.iter().zip(before)) {
            // What it leaves alone keeps its precision.
            if let Some(at) = at.filter(|_| after != before) {
                row[at] = from_stream_bits::<R>(stream, layer, after);
            }
        }
        Ok(())
    }
}
