//! `raystep dump`

mod buffers;
mod index;
mod left_out;
mod notes;
mod wanted;

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use raystep_kernels::export::{exr, npy};
use raystep_kernels::plan::{Bytes, Plan};
use raystep_kernels::programs;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Choices, Renderer, Stream, StreamData};
use raystep_lab::text::counted;

use crate::args::choices::{ChoiceArgs, What};
use crate::args::{QuietArgs, RunArgs, SCENE_OR_PROGRAM, SceneArgs, ViewArgs};
use crate::error::Error;
use crate::output::TargetFolder;
use crate::program_folder;
use crate::scene_file::read_file;
use crate::session::{Running, Session};
use crate::terminal::Progress;
use index::{INDEX, index};
use left_out::{LeftOut, NOT_NEEDED, needs_shading};
use wanted::streams;

/// Write streams after one pass or after every pass
///
/// DIR/pass-000123.hit.npy has the stream 'hit' after pass 123 as an array (layer, row, column) of float32 or uint32,
/// depending on the stream. Elements that are no pixels, such as photons (--integrator photons), fill the rows one after the
/// other: index.json has how many there are. DIR/pass-000123.note.NAME.npy has what a kernel of yours prints in it. With --buffers, DIR/scene.vertices.npy has the triangles as kernels read them, and so on.
/// index.json describes every pass, the structure, and how to convert the streams' units to the scene file's coordinates.
#[derive(Args, Debug)]
#[command(mut_arg("scene", |scene| scene.help(SCENE_OR_PROGRAM)), after_help = "\
Examples:
  raystep dump cornell-box --pass last --stream hit -o hits
  raystep dump cornell-box --pass 7 --stream state,tmax -o pass7
  raystep dump cornell-box --stream hit --buffers grid_cells,grid_items,vertices -o data
  raystep dump cornell-box --integrator photons --photons 999 --stream photon_key -o photons
  raystep dump teapot --pass all --stream all --size 64x64 --format both -o all
  raystep dump my-program --pass 3 -o pass3")]
pub(crate) struct DumpArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    /// Pass after which to write, counted from 0
    #[arg(long, value_name = "N|last|all", default_value = "last", allow_negative_numbers = true)]
    pass: Which,
    /// Streams, separated by commas; 'raystep plan' lists them
    #[arg(long, value_name = "NAME|all", default_value = "all", value_delimiter = ',', value_parser = parse_stream)]
    stream: Vec<Wanted>,
    /// Also write scene data: buffers of the grid or BVH, vertices, normals, materials, … , separated by commas; 'raystep
    /// plan' lists them
    #[arg(long, value_name = "NAME|all", value_delimiter = ',', value_parser = parse_stream)]
    buffers: Vec<Wanted>,
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// NumPy arrays, OpenEXR images (one channel per layer), or both
    #[arg(long, value_enum, default_value_t = Format::Npy)]
    format: Format,
    /// Replace the dump in a folder that is not empty: files listed in its index.json are deleted, others are kept.
    /// Also write if free space may be insufficient
    #[arg(long)]
    force: bool,
    /// Count cells visited and triangles tested
    #[arg(long)]
    counters: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Which {
    Number(usize),
    Last,
    All,
}

impl FromStr for Which {
    type Err = &'static str;

