//! The inspector in a browser.
//!
//! All of it runs in one Web Worker, which draws on an `OffscreenCanvas`: reading scenes, building structures and the
//! CPU reference kernels never hold up the page. `page/worker.js` creates a [`Window`](window::Window) and passes it the
//! events that `page/page.js` sends; [`shell`] is what the worker can ask of the page.
#![cfg(target_arch = "wasm32")]

mod device;
mod files;
pub mod hits;
mod host;
mod input;
mod painter;
mod shell;
mod tasks;
pub mod window;
