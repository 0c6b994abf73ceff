//! Which columns depend on the machine's speed, and which are the same wherever the same numbers are computed.

/// Whether a column may differ between two runs of the same command on the same machine.
#[must_use]
pub fn is_of_time(column: &str) -> bool {
    let is_unit = ["_ns", "_s", "_ns_low", "_ns_high", "_s_with"].iter().any(|end| column.ends_with(end));
    let is_rate = [
        "ns_per_ray",
        "ns_per_sample",
        "time_ratio",
        "same_error_time_ratio",
        "start_ratio",
        "build",
        "held_out_",
        "paid_off",
        "interval_",
    ]
    .iter()
    .any(|b| column.starts_with(b));
    is_unit
        || is_rate
        || matches!(
            column,
            "run_id"
                | "runs"
                | "invalid_runs"
                | "round"
                | "place"
                | "clock"
                | "ratio_to"
                | "is_recommended"
                | "is_fastest"
                | "is_front"
                | "is_selected"
                | "is_lower_bound"
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_and_counts_are_not_of_time() {
        for column in [
            "median_ns",
            "build_s",
            "build_s_low",
            "builds",
            "start_s_with",
            "time_ratio_low",
            "ns_per_ray_high",
            "runs",
            "is_fastest",
        ] {
            assert!(is_of_time(column), "{column}");
        }
        for column in ["wrong_rays", "passes", "tests_per_ray", "structure_bytes", "t_error", "is_needed", "rays"] {
            assert!(!is_of_time(column), "{column}");
        }
    }
}
