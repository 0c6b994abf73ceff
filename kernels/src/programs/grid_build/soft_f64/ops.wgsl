// Applies every operation of soft_f64 to a pair of numbers, for the test.

import package::soft_f64::{f64_add, f64_sub, f64_mul, f64_div, f64_min, f64_max, f64_neg, f64_abs};
import package::soft_f64::{f64_ge, f64_lt, f64_to_i32, f64_from_i32, f64_from_f32};

struct Given {
    a: vec2u,
    b: vec2u,
    f32_bits: u32,
    i32_bits: u32,
}

@group(0) @binding(0) var<storage, read> given: array<Given>;
@group(0) @binding(1) var<storage, read_write> results: array<array<vec2u, 11>>;

@compute @workgroup_size(64)
fn ops(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if (i >= arrayLength(&given)) {
        return;
    }
    let a = given[i].a;
    let b = given[i].b;
    results[i][0] = f64_add(a, b);
    results[i][1] = f64_sub(a, b);
    results[i][2] = f64_mul(a, b);
    results[i][3] = f64_div(a, b);
    results[i][4] = f64_min(a, b);
    results[i][5] = f64_max(a, b);
    results[i][6] = f64_neg(a);
    results[i][7] = f64_abs(a);
    results[i][8] = f64_from_f32(given[i].f32_bits);
    results[i][9] = f64_from_i32(i32(given[i].i32_bits));
    results[i][10] = vec2u(u32(f64_ge(a, b)) | (u32(f64_lt(a, b)) << 1u), u32(f64_to_i32(a)));
}
