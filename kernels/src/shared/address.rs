//! Twin of `address.wgsl`: lists in square textures, and what the paper's own form of this function does.

/// The WGSL of [`get_address`], for shaders whose lists are in textures.
pub(crate) const GET_ADDRESS: &str = include_str!("address.wgsl");

/// Column and row of the texel of entry `i` of a list, in a texture of `k` by `k` texels.
#[must_use]
pub fn get_address(i: u32, k: u32) -> [u32; 2] {
    [i % k, i / k]
}

/// Texels along each side of the texture of a list with so many entries: ⌈√n⌉, and one for an empty list.
#[must_use]
pub fn list_side(entries: u64) -> u64 {
    let floor = entries.isqrt();
    (floor + u64::from(floor * floor < entries)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How hardware divides floats.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Divide {
        /// Correctly rounded.
        Exact,
        /// By a product with the rounded reciprocal, as GPUs of 2004 did.
        ByReciprocal,
    }

    /// The paper's `float2(0.25+i%k, i/k)` in f32: a GPU of 2004 has no integers. Cg defines the modulus as
    /// `frac(i / k) * k`.
    fn as_written(i: u32, k: u32, added: f32, divide: Divide) -> [f32; 2] {
        let (i, k) = (i as f32, k as f32);
        let quotient = match divide {
            Divide::Exact => i / k,
            Divide::ByReciprocal => i * (1.0 / k),
        };
        [added + (quotient - quotient.floor()) * k, quotient]
    }

    /// The nearest texel: the one whose square holds the coordinates.
    fn nearest(coordinates: [f32; 2]) -> [u32; 2] {
        coordinates.map(|coordinate| coordinate as u32)
    }

    /// The entries of a texture of k by k texels for which another texel is read.
    fn missed(k: u32, added: f32, divide: Divide) -> impl Iterator<Item = u32> {
        (0..k * k).filter(move |&i| nearest(as_written(i, k, added, divide)) != get_address(i, k))
    }

    #[test]
    fn a_list_fills_the_smallest_square_that_holds_it() {
        for (entries, side) in [(0, 1), (1, 1), (2, 2), (4, 2), (5, 3), (9, 3), (10, 4), (u64::from(u32::MAX), 65_536)]
        {
            assert_eq!(list_side(entries), side, "{entries}");
        }
        for n in 1..3000 {
            let k = list_side(n);
            assert!(k * k >= n && (k - 1) * (k - 1) < n, "{n} entries, {k} texels");
        }
    }

    #[test]
    fn entries_follow_each_other_row_by_row() {
        assert_eq!([0, 1, 4, 5, 24].map(|i| get_address(i, 5)), [[0, 0], [1, 0], [4, 0], [0, 1], [4, 4]]);
    }

    /// The paper: "a result of 3.99999 when 4.0 is expected" gives the wrong texel.
    #[test]
    fn without_the_paper_s_quarter_an_entry_is_missed_at_3_99999() {
        let (i, k) = (284, 35);
        for divide in [Divide::Exact, Divide::ByReciprocal] {
            let bare = as_written(i, k, 0.0, divide);
            assert_eq!((format!("{:.5}", bare[0]), get_address(i, k)[0]), ("3.99999".into(), 4), "{divide:?}");
            assert_eq!(nearest(bare), [3, 8], "{divide:?}");
            assert_eq!(nearest(as_written(i, k, 0.25, divide)), [4, 8], "{divide:?}");
        }
    }

    /// Half a unit in the last place of a quotient in 2048..4096 is 2⁻¹³. Times k it reaches the quarter beyond k = 2048,
    /// and the first rounding that is bad enough comes at 2051: lists of 2050², or about 2²² entries, are read right.
    #[test]
    fn with_the_paper_s_quarter_and_exact_division_lists_of_four_million_entries_are_read_right() {
        for k in (1..=128).chain([255, 256, 257, 1000, 1023, 1024, 2047, 2048, 2049, 2050]) {
            assert_eq!(missed(k, 0.25, Divide::Exact).next(), None, "{k} texels a side");
        }
        assert_eq!(missed(2051, 0.25, Divide::Exact).collect::<Vec<_>>(), [4_200_619, 4_202_670, 4_204_721]);
        assert_eq!(missed(5, 0.0, Divide::Exact).count(), 8, "without the quarter, a list of 25 entries is misread");
    }

    /// Where k times the rounded 1/k is below 1, the first entry of a row is read in the row before: its quotient is at
    /// fault, to which the paper adds nothing.
    #[test]
    fn with_a_rounded_reciprocal_the_quarter_is_enough_up_to_40_texels_a_side() {
        for k in 1..=40 {
            assert_eq!(missed(k, 0.25, Divide::ByReciprocal).next(), None, "{k} texels a side");
        }
        assert_eq!(missed(41, 0.25, Divide::ByReciprocal).next(), Some(41));
        let [column, row] = as_written(41, 41, 0.25, Divide::ByReciprocal);
        assert!(row < 1.0 && nearest([column, row]) == [41, 0], "{column}, {row}");
        assert_eq!(missed(41, 0.25, Divide::Exact).next(), None);
    }
}
