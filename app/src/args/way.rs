//! The acceleration structure and the schedule, and their defaults: those of the paper where passes are stepped or
//! recorded, the fastest where only an image or hits are asked for.

use clap::builder::{ArgPredicate, PossibleValuesParser, TypedValueParser as _};
use clap::{Arg, Args};
use raystep_kernels::{Accelerator, ScheduleKind};

use super::named;

/// The structure and the schedule.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Tracing")]
pub(crate) struct WayArgs {
    /// Acceleration structure: a uniform grid (grid), an irregular grid with cells of many sizes (irregular), a bounding
    /// volume hierarchy (bvh), none, or auto, the fastest as measured: none for up to six triangles, on a GPU the grid
    /// if triangles fill the scene evenly, otherwise the BVH
    #[arg(long, default_value = "grid", value_parser = named(Accelerator::ALL, Accelerator::name))]
    pub(crate) accelerator: Accelerator,
    /// How the walk of a ray is divided into passes: intersect until no ray is active there, then traverse once
    /// (first); intersect and traverse alternately (second); several steps per pass, for active rays only (compact);
    /// the whole walk in one pass (fused)
    #[arg(long, default_value = "compact", default_value_if("mapping", "fragment", "second"),
          value_parser = named(ScheduleKind::ALL, ScheduleKind::name))]
    pub(crate) schedule: ScheduleKind,
}

/// The value for the fastest schedule.
const AUTO: &str = "auto";

/// `--schedule` of a command of which only an image or hits are asked for, unless its other options ask for passes.
pub(crate) fn fastest_schedule(arg: Arg) -> Arg {
    let names: Vec<&str> = [AUTO].into_iter().chain(ScheduleKind::ALL.iter().map(|kind| kind.name())).collect();
    let parser = PossibleValuesParser::new(names)
        .try_map(|name| if name == AUTO { Ok(ScheduleKind::Fused) } else { name.parse::<ScheduleKind>() });
    let of_passes = ["passes_csv", "trace_json", "steps_per_pass"];
    let why = "; or auto, the fastest as measured: fused [default: auto; compact where passes are recorded, with \
               --steps-per-pass, and with --numerics paper]";
    also(arg, why)
        .value_parser(parser)
        .default_value(AUTO)
        .default_value_ifs(of_passes.map(|option| (option, ArgPredicate::IsPresent, "compact")))
        .default_value_if("numerics", "paper", "compact")
}

/// `--accelerator` of such a command. If it is changed after [`fastest_schedule`], it depends on the schedule, whether
/// that is given or not.
pub(crate) fn fastest_accelerator(arg: Arg) -> Arg {
    let of_grids = [
        ("schedule", "first"),
        ("schedule", "second"),
        ("schedule", "compact"),
        ("skip", "on"),
        ("skip", "off"),
        ("build", "device"),
        ("traversal", "3d-dda"),
    ];
    also(arg, " [default: auto; grid with an option of grids, and with a schedule of several passes]")
        .default_value(Accelerator::Auto.name())
        .default_value_ifs(of_grids.map(|(option, value)| (option, value, "grid")))
        .default_value_if("grid", ArgPredicate::IsPresent, "grid")
}

/// Adds to the help, which then also says what the default is.
fn also(arg: Arg, more: &str) -> Arg {
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    arg.help(help + more).hide_default_value(true)
}
