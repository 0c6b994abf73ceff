//! `raystep course`

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use raystep_lab::course::files;

use crate::error::Error;
use crate::output::{Folder, TargetFolder};
use crate::terminal::print;

/// Write the exercises of a course on the paper's ray tracer into a new folder
///
/// Each exercise is a page, and a kernel with a hole that you complete; README.md says how. 'raystep grade' checks them. They
/// need nothing but this program, and no GPU.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep course my-course
  raystep grade my-course")]
pub(crate) struct CourseArgs {
    /// The new folder, or an empty one
    folder: PathBuf,
}

pub(crate) fn run(args: &CourseArgs) -> Result<(), Error> {
    let at = args.folder.display();
    if Folder::find(&args.folder)? == Folder::Full {
        return Err(Error::failed(format!(
            "{at} is not empty: choose another folder, so that nothing that you have written is lost"
        )));
    }
    TargetFolder::new(&args.folder, false)?.fill(&[], |folder| {
        for (name, text) in files() {
            if let Some((above, _)) = name.rsplit_once('/') {
                fs::create_dir_all(folder.place().join(above)).map_err(|e| Error::cannot_write(&args.folder, &e))?;
            }
            folder.write(name, |file| file.write_all(text.as_bytes()))?;
        }
        Ok(())
    })?;
    print(&format!("{at}/README.md is where it begins\n"))
}
