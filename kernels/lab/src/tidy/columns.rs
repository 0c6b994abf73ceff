//! The columns of all CSV files: one name for one thing, with type, unit and meaning. A file's schema follows from its
//! columns' names.

/// What a column's fields are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text.
    Text,
    /// A whole number.
    Integer,
    /// A number.
    Number,
    /// `true` or `false`.
    Boolean,
}

impl Kind {
    /// Its name in Frictionless Table Schema.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "string",
            Self::Integer => "integer",
            Self::Number => "number",
            Self::Boolean => "boolean",
        }
    }

    /// Whether it can hold a field; an empty one is unknown and always can.
    #[must_use]
    pub fn holds(self, field: &str) -> bool {
        field.is_empty()
            || match self {
                Self::Text => true,
                Self::Integer => field.parse::<i128>().is_ok(),
                Self::Number => field.parse::<f64>().is_ok_and(f64::is_finite),
                Self::Boolean => matches!(field, "true" | "false"),
            }
    }
}

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// The type of its fields.
    pub kind: Kind,
    /// What it holds.
    pub what: &'static str,
}

/// The column with this name; `None` if no file has one.
#[must_use]
pub fn column(name: &str) -> Option<&'static Column> {
    COLUMNS.iter().find(|column| column.name == name)
}

const fn text(name: &'static str, what: &'static str) -> Column {
    Column { name, kind: Kind::Text, what }
}

const fn count(name: &'static str, what: &'static str) -> Column {
    Column { name, kind: Kind::Integer, what }
}

const fn number(name: &'static str, what: &'static str) -> Column {
    Column { name, kind: Kind::Number, what }
}

const fn truth(name: &'static str, what: &'static str) -> Column {
    Column { name, kind: Kind::Boolean, what }
}

