//! What a program's streams have a texel for: rays, cells, triangles, …

use std::fmt;

/// A set of elements.
#[derive(PartialEq, Eq)]
pub struct Elements {
    /// Its name, in the plural.
    pub name: &'static str,
    /// How many there are.
    pub count: Count,
}

/// How many elements a set has, and how they lie in their streams' textures.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// Those of the run's image: pixel (x, y) is texel (x, y).
    Image,
    /// As many as the run is told before its first pass: the rows are filled one after the other.
    Given,
    /// As many as the device has found: what one kernel has left in the first texel of this stream. The set has no
    /// streams until then.
    Found {
        /// Name of the stream.
        in_stream: &'static str,
    },
    /// So many for each `per` elements of another set, the last of which may be fewer: totals of blocks, for example.
    Per {
        /// Name of the other set.
        of: &'static str,
        /// Elements of that set.
        per: u32,
        /// Elements of this one.
        each: u32,
    },
}

/// How many elements a set has in a run, and the texture that has a texel for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Elements; fewer than texels where they do not fill the last row.
    pub count: u32,
}

/// Texels a row for so many elements: about as many as rows, in whole workgroups.
#[must_use]
pub fn folded_width(count: u64) -> u64 {
    if count < 64 { count.max(1) } else { count.isqrt().next_multiple_of(8) }
}

impl Size {
    /// So many elements, row after row, about as many rows as texels a row; `None` where a side would be longer than
    /// `side`. No elements have a texture of one texel.
    #[must_use]
    pub fn folded(count: u64, side: u32) -> Option<Self> {
        let width = folded_width(count).min(u64::from(side).max(1));
        let height = count.div_ceil(width).max(1);
        let fits = height <= u64::from(side) && count <= u64::from(u32::MAX);
        fits.then_some(Self { width: width as u32, height: height as u32, count: count as u32 })
    }

    /// Texels.
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
