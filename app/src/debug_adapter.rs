//! The Debug Adapter Protocol (<https://microsoft.github.io/debug-adapter-protocol>): one element of one pass of a kernel,
//! interpreted, for an editor.
//!
//! The element is followed once, to its end; then a position is a number, and going back is as easy as going on. What variables
//! are at a position, another run up to there finds out.

mod breakpoints;
mod reply;
mod requests;
mod session;
mod target;
mod values;
mod wire;

use std::io::{BufRead, Write};

use crate::error::Error;
use requests::Adapter;
use wire::{Wire, read};

/// Answers requests until the client disconnects or its end is reached.
pub(crate) fn serve(input: &mut dyn BufRead, output: &mut dyn Write) -> Result<(), Error> {
    let mut adapter = Adapter::new(Wire::new(output));
    while let Some(message) = read(input)? {
        if !adapter.answer(&message)? {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
