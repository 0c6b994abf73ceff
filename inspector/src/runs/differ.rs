//! The rays in which two kept runs differ.

use std::sync::Arc;

use raystep_kernels::numbers::real::ulps;
use raystep_kernels::shared::constants::INF;
use raystep_kernels::{StreamData, named};
use raystep_lab::flip::{Errors, errors, flip};

use super::outcome::Picture;
use crate::session::request::{Job, answered, job};

/// The engine's job, named while it runs.
pub const COMPARING: &str = "comparing kept runs";

/// What is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Aspect {
    /// The triangle that was hit.
    #[default]
    Triangle,
    /// The distance along the ray.
    Distance,
    /// The colour.
    Color,
    /// How different the pictures look.
    Flip,
}

named!(Aspect, Triangle "triangle", Distance "t", Color "colour", Flip "FLIP");

/// How two hits of a ray differ, in ascending order; also the values of a picture of [`Aspect::Triangle`].
pub const CLASSES: [&str; 4] = ["same bits", "same triangle, other t, u or v", "other triangle", "hit and miss"];

/// How many rays differ, and by how much.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Number of rays.
    pub rays: u64,
    /// Rays that hit in one run and miss in the other.
    pub hit_or_miss: u64,
    /// Rays that hit another triangle.
    pub triangle: u64,
    /// Rays that hit in both runs, with another t.
    pub t: u64,
    /// The largest difference of their t, in units in the last place of f32.
    pub max_ulps: u64,
    /// The largest difference of their t, in scene units.
    pub max_t: f64,
    /// Rays that hit the same triangle at the same t, with other weights.
    pub weights: u64,
    /// Pixels of another colour.
    pub color: u64,
    /// The largest difference of a channel, linear light.
    pub max_color: f32,
    /// The errors of channels, if the pictures have finite colours.
    pub errors: Option<Errors>,
    /// The mean of FLIP, if that was asked for.
    pub flip: Option<f64>,
}

/// The rays in which two runs differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Differences {
    /// Width and height.
    pub size: [u32; 2],
    /// How many rays differ in which way.
    pub counts: Counts,
    /// The rays that differ in the aspect, y * width + x, ascending.
    pub rays: Vec<u32>,
    /// A value per ray for the picture of the aspect: the index of its class; log10 of the difference of t; the largest
    /// difference of a channel; FLIP. [`INF`] where nothing differs, an infinity where only one run has a value.
    pub values: Vec<f32>,
}

impl Differences {
    /// The smallest and the largest finite value; `None` if nothing differs.
    #[must_use]
    pub fn range(&self) -> Option<[f32; 2]> {
        let finite = self.values.iter().copied().filter(|v| v.is_finite() && *v < INF);
        finite.fold(None, |range, v| Some(range.map_or([v; 2], |[lo, hi]: [f32; 2]| [lo.min(v), hi.max(v)])))
    }

    /// The next ray that differs after this one, in the order of the image; after the last, the first.
    #[must_use]
    pub fn next(&self, after: Option<[u32; 2]>) -> Option<[u32; 2]> {
        next_ray(&self.rays, self.size[0], after)
    }
}

/// The pixel of the next of some rays (y * width + x, ascending) after one; after the last, of the first.
#[must_use]
pub fn next_ray(rays: &[u32], width: u32, after: Option<[u32; 2]>) -> Option<[u32; 2]> {
    let at = after.map_or(0, |[x, y]| rays.partition_point(|&ray| ray <= y * width + x));
    let ray = rays.get(at).or(rays.first())?;
    Some([ray % width, ray / width])
}

/// The streams of one run.
struct Side<'a> {
    picture: &'a Picture,
    hit: &'a StreamData,
    t: &'a StreamData,
    color: Option<&'a StreamData>,
}

impl<'a> Side<'a> {
    fn of(picture: &'a Picture) -> Option<Self> {
        let results = picture.results;
        let [hit, t] = [results.triangle.stream, results.t.stream].map(|stream| picture.stream(stream));
        Some(Self { picture, hit: hit?, t: t?, color: picture.stream(results.color) })
    }

    fn rays(&self) -> usize {
        self.hit.width as usize * self.hit.height as usize
    }

    /// The triangle and t, if the ray hit.
    fn hit(&self, ray: usize) -> Option<(u32, f32)> {
        self.picture.results.hit(self.t, self.hit, ray)
    }

    fn weights(&self, ray: usize) -> [u32; 2] {
        self.picture.results.weights.map(|layer| self.hit.get(layer, ray))
    }

