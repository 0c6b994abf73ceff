//! Errors of planning: images, scenes and rays that do not fit, with the numbers.

use raystep_scenes::{Projection, Scene};

use super::limits::Limits;
use crate::fragment::TEXEL_BYTES as DRAWN_BYTES;
use crate::numbers::bytes::Bytes;
use crate::numbers::units::Units;
use crate::options::mapping::{self, Mapping, Until};
use crate::options::rows::ROWS;
use crate::options::samples::Samples;
use crate::options::scene_data::{self, SceneDataKind};
use crate::options::{Accelerator, Options, Order, Ray, RaySource};
use crate::program::sizes::TooMany;
use crate::scene_data::{SceneDataError, traced_camera};
use crate::shader::ShaderError;
use crate::shared::address::list_side;
use crate::structures::bvh::BvhError;
use crate::structures::grid::GridError;
use crate::tables::elements::folded_width;

/// Why a run cannot be planned.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The image has no pixels, or too many.
    #[error(
        "an image of {width}x{height} pixels cannot be traced here: each side must be 1 to {side}, and their product at most {rays}"
    )]
    ImageSize {
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// Largest side.
        side: u32,
        /// Most pixels.
        rays: u64,
    },
    /// A buffer is larger than the device, GPU or CPU, can bind.
    #[error("{name} needs {} in one buffer, but this device binds at most {}: {} too many", Bytes(*bytes), Bytes(*limit), Bytes(bytes - limit))]
    BufferSize {
        /// The buffer.
        name: &'static str,
        /// Its size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// A list is longer than the largest texture that the device has.
    #[error(
        "{name} has {words} words of 32 bits and needs a texture of {side}x{side} texels, but this device has none larger \
         than {most}x{most}: where there are compute shaders, --scene-data buffers allows longer lists"
    )]
    ListSize {
        /// The list.
        name: &'static str,
        /// Its words.
        words: u64,
        /// Texels along each side.
        side: u64,
        /// Most of them.
        most: u32,
    },
    /// A kernel binds more than the device allows a shader.
    #[error(
        "kernel {kernel} binds {count} {kind}, but this device allows a shader {most}: {name} is one too many{hint}"
    )]
    Bindings {
        /// The kernel.
        kernel: &'static str,
        /// Of what.
        kind: &'static str,
        /// Number of bindings.
        count: usize,
        /// Most of them.
        most: u32,
        /// The first that does not fit.
        name: String,
        /// What helps, as the end of the sentence; empty if nothing does.
        hint: &'static str,
    },
    /// This machine does not have enough memory.
    #[error(transparent)]
    OutOfMemory(#[from] SceneDataError),
    /// More triangles than an id can name.
    #[error("the scene has {0} triangles, at most {max} can be traced", max = u32::MAX / 9)]
    TooManyTriangles(usize),
    /// The scene is so small compared with its distance from the origin that f32 cannot distinguish its points.
    #[error(
        "the scene's points are not finite, or are a hundred million times farther from the origin than from each \
         other: move the scene to the origin"
    )]
    Extent,
    /// More keys than a sort's schedule is made for.
    #[error("{keys} keys cannot be sorted: at most {most}")]
    TooManyKeys {
        /// Number of keys.
        keys: u32,
        /// Most of them.
        most: u32,
    },
    /// An option does not go together with the others, as its [row](crate::options::rows::Row) says.
    #[error("{0}")]
    Refused(String),
    /// The program builds grids only.
    #[error("the program grid-build builds grids: use --accelerator grid or irregular, not {0}")]
    NotBuilt(Accelerator),
    /// The camera cannot generate rays.
    #[error("the camera cannot generate rays: {0}")]
    Camera(String),
    /// An input ray cannot be traced.
    #[error("ray {index} cannot be traced: {reason}")]
    Ray {
        /// Its index in the list.
        index: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// This number of samples per pixel is not possible.
    #[error("cannot take {count} samples per pixel: {reason}")]
    Samples {
        /// The requested number.
        count: u32,
        /// Why not.
        reason: &'static str,
    },
    /// An attribute of the scene has the wrong number of entries.
    #[error("the scene has {triangles} triangles, but {entries} entries of {name}")]
    Attribute {
        /// The attribute.
        name: &'static str,
        /// Its entries.
        entries: usize,
        /// Triangles.
        triangles: usize,
    },
    /// A texture whose texels do not match its size, or more texels than can be indexed.
    #[error(
        "texture {index} of {width}x{height} has {texels} texels; they must match, and all textures together have at most {MAX_TEXELS}"
    )]
    Texture {
        /// Its index in the scene.
        index: usize,
        /// Texels per row.
        width: u32,
        /// Rows.
        height: u32,
        /// Number of texels it has.
        texels: usize,
    },
    /// A set has too many elements.
    #[error("{0}; use fewer cells")]
    TooMany(#[from] TooMany),
    /// The grid cannot be built.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The BVH cannot be built.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// One of raystep's own kernels is invalid.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

/// Most texels of all textures together: kernels compute a texel's position in its texture as i32, and the index of its
/// two words as u32.
pub const MAX_TEXELS: u64 = 1 << 30;

pub(crate) fn image_size(options: &Options, limits: &Limits) -> Result<(u32, u32, u64), PlanError> {
    let (width, height, rays) = match &options.rays {
        RaySource::Camera { width, height, .. } => {
            (u64::from(*width), u64::from(*height), u64::from(*width) * u64::from(*height))
        }
        RaySource::Given(rays) => {
            let rays = rays.len() as u64;
            let (width, height) = given_size(rays, limits)?;
            return Ok((width, height, rays));
        }
    };
    let (width, height) = checked_size(width, height, limits)?;
    Ok((width, height, rays))
}

/// The texture that so many input rays fill row by row.
pub(crate) fn given_size(rays: u64, limits: &Limits) -> Result<(u32, u32), PlanError> {
    let width = folded_width(rays).min(u64::from(limits.image_side));
    checked_size(width, rays.div_ceil(width.max(1)).max(1), limits)
}

fn checked_size(width: u64, height: u64, limits: &Limits) -> Result<(u32, u32), PlanError> {
    let side = u64::from(limits.image_side);
    if width == 0 || height == 0 || width > side || height > side || width * height > limits.rays {
        return Err(PlanError::ImageSize { width, height, side: limits.image_side, rays: limits.rays });
    }
    Ok((width as u32, height as u32))
}

/// Largest coordinate in traced units, where the scene's extent is 1 to 2. From 2²⁴ on, f32 cannot resolve the scene's
/// extent at all; up to this value, t stays far below [`crate::shared::constants::INF`] even along an axis that a ray
/// is nearly parallel to.
pub(crate) const FARTHEST: f64 = (1u64 << 28) as f64;

pub(crate) fn check_scene(scene: &Scene, units: Units) -> Result<(), PlanError> {
    let bounds = scene.bounds();
    let farthest = bounds.min.abs().max(bounds.max.abs()).as_dvec3().max_element() * units.scale();
    if !scene.triangles.is_empty() && (farthest.is_nan() || farthest > FARTHEST) {
        return Err(PlanError::Extent);
    }

    let triangles = scene.triangles.len();
    if triangles > (u32::MAX / 9) as usize {
        return Err(PlanError::TooManyTriangles(triangles));
    }
    let attributes = [
        ("normals", scene.normals.as_ref().map(Vec::len)),
        ("texcoords", scene.texcoords.as_ref().map(Vec::len)),
        ("colors", scene.colors.as_ref().map(Vec::len)),
        ("triangle_materials", Some(scene.triangle_materials.len())),
    ];
    for (name, entries) in attributes {
        if let Some(entries) = entries.filter(|&n| n != triangles) {
            return Err(PlanError::Attribute { name, entries, triangles });
        }
    }
    let mut all_texels = 0;
    for (index, t) in scene.textures.iter().enumerate() {
        let (width, height, texels) = (t.width, t.height, t.texels.len());
        let size = u64::from(width) * u64::from(height);
        all_texels += size.min(MAX_TEXELS + 1);
        if size == 0 || size != texels as u64 || all_texels > MAX_TEXELS {
            return Err(PlanError::Texture { index, width, height, texels });
        }
    }
    let out_of_range = scene.triangle_materials.iter().any(|&m| m as usize >= scene.materials.len());
    let missing = scene.materials.iter().filter_map(|m| m.texture).any(|t| t as usize >= scene.textures.len());
    if scene.materials.is_empty() || out_of_range || missing {
        return Err(PlanError::Attribute { name: "materials", entries: scene.materials.len(), triangles });
    }
    Ok(())
}

pub(crate) fn check_rays(options: &Options, units: Units) -> Result<(), PlanError> {
    match &options.rays {
        RaySource::Camera { camera, width, height } => {
            let positive = match camera.projection {
                Projection::Perspective { vertical_fov } => vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI,
                Projection::Orthographic { half_height } => half_height > 0.0,
            };
            if !positive {
                return Err(PlanError::Camera("its field of view is not between 0 and 180 degrees".into()));
            }
            let c = traced_camera(camera, units, *width, *height);
            let in_range = |v: &f32| v.is_finite() && f64::from(v.abs()) <= FARTHEST;
            if ![c.eye, c.right, c.up, c.forward].iter().flatten().all(in_range) {
                return Err(PlanError::Camera("it is too far from the scene for its size, or not finite".into()));
            }
            Ok(())
        }
        RaySource::Given(rays) => {
            match rays.iter().enumerate().find_map(|(index, ray)| Some((index, why_untraceable(ray, units)?))) {
                Some((index, reason)) => Err(PlanError::Ray { index, reason }),
                None => Ok(()),
            }
        }
    }
}

/// Why an input ray cannot be traced, if it cannot.
#[inline]
pub(crate) fn why_untraceable(ray: &Ray, units: Units) -> Option<&'static str> {
    let is_far = |v: &f32| f64::from(units.to_traced(*v).abs()) > FARTHEST;
    let far = || ray.origin.iter().any(is_far).then_some("its origin is too far from the scene for its size");
    ray.fault().or_else(far)
}

