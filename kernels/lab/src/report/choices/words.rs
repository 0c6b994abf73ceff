//! The answer in words.

use super::super::page::{Part, number};
use super::super::words::{Compared, compared};
use super::super::work::Work;
use super::MOST_WRONG;
use crate::html::escaped;
use crate::human::cell;
use crate::tidy::Row;

/// A choice in words.
pub(super) fn name(row: &Row) -> String {
    if !row.get("method").is_empty() {
        return escaped(row.get("method"));
    }
    format!("{}, {}, {}", row.get("accelerator"), row.get("schedule"), row.get("numerics"))
}

/// Choices in words, those that differ only in their schedules together.
fn listed(rows: &[&Row]) -> String {
    let mut groups: Vec<(&Row, Vec<&str>)> = Vec::new();
    for &row in rows {
        let is_like =
            |other: &Row| ["accelerator", "numerics"].iter().all(|column| other.get(column) == row.get(column));
        match groups.iter_mut().find(|(first, _)| is_like(first)) {
            Some((_, schedules)) => schedules.push(row.get("schedule")),
            None => groups.push((row, vec![row.get("schedule")])),
        }
    }
    let names = groups.iter().map(|(first, schedules)| {
        format!("{}, {}, {}", first.get("accelerator"), schedules.join("/"), first.get("numerics"))
    });
    names.collect::<Vec<_>>().join("; ")
}

/// Where it was measured, in words.
fn place(work: &Work<'_>) -> String {
    match work.machine().gpu() {
        Some(_) => work.machine().name(),
        None => {
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            format!("CPU, {}", crate::text::counted(cores, "core"))
        }
    }
}

/// Adds the answer. `outside` says how many rays start outside the grid, if any: all, most or some.
pub(super) fn say(work: &Work<'_>, rows: &[Row], outside: Option<&str>, part: &mut Part) {
    let scene = format!("{}, {}", escaped(&work.subject.scene.name), escaped(&place(work)));
    part.lead.push(answer(&scene, rows, outside));
}

fn is_accurate(row: &Row) -> bool {
    row.get("is_accurate") == "true"
}

/// The choice to take, what is as fast, and what is faster but wrong.
fn answer(scene: &str, rows: &[Row], outside: Option<&str>) -> String {
    let Some(fastest) = rows.iter().find(|r| r.get("is_fastest") == "true") else {
        return format!("{scene}: no choice could be shown to be accurate.{}{}", grid_misses(outside), limit(rows));
    };
    // Few of these rays meet edges, where the paper's rules lose some: the fastest robust choice is the one to take.
    let robust = quickest(rows, &[("numerics", "robust"), ("is_accurate", "true")]);
    let best = robust.filter(|_| fastest.get("numerics") == "paper").unwrap_or(fastest);
    let is_fastest = std::ptr::eq(best, fastest);
    let is_slower = !is_fastest && compared("time_ratio", best) == Compared::Slower;
    let mut text = format!(
        "<strong>{scene}: {}{}: {} per ray, {}.</strong>",
        name(best),
        if is_fastest { " is fastest" } else { "" },
        cell("ns_per_ray", best.get("ns_per_ray")),
        wrong(best),
    );
    if !is_fastest {
        text += &papers_instead(fastest, best);
    }
    let is_other = |r: &&Row| !std::ptr::eq(*r, fastest) && !std::ptr::eq(*r, best) && r.get("method").is_empty();
    let others = || rows.iter().filter(is_other);
    let accurate = |are: &[Compared]| {
        let those = others().filter(|r| is_accurate(r) && are.contains(&compared("time_ratio", r)));
        those.collect::<Vec<&Row>>()
    };
    let alike = accurate(&[Compared::NotDistinguishable, Compared::Unknown]);
    // The fastest was found in other rounds than those that are compared: there, another may be faster.
    let sooner = accurate(&[Compared::Faster]);
    if !sooner.is_empty() {
        text += &format!(" Faster still in the rounds that are compared: {}.", listed(&sooner));
    }
    text += &match (alike.is_empty(), is_fastest, is_slower) {
        (true, ..) if !sooner.is_empty() => String::new(),
        (true, _, true) => " Every other accurate choice is slower than that.".to_owned(),
        (true, _, false) => " Every other accurate choice is slower.".to_owned(),
        (false, true, _) => format!(" Not distinguishable in time: {}.", listed(&alike)),
        (false, false, true) => format!(" Not distinguishable from that in time: {}.", listed(&alike)),
        (false, false, false) => format!(" Not distinguishable either: {}.", listed(&alike)),
    };
    // Ratios are to the fastest, which need not be the best: there, intervals that lie apart tell.
    let is_faster = |r: &Row| {
        let ends = r.number("ns_per_ray_high").zip(best.number("ns_per_ray_low"));
        compared("time_ratio", r) == Compared::Faster || ends.is_some_and(|(high, low)| high < low)
    };
    let faster: Vec<&Row> = others().filter(|r| !is_accurate(r) && is_faster(r)).collect();
    if let Some(worst) = faster.iter().max_by_key(|r| r.number("wrong_rays").unwrap_or(0.0) as u64) {
        text += &format!(
            " Faster, but not accurate: {} ({}{} of {} wrong).",
            listed(&faster),
            if faster.len() > 1 { "up to " } else { "" },
            number("wrong_rays", worst),
            number("judged_rays", worst),
        );
    }
    if is_fastest {
        text += &papers(rows, fastest);
    }
    text + &grid_misses(outside) + &limit(rows)
}

