// The scene's triangles, flat: corners are read from a texture, so that each vertex knows its triangle's normal. A texel
// has the bits of a corner's x, y and z, and the triangle's colour.

@group(1) @binding(0) var corners: texture_2d<u32>;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) color: vec3f,
    // Weights of the corners.
    @location(1) weights: vec3f,
    // Distance behind the plane where the walk begins.
    @location(2) behind: f32,
}

fn texel(triangle: u32, i: u32) -> vec4u {
    let index = 3u * triangle + i;
    let width = textureDimensions(corners).x;
    return textureLoad(corners, vec2u(index % width, index / width), 0);
}

fn corner(triangle: u32, i: u32) -> vec3f {
    return bitcast<vec3f>(texel(triangle, i).xyz) - view.center;
}

@vertex
fn vs_triangle(@builtin(vertex_index) index: u32) -> Varying {
    let triangle = index / 3u;
    let i = index % 3u;
    let a = corner(triangle, 0u);
    let normal = cross(corner(triangle, 1u) - a, corner(triangle, 2u) - a);
    // Both sides alike; a triangle without area has no normal and no pixels.
    let facing = abs(dot(normal, view.light)) * inverseSqrt(max(dot(normal, normal), 1e-36));
    let base = unpack4x8unorm(texel(triangle, 0u).w).rgb;
    var weights = vec3f();
    weights[i] = 1.0;
    let position = corner(triangle, i);
    let behind = dot(position, view.front.xyz) - view.front.w;
    // What is far away is fainter: depth can be seen.
    let depth = clamp(0.5 + dot(position, view.front.xyz) * view.haze.w, 0.0, 1.0);
    let color = mix(base * (0.22 + 0.78 * facing), view.haze.rgb, 0.5 * depth * depth);
    return Varying(view.clip_from_world * vec4f(position, 1.0), color, weights, behind);
}

// How much of the pixel an edge of the triangle covers; nothing where the triangles are about as small as pixels.
fn edge(weights: vec3f, width_px: f32) -> f32 {
    let change = max(fwidth(weights), vec3f(1e-12));
    let distance_px = weights / change;
    let covered = clamp(width_px * 0.5 + 0.5 - min(distance_px.x, min(distance_px.y, distance_px.z)), 0.0, 1.0);
    let crowded = max(change.x, max(change.y, change.z));
    return covered * clamp(1.5 - 4.0 * crowded, 0.0, 1.0);
}

// Opacity in relation to that of the scene: what is in front of the walk would hide it. It fades over a part of the
// scene's depth, so that a cut does not look like an end.
fn kept(behind: f32) -> f32 {
    return mix(view.in_front, 1.0, smoothstep(-0.02, 0.0, behind * view.haze.w));
}

// Opaque triangles write depth and are not sorted: they fade by leaving out pixels, by interleaved gradient noise
// (Jimenez, 2014).
fn is_left_out(kept: f32, pixel: vec2f) -> bool {
    let noise = fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
    return kept <= noise;
}

@fragment
fn fs_solid(in: Varying) -> @location(0) vec4f {
    // Derivatives first: GLSL does not define them after some pixels are discarded.
    let covered = edge(in.weights, 1.0) * view.edges;
    let share = kept(in.behind);
    let is_opaque = view.in_front == 0.0;
    if (is_opaque && is_left_out(share, in.position.xy)) {
        discard;
    }
    let color = in.color * (1.0 - 0.4 * covered);
    let opacity = mix(view.opacity, 1.0, 0.35 * covered) * select(share, 1.0, is_opaque);
    return vec4f(color * opacity, opacity);
}

@fragment
fn fs_wire(in: Varying) -> @location(0) vec4f {
    let change = max(fwidth(in.weights), vec3f(1e-12));
    let distance_px = in.weights / change;
    let nearest = min(distance_px.x, min(distance_px.y, distance_px.z));
    let opacity = clamp(view.wire_px * 0.5 + 0.5 - nearest, 0.0, 1.0) * view.opacity * kept(in.behind);
    return vec4f(in.color * opacity, opacity);
}
