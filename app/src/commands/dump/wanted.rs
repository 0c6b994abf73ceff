//! The requested streams, and how to obtain one that the run omits.

use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Limits, Options, ScheduleKind, Stream};

use crate::error::Error;

/// The streams to write; an error if a named stream is not part of the plan.
pub(super) fn streams(named: &[Stream], plan: &Plan, options: &Options) -> Result<Vec<Stream>, Error> {
    if named.is_empty() {
        return Ok(plan.streams.iter().map(|s| s.what).collect());
    }
    for &stream in named {
        if !plan.has_stream(stream) {
            let what = format!("stream {}", stream.name());
            let reason = plan.left_out.iter().find(|l| l.what == what).map_or("not needed", |l| l.reason);
            let tip = option_for(stream, options).map(|o| format!("; {o} adds it")).unwrap_or_default();
            return Err(Error::usage(format!("--stream {}: this run omits it: {reason}{tip}", stream.name())));
        }
    }
    Ok(named.to_vec())
}

/// An additional option with which a run has a stream that it omits, if there is one: found by planning with it.
fn option_for(stream: Stream, options: &Options) -> Option<&'static str> {
    type Change = (&'static str, fn(&mut Options));
    let changes: [Change; 6] = [
        ("--accelerator grid", |o| o.accelerator = Accelerator::Grid),
        ("--accelerator bvh", |o| o.accelerator = Accelerator::Bvh),
        ("--accelerator irregular", |o| o.accelerator = Accelerator::Irregular),
        ("--schedule compact", |o| o.schedule = ScheduleKind::Compact),
        ("--steps-per-pass 1", |o| o.steps_per_pass = 1),
        ("--spp 2", |o| o.samples.count = 2),
    ];
    // Which streams exist does not depend on the scene, and planning this one is fast.
    let scene = raystep_scenes::generate::cornell_box();
    let has_it = |change: fn(&mut Options)| {
        let mut options = options.clone();
        change(&mut options);
        options.shade |= options.samples.count > 1;
        Plan::new(&scene, &options, &Limits::CPU).is_ok_and(|(plan, _)| plan.has_stream(stream))
    };
    changes.into_iter().find(|(_, change)| has_it(*change)).map(|(option, _)| option)
}
