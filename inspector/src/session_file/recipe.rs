//! A run as it is saved: a link, what a link cannot express, and edits.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{MOST_EDITS, at_most};
use crate::link::{Link, LinkRay};
use crate::runs::Recipe;
use crate::session::Edit;
use crate::settings::{DeviceKind, Settings, View};

/// A saved run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, try_from = "Unchecked")]
pub struct SavedRun {
    /// Its name; empty for the run that was open.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// The user's note.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Its scene and options, and for the run that was open its place and view.
    #[serde(serialize_with = "write_link")]
    pub link: Link,
    /// The hash of the scene's contents, to recognise another scene.
    pub scene_hash: String,
    /// Runs on the CPU reference in f64.
    #[serde(skip_serializing_if = "is_false")]
    f64: bool,
    /// Does not count cells and tests.
    #[serde(skip_serializing_if = "is_false")]
    no_counters: bool,
    /// A camera with parallel rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    parallel: Option<Parallel>,
    /// How many of the first passes run on the CPU reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    twins: Option<usize>,
    /// Edits by hand.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    edits: Vec<Edit>,
}

/// A saved run as it is in the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    #[serde(default)]
    name: String,
    #[serde(default)]
    note: String,
    #[serde(deserialize_with = "read_link")]
    link: Link,
    #[serde(default)]
    scene_hash: String,
    #[serde(default)]
    f64: bool,
    #[serde(default)]
    no_counters: bool,
    #[serde(default)]
    parallel: Option<Parallel>,
    #[serde(default)]
    twins: Option<usize>,
    #[serde(default, deserialize_with = "edits")]
    edits: Vec<Edit>,
}

/// A camera with parallel rays, as in [`View::Free`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Parallel {
    eye: [f64; 3],
    look_at: [f64; 3],
    up: [f64; 3],
    half_height: f64,
}

impl TryFrom<Unchecked> for SavedRun {
    type Error = String;

    fn try_from(read: Unchecked) -> Result<Self, String> {
        let Unchecked { name, note, link, scene_hash, f64, no_counters, parallel, twins, edits } = read;
        if parallel.is_some_and(|parallel| parallel.half_height <= 0.0) {
            return Err("half_height: expected a number above 0".into());
        }
        let [width, height] = match link.ray {
            Some(LinkRay::Given(_)) => [1, 1],
            _ => link.size,
        };
        for (i, edit) in edits.iter().enumerate() {
            let layers = edit.stream.layers();
            if edit.layer >= layers {
                let name = edit.stream.name();
                return Err(format!("edit {i}: {name} has layers 0 to {}, not {}", layers - 1, edit.layer));
            }
            if edit.x >= width || edit.y >= height {
                let (right, bottom) = (width - 1, height - 1);
                return Err(format!(
                    "edit {i}: the image has pixels 0,0 to {right},{bottom}, not {},{}",
                    edit.x, edit.y
                ));
            }
        }
        Ok(Self { name, note, link, scene_hash, f64, no_counters, parallel, twins, edits })
    }
}

impl SavedRun {
    /// A run of a scene; `place` has the scene's file, and the place and the view, if any.
    #[must_use]
    pub fn new(recipe: &Recipe, place: &Link, scene_hash: &str) -> Self {
        let Recipe { settings, edits, twins } = recipe;
        let own = settings.link();
        let link = Link {
            scene: place.scene.clone(),
            scene_index: place.scene_index,
            ray: own.ray.or(place.ray),
            pass: place.pass,
            stream: place.stream,
            zoom: place.zoom,
            pan: place.pan,
            ..own
        };
        let parallel = match settings.view {
            View::Free { eye, look_at, up, fov_deg: None, half_height } => {
                Some(Parallel { eye, look_at, up, half_height })
            }
            View::Free { .. } | View::Scene(_) => None,
        };
        Self {
            name: String::new(),
            note: String::new(),
            link,
            scene_hash: scene_hash.into(),
            f64: settings.device == DeviceKind::CpuF64,
            no_counters: !settings.counters,
            parallel,
            twins: *twins,
            edits: edits.clone(),
        }
    }

    /// With a name and a note.
    #[must_use]
    pub fn named(self, name: &str, note: &str) -> Self {
        Self { name: name.into(), note: note.into(), ..self }
    }

    /// How to make it.
    #[must_use]
    pub fn recipe(&self) -> Recipe {
        let mut settings = Settings::from(&self.link);
        if self.f64 {
            settings.device = DeviceKind::CpuF64;
        }
        if let Some(Parallel { eye, look_at, up, half_height }) = self.parallel {
            settings.view = View::Free { eye, look_at, up, fov_deg: None, half_height };
        }
        settings.counters = !self.no_counters;
        Recipe { settings, edits: self.edits.clone(), twins: self.twins }
    }
}

fn is_false(value: &bool) -> bool {
    !value
}

/// A link is stored as text: one line that can be copied from the file.
fn write_link<S: Serializer>(link: &Link, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(link)
}

fn read_link<'de, D: Deserializer<'de>>(from: D) -> Result<Link, D::Error> {
    String::deserialize(from)?.parse().map_err(D::Error::custom)
}

fn edits<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Edit>, D::Error> {
    at_most(from, "edits", MOST_EDITS)
}
