//! The window: menus, keys and panels for a run.
//!
//! From below: what is drawn and shown ([`canvas`], [`host`], …), the state that panels share (`state`), what a panel is
//! ([`pane`]), the panels, their arrangement (`desk`), and the [`Inspector`] that performs commands. None of them knows
//! what is above it.

pub mod canvas;
mod choice;
mod desk;
pub mod host;
mod inspector;
mod keys;
pub mod latency;
pub mod mask;
pub mod offscreen;
pub mod pane;
mod panels;
mod panes;
mod picture;
mod preview;
pub mod retained;
mod scrub;
mod state;
mod style;
mod svg;
mod thumbs;
pub mod units;

pub use inspector::{Arrival, CheckedStep, Inspector};
pub use style::background;
