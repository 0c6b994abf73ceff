import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load, load_space};
import package::merging::{absorbs, is_absorbed, wished};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var round: texture_2d_array<u32>;
@group(0) @binding(2) var places: texture_2d_array<u32>;
@group(0) @binding(3) var totals: texture_2d_array<u32>;
@group(0) @binding(4) var next_space: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var next_list: texture_storage_2d_array<r32uint, write>;

// Moves every leaf that remains to its new place, with the box of the one that is merged into it.
@compute @workgroup_size(BLOCK)
fn gather(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    if (is_absorbed(i)) {
        return;
    }
    var extent = load_space(space, i);
    if (absorbs(i)) {
        let axis = load(round, 0u, 0u);
        let other = load_space(space, load(wished, i, 0u));
        extent[axis] = (extent[axis] & 0xffffu) | (other[axis] & 0xffff0000u);
    }
    let first = load(places, i, 1u);
    var end = load(totals, 0u, 1u);
    if (i + 1u < launch.elements) {
        end = load(places, i + 1u, 1u);
    }
    let at = texel(load(places, i, 0u), textureDimensions(next_space).x);
    textureStore(next_space, at, 0, vec4u(extent.x));
    textureStore(next_space, at, 1, vec4u(extent.y));
    textureStore(next_space, at, 2, vec4u(extent.z));
    textureStore(next_list, at, 0, vec4u(first));
    textureStore(next_list, at, 1, vec4u(end - first));
}
