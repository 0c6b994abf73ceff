// Tests the cells of each span: at most 32 along x, in one row of a triangle's box.

import package::launch::{BLOCK, launch, block_index, texel};
import package::build::{build};
import package::filter::{UNCERTAIN, filter_box, filter_triangle, width_after};
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

// Where a span lies, and its triangle.
struct Place {
    triangle: u32,
    // The triangle's only cell is this one.
    is_whole: bool,
    first: vec3u,
    // Along x.
    last: u32,
}

fn place_of(i: u32) -> Place {
    let t = triangle_of(i);
    let low = load_box(t, 0u);
    let high = load_box(t, 3u);
    let spans_a_row = (high.x - low.x + 32u) / 32u;
    let within = i - load_first_span(t);
    let row = within / spans_a_row;
    let rows = high.y - low.y + 1u;
    let first = low + vec3u(32u * (within % spans_a_row), row % rows, row / rows);
    return Place(t, all(low == high), first, min(first.x + 31u, high.x));
}

// The cells that overlap, where all of them are certain.
struct Certain {
    cells: u32,
    is_certain: bool,
}

fn certain_cells(place: Place) -> Certain {
    if (place.is_whole) {
        // The only cell it can be in.
        return Certain(1u, true);
    }
    if (!filter_triangle(place.triangle)) {
        return Certain(0u, false);
    }
    let width = width_after(0u);
    let corner = bitcast<vec3f>(build.corner);
    var cells = 0u;
    for (var x = place.first.x; x <= place.last; x++) {
        let cell = vec3f(vec3u(x, place.first.yz));
        let overlaps = filter_box(corner + (cell + 0.5) * width, 0.5 * width);
        if (overlaps == UNCERTAIN) {
            return Certain(0u, false);
        }
        cells |= overlaps << (x - place.first.x);
    }
    return Certain(cells, true);
}

fn exact_cells(place: Place) -> u32 {
    var cells = 0u;
    prepare(place.triangle);
    if (enter_row(place.first.y, place.first.z)) {
        for (var x = place.first.x; x <= place.last; x++) {
            cells |= u32(meets(x)) << (x - place.first.x);
        }
    }
    return cells;
}

fn store(i: u32, place: Place, cells: u32) {
    let at = texel(i, textureDimensions(mask).x);
    textureStore(triangle, at, 0, vec4u(place.triangle));
    textureStore(cells_at, at, 0, vec4u(place.first.x));
    textureStore(cells_at, at, 1, vec4u(place.first.y));
    textureStore(cells_at, at, 2, vec4u(place.first.z));
    textureStore(mask, at, 0, vec4u(cells));
    textureStore(first_reference, at, 0, vec4u(countOneBits(cells)));
}

// Threads whose spans are not certain, in any order: what they find does not depend on it.
var<workgroup> waiting: array<u32, BLOCK>;
var<workgroup> waiting_count: atomic<u32>;

// Its loops, with those of the functions it calls, take fewer than 600 iterations; Mesa's software Vulkan ends a
// thread's loops after 65,535.
@compute @workgroup_size(BLOCK)
fn span(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = block_index(group, groups) * BLOCK;
    if (lane == 0u) {
        atomicStore(&waiting_count, 0u);
    }
    workgroupBarrier();
    if (first + lane < launch.elements) {
        let place = place_of(first + lane);
        let certain = certain_cells(place);
        if (certain.is_certain) {
            store(first + lane, place, certain.cells);
        } else {
            waiting[atomicAdd(&waiting_count, 1u)] = lane;
        }
    }
    workgroupBarrier();
    // Those that wait are few: side by side, they keep few threads busy for long.
    if (lane < atomicLoad(&waiting_count)) {
        let i = first + waiting[lane];
        let place = place_of(i);
        store(i, place, exact_cells(place));
    }
}
