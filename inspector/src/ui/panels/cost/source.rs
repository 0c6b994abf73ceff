//! Where costs come from: the run's counters after the current pass, or a second run that counts.

use std::sync::Arc;

use raystep_kernels::{Options, Progress, RenderError, Renderer};
use raystep_lab::work::{CostOrder, Measure, costs};
use serde::{Deserialize, Serialize};

use super::curve::Curve;
use super::spread::Spread;
use crate::session::request::{Job, JobContext, answered, flow, job};

/// The engine's job, named while it runs.
pub(super) const SORTING: &str = "sorting rays by cost";
/// The engine's job with a second run.
pub(super) const COUNTING: &str = "counting in a second run";

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) enum Shown {
    #[default]
    Sum,
    Cells,
    Triangles,
    Passes,
}

impl Shown {
    pub(super) const ALL: [(Self, &str, &str); 4] = [
        (Self::Sum, "sum", "cells or nodes visited plus triangles tested"),
        (Self::Cells, "cells", "cells or nodes visited by the ray"),
        (Self::Triangles, "triangles", "triangles tested against the ray"),
        (
            Self::Passes,
            "passes",
            "passes that processed the ray; their times are known for all rays together, not for each ray",
        ),
    ];

    /// What one of it is.
    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::Sum => "visits and tests",
            Self::Cells => "cells or nodes",
            Self::Triangles => "triangles",
            Self::Passes => "passes",
        }
    }
}

/// The costs that are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Of {
    /// The run and the edits that the costs depend on.
    pub(super) edition: u64,
    /// After this many passes; `None` after all.
    pub(super) place: Option<usize>,
    pub(super) shown: Shown,
}

/// Counters of every ray.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) cells: Vec<u32>,
    pub(super) triangles: Vec<u32>,
}

impl Counts {
    /// The current values; `None` in a run without counters.
    pub(super) async fn of(renderer: &Renderer) -> Result<Option<Self>, RenderError> {
        let Some(counters) = renderer.plan().counters() else { return Ok(None) };
        let (stream, rays) = (renderer.values(counters).await?, renderer.plan().rays as usize);
        let [cells, triangles] = [Measure::Cells, Measure::Triangles].map(|by| costs(&stream, rays, by));
        Ok(cells.zip(triangles).map(|(cells, triangles)| Self { cells, triangles }))
    }

    fn costs(&self, shown: Shown) -> Vec<u32> {
        match shown {
            Shown::Cells => self.cells.clone(),
            Shown::Triangles => self.triangles.clone(),
            Shown::Sum | Shown::Passes => {
                self.cells.iter().zip(&self.triangles).map(|(c, t)| c.saturating_add(*t)).collect()
            }
        }
    }
}

/// The rays in order.
pub(super) struct Sorted {
    pub(super) order: CostOrder,
    pub(super) curve: Curve,
    /// Fraction of the total cost in the most expensive 1% and 10%.
    pub(super) dearest: [f64; 2],
    pub(super) spread: Spread,
}

impl Sorted {
    pub(super) fn new(costs: Vec<u32>) -> Self {
        let order = CostOrder::new(costs);
        let dearest = [0.01, 0.1].map(|share| order.share_of_dearest(share));
        Self { curve: Curve::new(&order), spread: Spread::new(&order), dearest, order }
    }
}

/// An answer. Without rays, the session has moved on, or has no counters.
pub(super) struct Answer {
    pub(super) of: Of,
    pub(super) found: Option<(Arc<Counts>, Sorted)>,
    /// Whether a second run counted, without edits by hand.
    pub(super) is_again: bool,
}

/// What to count with.
pub(super) enum From {
    /// The session's own counters.
    Session,
    /// Known counters.
    Known(Arc<Counts>),
}

/// Sorts rays by cost.
pub(super) fn sort(of: Of, from: From) -> Job {
    job!(job, {
        let counts = match from {
            From::Known(counts) => Some(counts),
            From::Session => {
                let renderer = job.session.renderer();
                let is_there = match of.place {
                    Some(place) => job.session.place() == place,
                    None => renderer.next_kernel().is_none(),
                };
                let counts = if is_there { Counts::of(renderer).await } else { Ok(None) };
                counts.map_err(|error| error.to_string())?.map(Arc::new)
            }
        };
        let found = counts.map(|counts| {
            let sorted = Sorted::new(counts.costs(of.shown));
            (counts, sorted)
        });
        answered(Answer { of, found, is_again: false })
    })
}

/// Runs all passes again, up to the wanted place, with counters.
pub(super) fn count_again(of: Of) -> Job {
    job!(job, {
        let JobContext { session, scene, device, progress, .. } = job;
        let mut counted = async || {
            let wanted = Options { counters: true, timings: false, keep_passes: false, ..session.options().clone() };
            let mut renderer = if session.renderer().plan().counters().is_some() {
                session.renderer().another(&wanted, &device).await?
            } else {
                Renderer::new(scene, &wanted, &device).await?
            };
            let tell = |p: &Progress| flow(progress(p.rays_decided, p.rays));
            renderer.run_to(of.place.unwrap_or(usize::MAX), tell).await?;
            Counts::of(&renderer).await
        };
        let counts = counted().await.map_err(|error: RenderError| error.to_string())?;
        let found = counts.map(|counts| {
            let sorted = Sorted::new(counts.costs(of.shown));
            (Arc::new(counts), sorted)
        });
        answered(Answer { of, found, is_again: true })
    })
}
