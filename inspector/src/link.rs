//! A permalink: what is looked at, in one line that the command line and the window both open.
//!
//! ```text
//! raystep:1?scene=scenes/cornell-box.gltf&accelerator=bvh&pixel=270,256&pass=41&stream=tmax.x
//! ```
//!
//! Keys are the command line's options without their dashes, in any order; a key that is left out has its
//! default, which a version of the link never changes. What a shell would take as its own between double
//! quotes is percent-encoded (RFC 3986). Numbers are decimal and come back bit for bit.
//!
//! | key | value | default |
//! |---|---|---|
//! | `scene`, `scene-index` | the scene's file as it was named, and which scene of it | |
//! | `scene-hash` | of the scene's contents ([`scene_hash`](crate::runs::scene_hash)): a file with another is said to be another scene | |
//! | `camera`; or `eye`, `look-at`, `up`, `fov` | number of the scene's camera; or points, and degrees | the first; up 0,1,0, fov 40 |
//! | `size` | WxH, pixels | 512x512 |
//! | every option that is [linked](raystep_kernels::options::rows::Row::is_linked), such as `accelerator` | as the option; true or false for one without a value | that of the option; `steps-per-pass` 1: every step is a pass |
//! | `device`, `adapter` | auto, gpu, cpu; part of an adapter's name | auto |
//! | `pixel`; or `ray` | X,Y; or origin and direction, decimal or the bits of an f32 in hex | |
//! | `pass` | passes that have run | |
//! | `stream` | NAME or NAME.LAYER | |
//! | `zoom`, `pan` | screen points a texel; texel in the middle of the view, X,Y | |

mod error;
mod read;

use std::fmt;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use raystep_kernels::options::Choices;
use raystep_kernels::options::rows::{ROWS, Row};
use raystep_kernels::{Stream, named};
use raystep_lab::Hash;
use smart_default::SmartDefault;

use crate::ray_text::GivenRay;
pub use error::LinkError;

/// Version of the text.
pub const VERSION: u32 = 1;

/// Most pixels each way.
pub const MOST_PIXELS: u32 = 32_768;
/// The keys that are not options of a run, in the order in which they are written; those come after `size`.
const KEYS: [&str; 17] = [
    "scene",
    "scene-index",
    "scene-hash",
    "camera",
    "eye",
    "look-at",
    "up",
    "fov",
    "size",
    "device",
    "adapter",
    "pixel",
    "ray",
    "pass",
    "stream",
    "zoom",
    "pan",
];

/// Every key.
pub fn keys() -> impl Iterator<Item = &'static str> {
    KEYS.into_iter().chain(linked().map(|row| row.name))
}

/// The options that links have.
fn linked() -> impl Iterator<Item = &'static Row> {
    ROWS.iter().filter(|row| row.is_linked)
}

/// What no shell takes as its own between double quotes, and what separates nothing here.
const KEPT: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'.')
    .remove(b'_')
    .remove(b'~')
    .remove(b'/')
    .remove(b',')
    .remove(b':')
    .remove(b'@');

/// The target of a link. Its defaults are those of [`VERSION`], which a test compares with those of the options.
#[derive(Clone, Debug, PartialEq, SmartDefault)]
pub struct Link {
    /// The scene's file as it was named.
    pub scene: Option<String>,
    /// Which scene of a file that holds several; `None` for the file's own choice.
    pub scene_index: Option<usize>,
    /// Hash of the scene's contents.
    pub scene_hash: Option<Hash>,
    /// The view.
    pub camera: LinkCamera,
    /// Width and height in pixels.
    #[default([512, 512])]
    pub size: [u32; 2],
    /// The options of the run.
    #[default(Choices::stepped())]
    pub choices: Choices,
    /// Where passes run.
    pub device: LinkDevice,
    /// Part of the name of a GPU adapter.
    pub adapter: Option<String>,
    /// The ray that is followed.
    pub ray: Option<LinkRay>,
    /// Passes that have run.
    pub pass: Option<usize>,
    /// The stream that is shown.
    pub stream: Option<LinkStream>,
    /// Screen points per texel.
    pub zoom: Option<f32>,
    /// The texel in the middle of the view.
    pub pan: Option<[f32; 2]>,
}

/// The view of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LinkCamera {
    /// By the scene's first camera, or one that frames it.
    #[default]
    Default,
    /// By a camera of the scene, counted from 0.
    Index(usize),
    /// A custom camera, in scene units.
    Placed {
        /// Its position.
        eye: [f64; 3],
        /// The point it looks at.
        look_at: [f64; 3],
        /// The up direction.
        up: [f64; 3],
        /// Vertical angle of view, degrees.
        fov_deg: f64,
    },
}

