// Tests the cells of each span: at most 32 along x, in one row of a triangle's box.

import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::overlap::{prepare, enter_row, meets};

@group(0) @binding(0) var box: texture_2d_array<u32>;
@group(0) @binding(1) var first_span: texture_2d_array<u32>;
@group(0) @binding(2) var triangle: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(3) var cells_at: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var mask: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var first_reference: texture_storage_2d_array<r32uint, write>;

fn load_first_span(i: u32) -> u32 {
    return textureLoad(first_span, texel(i, textureDimensions(first_span).x), 0, 0).x;
}

fn load_box(i: u32, layer: u32) -> vec3u {
    let at = texel(i, textureDimensions(box).x);
    let x = textureLoad(box, at, layer, 0).x;
    let y = textureLoad(box, at, layer + 1u, 0).x;
    let z = textureLoad(box, at, layer + 2u, 0).x;
    return vec3u(x, y, z);
}

// The triangle of a span: the last one whose spans begin at or before it. Each has at least one.
fn triangle_of(span: u32) -> u32 {
    var low = 0u;
    var high = build.triangles;
    while (high - low > 1u) {
        let middle = low + (high - low) / 2u;
        if (load_first_span(middle) <= span) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// Its loops, with those of the functions it calls, take fewer than 400 iterations; Mesa's software Vulkan ends a
// thread's loops after 65,535.
@compute @workgroup_size(BLOCK)
fn span(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let t = triangle_of(i);
    let low = load_box(t, 0u);
    let high = load_box(t, 3u);
    let spans_a_row = (high.x - low.x + 32u) / 32u;
    let within = i - load_first_span(t);
    let row = within / spans_a_row;
    let rows = high.y - low.y + 1u;
    let first = low + vec3u(32u * (within % spans_a_row), row % rows, row / rows);

    var overlapped = 0u;
    if (all(low == high)) {
        // The only cell it can be in.
        overlapped = 1u;
    } else {
        prepare(t);
        if (enter_row(first.y, first.z)) {
            let last = min(first.x + 31u, high.x);
            for (var x = first.x; x <= last; x++) {
                overlapped |= u32(meets(x)) << (x - first.x);
            }
        }
    }

    let at = texel(i, textureDimensions(mask).x);
    textureStore(triangle, at, 0, vec4u(t));
    textureStore(cells_at, at, 0, vec4u(first.x));
    textureStore(cells_at, at, 1, vec4u(first.y));
    textureStore(cells_at, at, 2, vec4u(first.z));
    textureStore(mask, at, 0, vec4u(overlapped));
    textureStore(first_reference, at, 0, vec4u(countOneBits(overlapped)));
}
