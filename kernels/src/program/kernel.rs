//! A kernel's row, and the instances of kernels in a program.

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

use super::Program;
use super::breaks::Break;
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::options::reasons::{Reason, Run};
use crate::scene_data::SceneData;
use crate::tables::elements::Elements;
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::{StateCounts, Tag};
use crate::tables::stream::Stream;
use crate::tables::texels::{Columns, Texels};

/// Processes one element on the CPU.
pub type ElementTwin<R> = fn(&mut Texels<'_, R>, &SceneData);
/// Runs a whole pass on the CPU.
pub type PassTwin = fn(&mut dyn Columns, Kernel, &SceneData);

/// A kernel's twin, its CPU reference kernel: the same algorithm in Rust.
#[derive(Clone, Copy)]
pub enum Twin {
    /// For a kernel that accesses only its own element, in both precisions.
    Element {
        /// As a GPU computes.
        f32: ElementTwin<f32>,
        /// The reference for comparisons.
        f64: ElementTwin<f64>,
    },
    /// For a kernel whose elements read each other.
    Pass(PassTwin),
}

impl fmt::Debug for Twin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Element { .. } => "Element",
            Self::Pass(_) => "Pass",
        })
    }
}

/// A precision that twins run in.
pub trait Precision: Real {
    /// The twin for this precision.
    fn twin(f32: ElementTwin<f32>, f64: ElementTwin<f64>) -> ElementTwin<Self>;
}

impl Precision for f32 {
    fn twin(f32: ElementTwin<f32>, _: ElementTwin<f64>) -> ElementTwin<Self> {
        f32
    }
}

impl Precision for f64 {
    fn twin(_: ElementTwin<f32>, f64: ElementTwin<f64>) -> ElementTwin<Self> {
        f64
    }
}

/// Proof that no index of a kernel needs a check, for some scenes and options. Only this crate can create one: an
/// unchecked index out of bounds is undefined behaviour.
#[derive(Clone, Copy, Debug)]
pub struct Proof(Option<fn(&SceneData, &Features) -> bool>);

impl Proof {
    /// Every index is checked.
    pub const NONE: Self = Self(None);

    /// No index needs a check if this function returns true.
    pub(crate) const fn new(holds: fn(&SceneData, &Features) -> bool) -> Self {
        Self(Some(holds))
    }

    /// Whether the proof holds for a scene and options.
    #[must_use]
    pub fn holds(&self, data: &SceneData, features: &Features) -> bool {
        self.0.is_some_and(|holds| holds(data, features))
    }
}

/// A row of a program's table of kernels: all facts about a kernel.
#[derive(Clone, Copy, Debug)]
pub struct KernelInfo {
    /// Name of the file and of the entry point.
    pub name: &'static str,
    /// WGSL source, before options are decided.
    pub wgsl: &'static str,
    /// The same algorithm on the CPU.
    pub twin: Twin,
    /// Tags of the elements that it works on; empty if it works on all.
    pub takes: &'static [Tag],
    /// The states it sends them to. A transition to the same tag is listed only if the kernel did work on the element.
    /// Some runs use a subset.
    pub sends: &'static [Transition],
    /// Its role in a run.
    pub role: Role,
    /// Invocations per workgroup along x and along y; if it is launched over a list, in total.
    pub workgroup: u32,
    /// How it is launched over all elements.
    pub launch: Launch,
    /// How the host learns to which states it sent elements.
    pub counts: Counts,
    /// Whether an element may wait for the kernel's next dispatch because one dispatch allows too few loop iterations.
    pub resumes: fn(&Features) -> bool,
    /// The list of elements that wait for it, if only live ones are launched: an index into the program's lists.
    pub list: Option<usize>,
    /// Proof that it may run without index checks.
    pub proof: Proof,
    /// Its colour in all diagrams, sRGB: readable on light and dark backgrounds.
    pub colour: [u8; 3],
    /// Why a run does without it.
    pub why_absent: fn(&Run<'_>) -> Reason,
    /// One sentence about it.
    pub summary: &'static str,
    /// What breaks it on purpose, for the test of its comparison with its CPU reference: at least one.
    pub breaks: &'static [Break],
}

/// An instance of a kernel in a program: the elements it is launched over, and the streams bound to its names.
pub struct Instance {
    /// Its index in the program's table.
    pub index: usize,
    /// Its name: the kernel's, if the program has only one instance of it.
    pub name: &'static str,
    /// The program.
    pub program: &'static Program,
    /// The kernel.
    pub kernel: KernelInfo,
    /// The set of elements it is launched over.
    pub over: &'static Elements,
    /// The value of `launch.parameter`.
    pub parameter: u32,
    /// Streams bound under other names: pairs of a name in the WGSL and a stream.
    pub binds: &'static [(&'static str, &'static str)],
    /// Sets whose numbers of elements are read again before it runs. Their streams are unwritten then, unless the number
    /// is the same.
    pub renews: &'static [&'static Elements],
    /// Pairs (to, from): before the kernel runs, the stream `from` is renamed to `to`, without a copy. The set of `to` takes
    /// the size of the set of `from`, which then has no size until it is renewed. If it has none to begin with, nothing
    /// happens.
    pub adopts: &'static [(Stream, Stream)],
}