/// Bytes per texel as kernels read it.
const TEXEL_BYTES: u64 = 8;

/// Rejects textures that cannot be bound before they are converted.
pub(crate) fn check_texels(scene: &Scene, scene_data: SceneDataKind, limits: &Limits) -> Result<(), PlanError> {
    let texels: u64 = scene.textures.iter().map(|t| t.texels.len() as u64).sum();
    check_list("texels", texels * TEXEL_BYTES, scene_data, limits)
}

pub(crate) fn check_samples(options: &Options) -> Result<(), PlanError> {
    let count = options.samples.count;
    let reason = match options.rays {
        _ if !(1..=Samples::MOST).contains(&count) => "expected 1 to 65536",
        _ if options.samples.first > Samples::MOST - count => "there are at most 65536, with those before the first",
        _ if !options.samples.are_spread() => return Ok(()),
        RaySource::Given(_) => "input rays have no pixels to distribute samples over",
        RaySource::Camera { .. } if !options.shade => "samples average colours, but this run does not shade",
        RaySource::Camera { .. } => return Ok(()),
    };
    Err(PlanError::Samples { count, reason })
}

/// Whether options go together, and with the device.
pub(crate) fn check_choices(options: &Options, limits: &Limits) -> Result<(), PlanError> {
    if options.mapping != Mapping::Compute && u64::from(limits.color_bytes) < DRAWN_BYTES {
        return Err(PlanError::Refused(mapping::NO_GPU.into()));
    }
    check_scene_data(options, limits)?;
    if options.all_hits && (options.any_hit || options.order != Order::Exact) {
        return Err(PlanError::Refused("all hits of a ray have an exact order, and exclude any hit".into()));
    }
    let choices = options.choices();
    match ROWS.iter().find_map(|row| (row.refused)(&choices)?.impossible()) {
        Some(why) => Err(PlanError::Refused(why)),
        None => Ok(()),
    }
}

