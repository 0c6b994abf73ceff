import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::leaf::{load};

@group(0) @binding(0) var references_in_all: texture_2d_array<u32>;
@group(0) @binding(1) var totals: texture_storage_2d_array<r32uint, write>;

// Notes how many leaves and references there are at first: the top level's.
@compute @workgroup_size(BLOCK)
fn count_top(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    textureStore(totals, vec2u(0u), 0, vec4u(build.cells.x * build.cells.y * build.cells.z));
    textureStore(totals, vec2u(0u), 1, vec4u(load(references_in_all, 0u, 0u)));
    textureStore(totals, vec2u(0u), 2, vec4u(0u));
}
