//! The kinds of panels, and their common context.

use std::sync::Arc;

use egui::{Vec2, vec2};
use serde::{Deserialize, Serialize};

use super::canvas::Canvas;
use super::command::Command;
use super::panels;
use super::shared::Shared;
use crate::session::{Model, Pinned};

/// A kind of panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PaneKind {
    /// The passes.
    Passes,
    /// A stream.
    Stream,
    /// The selected ray's history.
    Ray,
    /// Its walk in 3D.
    Walk3d,
    /// Its walk, unfolded.
    Walk2d,
    /// Rays in each state, over passes or time.
    Timeline,
    /// The kernel's WGSL with the branches taken.
    Kernel,
    /// Kernels and streams.
    Dataflow,
    /// Durations.
    Timings,
    /// What the run needs, and what is omitted.
    Plan,
    /// The cost of rays.
    Cost,
    /// Statistics of the grid or BVH.
    Structure,
    /// Comparison of two runs.
    Compare,
    /// Differences between GPU and CPU reference.
    Divergence,
    /// Rays not yet resolved, and resolved wrongly, over time.
    Error,
    /// Time and wrong rays of every structure, schedule and set of rules.
    Choices,
    /// Kept runs.
    Runs,
    /// Watches and edits.
    Watches,
    /// The options of the run.
    Options,
    /// Messages.
    Log,
}

impl PaneKind {
    /// Every kind.
    pub const ALL: &[Self] = &[
        Self::Passes,
        Self::Stream,
        Self::Ray,
        Self::Walk3d,
        Self::Walk2d,
        Self::Timeline,
        Self::Kernel,
        Self::Dataflow,
        Self::Timings,
        Self::Plan,
        Self::Cost,
        Self::Structure,
        Self::Compare,
        Self::Divergence,
        Self::Error,
        Self::Choices,
        Self::Runs,
        Self::Watches,
        Self::Options,
        Self::Log,
    ];

    /// A new panel of this kind.
    #[must_use]
    pub fn make(self) -> Pane {
        let panel: Box<dyn Panel> = match self {
            Self::Passes => Box::<panels::passes::Passes>::default(),
            Self::Stream => Box::<panels::stream::StreamView>::default(),
            Self::Ray => Box::<panels::ray::RayView>::default(),
            Self::Options => Box::<panels::options::Options>::default(),
            Self::Walk3d => Box::<panels::walk3d::Walk3d>::default(),
            Self::Walk2d => Box::<panels::walk2d::Walk2d>::default(),
            Self::Kernel => Box::<panels::kernel::KernelView>::default(),
            Self::Timeline => Box::<panels::timeline::Timeline>::default(),
            Self::Timings => Box::<panels::timings::Timings>::default(),
            Self::Plan => Box::<panels::plan::PlanView>::default(),
            Self::Structure => Box::<panels::structure::Structure>::default(),
            Self::Cost => Box::<panels::cost::Cost>::default(),
            Self::Dataflow => Box::<panels::dataflow::Dataflow>::default(),
            Self::Log => Box::<panels::log::Log>::default(),
            Self::Compare => Box::<panels::compare::Compare>::default(),
            Self::Divergence => Box::<panels::divergence::Divergence>::default(),
            Self::Error => Box::<panels::error::ErrorOverTime>::default(),
            Self::Choices => Box::<panels::choices::Choices>::default(),
            Self::Runs => Box::<panels::runs::RunsPanel>::default(),
            Self::Watches => Box::<panels::watches::Watches>::default(),
        };
        Pane { kind: self, panel }
    }
}

/// What a panel can read and request.
pub struct Context<'a> {
    /// The run.
    pub model: &'a mut Model,
    /// The run that it is compared with.
    pub other: Option<&'a mut Model>,
    /// Pictures.
    pub canvas: &'a Arc<Canvas>,
    /// State shared by panels: the selected ray, the cursor, ranges.
    pub shared: &'a mut Shared,
    /// Commands to perform once all panels are shown.
    pub todo: &'a mut Vec<Command>,
}

/// What panels about rays show for a program without any.
pub const NO_RAYS: &str = "This program has no rays. The Stream panel shows its elements, pass by pass.";

impl Context<'_> {
    /// Whether the program that is open has rays, or none is open.
    #[must_use]
    pub fn has_rays(&self) -> bool {
        self.model.has_rays()
    }
}

/// A panel.
pub trait Panel {
    /// The title of its tab.
    fn title(&self) -> String;
    /// Shows it.
    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>);
    /// Its saved state, as RON; empty if there is none.
    fn save(&self) -> String {
        String::new()
    }
    /// Restores saved state; ignores what it cannot read.
    fn load(&mut self, _saved: &str) {}
    /// The room that its tools and some of its contents need. A smaller tile scrolls.
    fn least(&self) -> Vec2 {
        vec2(240.0, 120.0)
    }
    /// Handles a command about a view; returns whether it did.
    fn command(&mut self, _command: Command, _cx: &mut Context<'_>) -> bool {
        false
    }
}

/// A panel in a tile.
pub struct Pane {
    /// What it is.
    pub kind: PaneKind,
    /// The panel.
    pub panel: Box<dyn Panel>,
}

impl Pane {
    /// A view of a copy of a stream.
    pub(super) fn pinned(copy: Pinned) -> Self {
        Self { kind: PaneKind::Stream, panel: Box::new(panels::stream::StreamView::pinned(copy)) }
    }
}

/// A pane as it is saved.
#[derive(Serialize, Deserialize)]
struct Saved {
    kind: PaneKind,
    #[serde(default)]
    state: String,
}

impl Serialize for Pane {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Saved { kind: self.kind, state: self.panel.save() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Pane {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let saved = Saved::deserialize(deserializer)?;
        let mut pane = saved.kind.make();
        pane.panel.load(&saved.state);
        Ok(pane)
    }
}
