//! Passes that a dump omits, and their numbers.

use raystep_kernels::plan::Plan;
use raystep_kernels::program::Results;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Kernel, ScheduleKind, Stream};

use crate::session::Running;

/// Why a pass is omitted.
pub(super) const NOT_NEEDED: &str = "it changes none of the requested streams";

/// Whether a stream's values require shading: only shading writes it, shading changes it, or, with the fused kernel, it
/// holds the rays that are generated for shading.
pub(super) fn needs_shading(stream: Stream, results: &Results, schedule: ScheduleKind) -> bool {
    let is_ray = [results.origin, results.direction].contains(&stream);
    [results.t.stream, results.color, results.mean].contains(&stream) || is_ray && !schedule.is_stepped()
}

/// Passes of the full run that this one omits. They keep their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LeftOut {
    /// Before the first pass.
    pub(super) first: Option<Kernel>,
    /// After the last one.
    pub(super) last: Option<Kernel>,
}

impl LeftOut {
    pub(super) fn of(plan: &Plan) -> Self {
        let missing = |role| {
            let is_there = plan.variants.iter().any(|variant| variant.kernel.role() == role);
            plan.program.kernels().find(|kernel| kernel.role() == role && !is_there)
        };
        Self { first: missing(Role::Source), last: missing(Role::Finish) }
    }

    /// Offset of the number of the renderer's first pass.
    pub(super) fn before(self) -> usize {
        usize::from(self.first.is_some())
    }

    /// Number of passes of a completed run, including omitted ones.
    pub(super) fn count(self, running: &Running) -> usize {
        self.before() + running.renderer.pass_count() + usize::from(self.last.is_some())
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Limits, Options, RaySource};
    use raystep_scenes::generate;

    use super::*;

    /// A stream that is dumped without shading must exist, and equal that with shading, according to what kernels
    /// write.
    #[test]
    fn what_needs_no_shading_is_untouched_by_what_is_left_out() {
        let scene = generate::cornell_box();
        for (&schedule, &accelerator) in
            ScheduleKind::ALL.iter().flat_map(|s| Accelerator::ALL.iter().map(move |a| (s, a)))
        {
            for steps_per_pass in [1, 8] {
                let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 8, height: 8 };
                let shaded = Options { schedule, accelerator, steps_per_pass, counters: true, ..Options::new(rays) };
                let bare = Options { shade: false, ..shaded.clone() };
                let [with, without] =
                    [&shaded, &bare].map(|options| Plan::new(&scene, options, &Limits::CPU).expect("a plan").0);
                assert_eq!(LeftOut::of(&with), LeftOut { first: None, last: None });
                let left_out: Vec<Kernel> =
                    [LeftOut::of(&without).first, LeftOut::of(&without).last].into_iter().flatten().collect();
                let own = |kernel: &Kernel| without.variant(*kernel).is_some();
                let missing: Vec<_> = with.schedule.kernels().into_iter().filter(|k| !own(k)).collect();
                assert_eq!(missing, left_out, "{schedule} {accelerator}");
                let writes = |kernel: Option<Kernel>, stream| {
                    let variant = kernel.and_then(|kernel| with.variant(kernel));
                    variant.is_some_and(|v| v.written_streams().any(|written| written == stream))
                };
                let LeftOut { first, last } = LeftOut::of(&without);
                let results = with.program.results.expect("a program that traces rays");
                for planned in &with.streams {
                    // A first write does not matter if it is overwritten.
                    let is_written = without.schedule.kernels().into_iter().any(|k| writes(Some(k), planned.what));
                    let can_do_without = without.has_stream(planned.what)
                        && !writes(last, planned.what)
                        && (!writes(first, planned.what) || is_written);
                    assert_eq!(
                        needs_shading(planned.what, &results, schedule),
                        !can_do_without,
                        "{schedule} {accelerator}: {}",
                        planned.what.name()
                    );
                }
            }
        }
    }
}
