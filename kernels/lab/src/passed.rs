//! A pass of a kernel in the interpreter: its code, and what the pass begins with.

use raystep_kernels::interpret::pass::{Given, PassError};
use raystep_kernels::interpret::{
    Element, FailedAt, Followed, InterpretError, Interpreter, Many, Recording, Stopped, View, pass,
};
use raystep_kernels::program::Twin;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shader::{Printed, Variant};
use raystep_kernels::tables::elements::Size;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Kernel, Pass, RenderError, Renderer, Stream, StreamData};

/// A kernel for the interpreter.
#[derive(Debug)]
pub enum Code {
    /// One element after the other.
    Element(Interpreter),
    /// All threads of a pass: elements read each other.
    Whole(pass::Pass),
}

/// What a pass begins with.
#[derive(Clone, Debug)]
pub struct Begun {
    /// The pass.
    pub pass: Pass,
    /// The size of the set that the kernel is launched over.
    pub size: Size,
    /// Its streams, in the order of [`Code::streams`].
    pub streams: Vec<StreamData>,
}

/// An element could not be interpreted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{why}")]
pub struct Failure {
    /// Why.
    pub why: InterpretError,
    /// Column and row of the element.
    pub texel: [u32; 2],
    /// The lines of the composed source, from 1, that it ran last: in the function that ran, in the one that called it, and
    /// so on.
    pub lines: Vec<usize>,
}

impl From<PassError> for Failure {
    fn from(PassError { why, texel, lines }: PassError) -> Self {
        Self { why, texel, lines }
    }
}

impl Failure {
    fn of(FailedAt { why, element, lines }: FailedAt, size: Size) -> Self {
        let width = size.width.max(1);
        Self { why, texel: [element as u32 % width, element as u32 / width], lines }
    }
}

impl Code {
    /// Prepares a variant, with a limit for the turns of all loops of a thread.
    ///
    /// # Errors
    /// If it has what the interpreter does not know.
    pub fn new(variant: &Variant, turns: u32) -> Result<Self, InterpretError> {
        if matches!(variant.kernel.info().twin, Twin::Element { .. }) {
            match Interpreter::new(variant) {
                Ok(code) => return Ok(Self::Element(code.limited(turns))),
                Err(InterpretError::NotAlone(_)) => {}
                Err(why) => return Err(why),
            }
        }
        pass::Pass::new(variant).map(|code| Self::Whole(code.limited(turns)))
    }

    /// The code of one element.
    #[must_use]
    pub fn interpreter(&self) -> &Interpreter {
        match self {
            Self::Element(code) => code,
            Self::Whole(code) => code.code(),
        }
    }

    /// The kernel.
    #[must_use]
    pub fn kernel(&self) -> Kernel {
        self.interpreter().kernel()
    }

    /// The streams that it reads or writes.
    #[must_use]
    pub fn streams(&self) -> &[Stream] {
        self.interpreter().streams()
    }

    /// What elements did at the kernel's stops in a pass, of those that came to one, by their place in the set.
    ///
    /// # Errors
    /// If an element cannot be interpreted: the first.
    pub fn stopped(&self, begun: &Begun, data: &SceneData) -> Result<Vec<(usize, Vec<Stopped>)>, Failure> {
        let data = &*self.kernel().reads(data);
        match self {
            Self::Element(kernel) => {
                let many = Many { kernel, data, streams: &begun.streams };
                many.stopped(0..usize::MAX).map_err(|failed| Failure::of(failed, begun.size))
            }
            Self::Whole(code) => Ok(code.run(&begun.given(data))?.stopped),
        }
    }

    /// The steps of an element, of a kernel that [`Sourced::stopping`](raystep_kernels::shader::Sourced::stopping) has traced.
    ///
    /// # Errors
    /// If the pass has no such element, or another one fails before.
    pub fn follow(&self, begun: &Begun, data: &SceneData, texel: [u32; 2]) -> Result<Followed, Failure> {
        let data = &*self.kernel().reads(data);
        match self {
            Self::Element(code) => Ok(code.follow(data, begun.element(texel), &begun.texels(texel))),
            Self::Whole(code) => Ok(code.follow(&begun.given(data), texel)?),
        }
    }

    /// What the element's variables are at a step; behind the last, when it has ended or failed.
    ///
    /// # Errors
    /// As [`follow`](Self::follow), and if an expression that is evaluated there has no value.
    pub fn view(&self, begun: &Begun, data: &SceneData, texel: [u32; 2], step: usize) -> Result<View, Failure> {
        let data = &*self.kernel().reads(data);
        match self {
            Self::Element(code) => {
                let view = code.view(data, begun.element(texel), &begun.texels(texel), step);
                view.map_err(|why| Failure { why, texel, lines: Vec::new() })
            }
            Self::Whole(code) => Ok(code.view(&begun.given(data), texel, step)?),
        }
    }

    /// What happened to an element.
    ///
    /// # Errors
    /// If it cannot be interpreted, or the pass has no such element.
    pub fn record(&self, begun: &Begun, data: &SceneData, texel: [u32; 2]) -> Result<Recording, Failure> {
        let data = &*self.kernel().reads(data);
        match self {
            Self::Element(code) => {
                let recording = code.record(data, begun.element(texel), &mut begun.texels(texel));
                recording.map_err(|why| Failure { why, texel, lines: Vec::new() })
            }
            Self::Whole(code) => Ok(code.record(&begun.given(data), texel)?),
        }
    }

