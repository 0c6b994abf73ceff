import package::launch::{BLOCK, launch, element_of_rows, texel};
import package::leaf::{load_at};
import package::merging::{NOBODY, place, wished_by};
import package::sums::{sum_before};

@group(0) @binding(0) var kept: texture_2d_array<u32>;
@group(0) @binding(2) var kept_of_block: texture_2d_array<u32>;
@group(0) @binding(1) var cell_of: texture_storage_2d_array<r32uint, read_write>;

// Follows the leaves of the octrees to where they were moved.
@compute @workgroup_size(BLOCK)
fn follow(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(cell_of).x);
    var leaf = textureLoad(cell_of, at, 0).x;
    var its_place = place(leaf);
    let before = load_at(wished_by, its_place, 0u);
    if (before != NOBODY && load_at(wished_by, place(before), 0u) == NOBODY) {
        leaf = before;
        its_place = place(leaf);
    }
    textureStore(cell_of, at, 0, vec4u(sum_before(kept, its_place, kept_of_block, leaf, 0u)));
}
