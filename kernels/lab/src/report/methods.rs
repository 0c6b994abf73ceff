//! Results of other programs, to be shown beside raystep's: rows of a CSV file.

use std::io::Read;

use serde::Deserialize;

/// One method in one scene. Its rays should be those of the report; see `--rays-file`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Method {
    /// The scene's name; if it is empty, every scene of the report.
    #[serde(default)]
    pub scene: String,
    /// Its name in the diagram.
    pub method: String,
    /// Time per ray, in nanoseconds.
    pub ns_per_ray: f64,
    /// Lower end of its interval.
    #[serde(default)]
    pub ns_per_ray_low: Option<f64>,
    /// Upper end of its interval.
    #[serde(default)]
    pub ns_per_ray_high: Option<f64>,
    /// Rays that were judged.
    pub judged_rays: u64,
    /// Those that were wrong.
    pub wrong_rays: u64,
    /// Those that could not be decided.
    #[serde(default)]
    pub undecided: u64,
}

/// A file of methods that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum MethodsError {
    /// Not CSV, or not these columns.
    #[error("expected CSV with the columns method, ns_per_ray, judged_rays and wrong_rays: {0}")]
    Csv(#[from] ::csv::Error),
    /// Numbers that no measurement gives.
    #[error("row {row}, {method}: {reason}")]
    Row {
        /// Row, from 1, not counting the names.
        row: usize,
        /// The method.
        method: String,
        /// What is wrong.
        reason: &'static str,
    },
}

/// Reads methods.
///
/// # Errors
/// If the file is not CSV with these columns, or a number is impossible.
pub fn read(input: impl Read) -> Result<Vec<Method>, MethodsError> {
    let rows = ::csv::Reader::from_reader(input).into_deserialize();
    let methods: Vec<Method> = rows.collect::<Result<_, _>>()?;
    for (row, m) in (1..).zip(&methods) {
        let is_time = |ns: f64| ns.is_finite() && ns > 0.0;
        let ends = [m.ns_per_ray_low, m.ns_per_ray_high];
        let reason = match () {
            () if m.method.trim().is_empty() => "it has no name",
            () if !is_time(m.ns_per_ray) || !ends.iter().flatten().all(|&ns| is_time(ns)) => {
                "times must be above 0 and finite"
            }
            () if m.ns_per_ray_low.is_some_and(|low| low > m.ns_per_ray)
                || m.ns_per_ray_high.is_some_and(|high| high < m.ns_per_ray) =>
            {
                "its interval does not contain the time"
            }
            () if m.judged_rays == 0 => "no ray was judged",
            () if m.wrong_rays.checked_add(m.undecided).is_none_or(|sum| sum > m.judged_rays) => {
                "more rays are wrong or undecided than were judged"
            }
            () => continue,
        };
        return Err(MethodsError::Row { row, method: m.method.clone(), reason });
    }
    Ok(methods)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_read_and_impossible_ones_are_told() {
        let of = |text: &str| read(text.as_bytes()).map_err(|e| e.to_string());
        let ours = of("method,ns_per_ray,judged_rays,wrong_rays\nmine,12.5,1000,3\n").expect("a method");
        assert_eq!((ours[0].method.as_str(), ours[0].ns_per_ray, ours[0].ns_per_ray_low), ("mine", 12.5, None));
        let all = "scene,method,ns_per_ray,ns_per_ray_low,ns_per_ray_high,judged_rays,wrong_rays,undecided\n";
        let one = |row: &str| of(&format!("{all}{row}"));
        assert_eq!(one("box,mine,12,11,13,10,1,2\n").expect("a method")[0].ns_per_ray_high, Some(13.0));
        for (row, reason) in [
            ("box,,12,11,13,10,1,2\n", "row 1, : it has no name"),
            ("box,a,0,,,10,1,2\n", "row 1, a: times must be above 0"),
            ("box,a,12,13,14,10,1,2\n", "row 1, a: its interval"),
            ("box,a,12,,,0,0,0\n", "row 1, a: no ray was judged"),
            ("box,a,12,,,10,9,2\n", "row 1, a: more rays are wrong"),
            ("box,a,x,,,10,9,2\n", "expected CSV with the columns"),
        ] {
            let error = one(row).expect_err(row);
            assert!(error.starts_with(reason), "{error}");
        }
        assert!(of("a,b\n1,2\n").expect_err("other columns").contains("missing field"));
    }
}
