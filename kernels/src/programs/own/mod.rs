//! Programs of users: a folder with `program.toml`, which says what the program consists of, and WGSL files.

mod kernel;
mod manifest;
mod plan;
mod reader;
mod scene;
mod start;
mod steps;
mod streams;
mod tables;

use std::sync::{Arc, Mutex, PoisonError};

use crate::options::features::Features;
use crate::options::folder::Folder;
use crate::program::Program;
use crate::program::schedule::Schedule;
use crate::shader::Mistake;
use crate::tables::elements::{Elements, Size};
use crate::tables::stream::{Stream, StreamData};
pub use manifest::{Colours, Way};
pub(super) use plan::plan;
pub use scene::OfScene;
pub use start::array;

/// A user's program.
pub struct Own {
    /// The program.
    pub program: &'static Program,
    /// The order of its kernels.
    pub schedule: Schedule,
    /// The sizes of its sets that are known before it runs.
    pub sizes: Vec<(&'static Elements, Size)>,
    /// What its streams begin with, if their elements begin with different values.
    pub inputs: Vec<StreamData>,
    /// What its result is.
    pub result: Option<OwnResult>,
    /// What it reads of a scene, if it does.
    pub scene: Option<OfScene>,
    /// Its sets that have as many elements as one of ours for the scene, and that one's name.
    scene_sets: Vec<(&'static Elements, &'static str)>,
}

/// What the result of a program is, and how it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnResult {
    /// The stream.
    pub stream: Stream,
    /// The layer; `None` for a colour of three layers.
    pub layer: Option<usize>,
    /// How it is shown.
    pub way: Way,
    /// The numbers that have the first colour and the last; the smallest and the largest if it is not given.
    pub range: Option<[f64; 2]>,
    /// Its colours.
    pub colours: Colours,
}

/// A program that was read: its files, and the options that its kernels were compiled with.
type Known = (Arc<Folder>, Option<Features>, Arc<Own>);

/// Programs that were read before: a program lives as long as the process, so the same files are read once.
static READ: Mutex<Vec<Known>> = Mutex::new(Vec::new());

/// Most programs to remember.
const MOST_READ: usize = 16;

/// The program of a folder.
///
/// # Errors
/// If a file is wrong: with its place.
pub fn read(folder: &Arc<Folder>) -> Result<Arc<Own>, Box<Mistake>> {
    compiled(folder, None)
}

/// The same for a scene, for which its kernels are compiled with these options.
fn compiled(folder: &Arc<Folder>, features: Option<Features>) -> Result<Arc<Own>, Box<Mistake>> {
    let remembered = || READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((.., own)) = remembered().iter().find(|(other, with, _)| other == folder && *with == features) {
        return Ok(own.clone());
    }
    let own = Arc::new(tables::read(folder, features).map_err(Box::new)?);
    let mut all = remembered();
    if all.len() >= MOST_READ {
        all.remove(0);
    }
    all.push((folder.clone(), features, own.clone()));
    Ok(own)
}

#[cfg(test)]
mod tests;
