//! The window as people use it: every command, a first session, accessible names, snapshots of every panel, and error
//! handling. Drawn on software Vulkan or a better adapter; without an adapter these tests fail.

mod adapter;
mod bounces;
mod branches;
mod choices;
mod commands;
mod cost;
mod desk;
mod error;
mod exports;
mod hard;
mod keyboard;
mod layouts;
mod lessons;
mod light;
mod mapping;
mod measured;
mod names;
mod opening;
mod own_kernels;
mod own_programs;
mod passes;
mod photons;
mod readable;
mod retained;
mod runs;
mod session;
mod session_file;
mod snapshots;
mod stage;
mod tables;
mod timeline;
mod views;
mod walks;
