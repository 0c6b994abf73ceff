//! Statistics of one layer of a stream, for an image's range, histogram and legend.

use std::collections::HashSet;

use raystep_kernels::Stream;
use raystep_kernels::shared::constants::INF;

/// Bins of a histogram.
pub const BINS: usize = 256;

/// Shares of the ordinary values that lie at or below each of [`Span::percentiles`].
pub const PERCENTILES: [f64; 3] = [0.01, 0.5, 0.99];

/// Distinct integers are counted up to this number.
pub const MOST_DISTINCT: usize = 4096;

/// What stands for "none" in a layer of integers: no triangle, no node.
pub const NONE: u32 = u32::MAX;

/// Statistics of a layer. *Ordinary* values are those a colour map covers: finite floats below the tracer's own
/// [`INF`], and integers other than [`NONE`].
#[derive(Clone, Debug, PartialEq)]
pub struct LayerStats {
    /// Number of values.
    pub texels: u64,
    /// Ordinary values.
    pub ordinary: u64,
    /// Values with the layer's initial bits, before any kernel writes it. Kernels may write the same bits, too.
    pub unwritten: u64,
    /// Distribution of the ordinary values; `None` if there are none.
    pub span: Option<Span>,
    /// All other values.
    pub others: Others,
}

/// Distribution of ordinary values. f64 represents every f32 and u32 exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// The values at [`PERCENTILES`], exactly: each is a value of the layer.
    pub percentiles: [f64; 3],
    /// How many values lie in each of [`BINS`] equally wide bins from `min` to `max`; if those are equal, all are in
    /// the first bin.
    pub histogram: Vec<u64>,
}

/// Values that are not ordinary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Others {
    /// Of a layer of floats.
    Float {
        /// Not a number.
        nan: u64,
        /// +infinity.
        pos_inf: u64,
        /// -infinity.
        neg_inf: u64,
        /// The tracer's own [`INF`]: no hit so far, or a plane that is never crossed.
        at_inf: u64,
    },
    /// Of a layer of integers.
    Integer {
        /// [`NONE`].
        none: u64,
        /// Distinct ordinary values; `None` if there are more than [`MOST_DISTINCT`].
        distinct: Option<usize>,
    },
}

impl LayerStats {
    /// Statistics of `values`, all or some of layer `layer` of `stream`. Takes linear time, and 4 bytes of memory per
    /// value.
    #[must_use]
    pub fn of(stream: Stream, layer: usize, values: &[u32]) -> Self {
        let unwritten = stream.info().unwritten.get(layer);
        let mut stats = if stream.is_float_layer(layer) { of_floats(values) } else { of_integers(values) };
        stats.unwritten = values.iter().filter(|bits| Some(bits) == unwritten.as_ref()).count() as u64;
        stats
    }
}

fn of_floats(values: &[u32]) -> LayerStats {
    let (mut nan, mut pos_inf, mut neg_inf, mut at_inf) = (0, 0, 0, 0);
    let mut ordinary = Vec::with_capacity(values.len());
    for value in values.iter().map(|&bits| f32::from_bits(bits)) {
        match value {
            v if v.is_nan() => nan += 1,
            f32::INFINITY => pos_inf += 1,
            f32::NEG_INFINITY => neg_inf += 1,
            INF => at_inf += 1,
            v => ordinary.push(v),
        }
    }
    LayerStats {
        texels: values.len() as u64,
        ordinary: ordinary.len() as u64,
        unwritten: 0,
        span: Span::of(&mut ordinary, f32::total_cmp),
        others: Others::Float { nan, pos_inf, neg_inf, at_inf },
    }
}

fn of_integers(values: &[u32]) -> LayerStats {
    let mut ordinary: Vec<u32> = values.iter().copied().filter(|&v| v != NONE).collect();
    let mut seen = HashSet::new();
    for &value in &ordinary {
        seen.insert(value);
        if seen.len() > MOST_DISTINCT {
            break;
        }
    }
    let distinct = (seen.len() <= MOST_DISTINCT).then_some(seen.len());
    LayerStats {
        texels: values.len() as u64,
        ordinary: ordinary.len() as u64,
        unwritten: 0,
        span: Span::of(&mut ordinary, u32::cmp),
        others: Others::Integer { none: (values.len() - ordinary.len()) as u64, distinct },
    }
}

