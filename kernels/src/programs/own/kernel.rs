//! The rows of a user's kernels.

use toml::Spanned;

use super::manifest::{self, Counted};
use super::reader::{Reader, SizedSet, all_leaked, colour, leaked, listed, name_of, unused};
use crate::compose::{Word, WordKind, words};
use crate::options::features::Features;
use crate::program::breaks::Break;
use crate::program::kernel::{Path, Proof};
use crate::program::rounding::Rounding;
use crate::program::{Home, Instance, KernelInfo, Program, Renamed, Twin, UserFile};
use crate::shader::{Mistake, name_of_copy, place_in};
use crate::shared::constants::{LIST_SIDE, WORKGROUP};
use crate::shared::launch::BLOCK;
use crate::tables::elements::{Count, Elements};
use crate::tables::kernel::{Counts, Launch, ListInfo, Role, Transition};
use crate::tables::state::{StateInfo, StateRole, States, Tag};
use crate::tables::stream::{Meaning, Stream, StreamInfo};

/// No kernel of a user's is broken on purpose.
const NO_BREAKS: &[Break] = &[];

/// Most elements that a thread works on.
const MOST_EACH: u32 = 64;

/// What a kernel may name.
pub(super) struct Tables<'a> {
    pub(super) sets: &'a [SizedSet],
    pub(super) files: &'static [UserFile],
    pub(super) states: &'static [StateInfo],
    pub(super) streams: &'static [StreamInfo],
    pub(super) lists: &'static [ListInfo],
    /// Our program for the scene, whose buffers it may bind.
    pub(super) base: Option<&'static Program>,
}

impl Tables<'_> {
    fn stream(&self, name: &str) -> Option<Stream> {
        self.streams.iter().find(|info| info.name == name).map(Stream::of)
    }

    fn set(&self, name: &str) -> Option<&'static Elements> {
        self.sets.iter().find(|(set, _)| set.name == name).map(|(set, _)| *set)
    }

    fn has(&self, name: &str) -> bool {
        let is_buffer = self.base.is_some_and(|base| base.buffer(name).is_some());
        is_buffer || self.stream(name).is_some() || self.lists.iter().any(|list| list.name == name)
    }
}

