//! What every panel is, and what it can read and request.

use std::sync::Arc;

use egui::{Vec2, vec2};

use super::canvas::Canvas;
use super::state::kept_runs::KeptRuns;
use super::state::{Asks, Bookmarks, Display, Log, Selection, State, Watches};
use crate::command::Command;
use crate::session::Model;

/// What a panel can read and request. Its file begins with the parts that it touches.
pub struct Context<'a> {
    /// The run.
    pub model: &'a mut Model,
    /// The run that it is compared with.
    pub other: Option<&'a mut Model>,
    /// Pictures.
    pub canvas: &'a Arc<Canvas>,
    /// The selected ray, and what else was pointed at.
    pub selection: &'a mut Selection,
    /// How things are shown.
    pub display: &'a mut Display,
    /// What panels ask for.
    pub asks: &'a mut Asks,
    /// Places to return to.
    pub bookmarks: &'a mut Bookmarks,
    /// The watches.
    pub watches: &'a mut Watches,
    /// The messages.
    pub log: &'a mut Log,
    /// The kept runs.
    pub(super) runs: &'a mut KeptRuns,
}

/// What panels about rays show for a program without any.
pub const NO_RAYS: &str = "This program has no rays. The Stream panel shows its elements, pass by pass.";

impl<'a> Context<'a> {
    /// Of a run, and perhaps a second one.
    pub(super) fn new(
        model: &'a mut Model,
        other: Option<&'a mut Model>,
        canvas: &'a Arc<Canvas>,
        state: &'a mut State,
    ) -> Self {
        let State { selection, display, asks, bookmarks, watches, log, runs } = state;
        Self { model, other, canvas, selection, display, asks, bookmarks, watches, log, runs }
    }

    /// Whether the program that is open has rays, or none is open.
    #[must_use]
    pub fn has_rays(&self) -> bool {
        self.model.has_rays()
    }
}

/// A panel.
pub trait Panel {
    /// The title of its tab, if it is not the name of its kind.
    fn title(&self) -> Option<String> {
        None
    }
    /// Shows it.
    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>);
    /// Its saved state; empty if there is none. `saves!` makes this and the next from a field.
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

/// A panel's saved state is one field of it.
macro_rules! saves {
    ($field:ident) => {
        fn save(&self) -> String {
            serde_json::to_string(&self.$field).unwrap_or_default()
        }

        fn load(&mut self, saved: &str) {
            if let Ok(saved) = serde_json::from_str(saved) {
                self.$field = saved;
            }
        }
    };
}
pub(super) use saves;
