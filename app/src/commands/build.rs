//! `raystep build`

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use raystep_kernels::export::csv::RunContext;
use raystep_kernels::options::ProgramName;
use raystep_kernels::programs::grid_build::elements::{REFERENCES, REFINED, SPANS};
use raystep_kernels::structures::grid::GridError;
use raystep_lab::built::Built;
use raystep_lab::machine::now_ns;
use raystep_lab::statistics::median;

use crate::args::{QuietArgs, RunArgs, SceneArgs, ViewArgs, whole};
use crate::error::Error;
use crate::output::{Target, refuse_inputs, write};
use crate::session::{Running, Session};
use crate::terminal::{Progress, print};

/// Build a scene's grid pass by pass: count, scan, sort and list; divide, merge and expand cells
///
/// The program grid-build runs on any device, with the same result as the build on the host, bit for bit. It is the
/// grid that rays of this view would be traced through: a uniform one, or with --accelerator irregular an irregular one.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep build teapot
  raystep build teapot --accelerator irregular --check
  raystep build terrain --grid 64 --device gpu --check
  raystep build terrain --device gpu --repeats 15 --passes-csv build.csv
  raystep dump cornell-box --program grid-build --pass all -o build
  raystep inspect cornell-box --program grid-build")]
pub(crate) struct BuildArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Compare with the build on the host, and fail if a list differs
    #[arg(long)]
    check: bool,
    /// Build this many times on the device, then on the host, and report the medians. On a GPU, this is
    /// kernel time by GPU timestamps, without reading back the counts used to allocate streams
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1, 10_000),
          allow_negative_numbers = true)]
    repeats: u32,
    /// Time every pass, and write one row per pass of the last build
    #[arg(long, value_name = "F")]
    passes_csv: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: &BuildArgs) -> Result<(), Error> {
    let target = args.passes_csv.as_deref().map(Target::new).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::new(&args.scene, &args.view, &args.run, &progress, |_, options| {
        options.program = ProgramName::GridBuild;
        options.timings = args.passes_csv.is_some();
        options.keep_passes = options.timings;
    })?;
    refuse_inputs(&[target.as_ref()], &session.inputs)?;
    if let Some(note) = session.chosen.note_on_times().filter(|_| session.options.timings) {
        progress.say(format_args!("note: {note}"));
    }
    let most_words = session.chosen.limits().list_words(session.options.scene_data);
    let mut running = session.start(&progress)?;

    // One after the other: a device that waits in between lowers its clocks.
    let mut device_ns = Vec::new();
    for repeat in 0..args.repeats {
        if repeat > 0 {
            running.renderer.restart();
        }
        progress.part("building", repeat.into(), args.repeats.into());
        let show = |now: &raystep_kernels::Progress| {
            if args.repeats == 1 {
                progress.rays(now);
            }
            ControlFlow::Continue(())
        };
        let begin = now_ns();
        running.chosen.wait(running.renderer.run(show))?;
        // Without a device clock, the time until the last pass is known to be over.
        device_ns.push(running.renderer.device_ns().unwrap_or_else(|| now_ns() - begin) as f64);
    }
    let (mut host, mut host_ns) = (None, Vec::new());
    for repeat in 0..if args.check || args.repeats > 1 { args.repeats } else { 0 } {
        progress.part("building on the host", repeat.into(), args.repeats.into());
        let begin = now_ns();
        host = Some(Built::on_host(&running.renderer, most_words).map_err(failed)?);
        host_ns.push((now_ns() - begin) as f64);
    }
    let built = running.chosen.wait(Built::of(&running.renderer))?;
    let is_same = host.map(|host| host == built);
    if let Some(target) = target {
        let last = RunContext { repeat: args.repeats - 1, ..running.run_context() };
        write(vec![(target, running.passes_csv(&last, &[])?)])?;
    }
    progress.finish();
    let text = report(&running, &built, median(&device_ns).unwrap_or_default(), median(&host_ns), is_same);
    print(&text)?;
    match is_same {
        Some(false) => Err(Error::failed("the grid differs from that of the build on the host: a defect of raystep")),
        _ => Ok(()),
    }
}

/// The grid and its lists, in words.
fn told(built: &Built, running: &Running) -> Vec<(&'static str, String)> {
    let (renderer, data) = (&running.renderer, running.renderer.data());
    let of = |elements| renderer.size(elements).map_or(0, |size| u64::from(size.count));
    let [x, y, z] = data.build.cells;
    let lists = |lengths: &[u32], rest: String| {
        let references: u64 = lengths.iter().map(|&length| u64::from(length)).sum();
        format!("{references} references, longest list {}{rest}", lengths.iter().max().unwrap_or(&0))
    };
    let empty = |lengths: &[u32]| lengths.iter().filter(|&&length| length == 0).count();
    match built {
        Built::Uniform(built) => {
            let lengths: Vec<u32> = built.cells.windows(2).map(|list| list[1] - list[0]).collect();
            let tested = format!("; {} spans of up to 32 cells tested", of(&SPANS));
            vec![
                ("grid", format!("{x} x {y} x {z} cells, {} empty", empty(&lengths))),
                ("lists", lists(&lengths, tested)),
            ]
        }
        Built::Irregular(built) => {
            let (leaves, levels) = (of(&REFINED), data.build.levels);
            let made = if !data.build.by_content() { "of two levels" } else { "after merging" };
            let cells = format!("{} cells {made}, {} empty", built.cells.len(), empty(&built.lengths));
            let below = format!("{leaves} leaves up to {levels} levels below, {} map entries", built.map.len());
            vec![
                ("top level", format!("{x} x {y} x {z} cells, {} references", of(&REFERENCES))),
                ("octrees", below),
                ("grid", cells),
                ("lists", lists(&built.lengths, String::new())),
            ]
        }
    }
}

fn failed(error: GridError) -> Error {
    Error::failed(error.to_string())
}

fn report(running: &Running, built: &Built, device_ns: f64, host_ns: Option<f64>, is_same: Option<bool>) -> String {
    let (renderer, data) = (&running.renderer, running.renderer.data());
    let device = running.chosen.gpu().map_or("CPU".into(), |gpu| gpu.info.name.clone());
    let aside = match data.set_aside.len() {
        0 => String::new(),
        far => format!(", and {far} far away that are set aside"),
    };
    let mut lines = vec![
        ("device", format!("{device}: {}", running.chosen.reason)),
        ("triangles", format!("{}{aside}", data.build.triangles)),
    ];
    lines.extend(told(built, running));
    lines.extend([("passes", renderer.pass_count().to_string()), ("time", format!("{:.3} ms", device_ns / 1e6))]);
    if let Some(host_ns) = host_ns {
        let ratio = device_ns / host_ns;
        lines.push(("host", format!("{:.3} ms; device time by host time {ratio:.2}", host_ns / 1e6)));
    }
    if let Some(is_same) = is_same {
        let said = if is_same { "the same grid as the host's build, bit for bit" } else { "the grids differ" };
        lines.push(("check", said.into()));
    }
    lines.into_iter().map(|(name, value)| format!("{name:<10}{value}\n")).collect()
}
