//! Materials and lights in the format of `shade.wgsl`.

use bytemuck::{Pod, Zeroable};

/// `texture` of a material that has none.
pub const NO_TEXTURE: u32 = 0xffff_ffff;

/// An entry of the buffer `materials`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Diffuse colour, linear.
    pub base_color: [f32; 3],
    /// Index into `textures`, [`NO_TEXTURE`] for none.
    pub texture: u32,
    /// Added to the shaded colour, linear.
    pub emissive: [f32; 3],
    /// Not 0 if the normal is turned towards the viewer.
    pub double_sided: u32,
}

/// `kind` of [`Optics`]: light is scattered in all directions.
pub const DIFFUSE: u32 = 0;
/// `kind` of [`Optics`]: a perfect mirror.
pub const MIRROR: u32 = 1;
/// `kind` of [`Optics`]: the surface of a transparent solid, whose outside is where its corners are counterclockwise.
pub const DIELECTRIC: u32 = 2;
/// `kind` of [`Optics`]: a transparent sheet, so thin that rays leave it as they came.
pub const SHEET: u32 = 3;

/// An entry of the buffer `optics`: how a material scatters light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Optics {
    /// [`DIFFUSE`], [`MIRROR`], [`DIELECTRIC`] or [`SHEET`].
    pub kind: u32,
    /// Index of refraction, relative to the outside.
    pub ior: f32,
}

/// `kind` of a [`Light`].
pub const POINT: u32 = 0;
/// `kind` of a [`Light`].
pub const DIRECTIONAL: u32 = 1;
/// `kind` of a [`Light`].
pub const SPOT: u32 = 2;

/// An entry of the buffer `lights`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Traced units.
    pub position: [f32; 3],
    /// [`POINT`], [`DIRECTIONAL`] or [`SPOT`].
    pub kind: u32,
    /// Direction in which the light travels; length 1.
    pub direction: [f32; 3],
    /// Cosine of the half angle of a spot's outer cone, beyond which it is dark.
    pub cos_outer: f32,
    /// Linear colour.
    pub color: [f32; 3],
    /// 1 / (cosine of the inner half angle − `cos_outer`).
    pub cone_scale: f32,
}

/// The uniform `shading`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Shading {
    /// Colour of a ray that hits nothing, linear.
    pub background: [f32; 3],
    /// Number of lights.
    pub lights: u32,
}
