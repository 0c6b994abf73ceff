//! Files that persist on a desktop.

use std::path::PathBuf;
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use crate::error::reason;
use crate::output::{Target, write};

/// Waits for a dialog, on its own thread.
pub(super) fn wait<T>(dialog: impl Future<Output = T>) -> T {
    let mut dialog = pin!(dialog);
    loop {
        if let Poll::Ready(value) = dialog.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return value;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// The file of saved sessions, if the system has a place for it.
fn place() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "raystep").map(|folders| folders.data_dir().join("inspector.json"))
}

/// The saved session; empty if it cannot be read.
pub(super) fn recall() -> Option<Vec<u8>> {
    crate::scene_file::read_file(&place()?, raystep_inspector::saved::MOST_BYTES as u64).ok()
}

/// Saves the session. If that fails, the next window starts with defaults; the error says why.
pub(super) fn remember(saved: &str) -> Result<(), String> {
    let Some(place) = place() else { return Ok(()) };
    let folder = place.parent().unwrap_or(&place);
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {}", folder.display(), reason(&e)))?;
    let target = Target::new(&place).map_err(|e| e.message().to_owned())?;
    write(vec![(target, saved.as_bytes().to_vec())]).map_err(|e| e.message().to_owned())
}

/// An unused path for a file of this name, in the current folder.
pub(super) fn proposed(name: &str) -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    let (stem, extension) = name.split_once('.').map_or((name, ""), |(stem, _)| (stem, &name[stem.len()..]));
    let numbered = (2..1000).map(|n| format!("{stem}-{n}{extension}"));
    let free = std::iter::once(name.to_owned()).chain(numbered).map(|name| folder.join(name));
    let path = free.into_iter().find(|path| name.is_empty() || !path.exists()).unwrap_or_else(|| folder.join(name));
    path.to_string_lossy().into_owned()
}
