// The walk through a compressed eight-wide tree (Ylitie, Karras and Laine, 2017), one node a step, with a
// stack of one group of siblings a level.
//
// Boxes are grown on the host by more than the rounding of the test here, so it needs no epsilon.

import package::constants::{WIDE_STACK};

// Five words a node, see WideNode in bvh/wide_node.rs.
@group(1) @binding(20) var<storage, read> wide_nodes: array<vec4u>;

// What a ray's walk keeps in registers.
struct WideRay {
    origin: vec3f,
    // 1 / direction, finite.
    inverse: vec3f,
    // Bits 2, 1, 0: the direction goes up along x, y, z; the same in each byte.
    octant: u32,
    negative: vec3<bool>,
}

fn wide_ray(origin: vec3f, inverse: vec3f) -> WideRay {
    let negative = inverse < vec3f(0.0);
    let octant = select(4u, 0u, negative.x) | select(2u, 0u, negative.y) | select(1u, 0u, negative.z);
    return WideRay(origin, inverse, octant * 0x01010101u, negative);
}

// Siblings that wait: of an inner group, base is the first child, and bits the hits (24-31, in the order of
// visits) and which slots are inner nodes (0-7); of a leaf group, the first entry and its hits (0-23).
struct WideGroup {
    base: u32,
    bits: u32,
}

struct WideHits {
    inner: WideGroup,
    leaf: WideGroup,
}

fn bytes(word: u32) -> vec4f {
    return vec4f((vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xffu));
}

// Hits of four children: as many bits each as it has entries, at the place of its first.
fn hits_of_four(contents: u32, ray: WideRay, near: vec3u, far: vec3u, scale: vec3f, offset: vec3f, nearest_t: f32) -> u32 {
    let inner = ((contents & (contents << 1u)) & 0x10101010u) >> 4u;
    let places = (contents ^ (ray.octant & (inner * 0xffu))) & 0x1f1f1f1fu;
    let marks = (contents >> 5u) & 0x07070707u;
    let enter = max(
        max(bytes(near.x) * scale.x + offset.x, bytes(near.y) * scale.y + offset.y),
        max(bytes(near.z) * scale.z + offset.z, vec4f(0.0)),
    );
    let leave = min(
        min(bytes(far.x) * scale.x + offset.x, bytes(far.y) * scale.y + offset.y),
        min(bytes(far.z) * scale.z + offset.z, vec4f(nearest_t)),
    );
    let met = enter <= leave;
    var hits = 0u;
    if (met.x) {
        hits |= (marks & 0xffu) << (places & 0xffu);
    }
    if (met.y) {
        hits |= ((marks >> 8u) & 0xffu) << ((places >> 8u) & 0xffu);
    }
    if (met.z) {
        hits |= ((marks >> 16u) & 0xffu) << ((places >> 16u) & 0xffu);
    }
    if (met.w) {
        hits |= (marks >> 24u) << (places >> 24u);
    }
    return hits;
}

fn visit_wide(node: u32, ray: WideRay, nearest_t: f32) -> WideHits {
    let head = wide_nodes[5u * node];
    let body = wide_nodes[5u * node + 1u];
    let x = wide_nodes[5u * node + 2u];
    let y = wide_nodes[5u * node + 3u];
    let z = wide_nodes[5u * node + 4u];
    let spacing = bitcast<vec3f>(((vec3u(head.w) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu)) << vec3u(23u));
    let scale = spacing * ray.inverse;
    let offset = (bitcast<vec3f>(head.xyz) - ray.origin) * ray.inverse;
    // A ray that goes down an axis meets the upper plane first.
    let x_near = select(x.xy, x.zw, ray.negative.x);
    let x_far = select(x.zw, x.xy, ray.negative.x);
    let y_near = select(y.xy, y.zw, ray.negative.y);
    let y_far = select(y.zw, y.xy, ray.negative.y);
    let z_near = select(z.xy, z.zw, ray.negative.z);
    let z_far = select(z.zw, z.xy, ray.negative.z);
    let hits = hits_of_four(body.z, ray, vec3u(x_near.x, y_near.x, z_near.x), vec3u(x_far.x, y_far.x, z_far.x),
            scale, offset, nearest_t)
        | hits_of_four(body.w, ray, vec3u(x_near.y, y_near.y, z_near.y), vec3u(x_far.y, y_far.y, z_far.y),
            scale, offset, nearest_t);
    return WideHits(
        WideGroup(body.x, (hits & 0xff000000u) | (head.w >> 24u)),
        WideGroup(body.y, hits & 0x00ffffffu),
    );
}

// The node of a group's next hit, which is the highest bit of its hits.
fn wide_child(group: WideGroup, bit: u32, ray: WideRay) -> u32 {
    let slot = (bit - 24u) ^ (ray.octant & 7u);
    return group.base + countOneBits(group.bits & ((1u << slot) - 1u) & 0xffu);
}
