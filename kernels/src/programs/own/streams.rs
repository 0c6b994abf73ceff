//! The streams of a user's program: what they keep, and what they begin with.

use std::ops::Range;

use toml::Spanned;

use super::manifest;
use super::reader::{Reader, SizedSet, all_leaked, colour, layers_in_words, leaked, unused};
use super::start;
use crate::program::Program;
use crate::shader::{Mistake, name_of_copy};
use crate::tables::elements::{Elements, Size};
use crate::tables::state::{StateInfo, StateRole, Tag};
use crate::tables::stream::{Meaning, StreamData, StreamInfo, Texel};

/// Most layers of a stream: core WebGPU's textures have 256.
const MOST_LAYERS: usize = 256;

/// The kernel at an index loads other elements of a stream with this name.
pub(super) type Copied = (usize, String);

impl Reader<'_> {
    pub(super) fn states(&self) -> Result<&'static [StateInfo], Mistake> {
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

    pub(super) fn streams(
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
                    found.ok_or_else(|| wrong(self.no_set(of)))?.0
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
                return Err(wrong(format!("it has {} and {} meanings", layers_in_words(layers.len()), meaning.len())));
            }
            let tagged = meaning.iter().position(|meaning| *meaning == Meaning::Tag);
            if tagged.is_some_and(|layer| layer > 0) || tagged.is_some() && (texel != Texel::U32 || states.is_empty()) {
                return Err(wrong(
                    "a state is the first layer of a stream of type u32, and [states] lists them".into(),
                ));
            }
            let unwritten = start::unwritten(column.start(), texel, layers.len());
            let mut unwritten =
                unwritten.map_err(|message| self.at(place_of_start(entry), format!("{name}: {message}")))?;
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

    pub(super) fn inputs(
        &self,
        program: &'static Program,
        sizes: &[(&'static Elements, Size)],
    ) -> Result<Vec<StreamData>, Mistake> {
        let mut inputs = Vec::new();
        if let Some((other, _)) = self.folder.starts().find(|(name, _)| program.stream(name).is_none()) {
            return Err(self.at(0..0, format!("starts: {}", self.no_stream(other))));
        }
        for (name, entry) in &self.manifest.streams.0 {
            let given = self.folder.starts().find(|(stream, _)| stream == name).map(|(_, bytes)| bytes);
            let (kind, path) = match (given, start::file(entry.get_ref().start())) {
                (Some(_), _) => (start::Kind::Npy, "the array"),
                (None, Some(file)) => file,
                (None, None) => continue,
            };
            let wrong = |message: String| self.at(place_of_start(entry), format!("{name}: {message}"));
            let stream = program.stream(name).ok_or_else(|| wrong("it is missing".into()))?;
            let size = sizes.iter().find(|(set, _)| set.name == stream.info().elements.name);
            let size = size
                .ok_or_else(|| wrong("its elements are counted in the run, so it cannot start from a file".into()))?;
            let bytes = given.or_else(|| self.folder.file(path));
            let bytes = bytes.ok_or_else(|| wrong(format!("{path} is not in the folder")))?;
            let read = start::read(stream, size.1, kind, bytes);
            inputs.push(read.map_err(|message| wrong(format!("{path}: {message}")))?);
        }
        Ok(inputs)
    }
}

/// Where a stream's `start` is; the stream, if an array is given in its place.
pub(super) fn place_of_start(entry: &Spanned<manifest::Column>) -> Range<usize> {
    entry.get_ref().start.as_ref().map_or(entry.span(), Spanned::span)
}

/// The names of a stream's layers.
pub(super) fn layers(column: &manifest::Column) -> Vec<String> {
    column.layers.clone().unwrap_or_else(|| vec!["value".into()])
}
