//! The tracing options that all commands with rays share.

use clap::Args;
use raystep_kernels::{Accelerator, BuiltBy, GridSize, Keep, Numerics, Options, RaySource, ScheduleKind, Skip};

use super::{named, parse_grid, whole};
use crate::error::Error;

/// Tracing options except for the two that 'bench' combines itself.
#[derive(Args, Debug)]
#[command(next_help_heading = "Tracing")]
pub(crate) struct TuningArgs {
    /// Numerical rules: robust (no missed or wrong hit, except where f32 cannot decide between two triangles), or those
    /// of Mølhave's paper (paper), for comparison; with a grid, the paper's can lose rays that start outside it
    #[arg(long, default_value = "robust", value_parser = named(Numerics::ALL, Numerics::name))]
    pub(crate) numerics: Numerics,
    /// Number of grid cells along each axis, or along x, y and z; auto chooses it, and gives cells that list very many
    /// triangles a finer grid each, unless --skip is on or off [default: auto]
    #[arg(long, value_name = "auto|N|NX,NY,NZ", value_parser = parse_grid, allow_hyphen_values = true)]
    pub(crate) grid: Option<GridSize>,
    /// Skip over empty cells of the grid: if most cells are empty (auto), always (on) or never (off)
    #[arg(long, default_value = "auto", value_parser = named(Skip::ALL, Skip::name))]
    pub(crate) skip: Skip,
    /// Maximum steps per ray and pass with schedule compact [default: 8; for trace and dump 1, as in the paper]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1, 4096), allow_negative_numbers = true)]
    pub(crate) steps_per_pass: Option<u32>,
    /// Where to build the grid (--accelerator grid or irregular): on the host, or on the device that traces the rays; the
    /// result is the same. auto uses a GPU for irregular grids of at least 200,000 triangles, otherwise the host
    #[arg(long, default_value = "auto", value_parser = named(BuiltBy::ALL, BuiltBy::name))]
    pub(crate) build: BuiltBy,
    /// Include everything in the plan, to measure what omitting saves
    #[arg(long)]
    pub(crate) keep_all: bool,
}

impl TuningArgs {
    /// Refuses options that would have no effect with all of these.
    pub(crate) fn check(&self, accelerators: &[Accelerator], schedules: &[ScheduleKind]) -> Result<(), Error> {
        if !accelerators.contains(&Accelerator::Grid) {
            let chosen = accelerators.iter().map(|a| a.name()).collect::<Vec<_>>().join(", ");
            let all = [("--grid", self.grid() == GridSize::Auto), ("--skip on", self.skip != Skip::On)];
            if let Some((option, _)) = all.iter().find(|(_, is_default)| !is_default) {
                let why = if accelerators.contains(&Accelerator::Auto) {
                    "accelerator auto chooses its own".to_owned()
                } else {
                    format!("accelerator {chosen} has no such grid")
                };
                return Err(Error::usage(format!(
                    "{option} applies to a uniform grid, and {why}: omit it, or use --accelerator grid"
                )));
            }
        }
        if self.numerics == Numerics::Paper && accelerators.contains(&Accelerator::Irregular) {
            return Err(Error::usage(
                "--accelerator irregular: the paper has no rules for it; use --numerics robust, or --accelerator grid",
            ));
        }
        let is_grid = |a: &Accelerator| matches!(a, Accelerator::Grid | Accelerator::Irregular);
        if self.build == BuiltBy::Device && !accelerators.iter().any(is_grid) {
            return Err(Error::usage("--build device builds grids: use --accelerator grid or irregular"));
        }
        if self.skip == Skip::On && self.numerics == Numerics::Paper {
            return Err(Error::usage("--skip on: the paper's rules visit every cell; use --numerics robust"));
        }
        if let Some(steps) = self.steps_per_pass.filter(|&steps| steps > 1)
            && !schedules.contains(&ScheduleKind::Compact)
        {
            let chosen = schedules.iter().map(|s| s.name()).collect::<Vec<_>>().join(", ");
            return Err(Error::usage(format!(
                "--steps-per-pass {steps} applies to schedule compact, not to {chosen}: omit it, or use --schedule \
                 compact"
            )));
        }
        Ok(())
    }

    /// `--grid`
    pub(crate) fn grid(&self) -> GridSize {
        self.grid.unwrap_or_default()
    }

    /// The options of a run, with default accelerator and schedule.
    pub(crate) fn options(&self, rays: RaySource) -> Options {
        let defaults = Options::new(rays);
        Options {
            numerics: self.numerics,
            grid: self.grid(),
            skip: self.skip,
            build: self.build,
            steps_per_pass: self.steps_per_pass.unwrap_or(defaults.steps_per_pass),
            keep: Keep::all_if(self.keep_all),
            ..defaults
        }
    }
}
