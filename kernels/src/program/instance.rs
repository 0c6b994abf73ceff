//! The instances of kernels in a program: what is bound to the names of each, also in a program that it was not written for.

mod rows;

use std::borrow::Cow;
use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

use super::kernel::KernelInfo;
use super::{Course, Program, RayState};
use crate::options::features::Features;
use crate::scene_data::SceneData;
use crate::shared::launch::BLOCK;
use crate::tables::elements::{Elements, Size};
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::{StateCounts, States, Tag};
use crate::tables::stream::Stream;
pub(crate) use rows::{kernels, proof, twin};

/// An instance of a kernel in a program: the elements it is launched over, and the streams, lists and states that are bound
/// to its names.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Its name: the kernel's, if the program has only one instance of it.
    pub name: &'static str,
    /// The kernel.
    pub kernel: KernelInfo,
    /// The set of elements it is launched over.
    pub over: &'static Elements,
    /// The value of `launch.parameter`.
    pub parameter: u32,
    /// Streams, buffers and lists bound under other names: pairs of a name in the WGSL and one in the program.
    pub binds: &'static [(&'static str, &'static str)],
    /// The states of the kernel, if the program calls them otherwise.
    pub renamed: Option<&'static Renamed>,
    /// Options of the WGSL that are others in this instance than in the run.
    pub sets: &'static [(&'static str, bool)],
    /// Options of the WGSL that are in this instance what another option is in the run.
    pub follows: &'static [(&'static str, &'static str)],
    /// Sets whose numbers of elements are read again before it runs. Their streams are unwritten then, unless the number
    /// is the same.
    pub renews: &'static [&'static Elements],
    /// Pairs (to, from): before the kernel runs, the stream `from` is renamed to `to`, without a copy. The set of `to` takes
    /// the size of the set of `from`, which then has no size until it is renewed. If it has none to begin with, nothing
    /// happens.
    pub adopts: &'static [(Stream, Stream)],
    /// Pairs (to, from): before the kernel runs, the stream `from` is copied to `to`, of the same elements.
    pub copies: &'static [(Stream, Stream)],
}

impl Instance {
    /// The only instance of a kernel in a program, over a set of elements.
    #[must_use]
    pub const fn of(kernel: KernelInfo, over: &'static Elements) -> Self {
        Self {
            name: kernel.name,
            kernel,
            over,
            parameter: 0,
            binds: &[],
            renamed: None,
            sets: &[],
            follows: &[],
            renews: &[],
            adopts: &[],
            copies: &[],
        }
    }

    /// Its options that are others than the run's, and these.
    pub(crate) fn with_sets(&self, more: &'static [(&'static str, bool)]) -> &'static [(&'static str, bool)] {
        if self.sets.is_empty() { more } else { Vec::leak([self.sets, more].concat()) }
    }
}

/// The tag of a state that no element of an instance is ever in.
const NEVER: Tag = Tag::MAX - 1;

/// The states of a kernel as a program calls them in which it is a guest.
#[derive(Debug)]
pub struct Renamed {
    /// Each of the kernel's own states, and the one of the program that is meant.
    pub tags: Vec<(Tag, Tag)>,
    takes: Vec<Tag>,
    sends: Vec<Transition>,
    counts: Counts,
}

impl Renamed {
    /// The states of a kernel, by pairs of a name in its [`Home`](super::Home) and one in a program with these states; a state that no
    /// pair names has the same name in both, and one whose name is empty in the program never occurs in it. `None` if one of the
    /// two does not have it.
    #[must_use]
    pub fn new(kernel: &KernelInfo, states: States, names: &[(&str, &str)]) -> Option<Self> {
        let here = |name: &'static str| names.iter().find(|(own, _)| *own == name).map_or(name, |(_, here)| here);
        let is_known = |(own, _): &(&str, &str)| kernel.home.states.tag(own).is_some();
        if !names.iter().all(is_known) {
            return None;
        }
        let tag = |name: &str| if name.is_empty() { Some(NEVER) } else { states.tag(name) };
        let pairs = kernel.home.states.iter().filter_map(|own| Some((own.tag, tag(here(own.name))?)));
        let tags: Vec<(Tag, Tag)> = pairs.collect();
        let of = |own: Tag| tags.iter().find(|(tag, _)| *tag == own).map(|&(_, here)| here);
        let mut takes = kernel.takes.iter().map(|&tag| of(tag)).collect::<Option<Vec<_>>>()?;
        let send = |sent: &Transition| Some(Transition { from: of(sent.from)?, when: sent.when, to: of(sent.to)? });
        let mut sends = kernel.sends.iter().map(send).collect::<Option<Vec<_>>>()?;
        takes.retain(|&tag| tag != NEVER);
        sends.retain(|sent| sent.from != NEVER && sent.to != NEVER);
        let counts = match kernel.counts {
            Counts::AllTo(tag) => Counts::AllTo(of(tag)?),
            other => other,
        };
        Some(Self { tags, takes, sends, counts })
    }

