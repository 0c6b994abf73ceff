//! The options that every subcommand shares, the same everywhere.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use raystep_kernels::{Accelerator, GridSize, Numerics, Options, RaySource, Sampler, Samples, ScheduleKind, Skip};
use raystep_lab::Size;
use raystep_scenes::LoadOptions;

use crate::error::Error;

/// Which file.
#[derive(Args, Debug)]
pub(crate) struct SceneArgs {
    /// The scene: glTF 2.0, .gltf or .glb
    pub(crate) scene: PathBuf,
    /// Which scene of a file that holds several, counted from 0 [default: the file's own]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    pub(crate) scene_index: Option<usize>,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// What reading a scene may do.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ReadArgs {
    /// Most memory that a scene may take to be read, the copy of its textures for tracing included: bytes, or with K,
    /// M, G or T so many KiB, MiB, GiB or TiB
    #[arg(long, value_name = "SIZE", default_value = "8G", value_parser = parse_bytes, help_heading = "Scene and view")]
    pub(crate) max_memory: u64,
    /// Also read files that the scene names outside of its own folder, by '..' or through links
    #[arg(long, help_heading = "Scene and view")]
    pub(crate) allow_outside: bool,
}

impl Default for ReadArgs {
    fn default() -> Self {
        Self { max_memory: LoadOptions::default().max_bytes, allow_outside: false }
    }
}

/// What is seen, and at which size.
#[derive(Args, Debug)]
#[command(next_help_heading = "Scene and view")]
pub(crate) struct ViewArgs {
    /// Pixels a row and rows
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size, allow_hyphen_values = true)]
    pub(crate) size: Size,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) samples: SampleArgs,
}

/// Samples a pixel.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Scene and view")]
pub(crate) struct SampleArgs {
    /// Samples a pixel: the mean of so many rays through it. 1 is the pixel's centre; with more, hits and all other
    /// streams but color and accumulated are those of the last sample's ray
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
          value_parser = whole::<u32>(1, u64::from(Samples::MOST)))]
    pub(crate) spp: u32,
    /// Where in the pixel they lie: evenly spread, a scrambled Sobol' sequence (sobol); independently (random)
    #[arg(long, default_value = "sobol", value_parser = named(Sampler::ALL, Sampler::name))]
    pub(crate) sampler: Sampler,
    /// Another seed puts them elsewhere; the same one gives the same picture
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true,
          value_parser = whole::<u32>(0, u64::from(u32::MAX)))]
    pub(crate) seed: u32,
}

impl From<SampleArgs> for Samples {
    fn from(args: SampleArgs) -> Self {
        Self { count: args.spp, sampler: args.sampler, seed: args.seed }
    }
}

impl SampleArgs {
    /// Refuses what would have no effect: whoever asks for it expects something else.
    pub(crate) fn check(self) -> Result<(), Error> {
        let all = [("--sampler random", self.sampler == Sampler::Random), ("--seed", self.seed != 0)];
        match all.iter().find(|(_, is_asked)| *is_asked) {
            Some((option, _)) if self.spp == 1 => Err(Error::usage(format!(
                "{option} is about several samples a pixel, and one lies in its centre: leave it out, or give --spp"
            ))),
            _ => Ok(()),
        }
    }
}

/// What is seen.
#[derive(Args, Debug)]
#[command(next_help_heading = "Scene and view")]
pub(crate) struct CameraArgs {
    /// One of the scene's cameras, counted from 0 [default: 0, or one that frames the scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true,
          conflicts_with_all = ["eye", "look_at", "up", "fov"])]
    pub(crate) camera: Option<usize>,
    /// A camera of your own: where it is
    #[arg(long, value_name = "X,Y,Z", requires = "look_at", allow_hyphen_values = true)]
    pub(crate) eye: Option<Vector>,
    /// … what it looks at
    #[arg(long, value_name = "X,Y,Z", requires = "eye", allow_hyphen_values = true)]
    pub(crate) look_at: Option<Vector>,
    /// … what is up [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", requires_all = ["eye", "look_at"], allow_hyphen_values = true)]
    pub(crate) up: Option<Vector>,
    /// … and its vertical angle of view in degrees [default: 40]
    #[arg(long, value_name = "DEG", requires_all = ["eye", "look_at"], allow_hyphen_values = true, value_parser = parse_fov)]
    pub(crate) fov: Option<f64>,
}

