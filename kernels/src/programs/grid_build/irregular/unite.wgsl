import package::launch::{BLOCK, launch, element};
import package::leaf::{load_at};
import package::merging::{absorbs, is_absorbed, place, wished};

@group(0) @binding(0) var list: texture_2d_array<u32>;
@group(0) @binding(1) var kept: texture_storage_2d_array<r32uint, write>;

// Decides which leaves are merged: how many leaves and references replace each.
@compute @workgroup_size(BLOCK)
fn unite(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = place(i);
    var length = load_at(list, at, 1u);
    let is_gone = is_absorbed(at);
    if (is_gone) {
        length = 0u;
    } else if (absorbs(at)) {
        length += load_at(list, place(load_at(wished, at, 0u)), 1u) - load_at(wished, at, 1u);
    }
    textureStore(kept, at, 0, vec4u(u32(!is_gone)));
    textureStore(kept, at, 1, vec4u(length));
}
