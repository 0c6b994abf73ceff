// The grid as a ray sees it: which voxel it is in, and where it leaves it.

import package::grid::{grid};

const INFINITE: f32 = 3.4e38;

// The voxel of a position; clamped, since rounding may move a position on a face out of the grid.
fn voxel_at(position: vec3f) -> vec3i {
    return clamp(vec3i(floor((position - grid.corner) / grid.width)), vec3i(0), grid.cells - 1);
}

// t at which a ray crosses the far face of a voxel, for each axis. It never crosses faces that it is parallel to.
fn exits(voxel: vec3i, origin: vec3f, direction: vec3f) -> vec3f {
    let ahead = select(vec3i(0), vec3i(1), direction > vec3f(0.0));
    let face = grid.corner + grid.width * vec3f(voxel + ahead);
    let parallel = abs(direction) < vec3f(1e-20);
    return select((face - origin) / select(direction, vec3f(1.0), parallel), vec3f(INFINITE), parallel);
}

// t at which a ray enters the grid, 0 if it begins inside; negative if it passes it.
fn entry(origin: vec3f, direction: vec3f) -> f32 {
    let last = select(vec3i(0), grid.cells - 1, direction > vec3f(0.0));
    let first = grid.cells - 1 - last;
    let leave = exits(last, origin, direction);
    // Where the ray enters is where one that comes the other way leaves.
    let come = -exits(first, origin, -direction);
    let position = (origin - grid.corner) / grid.width;
    let beside = (abs(direction) < vec3f(1e-20)) & ((position < vec3f(0.0)) | (position > vec3f(grid.cells)));
    let t = max(0.0, max(come.x, max(come.y, come.z)));
    let passes = t > min(leave.x, min(leave.y, leave.z)) || any(beside);
    return select(t, -1.0, passes);
}
