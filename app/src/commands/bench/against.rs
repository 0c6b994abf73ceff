//! `raystep bench --against`: two builds in one run, both as processes that run on request, so that neither is treated
//! otherwise than the other.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use raystep_kernels::Traversal;
use raystep_kernels::options::Integrator;
use raystep_lab::bench::gate::paired::{Looks, judge, order};
use raystep_lab::bench::gate::{self, Gate, GateRow, LEVEL, Times, Verdict, changed, matched};
use raystep_lab::bench::summary::THIS;
use raystep_lab::bench::{Announced, Measured, RunRow, SCHEMA_VERSION, SummaryRow, runs};
use raystep_lab::rays::Random;

use super::process::{Patience, Process};
use super::{BenchArgs, Done, output, read_scenes};
use crate::error::Error;
use crate::output::TargetFolder;
use crate::session::run_id;
use crate::terminal::Progress;

/// `build` of the other build's rows, and the start of their configurations' ids.
const OTHER: &str = "other";

/// What is compared, with the results so far.
struct Comparison {
    names: [String; 2],
    /// Rows of this build and of the other, without times.
    rows: [Vec<SummaryRow>; 2],
    /// Their places: of this build and of the other.
    pairs: Vec<[usize; 2]>,
    /// Counted runs of each pair.
    runs: Vec<[Vec<RunRow>; 2]>,
    faults: Vec<String>,
    notes: Vec<String>,
}

/// Measures both builds and writes every file.
pub(super) fn fill(
    args: &BenchArgs,
    other: &Path,
    at_most: f64,
    folder: &TargetFolder,
    output: &Path,
) -> Result<Done, Error> {
    output::refuse_others(output)?;
    let progress = Progress::new(args.quiet.quiet);
    progress.stage("reading scenes");
    // Each process reads them again; here they are only described.
    let (inputs, subjects) = read_scenes(args, Some(folder), &progress)?;
    let scenes = inputs.iter().zip(&subjects).map(|(input, subject)| output::AboutScene::new(input, subject)).collect();
    drop(subjects);
    let this = std::env::current_exe().map_err(|e| Error::failed(format!("cannot find this program: {e}")))?;
    let run_id = run_id();
    let (comparison, times) = compare(args, [&this, other], at_most, &progress)?;
    let gate = gate_of(&comparison, times, &run_id, at_most);
    let measured = measured(comparison, &run_id, args.seed);
    progress.stage("writing");
    let about = output::About::new(args, &measured.run_id, &measured.notes, scenes);
    output::write(folder, about, &measured, false, Some(&gate))?;
    progress.finish();
    let gate = Some(gate);
    progress.say(format_args!("wrote {} to {}", output::written(&gate, false).join(", "), output.display()));
    Ok(Done { text: gate.as_ref().map(gate::text).unwrap_or_default(), gate })
}

/// Runs both builds alternately until a look decides, or all rounds are over; returns the last look's results.
fn compare(
    args: &BenchArgs,
    binaries: [&Path; 2],
    at_most: f64,
    progress: &Progress,
) -> Result<(Comparison, Vec<Times>), Error> {
    let looks = Looks { most: args.repeats() as usize };
    let arguments = arguments(args);
    let mut random = Random::new(u64::from(args.seed));
    let mut comparison: Option<Comparison> = None;
    for sitting in 0.. {
        let rounds = looks.rounds(sitting);
        let mut builds =
            [binaries[0], binaries[1]].map(|binary| Process::start(binary, &arguments, Patience::default()));
        let [Ok(this), Ok(that)] = &mut builds else {
            return Err(builds.into_iter().find_map(Result::err).unwrap_or_else(|| Error::failed("no build started")));
        };
        progress.stage(&format!("building, sitting {}", sitting + 1));
        let built = [this.build(sitting > 0)?, that.build(sitting > 0)?];
        let so_far = match &mut comparison {
            Some(so_far) => {
                so_far.check(&built);
                so_far
            }
            None => comparison.insert(Comparison::new(built, binaries, progress)),
        };
        for _ in 0..args.warmups {
            for places in &so_far.pairs {
                this.run(places[0])?;
                that.run(places[1])?;
            }
        }
        for round in rounds.clone() {
            progress.part("measuring", round as u64, looks.most as u64);
            for (place, (pair, other_first)) in order(so_far.pairs.len(), &mut random).into_iter().enumerate() {
                let places = so_far.pairs[pair];
                let mut sides = [(0, &mut *this), (1, &mut *that)];
                if other_first {
                    sides.reverse();
                }
                for (second, (side, build)) in sides.into_iter().enumerate() {
                    let run = RunRow { sitting, round, place: 2 * place + second, ..build.run(places[side])? };
                    so_far.runs[pair][side].push(run);
                }
            }
        }
        if looks.is_look(sitting) {
            let times = judge(&so_far.logs(), at_most, Looks::level());
            let is_decided = !so_far.faults.is_empty()
                || so_far.changed().any(|changed| !changed.is_empty())
                || times.iter().any(|row| row.verdict == Verdict::Fail)
                || times.iter().all(|row| row.verdict == Verdict::Pass);
            if (is_decided || rounds.end == looks.most)
                && let Some(comparison) = comparison
            {
                return Ok((comparison, times));
            }
        }
    }
    Err(Error::failed("no rounds were made"))
}