    fn from_str(value: &str) -> Result<Self, Self::Err> {
        match value {
            "last" => Ok(Self::Last),
            "all" => Ok(Self::All),
            _ => value.parse().map(Self::Number).map_err(|_| "expected a pass number of at least 0, last or all"),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Wanted {
    Named(String),
    All,
}

fn parse_stream(value: &str) -> Result<Wanted, Infallible> {
    Ok(if value == "all" { Wanted::All } else { Wanted::Named(value.to_owned()) })
}

/// The streams that are named, of the program that runs; none for all of them.
fn named_streams(args: &DumpArgs) -> Result<Vec<Stream>, Error> {
    let Choices { program, .. } = args.program.values;
    let program = match program_folder::find(&args.scene.scene) {
        Some(found) => program_folder::own(&found.folder)?.program,
        None => programs::chosen(&Choices { program, ..args.run.tracing.values }).program(),
    };
    let mut named = Vec::new();
    for wanted in &args.stream {
        let Wanted::Named(name) = wanted else { return Ok(Vec::new()) };
        let stream = program.stream(name).ok_or_else(|| {
            let names: Vec<_> = program.streams().map(Stream::name).collect();
            Error::usage(format!("--stream {name}: no such stream; the streams are {}, and all", names.join(", ")))
        })?;
        if !named.contains(&stream) {
            named.push(stream);
        }
    }
    Ok(named)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Npy,
    Exr,
    Both,
}

pub(crate) fn run(args: &DumpArgs) -> Result<(), Error> {
    if args.pass != Which::Last && !args.run.tracing.values.schedule.is_stepped() {
        return Err(Error::usage(
            "--schedule fused traces every ray in one pass: use --pass last for its hits, or schedule first, second \
             or compact, which have steps",
        ));
    }
    let folder = TargetFolder::new(&args.output, args.force)?;
    let text = folder.fill(&listed(&args.output), |folder| fill(args, folder))?;
    Progress::new(args.quiet.quiet).say(text);
    Ok(())
}

/// Writes every file, and prints a summary.
fn fill(args: &DumpArgs, folder: &TargetFolder) -> Result<String, Error> {
    let progress = Progress::new(args.quiet.quiet);
    let named = named_streams(args)?;
    let is_wanted = |stream| named.is_empty() || named.contains(&stream);
    let mut session = Session::of_any(&args.scene, &args.view, &args.run, &progress, |_, options| {
        let Choices { program, elements, .. } = args.program.values;
        (options.program, options.elements) = (program, elements);
        if !args.run.tracing.has("steps-per-pass") {
            options.steps_per_pass = 1;
        }
        if options.folder.is_some() {
            return;
        }
        // A program that is wrong is refused when the run is planned.
        let Ok(program) = programs::program_of(options) else { return };
        options.counters = args.counters || program.results.is_some_and(|results| named.contains(&results.counters));
        // Much of the scene data is for shading.
        // Where several kernels finish rays, these cast others, in passes that are counted by running them.
        let finishing = program.kernels().filter(|kernel| kernel.role() == Role::Finish).count();
        options.shade = options.samples.count > 1
            || finishing > 1
            || !args.buffers.is_empty()
            || program.results.is_some_and(|results| {
                program.streams().any(|s| is_wanted(s) && needs_shading(s, &results, options.schedule))
            });
    })?;
    // With many lights, shading takes several passes; how many is only known after running them.
    if !session.options.shade && session.scene.lights.len() as u64 > u64::from(session.chosen.limits().turns) {
        session.options.shade = true;
        (session.plan, session.data) = Plan::new(&session.scene, &session.options, &session.chosen.limits())?;
    }
    folder.refuse_inputs(&session.inputs, is_ours)?;
    // With a scene, a program of one's own may have more streams than before.
    let named: Vec<Stream> = named.iter().filter_map(|stream| session.plan.program.stream(stream.name())).collect();
    let streams = streams(&named, &session.plan)?;
    buffers::chosen(&args.buffers, &session.plan)?;
    let left_out = LeftOut::of(&session.plan);
    let mut running = session.start(&progress)?;

    let mut printed = None;
    let passes = match args.pass {
        Which::Number(wanted) => {
            printed = step_to(&mut running, wanted, left_out, &progress)?;
            vec![wanted]
        }
        Which::Last | Which::All => {
            let show = |now: &raystep_kernels::Progress| {
                progress.rays(now);
                ControlFlow::Continue(())
            };
            running.chosen.wait(running.renderer.run(show))?;
            let last = left_out.count(&running).saturating_sub(1);
            if args.pass == Which::Last { vec![last] } else { (0..=last).collect() }
        }
    };
    let bytes = bytes(&streams, &running.renderer, args.format) * passes.len() as u64;
    let files = streams.len() * passes.len() * if args.format == Format::Both { 2 } else { 1 };
    // Of some programs, streams have no texels before a pass has counted their elements.
    let is_whole = running.renderer.plan().sets.iter().all(|set| set.size.is_some());
    let about = if args.format == Format::Npy && is_whole { "" } else { " at most" };
    progress.say(format_args!(
        "writing {}, {}{about}, to {}",
        counted(files, "file"),
        Bytes(bytes),
        args.output.display()
    ));
    if !args.force {
        // If the system does not report free space, writing will show.
        fs4::available_space(folder.place()).map_or(Ok(()), |free| must_fit(bytes, free, &args.output))?;
    }

    let buffers = buffers::write(&args.buffers, &running, folder)?;
    let mut index = index(&running, &streams, buffers, left_out, passes.last().copied());
    for pass in index.passes.iter().filter(|pass| pass.left_out.is_some()) {
        progress.say(format_args!("pass {} ({}) is omitted: {NOT_NEEDED}", pass.index, pass.kernel));
    }
    if args.pass == Which::All {
        // The number of passes is only known now: run the same passes again, since kernels are deterministic.
        running.renderer.restart();
    }
    for (done, &wanted) in passes.iter().enumerate() {
        if args.pass == Which::All && index.passes[wanted].left_out.is_none() {
            printed = notes::Before::next_pass(&running)?;
            running.chosen.wait(running.renderer.step())?;
        }
        if let Some(printed) = printed.take() {
            index.passes[wanted].files.extend(printed.write(&running, folder, wanted)?);
        }
        progress.part("writing", done as u64, passes.len() as u64);
        for &stream in &streams {
            // Elements that a later pass counts have no texels yet.
            if running.renderer.size(stream.info().elements).is_none() {
                continue;
            }
            let data = running.chosen.wait(running.renderer.values(stream))?;
            index.passes[wanted].files.extend(write_stream(folder, wanted, &data, args.format)?);
        }
    }
    let text = super::json_text(&index)?;
    folder.write(INDEX, |out| std::io::Write::write_all(out, text.as_bytes()))?;
    let files: usize = index.passes.iter().map(|pass| pass.files.len()).sum();
    Ok(format!("wrote {} and index.json to {}", counted(files, "file"), args.output.display()))
}

/// Refuses output larger than the free space.
fn must_fit(bytes: u64, free: u64, output: &Path) -> Result<(), Error> {
    if bytes <= free {
        return Ok(());
    }
    Err(Error::failed(format!(
        "{} does not fit at {}: {} are free there; name fewer streams or another folder, or use --force to try",
        Bytes(bytes),
        output.display(),
        Bytes(free)
    )))
}

/// Whether a dump may write a file of this name.
fn is_ours(name: &str) -> bool {
    name == INDEX
        || buffers::is_ours(name)
        || (name.starts_with("pass-") && (name.ends_with(".npy") || name.ends_with(".exr")))
}

/// The dump's files that an existing index lists: plain names only.
fn listed(folder: &Path) -> Vec<String> {
    const MOST_BYTES: u64 = 1 << 30;
    let index = read_file(&folder.join(INDEX), MOST_BYTES).ok();
    let index = index.and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    let passes = index.as_ref().and_then(|index| index["passes"].as_array());
    let files = passes.into_iter().flatten().filter_map(|pass| pass["files"].as_array()).flatten();
    let buffers = index.as_ref().and_then(|index| index["buffers"].as_array());
    let files = files.chain(buffers.into_iter().flatten().map(|buffer| &buffer["file"]));
    let is_plain = |name: &str| is_ours(name) && !name.contains(['/', '\\']);
    files.filter_map(|name| name.as_str()).filter(|name| is_plain(name)).map(str::to_owned).collect()
}

/// Also returns what the last of these passes starts from, if it prints something.
fn step_to(
    running: &mut Running,
    wanted: usize,
    left_out: LeftOut,
    progress: &Progress,
) -> Result<Option<notes::Before>, Error> {
    let mut printed = None;
    while left_out.before() + running.renderer.pass_count() <= wanted {
        if left_out.before() + running.renderer.pass_count() == wanted {
            printed = notes::Before::next_pass(running)?;
        }
        if running.chosen.wait(running.renderer.step())?.is_none() {
            let count = left_out.count(running);
            if wanted < count {
                break;
            }
            return Err(Error::usage(format!(
                "--pass {wanted}: the run has {count} passes, 0 to {}",
                count.saturating_sub(1)
            )));
        }
        progress.rays(&running.renderer.progress());
    }
    Ok(printed)
}

/// Bytes of the streams after one pass.
fn bytes(streams: &[Stream], renderer: &Renderer, format: Format) -> u64 {
    let of = |stream: &Stream| {
        let texels = renderer.size(stream.info().elements).map_or(0, |size| size.texels());
        let raw = stream.bytes(texels).unwrap_or(u64::MAX);
        match format {
            Format::Npy => raw + npy::HEADER_BYTES,
            Format::Exr => raw,
            Format::Both => 2 * raw + npy::HEADER_BYTES,
        }
    };
    streams.iter().map(of).sum()
}

fn write_stream(folder: &TargetFolder, pass: usize, data: &StreamData, format: Format) -> Result<Vec<String>, Error> {
    let mut files = Vec::new();
    let name = |extension: &str| format!("pass-{pass:06}.{}.{extension}", data.stream.name());
    if format != Format::Exr {
        let name = name("npy");
        folder.write(&name, |out| npy::write_stream(out, data))?;
        files.push(name);
    }
    if format != Format::Npy {
        let name = name("exr");
        folder.write(&name, |out| exr::write_stream(out, data).map_err(io_error))?;
        files.push(name);
    }
    Ok(files)
}

fn io_error(error: exr::ExrError) -> std::io::Error {
    match error {
        exr::ExrError::Io(error) => error,
        other => std::io::Error::other(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_both_numbers() {
        assert!(must_fit(4096, 4096, Path::new("out")).is_ok());
        let error = must_fit(3 << 30, 5 << 20, Path::new("out")).map_err(|e| e.to_string());
        let expected = format!("error: {} does not fit at out: {} are free there", Bytes(3 << 30), Bytes(5 << 20));
        assert!(error.as_ref().is_err_and(|e| e.starts_with(&expected)), "{error:?}");
    }

    #[test]
    fn space_is_known_here() {
        let free = fs4::available_space(std::env::temp_dir()).expect("a file system");
        assert!(free > 0);
    }
}
