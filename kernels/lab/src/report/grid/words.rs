//! What the section on grid resolution says.

use crate::report::page::{Part, number};
use crate::report::words::{Compared, compared, with_interval};
use crate::report::work::Work;
use crate::tidy::Row;

pub(super) fn say(work: &Work<'_>, rows: &[Row], part: &mut Part) {
    let automatic = rows.iter().find(|r| r.get("is_automatic") == "true");
    let selected = rows.iter().find(|r| r.get("is_selected") == "true");
    if let (Some(automatic), Some(selected)) = (automatic, selected) {
        part.prose.push(resolution(automatic, selected));
    }
    if let Some(row) = rows.iter().max_by_key(|r| r.number("wrong_rays").unwrap_or(0.0) as u64) {
        part.prose.push(format!(
            "Wrong rays at any resolution and with any structure: at most {} of {} judged.",
            number("wrong_rays", row),
            number("judged_rays", row)
        ));
    }
    let is_compared = |row: &&Row| row.get("is_automatic") != "false" && row.get("accelerator") != "none";
    for row in rows.iter().filter(is_compared) {
        part.prose.push(pays_off(row));
    }
    part.prose.push(format!(
        "Times are {}; building is timed by the wall clock on the CPU. A structure pays off after the number of rays \
         for which its building time, beyond that of any plan, equals the time saved compared with testing every \
         triangle; its range is what the intervals of both allow.",
        work.clock_in_words()
    ));
}

fn resolution(automatic: &Row, selected: &Row) -> String {
    let cells = |row: &Row| ["cells_x", "cells_y", "cells_z"].map(|column| number(column, row)).join(" × ");
    let half = "Of all resolutions, the fastest on half of the rounds was";
    if selected.get("is_automatic") == "true" {
        return format!("{half} the automatic one, {}.", cells(automatic));
    }
    let ratio = with_interval("held_out_time_ratio", selected);
    let verdict = match compared("held_out_time_ratio", selected) {
        Compared::Faster => "faster",
        Compared::Slower => "slower, so that its lead was chance",
        Compared::NotDistinguishable => "not distinguishable",
        Compared::Unknown => "too few rounds to tell them apart",
    };
    format!(
        "{half} {} cells. On the other {} rounds it takes {ratio} times as long as the automatic resolution, {}: {verdict}.",
        cells(selected),
        number("held_out_rounds", selected),
        cells(automatic)
    )
}

fn pays_off(row: &Row) -> String {
    let name = match row.get("accelerator") {
        "grid" => "automatic grid",
        _ => "BVH",
    };
    match row.get("paid_off_rays") {
        "" => format!("After how many rays building the {name} pays off is not determined."),
        _ => format!(
            "Building the {name} pays off after {} rays (between {} and {}).",
            number("paid_off_rays", row),
            number("paid_off_rays_low", row),
            number("paid_off_rays_high", row)
        ),
    }
}
