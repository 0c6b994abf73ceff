//! Whether a run can have users' kernels in place of its own.

use crate::options::reasons::Run;
use crate::options::replacement::Replacement;
use crate::plan::PlanError;
use crate::program::{Program, Twin};
use crate::shader::Variant;

/// Checks that the run has every kernel that a user replaces, and that it can be replaced.
pub(super) fn check_replaced(program: &'static Program, variants: &[Variant], run: &Run<'_>) -> Result<(), PlanError> {
    for by in &run.options.replaced {
        let Replacement { kernel: name, file, .. } = &**by;
        let refused = |why: String| Err(PlanError::Refused(format!("--kernel {name}={file}: {why}")));
        let Some(kernel) = program.kernels().find(|kernel| kernel.name() == name) else {
            let names: Vec<&str> = variants.iter().map(|variant| variant.kernel.name()).collect();
            return refused(format!("no kernel is named {name}; this run has {}", names.join(", ")));
        };
        if !variants.iter().any(|variant| variant.kernel == kernel) {
            return refused(format!("this run does without {name}: {}", (kernel.info().why_absent)(run).1));
        }
        if kernel.course().is_none() || !matches!(kernel.info().twin, Twin::Element { .. }) {
            return refused(format!("the elements of {name} read each other, and such a kernel cannot be replaced"));
        }
        if run.features.fragments {
            return refused("a kernel is replaced as a compute shader: use --mapping compute".into());
        }
    }
    Ok(())
}
