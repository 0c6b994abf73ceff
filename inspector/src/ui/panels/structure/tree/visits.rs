//! The nodes that the selected ray comes to.

use std::collections::HashMap;
use std::sync::Arc;

use raystep_kernels::export::trace::Trace;
use raystep_kernels::scene_data::SceneData;

use crate::ui::pane::Context;
use crate::walk::{WalkGeometry, last_row_of_ray, row_after_passes};

/// What the ray did at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Visit {
    is_met: bool,
    /// Whether that was before the current place.
    has_run: bool,
}

impl Visit {
    pub(super) fn is_met(self) -> bool {
        self.is_met && self.has_run
    }

    pub(super) fn text(self) -> &'static str {
        match (self.has_run, self.is_met) {
            (true, true) => "met",
            (true, false) => "missed",
            (false, _) => "ahead",
        }
    }
}

/// The visits of a ray's history, and what they were found for.
#[derive(Default)]
pub(super) struct Visits {
    of: Option<(Arc<Trace>, usize)>,
    visits: HashMap<u32, Visit>,
}

impl Visits {
    /// Finds them for the selected ray at the current place.
    pub(super) fn update(&mut self, cx: &Context<'_>, data: &SceneData) {
        let now = cx.model.history.as_ref().map(|history| (history, cx.model.place));
        let is_same = match (&self.of, now) {
            (Some((known, at)), Some((history, place))) => Arc::ptr_eq(known, history) && *at == place,
            (None, None) => true,
            _ => false,
        };
        if !is_same {
            self.visits = now.map_or_else(HashMap::new, |(history, place)| visits(history, data, place));
            self.of = now.map(|(history, place)| (history.clone(), place));
        }
    }

    pub(super) fn of(&self, node: u32) -> Option<Visit> {
        self.visits.get(&node).copied()
    }

    /// The nodes whose boxes the ray meets, now or later.
    pub(super) fn met(&self) -> impl Iterator<Item = u32> + '_ {
        self.visits.iter().filter(|(_, visit)| visit.is_met).map(|(&node, _)| node)
    }
}

fn visits(history: &Trace, data: &SceneData, place: usize) -> HashMap<u32, Visit> {
    let last = last_row_of_ray(history, row_after_passes(history, place));
    let walk = WalkGeometry::new(history, data, last);
    let visit = |node: &crate::walk::NodeVisit| {
        let has_run = history.rows.get(node.row).is_some_and(|row| row.is_within(place));
        (node.node, Visit { is_met: node.is_met, has_run })
    };
    walk.nodes.iter().map(visit).collect()
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::export::trace::{Rays, trace};
    use raystep_kernels::{Accelerator, Device, Options, RaySource, Renderer, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    #[test]
    fn nodes_are_met_or_missed_and_ahead_until_their_pass_has_run() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options {
            accelerator: Accelerator::Bvh,
            schedule: ScheduleKind::Second,
            ..Options::new(RaySource::Camera { camera, width: 8, height: 8 })
        };
        let (history, data) = pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let history =
                trace(&mut renderer, 3, 4, Rays::All, |_| ControlFlow::Continue(())).await.expect("a history");
            (history, renderer.shared_data())
        });
        let all = visits(&history, &data, history.passes.expect("the whole run"));
        assert_eq!(all.get(&0).map(|visit| visit.text()), Some("met"), "the root");
        assert!(all.values().all(|visit| visit.has_run) && all.values().any(|visit| !visit.is_met));
        let none = visits(&history, &data, 0);
        assert!(none.len() == all.len() && none.values().all(|visit| visit.text() == "ahead" && !visit.is_met()));
        let some = visits(&history, &data, 8).values().filter(|visit| visit.has_run).count();
        assert!(some > 0 && some < all.len(), "{some} of {}", all.len());
    }
}
