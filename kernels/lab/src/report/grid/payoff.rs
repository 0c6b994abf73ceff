//! How long structures take to build, and after how many rays that pays off.

use std::time::{Duration, Instant};

use raystep_kernels::plan::Plan;

use super::Candidate;
use crate::Error;
use crate::report::times::{FOR_BUILDING, Times};
use crate::report::work::{Built, Work};
use crate::statistics::interval;
use crate::statistics::{median, quantile};
use crate::tidy::Row;

/// Time limit for building, after the third time.
const LONGEST: Duration = Duration::from_secs(4);

/// Seconds of every build of one structure.
#[derive(Clone, Debug, Default)]
pub(super) struct Builds(pub(super) Vec<f64>);

impl Builds {
    /// The median of how much longer building takes than planning without a structure in the same rounds, and between
    /// which values it lies: its interval, or all differences if there are too few for one.
    fn beyond(&self, none: &Self) -> Option<(f64, [f64; 2])> {
        let longer: Vec<f64> = self.0.iter().zip(&none.0).map(|(build, none)| build - none).collect();
        let interval = interval::of_median(&longer, 0).map(|i| [i.low, i.high]);
        Some((median(&longer)?, interval.or(Some([quantile(&longer, 0.0)?, quantile(&longer, 1.0)?]))?))
    }

    pub(super) fn fill(&self, row: Row) -> Row {
        row.set("builds", self.0.len())
            .median("build_s", median(&self.0).map(|middle| (middle, interval::of_median(&self.0, 0))))
            .set("build_s_min", quantile(&self.0, 0.0))
            .set("build_s_max", quantile(&self.0, 1.0))
    }
}

/// Plans each of them again and again, in turn: mostly building its structure.
pub(super) fn builds(work: &Work<'_>, built: &[(Candidate, Built)]) -> Result<Vec<Builds>, Error> {
    let mut builds: Vec<Builds> = built.iter().map(|(_, built)| Builds(vec![built.build_s])).collect();
    let begin = Instant::now();
    for round in 1..work.either(3, 9) {
        work.reporter.part("building", round, work.either(3, 9));
        if round >= 3 && begin.elapsed() > LONGEST || work.is_past(FOR_BUILDING) {
            break;
        }
        for ((one, _), builds) in built.iter().zip(&mut builds) {
            work.machine().forget_kernels();
            let begin = Instant::now();
            Plan::new(&work.subject.scene, &one.options, &work.machine().limits())?;
            builds.0.push(begin.elapsed().as_secs_f64());
        }
    }
    Ok(builds)
}

/// Nanoseconds a ray that a structure saves, compared with testing every triangle, in pairs of runs.
pub(super) fn saved(none: &Times, with: &Times, rays: u64, seed: u32) -> Option<Saved> {
    let differences = none.differences(with);
    let interval = interval::of_median(&differences, u64::from(seed)).map(|i| [i.low, i.high]);
    let a_ray = |ns: f64| ns / rays.max(1) as f64;
    Some(Saved { median: a_ray(median(&differences)?), interval: interval.map(|ends| ends.map(a_ray)) })
}

/// See [`saved`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Saved {
    pub(super) median: f64,
    pub(super) interval: Option<[f64; 2]>,
}

/// A number of rays, with the fewest and the most that the intervals of times allow; `None` if they allow that a
/// structure saves nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PaysOff {
    pub(super) rays: Option<f64>,
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
}

/// After how many rays the time to build a structure, beyond that of a plan without one, equals the time it saved.
pub(super) fn pays_off(builds: &Builds, of_none: &Builds, saved: Saved) -> PaysOff {
    let rays = |build_s: f64, saved_ns: f64| (saved_ns > 0.0).then(|| (1e9 * build_s / saved_ns).max(0.0).round());
    let all = || {
        let ((middle, [low, high]), [least, most]) = (builds.beyond(of_none)?, saved.interval?);
        // If the interval includes that nothing is saved, the median does not tell whether anything is.
        let high = rays(high, least)?;
        Some(PaysOff { rays: rays(middle, saved.median), low: rays(low, most), high: Some(high) })
    };
    all().unwrap_or(PaysOff { rays: None, low: None, high: None })
}

impl PaysOff {
    pub(super) fn fill(self, row: Row) -> Row {
        row.set("paid_off_rays", self.rays).set("paid_off_rays_low", self.low).set("paid_off_rays_high", self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_structure_pays_off_between_the_ends_of_its_intervals() {
        // Six builds of 9 to 11 ms, six plans of 1 ms: 9 ms to save at 90 to 110 ns a ray.
        let builds = Builds(vec![9e-3, 10e-3, 10e-3, 10e-3, 10e-3, 11e-3]);
        let none = Builds(vec![1e-3; 6]);
        let found = pays_off(&builds, &none, Saved { median: 100.0, interval: Some([90.0, 110.0]) });
        let expected = PaysOff { rays: Some(90_000.0), low: Some(72_727.0), high: Some(111_111.0) };
        assert_eq!(found, expected);
        // Not determined: nothing may be saved, or there is no interval.
        let unknown = PaysOff { rays: None, low: None, high: None };
        assert_eq!(pays_off(&builds, &none, Saved { median: 100.0, interval: Some([-1.0, 110.0]) }), unknown);
        assert_eq!(pays_off(&builds, &none, Saved { median: 100.0, interval: None }), unknown);
        // Built in no more time than any plan: at once.
        let at_once = pays_off(&none, &none, Saved { median: 100.0, interval: Some([90.0, 110.0]) });
        assert_eq!(at_once, PaysOff { rays: Some(0.0), low: Some(0.0), high: Some(0.0) });
    }

    #[test]
    fn few_builds_have_a_smallest_and_a_largest_but_no_interval() {
        const COLUMNS: &[&str] =
            columns![schema_version builds build_s build_s_low build_s_high build_s_min build_s_max];
        let row = Builds(vec![3.0, 1.0, 2.0]).fill(Row::new(COLUMNS));
        assert!(row.is(&[("builds", "3"), ("build_s", "2"), ("build_s_min", "1"), ("build_s_max", "3")]));
        assert!(row.is(&[("build_s_low", ""), ("build_s_high", "")]));
        let row = Builds((1..=9).map(f64::from).collect()).fill(Row::new(COLUMNS));
        assert!(row.is(&[("build_s", "5"), ("build_s_low", "2"), ("build_s_high", "8"), ("build_s_max", "9")]));
    }
}
