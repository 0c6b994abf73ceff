import package::launch::{BLOCK, launch, element};

@group(0) @binding(0) var halving: texture_storage_2d_array<r32uint, read_write>;

// Counts the halvings.
@compute @workgroup_size(BLOCK)
fn next_halving(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    if (element(group, groups, lane) < launch.elements) {
        textureStore(halving, vec2u(0u), 0, vec4u(textureLoad(halving, vec2u(0u), 0).x + 1u));
    }
}