    /// What each element of a pass prints, in the order of the kernel's notes.
    ///
    /// # Errors
    /// As [`stopped`](Self::stopped).
    pub fn noted(&self, begun: &Begun, data: &SceneData) -> Result<Vec<Vec<Printed>>, Failure> {
        let data = &*self.kernel().reads(data);
        match self {
            Self::Element(kernel) => {
                let many = Many { kernel, data, streams: &begun.streams };
                let failed = |why| Failure { why, texel: [0; 2], lines: Vec::new() };
                many.noted(0..begun.size.texels() as usize).map_err(failed)
            }
            Self::Whole(code) => {
                let noted = code.run(&begun.given(data))?.noted;
                Ok(noted.chunks(code.notes().len().max(1)).map(<[_]>::to_vec).collect())
            }
        }
    }

    /// Whether a pass works on an element: on all, or on those in the states that the kernel takes.
    #[must_use]
    pub fn works_on(&self, begun: &Begun, texel: [u32; 2]) -> bool {
        let kernel = self.kernel();
        let Some(course) = kernel.course().filter(|_| !kernel.takes().is_empty()) else { return true };
        let Some(state) = begun.streams.iter().find(|data| data.stream == course.stream) else { return true };
        let at = texel[1] as usize * state.width as usize + texel[0] as usize;
        at >= state.layer(STATE_TAG).len() || kernel.takes().contains(&state.get(STATE_TAG, at))
    }

    /// The number of elements that a pass works on, and how often they ran each statement together.
    ///
    /// # Errors
    /// As [`stopped`](Self::stopped).
    pub fn runs(&self, begun: &Begun, data: &SceneData) -> Result<(u64, Vec<u64>), Failure> {
        let data = &*self.kernel().reads(data);
        match self {
            Self::Element(kernel) => {
                let many = Many { kernel, data, streams: &begun.streams };
                let failed = |why| Failure { why, texel: [0; 2], lines: Vec::new() };
                many.runs(0..usize::MAX).map_err(failed)
            }
            Self::Whole(code) => Ok((begun.size.count.into(), code.run(&begun.given(data))?.runs)),
        }
    }
}

impl Begun {
    /// An element, for the interpreter.
    #[must_use]
    pub fn element(&self, texel: [u32; 2]) -> Element {
        Element { texel, size: [self.size.width, self.size.height] }
    }

    /// An element's components; 0 where a stream has none.
    #[must_use]
    pub fn texels(&self, [x, y]: [u32; 2]) -> Vec<u32> {
        let own = self.streams.iter().flat_map(|data| (0..data.stream.layers()).map(move |layer| (data, layer)));
        let at = |data: &StreamData| y as usize * data.width as usize + x as usize;
        own.map(|(data, layer)| data.layer(layer).get(at(data)).copied().unwrap_or_default()).collect()
    }

    /// For [`pass::Pass`].
    #[must_use]
    pub fn given<'a>(&'a self, data: &'a SceneData) -> Given<'a> {
        Given { data, size: self.size, parameter: self.pass.parameter, streams: &self.streams }
    }
}

/// Streams as the next pass of a run will find them.
#[derive(Clone, Debug)]
pub struct Before(Vec<(Stream, Option<StreamData>)>);

impl Before {
    /// Reads them; `None` at the end of the run.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn read(renderer: &Renderer, streams: &[Stream]) -> Result<Option<Self>, RenderError> {
        let Some(kernel) = renderer.next_kernel() else { return Ok(None) };
        let instance = kernel.instance();
        let mut before = Vec::new();
        for &stream in streams {
            let pairs = instance.copies.iter().chain(instance.adopts);
            let from = pairs.clone().find(|(to, _)| *to == stream).map_or(stream, |(_, from)| *from);
            let is_new = instance.renews.iter().any(|set| set.name == stream.info().elements.name);
            let is_known = renderer.size(from.info().elements).is_some() && !(is_new && from == stream);
            let values = if is_known { Some(renderer.values(from).await?) } else { None };
            before.push((stream, values.map(|values| StreamData { stream, ..values })));
        }
        Ok(Some(Self(before)))
    }

    /// What the pass began with, once it has run.
    #[must_use]
    pub fn begun(self, renderer: &Renderer) -> Option<Begun> {
        let pass = renderer.last_pass()?;
        let size = renderer.size(pass.kernel.instance().over)?;
        let data = self.0.into_iter().map(|(stream, before)| {
            let size = renderer.size(stream.info().elements);
            let is_as_large =
                |data: &StreamData| size.is_none_or(|size| [data.width, data.height] == [size.width, size.height]);
            before.filter(is_as_large).unwrap_or_else(|| unwritten(stream, size))
        });
        Some(Begun { size, streams: data.collect(), pass })
    }
}

/// Runs the next pass of a run, and returns what it began with; `None` at the end.
///
/// # Errors
/// If the device fails.
pub async fn step(renderer: &mut Renderer, streams: &[Stream]) -> Result<Option<Begun>, RenderError> {
    let Some(before) = Before::read(renderer, streams).await? else { return Ok(None) };
    Ok(renderer.step().await?.and_then(|_| before.begun(renderer)))
}

/// A stream whose elements the pass has counted.
fn unwritten(stream: Stream, size: Option<Size>) -> StreamData {
    let (width, height) = size.map_or((0, 0), |size| (size.width, size.height));
    let texels = width as usize * height as usize;
    let bits = stream.info().unwritten.iter().flat_map(|&bits| std::iter::repeat_n(bits, texels)).collect();
    StreamData { stream, width, height, bits }
}
