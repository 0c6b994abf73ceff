//! Sets of elements, for which streams have texels: rays, cells, triangles, …

use std::fmt;

use crate::shared::constants::WORKGROUP;

/// A set of elements.
#[derive(PartialEq, Eq)]
pub struct Elements {
    /// Its name, in the plural.
    pub name: &'static str,
    /// Its size.
    pub count: Count,
}

/// The size of a set of elements, and their layout in their streams' textures.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// The pixels of the run's image: pixel (x, y) is texel (x, y).
    Image,
    /// A number given before the first pass; the rows of the texture are filled one after the other.
    Given,
    /// A number found on the device: a kernel stores it in the first texel of this stream. Until then the set has no
    /// streams. If an instance of a kernel [renews](crate::program::Instance::renews) the set, its number is read again.
    Found {
        /// Name of the stream.
        in_stream: &'static str,
        /// Layer of the stream.
        layer: usize,
    },
    /// `each` elements for every block of `per` elements of another set; the last block may have fewer. For example,
    /// totals of blocks.
    Per {
        /// Name of the other set.
        of: &'static str,
        /// Elements of the other set.
        per: u32,
        /// Elements of this set.
        each: u32,
    },
}

/// The number of elements of a set in a run, and the size of the texture with a texel for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Number of elements; fewer than texels if they do not fill the last row.
    pub count: u32,
}

/// Texels per row for this many elements: about as many as there are rows, in whole workgroups.
#[must_use]
pub fn folded_width(count: u64) -> u64 {
    if count < 64 { count.max(1) } else { count.isqrt().next_multiple_of(8) }
}

/// The texel of ray `index` of `count` if each workgroup's tile of an image of this width has consecutive rays; the
/// remainder that fills no row of tiles stays in order. Consecutive rays are often alike, and threads of a workgroup
/// wait for each other: a camera's rays in such an order take 0.6 to 0.8 of the time on an H200.
#[must_use]
pub fn tiled(index: usize, width: usize, count: usize) -> usize {
    const SIDE: usize = WORKGROUP as usize;
    let in_tiles = count / (width * SIDE).max(1) * width * SIDE;
    if !width.is_multiple_of(SIDE) || index >= in_tiles {
        return index;
    }
    let (tile, within) = (index / (SIDE * SIDE), index % (SIDE * SIDE));
    let (column, row) = (tile % (width / SIDE), tile / (width / SIDE));
    (row * SIDE + within / SIDE) * width + column * SIDE + within % SIDE
}

impl Size {
    /// The size for this many elements, stored row by row in a nearly square texture whose width is a power of two, by
    /// which kernels divide fast; `None` if a side would be longer than `side`. Without elements, the texture has one texel.
    #[must_use]
    pub fn folded(count: u64, side: u32) -> Option<Self> {
        let widest = 1 << u64::from(side).max(1).ilog2();
        let width = folded_width(count).next_power_of_two().min(widest);
        let height = count.div_ceil(width).max(1);
        let fits = height <= u64::from(side) && count <= u64::from(u32::MAX);
        fits.then_some(Self { width: width as u32, height: height as u32, count: count as u32 })
    }

    /// Number of texels.
    #[must_use]
    pub fn texels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

impl fmt::Debug for Elements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::tiled;

    #[test]
    fn every_ray_has_a_texel_of_its_own_and_a_tile_has_consecutive_rays() {
        for (width, count) in [(1, 1), (7, 49), (8, 63), (8, 64), (24, 500), (32, 1000), (64, 4096)] {
            let mut texels: Vec<_> = (0..count).map(|ray| tiled(ray, width, count)).collect();
            for (ray, texel) in texels.iter().enumerate() {
                let (x, y) = (texel % width, texel / width);
                let tile = y / 8 * (width / 8) + x / 8;
                assert!(ray / 64 == tile || *texel == ray, "ray {ray} of {count} in rows of {width}: {x},{y}");
            }
            texels.sort_unstable();
            assert!(texels.iter().copied().eq(0..count), "{count} in rows of {width}");
        }
        assert_eq!([7, 8, 64].map(|ray| tiled(ray, 32, 1000)), [7, 32, 8]);
    }
}
