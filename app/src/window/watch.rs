//! Watches a kernel's file: whenever it is written, it is read again.

use std::path::{Path, PathBuf};
use std::sync::Weak;
use std::time::{Duration, SystemTime};

use raystep_inspector::ui::host::HostEvent;

use crate::session_file;

/// Between two looks at a file. An editor may write in several steps: what it has written for so long is read.
const PAUSE: Duration = Duration::from_millis(60);

/// When a file was written, and its size; `None` if it is not there, as while an editor replaces it.
type Stamp = Option<(SystemTime, u64)>;

fn stamp(path: &Path) -> Stamp {
    let about = path.metadata().ok()?;
    Some((about.modified().ok()?, about.len()))
}

/// What a file has been through.
struct Watched {
    /// When it was read.
    read: Stamp,
    /// When it was looked at last.
    seen: Stamp,
}

impl Watched {
    /// Whether it has been written since it was read, and not since it was looked at last.
    fn is_new(&mut self, now: Stamp) -> bool {
        let is_stable = std::mem::replace(&mut self.seen, now) == now;
        let is_new = now.is_some() && is_stable && now != self.read;
        if is_new {
            self.read = now;
        }
        is_new
    }
}

/// Watches a file in a thread, as long as the window is there. The thread touches no device.
pub(super) fn begin(path: PathBuf, window: Weak<()>, tell: impl Fn(HostEvent) + Send + 'static) {
    let first = stamp(&path);
    let mut watched = Watched { read: first, seen: first };
    std::thread::spawn(move || {
        while window.strong_count() > 0 {
            std::thread::sleep(PAUSE);
            if watched.is_new(stamp(&path)) {
                tell(match session_file::bytes(&path) {
                    Ok(bytes) => HostEvent::Read { path: path.to_string_lossy().into_owned(), bytes },
                    Err(error) => HostEvent::Failed(error.message().to_owned()),
                });
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_new_once_after_each_time_it_was_written_and_no_longer_changes() {
        let at = |seconds, bytes| Some((SystemTime::UNIX_EPOCH + Duration::from_secs(seconds), bytes));
        let mut watched = Watched { read: at(1, 10), seen: at(1, 10) };
        assert!(!watched.is_new(at(1, 10)));
        // Emptied, then written in two steps, then replaced.
        let steps = [at(2, 0), at(2, 5), at(2, 12), at(2, 12), at(2, 12), None, at(3, 12), at(3, 12)];
        let news: Vec<bool> = steps.into_iter().map(|now| watched.is_new(now)).collect();
        assert_eq!(news, [false, false, false, true, false, false, false, true]);
    }
}
