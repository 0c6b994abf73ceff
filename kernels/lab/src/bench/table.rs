//! The results as text tables.

use super::{OF_FILE, SummaryRow};
use crate::human::grouped;
use crate::statistics::Compared;
use crate::text::aligned;

/// The text columns; the last two if rows differ in them.
const NAMES: [&str; 4] = ["accelerator", "schedule", "mapping", "traversal"];

/// The numeric columns.
const COLUMNS: [&str; 6] = ["median ms", "low", "high", "Mray/s", "to fastest", "to baseline"];

/// One table per group, all with the same column widths. `rays_file` is the name of the file that rays are from, if they are.
#[must_use]
pub fn text(rows: &[SummaryRow], rays_file: Option<&str>) -> String {
    let has_baseline = rows.iter().any(|row| row.baseline_ratio.is_some());
    let columns = &COLUMNS[..COLUMNS.len() - usize::from(!has_baseline)];
    let texts = |row: &SummaryRow| [&row.accelerator, &row.schedule, &row.mapping, &row.traversal].map(String::clone);
    let differ = |name: usize| name < 2 || rows.iter().any(|row| texts(row)[name] != texts(&rows[0])[name]);
    let shown: Vec<usize> = (0..NAMES.len()).filter(|&name| differ(name)).collect();
    let names = shown.iter().map(|&name| NAMES[name]);
    let mut lines: Vec<Vec<String>> = vec![names.chain(columns.iter().copied()).map(str::to_owned).collect()];
    let title = |row: &SummaryRow| title(row, rays_file);
    let groups = || rows.chunk_by(|a, b| title(a) == title(b));
    for row in rows {
        let of_row = texts(row);
        let mut cells: Vec<String> = shown.iter().map(|&name| of_row[name].clone()).collect();
        cells.extend(numbers(row).into_iter().take(columns.len()));
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

/// The values of [`COLUMNS`].
fn numbers(row: &SummaryRow) -> [String; 6] {
    let ms = |ns: Option<f64>| ns.map_or("-".into(), |ns| format!("{:.3}", ns / 1e6));
    [
        ms(row.median_ns),
        ms(row.low_ns),
        ms(row.high_ns),
        row.rays_per_s.map_or("-".into(), |rate| format!("{:.3}", rate / 1e6)),
        to_fastest(row),
        row.baseline_ratio.map_or("-".into(), |ratio| format!("{ratio:.2}")),
    ]
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
}
