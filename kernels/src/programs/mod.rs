//! Programs: the kernels of each, with their rows, streams and schedules.

pub mod closest_hit;
pub mod grid_build;
pub mod light;
pub mod own;
pub mod path;
pub mod photons;
pub mod primitives;
pub mod sort;

use raystep_scenes::Scene;

use crate::options::{Choices, Integrator, Options, ProgramName};
use crate::plan::{Limits, Plan, PlanError, check_choices};
use crate::program::Program;
use crate::scene_data::SceneData;
use crate::shader::Mistake;
use crate::tables::stream::{Stream, StreamData};
pub(crate) use closest_hit::plan::Built;
use closest_hit::plan::Tracer;

type Planner = fn(&Scene, &Options, &Limits) -> Result<(Plan, SceneData), PlanError>;

/// A program as the rest of raystep finds it.
pub struct Registered {
    /// Its name in the option `--program`.
    pub name: ProgramName,
    /// The values of `--integrator` that choose it.
    integrators: &'static [Integrator],
    /// What it is.
    program: fn() -> &'static Program,
    /// Plans a run of it, and prepares the data that it binds.
    plan: Planner,
    /// What `raystep run` does with it; `None` if it needs a scene.
    pub alone: Option<Alone>,
}

/// A program that needs no scene.
#[derive(Debug)]
pub struct Alone {
    /// The stream of its results.
    pub results: Stream,
    /// Whether they are those of the same computation on the host.
    pub are_right: fn(&Options, &StreamData) -> bool,
}

/// Every program.
static REGISTRY: [Registered; 6] = [
    Registered {
        name: ProgramName::ClosestHit,
        integrators: &[Integrator::Local],
        program: || &closest_hit::PROGRAM,
        plan: trace,
        alone: None,
    },
    Registered {
        name: ProgramName::ClosestHit,
        integrators: &[Integrator::Shadows, Integrator::Whitted],
        program: || &light::PROGRAM,
        plan: trace,
        alone: None,
    },
    Registered {
        name: ProgramName::ClosestHit,
        integrators: &[Integrator::Path],
        program: || &path::PROGRAM,
        plan: trace,
        alone: None,
    },
    Registered {
        name: ProgramName::ClosestHit,
        integrators: &[Integrator::Photons],
        program: || &photons::PROGRAM,
        plan: trace,
        alone: None,
    },
    Registered {
        name: ProgramName::GridBuild,
        integrators: Integrator::ALL,
        program: || &grid_build::PROGRAM,
        plan: grid_build::plan::plan,
        alone: None,
    },
    sort::REGISTERED,
];

/// All programs.
pub fn all() -> impl Iterator<Item = &'static Program> {
    REGISTRY.iter().map(Registered::program)
}

impl Registered {
    /// The program.
    #[must_use]
    pub fn program(&self) -> &'static Program {
        (self.program)()
    }
}

/// How this program is registered, with the usual options.
#[must_use]
pub fn registered(name: ProgramName) -> &'static Registered {
    chosen(&Choices { program: name, ..Choices::default() })
}

/// The program with this name, with the usual options.
#[must_use]
pub fn named(name: ProgramName) -> &'static Program {
    registered(name).program()
}

/// The program that runs with these options.
///
/// # Errors
/// If it is a user's, and wrong.
pub fn program_of(options: &Options) -> Result<&'static Program, Box<Mistake>> {
    match &options.folder {
        Some(folder) => Ok(own::read(folder)?.program),
        None => Ok(chosen(&options.choices()).program()),
    }
}

/// The program that these choices name.
#[must_use]
pub fn chosen(choices: &Choices) -> &'static Registered {
    let is_it = |it: &&Registered| it.name == choices.program && it.integrators.contains(&choices.integrator);
    // There is one for all of them, as a test shows.
    REGISTRY.iter().find(is_it).unwrap_or(&REGISTRY[0])
}

fn trace(scene: &Scene, options: &Options, limits: &Limits) -> Result<(Plan, SceneData), PlanError> {
    closest_hit::plan::plan(tracer(options), scene, options, limits, None)
}

/// The program that traces rays with these options, and how it is planned.
fn tracer(options: &Options) -> Tracer {
    match options.integrator {
        Integrator::Local => {
            Tracer::of_rays(&closest_hit::PROGRAM, |options, features, _| closest_hit::schedule::of(options, features))
        }
        Integrator::Shadows | Integrator::Whitted => {
            Tracer::of_rays(&light::PROGRAM, |options, features, _| light::schedule(options, features))
        }
        Integrator::Path => Tracer::of_rays(&path::PROGRAM, |options, features, _| path::schedule(options, features)),
        Integrator::Photons => {
            Tracer { program: &photons::PROGRAM, others: photons::others, schedule: photons::schedule }
        }
    }
}

impl Plan {
    /// Plans a run and prepares the data that it binds. Uses no GPU.
    ///
    /// # Errors
    /// If the scene or the options do not fit `limits`, with the numbers.
    pub fn new(scene: &Scene, options: &Options, limits: &Limits) -> Result<(Self, SceneData), PlanError> {
        check_choices(options, limits)?;
        let (plan, data) = match &options.folder {
            Some(folder) => own::plan(folder, scene, options, limits)?,
            None => (chosen(&options.choices()).plan)(scene, options, limits)?,
        };
        if let Some(by) = options.replaced.iter().find(|by| !plan.has_replaced(&by.kernel)) {
            let (kernel, file, program) = (&by.kernel, &by.file, plan.program.name);
            return Err(PlanError::Refused(format!(
                "--kernel {kernel}={file}: no kernel of {program} can be replaced"
            )));
        }
        Ok((plan, data))
    }

    /// Plans a run of rays through a grid that is built already, as the options ask for.
    pub(crate) fn through(
        scene: &Scene,
        options: &Options,
        limits: &Limits,
        built: Built,
    ) -> Result<(Self, SceneData), PlanError> {
        check_choices(options, limits)?;
        closest_hit::plan::plan(tracer(options), scene, options, limits, Some(built))
    }
}

/// The stream with this name, of any program: names are unique.
#[must_use]
pub fn stream(name: &str) -> Option<Stream> {
    all().find_map(|program| program.stream(name))
}

/// Whether a stream holds the costs of rays, of any program.
#[must_use]
pub fn are_counters(stream: Stream) -> bool {
    all().any(|program| program.results.is_some_and(|results| results.counters == stream))
}

#[cfg(test)]
mod tests;
