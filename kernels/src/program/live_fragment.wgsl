// In place of `live`, if kernels run as fragment programs: a fragment is a workgroup of one thread, whose position in the
// grid of workgroups is its texel. The host learns by occlusion queries or from the states where rays went.

fn tiled_texel(group: vec3u, lane: u32) -> vec2u {
    return group.xy;
}

fn send(lane: u32, texel: vec2u, tag: u32) {}

fn book(lane: u32, tag: u32) {}
