//! Plans a run of a user's program.

use std::sync::Arc;

use crate::options::folder::Folder;
use crate::options::{Accelerator, Options};
use crate::plan::over::Over;
use crate::plan::{Limits, Plan, PlanError};
use crate::scene_data::{Contents, SceneData};
use crate::shader::ShaderError;

/// Plans the program of this folder.
pub(in crate::programs) fn plan(
    folder: &Arc<Folder>,
    options: &Options,
    limits: &Limits,
) -> Result<(Plan, SceneData), PlanError> {
    let own = super::read(folder).map_err(ShaderError::Mistake)?;
    let data = SceneData::from(Contents { inputs: own.inputs.clone(), ..Contents::default() });
    let run = Over {
        program: own.program,
        schedule: own.schedule.clone(),
        sizes: &own.sizes,
        accelerator: Accelerator::None,
    };
    Ok((run.plan(&data, options, limits)?, data))
}
