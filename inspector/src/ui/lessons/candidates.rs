//! What a ray may hit: each triangle by the kernels' own test in f32, and in f64 with a bound on f32's error.

use std::any::Any;

use raystep_kernels::export::trace::Trace;
use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::shared::triangle::{Shear, hit_triangle};
use raystep_lab::reference::candidates_of;

use crate::session::request::{Job, JobContext, JobFuture, Request};

/// The name of the engine's job.
pub(super) const FINDING: &str = "finding what the ray may hit";

/// A triangle that a ray may hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// Its index.
    pub(super) triangle: u32,
    /// t by the kernels' test; `None` if that misses.
    pub(super) t: Option<f32>,
    /// t in f64, and the bound on f32's error of it.
    pub(super) exact_t: [f64; 2],
    /// The smallest of the three barycentric weights in f64, and the bound on f32's error of it. Below 0, the ray passes
    /// beside the triangle.
    pub(super) weight: [f64; 2],
}

/// The triangles that a ray may hit, by index.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Candidates(pub(super) Vec<Candidate>);

impl Candidates {
    /// The request for a ray; the answer is `Candidates`.
    pub(super) fn request(life: &Trace) -> Option<Request> {
        let ray = &life.rows.first()?.after;
        Some(Request::Job(FINDING, job(ray.origin, ray.direction)))
    }
}

fn job(origin: [f32; 3], direction: [f32; 3]) -> Job {
    Box::new(move |context: JobContext<'_>| -> JobFuture<'_> {
        Box::pin(async move {
            let data = context.session.renderer().shared_data();
            let all = candidates_of(&data.vertices, &[[origin, direction]]).await.pop().unwrap_or_default().possible;
            // Nothing behind a triangle that is surely hit can be the nearest.
            let definite = all.iter().filter(|p| p.is_definite).map(|p| p.t + p.t_bound);
            let by = definite.fold(f64::INFINITY, f64::min);
            let (o, d) = (Vec3::<f32>::from_f32(origin), Vec3::from_f32(direction));
            let shear = Shear::of(d);
            let near = all.iter().filter(|p| p.t - p.t_bound <= by).map(|p| {
                let corners = data.corners(p.triangle);
                let found = hit_triangle::<f32>(data.features.triangle_rules(), o, d, &shear, corners);
                Candidate {
                    triangle: p.triangle,
                    t: found.is_hit.then_some(found.t),
                    exact_t: [p.t, p.t_bound],
                    weight: [p.u.min(p.v).min(1.0 - p.u - p.v), p.weight_bound],
                }
            });
            Ok(Box::new(Candidates(near.collect())) as Box<dyn Any + Send>)
        })
    })
}
