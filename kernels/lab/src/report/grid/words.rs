//! What the section on grid resolution says.

use crate::report::page::{Part, number};
use crate::report::words::{compared, with_interval};
use crate::report::work::Work;
use crate::statistics::Compared;
use crate::tidy::Row;

pub(super) fn say(work: &Work<'_>, rows: &[Row], part: &mut Part) {
    let automatic = rows.iter().find(|r| r.get("is_automatic") == "true");
    let selected = rows.iter().find(|r| r.get("is_selected") == "true");
    if let (Some(automatic), Some(selected)) = (automatic, selected) {
        part.prose.push(resolution(automatic, selected));
    }
    let none = rows.iter().find(|r| r.get("accelerator") == "none");
    let count = |row: &Row, column: &str| row.number(column).unwrap_or(0.0) as u64;
    if let Some(row) = rows.iter().max_by_key(|r| (count(r, "wrong_rays"), count(r, "judged_rays"))) {
        let judged = number("judged_rays", row);
        // Testing every triangle may take too long for all of them.
        let fewer = none.filter(|none| none.get("judged_rays") != row.get("judged_rays"));
        let fewer =
            fewer.map_or(String::new(), |none| format!("; {} without a structure", number("judged_rays", none)));
        part.prose.push(match row.get("wrong_rays") {
            "0" => format!("No ray was wrong with any resolution or structure ({judged} judged{fewer})."),
            _ => {
                let wrong = number("wrong_rays", row);
                format!("With any resolution or structure, at most {wrong} of {judged} judged rays were wrong.")
            }
        });
    }
    let is_named = |row: &&Row| row.get("is_automatic") != "false" && row.get("accelerator") != "none";
    for row in rows.iter().filter(is_named) {
        let is_compared =
            none.is_some_and(|none| !none.get("median_ns").is_empty() && none.get("rays") == row.get("rays"));
        part.prose.push(pays_off(row, is_compared));
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
        Compared::Slower => "slower, so that its lead was chance",
        other => other.words(),
    };
    format!(
        "{half} {} cells. On the other {} rounds it takes {ratio} times as long as the automatic resolution, {}: {verdict}.",
        cells(selected),
        number("held_out_rounds", selected),
        cells(automatic)
    )
}

/// `is_compared` if testing every triangle was timed with the same rays; otherwise a note says why not.
fn pays_off(row: &Row, is_compared: bool) -> String {
    let name = match row.get("accelerator") {
        "grid" => "automatic grid",
        _ => "BVH",
    };
    let unknown = format!("The number of rays after which the {name} pays off is unknown");
    match row.get("paid_off_rays") {
        "" if is_compared => format!("{unknown}: the intervals allow that it saves no time."),
        "" => format!("{unknown} (see notes)."),
        _ => format!(
            "Building the {name} pays off after {} rays (between {} and {}).",
            number("paid_off_rays", row),
            number("paid_off_rays_low", row),
            number("paid_off_rays_high", row)
        ),
    }
}
