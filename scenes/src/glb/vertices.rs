//! A primitive's vertices: which of them are written, and how triangles index them.

use crate::Scene;

/// How many triangle corners to examine before giving up sharing.
const SAMPLE: usize = 3 << 17;

/// The triangles of one material.
///
/// A corner has the number 3·triangle + k. Bytes in the file, in this order: positions, normals, texture coordinates
/// and colours of all vertices (those that the scene has), then the indices, padded to 4.
pub(super) struct Primitive<'a> {
    triangles: &'a [u32],
    /// The first corner of each vertex, and for each corner of `triangles` its vertex. `None` if every corner is a
    /// separate vertex.
    shared: Option<(Vec<u32>, Vec<u32>)>,
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

/// The scene's vertex attributes besides the position: glTF name and floats per vertex.
pub(super) fn attributes(scene: &Scene) -> impl Iterator<Item = (&'static str, usize)> {
    [
        scene.normals.is_some().then_some(("NORMAL", 3)),
        scene.texcoords.is_some().then_some(("TEXCOORD_0", 2)),
        scene.colors.is_some().then_some(("COLOR_0", 3)),
    ]
    .into_iter()
    .flatten()
}

impl<'a> Primitive<'a> {
    /// `triangles` must not be empty.
    pub(super) fn new(scene: &Scene, triangles: &'a [u32]) -> Self {
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for corner in triangles.iter().flat_map(|&t| scene.triangles[t as usize]) {
            for axis in 0..3 {
                min[axis] = min[axis].min(corner[axis]);
                max[axis] = max[axis].max(corner[axis]);
            }
        }
        // An index costs 4 bytes (2 in small primitives); each vertex that is not repeated saves all of its bytes.
        let vertex_bytes = 4 * (3 + attributes(scene).map(|a| a.1).sum::<usize>());
        let worth = |vertices: usize, corners: usize| vertices * vertex_bytes + corners * 4 < corners * vertex_bytes;
        let sample = &triangles[..triangles.len().min(SAMPLE / 3)];
        let mut shared = Some(share(scene, sample)).filter(|s| worth(s.0.len(), s.1.len()));
        if shared.is_some() && sample.len() < triangles.len() {
            shared = Some(share(scene, triangles)).filter(|s| worth(s.0.len(), s.1.len()));
        }
        Self { triangles, shared, min, max }
    }

    /// Number of vertices to write.
    pub(super) fn vertices(&self) -> usize {
        self.shared.as_ref().map_or(self.triangles.len() * 3, |s| s.0.len())
    }

    /// Number of indices to write and bytes per index; `None` if vertices are not shared.
    pub(super) fn indices(&self) -> Option<(usize, usize)> {
        // glTF forbids the largest value of an index type, since it would restart a strip.
        self.shared.as_ref().map(|(vertices, of)| (of.len(), if vertices.len() <= 0xffff { 2 } else { 4 }))
    }

    /// Appends the bytes; see [`Primitive`] for their order.
    pub(super) fn write(&self, scene: &Scene, out: &mut Vec<u8>) {
        self.put(&scene.triangles, out);
        if let Some(normals) = &scene.normals {
            self.put(normals, out);
        }
        if let Some(texcoords) = &scene.texcoords {
            self.put(texcoords, out);
        }
        if let Some(colors) = &scene.colors {
            self.put(colors, out);
        }
        if let (Some((_, of)), Some((_, size))) = (&self.shared, self.indices()) {
            for index in of {
                out.extend(&index.to_le_bytes()[..size]);
            }
            out.resize(out.len().next_multiple_of(4), 0);
        }
    }

    fn put<const N: usize>(&self, values: &[[[f32; N]; 3]], out: &mut Vec<u8>) {
        let mut vertex = |v: &[f32; N]| v.iter().for_each(|f| out.extend(f.to_le_bytes()));
        match &self.shared {
            Some((first, _)) => first.iter().for_each(|&c| vertex(&values[c as usize / 3][c as usize % 3])),
            None => self.triangles.iter().flat_map(|&t| &values[t as usize]).for_each(vertex),
        }
    }
}

/// The first corner of each distinct vertex, and for each corner its vertex. Vertices are compared by bits: 0 and −0
/// differ, so that both are preserved.
fn share(scene: &Scene, triangles: &[u32]) -> (Vec<u32>, Vec<u32>) {
    const FREE: u32 = u32::MAX;
    let corners = triangles.len() * 3;
    // Open addressing, at most half full, in one allocation: std's map would store keys as well.
    let mask = (corners * 2).next_power_of_two() - 1;
    let mut table = vec![FREE; mask + 1];
    let (mut first, mut of) = (Vec::new(), Vec::with_capacity(corners));
    for corner in triangles.iter().flat_map(|&t| [3 * t, 3 * t + 1, 3 * t + 2]) {
        let words = words(scene, corner);
        let mut slot = hash(&words) as usize & mask;
        let vertex = loop {
            match table[slot] {
                FREE => {
                    table[slot] = first.len() as u32;
                    first.push(corner);
                    break table[slot];
                }
                v if self::words(scene, first[v as usize]) == words => break v,
                _ => slot = (slot + 1) & mask,
            }
        };
        of.push(vertex);
    }
    (first, of)
}

/// All the bits of a corner; 0 for attributes that the scene does not have.
fn words(scene: &Scene, corner: u32) -> [u32; 11] {
    let (t, k) = (corner as usize / 3, corner as usize % 3);
    let [px, py, pz] = scene.triangles[t][k];
    let [nx, ny, nz] = scene.normals.as_ref().map_or([0.0; 3], |n| n[t][k]);
    let [u, v] = scene.texcoords.as_ref().map_or([0.0; 2], |c| c[t][k]);
    let [r, g, b] = scene.colors.as_ref().map_or([0.0; 3], |c| c[t][k]);
    [px, py, pz, nx, ny, nz, u, v, r, g, b].map(f32::to_bits)
}

/// Multiply and rotate over the words, then mix the high bits down (Steele, Lea and Flood 2014).
fn hash(words: &[u32]) -> u64 {
    let h = words.iter().fold(0u64, |h, &w| (h.rotate_left(23) ^ u64::from(w)).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h ^ (h >> 29)
}