impl Comparison {
    /// Of what both builds announced first.
    fn new(built: [(Vec<Announced>, Vec<String>); 2], binaries: [&Path; 2], progress: &Progress) -> Self {
        let names = ["this build".to_owned(), binaries[1].display().to_string()];
        let [(this, notes), (that, other_notes)] = built;
        let mut all = notes;
        let own: Vec<_> = other_notes.into_iter().filter(|note| !all.contains(note)).collect();
        all.extend(own.into_iter().map(|note| format!("{}: {note}", names[1])));
        all.iter().for_each(|note| progress.say(format_args!("note: {note}")));
        let rows = [this, that].map(|side| side.into_iter().map(|announced| announced.row).collect::<Vec<_>>());
        let matched = matched(&rows[0], &rows[1], &names[1]);
        let place = |side: usize, row: &SummaryRow| rows[side].iter().position(|r| std::ptr::eq(r, row));
        let pairs: Vec<[usize; 2]> =
            matched.pairs.iter().filter_map(|(this, that)| Some([place(0, this)?, place(1, that)?])).collect();
        let (faults, runs) = (matched.missing, vec![[Vec::new(), Vec::new()]; pairs.len()]);
        Self { names, pairs, runs, faults, notes: all, rows }
    }

    /// Notes where a later process of a build has other configurations or hits than the first.
    fn check(&mut self, built: &[(Vec<Announced>, Vec<String>); 2]) {
        for (side, (again, _)) in built.iter().enumerate() {
            let first = &self.rows[side];
            let differs = |(first, again): (&SummaryRow, &Announced)| {
                !first.is_same_configuration(&again.row) || first.hits_hash != again.row.hits_hash
            };
            let name = &self.names[side];
            let fault = match first.iter().zip(again).find(|pair| differs(*pair)) {
                Some((row, _)) => format!("{}: two processes of {name} have different hits", row.name()),
                None if first.len() != again.len() => format!("two processes of {name} have different rows"),
                None => continue,
            };
            if !self.faults.contains(&fault) {
                self.faults.push(fault);
            }
        }
    }

    /// The logarithms of each pair's ratios.
    fn logs(&self) -> Vec<Vec<f64>> {
        let of = |[this, that]: &[Vec<RunRow>; 2]| {
            runs::pairs(this, that).into_iter().map(|(this, that)| (this / that).ln()).collect()
        };
        self.runs.iter().map(of).collect()
    }

    /// What differs between the builds that must not, for each pair.
    fn changed(&self) -> impl Iterator<Item = Vec<String>> + '_ {
        self.pairs.iter().map(|places| changed(&self.rows[0][places[0]], &self.rows[1][places[1]]))
    }
}

/// The gate's result.
fn gate_of(comparison: &Comparison, times: Vec<Times>, run_id: &str, at_most: f64) -> Gate {
    let median = |runs: &[RunRow]| runs::valid(runs).median();
    let row = |(pair, (changed, times))| -> GateRow {
        let ([this, _], runs): ([usize; 2], &[Vec<RunRow>; 2]) = (comparison.pairs[pair], &comparison.runs[pair]);
        GateRow {
            name: comparison.rows[0][this].name(),
            configuration: this.to_string(),
            median_ns: median(&runs[0]),
            other_median_ns: median(&runs[1]),
            changed,
            times,
        }
    };
    Gate {
        schema_version: SCHEMA_VERSION,
        run_id: run_id.to_owned(),
        other: comparison.names[1].clone(),
        verdict: Verdict::Undecided,
        because: String::new(),
        at_most,
        level: LEVEL,
        method: "Both builds run one right after the other, in random order; sign test of the ratios at a level of 5% \
                 for all rows (Holm) and all three looks (Bonferroni) together; bounds by order statistics."
            .into(),
        rounds: comparison.runs.iter().map(|[this, _]| this.len()).max().unwrap_or(0),
        needed_repeats: None,
        drift: None,
        faults: comparison.faults.clone(),
        rows: comparison.changed().zip(times).enumerate().map(row).collect(),
    }
    .concluded()
}

