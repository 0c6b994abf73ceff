//! Finds the step of a clock from the times that it told.

/// Smallest step of a clock that is called coarse, nanoseconds. Passes take about as long or longer, and the clocks of
/// GPUs step by 1 ns to 1 µs; browsers round them to about 100 µs.
const COARSE_NS: f64 = 10_000.0;

/// Fewest different times that tell whether all of them are multiples of a step.
const FEWEST_STEPS: usize = 5;

/// How far a time may be from a multiple of the step, as a part of the step: rounded ticks are no whole nanoseconds, but
/// they are far closer. Of times that are no multiples, 4% are as close, and 4%⁵ of all fives.
const TOLERANCE: f64 = 0.02;

/// The step of a clock that told these times, in nanoseconds and in order; `None` if it is less than [`COARSE_NS`]. It
/// is the largest of which all differences are multiples, so the times should be spread unevenly, at distances of about
/// a step.
pub(super) fn coarse_step(times: &[u64]) -> Option<f64> {
    let steps: Vec<f64> = times
        .windows(2)
        .filter_map(|pair| pair[1].checked_sub(pair[0]))
        .filter(|&step| step > 0)
        .map(|step| step as f64)
        .collect();
    let least = steps.iter().copied().min_by(f64::total_cmp).filter(|&least| least >= COARSE_NS)?;
    if steps.len() < FEWEST_STEPS {
        // A clock that tells so few different times is coarse, whether or not by this step.
        return Some(least);
    }
    // The shortest difference may be of several steps.
    let steps_in_least = 1..=(least / COARSE_NS) as u32;
    steps_in_least.map(|count| least / f64::from(count)).find_map(|step| fitted(&steps, step))
}

/// About this step, such that all differences are multiples of it, if there is such a step.
fn fitted(differences: &[f64], about: f64) -> Option<f64> {
    let multiples = || differences.iter().map(|difference| (difference / about).round());
    let step = differences.iter().sum::<f64>() / multiples().sum::<f64>();
    let is_near = |(difference, multiple): (&f64, f64)| (difference - multiple * step).abs() <= TOLERANCE * step;
    (step >= COARSE_NS && differences.iter().zip(multiples()).all(is_near)).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times at uneven distances of 0.3 to 1.7 times `mean_ns`, rounded down to multiples of `step_ns`.
    fn told(count: u32, mean_ns: f64, step_ns: f64) -> Vec<u64> {
        let mut now = 3.7e12;
        let times = (0..count).map(|i| {
            now += mean_ns * (0.3 + 1.4 * (f64::from(i) * 0.618_034).fract());
            ((now / step_ns).floor() * step_ns) as u64
        });
        times.collect()
    }

    #[test]
    fn a_coarse_step_is_found_whether_times_are_closer_or_farther_apart() {
        // Chromium's, what browsers promise, and 2,048 ticks of 52.0833 ns, which are no whole nanoseconds.
        for step_ns in [65_536.0, 100_000.0, 2048.0 * 1e9 / 19.2e6, 20_000.0] {
            for mean_ns in [0.1 * step_ns, step_ns, 3.0 * step_ns] {
                let step = coarse_step(&told(128, mean_ns, step_ns));
                let is_found = step.is_some_and(|step| (step / step_ns - 1.0).abs() < 1e-4);
                assert!(is_found, "{step:?} of {step_ns} ns, about every {mean_ns} ns");
            }
        }
    }

    #[test]
    fn the_clock_of_a_gpu_is_not_coarse_even_if_passes_are_long() {
        for step_ns in [1.0, 32.0, 80.0, 1000.0, 9000.0] {
            for mean_ns in [3000.0, 30_000.0, 100_000.0, 1_000_000.0] {
                assert_eq!(coarse_step(&told(128, mean_ns, step_ns)), None, "{step_ns} ns, about every {mean_ns} ns");
            }
        }
    }

    #[test]
    fn few_different_times_are_of_a_coarse_clock_and_none_tell_nothing() {
        assert_eq!(coarse_step(&[0, 0, 16_000_000, 16_000_000, 32_000_000]), Some(16e6));
        assert_eq!(coarse_step(&[500, 500, 500]), None);
        assert_eq!(coarse_step(&[]), None);
        // A clock that was set back in between.
        assert_eq!(coarse_step(&[300_000, 400_000, 100_000, 200_000]), Some(1e5));
    }
}
