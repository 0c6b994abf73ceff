//! The options that subcommands share.

pub(crate) mod choices;
pub(crate) mod kernel;

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use raystep_kernels::Choices;
use raystep_kernels::options::mapping::{self, Mapping};
use raystep_kernels::options::scene_data;
use raystep_lab::{Machine, Size};
use raystep_scenes::LoadOptions;

use crate::error::Error;
use choices::{ChoiceArgs, Sampling, Tracing};
use kernel::KernelArgs;

/// What the scene may be for commands that also take programs.
pub(crate) const SCENE_OR_PROGRAM: &str = "The scene: a file that ends in .gltf, .glb, .obj, .ply or .stl, or a name, such \
     as cornell-box; or a program: a folder with program.toml, or FOLDER@SCENE";

/// The scene file.
#[derive(Args, Debug)]
pub(crate) struct SceneArgs {
    /// The scene: a file that ends in .gltf, .glb, .obj, .ply or .stl; or a name, such as cornell-box
    pub(crate) scene: PathBuf,
    /// Index of the scene in a file with several, counted from 0 [default: the file's default scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    pub(crate) scene_index: Option<usize>,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// Limits for reading a scene.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ReadArgs {
    /// Memory limit for reading a scene, including a copy of its textures for tracing, in bytes or with suffix K, M, G
    /// or T (KiB, MiB, GiB, TiB)
    #[arg(long, value_name = "SIZE", default_value = "8G", value_parser = parse_bytes, help_heading = "Scene and view")]
    pub(crate) max_memory: u64,
    /// Also read files outside the scene's folder that the scene refers to by '..' or symbolic links
    #[arg(long, help_heading = "Scene and view")]
    pub(crate) allow_outside: bool,
}

impl Default for ReadArgs {
    fn default() -> Self {
        Self { max_memory: LoadOptions::default().max_bytes, allow_outside: false }
    }
}

/// View and size.
#[derive(Args, Debug)]
#[command(next_help_heading = "Scene and view")]
pub(crate) struct ViewArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size, allow_hyphen_values = true)]
    pub(crate) size: Size,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) samples: ChoiceArgs<Sampling>,
}

/// The camera.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scene and view")]
pub(crate) struct CameraArgs {
    /// Index of a camera of the scene, counted from 0 [default: 0, or a camera that frames the scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true,
          conflicts_with_all = ["eye", "look_at", "up", "fov"])]
    pub(crate) camera: Option<usize>,
    /// Camera position
    #[arg(long, value_name = "X,Y,Z", requires = "look_at", allow_hyphen_values = true)]
    pub(crate) eye: Option<Vector>,
    /// Point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", requires = "eye", allow_hyphen_values = true)]
    pub(crate) look_at: Option<Vector>,
    /// Up direction of the camera [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", requires_all = ["eye", "look_at"], allow_hyphen_values = true)]
    pub(crate) up: Option<Vector>,
    /// Vertical angle of view in degrees [default: 40]
    #[arg(long, value_name = "DEG", requires_all = ["eye", "look_at"], allow_hyphen_values = true, value_parser = parse_fov)]
    pub(crate) fov: Option<f64>,
}

impl CameraArgs {
    /// The options that were given, with their values.
    pub(crate) fn words(&self) -> Vec<(&'static str, String)> {
        let vector = |Vector([x, y, z]): Vector| format!("{x},{y},{z}");
        let all = [
            ("--camera", self.camera.map(|index| index.to_string())),
            ("--eye", self.eye.map(vector)),
            ("--look-at", self.look_at.map(vector)),
            ("--up", self.up.map(vector)),
            ("--fov", self.fov.map(|degrees| degrees.to_string())),
        ];
        all.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    }
}

/// What a program of one's own sees of a scene.
#[derive(Args, Debug)]
#[command(next_help_heading = "Scene and view, of a program that reads a scene")]
pub(crate) struct SightArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = parse_size, allow_hyphen_values = true)]
    pub(crate) size: Size,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

/// Tracing options.
#[derive(Args, Debug)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) tracing: ChoiceArgs<Tracing>,
    #[command(flatten)]
    pub(crate) kernels: KernelArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

impl RunArgs {
    /// The choices of a run, whatever its view.
    pub(crate) fn values(&self) -> Choices {
        if self.kernels.kernels.is_empty() { self.tracing.values } else { self.tracing.through_the_grid() }
    }

    /// The choices of a run with this view.
    pub(crate) fn choices(&self, view: &ViewArgs) -> Choices {
        Choices { samples: view.samples.values.samples, ..self.values() }
    }

    /// The same on a device: one that only draws has defaults of its own.
    pub(crate) fn choices_on(&self, view: &ViewArgs, machine: &Machine) -> Choices {
        let choices = self.choices(view);
        match machine.gpu() {
            Some(gpu) if !gpu.computes => choices.drawn(|name| self.tracing.has(name)),
            _ => choices,
        }
    }

