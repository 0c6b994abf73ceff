//! Why a plan does without some of a program's rows.

use super::{Because, LeftOut, Plan};
use crate::options::Options;
use crate::options::keep::Item;
use crate::options::reasons::{Reason, Run};

/// Everything in the program's tables that the plan leaves out.
pub(crate) fn absent(plan: &Plan, options: &Options) -> Vec<LeftOut> {
    let mut all = Vec::new();
    let mut add = |what: String, (because, reason): Reason, item: Option<Item>| {
        // What the options do without, no item puts back.
        let item = item.filter(|_| because == Because::Scene);
        all.push(LeftOut { what, because, reason, item });
    };
    let run = Run { options, features: &plan.features, accelerator: plan.accelerator };
    let program = plan.program;
    for kernel in program.kernels().filter(|&kernel| plan.variant(kernel).is_none()) {
        add(format!("kernel {}", kernel.name()), (kernel.info().why_absent)(&run), None);
    }
    for stream in program.streams().filter(|&stream| !plan.has_stream(stream)) {
        add(format!("stream {}", stream.name()), (stream.info().why_absent)(&run), None);
    }
    for b in program.buffers.iter().filter(|b| !plan.buffers.iter().any(|p| p.what == b.name)) {
        add(format!("buffer {}", b.name), (b.why_absent)(&run), b.item);
    }
    all
}
