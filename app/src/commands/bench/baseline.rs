//! An earlier benchmark to compare with.

use std::path::{Path, PathBuf};

use raystep_lab::bench::{SummaryRow, read_summary};

use super::output::SUMMARY;
use crate::error::Error;
use crate::scene_file::read_file;

/// Most bytes of a summary: some millions of configurations.
const MOST_BYTES: u64 = 1 << 30;

/// What was measured before.
pub(super) struct Baseline {
    folder: PathBuf,
    rows: Vec<SummaryRow>,
}

impl Baseline {
    /// Reads the summary in a benchmark's folder.
    pub(super) fn read(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(SUMMARY);
        let cannot = |reason: String| {
            let at = path.display();
            Error::failed(format!("--baseline: {at}: {reason}; a folder that 'raystep bench' wrote is wanted"))
        };
        let bytes = read_file(&path, MOST_BYTES).map_err(|e| cannot(e.to_string()))?;
        let rows = read_summary(bytes.as_slice()).map_err(|e| cannot(e.to_string()))?;
        Ok(Self { folder: folder.to_owned(), rows })
    }

    /// Fills in the rows' ratios; what is to be said of those that have none, or not a fair one.
    pub(super) fn compare(&self, rows: &mut [SummaryRow]) -> Vec<String> {
        let at = self.folder.display();
        let mut notes = Vec::new();
        let mut note = |text: String| {
            if !notes.contains(&text) {
                notes.push(text);
            }
        };
        for row in rows.iter_mut() {
            let name = name(row);
            let Some(then) = row.in_baseline(&self.rows) else {
                note(format!("{at} has no match for {name}"));
                continue;
            };
            row.baseline_ratio = row.ratio_to(then);
            if row.baseline_ratio.is_none() {
                note(format!("{at} has no time of the same clock for {name}"));
            }
            if then.device != row.device {
                note(format!("{at} was measured on {}, and this is {}", then.device, row.device));
            }
            if then.scene_hash != row.scene_hash {
                note(format!("{} has changed since {at} was measured", row.scene));
            }
            if then.rays != row.rays {
                note(format!("{at} has {} rays for {name}, where now there are {}", then.rays, row.rays));
            }
        }
        let is_gone = |then: &&SummaryRow| !rows.iter().any(|row| row.is_same_configuration(then));
        for then in self.rows.iter().filter(is_gone) {
            note(format!("{at} also has {}, which was not measured now", name(then)));
        }
        notes
    }
}

/// A configuration in words.
fn name(row: &SummaryRow) -> String {
    let SummaryRow { scene, width_px, height_px, rays_kind, accelerator, schedule, numerics, tuning, .. } = row;
    format!("{scene} {width_px}x{height_px} {rays_kind}, {accelerator} {schedule} {numerics} {tuning}")
}
