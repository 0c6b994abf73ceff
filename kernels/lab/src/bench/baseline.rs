//! An earlier benchmark to compare with.

use super::SummaryRow;

/// The results of an earlier benchmark.
pub struct Baseline {
    /// Its folder, for display.
    pub folder: String,
    /// Its summary.
    pub rows: Vec<SummaryRow>,
}

impl Baseline {
    /// Fills in the rows' ratios. Returns notes on rows without a ratio, or whose ratio is not a fair comparison.
    pub fn compare(&self, rows: &mut [SummaryRow]) -> Vec<String> {
        let at = &self.folder;
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
                note(format!("{at} has no time by the same clock for {name}"));
            }
            if then.device != row.device {
                note(format!("{at} was measured on {}, and this is {}", then.device, row.device));
            }
            if then.scene_hash != row.scene_hash {
                note(format!("{} has changed since {at} was measured", row.scene));
            }
            if then.rays != row.rays {
                note(format!("{at} has {} rays for {name}, but now there are {}", then.rays, row.rays));
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