impl Reader<'_> {
    /// The row of a kernel, which loads these streams from copies.
    pub(super) fn kernel(
        &self,
        (index, name, entry): (usize, &str, &Spanned<manifest::Kernel>),
        tables: &Tables<'_>,
        copied: &[&str],
    ) -> Result<Instance, Mistake> {
        let wrong = |message: String| self.at(entry.span(), format!("{name}: {message}"));
        let written = entry.get_ref();
        let path = written.file.clone().unwrap_or_else(|| format!("{name}.wgsl"));
        let named = self.folder.named(&path);
        let file = tables.files.iter().find(|file| file.file == named && file.module != "program");
        let file = file.ok_or_else(|| wrong(format!("its file {path} is not in the folder")))?;
        let point = EntryPoint::of(file.source, name).ok_or_else(|| Mistake {
            place: place_in(file.file, file.source, 0),
            message: format!("it has no @compute function, which kernel {name} needs"),
        })?;
        let over = match &written.over {
            None => tables.sets[0].0,
            Some(over) => tables.set(over).ok_or_else(|| wrong(self.no_set(over)))?,
        };
        let role = match &written.role {
            None if written.takes.is_empty() => Role::Once,
            None => Role::Step,
            Some(role) => {
                let known = Role::NAMES.iter().find(|(name, _)| name == role).map(|(_, role)| *role);
                let names = || listed("roles", Role::NAMES.map(|(name, _)| name));
                known.ok_or_else(|| wrong(format!("no role is named {role}; {}", names())))?
            }
        };
        let each = written.each.unwrap_or(1);
        let is_image = over.count == Count::Image;
        if !(1..=MOST_EACH).contains(&each) || is_image && each > 1 {
            return Err(wrong(format!(
                "each is 1 to {MOST_EACH} elements of a set that is no image, one after the other"
            )));
        }
        let launch = match is_image {
            true if role == Role::Whole => Launch::Bands,
            true => Launch::Whole,
            false => Launch::List { each, weight: 1 },
        };
        let workgroup = match (is_image, point.workgroup) {
            (true, Threads::Square(x)) if (1..=16).contains(&x) => x,
            (false, Threads::InARow(x)) if x == BLOCK as u32 => x,
            _ => {
                let right = if is_image { "@workgroup_size(8, 8)" } else { "@workgroup_size(BLOCK)" };
                let what = if is_image { "the pixels of an image" } else { "elements one after the other" };
                let message = format!("kernel {name} works on {}, which are {what}: it needs {right}", over.name);
                return Err(Mistake { place: place_in(file.file, file.source, point.at), message });
            }
        };
        let (states, own) = self.renamed_states(entry, tables)?;
        let own_tag = |state: &String| {
            let tag = own.iter().position(|(_, here)| here == state).map(|tag| tag as Tag);
            let names = || listed("states", own.iter().map(|(name, _)| name.as_str()));
            tag.ok_or_else(|| wrong(format!("no state is named {state}; {}", names())))
        };
        let takes = written.takes.iter().map(own_tag).collect::<Result<Vec<Tag>, _>>()?;
        let send = |sent: &manifest::Sent| {
            Ok(Transition { from: own_tag(&sent.from)?, when: leaked(&sent.when), to: own_tag(&sent.to)? })
        };
        let sends = written.sends.iter().map(send).collect::<Result<Vec<Transition>, Mistake>>()?;
        let has_states = tables.streams.iter().any(|s| s.elements.name == over.name && s.meaning[0] == Meaning::Tag);
        if !(has_states || takes.is_empty() && sends.is_empty()) {
            return Err(wrong(format!("{} have no states: a stream of them has meaning = \"state\"", over.name)));
        }
        let counts = match (written.counts.unwrap_or(Counted::Sent), sends.as_slice()) {
            (_, []) => Counts::None,
            (Counted::Sent, _) => Counts::Sent,
            (Counted::Anew, _) => Counts::Anew,
            (Counted::All, sends) => {
                // Some may wait for another pass.
                let to = sends.iter().find(|sent| sent.from != sent.to).or(sends.first()).map_or(0, |sent| sent.to);
                if sends.iter().any(|sent| sent.to != to && sent.to != sent.from) {
                    return Err(wrong("counts = \"all\" is for a kernel that sends all elements to one state".into()));
                }
                Counts::AllTo(to)
            }
        };
        let (binds, copies) = self.binds(entry, tables, copied)?;
        let mut renews = Vec::new();
        for set in &written.renews {
            renews.push(tables.set(set).ok_or_else(|| wrong(self.no_set(set)))?);
        }
        let mut adopts = Vec::new();
        for (to, from) in &written.adopts.0 {
            let of = |name: &str| tables.stream(name).ok_or_else(|| self.at(from.span(), self.no_stream(name)));
            adopts.push((of(to)?, of(from.get_ref())?));
        }
        let mut sets = Vec::new();
        for (option, is_on) in &written.features.0 {
            if !Features::default().set(option, *is_on.get_ref()) {
                return Err(self.at(is_on.span(), format!("{option} is no option of @if")));
            }
            sets.push((leaked(option), *is_on.get_ref()));
        }
        let info = KernelInfo {
            name: leaked(&point.name),
            wgsl: file.source,
            twin: Twin::Interpreted,
            home: Box::leak(Box::new(Home { streams: tables.streams, states })),
            counts,
            role,
            takes: Vec::leak(takes),
            sends: Vec::leak(sends),
            workgroup,
            launch,
            resumes: |_| false,
            list: written.list.as_deref().map(leaked),
            proof: Proof::NONE,
            colour: colour(index),
            why_absent: unused,
            summary: leaked(&written.summary),
            explain: |_, _, _| (None, String::new()),
            path: Path::Stays,
            rounding: Rounding::NONE,
            breaks: NO_BREAKS,
        };
        let renamed = match written.states.0.is_empty() {
            true => None,
            false => {
                let pairs: Vec<(&str, &str)> = own.iter().map(|(own, here)| (own.as_str(), here.as_str())).collect();
                let renamed = Renamed::new(&info, States(tables.states), &pairs);
                Some(&*Box::leak(Box::new(renamed.ok_or_else(|| wrong("its states are not known".into()))?)))
            }
        };
        Ok(Instance {
            name: leaked(name),
            parameter: written.parameter,
            renamed,
            binds,
            sets: Vec::leak(sets),
            renews: Vec::leak(renews),
            adopts: Vec::leak(adopts),
            copies: Vec::leak(copies),
            ..Instance::of(info, over)
        })
    }

    /// The states of a kernel by their names in its WGSL; and pairs of such a name and the program's, empty if the state never
    /// occurs.
    fn renamed_states(
        &self,
        entry: &Spanned<manifest::Kernel>,
        tables: &Tables<'_>,
    ) -> Result<(States, Vec<(String, String)>), Mistake> {
        let named = &entry.get_ref().states;
        self.names(named, "a state")?;
        let here = |name: &str| tables.states.iter().find(|state| state.name == name);
        let mut pairs = Vec::new();
        for state in tables.states {
            let is_renamed = named.0.iter().any(|(own, here)| own == state.name || here.get_ref() == state.name);
            if !is_renamed {
                pairs.push((state.name.to_owned(), state.name.to_owned()));
            }
        }
        for (own, to) in &named.0 {
            if !to.get_ref().is_empty() && here(to.get_ref()).is_none() {
                let names = listed("states", tables.states.iter().map(|state| state.name));
                return Err(self.at(to.span(), format!("no state is named {}; {names}", to.get_ref())));
            }
            pairs.push((own.clone(), to.get_ref().clone()));
        }
        let info = |(tag, (own, to)): (usize, &(String, String))| match here(to) {
            Some(state) => StateInfo { tag: tag as Tag, name: leaked(own), ..*state },
            None => {
                let name = leaked(own);
                StateInfo { tag: tag as Tag, name, role: StateRole::Active, colour: colour(tag), meaning: "" }
            }
        };
        let states = Vec::leak(pairs.iter().enumerate().map(info).collect());
        Ok((States(states), pairs))
    }

    /// What is bound to names in a kernel's WGSL, and the copies that are made before it runs.
    fn binds(
        &self,
        entry: &Spanned<manifest::Kernel>,
        tables: &Tables<'_>,
        copied: &[&str],
    ) -> Result<(Binds, Vec<(Stream, Stream)>), Mistake> {
        let mut binds: Vec<(&'static str, &'static str)> = Vec::new();
        for (own, bound) in &entry.get_ref().binds.0 {
            if !tables.has(bound.get_ref()) {
                return Err(self.at(bound.span(), self.no_stream(bound.get_ref())));
            }
            binds.push((leaked(own), leaked(bound.get_ref())));
        }
        let mut copies = Vec::new();
        for stream in copied {
            let copy = name_of_copy(stream);
            let pair = tables.stream(&copy).zip(tables.stream(stream));
            copies.push(pair.ok_or_else(|| self.at(entry.span(), self.no_stream(&copy)))?);
            if let Some(&(own, _)) = binds.iter().find(|(_, bound)| bound == stream) {
                binds.push((leaked(&name_of_copy(own)), leaked(&copy)));
            }
        }
        Ok((Vec::leak(binds), copies))
    }

    /// The lists that kernels take their elements from.
    pub(super) fn lists(&self) -> Result<&'static [ListInfo], Mistake> {
        let mut names: Vec<&str> = Vec::new();
        for (_, entry) in &self.manifest.kernels.0 {
            let Some(list) = entry.get_ref().list.as_deref() else { continue };
            name_of(list, "a list").map_err(|message| self.at(entry.span(), message))?;
            if !names.contains(&list) {
                names.push(list);
            }
        }
        let list = |name: &&str| {
            let slots = all_leaked(&[format!("{name}_even"), format!("{name}_odd")]);
            ListInfo { name: leaked(name), slots: [slots[0], slots[1]] }
        };
        Ok(Vec::leak(names.iter().map(list).collect()))
    }
}

/// Pairs of a name in the WGSL and one in the program.
type Binds = &'static [(&'static str, &'static str)];

/// The threads of a workgroup: in a row, or as many along x and y.
#[derive(Clone, Copy)]
enum Threads {
    InARow(u32),
    Square(u32),
}

/// A `@compute` function, as far as words tell.
struct EntryPoint {
    name: String,
    workgroup: Threads,
    /// Where it begins.
    at: usize,
}

impl EntryPoint {
    /// The one with this name, or the first.
    pub(super) fn of(source: &str, wanted: &str) -> Option<Self> {
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
            let number = |text: &str| match text {
                "BLOCK" => BLOCK as u32,
                "LIST_SIDE" => LIST_SIDE,
                "WORKGROUP" => WORKGROUP,
                text => text.trim_end_matches(['u', 'i']).parse().unwrap_or(0),
            };
            let workgroup = match sides.as_slice() {
                [x] | [x, "1", ..] => Threads::InARow(number(x)),
                [x, y, ..] if number(x) == number(y) => Threads::Square(number(x)),
                _ => Threads::InARow(0),
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
