//! The inspector: a run that can be stepped forward and back, every stream in view, one ray's life in words.
//!
//! [`session`] knows no user interface and blocks on nothing, so that a desktop window, a browser and a test
//! can drive the same thing; [`draw`] makes pictures of it with wgpu; [`ui`] is the window's contents.

pub mod dataflow;
pub mod draw;
pub mod exports;
pub mod link;
pub mod names;
pub mod orbit;
pub mod ray_text;
pub mod saved;
pub mod session;
pub mod settings;
pub mod source;
pub mod ui;
pub mod walk;

pub use session::{Edit, Fired, OnProgress, Session, Target, Watch, Way, go_on};
