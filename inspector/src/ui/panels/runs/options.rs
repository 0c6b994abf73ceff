//! The options of kept runs in words: what all share is said once, and of each run only what it has for itself.

use raystep_kernels::Choices;
use raystep_kernels::options::rows::{ROWS, Row, Value};
use raystep_lab::text::counted;

use crate::runs::Kept;
use crate::settings::Settings;

/// The options of some runs.
pub(super) struct Options {
    /// Those that all share.
    pub(super) shared: String,
    /// Those of each run that another run has not.
    pub(super) own: Vec<String>,
}

impl Options {
    /// `is_here`: whether a run is of the open scene.
    pub(super) fn of<'a>(runs: impl Iterator<Item = (&'a Kept, bool)>) -> Self {
        let parts = |(kept, is_here): (&Kept, bool)| parts(&kept.recipe.settings, kept.recipe.edits.len(), is_here);
        Self::new(&runs.map(parts).collect::<Vec<_>>())
    }

    fn new(runs: &[Vec<Part>]) -> Self {
        let Some(first) = runs.first() else { return Self { shared: String::new(), own: Vec::new() } };
        let of = |i: usize| runs.iter().filter_map(move |run| run.get(i));
        // What is usual goes without saying, unless it is another value in another run.
        let is_said = |i: usize| {
            let is_usual = |part: &Part| part.is_usual || part.text.is_empty();
            !of(i).all(is_usual)
        };
        let said = (0..first.len()).filter(|&i| is_said(i));
        let (shared, own): (Vec<usize>, Vec<usize>) = said.partition(|&i| of(i).all(|part| Some(part) == first.get(i)));
        let words = |run: &[Part], which: &[usize]| {
            let texts = which.iter().filter_map(|&i| run.get(i)).map(|part| part.text.as_str());
            texts.filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" · ")
        };
        Self { shared: words(first, &shared), own: runs.iter().map(|run| words(run, &own)).collect() }
    }
}

/// Options that are never left out, and told by their values alone: those of a run's name.
const NAMED: [&str; 3] = ["accelerator", "schedule", "numerics"];

/// An option in words.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    text: String,
    /// Whether it goes without saying, if all runs have it.
    is_usual: bool,
}

/// Every run has the same number of parts, in the same order.
fn parts(settings: &Settings, edits: usize, is_here: bool) -> Vec<Part> {
    let usual = Choices::stepped();
    let of_row = |row: &Row| {
        let value = if (row.applies)(&settings.choices) { row.get(&settings.choices) } else { Value::Nothing };
        let name = row.panel.map_or(row.name, |(name, _)| name);
        let text = match &value {
            Value::Nothing => String::new(),
            Value::Flag(true) => name.to_owned(),
            Value::Flag(false) => format!("no {name}"),
            value if NAMED.contains(&row.name) => value.to_string(),
            value => format!("{name} {value}"),
        };
        Part { text, is_usual: !NAMED.contains(&row.name) && value == row.get(&usual) }
    };
    let part = |text: String, is_usual: bool| Part { text, is_usual };
    let [width, height] = settings.size;
    let size = if settings.ray.is_some() { "1 ray".into() } else { format!("{width} × {height}") };
    let edits = if edits == 0 { "no edits".into() } else { counted(edits as u64, "edit") };
    let others = [
        part(settings.device.name().into(), false),
        part(size, !settings.traces_rays()),
        part(edits.clone(), edits == "no edits"),
        part(if is_here { "this scene" } else { "other scene" }.into(), is_here),
    ];
    ROWS.iter().map(of_row).chain(others).collect()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, GridSize, Numerics};

    use super::*;
    use crate::settings::DeviceKind;

    fn of(runs: &[(&Settings, usize, bool)]) -> (String, Vec<String>) {
        let runs: Vec<_> = runs.iter().map(|(settings, edits, is_here)| parts(settings, *edits, *is_here)).collect();
        let Options { shared, own } = Options::new(&runs);
        (shared, own)
    }

    #[test]
    fn what_all_runs_share_is_said_once() {
        let settings = Settings { size: [64, 48], device: DeviceKind::Cpu, ..Settings::default() };
        let (shared, own) = of(&[(&settings, 0, true)]);
        assert_eq!((shared.as_str(), &own[..]), ("grid · compact · robust · CPU, f32 · 64 × 48", &[String::new()][..]));
        let bvh = settings.clone().through(Accelerator::Bvh);
        let (shared, own) = of(&[(&settings, 0, true), (&bvh, 0, true)]);
        assert_eq!(shared, "compact · robust · CPU, f32 · 64 × 48");
        assert_eq!(own, ["grid", "bvh"], "what only a grid has is as usual");
        // What is not usual is told of the run that has it.
        let fine = Choices { grid: GridSize::Cells([5, 4, 3]), ..settings.choices };
        let fine = Settings { choices: fine, ..settings.clone() };
        let (shared, own) = of(&[(&fine, 0, true), (&bvh, 0, true), (&settings, 0, true)]);
        assert_eq!(shared, "compact · robust · CPU, f32 · 64 × 48");
        assert_eq!(own, ["grid · cells 5,4,3", "bvh", "grid · cells auto"]);
        let paper = Choices { numerics: Numerics::Paper, ..settings.choices };
        let paper = Settings { choices: paper, size: [32, 32], ..settings.clone() };
        let (shared, own) = of(&[(&settings, 0, true), (&paper, 2, false)]);
        assert_eq!(shared, "grid · compact · CPU, f32");
        assert_eq!(own[0], "robust · 64 × 48 · no edits · this scene");
        assert_eq!(own[1], "paper · 32 × 32 · 2 edits · other scene");
        assert_eq!(of(&[]), (String::new(), Vec::new()));
    }
}
