//! The saved part of a stream view.

use raystep_kernels::Stream;
use serde::{Deserialize, Serialize};

use crate::draw::stream::Colors;

/// The saved part of a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Look {
    /// `None` shows the image once it exists, and the rays' states before that.
    pub(super) stream: Option<Stream>,
    /// `None` shows all components, if they are a colour.
    pub(super) layer: Option<usize>,
    pub(super) colors: Option<Colors>,
    pub(super) exposure: f32,
    /// Added to a colour.
    pub(super) offset: f32,
    /// `None` takes it from the values.
    pub(super) range: Option<[f32; 2]>,
    /// Points per texel; `None` fits the picture to the panel.
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
    /// Whether the view shows a colour for this stream.
    pub(super) fn is_color(&self, stream: Option<Stream>) -> bool {
        self.layer.is_none() && self.stream.or(stream) == Some(Stream::Color)
    }
}
