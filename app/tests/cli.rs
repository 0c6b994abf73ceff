//! The built binary, as a user runs it. `cli/` holds what the tests share and the tests by subject.

#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/common.rs"]
mod common;
#[path = "cli/confined.rs"]
mod confined;
#[path = "cli/dump.rs"]
mod dump;
#[path = "cli/escapes.rs"]
mod escapes;
#[path = "cli/files.rs"]
mod files;
#[path = "cli/inspect.rs"]
mod inspect;
#[path = "cli/link.rs"]
mod link;
#[path = "cli/messages.rs"]
mod messages;
#[cfg(unix)]
#[path = "cli/signals.rs"]
mod signals;
#[path = "cli/text.rs"]
mod text;
#[path = "cli/ways.rs"]
mod ways;
