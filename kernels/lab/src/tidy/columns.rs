//! The columns of all CSV files: one name for one thing, with type, unit and meaning. A file's schema follows from its
//! columns' names.

mod of_kernels;
mod of_light;
mod of_options;
mod of_passes;

use of_kernels::OF_KERNELS;
use of_light::OF_LIGHT;
use of_options::OF_OPTIONS;
use of_passes::OF_PASSES;
use raystep_kernels::named;

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

named!(Kind, Text "string", Integer "integer", Number "number", Boolean "boolean");

impl Kind {
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
    COLUMNS
        .iter()
        .chain(OF_PASSES)
        .chain(OF_KERNELS)
        .chain(OF_LIGHT)
        .chain(OF_OPTIONS.iter())
        .find(|column| column.name == name)
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

/// All columns but those that only `passes.csv`, or only files about kernels and the paper have.
const COLUMNS: &[Column] = &[
    // Keys.
    count("schema_version", "version of the columns' meanings; passes.csv has its own, all other files have the same"),
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
    text(
        "accelerator",
        "acceleration structure: grid, irregular, bvh or none; in summary.csv also auto, if raystep was asked to choose",
    ),
    text("schedule", "how walks are divided into passes: first, second, compact or fused"),
    text("numerics", "robust or paper"),
    text("grid", "requested cells of the grid along x, y and z, or auto"),
    text("skip", "whether empty cells are skipped over: auto, on or off"),
    count("steps_per_pass", "most steps per ray and pass; empty for schedules without this option"),
    truth("keep_all", "whether nothing is omitted from the plan"),
    count("width_px", "pixels per row of the image that the rays are from; empty for rays from a file"),
    count("height_px", "its rows"),
    text("rays_kind", "primary, bounce, shadow or random; or file and the hash of the rays, with its method as prefix"),
    text("order", "which of several hits is the nearest: by t as f32 has it (rounded), or by exact t (exact)"),
    text("rule", "numerical rule replaced by the paper's; empty if none"),
    text("stratum", "group of rays that were chosen in the same way"),
    count("rays", "rays of this kind traced in a run; of light, the primary ones"),
    count("seed", "seed of rays, samples and orders"),
    truth("is_automatic", "whether the grid's resolution is the automatic one"),
    // Times.
    text("clock", "clock of the times: gpu_timestamp, cpu_clock, or host if the device has no valid clock"),
    count("runs", "counted runs with a valid time"),
    count("invalid_runs", "counted runs whose time was missing, 0 or negative"),
    count("round", "round of interleaved runs, from 0; runs of the same round are compared"),
    count("place", "position in the round, from 0; the order is random"),
    count("sitting", "processes that ran it, from 0: where builds are compared, new ones are started several times"),
    number(
        "time_ns",
        "time of a run, in nanoseconds, by the clock: on a GPU from the begin of the first pass to the end of the last in each \
         submission, on the CPU the sum of its passes",
    ),
    number("wall_ns", "the same by the host's clock, including waits for the device"),
    number(
        "fixed_work_ns",
        "time of a fixed piece of work just before a run, by the host's clock, or the median of these: it shows the speed of the machine",
    ),
    number("median_wall_ns", "median time of a run by the host's clock, including waits for the device"),
    number("rays_per_s", "rays, with those that kernels cast, divided by the median time"),
    number("median_ns", "median time of a run, in nanoseconds"),
    number("low_ns", "lower end of the interval of the median"),
    number("high_ns", "upper end of the interval of the median"),
    number("min_ns", "shortest run"),
    number("max_ns", "longest run"),
    number("ns_per_ray", "median time divided by rays"),
    number("ns_per_ray_low", "lower end of the interval of ns_per_ray"),
    number("ns_per_ray_high", "upper end of the interval of ns_per_ray"),
    text("interval_method", "order_statistics or bootstrap; empty without an interval"),
    number("interval_level", "probability that the interval covers the true median"),
    number("time_ratio", "median of the ratios of runs in the same round, to the configuration in ratio_to"),
    number("time_ratio_low", "lower end of its interval"),
    number("time_ratio_high", "upper end of its interval"),
    number("baseline_ratio", "median time divided by that of an earlier benchmark: above 1 is slower"),
    text("ratio_to", "the configuration that ratios are relative to"),
    number(
        "build_s",
        "seconds for planning, mostly for building the structure: in grid.csv the median of several, elsewhere of one. In a \
         benchmark, kernels were composed before if it took less than a second",
    ),
    number(
        "start_s",
        "seconds for allocating, uploading and compiling: in left_out.csv the median of starts after the first, elsewhere of \
         one",
    ),
    // What the scene does not need: columns that end with _with are those of a run that has it nevertheless.
    text("item", "what the plan omits because the scene does not need it; all for everything together"),
    text("because", "what makes it unnecessary: scene, options or view"),
    text("reason", "why it is omitted"),
    truth("is_changed", "whether any kernel or buffer of this run changes with the item"),
    count("stream_bytes", "bytes of all streams"),
    count("stream_bytes_with", "the same with the item"),
    count("buffer_bytes", "bytes of all buffers"),
    count("buffer_bytes_with", "the same with the item"),
    count("added_bytes", "bytes of all streams and buffers with the item, less those without it"),
    number("first_start_s", "seconds of the first start, whose kernels the driver may have cached earlier"),
    number("first_start_s_with", "the same with the item"),
    number("start_s_with", "start_s with the item"),
    number("start_ratio", "median ratio of starts of the same round, without the first: start_s_with to start_s"),
    number("start_ratio_low", "lower end of its interval"),
    number("start_ratio_high", "upper end of its interval"),
    count("differing_hits", "rays whose hits with and without the item differ in any bit"),
    // Verdicts of the f64 judge.
    count("judged_rays", "rays compared with exact hits in f64"),
    count("missed", "rays that should hit and do not"),
    count("false_hits", "rays that hit and should not"),
    count("wrong_hits", "rays that hit another triangle, or at a wrong t"),
    count("undecided", "rays for which f32 cannot decide, and another result than the exact one was found"),
    count("wrong_rays", "missed, false and wrong hits"),
    number("wrong_per_million", "wrong rays per million judged"),
    number("wrong_per_million_low", "lower end of its exact 95% interval (Clopper and Pearson)"),
    number("wrong_per_million_high", "upper end; if none is wrong, the one-sided 95% bound"),
    count("at_bound", "rays that were not resolved when the run was stopped"),
    // Judged rays, one a row: t is in multiples of the ray's direction, in scene units.
    count("ray", "index of the ray among those traced, from 0"),
    text(
        "verdict",
        "same as the exact hit, undecided, missed, false_hit or wrong_hit; unresolved if the run was stopped before",
    ),
    count("found_triangle", "triangle that the ray was found to hit; empty if it hits nothing"),
    number("found_t", "t of that hit"),
    count("exact_triangle", "nearest triangle that the exact ray hits; empty if there is none"),
    number("exact_t", "t of that hit"),
    number("t_error", "error of found_t, if the triangle is the exact one"),
    number("t_bound", "bound on f32's error of t for that triangle"),
    // Facts about a report.
    text("name", "name of a fact"),
    text("value", "its value"),
    number("undecided_per_million", "undecided rays per million judged"),
    number("most_wrong_per_million", "limit of wrong_per_million_high for a choice to be accurate"),
    truth("is_accurate", "whether wrong_per_million_high is within that limit"),
    truth("is_recommended", "whether it is recommended: the fastest robust and accurate choice, to which ratios are"),
    truth(
        "is_fastest",
        "whether it has the shortest median time of all accurate choices, methods of other programs included",
    ),
    truth("is_front", "whether no other choice is both faster and as accurate"),
    count("witness_rays", "hits whose t was compared with rational arithmetic"),
    number("witness_error_by_bound", "their largest error of t, relative to the ray's bound"),
    number("witness_reference_error_by_bound", "the same of the f64 reference"),
    count("wrong_here_only", "rays that are wrong here and right with robust numerics"),
    count("wrong_robust_only", "rays that are right here and wrong with robust numerics"),
    number("p_value", "McNemar's exact test of both counts"),
    number("p_value_holm", "the same adjusted for all rules and structures (Holm)"),
    truth("is_needed", "whether rays are wrong or unresolved without the rule that are right with it"),
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
    count("hits", "rays that hit something; empty for configurations that were stopped"),
    text("hits_hash", "hash of all hits: equal hashes mean equal bits"),
    // Extreme cases.
    text("case", "name of the case"),
    text("device", "gpu, cpu_f32 or cpu_f64"),
    text(
        "triangle_test",
        "watertight; watertight_fma, with explicit fma wherever a compiler may contract; exact, with hits \
         ordered by exact t; moller_trumbore",
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
    // Passes, in order of time.
    number("pass_end_ns", "end of the pass, in nanoseconds since the start of the first one, by the clock"),
    count("resolved_rays", "rays with a final hit after the pass"),
    count("resolved_judged_rays", "judged rays with a final hit after the pass"),
    count("resolved_wrong_rays", "of these, the wrong ones"),
    number("resolved_wrong_per_million", "the same per million of all judged rays"),
    count("resolved_undecided_rays", "judged rays with a final hit that f32 cannot decide"),
    truth("is_last", "whether it is the last pass"),
    // Offset and scale.
    number("offset_extents", "offset from the given place, in extents of the scene"),
    number("scale", "factor by which the scene is scaled"),
    count(
        "measured_rays",
        "rays whose t is measured: those with the right triangle, in any direction also before rounding",
    ),
    number(
        "arithmetic_error_extents_largest",
        "largest error of t against the rounded scene, as a distance in extents",
    ),
    number("arithmetic_error_extents_median", "median of these errors"),
    number("arithmetic_bound_extents_largest", "largest bound of these errors"),
    number("arithmetic_bound_extents_median", "median bound of these errors"),
    number("arithmetic_error_by_bound_largest", "largest of these errors divided by the same ray's bound"),
    number("depth_rounding_extents_largest", "one rounding, 2^-24, of the largest depth of a vertex of a hit triangle"),
    number("arithmetic_by_depth_rounding", "largest error divided by it"),
    number("forward_error_extents_largest", "largest error of t of the same rays against the scene before rounding"),
    number("forward_error_extents_median", "median of these errors"),
    number("forward_bound_extents_largest", "largest bound of these errors"),
    number("forward_bound_extents_median", "median bound of these errors"),
    number("forward_error_by_bound_largest", "largest of these errors divided by the same ray's bound"),
    count("beyond_forward_bound_rays", "rays whose error exceeds their bound"),
    count("changed_rays", "rays that hit another triangle than before the scene was rounded, or none"),
    number("changed_per_million", "the same per million rays"),
    number("changed_per_million_low", "lower end of its exact 95% interval (Clopper and Pearson)"),
    number("changed_per_million_high", "upper end; if none has changed, the one-sided 95% bound"),
    // Grid resolution.
    number("resolution_factor", "cells along each axis relative to the automatic resolution"),
    truth("is_selected", "whether it is the fastest resolution in half of the rounds"),
    count("cells_x", "cells of the grid along x"),
    count("cells_y", "cells of the grid along y"),
    count("cells_z", "cells of the grid along z"),
    count("cells", "cells of the grid"),
    truth("leaps", "whether rays skip empty cells"),
    count("references", "entries in the lists of triangles of all cells"),
    count("builds", "times that it was planned and built"),
    number("build_s_low", "lower end of the interval of build_s, from 6 builds"),
    number("build_s_high", "upper end of the interval of build_s, from 6 builds"),
    number("build_s_min", "shortest build"),
    number("build_s_max", "longest build"),
    count("held_out_rounds", "rounds that did not take part in selecting the resolution"),
    number("held_out_time_ratio", "median ratio of times in these rounds"),
    number("held_out_time_ratio_low", "lower end of its interval"),
    number("held_out_time_ratio_high", "upper end of its interval"),
    count(
        "paid_off_rays",
        "rays after which building has paid off against testing every triangle; empty if not determined",
    ),
    count("paid_off_rays_low", "fewest such rays that the intervals of both times allow"),
    count("paid_off_rays_high", "most such rays that the intervals of both times allow"),
    // Samples per pixel.
    text(
        "quantity",
        "what the row is: error, slope (of a seed), median_error, median_slope (over seeds), time, or convergence (a median with \
         a time)",
    ),
    text("sampler", "positions of samples: sobol or random"),
    text("pixels", "pixels in which the error is measured: all or edges"),
    count("seeds", "seeds of which it is the median"),
    count("samples", "samples per pixel"),
    count("pixel_count", "pixels in which the error is measured"),
    number("rmse", "root mean square difference from the reference, in linear light"),
    count("reference_samples", "samples per pixel of the reference"),
    number("reference_rmse", "estimated error of the reference itself"),
    number("error", "root of the difference of the squares of rmse and reference_rmse"),
    number("error_low", "lower end of the interval of the median error"),
    number("error_high", "upper end of the interval of the median error"),
    truth("is_fitted", "whether every seed's error is more than three times that of the reference"),
    number("local_slope", "exponent of the error over samples, from the previous number of samples"),
    number("local_slope_low", "lower end of the interval of the median exponent"),
    number("local_slope_high", "upper end of the interval of the median exponent"),
    number("slope", "exponent of the error over samples, fitted to one seed, or the median over seeds"),
    number("slope_low", "lower end of the interval of the median slope"),
    number("slope_high", "upper end of the interval of the median slope"),
];

#[cfg(test)]
mod tests {
    use raystep_kernels::export::csv;

    use super::*;
    use crate::bench::{RunRow, SummaryRow};
    use crate::report::SECTIONS;
    use crate::{intensity, line_cost, paper};

    #[test]
    fn names_are_unique_and_fields_have_types() {
        let all = [COLUMNS, OF_PASSES, OF_KERNELS, OF_LIGHT].concat();
        for (i, column) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.name != column.name), "{} twice", column.name);
            assert!(
                !column.what.is_empty()
                    && column.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_' || b.is_ascii_digit())
            );
        }
        assert!(Kind::Integer.holds("12") && Kind::Integer.holds("") && !Kind::Integer.holds("1.5"));
        assert!(Kind::Number.holds("1e-20") && !Kind::Number.holds("NaN") && !Kind::Number.holds("x"));
        assert!(Kind::Boolean.holds("true") && !Kind::Boolean.holds("1"));
        for section in SECTIONS {
            let unknown: Vec<_> = section.columns.iter().filter(|name| column(name).is_none()).collect();
            assert!(unknown.is_empty(), "{}: {unknown:?}", section.file);
        }
        assert_eq!(column("median_ns").map(|c| c.kind), Some(Kind::Number));
        assert_eq!(column("p05_device_ns"), None);
        let of_paper = paper::FILES.iter().flat_map(|file| file.columns).copied();
        let of_passes = csv::COLUMNS.iter().map(String::as_str);
        let of_bench = [SummaryRow::COLUMNS, RunRow::COLUMNS, intensity::COLUMNS, line_cost::COLUMNS].concat();
        let unknown: Vec<_> =
            of_bench.into_iter().chain(of_paper).chain(of_passes).filter(|name| column(name).is_none()).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
    }
}
