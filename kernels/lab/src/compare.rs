//! Compares a stream of two runs: in numbers, ray by ray, and as an image of signed differences.

use raystep_kernels::numbers::real::ulps;
use raystep_kernels::shared::constants::INF;
use raystep_kernels::{Stream, StreamData};

/// Two streams that cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// They are not the same stream.
    #[error("stream {left:?} cannot be compared with stream {right:?}", left = .0[0].name(), right = .0[1].name())]
    Stream([Stream; 2]),
    /// They do not have the same size.
    #[error("an image of {}x{} cannot be compared with one of {}x{}", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
}

/// How one layer differs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerDifference {
    /// Rays whose bits differ. 0 and -0 differ, and so do NaNs with different bits.
    pub differing: u64,
    /// Those of them where only one side is an ordinary float: the other is NaN, infinite, or the tracer's own [`INF`].
    pub one_sided: u64,
    /// The first ray that differs, y * width + x.
    pub first: Option<usize>,
    /// Differences of rays where both sides are ordinary floats.
    pub floats: Option<FloatDifference>,
}

/// How far apart ordinary floats are, among those that differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatDifference {
    /// Largest difference in units in the last place.
    pub max_ulps: u64,
    /// The median; for an even number of rays the smaller of the two middle values.
    pub median_ulps: u64,
    /// Largest |a - b|, in the stream's unit.
    pub largest: f64,
    /// A ray with that difference.
    pub largest_ray: usize,
}

/// The values of one stream in two runs.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'a> {
    left: &'a StreamData,
    right: &'a StreamData,
}

/// The difference in one layer.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// left - right in a layer of floats; NaN if only one side is an ordinary float, 0 if neither is and both are
    /// equal.
    Signed(Vec<f32>),
    /// Whether integers differ; ids have no distance.
    Differs(Vec<bool>),
}

impl<'a> Comparison<'a> {
    /// Compares two runs.
    ///
    /// # Errors
    /// If they are not the same stream, or differ in size.
    pub fn new(left: &'a StreamData, right: &'a StreamData) -> Result<Self, CompareError> {
        if left.stream != right.stream {
            return Err(CompareError::Stream([left.stream, right.stream]));
        }
        let size = |s: &StreamData| [s.width, s.height];
        if size(left) != size(right) || left.bits.len() != right.bits.len() {
            return Err(CompareError::Size(size(left), size(right)));
        }
        Ok(Self { left, right })
    }

    fn pairs(&self, layer: usize) -> impl Iterator<Item = (usize, u32, u32)> + use<'a> {
        let (left, right) = (self.left.layer(layer), self.right.layer(layer));
        left.iter().zip(right).enumerate().map(|(ray, (&a, &b))| (ray, a, b))
    }

    /// How a layer differs. Takes 8 bytes of memory per differing ray.
    #[must_use]
    pub fn layer(&self, layer: usize) -> LayerDifference {
        let mut found = LayerDifference::default();
        let is_float = self.left.stream.is_float_layer(layer);
        let (mut distances, mut largest, mut largest_ray) = (Vec::new(), -1.0, 0);
        for (ray, a, b) in self.pairs(layer).filter(|(_, a, b)| a != b) {
            found.differing += 1;
            found.first.get_or_insert(ray);
            let (x, y) = (f32::from_bits(a), f32::from_bits(b));
            match (is_ordinary(x), is_ordinary(y)) {
                (true, true) if is_float => {
                    distances.push(ulps(a, b));
                    let difference = (f64::from(x) - f64::from(y)).abs();
                    if difference > largest {
                        (largest, largest_ray) = (difference, ray);
                    }
                }
                (x, y) => found.one_sided += u64::from(is_float && x != y),
            }
        }
        let middle = distances.len().saturating_sub(1) / 2;
        if let Some(&max_ulps) = distances.iter().max() {
            let median_ulps = *distances.select_nth_unstable(middle).1;
            found.floats = Some(FloatDifference { max_ulps, median_ulps, largest, largest_ray });
        }
        found
    }

    /// How every layer differs.
    #[must_use]
    pub fn layers(&self) -> Vec<LayerDifference> {
        (0..self.left.stream.layers()).map(|layer| self.layer(layer)).collect()
    }

    /// Rays that differ in any layer, in order.
    pub fn rays(&self) -> impl Iterator<Item = usize> + use<'a> {
        let (left, right) = (self.left, self.right);
        let rays = left.width as usize * left.height as usize;
        let differs = move |ray: &usize| (0..left.stream.layers()).any(|l| left.get(l, *ray) != right.get(l, *ray));
        (0..rays).filter(differs)
    }

    /// A layer's difference, as an image.
    #[must_use]
    pub fn difference(&self, layer: usize) -> Difference {
        if !self.left.stream.is_float_layer(layer) {
            return Difference::Differs(self.pairs(layer).map(|(_, a, b)| a != b).collect());
        }
        let signed = |(_, a, b): (usize, u32, u32)| {
            let (x, y) = (f32::from_bits(a), f32::from_bits(b));
            match (is_ordinary(x), is_ordinary(y)) {
                (true, true) => x - y,
                _ if a == b => 0.0,
                _ => f32::NAN,
            }
        };
        Difference::Signed(self.pairs(layer).map(signed).collect())
    }
}