    /// Refuses options that would have no effect, or do not go together.
    pub(crate) fn check(&self, view: &ViewArgs) -> Result<(), Error> {
        let choices = self.choices(view);
        if self.device.device == DeviceKind::Cpu && choices.needs_gpu() {
            let is_drawn = choices.mapping != Mapping::Compute;
            return Err(Error::usage(if is_drawn { mapping::NO_GPU } else { scene_data::NO_GPU }));
        }
        choices::check(&choices, |name| self.tracing.has(name) || view.samples.has(name))
    }

    /// Where passes run.
    pub(crate) fn device(&self) -> DeviceArgs {
        let device = self.device.if_needed(self.tracing.values.needs_gpu());
        if self.kernels.kernels.is_empty() { device } else { device.for_users() }
    }
}

/// Where passes run.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Device")]
pub(crate) struct DeviceArgs {
    /// Where passes run: on a GPU adapter or on the CPU
    ///
    /// auto selects the best GPU, otherwise the CPU, which is faster than a software adapter. The CPU interprets WGSL of your
    /// own, so for that, auto selects a software adapter rather than the CPU.
    #[arg(long, value_enum, default_value_t = DeviceKind::Auto)]
    pub(crate) device: DeviceKind,
    /// Name of the GPU adapter, or part of it; see 'raystep info'
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

impl DeviceArgs {
    /// Where users' kernels run: on the CPU they are interpreted, so a GPU in software is faster.
    pub(crate) fn for_users(&self) -> Self {
        match self.device {
            DeviceKind::Auto => Self { device: DeviceKind::GpuFirst, ..self.clone() },
            _ => self.clone(),
        }
    }

    /// Where passes run: some need a GPU, if only one in software.
    pub(crate) fn if_needed(&self, needs_gpu: bool) -> Self {
        let mut device = self.clone();
        if needs_gpu && device.device == DeviceKind::Auto && device.adapter.is_none() {
            device.device = DeviceKind::Gpu;
        }
        device
    }
}

/// `--device`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DeviceKind {
    /// The best GPU, otherwise the CPU
    Auto,
    /// The best adapter, even if it is software
    Gpu,
    /// All CPU cores
    Cpu,
    /// The best adapter, even if it is software, otherwise the CPU
    #[value(skip)]
    GpuFirst,
}

/// `--quiet`
#[derive(Args, Clone, Debug)]
pub(crate) struct QuietArgs {
    /// Show no progress, notes or summary
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Parses `--max-memory`.
fn parse_bytes(value: &str) -> Result<u64, String> {
    let wrong = || "expected a size, such as 512M, 4G or a number of bytes".to_owned();
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

/// A parser that lists all names, for help and completions.
pub(crate) fn named<T>(all: &'static [T], name: fn(T) -> &'static str) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: std::error::Error + Send + Sync> + Copy + Send + Sync + 'static,
{
    PossibleValuesParser::new(all.iter().map(|&v| name(v)).collect::<Vec<_>>()).try_map(|value| value.parse::<T>())
}

/// A parser of integers, whose error states the range.
pub(crate) fn whole<T: TryFrom<u64> + Clone + Send + Sync + 'static>(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse::<u64>().ok().filter(|n| (least..=most).contains(n));
        let wanted = || match most {
            u64::MAX => format!("expected an integer of at least {least}"),
            _ => format!("expected an integer from {least} to {most}"),
        };
        number.and_then(|n| T::try_from(n).ok()).ok_or_else(wanted)
    }
}

/// Parses an index.
pub(crate) fn counted(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "expected an integer of at least 0".to_owned())
}

/// Parses `--fov`; its range is checked with the camera.
fn parse_fov(text: &str) -> Result<f64, &'static str> {
    text.parse().map_err(|_| WRONG_FOV)
}

/// The error for an angle out of range.
pub(crate) const WRONG_FOV: &str = "expected an angle between 0 and 180 degrees";

/// Most pixels per side, on any device.
const MOST_PIXELS: u32 = 32_768;

/// An integer of at least 1; an error with the range if it is out of range; `None` if it is not a number.
fn whole_number(text: &str, most: u32, of: &str) -> Option<Result<u32, String>> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let number = text.parse().ok().filter(|n| (1..=most).contains(n));
    Some(number.ok_or_else(|| format!("expected 1 to {most} {of}")))
}

/// Parses `--size`.
pub(crate) fn parse_size(value: &str) -> Result<Size, String> {
    let wrong = || "expected two integers separated by x, such as 640x480".to_owned();
    let (width, height) = value.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |text| whole_number(text, MOST_PIXELS, "pixels per side").unwrap_or_else(|| Err(wrong()));
    Ok(Size { width: side(width)?, height: side(height)? })
}

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vector(pub(crate) [f64; 3]);

impl FromStr for Vector {
    type Err = String;

    fn from_str(value: &str) -> Result<Self, String> {
        let wrong = || "expected three numbers separated by commas, such as 0,1.5,-3".to_owned();
        let numbers = value
            .split(',')
            .map(|part| part.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self(numbers.try_into().map_err(|_| wrong())?))
    }
}
