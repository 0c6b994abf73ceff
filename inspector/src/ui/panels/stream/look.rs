//! The saved part of a stream view.

use crate::ui::panels::zoom::Zoom;
use raystep_kernels::Stream;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use crate::draw::stream::Colors;
use crate::names::maybe_saved_stream;

/// The saved part of a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, SmartDefault)]
#[serde(default)]
pub(super) struct Look {
    /// `None` shows the image once it exists, and the rays' states before that.
    #[serde(deserialize_with = "maybe_saved_stream")]
    pub(super) stream: Option<Stream>,
    /// `None` shows all components, if they are a colour.
    pub(super) layer: Option<usize>,
    pub(super) colors: Option<Colors>,
    #[default(1.0)]
    pub(super) exposure: f32,
    /// Added to a colour.
    pub(super) offset: f32,
    /// `None` takes it from the values.
    pub(super) range: Option<[f32; 2]>,
    #[serde(flatten)]
    pub(super) zoom: Zoom,
}

impl Look {
    /// With defaults for what is not finite: JSON has no such numbers, and would not be read again.
    pub(super) fn finite(self) -> Self {
        let default = Self::default();
        let or = |v: f32, instead: f32| if v.is_finite() { v } else { instead };
        Self {
            exposure: or(self.exposure, default.exposure),
            offset: or(self.offset, default.offset),
            range: self.range.filter(|range| range.iter().all(|v| v.is_finite())),
            zoom: self.zoom.finite(),
            ..self
        }
    }

    /// Whether the view shows a colour for this stream.
    pub(super) fn is_color(&self, stream: Option<Stream>) -> bool {
        self.layer.is_none() && self.stream.or(stream).is_some_and(Stream::is_color)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_does_not_lose_the_rest() {
        for bad in [f32::NAN, f32::INFINITY] {
            let look = Look {
                layer: Some(2),
                exposure: bad,
                offset: bad,
                range: Some([0.0, bad]),
                zoom: Zoom { scale: Some(bad), center: [bad, 1.0] },
                ..Look::default()
            };
            let text = serde_json::to_string(&look.finite()).expect("text");
            assert_eq!(
                serde_json::from_str::<Look>(&text).expect("a look"),
                Look { layer: Some(2), ..Look::default() }
            );
        }
        let zoom = Zoom { scale: Some(3.0), center: [4.0, 5.0] };
        let look = Look { exposure: 2.0, range: Some([-1.0, 1.0]), zoom, ..Look::default() };
        assert_eq!(look.clone().finite(), look);
    }
}
