//! Plans a sort of random keys.

use raystep_scenes::Scene;

use super::{KEY, KEYS, PROGRAM, random_keys, schedule};
use crate::options::{Accelerator, MOST_ELEMENTS, Options};
use crate::plan::over::{Over, in_rows};
use crate::plan::{Limits, Plan, PlanError, check_buffer};
use crate::program::sizes::TooMany;
use crate::scene_data::{Contents, SceneData};
use crate::tables::elements::Size;
use crate::tables::stream::StreamData;

/// Plans the sort of as many keys as the options say, which are random and the same for the same seed.
pub(super) fn plan(_: &Scene, options: &Options, limits: &Limits) -> Result<(Plan, SceneData), PlanError> {
    let keys = options.elements;
    let most = u64::from(limits.image_side).pow(2);
    let too_many = TooMany { elements: KEYS.name, count: keys.into(), most };
    if keys > MOST_ELEMENTS {
        return Err(PlanError::TooManyKeys { keys, most: MOST_ELEMENTS });
    }
    let Size { width, height, .. } = Size::folded(keys.into(), limits.image_side).ok_or(too_many)?;
    let texels = width as usize * height as usize;
    check_buffer("given", KEY.bytes(texels as u64).unwrap_or(u64::MAX), limits)?;
    let mut bits = random_keys(keys, options.samples.seed);
    bits.resize(texels, 0);
    bits.extend(0..texels as u32);
    let inputs = vec![StreamData { stream: KEY, width, height, bits }];
    let data = SceneData::from(Contents { inputs, ..Contents::default() });
    let sizes = [in_rows(&KEYS, keys.into(), limits)?];
    let run = Over { program: &PROGRAM, schedule: schedule(keys), sizes: &sizes, accelerator: Accelerator::None };
    Ok((run.plan(&data, options, limits)?, data))
}
