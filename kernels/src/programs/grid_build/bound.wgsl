// Finds the cells that each triangle's bounding box touches, and its number of spans.

import package::launch::{BLOCK, launch, element, texel};
import package::build::{build, vertices};
import package::filter::{NO, YES, is_above, slack};
import package::soft_f64::{f64_add, f64_sub, f64_div, f64_lt, f64_is_nan, f64_to_i32, f64_from_f32};

@group(0) @binding(0) var box: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(1) var first_span: texture_storage_2d_array<r32uint, write>;

// The cell that contains a coordinate moved by the growth, or the nearest cell to it.
fn cell_at(coordinate: u32, growth: f32, axis: u32) -> u32 {
    let last = i32(build.cells[axis]) - 1;
    let corner = bitcast<f32>(build.corner[axis]);
    let width = bitcast<f32>(build.width[axis]);
    let v = bitcast<f32>(coordinate);
    let guess = clamp(i32(clamp(((v - corner) + growth) / width, 0.0, 4096.0)), 0, last);
    // Where the planes on both sides tell for certain, this is it.
    let off_by = slack()[axis];
    let is_from_here = guess == 0 || is_above(v, growth, corner + f32(guess) * width, off_by) == YES;
    let is_up_to_here = guess == last || is_above(v, growth, corner + f32(guess + 1) * width, off_by) == NO;
    if (is_from_here && is_up_to_here) {
        return u32(guess);
    }
    let moved = f64_add(f64_from_f32(coordinate), f64_from_f32(bitcast<u32>(growth)));
    let distance = f64_sub(moved, f64_from_f32(build.corner[axis]));
    let cell = f64_to_i32(f64_div(distance, f64_from_f32(build.width[axis])));
    return u32(clamp(cell, 0, last));
}

// As f64_min and f64_max, of the bits of f32.
fn lower(a: u32, b: u32) -> u32 {
    let x = f64_from_f32(a);
    let y = f64_from_f32(b);
    return select(a, b, f64_is_nan(x) || f64_lt(y, x));
}

fn upper(a: u32, b: u32) -> u32 {
    let x = f64_from_f32(a);
    let y = f64_from_f32(b);
    return select(a, b, f64_is_nan(x) || f64_lt(x, y));
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
    let growth = bitcast<f32>(build.growth);
    let at = texel(i, textureDimensions(box).x);
    var cells = vec3u(0u);
    // A loop instead of six calls: compilers inline a division at every call.
    for (var a = 0u; a < 3u; a++) {
        let b0 = vertices[9u * i + a];
        let b1 = vertices[9u * i + a + 3u];
        let b2 = vertices[9u * i + a + 6u];
        let low = cell_at(lower(lower(b0, b1), b2), -growth, a);
        let high = cell_at(upper(upper(b0, b1), b2), growth, a);
        textureStore(box, at, a, vec4u(low));
        textureStore(box, at, a + 3u, vec4u(high));
        cells[a] = high - low + 1u;
    }
    // At most 4096 cells along an axis: 2^31 spans.
    let spans = ((cells.x + 31u) / 32u) * cells.y * cells.z;
    textureStore(first_span, texel(i, textureDimensions(first_span).x), 0, vec4u(spans));
}
