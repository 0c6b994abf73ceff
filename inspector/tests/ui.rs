//! The window as people use it: every command, a first session, names for who cannot see it, pictures of every panel,
//! and what may go wrong. Drawn on software Vulkan, the best adapter there is; without one these tests fail.

mod adapter;
mod commands;
mod desk;
mod error;
mod exports;
mod hard;
mod names;
mod session;
mod snapshots;
mod stage;
