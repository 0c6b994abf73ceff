//! `--rays-file` and `--strata`: rays of another program, read whole.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use clap::Args;
use raystep_lab::rays::file::{RaysError, RaysFile, RaysFormat, read_all};

use crate::commands::extension;
use crate::error::Error;

/// Rays from a file.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Rays")]
pub(crate) struct RaysFileArgs {
    /// Rays instead of the camera's: .npy, float32, N×6 (origin, direction) or N×8 (origin, t_min, direction, t_max), or
    /// .f32, see 'raystep cast --help'
    #[arg(long, value_name = "F")]
    pub(crate) rays_file: Option<PathBuf>,
    /// Groups of those rays, judged separately: .npy, N integers
    #[arg(long, value_name = "F", requires = "rays_file")]
    pub(crate) strata: Option<PathBuf>,
}

/// Most rays that are held in memory.
const MOST_RAYS: u64 = 1 << 26;

impl RaysFileArgs {
    /// Reads them.
    pub(crate) fn read(&self) -> Result<Option<RaysFile>, Error> {
        let Some(path) = &self.rays_file else { return Ok(None) };
        let format = match extension(path).as_str() {
            "npy" => RaysFormat::Npy,
            "f32" => RaysFormat::F32,
            _ => {
                let at = path.display();
                return Err(Error::usage(format!("--rays-file {at}: expected a name that ends in .npy or .f32")));
            }
        };
        let open = |option: &str, path: &Path| {
            let cannot = |e| Error::failed(format!("{option} {}: {}", path.display(), crate::output::reason(&e)));
            File::open(path).map(BufReader::new).map_err(cannot)
        };
        let rays = open("--rays-file", path)?;
        let mut strata = self.strata.as_deref().map(|path| open("--strata", path)).transpose()?;
        let of_strata = self.strata.as_ref().unwrap_or(path).display();
        let cannot = |error| match error {
            RaysError::Strata(error) => Error::failed(format!("--strata {of_strata}: {error}")),
            error => Error::failed(format!("--rays-file {}: {error}", path.display())),
        };
        let strata = strata.as_mut().map(|strata| strata as &mut dyn Read);
        let file = read_all(rays, format, strata, MOST_RAYS).map_err(cannot)?;
        match file.rays.is_empty() {
            true => Err(Error::failed(format!("--rays-file {}: it has no rays", path.display()))),
            false => Ok(Some(file)),
        }
    }
}
