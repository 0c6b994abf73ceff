// Sums of products in a fixed order: the built-in dot() may add in any order.

fn dot3(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn largest3(a: vec3f) -> f32 {
    return max(max(a.x, a.y), a.z);
}

// Length 1 along a, or 0 if a is too short to have a direction. Scaled first: the squares of a tiny vector would
// underflow.
fn unit3(a: vec3f) -> vec3f {
    let size = largest3(abs(a));
    if (!(size > 1e-37)) {
        return vec3f(0.0);
    }
    let scaled = a * (1.0 / size);
    return scaled * (1.0 / sqrt(dot3(scaled, scaled)));
}

fn smallest3(a: vec3f) -> f32 {
    return min(min(a.x, a.y), a.z);
}
