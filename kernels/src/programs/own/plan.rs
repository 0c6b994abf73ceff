//! Plans a run of a user's program.

use std::sync::Arc;

use raystep_scenes::Scene;

use super::OfScene;
use super::tables::MOST_BYTES;
use crate::options::folder::Folder;
use crate::options::reasons::Run;
use crate::options::{Accelerator, Options};
use crate::plan::over::Over;
use crate::plan::{Limits, Plan, PlanError};
use crate::scene_data::{Contents, SceneData};
use crate::shader::ShaderError;
use crate::tables::elements::{Elements, Size};

/// Plans the program of this folder; one that reads a scene reads this one.
pub(in crate::programs) fn plan(
    folder: &Arc<Folder>,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
) -> Result<(Plan, SceneData), PlanError> {
    let own = super::read(folder).map_err(ShaderError::Mistake)?;
    if let Some(of) = &own.scene {
        return with_scene(folder, of, scene, options, limits);
    }
    let data = SceneData::from(Contents { inputs: own.inputs.clone(), ..Contents::default() });
    let run = Over {
        program: own.program,
        schedule: own.schedule.clone(),
        sizes: &own.sizes,
        accelerator: Accelerator::None,
    };
    Ok((run.plan(&data, options, limits)?, data))
}

/// Plans the run of ours that the scene is prepared for, and then the user's over the same data.
fn with_scene(
    folder: &Arc<Folder>,
    of: &OfScene,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
) -> Result<(Plan, SceneData), PlanError> {
    let options = &of.options(options);
    let (base, mut data) = (of.base().plan)(scene, options, limits)?;
    let own = super::compiled(folder, Some(base.features)).map_err(ShaderError::Mistake)?;
    let mut sizes: Vec<(&'static Elements, Size)> = own.sizes.clone();
    for &(set, of) in &own.scene_sets {
        let size = base.sets.iter().find(|planned| planned.what.name == of).and_then(|planned| planned.size);
        let none = || PlanError::Refused(format!("{of} are counted in a run of {}", base.program.name));
        sizes.push((set, size.ok_or_else(none)?));
    }
    // Ours may begin with values of its own.
    data.inputs.clone_from(&own.inputs);
    let accelerator = base.accelerator;
    let run = Over { program: own.program, schedule: own.schedule.clone(), sizes: &sizes, accelerator };
    let plan = run.plan(&data, options, limits)?;
    let bytes: u64 = plan.streams.iter().map(|stream| stream.bytes).sum();
    if bytes > MOST_BYTES {
        let why = format!("its streams take {bytes} bytes: at most {MOST_BYTES} are allowed");
        return Err(PlanError::Refused(why));
    }
    let is_missing = |name: &str| !base.buffers.iter().any(|buffer| buffer.what == name);
    if let Some(buffer) = plan.buffers.iter().find_map(|b| own.program.buffer(b.what).filter(|b| is_missing(b.name))) {
        let run = Run { options, features: &base.features, accelerator };
        let why = (buffer.why_absent)(&run).1;
        return Err(PlanError::Refused(format!("{}: this run has no {}: {why}", own.program.name, buffer.name)));
    }
    Ok((plan, data))
}
