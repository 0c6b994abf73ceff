// What kernels know of the scene and the run as numbers.

struct SceneInfo {
    triangles: u32,
    // Most steps of a ray in one pass.
    steps: u32,
    // Rays; the texels of a picture, or fewer where rays are given.
    rays: u32,
    // Where this dispatch begins, in rows of workgroups.
    first_row: u32,
}

@group(1) @binding(2) var<uniform> scene: SceneInfo;
