//! Compares two outcomes of one pass, ray by ray.

use raystep_kernels::executor::cpu::CpuError;
use raystep_kernels::plan::Plan;
use raystep_kernels::program::rounding::Ties;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::HIT_TRIANGLE;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::tables::stream::{Stream, StreamData};

use super::Rounding;

/// Number of rays whose neighbours are traced together, which limits the memory for them.
const TOGETHER: usize = 4096;

/// Layer of the `counters` stream: repeated tests of a triangle that was in an earlier cell's list, too.
const REPEATED: (Stream, usize) = (streams::COUNTERS, 2);

/// What the differences of a ray's components mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Floats differ within the rounding bound.
    Rounding,
    /// Floats differ by more, or integers differ, and f32 cannot tell which is right.
    Tie,
    /// The same, but f32 can tell.
    Breach,
}

/// A component of a ray that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Its stream.
    pub stream: Stream,
    /// Its layer there.
    pub layer: usize,
    /// The bits in the outcome under test.
    pub ours: u32,
    /// The twin's bits.
    pub twin: u32,
    /// Whether it is a float that differs within the rounding bound.
    pub is_allowed: bool,
}

/// A ray with differences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judged<'a> {
    /// The ray's index, y * width + x.
    pub ray: usize,
    /// What they mean together.
    pub verdict: Verdict,
    /// At least one, in the order of the streams.
    pub components: &'a [Component],
}

/// Maximum memory, in bytes, of [`Rounding::judge`] for a pass of this plan.
#[must_use]
pub fn judging_bytes(plan: &Plan) -> u64 {
    let rays = u64::from(plan.width) * u64::from(plan.height);
    let is_pixel = plan.features.eye_rays || plan.features.whole_paths;
    let components: u64 = plan.streams.iter().map(|s| s.what.layers() as u64).sum();
    // Streams before and after, the twin's, and the moved part; if the kernel generates rays, also a copy of the scene.
    let nearby = if is_pixel { rays } else { rays.min(TOGETHER as u64) } * 4 * (3 * components + 3);
    let scene: u64 = if is_pixel { plan.buffers.iter().map(|b| b.bytes).sum() } else { 0 };
    rays * size_of::<usize>() as u64 + nearby + scene
}

impl Rounding<'_> {
    /// Compares an outcome of the pass with the f32 twin's; `after` has both for every compared stream. `is_compared`
    /// selects components. `each` gets every ray that differs, in the order of their indices: first those that differ
    /// only by rounding, then the others.
    ///
    /// # Errors
    /// If there is not enough memory to run the twin for neighbouring rays.
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
        // Sets of elements have different sizes.
        let rays = layers.iter().map(|(_, _, ours, twin)| ours.len().min(twin.len())).max().unwrap_or(0);
        let hits = self.bound(streams::HIT, after.iter().map(|[_, twin]| *twin));
        let gather = |ray: usize, components: &mut Vec<Component>| {
            components.clear();
            let mut possible = None;
            for &(stream, layer, ours, twin) in &layers {
                let Some((&ours, &twin)) = ours.get(ray).zip(twin.get(ray)).filter(|(ours, twin)| ours != twin) else {
                    continue;
                };
                let hit = || hits.and_then(|s| s.layer(HIT_TRIANGLE).get(ray).copied()).unwrap_or(NO_TRIANGLE);
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

    /// Which of these rays may take another path by rounding alone; `after` has the streams after the pass.
    fn may_part(&self, rays: &[usize], after: &[&StreamData]) -> Result<Vec<bool>, CpuError> {
        // It depends on the kernel whether this is known for all of them or for none.
        match rays.iter().map(|&ray| self.is_undecided(ray)).collect() {
            Some(are) => Ok(are),
            None => self.are_nearly(rays, after),
        }
    }

    /// Whether only the number of repeated tests differs, because its search, which repeats the walk from the start,
    /// may begin in another cell.
    fn is_other_count(&self, ray: usize, components: &[Component]) -> bool {
        self.kernel.info().rounding.ties == Ties::Triangle
            && components
                .iter()
                .filter(|c| !c.is_allowed)
                .all(|c| (Some(c.stream), c.layer) == (self.kernel.stream(REPEATED.0), REPEATED.1))
            && self.walk_may_begin_elsewhere(ray)
    }
}
