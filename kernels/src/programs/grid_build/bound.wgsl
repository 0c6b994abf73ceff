// Finds the cells that each triangle's bounding box touches, and its number of spans.

import package::launch::{BLOCK, launch, element, texel};
import package::build::{build, vertices};
import package::soft_f64::{F64, f64_add, f64_sub, f64_div, f64_min, f64_max, f64_to_i32, f64_from_f32};

@group(0) @binding(0) var box: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(1) var first_span: texture_storage_2d_array<r32uint, write>;

// The cell that contains a coordinate, or the nearest cell to it.
fn cell_at(coordinate: F64, axis: u32) -> u32 {
    let distance = f64_sub(coordinate, f64_from_f32(build.corner[axis]));
    let cell = f64_to_i32(f64_div(distance, f64_from_f32(build.width[axis])));
    return u32(clamp(cell, 0, i32(build.cells[axis]) - 1));
}

@compute @workgroup_size(BLOCK)
fn bound(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let growth = f64_from_f32(build.growth);
    let at = texel(i, textureDimensions(box).x);
    var cells = vec3u(0u);
    // A loop instead of six calls: compilers inline a division at every call.
    for (var a = 0u; a < 3u; a++) {
        let p0 = f64_from_f32(vertices[9u * i + a]);
        let p1 = f64_from_f32(vertices[9u * i + a + 3u]);
        let p2 = f64_from_f32(vertices[9u * i + a + 6u]);
        let low = cell_at(f64_sub(f64_min(f64_min(p0, p1), p2), growth), a);
        let high = cell_at(f64_add(f64_max(f64_max(p0, p1), p2), growth), a);
        textureStore(box, at, a, vec4u(low));
        textureStore(box, at, a + 3u, vec4u(high));
        cells[a] = high - low + 1u;
    }
    // At most 4096 cells along an axis: 2^31 spans.
    let spans = ((cells.x + 31u) / 32u) * cells.y * cells.z;
    textureStore(first_span, texel(i, textureDimensions(first_span).x), 0, vec4u(spans));
}
