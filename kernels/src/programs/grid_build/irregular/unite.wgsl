import package::launch::{BLOCK, launch, element_of_rows};
import package::leaf::{load_at};
import package::merging::{NOBODY, merged, place};

@group(0) @binding(0) var list: texture_2d_array<u32>;
@group(0) @binding(1) var kept: texture_storage_2d_array<r32uint, write>;

// Decides which leaves are merged: how many leaves and references replace each.
@compute @workgroup_size(BLOCK)
fn unite(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = place(i);
    var length = load_at(list, at, 1u);
    let it = merged(at);
    if (it.is_absorbed) {
        length = 0u;
    } else if (it.absorbed != NOBODY) {
        length += load_at(list, place(it.absorbed), 1u) - it.in_both;
    }
    textureStore(kept, at, 0, vec4u(u32(!it.is_absorbed)));
    textureStore(kept, at, 1, vec4u(length));
}
