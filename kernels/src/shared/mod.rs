//! Functions that several kernels share: one WGSL function for each, with its twin beside it.

pub mod address;
pub mod build;
pub mod bvh_walk;
pub mod camera;
pub mod constants;
pub mod crossing;
pub mod dda;
pub mod emitters;
pub mod exact;
pub mod grid_walk;
pub mod irregular_walk;
pub mod launch;
mod narrow;
pub mod packed_triangles;
pub mod photon_map;
pub mod samples;
pub mod scene;
pub mod shading;
pub mod start;
pub mod texture;
pub mod triangle;
pub mod vector;
pub mod wide_node;
pub mod wide_walk;

use grid_walk::WalkRules;

/// The WGSL of each module in this folder, by name, but for `grid_walk`, which depends on the rules: see
/// [`grid_walk_module`].
pub(crate) const MODULES: &[(&str, &str)] = &[
    ("build", include_str!("build.wgsl")),
    ("launch", include_str!("launch.wgsl")),
    ("vector", include_str!("vector.wgsl")),
    ("camera", include_str!("camera.wgsl")),
    ("samples", include_str!("samples.wgsl")),
    ("scene", include_str!("scene.wgsl")),
    ("bvh_walk", include_str!("bvh_walk.wgsl")),
    ("wide_walk", include_str!("wide_walk.wgsl")),
    ("packed_triangles", include_str!("packed_triangles.wgsl")),
    ("corners", include_str!("corners.wgsl")),
    ("dda", include_str!("dda.wgsl")),
    ("grid", include_str!("grid.wgsl")),
    ("irregular_walk", include_str!("irregular_walk.wgsl")),
    ("triangle", include_str!("triangle.wgsl")),
    ("exact", include_str!("exact.wgsl")),
    ("narrow", include_str!("narrow.wgsl")),
    ("crossing", include_str!("crossing.wgsl")),
    ("product", include_str!("product.wgsl")),
    ("texture", include_str!("texture.wgsl")),
    ("start", include_str!("start.wgsl")),
    ("photon_map", include_str!("photon_map.wgsl")),
];

/// The WGSL of the walk through a grid, with these rules.
pub(crate) const fn grid_walk_module(rules: WalkRules) -> (&'static str, &'static str) {
    let source = match rules {
        WalkRules { robust: true, .. } => include_str!("grid_walk/robust.wgsl"),
        WalkRules { dda: true, .. } => include_str!("grid_walk/dda.wgsl"),
        _ => include_str!("grid_walk/paper.wgsl"),
    };
    ("grid_walk", source)
}
