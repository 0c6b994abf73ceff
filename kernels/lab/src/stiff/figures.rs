//! Curves of a family, and cost over the stiffness number.

use super::{COLUMNS, Family, number};
use crate::plots::{Axis, Mark, Panel, Plot, Scale, Series, Stroke};
use crate::structures::STRUCTURES;
use crate::tidy::Row;

/// A rule is drawn if leaving it out makes at least this difference somewhere.
const DIFFERS: f64 = 3.0;

/// Robust rows of a family and structure, in order of the parameter.
pub(super) fn robust<'a>(rows: &'a [Row], family: &'a str, structure: &'a str) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |row| row.is(&[("family", family), ("accelerator", structure), ("rule", "")]))
}

/// A family's rows without a rule.
fn without<'a>(rows: &'a [Row], family: &'a str, structure: &'a str) -> impl Iterator<Item = &'a Row> {
    rows.iter()
        .filter(move |row| row.is(&[("family", family), ("accelerator", structure)]) && !row.get("rule").is_empty())
}

fn point(row: &Row, y: &str) -> Option<(f64, f64)> {
    Some((row.number("parameter")?, row.number(y)?))
}

/// Nanoseconds a ray and wrong rays over the parameter; `own` are the stiffness numbers of a scene by structure.
pub(super) fn curves(rows: &[Row], family: &Family, own: &[(String, f64)]) -> Plot {
    let mut times = Vec::new();
    let mut wrong = Vec::new();
    let mut light = Vec::new();
    for (structure, color) in STRUCTURES {
        let rows_of: Vec<&Row> =
            robust(rows, family.name, structure).filter(|r| point(r, "ns_per_ray").is_some()).collect();
        if rows_of.is_empty() {
            continue;
        }
        let mut line = Series::line(structure, color, rows_of.iter().filter_map(|r| point(r, "ns_per_ray")).collect());
        line.whiskers = rows_of.iter().map(|row| whisker(row)).collect();
        times.push(line);
        times.extend(rules_left_out(rows, family.name, structure, color));
        let stopped = rows_of.iter().filter(|row| row.get("is_lower_bound") == "true");
        let stopped: Vec<_> = stopped.filter_map(|row| point(row, "ns_per_ray")).collect();
        if !stopped.is_empty() {
            let marks = Series::line("stopped: at least", color, stopped);
            times.push(Series { mark: Mark::Triangle, stroke: Stroke::None, ..marks });
        }
        let worst = worst(without(rows, family.name, structure), errors_of(family).0);
        if !worst.is_empty() {
            let line = Series::dashed("", color, worst);
            wrong.push(Series { mark: Mark::Triangle, ..line });
        }
        let errors = |column| rows_of.iter().filter_map(|row| point(row, column)).collect();
        wrong.push(Series::line("", color, errors(errors_of(family).0)));
        light.push(Series::line("", color, errors("light_error_largest")));
    }
    let of_rule = Series { mark: Mark::Triangle, ..Series::dashed("the rule that loses most left out", 6, Vec::new()) };
    wrong.push(of_rule);
    let mut panels = vec![
        Panel { y: Axis::new("ns per ray", Scale::Log), height: Some(190.0), series: times },
        Panel { y: Axis::new(errors_of(family).1, Scale::LogWithZero), height: Some(100.0), series: wrong },
    ];
    if family.is_lit() {
        panels.push(Panel { y: Axis::new("error of light", Scale::Log), height: Some(100.0), series: light });
    }
    Plot {
        title: family.title.into(),
        x: Axis::new(family.parameter, Scale::Log),
        panels,
        places: places(rows, family, own),
    }
}

/// The column of the rays that a family gets wrong, and what it is called.
fn errors_of(family: &Family) -> (&'static str, &'static str) {
    match family.is_lit() {
        true => ("wrong_shadow_per_million", "wrong shadow rays per million"),
        false => ("wrong_per_million", "wrong rays per million"),
    }
}

/// The interval of the median, by ray; the median itself without one.
fn whisker(row: &Row) -> (f64, f64) {
    let end = |column: &str| Some(row.number(column)? / row.number("rays")?);
    let middle = row.number("ns_per_ray").unwrap_or(f64::NAN);
    end("low_ns").zip(end("high_ns")).unwrap_or((middle, middle))
}

/// Times without a rule, where they differ from those with all rules somewhere.
fn rules_left_out(rows: &[Row], family: &str, structure: &str, color: usize) -> Vec<Series> {
    let mut rules: Vec<&str> = without(rows, family, structure).map(|row| row.get("rule")).collect();
    rules.sort_unstable();
    rules.dedup();
    let mut lines = Vec::new();
    for rule in rules {
        let of_rule: Vec<&Row> = without(rows, family, structure).filter(|row| row.get("rule") == rule).collect();
        let differs = |row: &Row| saved(rows, row).is_some_and(|[low, high]| low > DIFFERS || high < 1.0 / DIFFERS);
        if of_rule.iter().any(|row| differs(row)) {
            let line = of_rule.iter().filter_map(|row| point(row, "ns_per_ray")).collect();
            lines.push(Series::dashed(format!("{structure} without {rule}"), color, line));
        }
    }
    lines
}

