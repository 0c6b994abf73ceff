// The walk through a compressed eight-wide BVH (Ylitie, Karras and Laine, 2017), one node per step, with a stack of one
// group of siblings per level.
//
// Boxes are grown by more than the rounding errors of the test: on the host, or here (see bvh_walk.wgsl).

import package::constants::{BOX_PADDING};

// Five words per node, see WideNode in wide_node.rs.
@group(1) @binding(20) var<storage, read> wide_nodes: array<vec4u>;

// Words of a restart trail, eight levels each; its last level; and what stands for none of a group's children.
const TRAIL_WORDS: u32 = 4u;
const MOST_LEVELS: u32 = 31u;
const NO_CHILD: u32 = 8u;

// The child entered at a level, from the word of the trail that contains the level.
fn trail_child(word: u32, level: u32) -> u32 {
    return (word >> (4u * (level % 8u))) & 15u;
}

// The word with a different child at the level.
fn with_trail_child(word: u32, level: u32, child: u32) -> u32 {
    let shift = 4u * (level % 8u);
    return (word & ~(15u << shift)) | (child << shift);
}

// The variables of a ray's walk, kept in registers.
struct WideRay {
    origin: vec3f,
    // 1 / direction, kept finite.
    inverse: vec3f,
    // Bits 2, 1, 0: the direction is not negative along x, y, z.
    octant: u32,
    negative: vec3<bool>,
}

fn wide_ray(origin: vec3f, inverse: vec3f) -> WideRay {
    let negative = inverse < vec3f(0.0);
    let octant = select(4u, 0u, negative.x) | select(2u, 0u, negative.y) | select(1u, 0u, negative.z);
    return WideRay(origin, inverse, octant, negative);
}

// Siblings that wait: base is the first child of an inner group, and bits holds the hits (24-31, in the order of
// visits) and the slots that are inner nodes (0-7).
struct WideGroup {
    base: u32,
    bits: u32,
}

// The entries of a node's leaves: bits (0-23) are those whose boxes were met, out of all of the node's.
struct WideLeaves {
    base: u32,
    bits: u32,
    all: u32,
}

struct WideHits {
    inner: WideGroup,
    leaves: WideLeaves,
}

// As integers, f32s that are not negative keep their order, and negative ones are below them: enough for max with 0,
// and for min where a negative value means a miss. GPUs compute more of these per clock.
fn ints(v: vec4f) -> vec4i {
    return bitcast<vec4i>(v);
}

fn bytes(word: u32) -> vec4f {
    return vec4f((vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(0xffu));
}

// Shifts a bit for each of four boxes into the misses, the last box's lowest: the sign of leave - enter. Lower planes
// along the ray are at `enter_at`, upper ones at `leave_at`, plus a number of `scale`.
fn misses_of_four(
    misses: u32,
    near: vec3u,
    far: vec3u,
    scale: vec3f,
    enter_at: vec3f,
    leave_at: vec3f,
    nearest_t: f32,
) -> u32 {
    let enter = bitcast<vec4f>(max(
        max(ints(bytes(near.x) * scale.x + enter_at.x), ints(bytes(near.y) * scale.y + enter_at.y)),
        max(ints(bytes(near.z) * scale.z + enter_at.z), vec4i(0)),
    ));
    let leave = bitcast<vec4f>(min(
        min(ints(bytes(far.x) * scale.x + leave_at.x), ints(bytes(far.y) * scale.y + leave_at.y)),
        min(ints(bytes(far.z) * scale.z + leave_at.z), vec4i(bitcast<i32>(nearest_t))),
    ));
    let inside = bitcast<vec4u>(leave - enter);
    var shifted = (misses << 1u) | (inside.w >> 31u);
    shifted = (shifted << 1u) | (inside.z >> 31u);
    shifted = (shifted << 1u) | (inside.y >> 31u);
    return (shifted << 1u) | (inside.x >> 31u);
}

// Moves bit s of eight to bit s ^ octant.
fn in_order(slots: u32, ray: WideRay) -> u32 {
    var bits = slots;
    bits = select(((bits & 0x0fu) << 4u) | (bits >> 4u), bits, ray.negative.x);
    bits = select(((bits & 0x33u) << 2u) | ((bits >> 2u) & 0x33u), bits, ray.negative.y);
    return select(((bits & 0x55u) << 1u) | ((bits >> 1u) & 0x55u), bits, ray.negative.z);
}

// Copies bit s of eight to bits 3s to 3s + 2.
fn tripled(slots: u32) -> u32 {
    var bits = (slots | (slots << 8u)) & 0x00f00fu;
    bits = (bits | (bits << 4u)) & 0x0c30c3u;
    bits = (bits | (bits << 2u)) & 0x249249u;
    return bits * 7u;
}

fn visit_wide(node: u32, ray: WideRay, nearest_t: f32) -> WideHits {
    let head = wide_nodes[5u * node];
    let body = wide_nodes[5u * node + 1u];
    let x = wide_nodes[5u * node + 2u];
    let y = wide_nodes[5u * node + 3u];
    let z = wide_nodes[5u * node + 4u];
    let spacing = bitcast<vec3f>(((vec3u(head.w) >> vec3u(0u, 8u, 16u)) & vec3u(0xffu)) << vec3u(23u));
    let scale = spacing * ray.inverse;
    let low = bitcast<vec3f>(head.xyz) - ray.origin;
    let offset = low * ray.inverse;
    @if(ray_padding) let far = abs(low) + 256.0 * spacing;
    @if(ray_padding) let padding = (BOX_PADDING * max(max(far.x, far.y), far.z)) * abs(ray.inverse);
    @if(ray_padding) let enter_at = offset - padding;
    @if(ray_padding) let leave_at = offset + padding;
    @if(!ray_padding) let enter_at = offset;
    @if(!ray_padding) let leave_at = offset;
    // A ray that goes down along an axis meets the upper plane first.
    let x_near = select(x.xy, x.zw, ray.negative.x);
    let x_far = select(x.zw, x.xy, ray.negative.x);
    let y_near = select(y.xy, y.zw, ray.negative.y);
    let y_far = select(y.zw, y.xy, ray.negative.y);
    let z_near = select(z.xy, z.zw, ray.negative.z);
    let z_far = select(z.zw, z.xy, ray.negative.z);
    var misses = misses_of_four(0u, vec3u(x_near.y, y_near.y, z_near.y), vec3u(x_far.y, y_far.y, z_far.y),
        scale, enter_at, leave_at, nearest_t);
    misses = misses_of_four(misses, vec3u(x_near.x, y_near.x, z_near.x), vec3u(x_far.x, y_far.x, z_far.x),
        scale, enter_at, leave_at, nearest_t);
    let hits = ~misses & 0xffu;
    let inner = body.z >> 24u;
    return WideHits(
        WideGroup(body.x, (in_order(hits & inner, ray) << 24u) | inner),
        WideLeaves(body.y, tripled(hits) & body.z, body.z),
    );
}

// The entry for a hit on a leaf.
fn wide_entry(leaves: WideLeaves, bit: u32) -> u32 {
    return leaves.base + countOneBits(leaves.all & ((1u << bit) - 1u));
}

// The node for the next hit in a group, which is the highest bit of its hits.
fn wide_child(group: WideGroup, bit: u32, ray: WideRay) -> u32 {
    let slot = (bit - 24u) ^ ray.octant;
    return group.base + countOneBits(group.bits & ((1u << slot) - 1u) & 0xffu);
}