impl Span {
    fn of<T: Copy + Into<f64>>(values: &mut [T], compare: fn(&T, &T) -> std::cmp::Ordering) -> Option<Self> {
        let smallest = values.iter().copied().min_by(compare)?;
        let (min, max) = (smallest.into(), values.iter().copied().max_by(compare).unwrap_or(smallest).into());
        let mut histogram = vec![0; BINS];
        let scale = if max > min { BINS as f64 / (max - min) } else { 0.0 };
        for &value in values.iter() {
            histogram[(((value.into() - min) * scale) as usize).min(BINS - 1)] += 1;
        }
        let percentiles = PERCENTILES.map(|share| {
            let place = (share * values.len() as f64).ceil() as usize;
            let place = place.clamp(1, values.len()) - 1;
            (*values.select_nth_unstable_by(place, compare).1).into()
        });
        Some(Self { min, max, percentiles, histogram })
    }

    /// Edges of a bin of the histogram.
    #[must_use]
    pub fn bin(&self, index: usize) -> [f64; 2] {
        let width = (self.max - self.min) / BINS as f64;
        [self.min + width * index as f64, self.min + width * (index + 1) as f64]
    }
}

#[cfg(test)]
mod tests {

    use raystep_kernels::programs::closest_hit::streams;
    use raystep_kernels::programs::closest_hit::streams::{HIT_TRIANGLE, STATE_T};

    use super::*;

    #[test]
    fn floats_without_a_place_on_the_scale_are_counted_apart() {
        let values = [3.0, f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY, INF, INF, -f32::NAN, 1.0];
        let stats = LayerStats::of(streams::STATE, STATE_T, &values.map(f32::to_bits));
        assert_eq!(stats.others, Others::Float { nan: 2, pos_inf: 1, neg_inf: 1, at_inf: 2 });
        assert_eq!((stats.texels, stats.ordinary, stats.unwritten), (9, 3, 2), "no t yet is INF");
        let span = stats.span.expect("three values");
        assert_eq!((span.min, span.max, span.percentiles), (-1.0, 3.0, [-1.0, 1.0, 3.0]));
        let filled: Vec<_> = (0..BINS).filter(|&i| span.histogram[i] > 0).collect();
        assert_eq!(filled, [0, BINS / 2, BINS - 1]);
        assert_eq!(span.bin(BINS / 2)[0], 1.0);
        assert_eq!(span.bin(BINS - 1)[1], 3.0);
    }

    #[test]
    fn the_whole_range_of_f32_fits() {
        let values = [f32::MIN, f32::MAX, f32::MIN_POSITIVE].map(f32::to_bits);
        let span = LayerStats::of(streams::COLOR, 0, &values).span.expect("values");
        assert_eq!((span.min, span.max), (f64::from(f32::MIN), f64::from(f32::MAX)));
        assert_eq!((span.histogram[0], span.histogram[BINS / 2], span.histogram[BINS - 1]), (1, 1, 1));
    }

    #[test]
    fn percentiles_are_those_of_the_sorted_values() {
        // 0 to 999, shuffled: 7 and 1000 have no common divisor.
        let values: Vec<u32> = (0..1000u32).map(|i| (7 * i % 1000) as f32).map(f32::to_bits).collect();
        let span = LayerStats::of(streams::TMAX, 0, &values).span.expect("values");
        assert_eq!(span.percentiles, [9.0, 499.0, 989.0]);
        assert_eq!(span.histogram.iter().sum::<u64>(), 1000);
        assert!(span.histogram.iter().all(|n| (3..=4).contains(n)), "{:?}", span.histogram);
    }

    #[test]
    fn ids_are_counted_apart_from_none() {
        let stats = LayerStats::of(streams::HIT, HIT_TRIANGLE, &[5, NONE, 7, 5, NONE, NONE]);
        assert_eq!(stats.others, Others::Integer { none: 3, distinct: Some(2) });
        assert_eq!((stats.ordinary, stats.unwritten), (3, 3));
        assert_eq!(stats.span.map(|s| (s.min, s.max)), Some((5.0, 7.0)));

        let most = MOST_DISTINCT as u32;
        for (ids, distinct) in [(most, Some(MOST_DISTINCT)), (most + 1, None), (2 * most, None)] {
            let stats = LayerStats::of(streams::HIT, HIT_TRIANGLE, &(0..ids).collect::<Vec<_>>());
            assert_eq!(stats.others, Others::Integer { none: 0, distinct });
        }
    }

    #[test]
    fn nothing_has_no_range() {
        assert_eq!(LayerStats::of(streams::COLOR, 0, &[]).span, None);
        let none = LayerStats::of(streams::PREVIOUS, 0, &[NONE; 4]);
        assert_eq!((none.ordinary, none.span), (0, None));
        let one = LayerStats::of(streams::COLOR, 0, &[2.5f32.to_bits()]).span.expect("a value");
        assert_eq!((one.min, one.max, one.percentiles, one.histogram[0]), (2.5, 2.5, [2.5; 3], 1));
    }
}