/// How many times as long the structure takes with all rules as in this row without one, at least and at most, by the
/// intervals of both; `None` without them.
pub(super) fn saved(rows: &[Row], row: &Row) -> Option<[f64; 2]> {
    let same = |c: &'static str| (c, row.get(c));
    let key = [same("family"), same("scene"), same("accelerator"), ("rule", "")];
    let whole = rows.iter().find(|row| row.is(&key))?;
    let ends = |row: &Row| {
        let rays = row.number("rays")?;
        Some([row.number("low_ns")? / rays, row.number("high_ns")? / rays])
    };
    let ([low, high], [own_low, own_high]) = (ends(whole)?, ends(row)?);
    (own_low > 0.0).then(|| [low / own_high, high / own_low])
}

/// At each point, the most wrong rays of any rule left out, by their column.
fn worst<'a>(rows: impl Iterator<Item = &'a Row>, column: &str) -> Vec<(f64, f64)> {
    let mut worst: Vec<(f64, f64)> = Vec::new();
    for (x, y) in rows.filter_map(|row| point(row, column)) {
        match worst.iter_mut().find(|point| point.0 == x) {
            Some(point) => point.1 = point.1.max(y),
            None => worst.push((x, y)),
        }
    }
    worst
}

/// Where a scene with these stiffness numbers stands in a family.
fn places(rows: &[Row], family: &Family, own: &[(String, f64)]) -> Vec<(f64, String)> {
    let place = |(structure, stiffness): &(String, f64)| {
        let curve: Vec<_> = robust(rows, family.name, structure).filter_map(|row| point(row, "stiffness")).collect();
        Some((crossing(&curve, *stiffness)?, format!("your scene, {structure}")))
    };
    own.iter().filter_map(place).collect()
}

/// Where a curve first reaches a value from below, interpolated between logarithms; `None` if it begins above the value
/// or does not reach it.
fn crossing(curve: &[(f64, f64)], value: f64) -> Option<f64> {
    curve.windows(2).find_map(|pair| {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let is_between = y0 < value && value <= y1;
        let share = (value / y0).ln() / (y1 / y0).ln();
        is_between.then(|| x0 * (x1 / x0).powf(share))
    })
}

/// Times over the stiffness number, all families.
pub(crate) fn over_stiffness(rows: &[Row], own: &[(String, f64)]) -> Plot {
    let mut series = Vec::new();
    for (structure, color) in STRUCTURES {
        let is_wanted = |row: &&Row| row.is(&[("accelerator", structure), ("rule", "")]);
        let points =
            rows.iter().filter(is_wanted).filter_map(|r| Some((r.number("stiffness")?, r.number("ns_per_ray")?)));
        series.push(Series { stroke: Stroke::None, ..Series::line(structure, color, points.collect()) });
    }
    let [x, y] = ["stiffness number", "ns per ray"].map(|label| Axis::new(label, Scale::Log));
    let places = own.iter().map(|(structure, stiffness)| (*stiffness, format!("your scene, {structure}"))).collect();
    Plot { places, ..Plot::new("Time over the stiffness number, all scenes", x, y, series) }
}

/// Rank correlations of the stiffness number, and of the work along the line and at the end together, with a column.
pub(super) fn correlations(rows: &[Row], structure: &str, column: &str) -> Option<[f64; 2]> {
    debug_assert!(COLUMNS.contains(&column));
    let rows: Vec<&Row> = rows.iter().filter(|r| r.is(&[("accelerator", structure), ("rule", "")])).collect();
    let of = |x: &dyn Fn(&Row) -> Option<f64>| {
        let pairs: Vec<_> = rows.iter().filter_map(|row| Some((x(row)?, row.number(column)?))).collect();
        number::rank_correlation(&pairs)
    };
    let both = |row: &Row| Some(row.number("stiffness")? + row.number("predicted_line")?);
    Some([of(&|row| row.number("stiffness"))?, of(&both)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_stands_where_the_curve_reaches_its_number() {
        let curve = [(1.0, 2.0), (10.0, 2.0), (100.0, 200.0), (1000.0, 100.0)];
        let at = crossing(&curve, 20.0).expect("a place");
        assert!((at - 10f64.powf(1.5)).abs() < 1e-9, "{at}");
        assert_eq!((crossing(&curve, 1.0), crossing(&curve, 1e4), crossing(&[], 1.0)), (None, None, None));
    }
}
