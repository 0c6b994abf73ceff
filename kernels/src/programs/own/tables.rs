//! The tables of a user's program, from `program.toml` and its WGSL files.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use super::kernel::Tables;
use super::manifest::{self, Manifest, Way};
use super::reader::{Reader, SizedSet, leaked, listed};
use super::steps::schedule;
use super::streams::{Copied, layers, place_of_start};
use super::{Own, OwnResult, start};
use crate::options::features::Features;
use crate::options::folder::Folder;
use crate::plan::variants;
use crate::program::schedule::Schedule;
use crate::program::{Course, Fault, Module, Program, UserFile};
use crate::programs::{self, primitives};
use crate::shader::{Mistake, Place, place_in};
use crate::shared::launch::{BLOCK, MOST_ELEMENTS};
use crate::tables::elements::{Count, Elements, Size};
use crate::tables::state::{StateRole, States};
use crate::tables::stream::{Meaning, Stream, StreamInfo};

/// Longest side of an image of elements.
const MOST_SIDE: u32 = 1 << 14;
/// Most bytes of all streams together.
pub(super) const MOST_BYTES: u64 = 1 << 31;

/// The modules that a user's kernels may import from, besides those of their own files: those of all our programs.
fn modules(features: &Features) -> Vec<Module> {
    let mut all: Vec<Module> =
        primitives::MODULES.iter().map(|&(name, source)| (name, Cow::Borrowed(source))).collect();
    for module in programs::all().flat_map(|program| (program.modules)(features)) {
        if !all.iter().any(|(name, _)| *name == module.0) {
            all.push(module);
        }
    }
    all
}

