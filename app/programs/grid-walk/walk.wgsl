// A step of the walk: tests the triangles that the voxel lists, and goes on through the face that is crossed first.

import package::camera::{eye_ray};
import package::constants::{NOBODY};
import package::corners::{vertex};
import package::grid::{cell_index, is_in_grid};
import package::grid_lists::{grid_cells, grid_items};
import package::live::{book};
import package::state::{HIT, MISS, WALK};
import package::triangle::{hit_triangle, is_nearer, shear_of};
import package::voxels::{exits};

@group(0) @binding(0) var ray: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var voxel: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(2) var tmax: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(3) var nearest: texture_storage_2d_array<r32uint, read_write>;

fn load(at: vec2u) -> vec3i {
    return vec3i(vec3u(textureLoad(voxel, at, 0).x, textureLoad(voxel, at, 1).x, textureLoad(voxel, at, 2).x));
}

fn step(at: vec2u) -> u32 {
    let eye = eye_ray(at);
    let here = load(at);
    let leave = vec3f(textureLoad(tmax, at, 0).x, textureLoad(tmax, at, 1).x, textureLoad(tmax, at, 2).x);

    // The triangles of this voxel. One that reaches into others may be hit in one of those.
    var t = bitcast<f32>(textureLoad(nearest, at, 0).x);
    var found = textureLoad(nearest, at, 1).x;
    let shear = shear_of(eye.direction);
    let list = cell_index(here);
    for (var item = grid_cells[list]; item < grid_cells[list + 1u]; item++) {
        let triangle = grid_items[item];
        let corners = array(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u));
        let candidate = hit_triangle(eye.origin, eye.direction, shear, corners[0], corners[1], corners[2]);
        if (candidate.is_hit && is_nearer(candidate.t, triangle, t, found)) {
            t = candidate.t;
            found = triangle;
        }
    }
    textureStore(nearest, at, 0, vec4u(bitcast<u32>(t)));
    textureStore(nearest, at, 1, vec4u(found));
    textureStore(ray, at, 1, vec4u(textureLoad(ray, at, 1).x + 1u));

    // A hit before the ray leaves the voxel is the nearest of all: what is in later voxels is farther away.
    let out = min(leave.x, min(leave.y, leave.z));
    let forward = select(vec3i(-1), vec3i(1), eye.direction > vec3f(0.0));
    let axis = select(select(2, 1, leave.y <= leave.z), 0, leave.x <= min(leave.y, leave.z));
    var next = here;
    next[axis] += forward[axis];
    if (t <= out) {
        return HIT;
    }
    if (!is_in_grid(next)) {
        return select(HIT, MISS, found == 0xffffffffu);
    }
    let exit = exits(next, eye.origin, eye.direction);
    for (var i = 0u; i < 3u; i++) {
        textureStore(voxel, at, i, vec4u(u32(next[i])));
        textureStore(tmax, at, i, vec4f(exit[i]));
    }
    return WALK;
}

@compute @workgroup_size(8, 8)
fn walk(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    var tag = NOBODY;
    if (all(id.xy < textureDimensions(ray)) && textureLoad(ray, id.xy, 0).x == WALK) {
        tag = step(id.xy);
        textureStore(ray, id.xy, 0, vec4u(tag));
    }
    book(lane, tag);
}
