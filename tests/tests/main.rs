//! Tests that need several crates together.

mod adding;
mod agreement;
mod any_hit;
mod architecture;
mod cast;
mod coarse_clock;
mod compact;
mod degenerate;
mod device;
mod divergence;
mod floors;
mod intervals;
mod library;
mod mapping;
mod names;
mod parity;
mod plan;
mod programs;
mod renderer;
mod samples;
mod schedules;
mod session;
mod session_changes;
mod stiff;
mod truth;
mod watertight;
