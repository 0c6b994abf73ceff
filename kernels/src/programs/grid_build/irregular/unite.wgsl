import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};
import package::merging::{absorbs, is_absorbed, wished};
import package::ranks::{count};

@group(0) @binding(0) var list: texture_2d_array<u32>;
@group(0) @binding(1) var places: texture_storage_2d_array<r32uint, write>;

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
    var length = load(list, i, 1u);
    let is_gone = is_absorbed(i);
    if (is_gone) {
        length = 0u;
    } else if (absorbs(i)) {
        let next = load(wished, i, 0u);
        let its_listed = load(list, next, 1u);
        length += its_listed - count(0u, load(list, next, 0u), its_listed);
    }
    let at = texel(i, textureDimensions(places).x);
    textureStore(places, at, 0, vec4u(u32(!is_gone)));
    textureStore(places, at, 1, vec4u(length));
    textureStore(places, at, 2, vec4u(0u));
}
