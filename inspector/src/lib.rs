//! What the inspector is about, without a window: a run that can be stepped forward and back.
//!
//! [`session::Session`] knows no user interface and blocks on nothing, so that a desktop window, a
//! browser and a test can drive the same thing.

pub mod dataflow;
pub mod draw;
pub mod exports;
pub mod link;
pub mod orbit;
pub mod saved;
pub mod session;
pub mod source;
pub mod walk;

pub use session::{Edit, Fired, OnProgress, Session, Target, Watch, Way, go_on};
