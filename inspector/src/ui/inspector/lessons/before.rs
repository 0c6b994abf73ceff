//! What was there before a lesson, to return to.

use egui_tiles::Tree;

use crate::session::Target;
use crate::session::request::Request;
use crate::settings::Settings;
use crate::ui::desk::arranged::Now;
use crate::ui::panes::Pane;
use crate::ui::units::Units;
use crate::ui::{Arrival, Inspector};

/// The panels, the units, and the run that was open.
pub(super) struct Before {
    pub(super) tree: Tree<Pane>,
    pub(super) arranged: Now,
    pub(super) units: Units,
    run: Option<Run>,
}

/// A run, and the place in it.
struct Run {
    generation: u64,
    path: String,
    settings: Settings,
    arrival: Arrival,
}

impl Before {
    /// Takes the panels of the inspector, and notes the rest. A lesson's numbers are in the units of the streams, so its
    /// panels are as well.
    pub(super) fn take(inspector: &mut Inspector) -> Self {
        let run = inspector.model.opened.as_ref().and_then(|opened| {
            let arrival = Arrival {
                pixel: inspector.state.selection.pixel,
                place: Some(inspector.model.place),
                shown: inspector.state.display.shown,
                ..Arrival::default()
            };
            let (path, settings) = (opened.path.clone()?, opened.settings.clone());
            Some(Run { generation: inspector.model.generation, path, settings, arrival })
        });
        let (tree, arranged) = inspector.desk.lend();
        let units = std::mem::replace(&mut inspector.state.display.units, Units::Traced);
        Self { tree, arranged, units, run }
    }

    /// Brings it back.
    pub(super) fn restore(self, inspector: &mut Inspector) {
        inspector.desk.return_to(self.tree, self.arranged);
        inspector.state.display.units = self.units;
        let Some(Run { generation, path, settings, arrival }) = self.run else { return };
        if inspector.model.generation != generation || inspector.scene.arrival.is_some() {
            inspector.open(&path, settings, arrival);
            return;
        }
        (inspector.state.asks.select, inspector.state.asks.show) = (arrival.pixel, arrival.shown);
        if let Some(place) = arrival.place {
            inspector.model.ask(Request::Step(Target::Pass(place)));
        }
    }
}
