//! Messages with a header that says how long they are.

use std::io::{self, BufRead, Read as _, Write};

use serde_json::{Value, json};

use crate::error::{Error, reason};

/// Most bytes of a message.
const MOST_BYTES: usize = 16 << 20;
/// Most bytes of all header lines of a message.
const MOST_HEADER: u64 = 8 << 10;

fn unframed() -> Error {
    Error::failed("expected a header with Content-Length, as the Debug Adapter Protocol has it")
}

fn unread(error: &io::Error) -> Error {
    Error::failed(format!("cannot read: {}", reason(error)))
}

/// Reads a message; `None` at the end. One that is no JSON is null.
pub(super) fn read(input: &mut dyn BufRead) -> Result<Option<Value>, Error> {
    let mut length: Option<usize> = None;
    let mut header = Vec::new();
    let mut left = MOST_HEADER;
    loop {
        header.clear();
        let read = (&mut *input).take(left).read_until(b'\n', &mut header).map_err(|e| unread(&e))?;
        if read == 0 {
            return if length.is_none() && left == MOST_HEADER { Ok(None) } else { Err(unframed()) };
        }
        left -= read as u64;
        let line = String::from_utf8_lossy(&header);
        let line = line.trim_end_matches(['\r', '\n']);
        if !header.ends_with(b"\n") {
            return Err(unframed());
        }
        if line.is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            length = Some(value.trim().parse().map_err(|_| unframed())?);
        }
    }
    let length = length.ok_or_else(unframed)?;
    if length > MOST_BYTES {
        return Err(Error::failed(format!("a message of {length} bytes is too long")));
    }
    let mut bytes = vec![0; length];
    input.read_exact(&mut bytes).map_err(|e| unread(&e))?;
    Ok(Some(serde_json::from_slice(&bytes).unwrap_or(Value::Null)))
}

/// The client's end.
pub(super) struct Wire<'a> {
    output: &'a mut dyn Write,
    sequence: u64,
}

impl<'a> Wire<'a> {
    pub(super) fn new(output: &'a mut dyn Write) -> Self {
        Self { output, sequence: 0 }
    }

    /// Sends a message.
    pub(super) fn send(&mut self, mut message: Value) -> io::Result<()> {
        self.sequence += 1;
        message["seq"] = json!(self.sequence);
        let text = message.to_string();
        write!(self.output, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        self.output.flush()
    }

    /// Sends an event.
    pub(super) fn event(&mut self, name: &str, body: Value) -> io::Result<()> {
        self.send(json!({ "type": "event", "event": name, "body": body }))
    }
}
