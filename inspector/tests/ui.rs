//! The window as people use it: every command, a first session, accessible names, snapshots of every panel, and error
//! handling. Drawn on software Vulkan or a better adapter; without an adapter these tests fail.

mod adapter;
mod choices;
mod commands;
mod cost;
mod desk;
mod error;
mod exports;
mod hard;
mod measured;
mod names;
mod session;
mod snapshots;
mod stage;
