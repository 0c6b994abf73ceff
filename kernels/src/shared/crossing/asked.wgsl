// For the test: a ray and two triangles in, every answer out.

import package::crossing::{compare_crossings, crosses_exactly};

@group(0) @binding(0) var<storage, read> given: array<f32>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;

fn point(at: u32) -> vec3f {
    return vec3f(given[at], given[at + 1u], given[at + 2u]);
}

@compute @workgroup_size(64)
fn asked(@builtin(global_invocation_id) id: vec3u) {
    let at = 24u * id.x;
    let o = point(at);
    let d = point(at + 3u);
    let crosses = crosses_exactly(o, d, point(at + 6u), point(at + 9u), point(at + 12u));
    let crosses_other = crosses_exactly(o, d, point(at + 15u), point(at + 18u), point(at + 21u));
    var order = 0;
    if (crosses && crosses_other) {
        order = compare_crossings(o, d, point(at + 6u), point(at + 9u), point(at + 12u), point(at + 15u), point(at + 18u), point(at + 21u));
    }
    results[2u * id.x] = u32(crosses) | (u32(crosses_other) << 1u);
    results[2u * id.x + 1u] = u32(order + 1);
}
