// What all shaders of the 3D view share.

struct View {
    // From lengths relative to `center`.
    clip_from_world: mat4x4f,
    // Towards the light, unit length.
    light: vec3f,
    // Of the scene's triangles.
    opacity: f32,
    // The scene's middle, traced units.
    center: vec3f,
    // How dark the edges between triangles are.
    edges: f32,
    size_px: vec2f,
    // Least w of what is drawn.
    near: f32,
    // Opacity of what lies behind the scene's triangles.
    hidden: f32,
    // Brings the drawing in front of the triangle that it lies on: factor and summand of the depth.
    nearer: vec2f,
    // Width of the wireframe's lines.
    wire_px: f32,
    // Opacity of the triangles in front of the walk, relative to the others.
    in_front: f32,
    // The plane where the walk begins, seen from the eye: the view's direction, and the distance along it.
    front: vec4f,
    // The background, into which triangles fade with depth, and 1 over the depth of the whole scene.
    haze: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;

fn nearer(clip: vec4f) -> vec4f {
    let z = min(clip.z * view.nearer.x + view.nearer.y * clip.w, clip.w);
    return vec4f(clip.xy, z, clip.w);
}
