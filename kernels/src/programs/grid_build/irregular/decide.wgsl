import package::launch::{BLOCK, launch, element_of_rows};
import package::leaf::{load_at, place_in, level_of, even_of};
import package::candidate::{is_its_turn, may_be_divided};
import package::ranks::{count};

@group(0) @binding(0) var list: texture_2d_array<u32>;
@group(0) @binding(1) var division: texture_2d_array<u32>;
@group(0) @binding(2) var places: texture_storage_2d_array<r32uint, write>;

// Cost of a step from cell to cell, in quarters of a triangle test.
const STEP_COST: u32 = 2u;
const LONG: u32 = 64u;

// Decides which leaves are divided: how many leaves and references replace each, and how many of these leaves may be
// divided later.
@compute @workgroup_size(BLOCK)
fn decide(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = place_in(list, i);
    let first = load_at(list, at, 0u);
    let length = load_at(list, at, 1u);
    let levels = load_at(division, at, 1u);
    var is_divided = false;
    var after = 0u;
    var left = 0u;
    if (!is_its_turn(levels)) {
        left = u32(may_be_divided(levels, length));
    } else if (may_be_divided(levels, length)) {
        for (var half = 0u; half < 8u; half++) {
            let listed = count(half, first, length);
            after += listed;
            left += u32(may_be_divided(levels + 1u, listed));
        }
        let is_gain = after + STEP_COST < 4u * length && after <= load_at(division, at, 0u);
        is_divided = is_gain || (level_of(levels) < even_of(levels) && length <= LONG);
        left = select(0u, left, is_divided);
    }
    textureStore(places, at, 0, vec4u(select(1u, 8u, is_divided)));
    textureStore(places, at, 1, vec4u(select(length, after, is_divided)));
    textureStore(places, at, 2, vec4u(left));
}
