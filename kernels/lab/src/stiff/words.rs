//! What is much slower than the best, in words.

use super::figures::{robust, saved};
use super::{FAMILIES, Family};
use crate::human::time;
use crate::structures::accelerating;
use crate::tidy::{Field as _, Row, Table};

/// What takes more than this many times as long as the fastest structure at the same point is said.
pub const TIMES_THE_BEST: f64 = 20.0;

/// Consecutive points of a family at which something takes too long.
struct Stretch<'a> {
    rows: Vec<(&'a Row, f64)>,
    is_at_end: bool,
}

/// A structure helps if its cells and tests are fewer than this part of all triangles.
const HELPS: f64 = 0.8;
/// Fewest triangles for which that is said.
const FEW: f64 = 256.0;

/// One sentence for each stretch of points at which a structure, with all rules, takes more than [`TIMES_THE_BEST`] times
/// as long as the fastest; for each rule without which it surely takes less than that part of its time; and where no
/// structure helps. Testing every triangle is compared with, but not named.
#[must_use]
pub fn sentences(rows: &[Row]) -> Vec<(&'static Family, String)> {
    let mut all = Vec::new();
    for family in FAMILIES {
        let mut say = |stretch: &Stretch<'_>, text: String| {
            all.push((family, format!("{} ({} {}): {text}", family.title, family.parameter, stretch.range())));
        };
        for structure in accelerating() {
            for stretch in stretches(robust(rows, family.name, structure), |row| slower(rows, family, row)) {
                slow(rows, family, structure, &stretch).into_iter().for_each(|text| say(&stretch, text));
            }
            for rule in rules(rows, family, structure) {
                let key = [("family", family.name), ("accelerator", structure), ("rule", &*rule)];
                let of_rule = rows.iter().filter(|row| row.is(&key));
                for stretch in stretches(of_rule, |row| saved(rows, row).map(|[least, _]| least)) {
                    let sum = |column: &str| -> u64 {
                        stretch.rows.iter().filter_map(|(row, _)| row.get(column).parse::<u64>().ok()).sum()
                    };
                    let [least, most] = stretch.ends();
                    let worst = if least == most { String::new() } else { format!(" (worst: {most} times)") };
                    let text = format!(
                        "with {rule} the {structure} takes at least {least} times{worst} as long as without; without it, {} of \
                         {} rays are wrong.",
                        sum("wrong_rays"),
                        sum("judged_rays"),
                    );
                    say(&stretch, text);
                }
            }
        }
        for stretch in stretches(robust(rows, family.name, "none"), |row| helpless(rows, family, row)) {
            say(
                &stretch,
                "every structure does more than four fifths of the work of testing every triangle.".to_owned(),
            );
        }
    }
    all
}

fn slow(rows: &[Row], family: &Family, structure: &str, stretch: &Stretch<'_>) -> Option<String> {
    let (worst, _) = stretch.rows.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (best, ns) = best(rows, family, worst.get("parameter"))?;
    let at_least = if worst.get("is_lower_bound") == "true" { "at least " } else { "" };
    Some(format!(
        "the {structure} takes {} times as long as the fastest structure; at {}, {at_least}{} a ray against {} ({best}).",
        stretch.ratios(),
        number(worst.get("parameter")),
        time(worst.number("ns_per_ray")?),
        time(ns),
    ))
}

/// Infinite where neither structure helps, by counts; for a row of testing every triangle.
fn helpless(rows: &[Row], family: &Family, row: &Row) -> Option<f64> {
    let work = |row: &Row| Some(row.number("cells_per_ray")? + row.number("tests_per_ray")?);
    let of = |structure: &str| {
        let key = [("family", family.name), ("rule", ""), ("scene", row.get("scene")), ("accelerator", structure)];
        rows.iter().find(|row| row.is(&key)).and_then(work)
    };
    let least = accelerating().filter_map(of).reduce(f64::min)?;
    (least > HELPS * work(row)? && row.number("triangles")? >= FEW).then_some(f64::INFINITY)
}

fn rules(rows: &[Row], family: &Family, structure: &str) -> Vec<String> {
    let mut rules: Vec<String> = Vec::new();
    for row in rows.iter().filter(|row| row.is(&[("family", family.name), ("accelerator", structure)])) {
        let rule = row.get("rule");
        if !rule.is_empty() && !rules.iter().any(|known| known == rule) {
            rules.push(rule.to_owned());
        }
    }
    rules
}

