//! What of a stream view is saved.

use raystep_kernels::Stream;
use raystep_kernels::programs::closest_hit::streams;
use serde::{Deserialize, Serialize};

use crate::draw::stream::Colors;
use crate::names::maybe_saved_stream;

/// What of a view is saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Look {
    /// `None` shows the picture once there is one, and before that rays' states.
    #[serde(deserialize_with = "maybe_saved_stream")]
    pub(super) stream: Option<Stream>,
    /// `None` shows all components, where they are a colour.
    pub(super) layer: Option<usize>,
    pub(super) colors: Option<Colors>,
    pub(super) exposure: f32,
    /// Added to a colour.
    pub(super) offset: f32,
    /// `None` is from the values.
    pub(super) range: Option<[f32; 2]>,
    /// Points a texel; `None` fits the picture into the panel.
    pub(super) scale: Option<f32>,
    /// The texel in the middle of the panel.
    pub(super) center: [f32; 2],
}

impl Default for Look {
    fn default() -> Self {
        Self {
            stream: None,
            layer: None,
            colors: None,
            exposure: 1.0,
            offset: 0.0,
            range: None,
            scale: None,
            center: [0.0; 2],
        }
    }
}

impl Look {
    /// Whether the view shows a colour, where it shows this stream.
    pub(super) fn is_color(&self, stream: Option<Stream>) -> bool {
        self.layer.is_none() && self.stream.or(stream) == Some(streams::COLOR)
    }
}
