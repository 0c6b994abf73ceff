//! Plans a program without rays: over sets of elements of given sizes.

use super::absent;
use super::allocated::Allocated;
use super::budget::fit_bindings;
use super::check::PlanError;
use super::{Limits, Plan, PlannedSet, bound_by, variants};
use crate::options::{Accelerator, Options};
use crate::program::Program;
use crate::program::schedule::{MOST_OPEN_PASSES, MOST_PASSES, Schedule};
use crate::program::sizes::{TooMany, derive};
use crate::scene_data::SceneData;
use crate::shared::launch::MOST_ELEMENTS;
use crate::tables::elements::{Elements, Size};

/// A run of a program over sets of elements.
pub(crate) struct Over<'a> {
    pub(crate) program: &'static Program,
    pub(crate) schedule: Schedule,
    /// The sets whose sizes are known, and these; the first is the program's main set.
    pub(crate) sizes: &'a [(&'static Elements, Size)],
    /// The structure that is built; [`Accelerator::None`] if none is.
    pub(crate) accelerator: Accelerator,
}

/// So many elements of a set, one after the other.
pub(crate) fn in_rows(
    elements: &'static Elements,
    count: u64,
    limits: &Limits,
) -> Result<(&'static Elements, Size), TooMany> {
    let most = MOST_ELEMENTS.min(u64::from(limits.image_side).pow(2));
    let size = Size::folded(count, limits.image_side).filter(|_| count <= MOST_ELEMENTS);
    Ok((elements, size.ok_or(TooMany { elements: elements.name, count, most })?))
}

impl Over<'_> {
    /// Plans the run; `data` is what its kernels read.
    pub(crate) fn plan(self, data: &SceneData, options: &Options, limits: &Limits) -> Result<Plan, PlanError> {
        let Self { program, schedule, sizes, accelerator } = self;
        let mut known = vec![None; program.elements.len()];
        for (size, elements) in known.iter_mut().zip(program.elements) {
            *size = sizes.iter().find(|(set, _)| set.name == elements.name).map(|&(_, size)| size);
        }
        derive(program, &mut known, limits.image_side)?;
        let sets: Vec<_> = program.elements.iter().zip(known).map(|(&what, size)| PlannedSet { what, size }).collect();
        let variants = variants(program, &schedule, &data.features, &[])?;
        let sharing = fit_bindings(program, &variants, None, data.features.scene_data, limits)?;
        let bound = bound_by(&variants);
        let Allocated { sets, streams, buffers } = Allocated::of_sets(program, sets, &bound, data, limits)?;
        let size = sets[0].size.unwrap_or(Size { width: 1, height: 1, count: 0 });
        let mut plan = Plan {
            program,
            sets,
            image_side: limits.image_side,
            most_elements: limits.rays.min(limits.list_words(data.features.scene_data)).min(MOST_ELEMENTS),
            width: size.width,
            height: size.height,
            rays: u64::from(size.count),
            triangles: (data.vertices.len() / 9) as u64,
            accelerator,
            is_gpu: limits.is_gpu,
            features: data.features,
            pass_bound: match (program.files.is_empty(), schedule.is_open()) {
                (true, _) => schedule.steps.len() as u64,
                (false, true) => MOST_OPEN_PASSES,
                (false, false) => MOST_PASSES,
            },
            schedule,
            variants,
            sharing,
            drawn: None,
            streams,
            buffers,
            left_out: Vec::new(),
            turns: limits.turns_of_users(),
        };
        plan.left_out = absent(&plan, options);
        Ok(plan)
    }
}
