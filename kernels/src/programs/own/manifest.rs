//! `program.toml` as it is written: names are not looked up yet.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use toml::Spanned;

use crate::tables::state::StateRole;
use crate::tables::stream::{Meaning, Texel};

/// The file.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Manifest {
    #[serde(default)]
    pub(super) summary: String,
    pub(super) scene: Option<Spanned<OfScene>>,
    #[serde(default)]
    pub(super) constants: Named<toml::Value>,
    pub(super) elements: Named<Set>,
    pub(super) streams: Named<Column>,
    #[serde(default)]
    pub(super) states: Named<State>,
    pub(super) kernels: Named<Kernel>,
    pub(super) schedule: Order,
    pub(super) result: Option<Spanned<Shown>>,
}

/// A table's entries in the order of the file, each with its place.
pub(super) struct Named<T>(pub(super) Vec<(String, Spanned<T>)>);

impl<T> Named<T> {
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Where the entry with a name is.
    pub(super) fn span_of(&self, name: &str) -> Option<Range<usize>> {
        self.0.iter().find(|(of, _)| of == name).map(|(_, entry)| entry.span())
    }
}

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Entries<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = Named<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Named<T>, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Named(entries))
            }
        }
        from.deserialize_map(Entries(PhantomData))
    }
}

/// A scene that kernels read.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { file = \"cornell-box\" }")]
pub(super) struct OfScene {
    /// The scene if none is named: a name, or a file in the folder.
    pub(super) file: Option<String>,
    /// The options of the run that it is prepared for, by their names on the command line.
    #[serde(default)]
    pub(super) options: Named<toml::Value>,
}

/// A set of elements: one of `image`, `count`, `per`, `found` and `scene`.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a set such as { image = [256, 256] }")]
pub(super) struct Set {
    /// Columns and rows.
    pub(super) image: Option<[u32; 2]>,
    /// Number of elements.
    pub(super) count: Option<u32>,
    /// Another set, of which a block of `block` elements has `each` of this one.
    pub(super) per: Option<String>,
    pub(super) block: Option<u32>,
    pub(super) each: Option<u32>,
    /// `STREAM` or `STREAM.LAYER`, whose first texel has the number.
    pub(super) found: Option<String>,
    /// The set of our program for the scene that has as many.
    pub(super) scene: Option<String>,
}

/// A stream.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a stream such as { type = \"f32\" }")]
pub(super) struct Column {
    pub(super) of: Option<String>,
    #[serde(rename = "type")]
    pub(super) texel: Type,
    pub(super) layers: Option<Vec<String>>,
    pub(super) meaning: Option<Meanings>,
    #[serde(default)]
    pub(super) unit: String,
    pub(super) start: Option<Spanned<toml::Value>>,
}

impl Column {
    pub(super) fn start(&self) -> Option<&toml::Value> {
        self.start.as_ref().map(Spanned::get_ref)
    }
}

/// One for all layers, or a list.
#[derive(Clone, serde::Deserialize)]
#[serde(untagged, expecting = "expected float, distance, light, count, id or state, or a list of them")]
pub(super) enum Meanings {
    One(Means),
    List(Vec<Means>),
}

impl Meanings {
    pub(super) fn list(&self) -> Vec<Means> {
        match self {
            Self::One(one) => vec![*one],
            Self::List(list) => list.clone(),
        }
    }
}

#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Type {
    F32,
    U32,
}

impl From<Type> for Texel {
    fn from(of: Type) -> Self {
        match of {
            Type::F32 => Self::F32,
            Type::U32 => Self::U32,
        }
    }
}

#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Means {
    Float,
    Distance,
    Light,
    Count,
    Id,
    State,
}

impl From<Means> for Meaning {
    fn from(of: Means) -> Self {
        match of {
            Means::Float => Self::Float,
            Means::Distance => Self::Distance,
            Means::Light => Self::Light,
            Means::Count => Self::Count,
            Means::Id => Self::Id,
            Means::State => Self::Tag,
        }
    }
}

/// A state.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a state such as { role = \"active\" }")]
pub(super) struct State {
    pub(super) role: Role,
    #[serde(default)]
    pub(super) meaning: String,
}

#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Role {
    Unborn,
    Active,
    Resolved,
    Finished,
}

