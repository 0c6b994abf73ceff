//! What putting back each item costs that the scene does not need.

use std::fmt::Write as _;
use std::time::Duration;

use raystep_kernels::{Options, RaySource};
use raystep_lab::meter::Meter;
use raystep_lab::report::SEED;
use raystep_lab::report::left_out::{Cost, Costs, NO_TIMES, Ratio, costs};
use raystep_lab::{Hash, Machine, Subject};
use raystep_scenes::{Camera, Scene};
use serde::Serialize;

use crate::error::Error;
use crate::terminal::Progress;

/// What putting back costs, and where it was measured.
pub(super) struct Measured {
    machine: Machine,
    costs: Costs,
    /// The time that it was to take.
    seconds: u32,
}

/// The columns of the table.
const HEADS: [&str; 5] = ["item", "time with it / without [95%]", "memory", "start-up", "not needed because"];

impl Measured {
    pub(super) fn of(
        scene: Scene,
        options: &Options,
        machine: Machine,
        seconds: u32,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let camera = match &options.rays {
            RaySource::Camera { camera, .. } => camera.clone(),
            RaySource::Given(_) => Camera::framing(&scene.bounds()),
        };
        let subject = Subject { scene, camera, hash: Hash::default(), file: String::new() };
        let meter = Meter::new(machine);
        let time = Duration::from_secs(seconds.into());
        let costs = costs(&subject, options, &meter, time, SEED, progress)?;
        Ok(Self { machine: meter.machine, costs, seconds })
    }

    /// Why there are no times.
    fn note(&self) -> Option<&'static str> {
        self.machine.gpu().is_none().then_some(NO_TIMES)
    }

    pub(super) fn text(&self) -> String {
        let (is_timed, seconds) = (self.machine.gpu().is_some(), self.seconds);
        let late = format!("not measured: limit of {seconds} s reached (--seconds N)");
        let mut text =
            format!("\nnot needed by the scene, and what including it would cost on {}\n", self.machine.name());
        // Writing to a string cannot fail.
        if let Some(note) = self.note() {
            let _ = writeln!(text, "  on the CPU, {note}");
        }
        let mut lines = vec![HEADS.map(str::to_owned).to_vec()];
        for cost in &self.costs.costs {
            let [time, memory, start] = cost.in_words();
            let time = if is_timed && cost.is_changed && cost.times.is_none() { late.clone() } else { time };
            lines.push(vec![cost.name().to_owned(), time, memory, start, cost.reason.clone()]);
        }
        let unplanned = |name: &str| [name, &late, "", "", ""].map(str::to_owned).to_vec();
        lines.extend(self.costs.unplanned.iter().map(|item| unplanned(item.name())));
        if !is_timed {
            // What has no effect has no memory, either.
            let second = |line: &[String]| if line[2].is_empty() { line[1].clone() } else { line[2].clone() };
            lines.iter_mut().for_each(|line| *line = vec![line[0].clone(), second(line), line[4].clone()]);
        }
        if lines.len() == 1 {
            return text + "  nothing: the scene needs everything that a plan can omit\n";
        }
        let cells = lines.iter().map(Vec::len).max().unwrap_or(0);
        raystep_lab::text::aligned(&lines, cells).into_iter().for_each(|line| text += &format!("  {line}"));
        let pairs = || self.costs.costs.iter().filter_map(|cost| Some(cost.times.as_ref()?.runs));
        if let (Some(fewest), Some(most)) = (pairs().min(), pairs().max()) {
            let pairs = if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") };
            let _ = writeln!(
                text,
                "  Medians of {pairs} pairs of runs. Among many 95% intervals, about one in twenty excludes 1 by chance."
            );
        }
        text
    }

    pub(super) fn about(&self) -> AboutCosts<'_> {
        AboutCosts {
            adapter: self.machine.name(),
            clock: self.machine.gpu().map(|_| self.machine.timer().name()),
            note: self.note(),
            items: self.costs.costs.iter().map(AboutCost::of).collect(),
            unplanned: self.costs.unplanned.iter().map(|item| item.name()).collect(),
        }
    }
}

/// In JSON.
#[derive(Serialize)]
pub(super) struct AboutCosts<'a> {
    adapter: String,
    /// `null` without times.
    clock: Option<&'static str>,
    /// Why there are no times.
    note: Option<&'static str>,
    items: Vec<AboutCost<'a>>,
    /// Items whose plans there was no time for.
    unplanned: Vec<&'static str>,
}

/// Named like the columns of a report's `left_out.csv`.
#[derive(Serialize)]
struct AboutCost<'a> {
    item: &'static str,
    because: &'static str,
    reason: &'a str,
    is_changed: bool,
    stream_bytes: u64,
    stream_bytes_with: u64,
    buffer_bytes: u64,
    buffer_bytes_with: u64,
    /// `null` without times.
    #[serde(flatten)]
    times: Option<AboutTimes>,
}

#[derive(Serialize)]
struct AboutTimes {
    first_start_s: f64,
    first_start_s_with: f64,
    start_s: Option<f64>,
    start_s_with: Option<f64>,
    start_ratio: Option<f64>,
    start_ratio_low: Option<f64>,
    start_ratio_high: Option<f64>,
    runs: usize,
    median_ns: Option<f64>,
    median_ns_with: Option<f64>,
    time_ratio: Option<f64>,
    time_ratio_low: Option<f64>,
    time_ratio_high: Option<f64>,
    differing_hits: usize,
}

impl<'a> AboutCost<'a> {
    fn of(cost: &'a Cost) -> Self {
        let [without, with] = cost.bytes;
        let parts = |ratio: Option<Ratio>| {
            let interval = ratio.and_then(|(_, interval)| interval);
            [ratio.map(|(median, _)| median), interval.map(|i| i.low), interval.map(|i| i.high)]
        };
        let times = cost.times.as_ref().map(|times| {
            let [start_ratio, start_ratio_low, start_ratio_high] = parts(times.start_ratio);
            let [time_ratio, time_ratio_low, time_ratio_high] = parts(times.time_ratio);
            AboutTimes {
                first_start_s: times.first_start_s[0],
                first_start_s_with: times.first_start_s[1],
                start_s: times.start_s[0],
                start_s_with: times.start_s[1],
                start_ratio,
                start_ratio_low,
                start_ratio_high,
                runs: times.runs,
                median_ns: times.run_ns[0],
                median_ns_with: times.run_ns[1],
                time_ratio,
                time_ratio_low,
                time_ratio_high,
                differing_hits: times.differing.len(),
            }
        });
        Self {
            item: cost.name(),
            because: cost.because.name(),
            reason: &cost.reason,
            is_changed: cost.is_changed,
            stream_bytes: without.streams,
            stream_bytes_with: with.streams,
            buffer_bytes: without.buffers,
            buffer_bytes_with: with.buffers,
            times,
        }
    }
}