    /// The same for an instance that never creates an element.
    #[must_use]
    pub fn of_existing(mut self) -> Self {
        self.sends.retain(|sent| self.takes.contains(&sent.from));
        self
    }
}

/// An instance of a kernel in a program: a row of the program's table.
#[derive(Clone, Copy)]
pub struct Kernel {
    program: &'static Program,
    index: usize,
}

impl Kernel {
    /// The kernel at an index of a program's table, which must be below the table's length.
    #[must_use]
    pub const fn at(program: &'static Program, index: usize) -> Self {
        Self { program, index }
    }

    /// The facts about the kernel, the same for all instances but for states: see [`takes`](Self::takes).
    #[must_use]
    pub const fn info(self) -> &'static KernelInfo {
        &self.instance().kernel
    }

    /// Its row of the program's table.
    #[must_use]
    pub const fn instance(self) -> &'static Instance {
        &self.program.kernels[self.index]
    }

    /// Its index in the program.
    #[must_use]
    pub const fn index(self) -> usize {
        self.index
    }

    /// The program it belongs to.
    #[must_use]
    pub const fn program(self) -> &'static Program {
        self.program
    }

    /// Tags of the elements that it works on, in the program; empty if it works on all.
    #[must_use]
    pub fn takes(self) -> &'static [Tag] {
        self.instance().renamed.map_or(self.info().takes, |renamed| &renamed.takes)
    }

    /// The states it sends them to, in the program.
    #[must_use]
    pub fn sends(self) -> &'static [Transition] {
        self.instance().renamed.map_or(self.info().sends, |renamed| &renamed.sends)
    }

    /// How the host learns to which states it sent elements.
    #[must_use]
    pub fn counts(self) -> Counts {
        self.instance().renamed.map_or(self.info().counts, |renamed| renamed.counts)
    }

    /// The course of the elements that it is launched over; `None` if they have no states.
    #[must_use]
    pub fn course(self) -> Option<&'static Course> {
        self.program.course_of(self.instance().over)
    }

    /// The index of its list among the program's, if it has one.
    #[must_use]
    pub fn list(self) -> Option<usize> {
        let name = self.bound(self.info().list?);
        self.program.lists.iter().position(|list| list.name == name)
    }

    /// The stream of the program that is bound to one of the kernel's [`Home`](super::Home).
    #[must_use]
    pub fn stream(self, own: Stream) -> Option<Stream> {
        self.program.stream(self.bound(own.name()))
    }

    /// Whether its twin reads the program's streams as they are: those of its [`Home`](super::Home), or the first of them.
    pub(crate) fn is_at_home(self) -> bool {
        let (home, here) = (self.info().home.streams, self.program.streams);
        std::ptr::eq(home.as_ptr(), here.as_ptr()) && self.instance().binds.is_empty()
    }

    /// What it reads of a scene in a run that reads this.
    #[must_use]
    pub fn reads(self, data: &SceneData) -> Cow<'_, SceneData> {
        let features = self.features(&data.features);
        if features == data.features { Cow::Borrowed(data) } else { Cow::Owned(data.with(features)) }
    }

    /// The triangle that a pass of it tested, if any, and why it left a ray as it did.
    #[must_use]
    pub fn explain(self, data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
        let [before, after] = [before, after].map(|ray| self.as_its_own(ray));
        (self.info().explain)(&self.reads(data), &before, &after)
    }

    /// A ray whose state is called as the kernel's row and twin call it.
    fn as_its_own(self, ray: &RayState) -> RayState {
        let mut tags = self.instance().renamed.into_iter().flat_map(|renamed| &renamed.tags);
        RayState { tag: tags.find(|(_, here)| *here == ray.tag).map_or(ray.tag, |&(own, _)| own), ..*ray }
    }

    /// The options that it is compiled with in a run with these options.
    #[must_use]
    pub fn features(self, of_run: &Features) -> Features {
        let mut features = *of_run;
        for &(name, other) in self.instance().follows {
            let is_on = of_run.list().into_iter().any(|(option, is_on)| option == other && is_on);
            features.set(name, is_on);
        }
        for &(name, is_on) in self.instance().sets {
            features.set(name, is_on);
        }
        features
    }

    /// Its name in the program.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.instance().name
    }

    /// What is bound to a name in its WGSL: the name itself, unless the instance says otherwise.
    #[must_use]
    pub fn bound(self, name: &str) -> &str {
        self.instance().binds.iter().find(|(of, _)| *of == name).map_or(name, |&(_, bound)| bound)
    }

    /// The state in which it leaves every element that it works on, if there is only one.
    #[must_use]
    pub fn sends_all_to(self) -> Option<Tag> {
        match self.counts() {
            Counts::AllTo(tag) => Some(tag),
            Counts::Sent | Counts::Anew | Counts::None => None,
        }
    }

    /// Whether the elements in each state have to be recounted after a pass of it, in a run with these options.
    #[must_use]
    pub fn is_counted_anew(self, features: &Features) -> bool {
        let info = self.info();
        match info.counts {
            Counts::Sent | Counts::None => false,
            Counts::AllTo(_) => (info.resumes)(&self.features(features)),
            Counts::Anew => true,
        }
    }

    /// Its role in a run.
    #[must_use]
    pub const fn role(self) -> Role {
        self.info().role
    }

    /// Whether it belongs to the walk, and so runs repeatedly.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        self.info().role.is_walk()
    }

    /// Invocations of its workgroups along x and y.
    #[must_use]
    pub const fn workgroup(self) -> u32 {
        self.info().workgroup
    }

    /// Workgroups along x and y of a launch over all elements of a set.
    #[must_use]
    pub(crate) fn groups(self, size: Size) -> [u32; 2] {
        /// The minimum that WebGPU guarantees along an axis.
        const MOST: u32 = 65_535;
        let workgroup = self.workgroup();
        match self.info().launch {
            // As many workgroups as cover the elements; a few more if they do not fit in one row.
            Launch::List { each, .. } => {
                let blocks = match each {
                    // Enough workgroups for either `element` or `element_of_rows`.
                    1 if workgroup == BLOCK as u32 => {
                        let in_rows = size.height.div_ceil(2) * (size.width / (workgroup / 2));
                        size.count.div_ceil(workgroup).max(in_rows)
                    }
                    _ => size.count.div_ceil(workgroup * each),
                };
                let rows = blocks.div_ceil(MOST).max(1);
                [blocks.div_ceil(rows), rows]
            }
            Launch::Whole | Launch::Bands => [size.width, size.height].map(|side| side.div_ceil(workgroup)),
        }
    }

    /// Number of these elements it would work on.
    #[must_use]
    pub fn live(self, counts: &StateCounts) -> u32 {
        counts.in_any(self.takes())
    }
}

impl PartialEq for Kernel {
    fn eq(&self, other: &Self) -> bool {
        self.index == other.index && std::ptr::eq(self.program, other.program)
    }
}

impl Eq for Kernel {}

impl PartialOrd for Kernel {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Kernel {
    /// In table order; the order between kernels of different programs is arbitrary.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |kernel: &Self| (kernel.index, std::ptr::from_ref(kernel.program).addr());
        key(self).cmp(&key(other))
    }
}

impl Hash for Kernel {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.index, std::ptr::from_ref(self.program)).hash(state);
    }
}

impl fmt::Debug for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
