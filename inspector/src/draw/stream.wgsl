// A stream as a picture: the colour of a texel follows from one of its components, read from the stream's own texture.

struct Picture {
    // Texel = (pixel + 0.5 - offset) / scale.
    offset: vec2f,
    scale: f32,
    layer: u32,
    lo: f32,
    hi: f32,
    exposure: f32,
    // Bits that mean "nothing here".
    unwritten: u32,
    // From here on a float means "never". WebGL wants the size to be a multiple of 16 bytes.
    @size(16) inf: f32,
}

// What is known before compiling, since some devices take every branch of what is not.
override MODE: u32;
// How the stream is kept, and the one that is subtracted, if any.
override SOURCE: u32;
override OTHER: u32;

// A layer of floats; of whole numbers; ids; three layers as a colour; a tag.
const SCALAR: u32 = 0u;
const COUNT: u32 = 1u;
const ID: u32 = 2u;
const COLOR: u32 = 3u;
const TAG: u32 = 4u;

// No stream; a layer of floats a component; a layer of words; one layer of words with a component in each.
const NONE: u32 = 0u;
const FLOATS: u32 = 1u;
const WORDS: u32 = 2u;
const PACKED: u32 = 3u;

const NAN: vec3f = vec3f(1.0, 0.0, 0.75);
const POSITIVE: vec3f = vec3f(0.95, 0.2, 0.1);
const NEGATIVE: vec3f = vec3f(0.1, 0.4, 1.0);
const NOTHING: vec3f = vec3f(0.11, 0.11, 0.13);

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var<uniform> colors: array<vec4f, 256>;
@group(0) @binding(2) var floats: texture_2d_array<f32>;
@group(0) @binding(3) var words: texture_2d_array<u32>;
@group(0) @binding(4) var other_floats: texture_2d_array<f32>;
@group(0) @binding(5) var other_words: texture_2d_array<u32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle that covers the target.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn bits_at(texel: vec2i, layer: u32) -> u32 {
    if SOURCE == FLOATS {
        return bitcast<u32>(textureLoad(floats, texel, layer, 0).x);
    }
    if SOURCE == PACKED {
        return textureLoad(words, texel, 0u, 0)[layer];
    }
    return textureLoad(words, texel, layer, 0).x;
}

fn other_bits_at(texel: vec2i, layer: u32) -> u32 {
    if OTHER == FLOATS {
        return bitcast<u32>(textureLoad(other_floats, texel, layer, 0).x);
    }
    if OTHER == PACKED {
        return textureLoad(other_words, texel, 0u, 0)[layer];
    }
    return textureLoad(other_words, texel, layer, 0).x;
}

fn is_special(bits: u32) -> bool {
    return (bits & 0x7f800000u) == 0x7f800000u;
}

// NaN and infinities are marked by a hatch as well as a colour, by pixels of the picture.
fn special(bits: u32, pixel: vec2f) -> vec3f {
    let stripe = ((i32(pixel.x + pixel.y) >> 2u) & 1) == 0;
    if (bits & 0x7fffffu) != 0u {
        return select(NAN, vec3f(0.0), stripe);
    }
    let color = select(POSITIVE, NEGATIVE, (bits >> 31u) != 0u);
    return select(color, vec3f(1.0), stripe);
}

fn hashed(id: u32) -> vec3f {
    var h = id * 0x9e3779b1u;
    h = (h ^ (h >> 15u)) * 0x85ebca77u;
    h = (h ^ (h >> 13u)) * 0xc2b2ae3du;
    h = h ^ (h >> 16u);
    let rgb = vec3f(f32(h & 255u), f32((h >> 8u) & 255u), f32((h >> 16u) & 255u)) / 255.0;
    return 0.25 + 0.7 * rgb;
}

fn mapped(value: f32) -> vec3f {
    let span = picture.hi - picture.lo;
    // A range without extent shows its one value in the middle.
    let at = select(0.5, (value - picture.lo) / span, span > 0.0);
    return colors[u32(clamp(at, 0.0, 1.0) * 255.0 + 0.5)].rgb;
}

fn srgb(linear: vec3f) -> vec3f {
    let x = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(x, vec3f(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3f(0.0031308));
}

fn color_of(texel: vec2i, pixel: vec2f) -> vec3f {
    let bits = bits_at(texel, picture.layer);
    if MODE == COLOR {
        let all = vec3u(bits, bits_at(texel, picture.layer + 1u), bits_at(texel, picture.layer + 2u));
        for (var c = 0u; c < 3u; c++) {
            if is_special(all[c]) {
                return special(all[c], pixel);
            }
        }
        return srgb(bitcast<vec3f>(all) * picture.exposure + picture.lo);
    }
    if OTHER != NONE {
        let there = other_bits_at(texel, picture.layer);
        if MODE == SCALAR && !is_special(bits) && !is_special(there) {
            return mapped(bitcast<f32>(bits) - bitcast<f32>(there));
        }
        if MODE == COUNT {
            return mapped(f32(bits) - f32(there));
        }
        return select(vec3f(1.0, 0.6, 0.1), NOTHING, bits == there);
    }
    if MODE == SCALAR {
        let value = bitcast<f32>(bits);
        if is_special(bits) {
            return special(bits, pixel);
        }
        return select(mapped(value), NOTHING, value >= picture.inf);
    }
    if bits == picture.unwritten {
        return NOTHING;
    }
    if MODE == ID {
        return hashed(bits);
    }
    if MODE == TAG {
        return colors[min(bits, 255u)].rgb;
    }
    return mapped(f32(bits));
}

@fragment
fn paint(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let size = vec2i(textureDimensions(floats).xy);
    let extent = select(vec2i(textureDimensions(words).xy), size, SOURCE == FLOATS);
    let at = (position.xy - picture.offset) / picture.scale;
    let texel = vec2i(floor(at));
    if any(texel < vec2i(0)) || any(texel >= extent) {
        return vec4f(0.0);
    }
    // Where several texels share a pixel, it shows their mean.
    let across = clamp(i32(ceil(1.0 / picture.scale - 0.01)), 1, 6);
    var sum = vec3f(0.0);
    for (var y = 0; y < across; y++) {
        for (var x = 0; x < across; x++) {
            sum += color_of(min(texel + vec2i(x, y), extent - 1), position.xy);
        }
    }
    var color = sum / f32(across * across);
    // A grid between texels that are large enough to be told apart.
    if picture.scale >= 12.0 {
        let within = fract(at) * picture.scale;
        if any(within < vec2f(1.0)) {
            color = mix(color, vec3f(0.0), 0.35);
        }
    }
    return vec4f(color, 1.0);
}
