//! `--rays-file` and `--strata` of `report` and `bench`: rays of another program, read whole.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use raystep_lab::rays::file::{RaysError, RaysFile, RaysFormat, read_all};

use crate::commands::extension;
use crate::error::Error;

/// Most rays that are held in memory.
const MOST_RAYS: u64 = 1 << 26;

/// Reads them.
pub(crate) fn read(path: &Path, strata: Option<&Path>) -> Result<RaysFile, Error> {
    let format = match extension(path).as_str() {
        "npy" => RaysFormat::Npy,
        "f32" => RaysFormat::F32,
        _ => {
            let at = path.display();
            return Err(Error::usage(format!("--rays-file {at}: expected a name that ends in .npy or .f32")));
        }
    };
    let open = |option: &str, path: &Path| {
        let cannot = |e| Error::failed(format!("{option} {}: {}", path.display(), crate::error::reason(&e)));
        File::open(path).map(BufReader::new).map_err(cannot)
    };
    let rays = open("--rays-file", path)?;
    let mut groups = strata.map(|path| open("--strata", path)).transpose()?;
    let of_strata = strata.unwrap_or(path).display();
    let cannot = |error| match error {
        RaysError::Strata(error) => Error::failed(format!("--strata {of_strata}: {error}")),
        error => Error::failed(format!("--rays-file {}: {error}", path.display())),
    };
    let groups = groups.as_mut().map(|groups| groups as &mut dyn Read);
    let file = read_all(rays, format, groups, MOST_RAYS).map_err(cannot)?;
    match file.rays.is_empty() {
        true => Err(Error::failed(format!("--rays-file {}: it has no rays", path.display()))),
        false => Ok(file),
    }
}