/// The fastest structure with all rules at a point, and its time.
fn best<'a>(rows: &'a [Row], family: &Family, parameter: &str) -> Option<(&'a str, f64)> {
    let here = rows.iter().filter(|row| row.is(&[("family", family.name), ("rule", ""), ("parameter", parameter)]));
    // A lower bound may be beaten by anything.
    let timed = here.filter(|row| row.get("is_lower_bound") == "false");
    let times = timed.filter_map(|row| Some((row.get("accelerator"), row.number("ns_per_ray")?)));
    times.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn slower(rows: &[Row], family: &Family, row: &Row) -> Option<f64> {
    let (_, ns) = best(rows, family, row.get("parameter"))?;
    Some(row.number("ns_per_ray")? / ns)
}

/// Stretches of points where `ratio` is more than [`TIMES_THE_BEST`].
fn stretches<'a>(rows: impl Iterator<Item = &'a Row>, ratio: impl Fn(&Row) -> Option<f64>) -> Vec<Stretch<'a>> {
    let (mut all, mut open) = (Vec::new(), Vec::new());
    for row in rows {
        match ratio(row) {
            Some(r) if r > TIMES_THE_BEST => open.push((row, r)),
            _ if !open.is_empty() => all.push(Stretch { rows: std::mem::take(&mut open), is_at_end: false }),
            _ => {}
        }
    }
    if !open.is_empty() {
        all.push(Stretch { rows: open, is_at_end: true });
    }
    all
}

impl Stretch<'_> {
    fn range(&self) -> String {
        let at = |entry: Option<&(&Row, f64)>| entry.map_or(String::new(), |(row, _)| number(row.get("parameter")));
        let (first, last) = (at(self.rows.first()), at(self.rows.last()));
        match (self.is_at_end, self.rows.len()) {
            (true, _) => format!("≥ {first}"),
            (false, 1) => format!("= {first}"),
            (false, _) => format!("{first} to {last}"),
        }
    }

    /// The smallest and the largest ratio.
    fn ends(&self) -> [String; 2] {
        let ratios = || self.rows.iter().map(|(_, ratio)| *ratio);
        [ratios().fold(f64::INFINITY, f64::min), ratios().fold(0.0, f64::max)].map(rounded)
    }

    /// Both, or one if they are the same.
    fn ratios(&self) -> String {
        let [least, most] = self.ends();
        if least == most { least } else { format!("{least} to {most}") }
    }
}

/// Two significant digits, thousands separated.
fn rounded(value: f64) -> String {
    let round: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    number(&round.text())
}

/// A field with its thousands separated, or as a power of ten.
fn number(field: &str) -> String {
    let Ok(value) = field.parse::<f64>() else { return field.to_owned() };
    if value.fract() != 0.0 || value < 1e4 {
        return field.to_owned();
    }
    let digits = format!("{value:.0}");
    let groups = digits.as_bytes().rchunks(3).rev().map(|group| String::from_utf8_lossy(group));
    groups.collect::<Vec<_>>().join(",")
}

impl super::Cost {
    /// [`sentences`] about these results.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let Table { rows, .. } = &self.rows;
        sentences(rows).into_iter().map(|(_, sentence)| sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stiff::COLUMNS;

    fn row(parameter: f64, structure: &str, rule: &str, ns: f64) -> Row {
        let row = Row::new(COLUMNS).set("family", "room").set("parameter", parameter).set("accelerator", structure);
        let row = row.set("scene", format!("room/{parameter}")).set("rays", 10u32).set("triangles", 5132u32);
        let row = row.set("low_ns", 9.0 * ns).set("high_ns", 11.0 * ns);
        row.set("rule", rule).set("ns_per_ray", ns).set("is_lower_bound", false)
    }

    #[test]
    fn what_is_more_than_20_times_as_slow_is_said_and_nothing_else() {
        let mut rows = Vec::new();
        let points =
            [(4.0, 100.0, 200.0), (30.0, 3990.0, 200.0), (300.0, 80_000.0, 200.0), (1e5, 9e5, 300.0), (1e6, 9e5, 9e5)];
        for (parameter, grid, bvh) in points {
            rows.push(row(parameter, "grid", "", grid));
            rows.push(row(parameter, "bvh", "", bvh));
            rows.push(row(parameter, "none", "", 1e6));
            // The last point is the only one at which the BVH saves too little.
            let tests = [5000.0, if parameter == 1e6 { 4200.0 } else { 40.0 }, 5132.0];
            let last = rows.len() - 3;
            for (row, tests) in rows[last..].iter_mut().zip(tests) {
                *row = row.clone().set("cells_per_ray", 10.0).set("tests_per_ray", tests);
            }
        }
        // Without padding the BVH takes a 25th of its time, surely less than a 20th; the other is not sure.
        rows.push(row(1e5, "bvh", "triangle-test", 300.0 / 24.0));
        rows.push(row(1e6, "bvh", "box-padding", 9e5 / 250.0).set("wrong_rays", 2u32).set("judged_rays", 64u32));
        let said: Vec<String> = sentences(&rows).into_iter().map(|(_, text)| text).collect();
        let place = "A small object in a large room (extent of the room / extent of the object";
        let expected = [
            "300 to 100,000): the grid takes 400 to 3000 times as long as the fastest structure; at 100,000, 900 µs a ray \
             against 300 ns (bvh).",
            "≥ 1,000,000): with box-padding the bvh takes at least 200 times as long as without; without it, 2 of 64 rays are \
             wrong.",
            "≥ 1,000,000): every structure does more than four fifths of the work of testing every triangle.",
        ];
        assert_eq!(said, expected.map(|text| format!("{place} {text}")));
    }

    #[test]
    fn numbers_are_read_by_people() {
        assert_eq!(["1000000", "0.003", "4", "30000"].map(number), ["1,000,000", "0.003", "4", "30,000"]);
    }
}
