//! The inspector: a run that can be stepped forwards and backwards, with every stream and the history of every ray.
//!
//! [`session`] does not depend on a user interface and never blocks, so a desktop window, a browser and a test can all
//! use it. [`draw`] renders it with wgpu. [`ui`] is the contents of the window.

pub mod branches;
pub mod command;
pub mod dataflow;
pub mod draw;
pub mod exports;
pub mod hits;
pub mod lesson;
pub mod link;
pub mod names;
pub mod orbit;
pub mod photons;
pub mod ray_text;
pub mod runs;
pub mod saved;
pub mod session;
pub mod session_file;
pub mod settings;
pub mod source;
pub mod ui;
pub mod versioned;
pub mod walk;

pub use session::{Direction, Edit, Fired, OnProgress, Session, Target, Watch, go_on};
