//! Every kind of panel, and panels in tiles.

use serde::{Deserialize, Serialize};

use super::pane::Panel;
use super::panels;
use crate::command::{Command, PaneKind};
use crate::session::Pinned;
use crate::session_file::layout::SavedPane;

/// A panel in a tile.
pub(super) struct Pane {
    /// What it is.
    pub(super) kind: PaneKind,
    /// The panel.
    pub(super) panel: Box<dyn Panel>,
}

impl Pane {
    /// A new panel of a kind.
    pub(super) fn new(kind: PaneKind) -> Self {
        use PaneKind as K;
        let panel: Box<dyn Panel> = match kind {
            K::Passes => Box::<panels::passes::Passes>::default(),
            K::Stream => Box::<panels::stream::StreamView>::default(),
            K::Ray => Box::<panels::ray::RayView>::default(),
            K::Options => Box::<panels::options::Options>::default(),
            K::Walk3d => Box::<panels::walk3d::Walk3d>::default(),
            K::Walk2d => Box::<panels::walk2d::Walk2d>::default(),
            K::LightTree => Box::<panels::light_tree::LightTreeView>::default(),
            K::Kernel => Box::<panels::kernel::KernelView>::default(),
            K::Bounces => Box::<panels::bounces::BouncesView>::default(),
            K::Timeline => Box::<panels::timeline::Timeline>::default(),
            K::Timings => Box::<panels::timings::Timings>::default(),
            K::Plan => Box::<panels::plan::PlanView>::default(),
            K::Structure => Box::<panels::structure::Structure>::default(),
            K::Cost => Box::<panels::cost::Cost>::default(),
            K::Dataflow => Box::<panels::dataflow::Dataflow>::default(),
            K::Lessons => Box::<panels::lessons::Lessons>::default(),
            K::Log => Box::<panels::log::Log>::default(),
            K::Compare => Box::<panels::compare::Compare>::default(),
            K::Divergence => Box::<panels::divergence::Divergence>::default(),
            K::Error => Box::<panels::error::ErrorOverTime>::default(),
            K::Choices => Box::<panels::choices::Choices>::default(),
            K::Runs => Box::<panels::runs::RunsPanel>::default(),
            K::Watches => Box::<panels::watches::Watches>::default(),
        };
        Self { kind, panel }
    }

    /// A view of a copy of a stream.
    pub(super) fn pinned(copy: Pinned) -> Self {
        Self { kind: PaneKind::Stream, panel: Box::new(panels::stream::StreamView::pinned(copy)) }
    }

    /// The title of its tab.
    pub(super) fn title(&self) -> String {
        self.panel.title().unwrap_or_else(|| Command::Show(self.kind).name().into())
    }
}

impl Serialize for Pane {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SavedPane { kind: self.kind, state: self.panel.save() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Pane {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let saved = SavedPane::deserialize(deserializer)?;
        let mut pane = Self::new(saved.kind);
        pane.panel.load(&saved.state);
        Ok(pane)
    }
}
