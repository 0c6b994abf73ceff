//! Two outcomes of one pass, ray by ray.

use raystep_kernels::executor::cpu::CpuError;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::closest_hit::rounding::Ties;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::HIT_TRIANGLE;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::tables::stream::{Stream, StreamData};

use super::Rounding;

/// Rays whose neighbours are looked at together: a bound on the memory that takes.
const TOGETHER: usize = 4096;

/// Layer of the `counters` stream: tests of a triangle that an earlier cell held, too.
const REPEATED: (Stream, usize) = (streams::COUNTERS, 2);

/// What the differences of a ray's components mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Floats are off by no more than rounding may make of them.
    Rounding,
    /// They are off by more, or integers differ, and f32 cannot tell which is right.
    Tie,
    /// The same, and f32 can tell.
    Breach,
}

/// A component of a ray that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Its stream.
    pub stream: Stream,
    /// Its layer there.
    pub layer: usize,
    /// The bits of the outcome that is judged.
    pub ours: u32,
    /// The twin's.
    pub twin: u32,
    /// A float that is off by no more than rounding may make of it.
    pub is_allowed: bool,
}

/// A ray with differences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judged<'a> {
    /// The ray's place, y * width + x.
    pub ray: usize,
    /// What they mean together.
    pub verdict: Verdict,
    /// At least one, in the order of the streams.
    pub components: &'a [Component],
}

/// Most bytes of memory that [`Rounding::judge`] takes for a pass of this plan.
#[must_use]
pub fn judging_bytes(plan: &Plan) -> u64 {
    let rays = u64::from(plan.width) * u64::from(plan.height);
    let is_pixel = plan.features.eye_rays;
    let components: u64 = plan.streams.iter().map(|s| s.what.layers() as u64).sum();
    // Streams before and after, their twin's, and the part that is moved; where rays are the scene's own, that, too.
    let nearby = if is_pixel { rays } else { rays.min(TOGETHER as u64) } * 4 * (3 * components + 3);
    let scene: u64 = if is_pixel { plan.buffers.iter().map(|b| b.bytes).sum() } else { 0 };
    rays * size_of::<usize>() as u64 + nearby + scene
}

impl Rounding<'_> {
    /// Compares an outcome of the pass with the f32 twin's: of each stream that is compared, theirs and the twin's.
    /// `is_compared` says which components count. `each` gets every ray that differs: those with nothing but
    /// rounding first, by their place, then the others.
    ///
    /// # Errors
    /// Where the twin cannot run for rays next to those that part: the system has not the memory.
    pub fn judge(
        &self,
        after: &[[&StreamData; 2]],
        is_compared: impl Fn(Stream, usize) -> bool,
        mut each: impl FnMut(Judged<'_>),
    ) -> Result<(), CpuError> {
        let layers: Vec<_> = after
            .iter()
            .flat_map(|&[ours, twin]| (0..ours.stream.layers()).map(move |layer| (ours, twin, layer)))
            .filter(|(ours, _, layer)| is_compared(ours.stream, *layer))
            .map(|(ours, twin, layer)| (ours.stream, layer, ours.layer(layer), twin.layer(layer)))
            .collect();
        let rays = layers.iter().map(|(_, _, ours, twin)| ours.len().min(twin.len())).min().unwrap_or(0);
        let hits = after.iter().map(|[_, twin]| twin).find(|s| s.stream == streams::HIT);
        let gather = |ray: usize, components: &mut Vec<Component>| {
            components.clear();
            let mut possible = None;
            for &(stream, layer, ours, twin) in layers.iter().filter(|(_, _, ours, twin)| ours[ray] != twin[ray]) {
                let (ours, twin) = (ours[ray], twin[ray]);
                let hit = || hits.map_or(NO_TRIANGLE, |s| s.get(HIT_TRIANGLE, ray));
                let possible = possible.get_or_insert_with(|| self.tested(ray, hit()));
                let is_allowed = self.allows((stream, layer), ours, twin, possible.as_ref());
                components.push(Component { stream, layer, ours, twin, is_allowed });
            }
        };

        let (mut open, mut components) = (Vec::new(), Vec::new());
        for ray in 0..rays {
            gather(ray, &mut components);
            if components.iter().any(|c| !c.is_allowed) {
                open.push(ray);
            } else if !components.is_empty() {
                each(Judged { ray, verdict: Verdict::Rounding, components: &components });
            }
        }
        let ours: Vec<_> = after.iter().map(|[ours, _]| *ours).collect();
        for rays in open.chunks(TOGETHER) {
            for (&ray, may_part) in rays.iter().zip(self.may_part(rays, &ours)?) {
                gather(ray, &mut components);
                let is_tie = may_part || self.is_other_count(ray, &components);
                let verdict = if is_tie { Verdict::Tie } else { Verdict::Breach };
                each(Judged { ray, verdict, components: &components });
            }
        }
        Ok(())
    }

    /// Which of these rays rounding alone may send another way; `after` is where they went.
    fn may_part(&self, rays: &[usize], after: &[&StreamData]) -> Result<Vec<bool>, CpuError> {
        // All of them or none: it depends on the kernel.
        match rays.iter().map(|&ray| self.is_undecided(ray)).collect() {
            Some(are) => Ok(are),
            None => self.are_nearly(rays, after),
        }
    }

    /// The count of repeated tests walks from the start again, through another first cell perhaps.
    fn is_other_count(&self, ray: usize, components: &[Component]) -> bool {
        self.row().ties == Ties::Triangle
            && components.iter().filter(|c| !c.is_allowed).all(|c| (c.stream, c.layer) == REPEATED)
            && self.walk_may_begin_elsewhere(ray)
    }
}
