//! The engine's job that looks at the lanes of all passes: a second run, with the states of all rays after each.

use std::sync::Arc;

use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Options, RenderError, Renderer};
use raystep_lab::work::{Measure, PassLanes, Survey, Warp, costs};

use crate::session::request::{Job, JobContext, answered, job};
use crate::ui::panels::cost::source::{Counts, Sorted};

/// Its name, shown while it runs.
pub(in crate::ui::panels::cost) const SURVEYING: &str = "looking at the warps of all passes";
/// Most warps in the list.
const MOST_WARPS: usize = 500;

/// What it found.
pub(in crate::ui::panels::cost) struct Surveyed {
    pub(in crate::ui::panels::cost) edition: u64,
    pub(in crate::ui::panels::cost) lanes: usize,
    pub(in crate::ui::panels::cost) passes: Vec<PassLanes>,
    /// The warps with the most passes, slowest first.
    pub(in crate::ui::panels::cost) slowest: Vec<Warp>,
    /// Whether rays change warps, as they are listed anew in every pass.
    pub(in crate::ui::panels::cost) is_listed: bool,
    /// Cells or nodes and triangles of every ray; `None` in a run without counters.
    pub(in crate::ui::panels::cost) counts: Option<Counts>,
    /// Rays by the number of passes that processed them.
    pub(in crate::ui::panels::cost) by_passes: Arc<Sorted>,
}

/// Runs all passes again.
pub(super) fn survey(edition: u64, lanes: usize) -> Job {
    job!(job, {
        let JobContext { session, device, progress, .. } = job;
        let mut surveyed = async || {
            let options = Options { timings: false, keep_passes: false, ..session.options().clone() };
            let mut renderer = session.renderer().another(&options, &device).await?;
            let Some(mut survey) = Survey::new(renderer.plan(), lanes) else { return Ok(None) };
            let rays = renderer.plan().rays as usize;
            let mut before = tags(&renderer).await?;
            let mut work = turns(&renderer, rays).await?;
            while let Some(pass) = renderer.step().await? {
                let after = tags(&renderer).await?;
                // Only a kernel of several steps loops.
                let is_loop = pass.kernel.role() == Role::Walk;
                let now = if is_loop { turns(&renderer, rays).await? } else { None };
                let taken = now.as_ref().zip(work.as_ref()).map(|(now, work)| difference(now, work));
                survey.add(pass.kernel, &before, &after, taken.as_deref());
                before = after;
                work = now.or(work);
                let now = renderer.progress();
                if !progress(now.rays_decided, now.rays) {
                    return Err(RenderError::Cancelled { passes: renderer.pass_count() });
                }
            }
            let mut passes_of_rays = survey.passes_of_rays().to_vec();
            passes_of_rays.truncate(rays);
            Ok(Some(Surveyed {
                edition,
                lanes,
                slowest: survey.slowest(MOST_WARPS),
                is_listed: survey.is_listed(),
                counts: Counts::of(&renderer).await?,
                by_passes: Arc::new(Sorted::new(passes_of_rays)),
                passes: survey.passes().to_vec(),
            }))
        };
        let surveyed = surveyed().await.map_err(|error: RenderError| error.to_string())?;
        answered(surveyed.ok_or("this program has no rays")?)
    })
}

async fn tags(renderer: &Renderer) -> Result<Vec<u32>, RenderError> {
    let Some(states) = renderer.plan().program.state_stream() else { return Ok(Vec::new()) };
    Ok(renderer.values(states).await?.layer(STATE_TAG).to_vec())
}

/// Loop turns of every ray so far: cells or nodes, and tests. `None` in a run without counters.
async fn turns(renderer: &Renderer, rays: usize) -> Result<Option<Vec<u32>>, RenderError> {
    if !renderer.plan().features.many_steps {
        return Ok(None);
    }
    let Some(counters) = renderer.plan().counters() else { return Ok(None) };
    Ok(costs(&renderer.values(counters).await?, rays, Measure::Sum))
}

fn difference(now: &[u32], before: &[u32]) -> Vec<u32> {
    now.iter().zip(before).map(|(now, before)| now.saturating_sub(*before)).collect()
}
