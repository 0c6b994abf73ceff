//! All hits of rays, in exact order: a ray looks for its next hit again and again, each time after the last one, so that what
//! it carries from one to the next is a triangle's id, however many it has.

use super::cast::{CastHit, Caster};
use super::error::RenderError;
use crate::options::Ray;
use crate::plan::PlanError;
use crate::shared::constants::NO_TRIANGLE;

/// Hits, ray after ray, and each ray's in the order in which it meets them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHits {
    /// The index of each hit's ray.
    pub rays: Vec<u64>,
    /// The hits. t is 0 where a ray starts on a surface and leaves it.
    pub hits: Vec<CastHit>,
}

/// How far [`Caster::cast_some`] has got in a slice of rays.
#[derive(Clone, Copy, Debug)]
pub struct AllHitsPlace {
    ray: usize,
    /// The triangle of that ray's last hit so far, and how many it had.
    last: u32,
    hits: usize,
    /// Rays that are traced at a time.
    batch: usize,
    most_hits: usize,
}

impl Default for AllHitsPlace {
    fn default() -> Self {
        Self::with_most(MOST_HITS)
    }
}

impl AllHitsPlace {
    /// Before the first ray, with so many hits at a time, and one for each ray that is traced at the time.
    #[must_use]
    pub fn with_most(hits: usize) -> Self {
        Self { ray: 0, last: NO_TRIANGLE, hits: 0, batch: usize::MAX, most_hits: hits.max(1) }
    }

    /// How many rays have all their hits.
    #[must_use]
    pub fn rays(&self) -> usize {
        self.ray
    }
}

/// Hits at a time, in about 100 MB.
const MOST_HITS: usize = 1 << 22;

impl Caster {
    /// All hits of these rays. With [`Options::all_hits`](crate::Options::all_hits) only.
    ///
    /// Every surface that a ray crosses is a hit, once, by increasing exact t. At edges and corners, and where a surface is seen
    /// edge-on, it is those of the ray whose origin is moved by an infinitesimal: so a closed surface is entered as often
    /// as it is left.
    ///
    /// ```
    /// use raystep_kernels::{Caster, Device, Options, Ray};
    /// use raystep_scenes::Scene;
    /// # pollster::block_on(async {
    /// let at = |z| [[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]];
    /// let scene = Scene::from_triangles(vec![at(0.0), at(1.0)]);
    /// let options = Options { all_hits: true, ..Caster::options() };
    /// let mut caster = Caster::new(scene, &options, &Device::Cpu(None)).await?;
    ///
    /// let found = caster.cast_all(&[Ray::new([0.0, 0.0, 3.0], [0.0, 0.0, -1.0])]).await?;
    /// assert_eq!(found.hits.iter().map(|hit| (hit.t, hit.triangle)).collect::<Vec<_>>(), [(2.0, 1), (3.0, 0)]);
    /// assert_eq!(found.rays, [0, 0]);
    /// # Ok::<(), raystep_kernels::RenderError>(())
    /// # }).unwrap();
    /// ```
    ///
    /// # Errors
    /// As for [`cast`](Self::cast), and if the caster is made for other results.
    pub async fn cast_all(&mut self, rays: &[Ray]) -> Result<AllHits, RenderError> {
        let (mut place, mut found) = (AllHitsPlace::default(), AllHits::default());
        while self.cast_some(rays, &mut place, &mut found).await? {}
        Ok(found)
    }

