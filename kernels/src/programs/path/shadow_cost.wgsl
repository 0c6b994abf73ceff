// The cost of a shadow ray.

import package::state::{SCATTER};

@if(shadows) @group(0) @binding(16) var shadow_counters: texture_2d_array<u32>;

// The cost of the shadow ray, if one was cast.
fn cost_of_shadow(texel: vec2u, tag: u32) -> vec3u {
    @if(shadows) if (tag != SCATTER) {
        return vec3u(
            textureLoad(shadow_counters, texel, 0, 0).x,
            textureLoad(shadow_counters, texel, 1, 0).x,
            textureLoad(shadow_counters, texel, 2, 0).x,
        );
    }
    return vec3u(0u);
}
