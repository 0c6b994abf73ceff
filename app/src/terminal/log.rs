//! Progress where stderr is no terminal but a file or a pipe, as in the log of a job: a line every few seconds.

use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::TermLike;

/// What progress draws on: keeps what is drawn, and writes it as a line when the next one is due.
#[derive(Debug)]
pub(super) struct Log<W> {
    every: Duration,
    lines: Mutex<Lines<W>>,
}

#[derive(Debug)]
struct Lines<W> {
    out: W,
    drawn: String,
    due: Instant,
}

impl<W: Write> Log<W> {
    /// The first line is due after this time, too: short work has none.
    pub(super) fn new(out: W, every: Duration) -> Self {
        Self { every, lines: Mutex::new(Lines { out, drawn: String::new(), due: Instant::now() + every }) }
    }
}

impl<W: Write + std::fmt::Debug + Send> TermLike for Log<W> {
    /// Lines are never wrapped.
    fn width(&self) -> u16 {
        u16::MAX
    }

    fn move_cursor_up(&self, _lines: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _lines: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _columns: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _columns: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        // The rest of a line is filled with spaces.
        self.lines.lock().unwrap_or_else(PoisonError::into_inner).drawn.push_str(text.trim_end());
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        let mut lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        let drawn = std::mem::take(&mut lines.drawn);
        if drawn.is_empty() || Instant::now() < lines.due {
            return Ok(());
        }
        lines.due = Instant::now() + self.every;
        // A log that cannot be written to does not end the work.
        let _ = writeln!(lines.out, "progress: {drawn}");
        Ok(())
    }
}
