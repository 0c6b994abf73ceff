//! The tables of a user's program, from `program.toml` and its WGSL files.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;

use super::manifest::{self, Manifest, Named, Way};
use super::steps::schedule;
use super::{Own, OwnResult, start};
use crate::compose::{Word, WordKind, words};
use crate::options::features::Features;
use crate::options::folder::Folder;
use crate::options::reasons::{Because, Reason, Run};
use crate::plan::variants;
use crate::program::breaks::Break;
use crate::program::kernel::{Path, Proof};
use crate::program::rounding::Rounding;
use crate::program::schedule::Schedule;
use crate::program::{Course, Home, Instance, KernelInfo, Module, Program, Twin, UserFile};
use crate::programs::{closest_hit, primitives};
use crate::shader::{Mistake, Place, ShaderError, name_of_copy, place_in};
use crate::shared::launch::{BLOCK, MOST_ELEMENTS};
use crate::tables::elements::{Count, Elements, Size};
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::{StateInfo, StateRole, States, Tag};
use crate::tables::stream::{Meaning, Stream, StreamInfo, Texel};

/// Longest side of an image of elements.
const MOST_SIDE: u32 = 1 << 14;
/// Most layers of a stream: core WebGPU's textures have 256.
const MOST_LAYERS: usize = 256;
/// Most bytes of all streams together.
const MOST_BYTES: u64 = 1 << 31;

/// Colours of kernels and states, readable on light and dark backgrounds (Okabe and Ito 2008, and between them).
const COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 140, 200],
    [200, 140, 0],
    [120, 94, 180],
    [140, 140, 60],
];

fn colour(index: usize) -> [u8; 3] {
    COLOURS[index % COLOURS.len()]
}

fn unused(_: &Run<'_>) -> Reason {
    (Because::Options, "no kernel of the schedule uses it")
}

fn leaked(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

fn all_leaked(texts: &[String]) -> &'static [&'static str] {
    Vec::leak(texts.iter().map(|text| leaked(text)).collect())
}

/// The modules that a user's kernels may import from, besides those of their own files.
fn modules(features: &Features) -> Vec<Module> {
    let own = primitives::MODULES.iter().map(|&(name, source)| (name, Cow::Borrowed(source)));
    (closest_hit::PROGRAM.modules)(features).into_iter().chain(own).collect()
}

/// Reads a program.
pub(super) fn read(folder: &Arc<Folder>) -> Result<Own, Mistake> {
    let file = folder.named(Folder::MANIFEST);
    let everywhere = |message: String| Mistake {
        place: Place { file: file.clone(), line: 0, column: 0, text: String::new() },
        message,
    };
    let bytes = folder.file(Folder::MANIFEST).unwrap_or_default();
    let text = std::str::from_utf8(bytes).map_err(|_| everywhere("not a text in UTF-8".into()))?;
    let at = |range: Range<usize>, message: String| Mistake { place: place_in(&file, text, range.start), message };
    let manifest: Manifest = toml::from_str(text).map_err(|error| match error.span() {
        Some(span) => at(span, error.message().to_owned()),
        None => everywhere(error.message().to_owned()),
    })?;
    let of = Reader { folder, text, file: &file, manifest: &manifest };
    let files = of.files()?;
    let sets = of.sets()?;
    let (program, order) = of.program(&sets, files, &[])?;
    // Which streams need a copy, the shaders tell; with the copies they are other shaders.
    let copies = of.copies(program, &order)?;
    let (program, order) = if copies.is_empty() { (program, order) } else { of.program(&sets, files, &copies)? };
    let all = variants(program, &order, &Features::default(), &[]).map_err(|error| of.shader(error))?;
    drop(all);
    let bytes = program.streams().fold(0u64, |sum, stream| {
        let size = sets.iter().find(|(set, _)| set.name == stream.info().elements.name).and_then(|(_, size)| *size);
        sum.saturating_add(size.and_then(|size| stream.bytes(size.texels())).unwrap_or(0))
    });
    if bytes > MOST_BYTES {
        return Err(everywhere(format!("its streams take {bytes} bytes: at most {MOST_BYTES} are allowed")));
    }
    let sizes: Vec<_> = sets.iter().filter_map(|&(set, size)| Some((set, size?))).collect();
    let inputs = of.inputs(program, &sizes)?;
    let result = of.result(program)?;
    Ok(Own { program, schedule: order, sizes, inputs, result })
}

