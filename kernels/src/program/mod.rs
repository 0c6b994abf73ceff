//! A program as a value: what elements it has, what it keeps for each, the states they go through, its kernels, and in
//! what order they run. Plans, executors, sessions and exports know programs by this value alone.

pub mod breaks;
pub mod check;
pub mod kernel;
pub mod schedule;
pub mod sizes;

use std::borrow::Cow;
use std::fmt;

use crate::options::features::Features;
use crate::scene_data::buffer::BufferInfo;
use crate::tables::elements::Elements;
use crate::tables::kernel::{ListInfo, Transition};
use crate::tables::state::{States, Tag};
use crate::tables::stream::{Stream, StreamInfo};
pub use check::Fault;
pub use kernel::{Instance, Kernel, KernelInfo, Twin};

/// A WGSL module: its name, and its text.
pub type Module = (&'static str, Cow<'static, str>);

/// A stream program.
pub struct Program {
    /// Its name: of its folder, in options and in labels of what it has on a GPU.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// Its sets of elements; the first is what a run is about: its image, or the elements that it is given.
    pub elements: &'static [&'static Elements],
    /// Its streams.
    pub streams: &'static [StreamInfo],
    /// Its states; none where every kernel works on every element.
    pub states: States,
    /// Where its elements begin and end; `None` without states.
    pub course: Option<Course>,
    /// Uniforms and storage buffers that its kernels read.
    pub buffers: &'static [BufferInfo],
    /// Lists of elements that wait for a kernel.
    pub lists: &'static [ListInfo],
    /// Its kernels, each as often as it stands in the program.
    pub kernels: &'static [Instance],
    /// WGSL modules that kernels import from, by name: `package::NAME`.
    pub modules: fn(&Features) -> Vec<Module>,
}

/// Where the elements of a program with states begin and end.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// The stream whose first layer holds the tags.
    pub stream: Stream,
    /// The streams that elements from outside begin with.
    pub inputs: &'static [Stream],
    /// Where elements are as long as nobody has made them.
    pub unborn: Tag,
    /// Where elements begin that come from outside, and those that a kernel makes itself.
    pub born: Tag,
    /// Where an element goes whose walk is given up.
    pub given_up: Tag,
    /// Where an element is that no kernel has work for.
    pub done: Tag,
}

impl Program {
    /// Its kernels.
    pub fn kernels(&'static self) -> impl Iterator<Item = Kernel> {
        self.kernels.iter().map(Kernel::of)
    }

    /// Its streams.
    pub fn streams(&'static self) -> impl Iterator<Item = Stream> {
        self.streams.iter().map(Stream::of)
    }

    /// The kernel with this name.
    #[must_use]
    pub fn kernel(&'static self, name: &str) -> Option<Kernel> {
        self.kernels().find(|kernel| kernel.name() == name)
    }

    /// The stream with this name.
    #[must_use]
    pub fn stream(&'static self, name: &str) -> Option<Stream> {
        self.streams().find(|stream| stream.name() == name)
    }

    /// The buffer with this name.
    #[must_use]
    pub fn buffer(&self, name: &str) -> Option<&'static BufferInfo> {
        self.buffers.iter().find(|buffer| buffer.name == name)
    }

    /// The set of elements with this name.
    #[must_use]
    pub fn elements(&self, name: &str) -> Option<&'static Elements> {
        self.elements.iter().copied().find(|elements| elements.name == name)
    }

    /// The stream of states, where it has states.
    #[must_use]
    pub fn state_stream(&self) -> Option<Stream> {
        self.course.map(|course| course.stream)
    }

    /// The state machine: what the rows of all kernels say of the states between which they send elements.
    pub fn transitions(&'static self) -> impl Iterator<Item = (Kernel, &'static Transition)> {
        self.kernels().flat_map(|kernel| kernel.info().sends.iter().map(move |transition| (kernel, transition)))
    }
}

impl fmt::Debug for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}