impl From<Role> for StateRole {
    fn from(of: Role) -> Self {
        match of {
            Role::Unborn => Self::Unborn,
            Role::Active => Self::Active,
            Role::Resolved => Self::Resolved,
            Role::Finished => Self::Finished,
        }
    }
}

/// A kernel.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a kernel such as { summary = \"…\" }")]
pub(super) struct Kernel {
    /// Its file; `NAME.wgsl` if it is not given.
    pub(super) file: Option<String>,
    /// The set that it is launched over; the first if it is not given.
    pub(super) over: Option<String>,
    #[serde(default)]
    pub(super) summary: String,
    #[serde(default)]
    pub(super) takes: Vec<String>,
    #[serde(default)]
    pub(super) sends: Vec<Sent>,
    #[serde(default)]
    pub(super) parameter: u32,
    /// Streams of the program by names in the WGSL.
    #[serde(default)]
    pub(super) binds: Named<String>,
    /// Sets whose numbers are read again before it runs.
    #[serde(default)]
    pub(super) renews: Vec<String>,
    /// Streams of which it reads and writes other elements, in pairs that no two threads share.
    #[serde(default)]
    pub(super) in_place: Vec<String>,
    /// Streams that it renames to others before it runs: the new name, and the old one.
    #[serde(default)]
    pub(super) adopts: Named<String>,
    /// The program's states by names in the WGSL; an empty one for a state that never occurs.
    #[serde(default)]
    pub(super) states: Named<String>,
    /// Options of `@if` that are others than in the run.
    #[serde(default)]
    pub(super) features: Named<bool>,
    /// The list of elements that wait for it.
    pub(super) list: Option<String>,
    /// What it is in a run, if not `step`, or `once` for one that takes no states.
    pub(super) role: Option<String>,
    /// Elements per thread.
    pub(super) each: Option<u32>,
    /// How the states that it sends elements to are counted.
    pub(super) counts: Option<Counted>,
}

/// How states are counted after a pass.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Counted {
    /// By the kernel.
    Sent,
    /// All elements have the same.
    All,
    /// By another kernel, of role `count`.
    Anew,
}

/// A transition.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "{ from = \"STATE\", to = \"STATE\" }")]
pub(super) struct Sent {
    pub(super) from: String,
    pub(super) to: String,
    #[serde(default)]
    pub(super) when: String,
}

/// The schedule.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table with steps = […]")]
pub(super) struct Order {
    pub(super) steps: Vec<Spanned<Step>>,
}

/// A step of it: one of `run`, `repeat`, `while_any` and `until_idle`.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a step such as { run = \"KERNEL\" }")]
pub(super) struct Step {
    pub(super) run: Option<String>,
    pub(super) parameter: Option<Number>,
    pub(super) repeat: Option<Number>,
    pub(super) name: Option<String>,
    pub(super) while_any: Option<Awaited>,
    pub(super) until_idle: Option<String>,
    pub(super) steps: Option<Vec<Spanned<Step>>>,
}

/// What a loop waits for: a set without elements, or kernels that no element is active in.
#[derive(Clone, serde::Deserialize)]
#[serde(untagged, expecting = "expected the name of a set, or a list of kernels")]
pub(super) enum Awaited {
    Set(String),
    Kernels(Vec<String>),
}

/// A number, or one that counts with the turns of the loops around it.
#[derive(Clone, serde::Deserialize)]
#[serde(untagged, expecting = "expected a number from 0 to 4294967295, or { first = NUMBER, by = [NUMBER, …] }")]
pub(super) enum Number {
    Always(u32),
    Counted {
        first: u32,
        #[serde(default)]
        by: Vec<u32>,
    },
}

/// What the result is.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { stream = \"NAME\" }")]
pub(super) struct Shown {
    pub(super) stream: String,
    pub(super) layer: Option<String>,
    #[serde(rename = "as")]
    pub(super) show: Option<Way>,
    /// What is black, or the colours' first, and what is white, or their last.
    pub(super) range: Option<[f64; 2]>,
    #[serde(default)]
    pub(super) colours: Colours,
}

/// How it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// A pixel for each element.
    Image,
    /// Values over the elements' numbers.
    Plot,
    /// Numbers.
    Table,
}

/// Colours of numbers in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Colours {
    /// From black to white.
    #[default]
    Gray,
    /// From violet over green to yellow.
    Viridis,
    /// From blue over grey to yellow.
    Cividis,
    /// From black over red to pale yellow.
    Magma,
}
