//! The results as text tables.

use super::SummaryRow;
use crate::text::aligned;

/// The text columns.
const NAMES: [&str; 2] = ["accelerator", "schedule"];

/// The numeric columns.
const COLUMNS: [&str; 6] = ["median ms", "p05", "p95", "Mray/s", "to fastest", "to baseline"];

/// One table per group, all with the same column widths.
#[must_use]
pub fn text(rows: &[SummaryRow]) -> String {
    let has_baseline = rows.iter().any(|row| row.baseline_ratio.is_some());
    let columns = &COLUMNS[..COLUMNS.len() - usize::from(!has_baseline)];
    let names = NAMES.iter().chain(columns);
    let mut lines: Vec<Vec<String>> = vec![names.map(|n| (*n).to_owned()).collect()];
    let groups = || rows.chunk_by(|a, b| title(a) == title(b));
    for group in groups() {
        // Only times of the same clock can be compared; all rows of a run have the same one.
        let fastest = group.iter().filter_map(|row| row.time_ns()).map(|(ns, _)| ns).reduce(f64::min);
        for row in group {
            let mut cells = vec![row.accelerator.clone(), row.schedule.clone()];
            cells.extend(numbers(row, fastest).into_iter().take(columns.len()));
            lines.push(cells);
        }
    }
    let lines: Vec<String> = aligned(&lines, NAMES.len()).into_iter().map(|line| format!("  {line}")).collect();
    let (head, mut lines) = (&lines[0], &lines[1..]);
    let table = |group: &[SummaryRow]| {
        let (of_group, rest) = lines.split_at(group.len());
        lines = rest;
        format!("{}\n{head}{}", title(&group[0]), of_group.concat())
    };
    groups().map(table).collect::<Vec<_>>().join("\n")
}

/// What the rows of a group have in common.
fn title(row: &SummaryRow) -> String {
    let SummaryRow { scene, triangles, width_px, height_px, rays_kind, rays, .. } = row;
    format!("{scene} ({triangles} triangles), {width_px}x{height_px}: {rays} {rays_kind} rays")
}

/// The values of [`COLUMNS`].
fn numbers(row: &SummaryRow, fastest: Option<f64>) -> [String; 6] {
    let ms = |ns: Option<f64>| ns.map_or("-".into(), |ns| format!("{:.3}", ns / 1e6));
    let time = row.time_ns().map(|(ns, _)| ns);
    let ratio = |ratio: Option<f64>| ratio.map_or("-".into(), |ratio| format!("{ratio:.2}"));
    let to_fastest = time.zip(fastest).filter(|&(_, fastest)| fastest > 0.0).map(|(ns, fastest)| ns / fastest);
    [
        ms(time),
        ms(row.p05_device_ns),
        ms(row.p95_device_ns),
        row.rays_per_s.map_or("-".into(), |rate| format!("{:.3}", rate / 1e6)),
        ratio(to_fastest),
        ratio(row.baseline_ratio),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(schedule: &str, rays_kind: &str, ns: Option<f64>) -> SummaryRow {
        SummaryRow {
            scene: "box".into(),
            triangles: 26,
            accelerator: "grid".into(),
            schedule: schedule.into(),
            rays_kind: rays_kind.into(),
            width_px: 32,
            height_px: 8,
            rays: 256,
            timer_source: Some("cpu_clock".into()),
            median_device_ns: ns,
            p05_device_ns: ns.map(|ns| ns * 0.9),
            p95_device_ns: ns.map(|ns| ns * 1.2),
            rays_per_s: ns.map(|ns| 256e9 / ns),
            ..SummaryRow::default()
        }
    }

    #[test]
    fn columns_are_aligned_and_the_fastest_is_1() {
        let rows =
            [row("first", "primary", Some(2.5e6)), row("second", "primary", Some(1e6)), row("first", "bounce", None)];
        let expected = "\
box (26 triangles), 32x8: 256 primary rays
  accelerator  schedule  median ms    p05    p95  Mray/s  to fastest
  grid         first         2.500  2.250  3.000   0.102        2.50
  grid         second        1.000  0.900  1.200   0.256        1.00

box (26 triangles), 32x8: 256 bounce rays
  accelerator  schedule  median ms    p05    p95  Mray/s  to fastest
  grid         first             -      -      -       -           -
";
        assert_eq!(text(&rows), expected);
        let compared = SummaryRow { baseline_ratio: Some(1.25), ..row("first", "primary", Some(1.0)) };
        assert!(text(&[compared]).ends_with("        1.00         1.25\n"));
        assert_eq!(text(&[]), "");
    }
}
