// The scene as a function: the distance from a point to the nearest surface, or less.

const EYE: vec3f = vec3f(0.0, 1.2, -4.0);

fn distance_to(p: vec3f) -> f32 {
    let ball = length(p - vec3f(0.0, 1.0, 0.0)) - 0.8;
    let ring = length(vec2f(length(p.xz - vec2f(0.2, -0.3)) - 1.5, p.y - 0.25)) - 0.2;
    // Smoothly joined (Quilez 2013).
    let mix_at = clamp(0.5 + 0.5 * (ring - ball) / 0.3, 0.0, 1.0);
    let joined = mix(ring, ball, mix_at) - 0.3 * mix_at * (1.0 - mix_at);
    return min(joined, p.y);
}

fn direction_of(pixel: vec2u, size: vec2u) -> vec3f {
    let at = (vec2f(pixel) + 0.5 - 0.5 * vec2f(size)) / f32(size.y);
    return normalize(vec3f(at.x, -at.y - 0.1, 1.0));
}
