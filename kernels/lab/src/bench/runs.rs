//! The timed runs of a benchmark: `runs.csv`, one row per run.

use std::collections::BTreeMap;
use std::io::Read;

use super::summary::{HOST, ReadError, check_version};
use crate::meter::{Time, Valid};

csv_row! {
    /// A row of `runs.csv`; [`crate::tidy::columns`] describes its columns.
    pub struct RunRow {
        pub schema_version: u32,
        pub run_id: String,
        pub configuration: String,
        pub sitting: usize,
        pub round: usize,
        pub place: usize,
        pub clock: String,
        pub time_ns: Option<u64>,
        pub wall_ns: u64,
        pub fixed_work_ns: u64,
    }
}

impl RunRow {
    /// Fills in the time by this row's clock.
    #[must_use]
    pub fn timed(self, time: Time) -> Self {
        let time_ns = if self.clock == HOST { Some(time.wall_ns) } else { time.device_ns };
        Self { time_ns: time_ns.filter(|&ns| ns > 0), wall_ns: time.wall_ns, ..self }
    }
}

/// The valid times of some runs.
#[must_use]
pub fn valid(runs: &[RunRow]) -> Valid {
    Valid::of(&runs.iter().map(|run| run.time_ns).collect::<Vec<_>>())
}

/// The times of two configurations in the same rounds; a round without a valid time of both is left out.
#[must_use]
pub fn pairs(of: &[RunRow], to: &[RunRow]) -> Vec<(f64, f64)> {
    let to: BTreeMap<usize, u64> = to.iter().filter_map(|run| Some((run.round, run.time_ns?))).collect();
    of.iter().filter_map(|run| Some((run.time_ns? as f64, *to.get(&run.round)? as f64))).collect()
}

/// Reads `runs.csv`.
///
/// # Errors
/// If it is not such a file, or has another version.
pub fn read_runs(input: impl Read) -> Result<Vec<RunRow>, ReadError> {
    let rows: Vec<RunRow> = ::csv::Reader::from_reader(input).deserialize().collect::<Result<_, _>>()?;
    check_version(rows.iter().map(|row| row.schema_version))?;
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::super::write_rows;
    use super::*;

    fn run(round: usize, device_ns: Option<u64>) -> RunRow {
        let row = RunRow {
            schema_version: crate::tidy::SCHEMA_VERSION,
            round,
            clock: "cpu_clock".into(),
            ..RunRow::default()
        };
        row.timed(Time { wall_ns: 9, device_ns })
    }

    #[test]
    fn runs_are_paired_by_round_and_read_back() {
        let (a, b) = ([run(0, Some(2)), run(1, Some(4)), run(2, None)], [run(1, Some(8)), run(2, Some(3))]);
        assert_eq!(pairs(&a, &b), [(4.0, 8.0)]);
        assert_eq!((valid(&a).ns, valid(&a).invalid), (vec![2.0, 4.0], 1));
        let by_host =
            RunRow { clock: "host".into(), ..RunRow::default() }.timed(Time { wall_ns: 9, device_ns: Some(1) });
        assert_eq!(by_host.time_ns, Some(9));
        let mut file = Vec::new();
        write_rows(&mut file, &a).expect("memory");
        let names = "schema_version,run_id,configuration,sitting,round,place,clock,time_ns,wall_ns,fixed_work_ns\r\n";
        assert!(file.starts_with(names.as_bytes()), "{}", String::from_utf8_lossy(&file));
        assert_eq!(read_runs(file.as_slice()).expect("runs"), a);
        let mut old = Vec::new();
        write_rows(&mut old, &[RunRow { schema_version: 1, ..run(0, None) }]).expect("memory");
        assert!(matches!(read_runs(old.as_slice()), Err(ReadError::Version(1))));
    }
}