    /// As [`cast_all`](Self::cast_all), the next of them: takes a limited amount of memory however many hits there are. They are
    /// appended to `found`; `false` when there are no more. All calls for a slice of rays take the same place, which begins as
    /// [`AllHitsPlace::default`].
    ///
    /// # Errors
    /// As for `cast_all`.
    pub async fn cast_some(
        &mut self,
        rays: &[Ray],
        place: &mut AllHitsPlace,
        found: &mut AllHits,
    ) -> Result<bool, RenderError> {
        if !self.plan().features.all_hits {
            return Err(
                PlanError::Refused("this caster finds one hit of each ray: choose Options::all_hits".into()).into()
            );
        }
        let begin = place.ray.min(rays.len());
        let rays = &rays[begin..];
        // At the start, all are checked.
        let most = if begin == 0 && place.last == NO_TRIANGLE { rays.len() } else { place.batch };
        let needs = self.needs(&rays[..most.min(rays.len())]).map_err(|error| after(begin, error))?;
        self.make_room_for(needs).await?;
        let most = usize::try_from(self.batch()).unwrap_or(usize::MAX);
        let mut round = Round::new(&rays[..rays.len().min(place.batch).min(most)], (place.last, place.hits));
        while self.cast_round(&mut round).await? {
            let hits_left = place.most_hits.saturating_add(round.rays.len());
            if round.is_cut_to(hits_left) {
                continue;
            }
            // The one ray that is left has too many.
            (place.last, place.hits) = (round.last[0], round.hits_of(0));
            found.take(begin, &mut round);
            return Ok(true);
        }
        place.batch = round.rays.len().saturating_mul(2).max(1);
        place.ray = begin + round.rays.len();
        (place.last, place.hits) = (NO_TRIANGLE, 0);
        let is_all = round.rays.len() == rays.len();
        found.take(begin, &mut round);
        Ok(!is_all)
    }

    /// Finds the next hit of each ray that may have one; `false` if none has.
    async fn cast_round(&mut self, round: &mut Round<'_>) -> Result<bool, RenderError> {
        let rays: Vec<Ray> = round.going.iter().map(|&ray| round.rays[ray]).collect();
        let last: Vec<u32> = round.going.iter().map(|&ray| round.last[ray]).collect();
        let mut hits = Vec::new();
        self.cast_after(&rays, &last, &mut hits).await?;
        let mut hits = hits.into_iter();
        let triangles = usize::try_from(self.plan().triangles).unwrap_or(usize::MAX);
        let mut going = std::mem::take(&mut round.going);
        going.retain(|&ray| {
            let Some(hit) = hits.next().filter(CastHit::is_hit) else { return false };
            round.last[ray] = hit.triangle;
            round.hits[ray].push(hit);
            round.count += 1;
            // Each is crossed once, so this is the end even on a device that errs.
            round.hits_of(ray) < triangles
        });
        round.going = going;
        Ok(!round.going.is_empty())
    }
}

/// A ray's number counts from the first of all.
fn after(begin: usize, error: PlanError) -> PlanError {
    match error {
        PlanError::Ray { index, reason } => PlanError::Ray { index: begin + index, reason },
        error => error,
    }
}

/// Rays whose hits are being found.
struct Round<'a> {
    rays: &'a [Ray],
    /// Those that may have another hit.
    going: Vec<usize>,
    /// The triangle of each ray's last hit.
    last: Vec<u32>,
    hits: Vec<Vec<CastHit>>,
    /// Hits that the first ray had before.
    before: usize,
    /// The number of all hits.
    count: usize,
}

impl<'a> Round<'a> {
    /// The first ray has had its hits up to that on a triangle.
    fn new(rays: &'a [Ray], (last_of_first, before): (u32, usize)) -> Self {
        let mut last = vec![NO_TRIANGLE; rays.len()];
        last.iter_mut().take(1).for_each(|last| *last = last_of_first);
        Self { rays, going: (0..rays.len()).collect(), last, hits: vec![Vec::new(); rays.len()], before, count: 0 }
    }

    /// How many hits a ray has had so far.
    fn hits_of(&self, ray: usize) -> usize {
        self.hits[ray].len() + if ray == 0 { self.before } else { 0 }
    }

    /// Leaves later rays for another time until there are at most so many hits; `false` if one ray has more.
    fn is_cut_to(&mut self, most: usize) -> bool {
        while self.count > most {
            if self.rays.len() == 1 {
                return false;
            }
            self.rays = &self.rays[..self.rays.len() / 2];
            self.count -= self.hits.drain(self.rays.len()..).map(|hits| hits.len()).sum::<usize>();
            self.going.retain(|&ray| ray < self.rays.len());
        }
        true
    }
}

impl AllHits {
    /// Appends what was found.
    fn take(&mut self, begin: usize, round: &mut Round<'_>) {
        for (ray, hits) in (begin as u64..).zip(&mut round.hits) {
            self.rays.extend(std::iter::repeat_n(ray, hits.len()));
            self.hits.append(hits);
        }
    }
}
