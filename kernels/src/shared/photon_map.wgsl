// The grid that photons are sorted into, and what is known of them all. With mirrors or glass, there are two maps with the same
// cells: a global one, and one of caustics, whose photons came by mirrors and glass alone (Jensen 1996).

import package::vector::{dot3};

struct PhotonMap {
    // Of the scene's box, the corner at which the cells begin; traced units.
    corner: vec3f,
    photons: u32,
    // Cells along each axis, and in all, of one map.
    size: vec3u,
    cells: u32,
    // A sphere about the center with this radius holds the scene.
    center: vec3f,
    reach: f32,
    // Cells by traced unit.
    per_unit: f32,
    // Of a cell.
    width: f32,
    // How far away photons may be that light is estimated from: less than the width.
    radius: f32,
    // How far off a point's place may be by rounding, in cells.
    margin: f32,
    // From how many photons light is estimated.
    nearest: u32,
    // Number of places where photons may be stored.
    records: u32,
    // Photons by row of their texture.
    row: u32,
    maps: u32,
}

@group(1) @binding(28) var<uniform> photon_map: PhotonMap;

// Where a point is among the cells.
fn place_of(point: vec3f) -> vec3f {
    return (point - photon_map.corner) * photon_map.per_unit;
}

// The cell there; the nearest if there is none.
fn cell_of(place: vec3f) -> vec3i {
    return clamp(vec3i(floor(place)), vec3i(0), vec3i(photon_map.size) - vec3i(1));
}

// The 1-D index of a cell of a map: those of the second follow those of the first.
fn index_of(map: u32, cell: vec3i) -> u32 {
    let at = vec3u(cell);
    return map * photon_map.cells + (at.z * photon_map.size.y + at.y) * photon_map.size.x + at.x;
}

fn has_cell(cell: vec3i) -> bool {
    return all(cell >= vec3i(0)) && all(cell < vec3i(photon_map.size));
}

// At most the squared distance from a place to the cell a step away from its own, in traced units.
fn distance_to(place: vec3f, cell: vec3i, step: vec3i) -> f32 {
    let below = place - vec3f(cell);
    let away = select(select(vec3f(0.0), below, step < vec3i(0)), vec3f(1.0) - below, step > vec3i(0));
    let least = max(away - vec3f(photon_map.margin), vec3f(0.0)) * photon_map.width;
    return dot3(least, least);
}
