//! The results as text tables.

use super::{OF_FILE, SummaryRow};
use crate::human::grouped;
use crate::statistics::Compared;
use crate::text::aligned;

/// The text columns; the last three if rows differ in them, or are about light.
const NAMES: [&str; 5] = ["accelerator", "schedule", "mapping", "traversal", "integrator"];

/// A numeric column.
struct Column {
    name: &'static str,
    value: fn(&SummaryRow) -> String,
    /// Whether it is shown for one of these rows.
    is_shown: fn(&SummaryRow) -> bool,
}

const fn column(name: &'static str, value: fn(&SummaryRow) -> String) -> Column {
    Column { name, value, is_shown: |_| true }
}

const COLUMNS: [Column; 9] = [
    column("median ms", |row| ms(row.median_ns)),
    column("low", |row| ms(row.low_ns)),
    column("high", |row| ms(row.high_ns)),
    column("Mray/s", |row| millions(row.rays_per_s)),
    Column { is_shown: |row| !row.is_of_hits(), ..column("Msample/s", |row| millions(row.samples_per_s)) },
    Column {
        is_shown: |row| row.secondary_rays > Some(0),
        ..column("secondary rays", |row| count(row.secondary_rays))
    },
    Column { is_shown: |row| !row.is_of_hits(), ..column("shadow rays", |row| count(row.shadow_rays)) },
    column("to fastest", to_fastest),
    Column {
        is_shown: |row| row.baseline_ratio.is_some(),
        ..column("to baseline", |row| row.baseline_ratio.map_or("-".into(), |ratio| format!("{ratio:.2}")))
    },
];

/// One table per group, all with the same column widths. `rays_file` is the name of the file that rays are from, if they are.
#[must_use]
pub fn text(rows: &[SummaryRow], rays_file: Option<&str>) -> String {
    let columns: Vec<&Column> = COLUMNS.iter().filter(|column| rows.iter().any(column.is_shown)).collect();
    let texts = |row: &SummaryRow| {
        [&row.accelerator, &row.schedule, &row.mapping, &row.traversal, &row.integrator].map(String::clone)
    };
    let differ = |name: usize| name < 2 || rows.iter().any(|row| texts(row)[name] != texts(&rows[0])[name]);
    let is_of_light = rows.iter().any(|row| !row.is_of_hits());
    let shown: Vec<usize> =
        (0..NAMES.len()).filter(|&name| differ(name) || is_of_light && NAMES[name] == "integrator").collect();
    let names = shown.iter().map(|&name| NAMES[name]);
    let mut lines: Vec<Vec<String>> =
        vec![names.chain(columns.iter().map(|column| column.name)).map(str::to_owned).collect()];
    let title = |row: &SummaryRow| title(row, rays_file);
    let groups = || rows.chunk_by(|a, b| title(a) == title(b));
    for row in rows {
        let of_row = texts(row);
        let mut cells: Vec<String> = shown.iter().map(|&name| of_row[name].clone()).collect();
        cells.extend(columns.iter().map(|column| (column.value)(row)));
        lines.push(cells);
    }
    let lines: Vec<String> = aligned(&lines, shown.len()).into_iter().map(|line| format!("  {line}")).collect();
    let (head, mut lines) = (&lines[0], &lines[1..]);
    let table = |group: &[SummaryRow]| {
        let (of_group, rest) = lines.split_at(group.len());
        lines = rest;
        format!("{}\n{head}{}", title(&group[0]), of_group.concat())
    };
    groups().map(table).collect::<Vec<_>>().join("\n")
}

/// What the rows of a group have in common.
fn title(row: &SummaryRow, rays_file: Option<&str>) -> String {
    let SummaryRow { scene, rays_kind, .. } = row;
    let [triangles, rays] = [row.triangles, row.rays].map(grouped);
    match (row.size(), rays_file) {
        (Some(size), _) => format!("{scene} ({triangles} triangles), {size}: {rays} {rays_kind} rays"),
        (None, Some(file)) => format!("{scene} ({triangles} triangles): {rays} rays of {file}"),
        (None, None) => format!("{scene} ({triangles} triangles): {rays} {OF_FILE}"),
    }
}

fn ms(ns: Option<f64>) -> String {
    ns.map_or("-".into(), |ns| format!("{:.3}", ns / 1e6))
}

fn millions(rate: Option<f64>) -> String {
    rate.map_or("-".into(), |rate| format!("{:.3}", rate / 1e6))
}

fn count(rays: Option<u64>) -> String {
    rays.map_or("-".into(), grouped)
}