/// A message of the reader of TOML, without names of types of Rust.
fn plain(message: &str) -> String {
    const WORDS: [(&str, &str); 6] = [
        ("expected u32", "expected an integer from 0 to 4294967295"),
        ("expected f64", "expected a number"),
        ("expected a sequence", "expected a list"),
        ("expected a map", "expected a table"),
        ("type: sequence", "type: list"),
        ("type: map", "type: table"),
    ];
    WORDS.iter().fold(message.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// What is wrong with a program: its name is in the place.
fn without_name(fault: &Fault, program: &Program) -> String {
    let text = fault.to_string();
    let name = format!("{}: ", program.name);
    text.strip_prefix(name.as_str()).unwrap_or(&text).to_owned()
}

/// Reads a program, whose kernels are compiled with these options if they are known.
pub(super) fn read(folder: &Arc<Folder>, features: Option<Features>) -> Result<Own, Mistake> {
    let file = folder.named(Folder::MANIFEST);
    let everywhere = |message: String| Mistake {
        place: Place { file: file.clone(), line: 0, column: 0, text: String::new() },
        message,
    };
    let bytes = folder.file(Folder::MANIFEST).unwrap_or_default();
    let text = std::str::from_utf8(bytes).map_err(|_| everywhere("not a text in UTF-8".into()))?;
    let at = |range: Range<usize>, message: String| Mistake { place: place_in(&file, text, range.start), message };
    let manifest: Manifest = toml::from_str(text).map_err(|error| match error.span() {
        Some(span) => at(span, plain(error.message())),
        None => everywhere(plain(error.message())),
    })?;
    let of = Reader { folder, text, file: &file, manifest: &manifest };
    let files = of.files()?;
    let scene = of.scene()?;
    let base = scene.as_ref().map(|scene| scene.base().program());
    let sets = of.sets(base)?;
    let (program, order) = of.program(base, &sets, files, &[])?;
    // With a scene, kernels are compiled for it: what follows from their shaders is found then.
    let features = features.or(base.is_none().then_some(Features::default()));
    let (program, order) = match features {
        None => (program, order),
        Some(features) => {
            // Which streams need a copy, the shaders tell; with the copies they are other shaders.
            let copies = of.copies(program, &order, &features)?;
            let (program, order) =
                if copies.is_empty() { (program, order) } else { of.program(base, &sets, files, &copies)? };
            drop(variants(program, &order, &features, &[]).map_err(|error| of.shader(error))?);
            (program, order)
        }
    };
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
    let scene_sets = of.scene_sets(&sets);
    Ok(Own { program, schedule: order, sizes, inputs, result, scene, scene_sets })
}

impl Reader<'_> {
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

    fn sets(&self, base: Option<&'static Program>) -> Result<Vec<SizedSet>, Mistake> {
        let table = &self.manifest.elements;
        self.names(table, "a set of elements")?;
        if table.0.is_empty() {
            return Err(self.at(0..0, "no elements: [elements] needs a set such as cells = { image = [256, 256] }"));
        }
        let mut sets = Vec::new();
        for (name, entry) in &table.0 {
            let wrong = |message: &str| self.at(entry.span(), format!("{name}: {message}"));
            let (count, size) = match *entry.get_ref() {
                manifest::Set {
                    image: Some([width, height]),
                    count: None,
                    per: None,
                    found: None,
                    scene: None,
                    ..
                } => {
                    if !(1..=MOST_SIDE).contains(&width) || !(1..=MOST_SIDE).contains(&height) {
                        return Err(wrong(&format!("an image has 1 to {MOST_SIDE} columns and rows")));
                    }
                    (Count::Image, Some(Size { width, height, count: width * height }))
                }
                manifest::Set { image: None, count: Some(count), per: None, found: None, scene: None, .. } => {
                    let size = Size::folded(count.into(), MOST_SIDE).filter(|_| u64::from(count) <= MOST_ELEMENTS);
                    let message = || wrong(&format!("a set has at most {MOST_ELEMENTS} elements"));
                    (Count::Given, Some(size.ok_or_else(message)?))
                }
                manifest::Set {
                    image: None,
                    count: None,
                    per: Some(ref of),
                    found: None,
                    scene: None,
                    block,
                    each,
                } => {
                    let (per, each) = (block.unwrap_or(BLOCK as u32), each.unwrap_or(1));
                    if per == 0 || each == 0 {
                        return Err(wrong("block and each are at least 1"));
                    }
                    if !table.0.iter().any(|(other, _)| other == of) || of == name {
                        return Err(wrong(&format!("no other set is named {of}")));
                    }
                    (Count::Per { of: leaked(of), per, each }, None)
                }
                manifest::Set { image: None, count: None, per: None, found: None, scene: Some(ref of), .. } => {
                    let base = base.ok_or_else(|| wrong("a set of a scene's needs a table [scene]"))?;
                    let set = base.elements(of).filter(|set| matches!(set.count, Count::Image | Count::Given));
                    let sets = || base.elements.iter().filter(|set| matches!(set.count, Count::Image | Count::Given));
                    let named = || sets().map(|set| set.name).collect::<Vec<_>>().join(", ");
                    (set.ok_or_else(|| wrong(&format!("{} has {}, and no {of}", base.name, named())))?.count, None)
                }
                manifest::Set { image: None, count: None, per: None, found: Some(ref found), scene: None, .. } => {
                    let (stream, layer) = found.split_once('.').unwrap_or((found, ""));
                    let known = self.manifest.streams.0.iter().find(|(name, _)| name == stream);
                    let (_, column) = known.ok_or_else(|| wrong(&self.no_stream(stream)))?;
                    let layers = layers(column.get_ref());
                    let layer = match layer {
                        "" => Some(0),
                        layer => layers.iter().position(|name| name == layer),
                    };
                    let no_layer = || {
                        format!("there is no layer {found}; {}", listed("layers", layers.iter().map(String::as_str)))
                    };
                    let layer = layer.ok_or_else(|| wrong(&no_layer()))?;
                    (Count::Found { in_stream: leaked(stream), layer }, None)
                }
                _ => return Err(wrong("a set has one of image = [columns, rows], count, per, found and scene")),
            };
            let set: &'static Elements = Box::leak(Box::new(Elements { name: leaked(name), count }));
            sets.push((set, size));
        }
        if let Some((set, None)) = sets.first()
            && !matches!(set.count, Count::Image | Count::Given)
        {
            let message = format!("the first set, {}, is the main one: it needs image, count or scene", set.name);
            return Err(self.at(table.0[0].1.span(), message));
        }
        Ok(sets)
    }

    /// The sets that have as many elements as one of ours, and its name.
    fn scene_sets(&self, sets: &[SizedSet]) -> Vec<(&'static Elements, &'static str)> {
        let written = self.manifest.elements.0.iter().zip(sets);
        written.filter_map(|((_, entry), (set, _))| Some((*set, leaked(entry.get_ref().scene.as_deref()?)))).collect()
    }

    /// The program and its schedule.
    fn program(
        &self,
        base: Option<&'static Program>,
        sets: &[SizedSet],
        files: &'static [UserFile],
        copies: &[Copied],
    ) -> Result<(&'static Program, Schedule), Mistake> {
        let states = self.states()?;
        let streams = self.streams(sets, states, copies)?;
        let lists = self.lists()?;
        let tables = Tables { sets, files, states, streams, lists, base };
        let mut kernels = Vec::new();
        self.names(&self.manifest.kernels, "a kernel")?;
        for (index, (name, entry)) in self.manifest.kernels.0.iter().enumerate() {
            let copied = copies.iter().filter(|(of, _)| *of == index).map(|(_, stream)| stream.as_str());
            let copied: Vec<&str> = copied.collect();
            let instance = self.kernel((index, name, entry), &tables, &copied)?;
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
            buffers: base.map_or(&[], |base| base.buffers),
            lists,
            kernels: Vec::leak(kernels),
            modules,
            files,
        }));
        if let Some(fault) = program.faults().first() {
            return Err(self.at(self.place_of(fault), without_name(fault, program)));
        }
        let order = schedule(program, &self.manifest.schedule.steps);
        let mut order = order.map_err(|(range, message)| self.at(range, message))?;
        if order.steps.is_empty() {
            return Err(self.at(0..0, "the schedule is empty: steps = [{ run = \"KERNEL\" }]"));
        }
        for (name, entry) in self.manifest.streams.0.iter().rev() {
            let Some(by) = start::kernel(entry.get_ref().start()) else { continue };
            let missing = || self.at(place_of_start(entry), format!("{name}: {}", self.no_kernel(by)));
            let kernel = program.kernel(by).ok_or_else(missing)?;
            let first = crate::program::schedule::Step::Run(kernel);
            if !order.steps.contains(&first) {
                order.steps.insert(0, first);
            }
        }
        Ok((program, order))
    }

    /// The table that a fault is in.
    fn place_of(&self, fault: &Fault) -> Range<usize> {
        let Manifest { kernels, streams, states, elements, .. } = self.manifest;
        let found = match *fault {
            Fault::Transition { kernel, .. } | Fault::Adoption { kernel, .. } => kernels.span_of(kernel),
            Fault::Layers { stream, .. } | Fault::Begin { stream, .. } => streams.span_of(stream),
            Fault::Unreached { state, .. } | Fault::DeadEnd { state, .. } => states.span_of(state),
            Fault::Missing { of, .. } => kernels.span_of(of).or(streams.span_of(of)).or(elements.span_of(of)),
            Fault::Twice { .. } | Fault::Place { .. } | Fault::TooMany { .. } => None,
        };
        found.unwrap_or(0..0)
    }

    /// Which kernels load other elements of a stream than they store.
    fn copies(&self, program: &'static Program, order: &Schedule, features: &Features) -> Result<Vec<Copied>, Mistake> {
        let all = variants(program, order, features, &[]).map_err(|error| self.shader(error))?;
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

    fn result(&self, program: &'static Program) -> Result<Option<OwnResult>, Mistake> {
        let Some(entry) = &self.manifest.result else { return Ok(None) };
        let shown = entry.get_ref();
        let wrong = |message: String| self.at(entry.span(), message);
        let stream = program.stream(&shown.stream);
        let stream = stream.ok_or_else(|| wrong(self.no_stream(&shown.stream)))?;
        let layer = match &shown.layer {
            Some(name) => {
                let found = stream.info().layers.iter().position(|layer| layer == name);
                let layers = || listed("layers", stream.info().layers.iter().copied());
                Some(found.ok_or_else(|| wrong(format!("{} has no layer {name}; {}", shown.stream, layers())))?)
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
