//! Settings of the 3D view.

use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

/// How the scene's triangles are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TriangleStyle {
    /// Not at all.
    Hidden,
    /// Their edges.
    Wireframe,
    /// Transparent: items behind them are visible.
    Translucent,
    /// Opaque and lit: items behind them are faint.
    #[default]
    Opaque,
}

/// What the colours of photons tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PhotonPaint {
    /// The hue and, by its fourth root, the size of their power.
    #[default]
    Power,
    /// After how many bounces they are stored.
    Bounce,
    /// In which map they are.
    Map,
}

/// Settings of the 3D view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, SmartDefault)]
#[serde(default)]
pub struct Settings {
    /// The scene's triangles.
    pub triangles: TriangleStyle,
    /// Darker edges on triangles that are not drawn as wireframe.
    #[default(true)]
    pub edges: bool,
    /// The box of the grid or of the BVH's root.
    #[default(true)]
    pub bounds: bool,
    /// The cells or nodes visited.
    #[default(true)]
    pub visited: bool,
    /// Nodes whose boxes the ray missed.
    pub missed_nodes: bool,
    /// Where the ray crosses planes, and where it would leave its cell along each axis.
    #[default(true)]
    pub crossings: bool,
    /// Triangles tested.
    #[default(true)]
    pub tested: bool,
    /// The ray and its hit.
    #[default(true)]
    pub ray: bool,
    /// The pixel's rays to lights, up to the current pass.
    #[default(true)]
    pub light: bool,
    /// The places where photons are stored.
    #[default(true)]
    pub photons: bool,
    /// What their colours tell.
    pub photon_paint: PhotonPaint,
    /// The cells, circle and photons of the selected pixel's search.
    #[default(true)]
    pub search: bool,
    /// The camera that generates the rays.
    #[default(true)]
    pub camera: bool,
    /// The directions of x, y and z, beside a lower corner of the scene.
    #[default(true)]
    pub axes: bool,
    /// Whether triangles between the eye and the walk are cut away.
    #[default(true)]
    pub cut: bool,
    /// Width of the thinnest lines.
    #[default(1.25)]
    pub line_width_px: f32,
    /// Light on dark.
    #[default(true)]
    pub is_dark: bool,
}

impl Settings {
    pub(super) fn opacity(&self) -> f32 {
        match self.triangles {
            TriangleStyle::Hidden => 0.0,
            TriangleStyle::Wireframe => 0.5,
            TriangleStyle::Translucent => 0.22,
            TriangleStyle::Opaque => 1.0,
        }
    }

    /// Opacity of triangles in front of the walk, relative to the others.
    pub(super) fn in_front(&self) -> f32 {
        match self.triangles {
            // Opaque triangles write depth: faint ones would hide what they are to show.
            TriangleStyle::Opaque => 0.0,
            _ => 0.2,
        }
    }

    pub(super) fn background(&self) -> wgpu::Color {
        let [r, g, b] = if self.is_dark { [0x15, 0x18, 0x1d] } else { [0xf4, 0xf5, 0xf7] };
        let share = |byte: u8| f64::from(byte) / 255.0;
        wgpu::Color { r: share(r), g: share(g), b: share(b), a: 1.0 }
    }
}