/// The rows of both builds with their times; each pair's first row has the ratio to the second.
fn measured(comparison: Comparison, run_id: &str, seed: u32) -> Measured {
    let Comparison { mut rows, pairs, runs, notes, .. } = comparison;
    let ids = |side: usize, place: usize| if side == 0 { place.to_string() } else { format!("{OTHER}-{place}") };
    for (side, rows) in rows.iter_mut().enumerate() {
        for (place, row) in rows.iter_mut().enumerate() {
            (row.run_id, row.configuration) = (run_id.to_owned(), ids(side, place));
            row.build = if side == 0 { THIS } else { OTHER }.to_owned();
        }
    }
    let mut all = Vec::new();
    for (places, runs) in pairs.iter().zip(runs) {
        for (side, counted) in runs.iter().enumerate() {
            rows[side][places[side]].set_times(counted, u64::from(seed));
            let own = |run: &RunRow| RunRow {
                run_id: run_id.to_owned(),
                configuration: ids(side, places[side]),
                ..run.clone()
            };
            all.extend(counted.iter().map(own));
        }
        let ratios = runs::pairs(&runs[0], &runs[1]);
        rows[0][places[0]].set_ratio(&ids(1, places[1]), &ratios, u64::from(seed));
    }
    Measured { run_id: run_id.to_owned(), rows: rows.concat(), runs: all, details: Vec::new(), notes }
}

/// The arguments that make a build serve the same benchmark. Options with their default values are left out, so that a
/// build from before an option still knows the rest.
fn arguments(args: &BenchArgs) -> Vec<OsString> {
    let mut all: Vec<OsString> = ["bench", "--serve"].map(OsString::from).into();
    let mut option = |name: &str, value: String| all.extend([OsString::from(name), value.into()]);
    let list = |names: Vec<&str>| names.join(",");
    let texts = |values: &[String]| values.join(",");
    option("--accelerators", list(args.accelerators.iter().map(|a| a.name()).collect()));
    option("--schedules", list(args.schedules.iter().map(|s| s.name()).collect()));
    option("--sizes", texts(&args.sizes.iter().map(ToString::to_string).collect::<Vec<_>>()));
    if args.rays_file.is_none() {
        option("--rays", list(args.rays.iter().map(|k| k.name()).collect()));
    }
    option("--max-memory", args.read.max_memory.to_string());
    option("--seed", args.seed.to_string());
    let device = clap::ValueEnum::to_possible_value(&args.device.device);
    let vector = |v: crate::args::Vector| v.0.map(|v| v.to_string()).join(",");
    let camera = &args.camera;
    let mappings: Vec<String> = args.mappings.iter().map(ToString::to_string).collect();
    let traversals = list(args.traversals.iter().map(|t| t.name()).collect());
    let integrators = list(args.integrators.iter().map(|i| i.name()).collect());
    let optional: BTreeMap<&str, Option<String>> = BTreeMap::from([
        // An earlier build knows compute shaders only.
        ("--mappings", Some(mappings.join(",")).filter(|mappings| mappings != "compute")),
        ("--traversals", Some(traversals).filter(|traversals| traversals != Traversal::AmanatidesWoo.name())),
        ("--integrators", Some(integrators).filter(|integrators| integrators != Integrator::default().name())),
        ("--device", device.filter(|_| args.device.adapter.is_none()).map(|device| device.get_name().to_owned())),
        ("--adapter", args.device.adapter.clone()),
        ("--scene-index", args.scene_index.map(|index| index.to_string())),
        ("--camera", camera.camera.map(|index| index.to_string())),
        ("--eye", camera.eye.map(vector)),
        ("--look-at", camera.look_at.map(vector)),
        ("--up", camera.up.map(vector)),
        ("--fov", camera.fov.map(|fov| fov.to_string())),
    ]);
    for (name, value) in optional {
        value.into_iter().for_each(|value| option(name, value));
    }
    all.extend(args.tuning.words().into_iter().map(OsString::from));
    all.extend(args.read.allow_outside.then(|| OsString::from("--allow-outside")));
    all.extend(args.rays_file.iter().flat_map(|path| [OsString::from("--rays-file"), path.clone().into_os_string()]));
    all.push("--".into());
    all.extend(args.scenes.iter().map(|scene| PathBuf::into_os_string(scene.clone())));
    all
}
