//! Generates scenes from a few numbers.
//!
//! [`GENERATORS`] drives `raystep scene NAME` and its help: it is the only place with each generator's parameters,
//! defaults and ranges. Programs call the functions beside it.
//!
//! The same numbers give the same scene everywhere: random numbers come from a seeded SplitMix64, and the coordinates
//! of [`soup`], [`terrain`], [`icosphere`], [`whitted`], [`glass_ball`] and [`cornell_balls`] use only operations whose
//! rounding IEEE 754 prescribes (+ − × ÷ √), so they have the same bits on every machine. [`sphere_flake`], [`hair`],
//! [`tiny_in_room`] and [`ring`] also use sines and cosines, whose last bit may differ between systems.
//!
//! No generator allocates memory for more than [`MAX_TRIANGLES`].

mod caustics;
mod cornell;
mod draft;
mod flake;
mod hair;
mod icosphere;
mod random;
mod soup;
mod terrain;
mod tiny;
mod whitted;

pub use caustics::{cornell_balls, glass_ball, ring};
pub use cornell::{cornell_box, cornell_lamp};
pub use flake::sphere_flake;
pub use hair::hair;
pub use icosphere::icosphere;
pub(crate) use random::mix;
pub use soup::soup;
pub use terrain::terrain;
pub use tiny::tiny_in_room;
pub use whitted::whitted;

use crate::Scene;
use std::ops::RangeInclusive;

/// Maximum number of triangles: about 7 GiB of positions, more than any adapter can bind.
pub const MAX_TRIANGLES: u64 = 200_000_000;

/// Why a scene was not generated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GenerateError {
    /// No generator has this name.
    #[error("there is no generator '{name}'; there are {known}")]
    UnknownGenerator {
        /// The requested name.
        name: String,
        /// The names in [`GENERATORS`].
        known: String,
    },
    /// The generator does not take this parameter.
    #[error("{generator} has no parameter '{name}'; it takes {known}")]
    UnknownParameter {
        /// The generator's name.
        generator: &'static str,
        /// The given name.
        name: String,
        /// The names it takes.
        known: String,
    },
    /// A parameter is outside its range.
    #[error("{generator}: {parameter} is {value}, but must be from {min} to {max}")]
    OutOfRange {
        /// The generator's name.
        generator: &'static str,
        /// The parameter's name.
        parameter: &'static str,
        /// The given value.
        value: u64,
        /// Smallest allowed value.
        min: u64,
        /// Largest allowed value.
        max: u64,
    },
    /// Each parameter is in its range, but together they need too many triangles.
    #[error("{generator} would have {triangles} triangles with these parameters; the most is {MAX_TRIANGLES}")]
    TooManyTriangles {
        /// The generator's name.
        generator: &'static str,
        /// The number of triangles requested.
        triangles: u64,
    },
    /// The system refused the memory.
    #[error("{generator} needs {bytes} bytes of memory for {triangles} triangles, and the system refused them")]
    OutOfMemory {
        /// The generator's name.
        generator: &'static str,
        /// The number of triangles requested.
        triangles: u64,
        /// Bytes of their vertices and attributes.
        bytes: u64,
    },
}

/// An integer parameter of a generator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The option's name without dashes, e.g. `triangles`.
    pub name: &'static str,
    /// Help text, one line.
    pub summary: &'static str,
    /// Used if none is given.
    pub default: u64,
    /// Allowed values.
    pub range: RangeInclusive<u64>,
}

/// One row of [`GENERATORS`].
#[derive(Clone, Debug)]
pub struct Generator {
    /// The name on the command line.
    pub name: &'static str,
    /// Help text, one line.
    pub summary: &'static str,
    /// Its parameters, in the order in which `make` expects the values.
    pub parameters: &'static [Parameter],
    make: fn(&[u64]) -> Result<Scene, GenerateError>,
}

