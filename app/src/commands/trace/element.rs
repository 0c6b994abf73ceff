//! The history of an element of a program of one's own.

use std::path::Path;

use raystep_kernels::Options;
use raystep_kernels::plan::Plan;
use raystep_lab::element_history::{ElementPass, element_history};
use raystep_lab::text::aligned;

use super::{Format, Pixel};
use crate::args::{QuietArgs, ReadArgs, RunArgs, SightArgs, ViewArgs};
use crate::commands::json_text;
use crate::device;
use crate::error::Error;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{Progress, print};

pub(super) fn run(
    path: &Path,
    pixel: Pixel,
    format: Format,
    view: &ViewArgs,
    run: &RunArgs,
    read: &ReadArgs,
    quiet: &QuietArgs,
) -> Result<(), Error> {
    let progress = Progress::new(quiet.quiet);
    let sight = SightArgs { size: view.size, camera: view.camera.clone(), read: *read };
    let (SceneFile { folder, scene, .. }, rays) = scene_file::read_program(path, &sight)?;
    let chosen = device::choose(&run.device.for_users())?;
    let options = Options { folder, ..Options::new(rays) };
    let planned = chosen.wait(Plan::on(&scene, &options, &chosen.device))?;
    let told = |passes: usize| {
        progress.stage(&format!("following the element, pass {passes}"));
        true
    };
    let history = element_history(&chosen.device, planned, &options, [pixel.x, pixel.y], told);
    let history = chosen.wait(history).map_err(Error::failed)?;
    progress.finish();
    print(&match format {
        Format::Json => json_text(&history)?,
        Format::Table => table(&history),
        Format::Csv => csv_of(&history)?,
    })
}

/// A line for each change or reason: the first of a pass has its number.
fn table(history: &[ElementPass]) -> String {
    let mut rows = vec![["pass", "kernel", "what it has changed", "why"].map(str::to_owned)];
    for pass in history {
        let changes: Vec<String> = changes(pass);
        let why: Vec<&String> = pass.why.iter().chain(&pass.noted).collect();
        for line in 0..changes.len().max(why.len()).max(1) {
            let of = |text: String| if line == 0 { text } else { String::new() };
            let change = changes.get(line).cloned().unwrap_or_else(|| of("nothing".into()));
            let why = why.get(line).map_or_else(String::new, |why| (*why).clone());
            rows.push([of(pass.pass.to_string()), of(pass.kernel.to_owned()), change, why]);
        }
    }
    aligned(&rows, 4).iter().map(|line| format!("{}\n", line.trim_end())).collect()
}

fn changes(pass: &ElementPass) -> Vec<String> {
    let text = |change: &raystep_lab::element_history::Change| {
        format!("{}.{} {} > {}", change.stream, change.layer, change.before, change.after)
    };
    pass.changes.iter().map(text).collect()
}

/// A row for each component that a pass has changed.
fn csv_of(history: &[ElementPass]) -> Result<String, Error> {
    let failed = |e: &dyn std::fmt::Display| Error::failed(format!("cannot write as CSV: {e}"));
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(["pass", "kernel", "stream", "layer", "before", "after"]).map_err(|e| failed(&e))?;
    for pass in history {
        let number = pass.pass.to_string();
        for change in &pass.changes {
            let row = [&number, pass.kernel, change.stream, change.layer, &change.before, &change.after];
            csv.write_record(row).map_err(|e| failed(&e))?;
        }
    }
    let bytes = csv.into_inner().map_err(|e| failed(&e))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