/// "0 of 36,864 rays wrong (95%: at most 81 per million)".
fn wrong(row: &Row) -> String {
    let judged = number("judged_rays", row);
    let of = match row.number("judged_rays").zip(row.number("rays")) {
        Some((some, all)) if some < all => format!("{judged} judged rays (a sample of {})", number("rays", row)),
        _ => format!("{judged} rays"),
    };
    let high = cell("wrong_per_million_high", row.get("wrong_per_million_high"));
    format!("{} of {of} wrong (95%: at most {high} per million)", number("wrong_rays", row))
}

/// What "accurate" means here.
fn limit(rows: &[Row]) -> String {
    let Some(row) = rows.iter().find(|r| r.is(&[("method", ""), ("at_bound", "0")])).or(rows.first()) else {
        return String::new();
    };
    let is_raised = row.number("most_wrong_per_million").is_some_and(|most| most > MOST_WRONG);
    let why = match is_raised {
        true => format!("; {} judged rays cannot show less", number("judged_rays", row)),
        false => String::new(),
    };
    let most = number("most_wrong_per_million", row);
    format!(" Accurate: shown to be wrong for at most {most} rays per million (95%{why}).")
}

/// Why the paper's rules are wrong so often with a grid, if that is the reason.
fn grid_misses(outside: Option<&str>) -> String {
    outside.map_or(String::new(), |share| {
        format!(" The paper's rules with a grid miss rays that start outside it, as {share} of these do.")
    })
}

/// The row with the shortest median time among those with these fields.
pub(super) fn quickest<'a>(rows: &'a [Row], wanted: &[(&str, &str)]) -> Option<&'a Row> {
    let ns = |row: &Row| row.number("median_ns").unwrap_or(f64::INFINITY);
    let of = rows.iter().filter(|row| row.is(wanted) && row.number("median_ns").is_some());
    of.min_by(|a, b| ns(a).total_cmp(&ns(b)))
}

/// What the fastest choice, by the paper's rules, gains over the best robust one, and why it is not the one to take.
fn papers_instead(fastest: &Row, best: &Row) -> String {
    let name = format!("{}, {}", fastest.get("accelerator"), fastest.get("schedule"));
    let ns = cell("ns_per_ray", fastest.get("ns_per_ray"));
    let time = match compared("time_ratio", best) {
        Compared::Slower => format!("({name}) take {ns}"),
        Compared::Unknown => format!("({name}) take {ns}, in too few runs to compare,"),
        Compared::Faster => format!("({name}) take {ns}, longer in the rounds that are compared,"),
        Compared::NotDistinguishable => format!("({name}; {ns}) are not distinguishable in time"),
    };
    let wrong = match fastest.get("wrong_rays") {
        "0" => "none of these rays wrong either".to_owned(),
        _ => format!("{} of {} wrong", number("wrong_rays", fastest), number("judged_rays", fastest)),
    };
    format!(" The paper's rules {time} and got {wrong}, but can lose rays at edges.")
}