impl Generator {
    /// Makes the scene. Parameters that are not in `given` have their defaults; if one is given twice, the last value
    /// counts.
    ///
    /// # Errors
    /// An unknown parameter, one out of range, or too many triangles.
    pub fn make(&self, given: &[(&str, u64)]) -> Result<Scene, GenerateError> {
        let mut values: Vec<u64> = self.parameters.iter().map(|p| p.default).collect();
        for &(name, value) in given {
            let slot = self.parameters.iter().position(|p| p.name == name).ok_or_else(|| {
                let known = match self.parameters {
                    [] => "none".to_owned(),
                    some => some.iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
                };
                GenerateError::UnknownParameter { generator: self.name, name: name.to_owned(), known }
            })?;
            values[slot] = value;
        }
        (self.make)(&values)
    }
}

/// The generator with this name.
///
/// # Errors
/// An unknown name; the message lists all names.
pub fn find(name: &str) -> Result<&'static Generator, GenerateError> {
    GENERATORS.iter().find(|g| g.name == name).ok_or_else(|| GenerateError::UnknownGenerator {
        name: name.to_owned(),
        known: GENERATORS.iter().map(|g| g.name).collect::<Vec<_>>().join(", "),
    })
}

const SEED: Parameter =
    Parameter { name: "seed", summary: "start of the random numbers", default: 1, range: 0..=u64::MAX };

/// Every generator, in the order in which help lists them.
pub const GENERATORS: &[Generator] = &[
    Generator {
        name: "cornell-box",
        summary: "the paper's box: 26 triangles, one point light",
        parameters: &[],
        make: |_| Ok(cornell_box()),
    },
    Generator {
        name: "cornell-lamp",
        summary: "the same box, with a glowing square in its ceiling instead of the light",
        parameters: &[],
        make: |_| Ok(cornell_lamp()),
    },
    Generator {
        name: "soup",
        summary: "small triangles scattered evenly in a unit cube",
        parameters: &[soup::TRIANGLES, SEED],
        make: |v| soup(v[0], v[1]),
    },
    Generator {
        name: "terrain",
        summary: "mountains and lakes: a height field with smooth normals and vertex colours",
        parameters: &[terrain::TRIANGLES, SEED],
        make: |v| terrain(v[0], v[1]),
    },
    Generator {
        name: "sphere-flake",
        summary: "spheres that carry nine smaller spheres each (Haines 1987)",
        parameters: &[flake::DEPTH, flake::SUBDIVISIONS],
        make: |v| sphere_flake(v[0], v[1]),
    },
    Generator {
        name: "hair",
        summary: "a ball of long thin ribbons, the worst case for boxes along the axes",
        parameters: &[hair::STRANDS, SEED],
        make: |v| hair(v[0], v[1]),
    },
    Generator {
        name: "tiny-in-room",
        summary: "a small finely tessellated object in a very large room",
        parameters: &[tiny::TRIANGLES, tiny::RATIO],
        make: |v| tiny_in_room(v[0], v[1]),
    },
    Generator {
        name: "icosphere",
        summary: "a closed unit sphere whose triangles share their corners bit for bit",
        parameters: &[icosphere::SUBDIVISIONS],
        make: |v| icosphere(v[0]),
    },
    Generator {
        name: "whitted",
        summary: "a glass ball and a mirror over a checkered floor (Whitted 1980)",
        parameters: &[whitted::SUBDIVISIONS],
        make: |v| whitted(v[0]),
    },
    Generator {
        name: "glass-ball",
        summary: "a glass ball above a floor, under a small lamp (Purcell et al. 2003)",
        parameters: &[caustics::SUBDIVISIONS],
        make: |v| glass_ball(v[0]),
    },
    Generator {
        name: "ring",
        summary: "a metal ring on a floor, beside a small lamp (Purcell et al. 2003)",
        parameters: &[caustics::SIDES],
        make: |v| ring(v[0]),
    },
    Generator {
        name: "cornell-balls",
        summary: "the Cornell box with a lamp, a mirror ball and a glass ball (Purcell et al. 2003)",
        parameters: &[caustics::SUBDIVISIONS],
        make: |v| cornell_balls(v[0]),
    },
];
