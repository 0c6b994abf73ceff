//! A kernel's row, and the places where a kernel stands in a program.

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
use crate::tables::texels::{Columns, Texels};

/// One element's work on the CPU.
pub type ElementTwin<R> = fn(&mut Texels<'_, R>, &SceneData);
/// A whole pass on the CPU.
pub type PassTwin = fn(&mut dyn Columns, Kernel, &SceneData);

/// A kernel's twin, its CPU reference kernel: the same algorithm in Rust.
#[derive(Clone, Copy)]
pub enum Twin {
    /// Of a kernel that looks at its own element alone, in both precisions.
    Element {
        /// As a GPU computes.
        f32: ElementTwin<f32>,
        /// For comparison.
        f64: ElementTwin<f64>,
    },
    /// Of a kernel whose elements look at each other.
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

/// A precision in which twins run.
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

/// That no index of a kernel needs a check, for some scenes and options. Only this crate proves it: what indexes out of
/// bounds without a check may do anything.
#[derive(Clone, Copy, Debug)]
pub struct Proof(Option<fn(&SceneData, &Features) -> bool>);

impl Proof {
    /// Every index is checked.
    pub const NONE: Self = Self(None);

    /// No index needs a check where this holds.
    pub(crate) const fn new(holds: fn(&SceneData, &Features) -> bool) -> Self {
        Self(Some(holds))
    }

    /// Whether it holds.
    #[must_use]
    pub fn holds(&self, data: &SceneData, features: &Features) -> bool {
        self.0.is_some_and(|holds| holds(data, features))
    }
}

/// A row of a program's table of kernels: all that is known of a kernel.
#[derive(Clone, Copy, Debug)]
pub struct KernelInfo {
    /// Name of the file and of the entry point.
    pub name: &'static str,
    /// Source with its options still in it.
    pub wgsl: &'static str,
    /// The same algorithm on the CPU.
    pub twin: Twin,
    /// Tags of the elements that it works on; none for a kernel that works on all.
    pub takes: &'static [Tag],
    /// Where it sends them. A pass that leaves a tag as it was is listed only where the kernel worked on the element.
    /// Some runs use a subset.
    pub sends: &'static [Transition],
    /// What it is for in a run.
    pub role: Role,
    /// Invocations of its workgroups along x and y, or of a workgroup where it is launched over a list.
    pub workgroup: u32,
    /// How it is launched over all elements.
    pub launch: Launch,
    /// How the host learns where it sent elements.
    pub counts: Counts,
    /// Whether an element may wait there for the next dispatch, as one has too few loop turns for it.
    pub resumes: fn(&Features) -> bool,
    /// The list of the elements that wait for it, where only live ones are launched: an index into the program's.
    pub list: Option<usize>,
    /// Whether it may run without checks of its indices.
    pub proof: Proof,
    /// Its colour in every diagram, sRGB: readable on light and dark.
    pub colour: [u8; 3],
    /// Why a run does without it.
    pub why_absent: fn(&Run<'_>) -> Reason,
    /// One sentence.
    pub summary: &'static str,
    /// What breaks it on purpose, for the test of its comparison with its CPU reference: at least one.
    pub breaks: &'static [Break],
}

/// A place of a kernel in a program: what it is launched over, and what is bound to its names.
pub struct Instance {
    /// Its place in the program's table.
    pub index: usize,
    /// Its name: the kernel's, where that stands in the program once.
    pub name: &'static str,
    /// The program.
    pub program: &'static Program,
    /// The kernel.
    pub kernel: KernelInfo,
    /// What it is launched over.
    pub over: &'static Elements,
    /// What `launch.parameter` is to it.
    pub parameter: u32,
    /// The streams bound to its names, where they have others.
    pub binds: &'static [(&'static str, &'static str)],
}

/// A kernel where it stands in a program: a row of the program's table.
#[derive(Clone, Copy)]
pub struct Kernel(&'static Instance);

impl Kernel {
    /// The kernel of a row.
    #[must_use]
    pub const fn of(instance: &'static Instance) -> Self {
        Self(instance)
    }
    /// What is known of the kernel, wherever it stands.
    #[must_use]
    pub const fn info(self) -> &'static KernelInfo {
        &self.0.kernel
    }
    /// Its place in the program.
    #[must_use]
    pub const fn instance(self) -> &'static Instance {
        self.0
    }
    /// The program in which it stands.
    #[must_use]
    pub const fn program(self) -> &'static Program {
        self.0.program
    }
    /// Its name in the program.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.0.name
    }
    /// What is bound to a name of its WGSL: the name itself, unless its place in the program says otherwise.
    #[must_use]
    pub fn bound(self, name: &str) -> &str {
        self.0.binds.iter().find(|(of, _)| *of == name).map_or(name, |&(_, bound)| bound)
    }
    /// The state in which it leaves every element that it works on, where there is only one.
    #[must_use]
    pub const fn sends_all_to(self) -> Option<Tag> {
        match self.info().counts {
            Counts::AllTo(tag) => Some(tag),
            Counts::Sent | Counts::Anew | Counts::None => None,
        }
    }
    /// Whether the elements in each state are counted anew after a pass of it, in a run with these options.
    #[must_use]
    pub fn is_counted_anew(self, features: &Features) -> bool {
        let info = self.info();
        match info.counts {
            Counts::Sent | Counts::None => false,
            Counts::AllTo(_) => (info.resumes)(features),
            Counts::Anew => true,
        }
    }
    /// What it is for in a run.
    #[must_use]
    pub const fn role(self) -> Role {
        self.info().role
    }
    /// Whether it belongs to the walk: it runs again and again.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        self.info().role.is_walk()
    }
    /// Invocations of its workgroups along x and y.
    #[must_use]
    pub const fn workgroup(self) -> u32 {
        self.info().workgroup
    }
    /// How many of these elements it would work on.
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
    /// In the order of their table; kernels of two programs in any.
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

/// A program's table of kernels, and a constant for each of them. A kernel's twin is the function of its name in the
/// module of its name.
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
            }),*];

        $($(#[doc = $doc])* pub const $kernel: Kernel = Kernel::of(&KERNELS[Index::$kernel as usize]);)*

        /// What this program alone says of each of its kernels.
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
