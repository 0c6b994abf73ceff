//! A run's program as the folder of a user's program: `program.toml`, the kernels' WGSL as we have it, and what its streams
//! begin with. Run from there, it gives the same bits.
//!
//! Written is what the run has: its kernels, and the streams, sets and states that they name, with the schedule of its options.

mod toml;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io;

use self::toml::{list, number, quoted, steps, table};
use super::npy;
use crate::options::folder::Folder;
use crate::options::rows::{ROWS, Value};
use crate::options::{Accelerator, Choices, Options, ProgramName, RaySource};
use crate::plan::Plan;
use crate::program::schedule::Step;
use crate::program::{Course, Kernel, Program};
use crate::programs::chosen;
use crate::scene_data::SceneData;
use crate::shader::Variant;
use crate::tables::elements::{Count, Elements};
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::StateRole;
use crate::tables::stream::{Meaning, Stream, StreamData, Texel};

/// Why a run cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// It has what a folder cannot say.
    #[error("{0} cannot be a folder")]
    Unsupported(&'static str),
    /// An array could not be written.
    #[error(transparent)]
    Array(#[from] io::Error),
}

/// The files of a run's program, by their paths in the folder; `scene` is the name of the scene to run with if none is given.
///
/// # Errors
/// If the run has rays of the caller's, is drawn, or is a user's already.
pub fn program(
    plan: &Plan,
    data: &SceneData,
    options: &Options,
    scene: Option<&str>,
) -> Result<BTreeMap<String, Vec<u8>>, ExportError> {
    if options.folder.is_some() || !plan.replaced().is_empty() {
        return Err(ExportError::Unsupported("a program of one's own"));
    }
    if plan.drawn.is_some() {
        return Err(ExportError::Unsupported("a run of fragment programs"));
    }
    if matches!(options.rays, RaySource::Given(_)) {
        return Err(ExportError::Unsupported("a run of rays that a file has"));
    }
    if options.program == ProgramName::GridBuild && options.accelerator == Accelerator::Irregular {
        // Its barriers are in loops whose lengths are loaded: what users may write, our check of theirs cannot follow.
        return Err(ExportError::Unsupported("the build of an irregular grid"));
    }
    let alone = chosen(&options.choices()).alone.as_ref();
    let has_scene = alone.is_none();
    let written = Written::of(plan, data);
    let mut files = BTreeMap::new();
    let mut text = format!("summary = {}\n", quoted(plan.program.summary));
    if has_scene {
        text += &scene_table(scene, &options.choices());
    }
    text += &written.elements(has_scene);
    for input in &data.inputs {
        let (stream, count) = (input.stream, count_of(plan, input.stream.info().elements));
        let (is_float, shape) = (stream.info().texel == Texel::F32, [stream.layers() as u32, 1, count]);
        let mut bytes = Vec::new();
        npy::write_bits(&mut bytes, is_float, shape, &trimmed(input, count))?;
        files.insert(format!("{}.npy", input.stream.name()), bytes);
    }
    text += &written.streams();
    text += &written.states();
    for variant in &plan.variants {
        text += &written.kernel(variant);
        let info = variant.kernel.info();
        files.insert(format!("{}.wgsl", info.name), info.wgsl.as_bytes().to_vec());
    }
    _ = write!(text, "\n[schedule]\nsteps = [\n{}]\n", steps(&plan.schedule.steps, 1));
    let traced = plan.program.results.map(|results| [results.mean, results.color]);
    let results = traced.into_iter().flatten().chain(alone.map(|alone| alone.results));
    if let Some(shown) = results.into_iter().find(|&stream| plan.has_stream(stream)) {
        _ = write!(text, "\n[result]\nstream = {}\n", quoted(shown.name()));
    }
    files.insert(Folder::MANIFEST.to_owned(), text.into_bytes());
    Ok(files)
}

/// The elements of a set.
fn count_of(plan: &Plan, set: &Elements) -> u32 {
    let planned = plan.sets.iter().find(|planned| planned.what.name == set.name);
    planned.and_then(|planned| planned.size).map_or(0, |size| size.count)
}

/// The values of a stream's elements, without the texels behind the last.
fn trimmed(data: &StreamData, count: u32) -> Vec<u32> {
    (0..data.stream.layers()).flat_map(|layer| data.layer(layer).iter().take(count as usize).copied()).collect()
}

/// The table of the scene, with the options that are not the defaults, and the schedule.
fn scene_table(scene: Option<&str>, choices: &Choices) -> String {
    let usual = Choices::default();
    let mut text = "\n[scene]\n".to_owned();
    if let Some(scene) = scene {
        _ = writeln!(text, "file = {}", quoted(scene));
    }
    text += "\n[scene.options]\n";
    for row in ROWS {
        let value = row.get(choices);
        // The schedule of a folder's run is another one if it is not given, and the accelerator is part of the program.
        if value == row.get(&usual) && !matches!(row.name, "schedule" | "accelerator") {
            continue;
        }
        match value {
            Value::Nothing => {}
            Value::Text(value) => _ = writeln!(text, "{} = {}", row.name, quoted(&value)),
            Value::Number(value) => _ = writeln!(text, "{} = {value}", row.name),
            Value::Flag(value) => _ = writeln!(text, "{} = {value}", row.name),
        }
    }
    text
}

/// What of a program is written.
struct Written<'a> {
    plan: &'a Plan,
    data: &'a SceneData,
    program: &'static Program,
    kernels: Vec<Kernel>,
    sets: BTreeSet<&'static str>,
}

