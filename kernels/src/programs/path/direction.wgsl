// A random direction about a normal, and the sine and cosine that it needs.

import package::vector::{unit3};

// Cosine and sine of so many turns, from 0 to 1: the polynomials of Moshier's Cephes (1989) between -1/8 and 1/8 turn.
fn on_circle(turns: f32) -> vec2f {
    let quarter = floor(4.0 * turns + 0.5);
    let angle = (4.0 * turns - quarter) * 1.57079637;
    let square = angle * angle;
    let sine = angle + angle * square * ((-1.9515296e-4 * square + 8.332161e-3) * square - 0.16666655);
    let cosine = 1.0 - 0.5 * square
        + square * square * ((2.4433157e-5 * square - 1.3887316e-3) * square + 4.1666646e-2);
    let is_odd = (u32(quarter) & 1u) == 1u;
    let at = select(vec2f(cosine, sine), vec2f(-sine, cosine), is_odd);
    return select(at, -at, (u32(quarter) & 2u) == 2u);
}

// What is at right angles to a normal of length 1, with these coordinates along two axes there (Duff et al. 2017).
fn perpendicular(normal: vec3f, at: vec2f) -> vec3f {
    let side = select(-1.0, 1.0, normal.z >= 0.0);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    let first = vec3f(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x);
    let second = vec3f(b, side + normal.y * normal.y * a, -normal.y);
    return first * at.x + second * at.y;
}

// A direction of length 1 about a normal of length 1, with a pdf of cosine / pi, by two numbers from 0 to below 1.
fn cosine_weighted(normal: vec3f, by: vec2f) -> vec3f {
    let at = on_circle(by.y) * sqrt(by.x);
    return unit3(perpendicular(normal, at) + normal * sqrt(1.0 - by.x));
}
