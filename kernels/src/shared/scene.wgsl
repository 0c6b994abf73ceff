// Numbers that describe the scene and the run to kernels.

@if(apart) import package::launch::{launch};

struct SceneInfo {
    triangles: u32,
    // Most steps of a ray in one pass.
    steps: u32,
    // Number of rays: the texels of an image, or fewer with input rays.
    rays: u32,
    // First row of workgroups of this dispatch.
    first_row: u32,
    // Size of the streams.
    size: vec2u,
    // WebGL wants the size of a uniform to be a multiple of 16 bytes.
    padding: vec2u,
}

@group(1) @binding(2) var<uniform> scene: SceneInfo;

// The size of the streams that a kernel works on.
@if(!apart)
fn size_of_streams() -> vec2u {
    return scene.size;
}

// Of elements that are not the image's: they fill whole rows.
@if(apart)
fn size_of_streams() -> vec2u {
    return vec2u(launch.width, launch.elements / launch.width);
}
