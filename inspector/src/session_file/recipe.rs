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
#[serde(deny_unknown_fields, remote = "Self")]
pub struct SavedRun {
    /// Its name; empty for the run that was open.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// The user's note.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Its scene and options, and for the run that was open its place and view.
    pub link: Link,
    /// The hash of the scene's contents, to recognise another scene.
    #[serde(default)]
    pub scene_hash: String,
    /// Runs on the CPU reference in f64.
    #[serde(default, skip_serializing_if = "is_false")]
    f64: bool,
    /// Does not count cells and tests.
    #[serde(default, skip_serializing_if = "is_false")]
    no_counters: bool,
    /// A camera with parallel rays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    parallel: Option<Parallel>,
    /// How many of the first passes run on the CPU reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    twins: Option<usize>,
    /// Edits by hand.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "edits")]
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

// `remote` makes the functions that are called here.
impl Serialize for SavedRun {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for SavedRun {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let read = Self::deserialize(from)?;
        read.check().map_err(D::Error::custom)?;
        Ok(read)
    }
}

impl SavedRun {
    /// What the types of its fields leave open.
    fn check(&self) -> Result<(), String> {
        if self.parallel.is_some_and(|parallel| parallel.half_height <= 0.0) {
            return Err("half_height: expected a number above 0".into());
        }
        let [width, height] = match self.link.ray {
            Some(LinkRay::Given(_)) => [1, 1],
            _ => self.link.size,
        };
        for (i, edit) in self.edits.iter().enumerate() {
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
        Ok(())
    }

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

fn edits<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Edit>, D::Error> {
    at_most(from, "edits", MOST_EDITS)
}
