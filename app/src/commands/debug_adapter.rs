//! `raystep debug-adapter`

use std::io;

use clap::Args;

use crate::debug_adapter::serve;
use crate::error::Error;

/// Serve the interpreter to an editor: breakpoints in WGSL, variables, steps forward and back
///
/// Speaks the Debug Adapter Protocol over standard input and output. An editor starts it; docs/debug-adapter.md says how. What
/// is debugged is one element of one pass: the editor's launch request says which.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep debug-adapter   # an editor starts it")]
pub(crate) struct DebugAdapterArgs {}

pub(crate) fn run(_: &DebugAdapterArgs) -> Result<(), Error> {
    serve(&mut io::stdin().lock(), &mut io::stdout().lock())
}