/// The ratio to the fastest of the group with its interval, unless that says that they cannot be distinguished.
fn to_fastest(row: &SummaryRow) -> String {
    let Some(ratio) = row.time_ratio else { return "-".into() };
    match row.time_ratio_low.zip(row.time_ratio_high) {
        _ if row.ratio_to.as_ref() == Some(&row.configuration) => "fastest".into(),
        Some((low, high)) => match Compared::of(Some([low, high])) {
            alike @ (Compared::AsFast | Compared::NotDistinguishable) => alike.words().into(),
            _ => format!("{ratio:.2} [{low:.2}, {high:.2}]"),
        },
        None => format!("{ratio:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(schedule: &str, rays_kind: &str, ns: Option<f64>, ratio: Option<[f64; 3]>) -> SummaryRow {
        SummaryRow {
            configuration: schedule.into(),
            scene: "box".into(),
            triangles: 26,
            accelerator: "grid".into(),
            schedule: schedule.into(),
            rays_kind: rays_kind.into(),
            width_px: Some(32),
            height_px: Some(8),
            rays: 256,
            clock: "cpu_clock".into(),
            median_ns: ns,
            low_ns: ns.map(|ns| ns * 0.9),
            high_ns: ns.map(|ns| ns * 1.2),
            rays_per_s: ns.map(|ns| 256e9 / ns),
            time_ratio: ratio.map(|r| r[0]),
            time_ratio_low: ratio.map(|r| r[1]),
            time_ratio_high: ratio.map(|r| r[2]),
            ratio_to: Some("second".into()),
            integrator: "local".into(),
            ..SummaryRow::default()
        }
    }

    #[test]
    fn rays_of_a_file_have_its_name_and_no_size() {
        let of_file = SummaryRow {
            width_px: None,
            height_px: None,
            rays: 1_000_000,
            triangles: 994,
            ..row("fused", "file fnv1a64:0", None, None)
        };
        assert!(
            text(std::slice::from_ref(&of_file), Some("a.npy"))
                .starts_with("box (994 triangles): 1,000,000 rays of a.npy\n")
        );
        assert!(text(&[of_file], None).starts_with("box (994 triangles): 1,000,000 rays of a file\n"));
    }

    #[test]
    fn columns_are_aligned_and_only_a_narrow_interval_is_as_fast() {
        let rows = [
            row("first", "primary", Some(2.5e6), Some([2.5, 2.25, 3.0])),
            row("second", "primary", Some(1e6), Some([1.0; 3])),
            row("compact", "primary", Some(1e6), Some([1.0, 0.98, 1.02])),
            row("fused", "primary", Some(1.1e6), Some([1.1, 0.9, 1.2])),
            row("first", "bounce", None, None),
        ];
        let expected = "\
box (26 triangles), 32x8: 256 primary rays
  accelerator  schedule  median ms    low   high  Mray/s           to fastest
  grid         first         2.500  2.250  3.000   0.102    2.50 [2.25, 3.00]
  grid         second        1.000  0.900  1.200   0.256              fastest
  grid         compact       1.000  0.900  1.200   0.256              as fast
  grid         fused         1.100  0.990  1.320   0.233  not distinguishable

box (26 triangles), 32x8: 256 bounce rays
  accelerator  schedule  median ms    low   high  Mray/s           to fastest
  grid         first             -      -      -       -                    -
";
        assert_eq!(text(&rows, None), expected);
        let few = SummaryRow {
            time_ratio_low: None,
            baseline_ratio: Some(1.25),
            ..row("first", "primary", Some(1.0), Some([1.5; 3]))
        };
        assert!(text(&[few], None).ends_with("  1.50         1.25\n"));
        assert_eq!(text(&[], None), "");
    }

    #[test]
    fn light_has_its_rays_and_samples_by_second() {
        let hits = row("second", "primary", Some(1e6), Some([1.0; 3]));
        let light = SummaryRow {
            integrator: "shadows".into(),
            shadow_rays: Some(1200),
            secondary_rays: Some(0),
            samples_per_s: Some(128e6),
            ..row("fused", "primary", Some(2e6), Some([2.0, 1.9, 2.1]))
        };
        let expected = "\
box (26 triangles), 32x8: 256 primary rays
  accelerator  schedule  integrator  median ms    low   high  Mray/s  Msample/s  shadow rays         to fastest
  grid         second    local           1.000  0.900  1.200   0.256          -            -            fastest
  grid         fused     shadows         2.000  1.800  2.400   0.128    128.000        1,200  2.00 [1.90, 2.10]
";
        assert_eq!(text(&[hits, light.clone()], None), expected);
        let mirrors = text(&[SummaryRow { secondary_rays: Some(77), ..light }], None);
        assert!(mirrors.contains("  secondary rays  ") && mirrors.contains("  77  "), "{mirrors}");
    }
}
