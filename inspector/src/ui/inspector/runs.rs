//! Kept runs in the window: kept, run again, compared and measured, and sessions as files.

mod file;
mod perform;
