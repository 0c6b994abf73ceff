// Writes a reference for each cell that a span overlaps, x ascending.
//
// Spans ascend by triangle, so the references to a cell do too, and a stable sort keeps that order.

import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};

@group(0) @binding(0) var triangle: texture_2d_array<u32>;
@group(0) @binding(1) var cells_at: texture_2d_array<u32>;
@group(0) @binding(2) var mask: texture_2d_array<u32>;
@group(0) @binding(3) var first_reference: texture_2d_array<u32>;
@group(0) @binding(4) var cell_out: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var triangle_out: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn emit(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(mask).x);
    let t = textureLoad(triangle, at, 0, 0).x;
    let x = textureLoad(cells_at, at, 0, 0).x;
    let y = textureLoad(cells_at, at, 1, 0).x;
    let z = textureLoad(cells_at, at, 2, 0).x;
    let first = x + build.cells.x * (y + build.cells.y * z);
    var left = textureLoad(mask, at, 0, 0).x;
    var reference = textureLoad(first_reference, at, 0, 0).x;
    let width = textureDimensions(cell_out).x;
    // At most 32 iterations.
    while (left != 0u) {
        let to = texel(reference, width);
        textureStore(cell_out, to, 0, vec4u(first + firstTrailingBit(left)));
        textureStore(triangle_out, to, 0, vec4u(t));
        left &= left - 1u;
        reference += 1u;
    }
}