impl LinkCamera {
    /// The default up direction.
    pub const UP: [f64; 3] = [0.0, 1.0, 0.0];
    /// The default angle of view, degrees.
    pub const FOV_DEG: f64 = 40.0;
}

/// Where passes run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinkDevice {
    /// The best GPU, otherwise the CPU.
    #[default]
    Auto,
    /// The best adapter, even if it is software.
    Gpu,
    /// The CPU, by the CPU reference kernels.
    Cpu,
}

named!(LinkDevice, Auto "auto", Gpu "gpu", Cpu "cpu");

/// The selected ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkRay {
    /// The one through the centre of a pixel.
    Pixel([u32; 2]),
    /// A ray that was typed in.
    Given(GivenRay),
}

/// The displayed stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkStream {
    /// Which.
    pub stream: Stream,
    /// One of its layers; `None` for all of them.
    pub layer: Option<usize>,
}

/// The contents of a stream view, as in links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The stream, and one of its layers.
    pub stream: LinkStream,
    /// Points per texel; `None` fits the picture to its panel.
    pub zoom: Option<f32>,
    /// The texel in the middle.
    pub pan: Option<[f32; 2]>,
}

impl Shown {
    /// The view that a link requests, if it names a stream.
    #[must_use]
    pub fn of(link: &Link) -> Option<Self> {
        Some(Self { stream: link.stream?, zoom: link.zoom, pan: link.pan })
    }
}

impl Link {
    /// The keys and values that differ from the defaults.
    fn pairs(&self) -> Vec<(&'static str, String)> {
        let default = Self::default();
        let mut pairs = Vec::new();
        let mut add = |key: &'static str, value: Option<String>| pairs.extend(value.map(|value| (key, value)));
        add("scene", self.scene.clone());
        add("scene-index", self.scene_index.map(|n| n.to_string()));
        add("scene-hash", self.scene_hash.map(|hash| hash.to_string()));
        match self.camera {
            LinkCamera::Default => {}
            LinkCamera::Index(n) => add("camera", Some(n.to_string())),
            LinkCamera::Placed { eye, look_at, up, fov_deg } => {
                add("eye", Some(list(&eye)));
                add("look-at", Some(list(&look_at)));
                add("up", (up != LinkCamera::UP).then(|| list(&up)));
                add("fov", (fov_deg != LinkCamera::FOV_DEG).then(|| number(fov_deg)));
            }
        }
        let [width, height] = self.size;
        add("size", (self.size != default.size).then(|| format!("{width}x{height}")));
        // What a reader has from the keys before this one.
        let mut known = default.choices;
        for row in linked() {
            let value = row.get(&self.choices);
            if value != row.get(&known) && row.set(&mut known, &value.to_string()).is_ok() {
                add(row.name, Some(value.to_string()));
            }
        }
        add("device", (self.device != default.device).then(|| self.device.name().into()));
        add("adapter", self.adapter.clone());
        match self.ray {
            None => {}
            Some(LinkRay::Pixel(pixel)) => add("pixel", Some(list(&pixel))),
            Some(LinkRay::Given(GivenRay(numbers))) => add("ray", Some(list(&numbers))),
        }
        add("pass", self.pass.map(|n| n.to_string()));
        add("stream", self.stream.map(|s| s.to_string()));
        add("zoom", self.zoom.map(number));
        add("pan", self.pan.map(|p| list(&p)));
        pairs
    }
}

impl fmt::Display for Link {
    /// One line, safe between double quotes in a shell.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "raystep:{VERSION}")?;
        for (i, (key, value)) in self.pairs().into_iter().enumerate() {
            let separator = if i == 0 { '?' } else { '&' };
            write!(f, "{separator}{key}={}", utf8_percent_encode(&value, KEPT))?;
        }
        Ok(())
    }
}

impl fmt::Display for LinkStream {
    /// `tmax`, or `tmax.x` for one layer.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let info = self.stream.info();
        match self.layer.and_then(|layer| info.layers.get(layer)) {
            Some(layer) => write!(f, "{}.{layer}", info.name),
            None => f.write_str(info.name),
        }
    }
}

/// The shorter of two notations of a number; both parse to the same bits.
fn number(value: impl fmt::Display + fmt::Debug) -> String {
    let (plain, short) = (format!("{value}"), format!("{value:?}"));
    if short.len() < plain.len() { short } else { plain }
}

fn list<T: fmt::Display + fmt::Debug>(values: &[T]) -> String {
    values.iter().map(number).collect::<Vec<_>>().join(",")
}
