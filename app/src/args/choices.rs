//! The options that are rows of [`ROWS`], as options of commands.

use std::fmt;
use std::marker::PhantomData;

use clap::builder::{ArgPredicate, PossibleValuesParser, TypedValueParser as _};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use raystep_kernels::options::Integrator;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::options::rows::{ROWS, Refusal, Row, Value, Values};
use raystep_kernels::{Accelerator, Choices, GridSize, Options, RaySource, ScheduleKind};

use serde::{Serialize, Serializer};

use super::whole;
use crate::error::Error;

/// Rows that commands have together.
pub(crate) trait Group {
    /// Their heading in `--help`, if they have one of their own.
    const HEADING: Option<&'static str>;
    /// Whether a row is one of them.
    fn has(name: &str) -> bool;
}

macro_rules! groups {
    ($($(#[$doc:meta])* $name:ident, $heading:expr => |$row:ident| $has:expr;)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug)]
            pub(crate) struct $name;

            impl Group for $name {
                const HEADING: Option<&'static str> = $heading;
                fn has($row: &str) -> bool {
                    $has
                }
            }
        )*
    };
}

groups! {
    /// What runs, and on how many elements without a scene.
    What, None => |row| matches!(row, "program" | "elements");
    /// What a program without a scene works on.
    Amount, None => |row| matches!(row, "elements" | "seed");
    /// Samples per pixel.
    Sampling, Some("Scene and view") => |row| matches!(row, "spp" | "sampler" | "seed");
    /// Everything about tracing.
    Tracing, Some("Tracing") => |row| !What::has(row) && !Sampling::has(row);
    /// What rays of a file have.
    Casting, Some("Tracing") => |row| is_of_any_rays(row) || matches!(row, "accelerator" | "schedule");
    /// What `raystep bench` does not combine itself.
    Tuning, Some("Tracing") => |row| is_of_any_rays(row) || is_of_photons(row);
}

/// What rays have wherever they come from.
fn is_of_any_rays(row: &str) -> bool {
    matches!(row, "numerics" | "order" | "grid" | "skip" | "steps-per-pass" | "build" | "keep-all")
}

/// What maps of photons have: their number alone decides what a run takes.
fn is_of_photons(row: &str) -> bool {
    matches!(row, "photons" | "photon-map" | "neighbours" | "nearest" | "gather" | "gather-radius")
}

/// The rows of a group.
pub(crate) fn rows<S: Group>() -> impl Iterator<Item = &'static Row> {
    ROWS.iter().filter(|row| S::has(row.name))
}

/// The options of a group, with their values.
#[derive(Clone)]
pub(crate) struct ChoiceArgs<S> {
    /// The values, and the defaults of all other options.
    pub(crate) values: Choices,
    /// The options that were given.
    given: Vec<&'static str>,
    group: PhantomData<S>,
}

impl<S: Group> ChoiceArgs<S> {
    /// The options that a link sets.
    pub(crate) fn of(values: Choices) -> Self {
        let usual = Choices::stepped();
        let given = rows::<S>().filter(|row| row.get(&values) != row.get(&usual)).map(|row| row.name).collect();
        Self { values, given, group: PhantomData }
    }

    /// Whether an option was given.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.given.contains(&name)
    }

    /// Without `--steps-per-pass`, every step is a pass.
    pub(crate) fn step_by_step(&mut self) {
        if !self.has("steps-per-pass") {
            self.values.steps_per_pass = 1;
        }
    }

    /// With a kernel of the user's, single steps through the grid are the default: those have all kernels of the paper.
    pub(crate) fn through_the_grid(&self) -> Choices {
        let mut values = self.values;
        // Fragment programs, for which there is another default, cannot be replaced: the plan says so.
        if !self.has("schedule") && values.mapping == Mapping::Compute {
            values.schedule = ScheduleKind::Compact;
        }
        if !self.has("steps-per-pass") {
            values.steps_per_pass = 1;
        }
        if !self.has("accelerator") {
            values.accelerator = Accelerator::Grid;
        }
        values
    }

    /// Refuses what has no effect with any of these, or goes together with none of them.
    pub(crate) fn check_for(
        &self,
        accelerators: &[Accelerator],
        schedules: &[ScheduleKind],
        integrators: &[Integrator],
    ) -> Result<(), Error> {
        let each = accelerators.iter().flat_map(|&accelerator| {
            schedules.iter().flat_map(move |&schedule| {
                let of_light = integrators.iter();
                of_light.map(move |&integrator| Choices { accelerator, schedule, integrator, ..self.values })
            })
        });
        for row in ROWS {
            let refused: Vec<_> = each.clone().map(|choices| (row.refused)(&choices)).collect();
            let fault = refused.iter().flatten().find(|why| matches!(why, Refusal::Impossible(_)));
            let is_idle = self.has(row.name) && refused.iter().all(Option::is_some);
            if let Some(why) = fault.or_else(|| refused.iter().flatten().next().filter(|_| is_idle)) {
                return Err(Error::usage(why));
            }
        }
        Ok(())
    }

    /// The options of a run.
    pub(crate) fn options(&self, rays: RaySource) -> Options {
        Options::new(rays).chosen(&self.values)
    }

    /// The words that give these values: those that were given, and those that are not the defaults.
    pub(crate) fn words(&self) -> Vec<String> {
        let default = Choices::default();
        let mut words = Vec::new();
        for row in rows::<S>() {
            match row.get(&self.values) {
                Value::Nothing | Value::Flag(false) => {}
                value if value == row.get(&default) && !self.has(row.name) => {}
                Value::Flag(true) => words.push(format!("--{}", row.name)),
                value => words.extend([format!("--{}", row.name), value.to_string()]),
            }
        }
        words
    }
}