/// How rays are traced.
#[derive(Args, Debug)]
#[command(next_help_heading = "Tracing")]
pub(crate) struct RunArgs {
    /// What keeps a ray from testing every triangle: a uniform grid; a tree of boxes (bvh); nothing (none);
    /// auto: nothing for a few triangles, the grid where they fill the scene evenly, else the tree
    #[arg(long, default_value = "grid", value_parser = named(Accelerator::ALL, Accelerator::name))]
    pub(crate) accelerator: Accelerator,
    /// How a ray's walk is cut into passes: intersect until no ray is active there, then traverse once
    /// (first); both in turn (second); some steps a pass, and only for rays that still walk (compact); the
    /// whole walk in one (fused)
    #[arg(long, default_value = "compact", value_parser = named(ScheduleKind::ALL, ScheduleKind::name))]
    pub(crate) schedule: ScheduleKind,
    #[command(flatten)]
    pub(crate) tuning: TuningArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

/// What else decides how rays are traced: all but the two choices that 'bench' makes itself.
#[derive(Args, Debug)]
#[command(next_help_heading = "Tracing")]
pub(crate) struct TuningArgs {
    /// Rules for planes, steps and hits: no wrong hits but ties (robust), or the paper's, a baseline that
    /// wants the eye inside of the grid (else all rays miss)
    #[arg(long, default_value = "robust", value_parser = named(Numerics::ALL, Numerics::name))]
    pub(crate) numerics: Numerics,
    /// Cells of the grid: as many along each axis, or along x, y and z
    #[arg(long, value_name = "auto|N|NX,NY,NZ", default_value = "auto", value_parser = parse_grid,
          allow_hyphen_values = true)]
    pub(crate) grid: GridSize,
    /// Leap over empty cells of the grid: where most of them are empty (auto), always (on) or never (off)
    #[arg(long, default_value = "auto", value_parser = named(Skip::ALL, Skip::name))]
    pub(crate) skip: Skip,
    /// Most steps of a ray in one pass of the compact schedule [default: 8; for trace and dump 1, the paper's]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1, 4096), allow_negative_numbers = true)]
    pub(crate) steps_per_pass: Option<u32>,
    /// Leave nothing out of the plan, to see what leaving out saves
    #[arg(long)]
    pub(crate) keep_all: bool,
}

impl TuningArgs {
    /// Refuses what would have no effect with any of these: whoever asks for it expects something else.
    pub(crate) fn check(&self, accelerators: &[Accelerator], schedules: &[ScheduleKind]) -> Result<(), Error> {
        if !accelerators.contains(&Accelerator::Grid) {
            let chosen = accelerators.iter().map(|a| a.name()).collect::<Vec<_>>().join(", ");
            let all = [("--grid", self.grid == GridSize::Auto), ("--skip on", self.skip != Skip::On)];
            if let Some((option, _)) = all.iter().find(|(_, is_default)| !is_default) {
                let why = if accelerators.contains(&Accelerator::Auto) {
                    "accelerator auto decides by itself whether there is one".to_owned()
                } else {
                    format!("accelerator {chosen} uses none")
                };
                return Err(Error::usage(format!(
                    "{option} is about a grid, and {why}: leave it out, or name accelerator grid"
                )));
            }
        }
        if self.skip == Skip::On && self.numerics == Numerics::Paper {
            return Err(Error::usage("--skip on: the paper's rules go from cell to cell; use --numerics robust"));
        }
        if let Some(steps) = self.steps_per_pass.filter(|&steps| steps > 1)
            && !schedules.contains(&ScheduleKind::Compact)
        {
            let chosen = schedules.iter().map(|s| s.name()).collect::<Vec<_>>().join(", ");
            return Err(Error::usage(format!(
                "--steps-per-pass {steps} is for schedule compact, and this is {chosen}: leave it out, or name schedule compact"
            )));
        }
        Ok(())
    }

    /// A run's options, with the default accelerator and schedule.
    pub(crate) fn options(&self, rays: RaySource) -> Options {
        let defaults = Options::new(rays);
        Options {
            numerics: self.numerics,
            grid: self.grid,
            skip: self.skip,
            steps_per_pass: self.steps_per_pass.unwrap_or(defaults.steps_per_pass),
            keep_all: self.keep_all,
            ..defaults
        }
    }
}

/// Where passes run.
#[derive(Args, Debug)]
#[command(next_help_heading = "Device")]
pub(crate) struct DeviceArgs {
    /// A GPU adapter, or the kernels' CPU twins
    ///
    /// auto takes the best GPU, else the CPU: the twins are faster than a software adapter.
    #[arg(long, value_enum, default_value_t = DeviceKind::Auto)]
    pub(crate) device: DeviceKind,
    /// The GPU adapter with this in its name, see 'raystep info'
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

/// `--device`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DeviceKind {
    /// The best GPU, else the CPU
    Auto,
    /// The best adapter, be it software
    Gpu,
    /// The kernels' twins on all cores
    Cpu,
}