fn is_ordinary(value: f32) -> bool {
    value.is_finite() && value != INF
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::streams;

    use super::*;

    fn stream(stream: Stream, layers: &[&[f32]]) -> StreamData {
        let bits = layers.iter().flat_map(|l| l.iter().map(|v| v.to_bits())).collect();
        StreamData { stream, width: layers[0].len() as u32, height: 1, bits }
    }

    #[test]
    fn floats_are_as_far_apart_as_their_last_places_say() {
        let next = 1f32.next_up();
        let a = stream(streams::TMAX, &[&[1.0, 2.0, 0.0, INF, 5.0, 1.0], &[0.0; 6], &[INF; 6]]);
        let b = stream(streams::TMAX, &[&[next, 2.0, -0.0, 3.0, 4.5, next.next_up()], &[0.0; 6], &[INF; 6]]);
        let compared = Comparison::new(&a, &b).expect("comparable");
        let [x, y, z] = compared.layers()[..] else { panic!("three layers") };
        assert_eq!((x.differing, x.one_sided, x.first), (5, 1, Some(0)));
        let floats = x.floats.expect("floats differ");
        // 0, 1, 2 and 2^20 or so: the lower middle is 1.
        assert_eq!((floats.median_ulps, floats.max_ulps), (1, 1 << 20));
        assert_eq!((floats.largest, floats.largest_ray), (0.5, 4));
        assert_eq!([y, z], [LayerDifference::default(); 2]);
        assert_eq!(compared.rays().collect::<Vec<_>>(), [0, 2, 3, 4, 5]);
        let Difference::Signed(signed) = compared.difference(0) else { panic!("floats") };
        assert!(signed[3].is_nan());
        assert_eq!((signed[0], signed[1], signed[4]), (1.0 - next, 0.0, 0.5));
        assert_eq!(compared.difference(2), Difference::Signed(vec![0.0; 6]), "both miss");
    }

    #[test]
    fn ids_are_the_same_or_not() {
        let (a, mut b) = (stream(streams::HIT, &[&[0.5; 4][..]; 3]), stream(streams::HIT, &[&[0.5; 4][..]; 3]));
        b.bits[2 * 4 + 2] = u32::MAX;
        let compared = Comparison::new(&a, &b).expect("comparable");
        assert_eq!(compared.difference(2), Difference::Differs(vec![false, false, true, false]));
        let found = compared.layer(2);
        assert_eq!((found.differing, found.first, found.one_sided, found.floats), (1, Some(2), 0, None));
        assert_eq!(compared.rays().collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn what_cannot_be_compared_is_said() {
        let a = stream(streams::HIT, &[&[0.5; 4][..]; 3]);
        let other = stream(streams::TMAX, &[&[0.5; 4][..]; 3]);
        let small = stream(streams::HIT, &[&[0.5; 3][..]; 3]);
        let turned = StreamData { width: 1, height: 4, ..a.clone() };
        let error = |b| Comparison::new(&a, b).expect_err("not comparable").to_string();
        assert_eq!(error(&other), "stream \"hit\" cannot be compared with stream \"tmax\"");
        assert_eq!(error(&small), "an image of 4x1 cannot be compared with one of 3x1");
        assert_eq!(error(&turned), "an image of 4x1 cannot be compared with one of 1x4");
    }
}
