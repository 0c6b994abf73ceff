//! A kernel's row: all that is known of a kernel, in whatever program it runs.

use std::fmt;

use super::breaks::Break;
use super::ray_state::RayState;
use super::rounding::Rounding;
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::options::reasons::{Reason, Run};
use crate::scene_data::SceneData;
use crate::shared::launch::BLOCK;
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::{States, Tag};
use crate::tables::stream::StreamInfo;
use crate::tables::texels::{Columns, Texels};

/// Processes one element on the CPU.
pub type ElementTwin<R> = fn(&mut Texels<'_, R>, &SceneData);
/// Runs a whole pass on the CPU.
pub type PassTwin = fn(&mut dyn Columns, &SceneData);

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
    /// A kernel of a user's program has no Rust: its WGSL is interpreted.
    Interpreted,
}

impl fmt::Debug for Twin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Element { .. } => "Element",
            Self::Pass(_) => "Pass",
            Self::Interpreted => "Interpreted",
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

/// The triangle that a pass tested, if any, and why it left a ray as it did: from the ray before and after it.
pub type Explain = fn(&SceneData, &RayState, &RayState) -> (Option<u32>, String);

/// Where one pass of a kernel takes a ray, along its path through a grid or a BVH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Nowhere, or all the way at once.
    Stays,
    /// Into its first cell, or to the root.
    Enters,
    /// Into its next cell, or out of the grid.
    NextCell,
    /// To the next node, if the box of its node was tested.
    NextNode,
    /// Through several cells or nodes, or none.
    Several,
}

/// The tables whose constants a kernel's row and twin name: those of the program that it was written for. In a program
/// with other tables, an instance says which of its streams and states are meant.
#[derive(Debug)]
pub struct Home {
    /// Streams.
    pub streams: &'static [StreamInfo],
    /// States.
    pub states: States,
}

impl Home {
    /// Of kernels whose twins find their streams by name, and whose elements have no states.
    pub const NONE: Self = Self { streams: &[], states: States(&[]) };
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
    /// The tables that this row and the twin refer to.
    pub home: &'static Home,
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
    /// The name of the list of elements that wait for it, if only live ones are launched.
    pub list: Option<&'static str>,
    /// Proof that it may run without index checks.
    pub proof: Proof,
    /// Its colour in all diagrams, sRGB: readable on light and dark backgrounds.
    pub colour: [u8; 3],
    /// Why a run does without it.
    pub why_absent: fn(&Run<'_>) -> Reason,
    /// One sentence about it.
    pub summary: &'static str,
    /// How it explains what a pass did to a ray.
    pub explain: Explain,
    /// Where one pass of it takes a ray.
    pub path: Path,
    /// What a device that rounds otherwise may change in one pass.
    pub rounding: Rounding,
    /// What breaks it on purpose, for the test of its comparison with its CPU reference: at least one.
    pub breaks: &'static [Break],
}

impl KernelInfo {
    /// The row of a kernel that runs once on every element of a set without states, one to a thread, and whose elements may
    /// read each other. `source` is its name and its WGSL.
    #[must_use]
    pub const fn once(
        (name, wgsl): (&'static str, &'static str),
        twin: PassTwin,
        colour: [u8; 3],
        summary: &'static str,
        why_absent: fn(&Run<'_>) -> Reason,
        breaks: &'static [Break],
    ) -> Self {
        Self {
            name,
            wgsl,
            twin: Twin::Pass(twin),
            home: &Home::NONE,
            takes: &[],
            sends: &[],
            role: Role::Once,
            workgroup: BLOCK as u32,
            launch: Launch::List { each: 1, weight: 1 },
            counts: Counts::None,
            resumes: |_| false,
            list: None,
            proof: Proof::NONE,
            colour,
            why_absent,
            summary,
            explain: |_, _, _| (None, String::new()),
            path: Path::Stays,
            rounding: Rounding::NONE,
            breaks,
        }
    }
}