/// All columns.
pub const COLUMNS: &[Column] = &[
    // Keys.
    count("schema_version", "version of the columns' meanings, the same in all files"),
    text("run_id", "identifies one invocation of the command, in all its files"),
    text("configuration", "identifies what was run, within run_id"),
    text("section", "section of the report"),
    text("build", "which build ran it: this, or other for the one it is compared with"),
    text("scene", "name of the scene"),
    text("scene_hash", "hash of all files the scene was read from, with the method as prefix"),
    text("adapter", "name of the GPU adapter, or cpu for the CPU reference kernels"),
    // What was run.
    text("method", "name of another program's method; empty for raystep's"),
    count("triangles", "triangles of the scene"),
    text("accelerator", "acceleration structure: grid, bvh or none"),
    text("schedule", "how walks are divided into passes: first, second, compact or fused"),
    text("numerics", "robust or paper"),
    text("grid", "requested cells of the grid along x, y and z, or auto"),
    text("skip", "whether empty cells are skipped over: auto, on or off"),
    count("steps_per_pass", "most steps per ray and pass; empty for schedules without this option"),
    truth("keep_all", "whether nothing is omitted from the plan"),
    count("width_px", "rays per row of the image"),
    count("height_px", "rows of the image"),
    text("rays_kind", "primary, bounce, shadow or random"),
    text("rule", "numerical rule replaced by the paper's; empty if none"),
    text("stratum", "group of rays that were chosen in the same way"),
    count("rays", "rays traced in a run"),
    count("seed", "seed of rays and orders"),
    truth("is_automatic", "whether the grid's resolution is the automatic one"),
    // Times.
    text("clock", "gpu_timestamp, cpu_clock, or host if the device has no valid clock"),
    count("runs", "counted runs with a valid time"),
    count("invalid_runs", "counted runs whose time was missing, 0 or negative"),
    count("round", "round of interleaved runs, from 0; runs of the same round are compared"),
    count("place", "position in the round, from 0; the order is random"),
    count("sitting", "processes that ran it, from 0: where builds are compared, new ones are started several times"),
    number("time_ns", "time of a run, in nanoseconds, by the clock"),
    number("wall_ns", "the same by the host's clock, including waits for the device"),
    number(
        "fixed_work_ns",
        "time of a fixed piece of work just before a run, by the host's clock, or the median of these: it shows the speed of the machine",
    ),
    number("median_wall_ns", "median time of a run by the host's clock, including waits for the device"),
    number("rays_per_s", "rays divided by the median time"),
    number("median_ns", "median time of a run, in nanoseconds"),
    number("low_ns", "lower end of the interval of the median"),
    number("high_ns", "upper end of the interval of the median"),
    number("min_ns", "shortest run"),
    number("max_ns", "longest run"),
    number("ns_per_ray", "median time divided by rays"),
    text("interval_method", "order_statistics or bootstrap; empty without an interval"),
    number("interval_level", "probability that the interval covers the true median"),
    number("time_ratio", "median of the ratios of runs in the same round, to the configuration in ratio_to"),
    number("time_ratio_low", "lower end of its interval"),
    number("time_ratio_high", "upper end of its interval"),
    number("baseline_ratio", "median time divided by that of an earlier benchmark: above 1 is slower"),
    text("ratio_to", "the configuration that ratios are relative to"),
    number("build_s", "seconds for planning, mostly for building the structure"),
    number("start_s", "seconds for allocating, uploading and compiling: the median of starts after the first"),
    // What the scene does not need: columns that end with _with are those of a run that has it nevertheless.
    text("item", "what the plan omits because the scene does not need it; all for everything together"),
    text("because", "what makes it unnecessary: scene, options or view"),
    text("reason", "why it is omitted"),
    truth("is_changed", "whether any kernel or buffer of this run changes with the item"),
    count("stream_bytes", "bytes of all streams"),
    count("stream_bytes_with", "the same with the item"),
    count("buffer_bytes", "bytes of all buffers"),
    count("buffer_bytes_with", "the same with the item"),
    number("first_start_s", "seconds of the first start, whose kernels the driver may have cached earlier"),
    number("first_start_s_with", "the same with the item"),
    number("start_s_with", "start_s with the item"),
    number("start_ratio", "median ratio of starts of the same round, without the first: start_s_with to start_s"),
    number("start_ratio_low", "lower end of its interval"),
    number("start_ratio_high", "upper end of its interval"),
    count("differing_hits", "rays whose hits with and without the item differ in any bit"),
    // Verdicts of f64 brute force.
    count("judged_rays", "rays compared with f64 brute force"),
    count("missed", "rays that should hit and do not"),
    count("false_hits", "rays that hit and should not"),
    count("wrong_hits", "rays that hit another triangle, or at a wrong t"),
    count("undecided", "rays for which f32 cannot decide, and another result than the exact one was found"),
    count("wrong_rays", "missed, false and wrong hits"),
    number("wrong_per_million", "wrong rays per million judged"),
    number("wrong_per_million_low", "lower end of its exact 95% interval (Clopper and Pearson)"),
    number("wrong_per_million_high", "upper end; if none is wrong, the one-sided 95% bound"),
    count("at_bound", "rays that were not resolved when the run was stopped"),
    // Work.
    count("passes", "passes of a run"),
    number("cells_per_ray", "cells or nodes visited, per ray"),
    number("tests_per_ray", "triangles tested, per ray"),
    number(
        "repeated_per_ray",
        "tests of a triangle that the ray had already met, per ray; empty if the schedule cannot count them",
    ),
    number("useful_steps_per_thread", "rays worked on divided by threads launched, over all passes"),
    number("bytes_per_triangle", "structure_bytes, plus the bytes of packed triangles, divided by triangles"),
    count("structure_bytes", "bytes of the grid or BVH"),
    count("hits", "rays that hit something"),
    text("hits_hash", "hash of all hits: equal hashes mean equal bits"),
    // Extreme cases.
    text("case", "name of the case"),
    text("device", "gpu, cpu_f32 or cpu_f64"),
    text(
        "triangle_test",
        "watertight; watertight_fma, with explicit fma wherever a compiler may contract; moller_trumbore",
    ),
    count("undecided_ceiling", "most undecided rays that the error bound allows"),
    count("undecidable", "rays for which the error bound allows more than one result"),
    count("edge_on", "hits of a triangle that is seen exactly edge-on or has no area"),
    count("non_finite", "rays with a value in any stream that is not finite"),
    number("t_relative", "largest error of t among hits of the exact triangle, relative to the exact t"),
    number("t_ulp", "the same in f32's units in the last place of the triangle's farthest depth"),
    number("u_relative", "largest error of the weight of vertex 1, relative"),
    number("u_ulp", "the same in units in the last place of 1"),
    number("v_relative", "largest error of the weight of vertex 2, relative"),
    number("v_ulp", "the same in units in the last place of 1"),
    text("expected", "pass, fail, or any if nothing is expected"),
    text("result", "pass, or fail if there is any error or too many rays are undecided"),
    number("error_units", "largest error of tMax, in units of 2^-24 max(|plane|, |origin|) / |direction|"),
    number("error_t", "the same in t"),
    number("bound_units", "the bound of robust numerics; empty for others"),
    text("pipeline", "accelerator, schedule, and other differences"),
    text("compared_with", "the pipeline on the first device that traced the same rays"),
    count("pairs", "rays that hit the same triangle in both pipelines"),
    count("other_triangle", "rays that hit another triangle, or none, in one of them"),
    count("differing_t", "pairs whose t differs in any bit"),
    count("differing_u", "pairs whose weight of vertex 1 differs"),
    count("differing_v", "pairs whose weight of vertex 2 differs"),
    // Stiff scenes.
    text("family", "scenes that differ in one parameter; scene for one that is of no family"),
    number("parameter", "the family's parameter; empty for a scene of no family"),
    text("version", "version of raystep"),
    truth("is_quick", "whether fewer rays were traced"),
    truth("is_lower_bound", "whether a run was stopped: its time is at least this"),
    number("stiffness", "cells or nodes plus tests expected at a random point of a random triangle"),
    number("predicted_line", "the same along a random line through the scene"),
    // Passes.
    count("repeat", "repetition, from 0"),
    truth("is_warmup", "whether the repetition was only a warm-up"),
    count("pass_index", "index of a pass in its run, from 0"),
    count("iteration", "iteration of the schedule's loop, from 1; 0 before the loop"),
    text("kernel", "the kernel that ran"),
    count("gpu_begin_ns", "since the run's first timed pass began, by the clock"),
    count("gpu_duration_ns", "duration of a pass, by the clock"),
    count("cpu_encode_ns", "host time to record the pass"),
    count("rays_in", "rays in one of the kernel's states before the pass: those it worked on"),
    count("rays_out", "those of them that the pass moved to a state of another kernel"),
    count("threads_launched", "threads launched by a pass, with or without a ray to work on"),
    count(
        "cells_visited",
        "cells or nodes visited: by a pass, known if counters were requested; or by the farthest ray of a walk",
    ),
    count("triangles_tested", "triangles tested by a pass; known if counters were requested"),
    number("clock_resolution_ns", "smallest step of the clock"),
    truth("valid", "whether the timer gave a duration; empty if nothing was timed"),
    count("host_run_ns", "time of the whole run by the host's clock; known if clock is host"),
];

#[cfg(test)]
mod tests {
    use raystep_kernels::export::csv;

    use super::*;
    use crate::bench::{runs, summary};

    #[test]
    fn names_are_unique_and_fields_have_types() {
        for (i, column) in COLUMNS.iter().enumerate() {
            assert!(COLUMNS[..i].iter().all(|other| other.name != column.name), "{} twice", column.name);
            assert!(
                !column.what.is_empty()
                    && column.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_' || b.is_ascii_digit())
            );
        }
        assert!(Kind::Integer.holds("12") && Kind::Integer.holds("") && !Kind::Integer.holds("1.5"));
        assert!(Kind::Number.holds("1e-20") && !Kind::Number.holds("NaN") && !Kind::Number.holds("x"));
        assert!(Kind::Boolean.holds("true") && !Kind::Boolean.holds("1"));
        assert_eq!(column("median_ns").map(|c| c.kind), Some(Kind::Number));
        assert_eq!(column("p05_device_ns"), None);
        let of_bench = [&summary::COLUMNS[..], &runs::COLUMNS, &csv::COLUMNS].concat();
        let unknown: Vec<_> = of_bench.into_iter().filter(|name| column(name).is_none()).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
    }
}