    fn picture(&self) -> Option<Vec<[f32; 3]>> {
        (0..self.rays()).map(|ray| Some(self.color(ray)?.map(f32::from_bits))).collect()
    }

    fn color(&self, ray: usize) -> Option<[u32; 3]> {
        self.color.map(|color| [0, 1, 2].map(|layer| color.get(layer, ray)))
    }
}

/// How one ray's hits differ: the class, and a value for the picture of distances.
fn hits_differ([a, b]: [&Side<'_>; 2], ray: usize, counts: &mut Counts) -> (usize, f32) {
    let (Some((ours, t)), Some((theirs, u))) = (a.hit(ray), b.hit(ray)) else {
        if a.hit(ray).is_none() && b.hit(ray).is_none() {
            return (0, INF);
        }
        counts.hit_or_miss += 1;
        return (3, f32::INFINITY);
    };
    let (mut class, mut distance) = (0, INF);
    if t.to_bits() != u.to_bits() {
        let apart = (f64::from(t) * a.picture.t_scale - f64::from(u) * b.picture.t_scale).abs();
        (counts.t, class) = (counts.t + 1, 1);
        counts.max_ulps = counts.max_ulps.max(ulps(t.to_bits(), u.to_bits()));
        counts.max_t = counts.max_t.max(apart);
        // -0 and 0 are other bits of the same number: the least of all differences.
        distance = apart.max(f64::from(f32::MIN_POSITIVE)).log10() as f32;
    } else if ours == theirs && a.weights(ray) != b.weights(ray) {
        (counts.weights, class) = (counts.weights + 1, 1);
    }
    if ours != theirs {
        (counts.triangle, class) = (counts.triangle + 1, 2);
    }
    (class, distance)
}

/// The largest difference of a channel, if a pixel's colours differ.
fn colors_differ([a, b]: [&Side<'_>; 2], ray: usize, counts: &mut Counts) -> Option<f32> {
    let (ours, theirs) = a.color(ray).zip(b.color(ray)).filter(|(ours, theirs)| ours != theirs)?;
    let apart = ours.into_iter().zip(theirs).map(|(a, b)| (f32::from_bits(a) - f32::from_bits(b)).abs());
    let largest = apart.fold(0.0, f32::max);
    counts.color += 1;
    counts.max_color = counts.max_color.max(largest);
    Some(largest)
}

/// Compares two pictures; `None` if they differ in size, or lack a stream.
#[must_use]
pub fn differences(a: &Picture, b: &Picture, aspect: Aspect) -> Option<Differences> {
    let (left, right) = (Side::of(a)?, Side::of(b)?);
    let size = a.size();
    if size != b.size() {
        return None;
    }
    let sides = [&left, &right];
    let mut counts = Counts { rays: left.rays() as u64, ..Counts::default() };
    let pictures = left.picture().zip(right.picture());
    let pictures = pictures.as_ref();
    counts.errors = pictures.and_then(|(a, b)| errors(a, b));
    let map = pictures.filter(|_| aspect == Aspect::Flip).and_then(|(a, b)| flip(a, b, size.map(|side| side as usize)));
    counts.flip = map.as_ref().map(|map| map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64);
    let (mut rays, mut values) = (Vec::new(), Vec::with_capacity(left.rays()));
    for ray in 0..left.rays() {
        let (class, distance) = hits_differ(sides, ray, &mut counts);
        let color = colors_differ(sides, ray, &mut counts);
        let (is_other, value) = match aspect {
            Aspect::Triangle => (class >= 2, if class == 0 { INF } else { class as f32 }),
            Aspect::Distance => (distance != INF, distance),
            Aspect::Color => (color.is_some(), color.unwrap_or(INF)),
            Aspect::Flip => {
                let value = map.as_ref().and_then(|map| map.get(ray).copied()).filter(|&value| value > 0.0);
                (value.is_some(), value.unwrap_or(INF))
            }
        };
        if is_other {
            rays.push(ray as u32);
        }
        values.push(value);
    }
    Some(Differences { size, counts, rays, values })
}

/// Compares two pictures in an engine. `question` comes back with the answer.
#[must_use]
pub fn job<Q: Send + 'static>(question: Q, a: Arc<Picture>, b: Arc<Picture>, aspect: Aspect) -> Job {
    job!(_, {
        let found = differences(&a, &b, aspect).ok_or("the runs have different sizes")?;
        answered((question, found))
    })
}

#[cfg(test)]
mod tests {
    use raystep_scenes::generate::cornell_box;

    use super::*;
    use crate::runs::outcome::tests::picture;
    use crate::settings::Settings;

    /// Sets a component of a ray.
    fn set(picture: &mut Picture, stream: usize, layer: usize, ray: usize, change: impl Fn(u32) -> u32) {
        let data = &mut picture.streams[stream];
        let at = layer * (data.width * data.height) as usize + ray;
        data.bits[at] = change(data.bits[at]);
    }

    #[test]
    fn every_kind_of_difference_is_counted_and_listed() {
        let a = picture(&cornell_box(), &Settings { size: [8, 8], ..Settings::default() });
        for aspect in Aspect::ALL {
            let same = differences(&a, &a, aspect).expect("the same size");
            let flip = (aspect == Aspect::Flip).then_some(0.0);
            let none = Counts { rays: 64, errors: Some(Errors::default()), flip, ..Counts::default() };
            assert_eq!((same.counts, same.rays.len()), (none, 0));
        }
        let mut b = a.clone();
        let at = |stream| a.streams.iter().position(|data| data.stream == stream).expect("kept");
        let results = a.results;
        let (hit, t, color) = (at(results.triangle.stream), at(results.t.stream), at(results.color));
        let inside = |ray: usize| results.hit(&a.streams[t], &a.streams[hit], ray).is_some();
        let hits: Vec<usize> = (0..64).filter(|&ray| inside(ray)).collect();
        let [other, far, miss, weights, both] = hits[10..15] else { panic!("five hits") };
        set(&mut b, hit, results.triangle.layer, other, |id| id + 1);
        set(&mut b, t, results.t.layer, far, |bits| bits + 3);
        set(&mut b, hit, results.triangle.layer, miss, |_| u32::MAX);
        set(&mut b, hit, results.weights[0], weights, |bits| bits ^ 1);
        set(&mut b, hit, results.triangle.layer, both, |id| id + 2);
        set(&mut b, t, results.t.layer, both, |bits| bits + 1);
        set(&mut b, color, 1, far, |bits| (f32::from_bits(bits) + 0.25).to_bits());
        let [triangle, distance, colors, flip] =
            Aspect::ALL.map(|aspect| differences(&a, &b, aspect).expect("the same size"));
        let counts = &triangle.counts;
        assert_eq!((counts.triangle, counts.hit_or_miss, counts.t, counts.weights), (2, 1, 2, 1), "{counts:?}");
        assert_eq!((counts.max_ulps, counts.color), (3, 1));
        // A quarter, but for the rounding of the sum.
        assert!((counts.max_color - 0.25).abs() < 1e-6 && counts.max_t > 0.0 && counts.max_t < 1e-5, "{counts:?}");
        let list = |rays: &[usize]| rays.iter().map(|&ray| ray as u32).collect::<Vec<_>>();
        assert_eq!(triangle.rays, list(&[other, miss, both]));
        assert_eq!(distance.rays, list(&[far, miss, both]));
        assert_eq!(colors.rays, list(&[far]));
        // A quarter in one channel of 192.
        let errors = triangle.counts.errors.expect("colours");
        assert!((errors.mae - 0.25 / 192.0).abs() < 1e-6 && (errors.rmse - 0.25 / 192.0_f64.sqrt()).abs() < 1e-6);
        // A pixel is seen around itself too.
        assert!(flip.rays.contains(&(far as u32)) && flip.rays.len() > 1 && flip.counts.flip.is_some_and(|f| f > 0.0));
        let values = |found: &Differences, rays: [usize; 5]| rays.map(|ray| found.values[ray]);
        assert_eq!(values(&triangle, [other, far, miss, weights, both]), [2.0, 1.0, 3.0, 1.0, 2.0]);
        assert_eq!(distance.values[miss], f32::INFINITY);
        assert_eq!(distance.values[other], INF);
        assert!(distance.range().is_some_and(|[lo, hi]| lo < hi && hi < -4.0), "{:?}", distance.range());
        // In the order of the image, and around.
        let pixel = |ray: usize| Some([ray as u32 % 8, ray as u32 / 8]);
        assert_eq!(triangle.next(None), pixel(other));
        assert_eq!(triangle.next(pixel(other)), pixel(miss));
        assert_eq!(triangle.next(pixel(both)), pixel(other));
        let small = picture(&cornell_box(), &Settings { size: [8, 4], ..Settings::default() });
        assert_eq!(differences(&a, &small, Aspect::Color), None);
    }
}