impl<'a> Written<'a> {
    fn of(plan: &'a Plan, data: &'a SceneData) -> Self {
        let kernels: Vec<Kernel> = plan.variants.iter().map(|variant| variant.kernel).collect();
        let mut sets: BTreeSet<&'static str> = kernels.iter().map(|kernel| kernel.instance().over.name).collect();
        sets.extend(plan.streams.iter().map(|stream| stream.what.info().elements.name));
        sets.extend(kernels.iter().flat_map(|kernel| kernel.instance().renews).map(|set| set.name));
        looped_sets(&plan.schedule.steps, &mut sets);
        // A set may be counted by another.
        let program = plan.program;
        loop {
            let of = |set: &&'static str| match program.elements(set)?.count {
                Count::Per { of, .. } => Some(of),
                Count::Found { in_stream, .. } => Some(program.stream(in_stream)?.info().elements.name),
                Count::Image | Count::Given => None,
            };
            let more: Vec<&'static str> = sets.iter().filter_map(of).collect();
            let before = sets.len();
            sets.extend(more);
            if sets.len() == before {
                return Self { plan, data, program, kernels, sets };
            }
        }
    }

    fn elements(&self, has_scene: bool) -> String {
        let mut text = "\n[elements]\n".to_owned();
        for set in self.program.elements.iter().filter(|set| self.sets.contains(set.name)) {
            let how = match set.count {
                Count::Image | Count::Given if has_scene => format!("scene = {}", quoted(set.name)),
                Count::Image => {
                    let size = self.plan.size();
                    format!("image = [{}, {}]", size.width, size.height)
                }
                Count::Given => format!("count = {}", count_of(self.plan, set)),
                Count::Per { of, per, each } => format!("per = {}, block = {per}, each = {each}", quoted(of)),
                Count::Found { in_stream, layer } => {
                    let layer = self.program.stream(in_stream).map_or("", |stream| stream.info().layers[layer]);
                    format!("found = {}", quoted(&format!("{in_stream}.{layer}")))
                }
            };
            _ = writeln!(text, "{} = {{ {how} }}", set.name);
        }
        text
    }

    /// Every stream that a kernel binds, or that has the number of a set's elements.
    fn has(&self, stream: Stream) -> bool {
        let counts = |set: &&&'static Elements| {
            self.sets.contains(set.name)
                && matches!(set.count, Count::Found { in_stream, .. } if in_stream == stream.name())
        };
        let adopts =
            |kernel: &Kernel| kernel.instance().adopts.iter().any(|&(to, from)| to == stream || from == stream);
        self.plan.has_stream(stream)
            || self.program.elements.iter().any(|set| counts(&set))
            || self.kernels.iter().any(adopts)
            || self.program.courses.iter().any(|course| course.stream == stream)
    }

    fn streams(&self) -> String {
        let mut text = String::new();
        for stream in self.program.streams().filter(|&stream| self.has(stream)) {
            let info = stream.info();
            let (kind, is_float) = if info.texel == Texel::F32 { ("f32", true) } else { ("u32", false) };
            _ = write!(text, "\n[streams.{}]\nof = {}\ntype = \"{kind}\"\n", info.name, quoted(info.elements.name));
            _ = writeln!(text, "layers = {}", list(info.layers, |layer| quoted(layer)));
            _ = writeln!(text, "meaning = {}", list(info.meaning, |meaning| quoted(meaning_name(*meaning))));
            if !info.unit.is_empty() {
                _ = writeln!(text, "unit = {}", quoted(info.unit));
            }
            let start = match self.data.inputs.iter().any(|input| input.stream == stream) {
                true => table([("npy", quoted(&format!("{}.npy", info.name)))]),
                false => list(info.unwritten, |&bits| number(bits, is_float)),
            };
            _ = writeln!(text, "start = {start}");
        }
        text
    }

    fn states(&self) -> String {
        let mut used: BTreeSet<u32> = self.kernels.iter().flat_map(|kernel| kernel.takes()).copied().collect();
        used.extend(self.kernels.iter().flat_map(|kernel| kernel.sends()).flat_map(|sent| [sent.from, sent.to]));
        used.extend(self.program.courses.iter().flat_map(|course| [course.unborn, course.born, course.done]));
        if used.is_empty() {
            return String::new();
        }
        let mut text = "\n[states]\n".to_owned();
        // All of them: their order is their number.
        for state in self.program.states.iter() {
            let role = match state.role {
                StateRole::Unborn => "unborn",
                StateRole::Active => "active",
                StateRole::Resolved => "resolved",
                StateRole::Finished => "finished",
            };
            let entries = [("role", quoted(role)), ("meaning", quoted(state.meaning))];
            _ = writeln!(text, "{} = {}", state.name, table(entries));
        }
        text
    }

    fn kernel(&self, variant: &Variant) -> String {
        let kernel = variant.kernel;
        let (info, instance) = (kernel.info(), kernel.instance());
        let mut text = format!("\n[kernels.{}]\n", kernel.name());
        let mut line = |name: &str, value: String| _ = writeln!(text, "{name} = {value}");
        if info.name != kernel.name() {
            line("file", quoted(&format!("{}.wgsl", info.name)));
        }
        line("over", quoted(instance.over.name));
        line("summary", quoted(info.summary));
        let usual = if kernel.takes().is_empty() { Role::Once } else { Role::Step };
        if info.role != usual {
            let named = Role::NAMES.iter().find(|(_, role)| *role == info.role);
            line("role", quoted(named.map_or("", |(name, _)| name)));
        }
        let state = |tag: u32| quoted(self.program.states.name(tag));
        // Where elements go that no kernel of the run takes, they never go in the run; nor do they come from where none sends them.
        let goes_on = |tag: u32| {
            let is_taken = self.kernels.iter().any(|kernel| kernel.takes().contains(&tag));
            is_taken || self.program.states.role(tag) == Some(StateRole::Finished)
        };
        let comes = |tag: u32| {
            let begins = |course: &Course| [course.unborn, course.born].contains(&tag);
            self.program.courses.iter().any(begins)
                || self
                    .kernels
                    .iter()
                    .any(|kernel| kernel.sends().iter().any(|sent| sent.to == tag && sent.from != tag))
        };
        let takes: Vec<u32> = kernel.takes().iter().copied().filter(|&tag| comes(tag)).collect();
        if !takes.is_empty() {
            line("takes", list(&takes, |&tag| state(tag)));
        }
        if !kernel.sends().is_empty() {
            let sent = |sent: &Transition| {
                "\n    ".to_owned()
                    + &table([("from", state(sent.from)), ("when", quoted(sent.when)), ("to", state(sent.to))])
            };
            let all: Vec<String> =
                kernel.sends().iter().filter(|sent| goes_on(sent.to) && comes(sent.from)).map(sent).collect();
            line("sends", format!("[{},\n]", all.join(",")));
        }
        match kernel.counts() {
            _ if kernel.is_counted_anew(&self.plan.features) => line("counts", quoted("anew")),
            Counts::AllTo(_) => line("counts", quoted("all")),
            Counts::Anew => line("counts", quoted("anew")),
            Counts::Sent | Counts::None => {}
        }
        if let Some(list) = info.list.filter(|_| self.plan.features.live_lists) {
            line("list", quoted(kernel.bound(list)));
        }
        if let Launch::List { each, .. } = info.launch
            && each > 1
        {
            line("each", each.to_string());
        }
        if instance.parameter > 0 {
            line("parameter", instance.parameter.to_string());
        }
        let is_there = |name: &str| {
            self.program.buffer(name).is_some()
                || self.program.stream(name).is_some_and(|stream| self.has(stream))
                || self.plan.features.live_lists && self.program.lists.iter().any(|list| list.name == name)
        };
        let binds: Vec<_> = instance.binds.iter().filter(|(_, bound)| is_there(bound)).collect();
        if !binds.is_empty() {
            line("binds", table(binds.iter().map(|(own, bound)| (*own, quoted(bound)))));
        }
        if !instance.renews.is_empty() {
            line("renews", list(instance.renews, |set| quoted(set.name)));
        }
        if !instance.adopts.is_empty() {
            line("adopts", table(instance.adopts.iter().map(|(to, from)| (to.name(), quoted(from.name())))));
        }
        if !instance.sets.is_empty() {
            line("features", table(instance.sets.iter().map(|(name, is_on)| (*name, is_on.to_string()))));
        }
        if let Some(renamed) = instance.renamed {
            let own = info.home.states;
            let name = |(tag, here): &(u32, u32)| {
                let here = self.program.states.iter().find(|state| state.tag == *here);
                (own.name(*tag), here.map_or("", |state| state.name))
            };
            let pairs = renamed.tags.iter().map(name).filter(|(own, here)| own != here);
            line("states", table(pairs.map(|(own, here)| (own, quoted(here)))));
        }
        let in_place = variant.loads_of_others();
        if !in_place.is_empty() {
            line("in_place", list(in_place, |stream| quoted(stream.name())));
        }
        text
    }
}

/// The sets whose elements a loop waits for.
fn looped_sets(steps: &[Step], sets: &mut BTreeSet<&'static str>) {
    for step in steps {
        if let Step::RepeatWhileAny(set, _) = step {
            sets.insert(set.name);
        }
        looped_sets(step.body().unwrap_or_default(), sets);
    }
}

fn meaning_name(meaning: Meaning) -> &'static str {
    match meaning {
        Meaning::Float => "float",
        Meaning::Distance => "distance",
        Meaning::Light => "light",
        Meaning::Count => "count",
        Meaning::Id => "id",
        Meaning::Tag => "state",
    }
}

#[cfg(test)]
mod tests;
