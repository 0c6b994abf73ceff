import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::candidate::{is_its_turn};
import package::leaf::{STAYS, load_at, place_in, space_at, level_of};
import package::ranks::{count};
import package::sums::{sum_before};
import package::u64::{share};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var division: texture_2d_array<u32>;
@group(0) @binding(3) var places: texture_2d_array<u32>;
@group(0) @binding(4) var totals: texture_2d_array<u32>;
@group(0) @binding(8) var places_of_block: texture_2d_array<u32>;
@group(0) @binding(5) var next_space: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var next_list: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(7) var next_division: texture_storage_2d_array<r32uint, write>;

fn store(i: u32, extent: vec3u, list: vec2u, division: vec2u) {
    let at = texel(i, textureDimensions(next_space).x);
    textureStore(next_space, at, 0, vec4u(extent.x));
    textureStore(next_space, at, 1, vec4u(extent.y));
    textureStore(next_space, at, 2, vec4u(extent.z));
    textureStore(next_list, at, 0, vec4u(list.x));
    textureStore(next_list, at, 1, vec4u(list.y));
    textureStore(next_division, at, 0, vec4u(division.x));
    textureStore(next_division, at, 1, vec4u(division.y));
}

// Leaves of the workgroup that are divided, in any order: each has its own place. What their octants have in common is kept
// here, so that eight threads write them side by side.
var<workgroup> next_divided: atomic<u32>;
var<workgroup> low_xy: array<u32, BLOCK>;
// The lowest virtual cell along z, and in the upper half of the word the levels of the octants.
var<workgroup> low_z_levels: array<u32, BLOCK>;
var<workgroup> its_list: array<vec2u, BLOCK>;
var<workgroup> its_budget: array<u32, BLOCK>;
// Where its octants go, and their references.
var<workgroup> its_places: array<vec2u, BLOCK>;
// Lengths of the octants' lists.
var<workgroup> listed: array<u32, 8u * BLOCK>;

// Moves a leaf, or takes down what its octants need.
fn move_or_divide(i: u32) {
    let at = place_in(places, i);
    let to = sum_before(places, at, places_of_block, i, 0u);
    let reference = sum_before(places, at, places_of_block, i, 1u);
    var end = load_at(totals, vec2u(0u), 0u);
    if (i + 1u < launch.elements) {
        end = sum_before(places, place_in(places, i + 1u), places_of_block, i + 1u, 0u);
    }
    let extent = space_at(space, at);
    let own = vec2u(load_at(list, at, 0u), load_at(list, at, 1u));
    let budget = load_at(division, at, 0u);
    let levels = load_at(division, at, 1u);
    if (end - to != 8u) {
        let its_levels = levels | select(0u, STAYS, is_its_turn(levels));
        store(to, extent, vec2u(reference, own.y), vec2u(budget, its_levels));
        return;
    }
    let k = atomicAdd(&next_divided, 1u);
    low_xy[k] = (extent.x & 0xffffu) | (extent.y << 16u);
    low_z_levels[k] = (extent.z & 0xffffu) | ((levels + 1u) << 16u);
    its_list[k] = own;
    its_budget[k] = budget;
    its_places[k] = vec2u(to, reference);
}

fn store_octant(k: u32, half: u32) {
    var before = 0u;
    var in_all = 0u;
    for (var h = 0u; h < 8u; h++) {
        let length = listed[8u * k + h];
        before += select(0u, length, h < half);
        in_all += length;
    }
    let levels = low_z_levels[k] >> 16u;
    let width = (1u << build.levels) >> level_of(levels);
    let corner = vec3u(low_xy[k] & 0xffffu, low_xy[k] >> 16u, low_z_levels[k] & 0xffffu);
    let low = corner + width * ((vec3u(half) >> vec3u(0u, 1u, 2u)) & vec3u(1u));
    let length = listed[8u * k + half];
    let budget = share(its_budget[k], length, max(in_all, 1u));
    let its_place = its_places[k];
    store(its_place.x + half, low | ((low + width) << vec3u(16u)), vec2u(its_place.y + before, length), vec2u(budget, levels));
}

// Replaces each divided leaf by its eight octants, and moves the others. Those whose turn it was stay as they are.
@compute @workgroup_size(BLOCK)
fn divide(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    if (lane == 0u) {
        atomicStore(&next_divided, 0u);
    }
    workgroupBarrier();
    let i = element(group, groups, lane);
    if (i < launch.elements) {
        move_or_divide(i);
    }
    workgroupBarrier();
    let octants = 8u * atomicLoad(&next_divided);
    for (var k = lane; k < octants; k += BLOCK) {
        listed[k] = count(k % 8u, its_list[k / 8u].x, its_list[k / 8u].y);
    }
    workgroupBarrier();
    for (var k = lane; k < octants; k += BLOCK) {
        store_octant(k / 8u, k % 8u);
    }
}
