// The ray of a pixel: from the eye through the pixel's centre, or another point in it, on the view plane, which is at
// distance 1.
// The direction is not normalised, so t is the depth along the view axis, and there is no square root, whose rounding
// differs between GPUs.

struct Camera {
    // The eye; for parallel rays the centre of the image. Traced units.
    eye: vec3f,
    // 2 / width and 2 / height of the image in pixels.
    pixel_x: f32,
    // From the centre of the view plane to its right edge.
    right: vec3f,
    pixel_y: f32,
    // From the centre of the view plane to its upper edge.
    up: vec3f,
    // From the eye to the centre of the view plane; the direction of parallel rays.
    forward: vec3f,
}

@group(1) @binding(0) var<uniform> camera: Camera;

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

fn eye_ray(texel: vec2u) -> Ray {
    return eye_ray_at(vec2f(texel) + 0.5);
}

// The ray through a point, in pixels from the image's upper left corner.
fn eye_ray_at(place: vec2f) -> Ray {
    let x = place.x * camera.pixel_x - 1.0;
    let y = 1.0 - place.y * camera.pixel_y;
    @if(perspective) return Ray(camera.eye, camera.forward + camera.right * x + camera.up * y);
    @else return Ray(camera.eye + camera.right * x + camera.up * y, camera.forward);
}