/// Whether kernels can read lists from textures, if they are to, and can be compute shaders, if some are.
fn check_scene_data(options: &Options, limits: &Limits) -> Result<(), PlanError> {
    let only_draws = options.scene_data == SceneDataKind::Textures
        && options.mapping.fragment().is_some_and(|how| how.until == Until::Query);
    if !limits.computes() && !only_draws {
        return Err(PlanError::Refused(mapping::ONLY_DRAWS.into()));
    }
    // What draws nothing is the CPU.
    let is_wrong = options.scene_data == SceneDataKind::Textures && limits.color_bytes == 0;
    if is_wrong { Err(PlanError::Refused(scene_data::NO_GPU.into())) } else { Ok(()) }
}

/// Rejects a list of scene data that is too long.
pub(crate) fn check_list(
    name: &'static str,
    bytes: u64,
    scene_data: SceneDataKind,
    limits: &Limits,
) -> Result<(), PlanError> {
    let words = bytes.div_ceil(4);
    match scene_data {
        SceneDataKind::Buffers => check_buffer(name, bytes, limits),
        SceneDataKind::Textures if words > limits.list_words(scene_data) => {
            Err(PlanError::ListSize { name, words, side: list_side(words), most: limits.image_side })
        }
        SceneDataKind::Textures => Ok(()),
    }
}

pub(crate) fn check_buffer(name: &'static str, bytes: u64, limits: &Limits) -> Result<(), PlanError> {
    let limit = limits.storage_bytes;
    if bytes > limit { Err(PlanError::BufferSize { name, bytes, limit }) } else { Ok(()) }
}