/// As members of an object.
impl<S: Group> Serialize for ChoiceArgs<S> {
    fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
        serializer.collect_map(rows::<S>().filter_map(|row| Some((row.key(), row.recorded(&self.values)?))))
    }
}

impl<S: Group> FromArgMatches for ChoiceArgs<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut args = Self { values: Choices::default(), given: Vec::new(), group: PhantomData };
        args.update_from_arg_matches(matches)?;
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for row in rows::<S>() {
            let Some(source) = matches.value_source(row.name) else { continue };
            let value = match row.values {
                Values::Switch => Some(matches.get_flag(row.name).to_string()),
                _ => matches.get_one::<String>(row.name).cloned(),
            };
            if source == ValueSource::CommandLine {
                self.given.push(row.name);
            }
            if let Some(Err(why)) = value.map(|value| row.set(&mut self.values, &value)) {
                return Err(clap::Error::raw(clap::error::ErrorKind::ValueValidation, why));
            }
        }
        Ok(())
    }
}

impl<S: Group> Args for ChoiceArgs<S> {
    fn augment_args(command: Command) -> Command {
        command.args(rows::<S>().map(|row| match S::HEADING {
            Some(heading) => arg(row).help_heading(heading),
            None => arg(row),
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// As its values: whether they were given does not matter.
impl<S> fmt::Debug for ChoiceArgs<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.values.fmt(f)
    }
}

/// Refuses what does not go together, and options that were given and would have no effect.
pub(crate) fn check(choices: &Choices, is_given: impl Fn(&str) -> bool) -> Result<(), Error> {
    for row in ROWS {
        match (row.refused)(choices) {
            Some(Refusal::Idle(_)) if !is_given(row.name) => {}
            Some(why) => return Err(Error::usage(why)),
            None => {}
        }
    }
    Ok(())
}

/// The option of a row.
fn arg(row: &'static Row) -> Arg {
    let arg = Arg::new(row.name).long(row.name).visible_aliases(row.alias).help(row.help);
    let arg = match row.values {
        Values::Switch => return arg.action(ArgAction::SetTrue),
        Values::Names(names) => {
            arg.value_name(row.name.to_uppercase()).value_parser(PossibleValuesParser::new(names()))
        }
        Values::Whole(least, most) => {
            let number = whole::<u64>(least.into(), most.into());
            let parser = move |text: &str| number(text).map(|_| text.to_owned());
            arg.value_name("N").allow_negative_numbers(true).value_parser(parser)
        }
        Values::Cells => {
            let parser = |text: &str| text.parse::<GridSize>().map(|_| text.to_owned());
            arg.value_name("auto|N|NX,NY,NZ").allow_hyphen_values(true).value_parser(parser)
        }
    };
    // Fragment programs append to no lists of live rays.
    let arg = if row.name == "schedule" { arg.default_value_if("mapping", "fragment", "second") } else { arg };
    // Where the default depends on others, the help says it.
    if row.help.contains("[default") { arg } else { arg.default_value(row.get(&Choices::default()).to_string()) }
}

/// These options, and those of a run that a link sets: for what cannot be combined with any of them.
pub(crate) fn with_linked(own: &[&'static str]) -> Vec<&'static str> {
    let linked = rows::<Tracing>().chain(rows::<Sampling>()).filter(|row| row.is_linked);
    own.iter().copied().chain(linked.map(|row| row.name)).collect()
}

// Defaults are those of the paper where passes are stepped or recorded, and the fastest where only an image or hits are
// asked for.

/// The value for the fastest schedule.
const AUTO: &str = "auto";

/// `--schedule` of a command of which only an image or hits are asked for, unless its other options ask for passes.
pub(crate) fn fastest_schedule(arg: Arg) -> Arg {
    let names: Vec<&str> = [AUTO].into_iter().chain(ScheduleKind::ALL.iter().map(|kind| kind.name())).collect();
    let fastest = ScheduleKind::Fused.name();
    let parser = PossibleValuesParser::new(names).map(move |name| if name == AUTO { fastest.into() } else { name });
    let of_passes = ["passes_csv", "trace_json", "steps-per-pass"];
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