/// What the paper's rules gain and lose with the structure and schedule of the fastest choice, which is robust.
fn papers(rows: &[Row], fastest: &Row) -> String {
    let same =
        [("accelerator", fastest.get("accelerator")), ("schedule", fastest.get("schedule")), ("numerics", "paper")];
    let Some(paper) = rows.iter().find(|r| r.is(&same)).filter(|_| fastest.get("numerics") == "robust") else {
        return String::new();
    };
    let errors = match paper.get("wrong_rays") {
        "0" => "none wrong either".to_owned(),
        _ => format!("{} of {} wrong", number("wrong_rays", paper), number("judged_rays", paper)),
    };
    let ratio = cell("time_ratio", paper.get("time_ratio"));
    let gain = match compared("time_ratio", paper) {
        Compared::Faster => format!("take {ratio} of the time here"),
        Compared::NotDistinguishable => "are no faster here".to_owned(),
        Compared::Slower => format!("take {ratio} times as long here"),
        Compared::Unknown => "were not timed often enough to compare".to_owned(),
    };
    format!(" The paper's rules {gain}: {errors}.")
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::*;
    use crate::html::spans;

    /// A choice with its time per ray and the interval of its ratio to the fastest, if it is not the fastest itself.
    fn row(name: [&str; 3], ns: f64, ratio: Option<[f64; 2]>, wrong: u64) -> Row {
        let [accelerator, schedule, numerics] = name;
        Row::new(COLUMNS)
            .set("accelerator", accelerator)
            .set("schedule", schedule)
            .set("numerics", numerics)
            .set("rays", 36_864_u64)
            .set("judged_rays", 36_864_u64)
            .set("at_bound", 0_u64)
            .set("median_ns", 36_864.0 * ns)
            .set("ns_per_ray", ns)
            .set("ns_per_ray_low", 0.9 * ns)
            .set("ns_per_ray_high", 1.1 * ns)
            .set("time_ratio_low", ratio.map(|[low, _]| low))
            .set("time_ratio_high", ratio.map(|[_, high]| high))
            .set("is_fastest", ratio.is_none())
            .set("wrong_rays", wrong)
            .set("wrong_per_million_high", if wrong == 0 { 81.26 } else { 3_000.0 })
            .set("most_wrong_per_million", MOST_WRONG)
            .set("is_accurate", wrong == 0)
    }

    const GRID: [&str; 3] = ["grid", "compact", "robust"];
    const BVH: [&str; 3] = ["bvh", "fused", "robust"];
    const PAPER: [&str; 3] = ["bvh", "fused", "paper"];

    /// The answer, and its emphasised begin.
    fn told(rows: &[Row], outside: Option<&str>) -> (String, String) {
        let spans = spans(&answer("box, CPU", rows, outside));
        let first = spans.first().filter(|(_, is_strong)| *is_strong).map(|(text, _)| text.clone());
        (spans.into_iter().map(|(text, _)| text).collect(), first.unwrap_or_default())
    }

    #[test]
    fn a_robust_choice_is_named_first_even_if_the_papers_rules_are_faster() {
        let slow = row(GRID, 700.0, Some([5.0, 8.0]), 0);
        let rows = [row(PAPER, 107.0, None, 0), row(BVH, 162.0, Some([1.3, 1.8]), 0), slow];
        let (all, first) = told(&rows, None);
        assert_eq!(
            first,
            "box, CPU: bvh, fused, robust: 162 ns per ray, 0 of 36,864 rays wrong (95%: at most 81 per million)."
        );
        let rest = " The paper's rules (bvh, fused) take 107 ns and got none of these rays wrong either, but can lose \
                    rays at edges. Every other accurate choice is slower than that. Accurate: shown to be wrong for at \
                    most 100 rays per million (95%).";
        assert_eq!(all, first + rest);
        let alike = row(GRID, 120.0, Some([0.9, 1.3]), 0);
        let rows = [row(PAPER, 107.0, None, 0), row(BVH, 110.0, Some([0.9, 1.2]), 0), alike];
        let (all, _) = told(&rows, None);
        assert!(all.contains(" (bvh, fused; 107 ns) are not distinguishable in time and got none"), "{all}");
        assert!(all.contains(" Not distinguishable either: grid, compact, robust. Accurate"), "{all}");
        // Found to be slower in the rounds that choose, and faster in those that compare.
        let faster = |name| row(name, 100.0, Some([0.7, 0.9]), 0);
        let (all, _) = told(&[row(BVH, 107.0, None, 0), faster(GRID)], None);
        let told_so = "Faster still in the rounds that are compared: grid, compact, robust. Accurate";
        assert!(all.contains(told_so) && !all.contains("slower"), "{all}");
        let (all, _) = told(&[row(PAPER, 107.0, None, 0), faster(BVH)], None);
        assert!(
            all.contains(" (bvh, fused) take 107 ns, longer in the rounds that are compared, and got none"),
            "{all}"
        );
    }

    #[test]
    fn what_is_wrong_is_told_together_with_the_reason() {
        let wrong = |schedule| row(["grid", schedule, "paper"], 50.0, Some([0.2, 0.4]), 92);
        let rows = [row(BVH, 162.0, None, 0), wrong("compact"), wrong("fused")];
        let (all, first) = told(&rows, Some("most"));
        assert!(first.contains("bvh, fused, robust is fastest: 162 ns per ray"), "{first}");
        let faster = " Every other accurate choice is slower. Faster, but not accurate: grid, compact/fused, paper (up \
                      to 92 of 36,864 wrong). The paper's rules with a grid miss rays that start outside it, as most of \
                      these do.";
        assert!(all.contains(faster), "{all}");
        // Neither is accurate: nothing is recommended.
        let (all, first) = told(&[wrong("fused").set("is_fastest", false)], None);
        assert!(all.starts_with("box, CPU: no choice could be shown to be accurate. Accurate: "), "{all}");
        assert_eq!(first, "");
    }

    #[test]
    fn a_sample_and_a_raised_limit_are_told() {
        let of_sample = row(BVH, 162.0, None, 0).set("judged_rays", 13_421_u64).set("most_wrong_per_million", 223.187);
        let (all, _) = told(&[of_sample], None);
        assert!(all.contains(" 0 of 13,421 judged rays (a sample of 36,864) wrong (95%: at most "), "{all}");
        let limit = " Accurate: shown to be wrong for at most 220 rays per million (95%; 13,421 judged rays cannot \
                     show less).";
        assert!(all.ends_with(limit), "{all}");
    }
}