/// `--quiet`
#[derive(Args, Clone, Debug)]
pub(crate) struct QuietArgs {
    /// Show no progress, notes or summary
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Reads `--max-memory`.
fn parse_bytes(value: &str) -> Result<u64, String> {
    let wrong = || "a size is wanted, such as 512M, 4G or a number of bytes".to_owned();
    let digits = value.find(|c: char| !c.is_ascii_digit()).unwrap_or(value.len());
    let (number, unit) = value.split_at(digits);
    let shift = match unit.to_ascii_uppercase().as_str() {
        "" | "B" => 0,
        "K" | "KB" | "KIB" => 10,
        "M" | "MB" | "MIB" => 20,
        "G" | "GB" | "GIB" => 30,
        "T" | "TB" | "TIB" => 40,
        _ => return Err(wrong()),
    };
    let bytes = number.parse::<u64>().ok().and_then(|number| number.checked_mul(1 << shift));
    bytes.filter(|&bytes| bytes > 0).ok_or_else(wrong)
}

/// A parser that knows every value's name, for help and completions.
pub(crate) fn named<T>(all: &'static [T], name: fn(T) -> &'static str) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: std::error::Error + Send + Sync> + Copy + Send + Sync + 'static,
{
    PossibleValuesParser::new(all.iter().map(|&v| name(v)).collect::<Vec<_>>()).try_map(|value| value.parse::<T>())
}

/// A parser of whole numbers, whose error says which are right.
pub(crate) fn whole<T: TryFrom<u64> + Clone + Send + Sync + 'static>(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse::<u64>().ok().filter(|n| (least..=most).contains(n));
        let wanted = || match most {
            u64::MAX => format!("a whole number from {least} is wanted"),
            _ => format!("a whole number from {least} to {most} is wanted"),
        };
        number.and_then(|n| T::try_from(n).ok()).ok_or_else(wanted)
    }
}

/// Reads the number of one of several things.
pub(crate) fn counted(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "a whole number is wanted; the first one's is 0".to_owned())
}

/// Reads `--fov`; whether it is an angle that can be seen under is looked at with the camera.
fn parse_fov(text: &str) -> Result<f64, &'static str> {
    text.parse().map_err(|_| WRONG_FOV)
}

/// What is said where it is not.
pub(crate) const WRONG_FOV: &str = "an angle between 0 and 180 degrees is wanted";

/// Most pixels each way, on any device.
const MOST_PIXELS: u32 = 32_768;
/// Most cells of a grid along an axis.
const MOST_CELLS: u32 = 4096;

/// A whole number from 1; where it is out of range, an error that says the range. None where it is no number.
fn whole_number(text: &str, most: u32, of: &str) -> Option<Result<u32, String>> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let number = text.parse().ok().filter(|n| (1..=most).contains(n));
    Some(number.ok_or_else(|| format!("1 to {most} {of} are wanted")))
}

/// Reads `--size`.
pub(crate) fn parse_size(value: &str) -> Result<Size, String> {
    let wrong = || "two whole numbers with an x between them are wanted, such as 640x480".to_owned();
    let (width, height) = value.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |text| whole_number(text, MOST_PIXELS, "pixels each way").unwrap_or_else(|| Err(wrong()));
    Ok(Size { width: side(width)?, height: side(height)? })
}

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vector(pub(crate) [f64; 3]);

impl FromStr for Vector {
    type Err = String;

    fn from_str(value: &str) -> Result<Self, String> {
        let wrong = || "three numbers with commas between them are wanted, such as 0,1.5,-3".to_owned();
        let numbers = value
            .split(',')
            .map(|part| part.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self(numbers.try_into().map_err(|_| wrong())?))
    }
}

/// Reads `--grid`.
pub(crate) fn parse_grid(value: &str) -> Result<GridSize, String> {
    let wrong = || "auto, a number of cells, or one each for x, y and z are wanted, such as 32 or 32,8,32".to_owned();
    if value == "auto" {
        return Ok(GridSize::Auto);
    }
    let cells = value
        .split(',')
        .map(|part| whole_number(part, MOST_CELLS, "cells along an axis").unwrap_or_else(|| Err(wrong())))
        .collect::<Result<Vec<_>, _>>()?;
    match cells[..] {
        [n] => Ok(GridSize::Cells([n; 3])),
        [x, y, z] => Ok(GridSize::Cells([x, y, z])),
        _ => Err(wrong()),
    }
}