/// An instance of a kernel in a program: a row of the program's table.
#[derive(Clone, Copy)]
pub struct Kernel(&'static Instance);

impl Kernel {
    /// The kernel of an instance.
    #[must_use]
    pub const fn of(instance: &'static Instance) -> Self {
        Self(instance)
    }
    /// The facts about the kernel, the same for all instances.
    #[must_use]
    pub const fn info(self) -> &'static KernelInfo {
        &self.0.kernel
    }
    /// Its index in the program.
    #[must_use]
    pub const fn instance(self) -> &'static Instance {
        self.0
    }
    /// The program it belongs to.
    #[must_use]
    pub const fn program(self) -> &'static Program {
        self.0.program
    }
    /// Its name in the program.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.0.name
    }
    /// What is bound to a name in its WGSL: the name itself, unless the instance says otherwise.
    #[must_use]
    pub fn bound(self, name: &str) -> &str {
        self.0.binds.iter().find(|(of, _)| *of == name).map_or(name, |&(_, bound)| bound)
    }
    /// The state in which it leaves every element that it works on, if there is only one.
    #[must_use]
    pub const fn sends_all_to(self) -> Option<Tag> {
        match self.info().counts {
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
            Counts::AllTo(_) => (info.resumes)(features),
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
    /// Number of these elements it would work on.
    #[must_use]
    pub fn live(self, counts: &StateCounts) -> u32 {
        self.info().takes.iter().map(|&tag| counts[tag as usize]).sum()
    }
}

impl PartialEq for Kernel {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
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
        let key = |kernel: &Self| (kernel.0.index, std::ptr::from_ref(kernel.0).addr());
        key(self).cmp(&key(other))
    }
}

impl Hash for Kernel {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::ptr::from_ref(self.0).hash(state);
    }
}

impl fmt::Debug for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Defines a program's table of kernels, and a constant for each of them. A kernel's twin is the function of the same
/// name in the module of the same name.
macro_rules! kernels {
    ($($(#[doc = $doc:literal])* $kernel:ident $module:ident of $over:ident, twin: $twin:ident, { takes: $takes:expr, sends: $sends:expr, role: $role:expr, workgroup: $workgroup:expr, launch: $launch:expr, counts: $counts:expr, resumes: $resumes:expr, list: $list:expr, $(proof: $proof:expr,)? colour: $colour:expr, why_absent: $why_absent:expr, summary: $summary:literal, own: $own:expr, breaks: $breaks:expr, })*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Index { $($kernel),* }

        /// Every kernel.
        pub static KERNELS: [$crate::program::Instance; [$(Index::$kernel as usize),*].len()] =
            [$($crate::program::Instance {
                index: Index::$kernel as usize,
                name: stringify!($module),
                program: &super::PROGRAM,
                kernel: $crate::program::KernelInfo {
                    name: stringify!($module),
                    wgsl: include_str!(concat!(stringify!($module), ".wgsl")),
                    twin: $crate::program::kernel::twin!($twin $module),
                    takes: $takes,
                    sends: $sends,
                    role: $role,
                    workgroup: $workgroup,
                    launch: $launch,
                    counts: $counts,
                    resumes: $resumes,
                    list: $list,
                    proof: $crate::program::kernel::proof!($($proof)?),
                    colour: $colour,
                    why_absent: $why_absent,
                    summary: $summary,
                    breaks: $breaks,
                },
                over: &$over,
                parameter: 0,
                binds: &[],
                renews: &[],
                adopts: &[],
            }),*];

        $($(#[doc = $doc])* pub const $kernel: Kernel = Kernel::of(&KERNELS[Index::$kernel as usize]);)*

        /// The program's own data about each of its kernels.
        pub static OWN: [Own; KERNELS.len()] = [$($own),*];
    };
}
pub(crate) use kernels;

macro_rules! proof {
    () => {
        $crate::program::kernel::Proof::NONE
    };
    ($proof:expr) => {
        $proof
    };
}
pub(crate) use proof;

macro_rules! twin {
    (element $module:ident) => {
        $crate::program::Twin::Element { f32: super::$module::$module::<f32>, f64: super::$module::$module::<f64> }
    };
    (pass $module:ident) => {
        $crate::program::Twin::Pass(super::$module::$module)
    };
}
pub(crate) use twin;
