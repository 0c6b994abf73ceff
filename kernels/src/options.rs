//! What a user asks for.

use std::fmt;
use std::str::FromStr;

use raystep_scenes::Camera;

use crate::grid::GridSize;

/// What keeps a ray from testing every triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accelerator {
    /// A uniform grid.
    #[default]
    Grid,
    /// Nothing: every ray tests every triangle (the paper's Table 3).
    None,
}

/// In which order kernels run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ScheduleKind {
    /// The paper's first strategy: intersect until no ray is active there, then traverse once.
    First,
    /// The paper's second: intersect and traverse in turn.
    #[default]
    Second,
}

/// The rules for planes, steps and hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Numerics {
    /// No missed, false or wrong hits but ties.
    #[default]
    Robust,
    /// As the paper has them, a measured baseline.
    Paper,
}

/// An option's value has no meaning.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{value:?} is not one of {expected}")]
pub struct ParseOptionError {
    value: String,
    expected: &'static str,
}

macro_rules! named {
    ($type:ident, $expected:literal, $($variant:ident $name:literal),*) => {
        impl $type {
            /// Every value.
            pub const ALL: &[Self] = &[$(Self::$variant),*];
            /// Its name in options and reports.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }
        }
        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
        impl FromStr for $type {
            type Err = ParseOptionError;
            fn from_str(value: &str) -> Result<Self, Self::Err> {
                match value {
                    $($name => Ok(Self::$variant),)*
                    _ => Err(ParseOptionError { value: value.into(), expected: $expected }),
                }
            }
        }
    };
}
named!(Accelerator, "grid, none", Grid "grid", None "none");
named!(ScheduleKind, "first, second", First "first", Second "second");
named!(Numerics, "robust, paper", Robust "robust", Paper "paper");

/// A ray in scene units: `origin + t * direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes; any length but 0.
    pub direction: [f32; 3],
}

/// Where rays come from.
#[derive(Clone, Debug, PartialEq)]
pub enum RaySource {
    /// One through the centre of each pixel.
    Camera {
        /// The camera.
        camera: Camera,
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// These. They fill texels row by row; the last row may be partly unused.
    Given(Vec<Ray>),
}

/// A run's options.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// `--accelerator`
    pub accelerator: Accelerator,
    /// `--schedule`
    pub schedule: ScheduleKind,
    /// `--numerics`
    pub numerics: Numerics,
    /// `--grid`
    pub grid: GridSize,
    /// Where rays come from.
    pub rays: RaySource,
    /// Shade the hits; without it, a run ends with the `hit` stream.
    pub shade: bool,
    /// Count cells, tests and repeated tests per ray.
    pub counters: bool,
    /// Time every pass, where the adapter can.
    pub timings: bool,
    /// `--keep-all`: leave nothing out, to see what leaving out saves.
    pub keep_all: bool,
}

impl Options {
    /// The defaults: grid, second, robust, shaded, nothing measured.
    #[must_use]
    pub fn new(rays: RaySource) -> Self {
        Self {
            accelerator: Accelerator::default(),
            schedule: ScheduleKind::default(),
            numerics: Numerics::default(),
            grid: GridSize::default(),
            rays,
            shade: true,
            counters: false,
            timings: false,
            keep_all: false,
        }
    }
}