/// A set of elements, and its size if it is known.
type SizedSet = (&'static Elements, Option<Size>);

struct Reader<'a> {
    folder: &'a Arc<Folder>,
    text: &'a str,
    file: &'a str,
    manifest: &'a Manifest,
}

/// The kernel at an index loads other elements of a stream with this name.
type Copied = (usize, String);

impl Reader<'_> {
    fn at(&self, range: Range<usize>, message: impl Into<String>) -> Mistake {
        Mistake { place: place_in(self.file, self.text, range.start), message: message.into() }
    }

    fn shader(&self, error: ShaderError) -> Mistake {
        match error {
            ShaderError::Mistake(mistake) => *mistake,
            other => self.at(0..0, other.to_string()),
        }
    }

    /// The names of a table: those of variables of WGSL.
    fn names<T>(&self, table: &Named<T>, what: &str) -> Result<(), Mistake> {
        for (name, entry) in &table.0 {
            let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
                && name.chars().all(|c| c == '_' || c.is_ascii_alphanumeric())
                && name.len() <= 64
                && !name.contains("__")
                && !name.ends_with("_before");
            if !is_name {
                let message = format!(
                    "{what} cannot be named {name}: names have letters, digits and single underscores, and do not end in \
                     _before"
                );
                return Err(self.at(entry.span(), message));
            }
        }
        Ok(())
    }

    /// All WGSL files of the folder, and the constants of the manifest as a module.
    fn files(&self) -> Result<&'static [UserFile], Mistake> {
        let mut files: Vec<UserFile> = Vec::new();
        let ours: Vec<&str> = modules(&Features::default()).into_iter().map(|(name, _)| name).collect();
        let reserved = ["program", "constants", "state", "live", "lists"];
        for (path, bytes) in self.folder.files() {
            let Some(stem) = path.strip_suffix(".wgsl") else { continue };
            let module = stem.rsplit('/').next().unwrap_or(stem);
            let file = self.folder.named(path);
            let wrong = |message: String| Mistake { place: place_in(&file, "", 0), message };
            if ours.contains(&module) || reserved.contains(&module) || files.iter().any(|other| other.module == module)
            {
                return Err(wrong(format!("package::{module} is another module: give the file another name")));
            }
            let source = std::str::from_utf8(bytes).map_err(|_| wrong("not a text in UTF-8".into()))?;
            files.push(UserFile { module: leaked(module), file: leaked(&file), source: leaked(source) });
        }
        self.names(&self.manifest.constants, "a constant")?;
        let mut text = String::new();
        for (name, value) in &self.manifest.constants.0 {
            let value_of = start::constant(value.get_ref()).ok_or_else(|| {
                self.at(value.span(), "a constant is a number, true or false, or a list of two to four numbers")
            })?;
            text += &format!("const {name} = {value_of};\n");
        }
        files.push(UserFile { module: "program", file: leaked(self.file), source: leaked(&text) });
        Ok(Vec::leak(files))
    }

    fn sets(&self) -> Result<Vec<SizedSet>, Mistake> {
        let table = &self.manifest.elements;
        self.names(table, "a set of elements")?;
        if table.0.is_empty() {
            return Err(self.at(0..0, "no elements: [elements] needs a set such as cells = { image = [256, 256] }"));
        }
        let mut sets = Vec::new();
        for (name, entry) in &table.0 {
            let wrong = |message: &str| self.at(entry.span(), format!("{name}: {message}"));
            let (count, size) = match *entry.get_ref() {
                manifest::Set { image: Some([width, height]), count: None, per: None, found: None, .. } => {
                    if !(1..=MOST_SIDE).contains(&width) || !(1..=MOST_SIDE).contains(&height) {
                        return Err(wrong(&format!("an image has 1 to {MOST_SIDE} columns and rows")));
                    }
                    (Count::Image, Some(Size { width, height, count: width * height }))
                }
                manifest::Set { image: None, count: Some(count), per: None, found: None, .. } => {
                    let size = Size::folded(count.into(), MOST_SIDE).filter(|_| u64::from(count) <= MOST_ELEMENTS);
                    let message = || wrong(&format!("a set has at most {MOST_ELEMENTS} elements"));
                    (Count::Given, Some(size.ok_or_else(message)?))
                }
                manifest::Set { image: None, count: None, per: Some(ref of), found: None, block, each } => {
                    let (per, each) = (block.unwrap_or(BLOCK as u32), each.unwrap_or(1));
                    if per == 0 || each == 0 {
                        return Err(wrong("block and each are at least 1"));
                    }
                    if !table.0.iter().any(|(other, _)| other == of) || of == name {
                        return Err(wrong(&format!("no other set is named {of}")));
                    }
                    (Count::Per { of: leaked(of), per, each }, None)
                }
                manifest::Set { image: None, count: None, per: None, found: Some(ref found), .. } => {
                    let (stream, layer) = found.split_once('.').unwrap_or((found, ""));
                    let known = self.manifest.streams.0.iter().find(|(name, _)| name == stream);
                    let (_, column) = known.ok_or_else(|| wrong(&format!("no stream is named {stream}")))?;
                    let layers = layers(column.get_ref());
                    let layer = match layer {
                        "" => Some(0),
                        layer => layers.iter().position(|name| name == layer),
                    };
                    let layer = layer.ok_or_else(|| wrong(&format!("{stream} has no such layer")))?;
                    (Count::Found { in_stream: leaked(stream), layer }, None)
                }
                _ => return Err(wrong("a set has one of image = [columns, rows], count, per and found")),
            };
            let set: &'static Elements = Box::leak(Box::new(Elements { name: leaked(name), count }));
            sets.push((set, size));
        }
        if let Some((set, None)) = sets.first() {
            let message = format!("the first set, {}, is the main one: it needs image or count", set.name);
            return Err(self.at(table.0[0].1.span(), message));
        }
        Ok(sets)
    }

    fn states(&self) -> Result<&'static [StateInfo], Mistake> {
        let table = &self.manifest.states;
        self.names(table, "a state")?;
        let info = |(index, (name, entry)): (usize, &(String, Spanned<manifest::State>))| StateInfo {
            tag: index as Tag,
            name: leaked(name),
            role: entry.get_ref().role.into(),
            colour: colour(index + 3),
            meaning: leaked(&entry.get_ref().meaning),
        };
        Ok(Vec::leak(table.0.iter().enumerate().map(info).collect()))
    }

    fn streams(
        &self,
        sets: &[SizedSet],
        states: &[StateInfo],
        copies: &[Copied],
    ) -> Result<&'static [StreamInfo], Mistake> {
        let table = &self.manifest.streams;
        self.names(table, "a stream")?;
        let mut streams: Vec<StreamInfo> = Vec::new();
        for (name, entry) in &table.0 {
            let wrong = |message: String| self.at(entry.span(), format!("{name}: {message}"));
            let column = entry.get_ref();
            let elements = match &column.of {
                None => sets[0].0,
                Some(of) => {
                    let found = sets.iter().find(|(set, _)| set.name == of);
                    found.ok_or_else(|| wrong(format!("no set of elements is named {of}")))?.0
                }
            };
            let texel: Texel = column.texel.into();
            let layers = layers(column);
            let mut distinct = layers.clone();
            distinct.sort();
            distinct.dedup();
            if layers.is_empty() || layers.len() > MOST_LAYERS || distinct.len() < layers.len() {
                return Err(wrong(format!("it has 1 to {MOST_LAYERS} layers with different names")));
            }
            let meant: Vec<Meaning> = match &column.meaning {
                Some(given) => given.list().into_iter().map(Meaning::from).collect(),
                None => vec![if texel == Texel::F32 { Meaning::Float } else { Meaning::Count }],
            };
            let meaning = if meant.len() == 1 { vec![meant[0]; layers.len()] } else { meant };
            if meaning.len() != layers.len() {
                return Err(wrong(format!("it has {} layers and {} meanings", layers.len(), meaning.len())));
            }
            let tagged = meaning.iter().position(|meaning| *meaning == Meaning::Tag);
            if tagged.is_some_and(|layer| layer > 0) || tagged.is_some() && (texel != Texel::U32 || states.is_empty()) {
                return Err(wrong(
                    "a state is the first layer of a stream of type u32, and [states] lists them".into(),
                ));
            }
            let mut unwritten = start::unwritten(column.start.as_ref(), texel, layers.len()).map_err(&wrong)?;
            if tagged.is_some() && column.start.is_none() {
                let unborn = states.iter().find(|state| state.role == StateRole::Unborn);
                unwritten[0] = unborn.or(states.first()).map_or(0, |state| state.tag);
            }
            streams.push(StreamInfo {
                index: streams.len(),
                name: leaked(name),
                elements,
                texel,
                layers: all_leaked(&layers),
                meaning: Vec::leak(meaning),
                unit: leaked(&column.unit),
                unwritten: Vec::leak(unwritten),
                why_absent: unused,
            });
        }
        let copied: Vec<StreamInfo> =
            streams.iter().filter(|s| copies.iter().any(|(_, c)| c == s.name)).copied().collect();
        for stream in copied {
            streams.push(StreamInfo { index: streams.len(), name: leaked(&name_of_copy(stream.name)), ..stream });
        }
        Ok(Vec::leak(streams))
    }

    /// The program and its schedule.
    fn program(
        &self,
        sets: &[SizedSet],
        files: &'static [UserFile],
        copies: &[Copied],
    ) -> Result<(&'static Program, Schedule), Mistake> {
        let states = self.states()?;
        let streams = self.streams(sets, states, copies)?;
        let mut kernels = Vec::new();
        self.names(&self.manifest.kernels, "a kernel")?;
        for (index, (name, entry)) in self.manifest.kernels.0.iter().enumerate() {
            let copied = copies.iter().filter(|(of, _)| *of == index).map(|(_, stream)| stream.as_str());
            let copied: Vec<&str> = copied.collect();
            let instance =
                self.kernel((index, name, entry), sets, files, [states, &[]].concat().leak(), streams, &copied)?;
            kernels.push(instance);
        }
        if kernels.is_empty() {
            return Err(self.at(0..0, "no kernels: [kernels] needs one such as step = { }, with its WGSL in step.wgsl"));
        }
        let tagged = streams.iter().filter(|s| s.meaning[0] == Meaning::Tag && !s.name.ends_with("_before"));
        let with = |role: StateRole| states.iter().find(|state| state.role == role).map(|state| state.tag);
        let course = |stream: &'static StreamInfo| {
            let unborn = stream.unwritten[0];
            let done = with(StateRole::Finished).unwrap_or(unborn);
            Course {
                stream: Stream::of(stream),
                inputs: &[],
                unborn,
                born: with(StateRole::Active).unwrap_or(unborn),
                given_up: |tag| tag,
                done,
            }
        };
        let elements: Vec<&'static Elements> = sets.iter().map(|(set, _)| *set).collect();
        let program: &'static Program = Box::leak(Box::new(Program {
            name: leaked(&self.folder.name),
            summary: leaked(&self.manifest.summary),
            elements: Vec::leak(elements),
            streams,
            states: States(states),
            courses: Vec::leak(tagged.map(course).collect()),
            rays: None,
            results: None,
            buffers: &[],
            lists: &[],
            kernels: Vec::leak(kernels),
            modules,
            files,
        }));
        if let Some(fault) = program.faults().first() {
            return Err(self.at(0..0, fault.to_string()));
        }
        let order = schedule(program, &self.manifest.schedule.steps);
        let mut order = order.map_err(|(range, message)| self.at(range, message))?;
        if order.steps.is_empty() {
            return Err(self.at(0..0, "the schedule is empty: steps = [{ run = \"KERNEL\" }]"));
        }
        for (name, entry) in self.manifest.streams.0.iter().rev() {
            let Some(by) = start::kernel(entry.get_ref().start.as_ref()) else { continue };
            let kernel =
                program.kernel(by).ok_or_else(|| self.at(entry.span(), format!("{name}: no kernel is named {by}")))?;
            let first = crate::program::schedule::Step::Run(kernel);
            if !order.steps.contains(&first) {
                order.steps.insert(0, first);
            }
        }
        Ok((program, order))
    }

    fn kernel(
        &self,
        (index, name, entry): (usize, &str, &Spanned<manifest::Kernel>),
        sets: &[SizedSet],
        files: &'static [UserFile],
        states: &'static [StateInfo],
        streams: &'static [StreamInfo],
        copied: &[&str],
    ) -> Result<Instance, Mistake> {
        let wrong = |message: String| self.at(entry.span(), format!("{name}: {message}"));
        let written = entry.get_ref();
        let path = written.file.clone().unwrap_or_else(|| format!("{name}.wgsl"));
        let named = self.folder.named(&path);
        let file = files.iter().find(|file| file.file == named && file.module != "program");
        let file = file.ok_or_else(|| wrong(format!("its file {path} is not in the folder")))?;
        let point = EntryPoint::of(file.source, name).ok_or_else(|| Mistake {
            place: place_in(file.file, file.source, 0),
            message: format!("it has no @compute function, which kernel {name} needs"),
        })?;
        let over = match &written.over {
            None => sets[0].0,
            Some(over) => {
                let found = sets.iter().find(|(set, _)| set.name == over);
                found.ok_or_else(|| wrong(format!("no set of elements is named {over}")))?.0
            }
        };
        let is_image = over.count == Count::Image;
        let launch = if is_image { Launch::Whole } else { Launch::List { each: 1, weight: 1 } };
        let workgroup = match (is_image, point.workgroup) {
            (true, Some([x, y])) if x == y && (1..=16).contains(&x) => x,
            (false, None) => BLOCK as u32,
            (false, Some([x, 1])) if x == BLOCK as u32 => x,
            _ => {
                let right = if is_image { "@workgroup_size(8, 8)" } else { "@workgroup_size(BLOCK)" };
                let what = if is_image { "the pixels of an image" } else { "elements one after the other" };
                let message = format!("kernel {name} works on {}, which are {what}: it needs {right}", over.name);
                return Err(Mistake { place: place_in(file.file, file.source, point.at), message });
            }
        };
        let tag = |state: &String| {
            let found = states.iter().find(|info| info.name == state).map(|info| info.tag);
            found.ok_or_else(|| wrong(format!("no state is named {state}")))
        };
        let takes = written.takes.iter().map(tag).collect::<Result<Vec<Tag>, _>>()?;
        let send = |sent: &manifest::Sent| {
            Ok(Transition { from: tag(&sent.from)?, when: leaked(&sent.when), to: tag(&sent.to)? })
        };
        let sends = written.sends.iter().map(send).collect::<Result<Vec<Transition>, Mistake>>()?;
        let has_states = streams.iter().any(|s| s.elements.name == over.name && s.meaning[0] == Meaning::Tag);
        if !(has_states || takes.is_empty() && sends.is_empty()) {
            return Err(wrong(format!("{} have no states: a stream of them has meaning = \"state\"", over.name)));
        }
        let stream_named = |stream: &str| streams.iter().find(|info| info.name == stream).map(Stream::of);
        let mut binds: Vec<(&'static str, &'static str)> = Vec::new();
        for (own, bound) in &written.binds.0 {
            if stream_named(bound.get_ref()).is_none() {
                return Err(self.at(bound.span(), format!("no stream is named {}", bound.get_ref())));
            }
            binds.push((leaked(own), leaked(bound.get_ref())));
        }
        let mut copies = Vec::new();
        for stream in copied {
            let copy = name_of_copy(stream);
            let pair = stream_named(&copy).zip(stream_named(stream));
            copies.push(pair.ok_or_else(|| wrong(format!("no stream is named {copy}")))?);
            if let Some(&(own, _)) = binds.iter().find(|(_, bound)| bound == stream) {
                binds.push((leaked(&name_of_copy(own)), leaked(&copy)));
            }
        }
        let mut renews = Vec::new();
        for set in &written.renews {
            let found = sets.iter().find(|(other, _)| other.name == set);
            renews.push(found.ok_or_else(|| wrong(format!("no set of elements is named {set}")))?.0);
        }
        let info = KernelInfo {
            name: leaked(&point.name),
            wgsl: file.source,
            twin: Twin::Interpreted,
            home: Box::leak(Box::new(Home { streams, states: States(states) })),
            counts: if takes.is_empty() && sends.is_empty() { Counts::None } else { Counts::Sent },
            role: if takes.is_empty() { Role::Once } else { Role::Step },
            takes: Vec::leak(takes),
            sends: Vec::leak(sends),
            workgroup,
            launch,
            resumes: |_| false,
            list: None,
            proof: Proof::NONE,
            colour: colour(index),
            why_absent: unused,
            summary: leaked(&written.summary),
            explain: |_, _, _| (None, String::new()),
            path: Path::Stays,
            rounding: Rounding::NONE,
            breaks: NO_BREAKS,
        };
        Ok(Instance {
            name: leaked(name),
            parameter: written.parameter,
            binds: Vec::leak(binds),
            renews: Vec::leak(renews),
            copies: Vec::leak(copies),
            ..Instance::of(info, over)
        })
    }

    /// Which kernels load other elements of a stream than they store.
    fn copies(&self, program: &'static Program, order: &Schedule) -> Result<Vec<Copied>, Mistake> {
        let all = variants(program, order, &Features::default(), &[]).map_err(|error| self.shader(error))?;
        let mut copies = Vec::new();
        for variant in all {
            let index = variant.kernel.index();
            let in_place = self.manifest.kernels.0.get(index).map(|(_, entry)| entry.get_ref().in_place.as_slice());
            for stream in variant.loads_of_others() {
                if !in_place.is_some_and(|names| names.iter().any(|name| name == stream.name())) {
                    copies.push((index, stream.name().to_owned()));
                }
            }
        }
        Ok(copies)
    }

    fn inputs(
        &self,
        program: &'static Program,
        sizes: &[(&'static Elements, Size)],
    ) -> Result<Vec<crate::tables::stream::StreamData>, Mistake> {
        let mut inputs = Vec::new();
        for (name, entry) in &self.manifest.streams.0 {
            let Some((kind, path)) = start::file(entry.get_ref().start.as_ref()) else { continue };
            let wrong = |message: String| self.at(entry.span(), format!("{name}: {message}"));
            let stream = program.stream(name).ok_or_else(|| wrong("it is missing".into()))?;
            let size = sizes.iter().find(|(set, _)| set.name == stream.info().elements.name);
            let size = size
                .ok_or_else(|| wrong("its elements are counted in the run, so it cannot start from a file".into()))?;
            let bytes = self.folder.file(path).ok_or_else(|| wrong(format!("{path} is not in the folder")))?;
            let read = start::read(stream, size.1, kind, bytes);
            inputs.push(read.map_err(|message| wrong(format!("{path}: {message}")))?);
        }
        Ok(inputs)
    }

    fn result(&self, program: &'static Program) -> Result<Option<OwnResult>, Mistake> {
        let Some(entry) = &self.manifest.result else { return Ok(None) };
        let shown = entry.get_ref();
        let wrong = |message: String| self.at(entry.span(), message);
        let stream = program.stream(&shown.stream);
        let stream = stream.ok_or_else(|| wrong(format!("no stream is named {}", shown.stream)))?;
        let layer = match &shown.layer {
            Some(name) => {
                let found = stream.info().layers.iter().position(|layer| layer == name);
                Some(found.ok_or_else(|| wrong(format!("{} has no layer {name}", shown.stream)))?)
            }
            None => (!stream.is_color()).then_some(0),
        };
        let is_image = stream.info().elements.count == Count::Image;
        let way = shown.show.unwrap_or(if is_image { Way::Image } else { Way::Plot });
        if way == Way::Image && !is_image {
            return Err(wrong(format!(
                "{} are not the pixels of an image: as = \"plot\" or \"table\"",
                stream.info().elements.name
            )));
        }
        if shown.range.is_some_and(|[low, high]| low >= high || !low.is_finite() || !high.is_finite()) {
            return Err(wrong(
                "range = [smallest, largest] has two different finite numbers, the smaller first".into(),
            ));
        }
        Ok(Some(OwnResult { stream, layer, way, range: shown.range, colours: shown.colours }))
    }
}

/// No kernel of a user's is broken on purpose.
const NO_BREAKS: &[Break] = &[];

fn layers(column: &manifest::Column) -> Vec<String> {
    column.layers.clone().unwrap_or_else(|| vec!["value".into()])
}

/// A `@compute` function, as far as words tell.
struct EntryPoint {
    name: String,
    /// The first two numbers of `@workgroup_size`; `None` for `BLOCK`.
    workgroup: Option<[u32; 2]>,
    /// Where it begins.
    at: usize,
}

impl EntryPoint {
    /// The one with this name, or the first.
    fn of(source: &str, wanted: &str) -> Option<Self> {
        let all = words(source);
        let code: Vec<&Word<'_>> = all.iter().filter(|word| word.kind != WordKind::Comment).collect();
        let mut first = None;
        for (at, word) in code.iter().enumerate().filter(|(_, word)| word.text == "fn") {
            let Some(name) = code.get(at + 1).map(|name| name.text) else { continue };
            // Its attributes follow what ends the declaration before it.
            let begin = code[..at].iter().rposition(|word| matches!(word.text, ";" | "}")).map_or(0, |end| end + 1);
            let attributes = &code[begin..at];
            if !attributes.iter().any(|word| word.text == "@compute") {
                continue;
            }
            let size = attributes.iter().position(|word| word.text == "@workgroup_size");
            let sides: Vec<&str> = attributes[size.map_or(attributes.len(), |size| size + 1)..]
                .iter()
                .take_while(|word| word.text != ")")
                .map(|word| word.text)
                .filter(|text| !matches!(*text, "(" | ","))
                .collect();
            let number = |text: &str| text.trim_end_matches(['u', 'i']).parse::<u32>().unwrap_or(0);
            let workgroup = match sides.as_slice() {
                ["BLOCK"] => None,
                [x] => Some([number(x), 1]),
                [x, y, ..] => Some([number(x), number(y)]),
                [] => Some([0, 0]),
            };
            let point = Self { name: name.to_owned(), workgroup, at: word.start };
            if name == wanted {
                return Some(point);
            }
            first = first.or(Some(point));
        }
        first
    }
}
