//! What scenes cost that get harder in one way, and where this scene stands among them.

use super::page::{Part, number};
use super::record::RUN_COLUMNS;
use super::work::Work;
use crate::Error;
use crate::html::escaped;
use crate::stiff;
use crate::tidy::{Row, Table};

pub(super) use crate::stiff::COLUMNS;

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let start = work.stiff.ok_or(Error::NothingBuilt)?;
    let cost = start.cost(work.meter, work.reporter)?;
    // The families are the same for all scenes: their rows are written once.
    if table.rows.is_empty() {
        table.rows.extend(cost.rows.rows.iter().cloned());
        record(work, &cost.rows.rows, &cost.runs.rows);
        part.notes.extend(cost.notes.iter().cloned());
    }
    work.stage("stiff");
    let subject = work.subject;
    let mut own = start.scene(&subject.scene.name, &subject.scene, work.meter, work.reporter)?;
    for row in &mut own.rows.rows {
        *row = row.clone().set("scene", &*subject.scene.name).set("scene_hash", subject.hash);
    }
    let own_rows = &own.rows.rows;
    record(work, own_rows, &own.runs.rows);
    part.notes.extend(own.notes);
    let rows = &cost.rows.rows;
    for row in own_rows.iter().filter(|row| row.get("rule").is_empty() && row.get("accelerator") != "none") {
        let structure = escaped(row.get("accelerator"));
        part.prose.push(format!("Stiffness number of this scene, {structure}: {}.", number("stiffness", row)));
    }
    part.prose.push(escaped(&stiff::correlation_text(rows)));
    let numbers = stiff::own_numbers(own_rows);
    part.figure("stiffness", stiff::over_stiffness(rows, &numbers), "Time of a ray over the stiffness number.");
    for family in stiff::parts(rows, &numbers) {
        part.prose.extend(family.sentences.iter().map(|sentence| escaped(sentence)));
        let caption = format!("{}: {}. {}", family.family.title, family.family.what, stiff::CAPTION);
        part.figure(family.family.name, family.curves, caption);
    }
    part.table(own_rows);
    table.rows.extend(own.rows.rows);
    Ok(part)
}

/// Adds timed runs to those of the report, with the keys of their rows.
fn record(work: &Work<'_>, rows: &[Row], runs: &[Row]) {
    let keys = ["run_id", "configuration"];
    let complete = |run: &Row| {
        let row = rows.iter().find(|row| row.is(&keys.map(|key| (key, run.get(key)))))?;
        Some(Row::new(RUN_COLUMNS).like(row).like(run).set("section", work.section))
    };
    work.record.add_runs(runs.iter().filter_map(complete));
}
