//! Every buffer of scene data and every uniform, in one table. What is kept for each ray is in [`super::streams`].

use bytemuck::{bytes_of, cast_slice};

use super::streams::{no_emitters, no_specular};
use crate::options::Skip;
use crate::options::keep::Item;
use crate::options::reasons::{Because, GIVEN, ONE_SAMPLE, On, Passes, Reason, Run, SEVERAL_STEPS};
use crate::scene_data::buffer::{BufferInfo, storage, uniform};

/// Every buffer.
pub static BUFFERS: &[BufferInfo] = &[
    uniform("camera", "eye, view plane, pixel size; traced units", |data| bytes_of(&data.camera), |_| GIVEN).of_view(),
    uniform(
        "grid",
        "corner, cells, cell width; traced units",
        |data| bytes_of(&data.grid),
        |run| run.needed_only(On::Cells, Passes::Any),
    ),
    uniform(
        "scene",
        "triangles, steps per pass, rays, first row of workgroups, size of the streams",
        |data| bytes_of(&data.info),
        |_| {
            let needs = "needed only with --accelerator bvh or none, or several steps per pass: --schedule fused, or compact \
                         with --steps-per-pass 2 or more";
            (Because::Options, needs)
        },
    )
    .of_view(),
    uniform(
        "shading",
        "background, number of lights",
        |data| bytes_of(&data.shading),
        |run| run.of_shading("nothing refers to it"),
    ),
    uniform("sampling", "samples per pixel, seed, first sample", |data| bytes_of(&data.sampling), |_| ONE_SAMPLE)
        .of_view(),
    storage(
        "vertices",
        "nine f32 per triangle: corners 0, 1, 2, traced units",
        |data| cast_slice(&data.vertices),
        |run| {
            if run.options.shade {
                (Because::Scene, "every triangle has vertex normals")
            } else {
                (Because::Options, "packed_triangles has them: needed only for an image, or one step per pass")
            }
        },
    )
    .in_rows(&[3, 3]),
    storage(
        "grid_cells",
        "u32 per cell and one more: start of its list in grid_items",
        |data| cast_slice(&data.grid_cells),
        |run| run.needed_only(On::Grid, Passes::Any),
    ),
    storage(
        "grid_items",
        "u32 triangle ids, ascending within a cell",
        |data| cast_slice(&data.grid_items),
        |run| run.needed_only(On::Grid, Passes::Any),
    ),
    storage(
        "grid_distances",
        "u8 per cell: chessboard distance to the next cell with a list, 0 for one with a list",
        |data| cast_slice(&data.grid_distances),
        of_leaps,
    ),
    storage(
        "irregular_map",
        "u32 per top-level cell, and blocks below: a cell, or a block of finer entries",
        |data| cast_slice(&data.irregular_map),
        |run| run.needed_only(On::Irregular, Passes::Any),
    ),
    storage(
        "irregular_cells",
        "16 bytes per cell: box in virtual cells, start of its list in irregular_items",
        |data| cast_slice(&data.irregular_cells),
        |run| run.needed_only(On::Irregular, Passes::Any),
    ),
    storage(
        "irregular_items",
        "u32 triangle ids, ascending within a cell; bit 31 marks the last of a list",
        |data| cast_slice(&data.irregular_items),
        |run| run.needed_only(On::Irregular, Passes::Any),
    ),
    storage(
        "bvh_nodes",
        "32 bytes per node: box, first child or item, link; traced units",
        |data| cast_slice(&data.bvh_nodes),
        |run| run.needed_only(On::Bvh, Passes::Stepped),
    ),
    storage(
        "bvh_parents",
        "u32 per node: its parent, and in bits 30-31 the axis of the node's link",
        |data| cast_slice(&data.bvh_parents),
        |run| run.needed_only(On::Bvh, Passes::Stepped),
    ),
    storage(
        "bvh_items",
        "u32 triangle ids, in the order of the leaves",
        |data| cast_slice(&data.bvh_items),
        |run| run.needed_only(On::Bvh, Passes::OneStep),
    ),
    storage(
        "wide_nodes",
        "80 bytes per node: eight quantised boxes; traced units",
        |data| cast_slice(&data.wide_nodes),
        |run| run.needed_only(On::Bvh, Passes::Fused),
    ),
    storage(
        "packed_triangles",
        "48 bytes per entry: corners and triangle id; traced units",
        |data| cast_slice(&data.packed_triangles),
        |_| SEVERAL_STEPS,
    ),
    storage(
        "normals",
        "nine f32 per triangle: unit vertex normals",
        |data| cast_slice(&data.normals),
        |run| run.of_shading("no vertex normals: shading is flat"),
    )
    .in_rows(&[3, 3])
    .of(Item::Normals),
    storage(
        "texcoords",
        "six f32 per triangle: base colour texture coordinates",
        |data| cast_slice(&data.texcoords),
        |run| run.of_shading("no base colour texture"),
    )
    .in_rows(&[3, 2])
    .of(Item::Textures),
    storage(
        "vertex_colors",
        "nine f32 per triangle: linear colours",
        |data| cast_slice(&data.vertex_colors),
        |run| run.of_shading("no vertex colours"),
    )
    .in_rows(&[3, 3])
    .of(Item::VertexColors),
    storage(
        "triangle_materials",
        "u32 per triangle: index into materials",
        |data| cast_slice(&data.triangle_materials),
        |run| run.of_shading("one material"),
    )
    .of(Item::ManyMaterials),
    storage(
        "materials",
        "32 bytes: base colour, texture, emissive, double-sided",
        |data| cast_slice(&data.materials),
        |run| run.of_shading("nothing refers to it"),
    ),
    storage(
        "optics",
        "8 bytes per material: how it scatters light, index of refraction",
        |data| cast_slice(&data.optics),
        no_specular,
    ),
    storage(
        "emitters",
        "16 bytes per light and triangle that glows: a row of an alias table",
        |data| cast_slice(&data.emitters),
        no_emitters,
    ),
    uniform("emission", "number of emitters, pdf of a point by luminance", |data| bytes_of(&data.emission), no_emitters),
    storage(
        "lights",
        "48 bytes: position, kind, direction, cone, colour",
        |data| cast_slice(&data.lights),
        |run| run.of_shading("nothing refers to it"),
    )
    .of_view(),
    storage(
        "textures",
        "16 bytes: first texel, width, height, sampling",
        |data| cast_slice(&data.textures),
        |run| run.of_shading("no base colour texture"),
    )
    .of(Item::Textures),
    storage(
        "texels",
        "two u32 per texel: linear R G B, 16 bits each",
        |data| cast_slice(&data.texels),
        |run| run.of_shading("no base colour texture"),
    )
    .in_rows(&[2])
    .of(Item::Textures),
];

/// Why the distances for empty-space skipping are left out.
fn of_leaps(run: &Run<'_>) -> Reason {
    match run.features {
        features if !features.grid => run.needed_only(On::Grid, Passes::Any),
        features if !features.robust => (Because::Options, "needed only with --numerics robust, if cells are empty"),
        _ if run.options.skip == Skip::Off => {
            (Because::Options, "needed only with --skip on, or auto if many cells are empty")
        }
        _ => (Because::Scene, "too few cells are empty for --skip auto"),
    }
}
