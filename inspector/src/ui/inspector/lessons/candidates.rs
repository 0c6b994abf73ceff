//! What a ray may hit: each triangle by the kernels' own test in f32, and in f64 with a bound on f32's error.

use raystep_kernels::export::trace::Trace;
use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::triangle::{Shear, hit_triangle};
use raystep_lab::judge::{RAYS_A_BATCH, Traced};
use raystep_lab::reference::{Possible, candidates_of};

use crate::lesson::{Comparison, Fact, Name, Value, Wrong};
use crate::session::request::{Job, JobContext, JobFuture, Request, answered, job};
use crate::session::{Session, go_on};

/// The name of the engine's job.
pub(super) const FINDING: &str = "finding what the ray may hit";

/// The name of the search for a ray.
pub(super) const SEEKING: &str = "looking for a ray";

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
    pub(super) fn request(history: &Trace) -> Option<Request> {
        let ray = &history.rows.first()?.after;
        Some(Request::Job(FINDING, of_ray([ray.origin, ray.direction])))
    }

    /// Those of a ray, by the triangles that it may hit in f32, wherever they are.
    fn of(data: &SceneData, [origin, direction]: [[f32; 3]; 2], possible: &[Possible]) -> Self {
        // Nothing behind a triangle that is surely hit can be the nearest.
        let definite = possible.iter().filter(|p| p.is_definite).map(|p| p.t + p.t_bound);
        let by = definite.fold(f64::INFINITY, f64::min);
        let (o, d) = (Vec3::<f32>::from_f32(origin), Vec3::from_f32(direction));
        let shear = Shear::of(d);
        let near = possible.iter().filter(|p| p.t - p.t_bound <= by).map(|p| {
            let corners = data.corners(p.triangle);
            let found = hit_triangle::<f32>(data.features.triangle_rules(), o, d, &shear, corners);
            Candidate {
                triangle: p.triangle,
                t: found.is_hit.then_some(found.t),
                exact_t: [p.t, p.t_bound],
                weight: [p.u.min(p.v).min(1.0 - p.u - p.v), p.weight_bound],
            }
        });
        Self(near.collect())
    }

    /// Whether all of this holds for them.
    fn satisfy(&self, wanted: &[Comparison]) -> bool {
        let value_of = |name: &Name| match name {
            Name::Fact(fact) => self.fact(*fact).map_err(|why| Wrong::Unavailable { name: name.to_string(), why }),
            Name::Measured(of, _) => Err(Wrong::NotMeasured(of.clone())),
        };
        wanted.iter().all(|comparison| comparison.check(value_of).is_ok())
    }

    /// A value of them.
    pub(super) fn fact(&self, fact: Fact) -> Result<Value, String> {
        let all = &self.0;
        let at = |index: usize| -> Result<&Candidate, String> {
            all.get(index).ok_or_else(|| format!("the ray may hit {} triangles only", all.len()))
        };
        let single = |index| at(index)?.t.map(Value::single).ok_or_else(|| "the test in f32 misses it".into());
        Ok(match fact {
            Fact::TieCount => Value::count(all.len() as u64),
            Fact::TieHits => Value::count(all.iter().filter(|candidate| candidate.t.is_some()).count() as u64),
            Fact::TieFirst => Value::count(at(0)?.triangle.into()),
            Fact::TieFirstT => return single(0),
            Fact::TieFirstExact => Value::double(at(0)?.exact_t[0]),
            Fact::TieFirstWeight => Value::small(at(0)?.weight[0]),
            Fact::TieSecond => Value::count(at(1)?.triangle.into()),
            Fact::TieSecondT => return single(1),
            Fact::TieSecondExact => Value::double(at(1)?.exact_t[0]),
            Fact::TieSecondWeight => Value::small(at(1)?.weight[0]),
            Fact::TieGap => Value::small((at(0)?.exact_t[0] - at(1)?.exact_t[0]).abs()),
            Fact::TieBound => Value::small(at(0)?.exact_t[1] + at(1)?.exact_t[1]),
            _ => Value::small(at(0)?.weight[1].max(at(1)?.weight[1])),
        })
    }
}

fn of_ray(ray: [[f32; 3]; 2]) -> Job {
    job!(context, {
        let data = context.session.renderer().shared_data();
        let all = candidates_of(&data.vertices, &[ray]).await.pop().unwrap_or_default();
        answered(Candidates::of(&data, ray, &all.possible))
    })
}

/// What a step wants of a ray that it looks for.
#[derive(Clone)]
pub(super) struct Sought {
    /// Where to look first, if not in the middle of the image.
    pub(super) near: Option<[u32; 2]>,
    /// What holds for the triangles that it may hit.
    pub(super) wanted: Vec<Comparison>,
    /// A row of its history that the step goes to: its number, from 1, among those whose reason contains a text.
    pub(super) row: Option<(usize, String)>,
}

impl Sought {
    /// The request for the nearest such ray; the answer is its pixel, an `Option<[u32; 2]>`. The rays and their history
    /// are those of the run at hand: directions and t differ between devices in their last bits, and a tie depends on
    /// them.
    pub(super) fn request(self) -> Request {
        Request::Job(
            SEEKING,
            Box::new(move |context: JobContext<'_>| -> JobFuture<'_> {
                Box::pin(async move { answered(self.nearest(context).await?) })
            }),
        )
    }

    async fn nearest(&self, context: JobContext<'_>) -> Result<Option<[u32; 2]>, String> {
        let JobContext { session, progress, .. } = context;
        let traced = Traced::read(session.renderer()).await.map_err(|error| error.to_string())?;
        let (data, size) = (session.renderer().shared_data(), session.renderer().plan().size());
        let middle = self.near.unwrap_or([size.width / 2, size.height / 2]);
        let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| [x, y]));
        let mut rays: Vec<_> =
            pixels.take(traced.rays()).enumerate().map(|(i, pixel)| (pixel, traced.ray(i))).collect();
        rays.sort_by_key(|(pixel, _)| {
            [0, 1].map(|axis| u64::from(pixel[axis].abs_diff(middle[axis])).pow(2)).iter().sum::<u64>()
        });
        let mut done = 0;
        for batch in rays.chunks(RAYS_A_BATCH) {
            let given: Vec<_> = batch.iter().map(|(_, ray)| *ray).collect();
            let all = candidates_of(&data.vertices, &given).await;
            for ((pixel, ray), all) in batch.iter().zip(&all) {
                let is_like_that = Candidates::of(&data, *ray, &all.possible).satisfy(&self.wanted);
                if is_like_that && self.has_row(session, *pixel).await? {
                    return Ok(Some(*pixel));
                }
            }
            done += batch.len() as u64;
            if !progress(done, rays.len() as u64) {
                return Err("the search was cancelled".into());
            }
        }
        Ok(None)
    }

    async fn has_row(&self, session: &mut Session, [x, y]: [u32; 2]) -> Result<bool, String> {
        let Some((number, text)) = &self.row else { return Ok(true) };
        let history = session.follow([x, y], &mut go_on).await.map_err(|error| error.to_string())?;
        Ok(history.rows.iter().filter(|row| row.why.contains(text)).nth(number - 1).is_some())
    }
}
