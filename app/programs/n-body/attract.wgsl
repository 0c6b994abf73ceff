// The attraction of all bodies, each with the same share of a mass of 1. A workgroup loads them in tiles of 256.

import package::launch::{BLOCK, element, launch, texel};
import package::program::{SOFTENING, STEP};

@group(0) @binding(0) var position: texture_2d_array<f32>;
@group(0) @binding(1) var velocity: texture_storage_2d_array<r32float, read_write>;

var<workgroup> tile: array<vec3f, BLOCK>;

fn place_of(i: u32) -> vec3f {
    let at = texel(i, launch.width);
    return vec3f(
        textureLoad(position, at, 0, 0).x,
        textureLoad(position, at, 1, 0).x,
        textureLoad(position, at, 2, 0).x,
    );
}

@compute @workgroup_size(BLOCK)
fn attract(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    let is_there = i < launch.elements;
    var here = vec3f(0.0);
    if (is_there) {
        here = place_of(i);
    }
    var pull = vec3f(0.0);
    for (var first = 0u; first < launch.elements; first += BLOCK) {
        if (first + lane < launch.elements) {
            tile[lane] = place_of(first + lane);
        }
        workgroupBarrier();
        let count = min(BLOCK, launch.elements - first);
        for (var other = 0u; other < count; other++) {
            let away = tile[other] - here;
            let squared = dot(away, away) + SOFTENING * SOFTENING;
            pull += away / (squared * sqrt(squared));
        }
        workgroupBarrier();
    }
    if (is_there) {
        let at = texel(i, launch.width);
        let change = STEP / f32(launch.elements) * pull;
        for (var axis = 0u; axis < 3u; axis++) {
            textureStore(velocity, at, axis, vec4f(textureLoad(velocity, at, axis).x + change[axis]));
        }
    }
}
