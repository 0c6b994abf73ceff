//! Twin of `texture.wgsl`: base colour textures.

use bytemuck::{Pod, Zeroable};

use crate::numbers::real::{Real, Vec3};

/// An entry of the buffer `textures`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Texture {
    /// Index of the first texel.
    pub first: u32,
    /// Texels per row.
    pub width: i32,
    /// Rows.
    pub height: i32,
    /// Bits 0-1 wrap of u, 2-3 wrap of v (0 repeat, 1 mirror, 2 clamp), bit 4 bilinear.
    pub sampling: u32,
}

fn wrap(i: i32, size: i32, mode: u32) -> i32 {
    if mode == 2 {
        return i.max(0).min(size - 1);
    }
    if mode == 1 {
        let period = 2 * size;
        let folded = ((i % period) + period) % period;
        return folded.min(period - 1 - folded);
    }
    ((i % size) + size) % size
}

fn texel_at<R: Real>(texture: &Texture, texels: &[u32], x: i32, y: i32) -> Vec3<R> {
    let column = wrap(x, texture.width, texture.sampling & 3);
    let row = wrap(y, texture.height, (texture.sampling >> 2) & 3);
    let word = 2 * (texture.first as usize + (row * texture.width + column) as usize);
    let rg = texels[word];
    let b = texels[word + 1];
    let channel = |v: u32| R::from_i32(v as i32);
    Vec3::new(channel(rg & 0xffff), channel(rg >> 16), channel(b & 0xffff)) * R::from_f32(1.0 / 65535.0)
}

/// The linear colour of texture `index` at (u, v); v = 0 is the upper edge of the top row.
pub fn sample_texture<R: Real>(textures: &[Texture], texels: &[u32], index: u32, u: R, v: R) -> Vec3<R> {
    let texture = &textures[index as usize];
    let (lowest, highest) = (R::from_f32(-1e9), R::from_f32(1e9));
    let x = (u * R::from_i32(texture.width)).max(lowest).min(highest);
    let y = (v * R::from_i32(texture.height)).max(lowest).min(highest);
    if texture.sampling & 16 == 0 {
        return texel_at(texture, texels, x.floor().to_i32(), y.floor().to_i32());
    }
    let half = R::from_f32(0.5);
    let left = (x - half).floor();
    let top = (y - half).floor();
    let fx = x - half - left;
    let fy = y - half - top;
    let i = left.to_i32();
    let j = top.to_i32();
    let one = R::one();
    let at = |x, y| texel_at::<R>(texture, texels, x, y);
    let upper = at(i, j) * (one - fx) + at(i + 1, j) * fx;
    let lower = at(i, j + 1) * (one - fx) + at(i + 1, j + 1) * fx;
    upper * (one - fy) + lower * fy
}
