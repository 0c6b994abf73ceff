//! What is traced to compare kernels: generated scenes, since no file may be at hand.

use raystep_kernels::options::mapping::Fragment;
use raystep_kernels::options::{Integrator, PhotonSort, Photons};
use raystep_kernels::{GridSize, Options, Order, RaySource, Sampler, Samples, named};
use raystep_scenes::{Camera, Scene, generate};

use super::as_fragments;
use crate::configuration::Configuration;
use crate::stability::Ceiling;
use crate::{Error, rays};

/// Rays in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The Cornell box from inside, a pixel each.
    Room,
    /// Rays with an end in it.
    Segments,
    /// A cloud of triangles from outside.
    Soup,
    /// A ball of glass and a mirror over a floor.
    Balls,
    /// A small object in a room so large that the irregular grid sets its walls aside.
    Knot,
}

named!(
    Place,
    Room "Cornell box",
    Segments "Cornell box, any hit",
    Soup "100 triangles from outside",
    Balls "glass and a mirror",
    Knot "a knot in a large room"
);

impl Place {
    /// In the room, a resolution at which the eye does not lie on a plane: there, f32 could not tell in which cell any
    /// ray begins.
    fn grid(self) -> GridSize {
        match self {
            Self::Room | Self::Segments => GridSize::Cells([7, 7, 9]),
            Self::Soup | Self::Balls | Self::Knot => GridSize::Auto,
        }
    }

    /// How many rays may go another way where f32's rounding decides.
    fn undecided(self) -> Ceiling {
        match self {
            Self::Segments => Ceiling { share: 0.5, because: "half of the segments end on a surface" },
            // An eighth of the rays are in the middle row or column, where they meet edges and planes of symmetric scenes.
            _ => Ceiling { share: 0.002, because: "twice what small images have in the tests of kernels" },
        }
    }

    fn scene(self) -> Result<Scene, Error> {
        Ok(match self {
            Self::Room | Self::Segments => generate::cornell_box(),
            Self::Soup => generate::soup(100, 4)?,
            Self::Balls => generate::whitted(0)?,
            Self::Knot => generate::tiny_in_room(200, 100)?,
        })
    }
}

/// A run to compare.
#[derive(Clone, Debug)]
pub(super) struct Traced {
    place: Place,
    configuration: Configuration,
    is_shaded: bool,
    integrator: Integrator,
    sort: PhotonSort,
    samples: u32,
    is_contracted: bool,
    is_exact: bool,
    how: Option<Fragment>,
    /// Most loop iterations a dispatch, if fewer than the device allows.
    pub(super) turns: Option<u32>,
}

impl Traced {
    pub(super) fn new(place: Place, configuration: Configuration) -> Self {
        Self {
            place,
            configuration,
            is_shaded: true,
            integrator: Integrator::Local,
            sort: PhotonSort::Scan,
            samples: 1,
            is_contracted: false,
            is_exact: false,
            how: None,
            turns: None,
        }
    }

    pub(super) fn unshaded(self) -> Self {
        Self { is_shaded: false, ..self }
    }

    pub(super) fn lit(self, integrator: Integrator) -> Self {
        Self { integrator, ..self }
    }

    pub(super) fn bitonic(self) -> Self {
        Self { sort: PhotonSort::Bitonic, ..self }
    }

    pub(super) fn sampled(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    pub(super) fn contracted(self) -> Self {
        Self { is_contracted: true, ..self }
    }

    pub(super) fn exactly(self) -> Self {
        Self { is_exact: true, ..self }
    }

    pub(super) fn in_parts(self) -> Self {
        Self { turns: Some(6), ..self }
    }

    pub(super) fn drawn(self, how: Fragment) -> Self {
        Self { how: Some(how), ..self }
    }

    pub(super) fn undecided(&self) -> Ceiling {
        self.place.undecided()
    }

    /// What is special about it, in words.
    pub(super) fn name(&self) -> String {
        let mut name = format!("{}, {}", self.configuration, self.place.name());
        let samples = format!(", {} samples", self.samples);
        let light = format!(", {}", self.integrator);
        let how = self.how.map(|how| format!(", {}", raystep_kernels::options::mapping::Mapping::Fragment(how)));
        for (is_so, words) in [
            (!self.is_shaded, ", not shaded"),
            (self.integrator != Integrator::Local, &light),
            (self.sort == PhotonSort::Bitonic, ", bitonic sort"),
            (self.samples > 1, &samples),
            (self.is_contracted, ", explicit fma"),
            (self.is_exact, ", exact order"),
            (self.turns.is_some(), ", in parts"),
            (self.how.is_some(), how.as_deref().unwrap_or_default()),
        ] {
            name += if is_so { words } else { "" };
        }
        name
    }

    /// The scene and the options.
    pub(super) fn make(&self) -> Result<(Scene, Options), Error> {
        let scene = self.place.scene()?;
        // Not a multiple of a workgroup; few enough rays for many passes of one step.
        let [width, height] = if self.samples > 1 { [11, 7] } else { [21, 13] };
        let rays = match self.place {
            Place::Segments => RaySource::Given(rays::segments(&scene, 200, 3)).until(1.0),
            Place::Soup => {
                let camera = Camera::framing(&scene.bounds());
                RaySource::Camera { camera, width, height }
            }
            _ => {
                let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
                RaySource::Camera { camera, width, height }
            }
        };
        let is_any_hit = self.place == Place::Segments;
        let sampler = if self.samples > Samples::BLOCK { Sampler::Random } else { Sampler::Sobol };
        let options = Options {
            integrator: self.integrator,
            photons: Photons { count: 300, sort: self.sort, nearest: 10, radius: 100, ..Photons::default() },
            counters: !is_any_hit,
            any_hit: is_any_hit,
            shade: self.is_shaded && !is_any_hit,
            contracted: self.is_contracted,
            order: if self.is_exact { Order::Exact } else { Order::Rounded },
            grid: self.place.grid(),
            samples: Samples { count: self.samples, sampler, seed: 5, first: 0 },
            ..self.configuration.of(&Options::new(rays))
        };
        Ok((
            scene,
            match self.how {
                Some(how) => as_fragments(how, options),
                None => options,
            },
        ))
    }
}
