//! Tests of the built binary, as a user runs it. `common` runs it; the tests are grouped by subject.

mod bad_input;
mod bench;
mod build;
mod cast;
mod cast_formats;
mod common;
mod confined;
mod dump;
mod escapes;
mod far;
mod files;
mod formats;
mod history;
mod inspect;
mod left_out;
mod lesson;
mod link;
mod mapping;
mod messages;
mod named;
mod passes;
mod plan;
mod rays_file;
mod report;
mod report_bundle;
mod report_files;
mod report_sections;
mod session_file;
mod shard;
#[cfg(unix)]
mod signals;
mod stability;
mod sweep;
mod text;
mod traversal;
mod ways;
