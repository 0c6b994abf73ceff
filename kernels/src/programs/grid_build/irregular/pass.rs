//! What the twins of this folder share: streams by the names in the kernels' WGSL.

use crate::programs::primitives::scan::SCAN_BLOCK;
use crate::shared::build::Build;
use crate::tables::stream::Stream;
use crate::tables::texels::Columns;

/// A pass of a kernel over the streams of an executor. Elements that do not exist load as 0, and stores to them are
/// ignored, as on a device: somebody may have edited the streams.
pub(in crate::programs::grid_build) struct Pass<'a> {
    columns: &'a mut dyn Columns,
    pub(in crate::programs::grid_build) build: &'a Build,
}

/// A stream of a pass; `None` if the plan left it out.
#[derive(Clone, Copy)]
pub(in crate::programs::grid_build) struct View(Option<Stream>);

impl<'a> Pass<'a> {
    pub(in crate::programs::grid_build) fn new(columns: &'a mut dyn Columns, build: &'a Build) -> Self {
        Self { columns, build }
    }

    /// The stream bound to a name.
    pub(in crate::programs::grid_build) fn of(&self, name: &str) -> View {
        View(self.columns.stream(name))
    }

    /// Number of elements of a stream.
    pub(in crate::programs::grid_build) fn len(&self, view: View) -> u32 {
        view.0.map_or(0, |stream| self.columns.len(stream) as u32)
    }

    pub(in crate::programs::grid_build) fn get(&self, view: View, layer: usize, element: u32) -> u32 {
        view.0.map_or(0, |stream| self.columns.load(stream, layer, element as usize))
    }

    pub(in crate::programs::grid_build) fn set(&mut self, view: View, layer: usize, element: u32, value: u32) {
        if let Some(stream) = view.0 {
            self.columns.store(stream, layer, element as usize, value);
        }
    }

    /// Consecutive layers of an element, from the first.
    pub(in crate::programs::grid_build) fn all<const N: usize>(&self, view: View, element: u32) -> [u32; N] {
        std::array::from_fn(|layer| self.get(view, layer, element))
    }

    pub(in crate::programs::grid_build) fn set_all<const N: usize>(
        &mut self,
        view: View,
        element: u32,
        values: [u32; N],
    ) {
        for (layer, value) in values.into_iter().enumerate() {
            self.set(view, layer, element, value);
        }
    }

    /// The sum of the values before an element, of which a scan leaves those of its block and those of all blocks before.
    pub(in crate::programs::grid_build) fn sum_before(
        &self,
        values: View,
        sums: View,
        layer: usize,
        element: u32,
    ) -> u32 {
        self.get(sums, layer, element / SCAN_BLOCK as u32).saturating_add(self.get(values, layer, element))
    }

    /// Number of cells of the top level.
    pub(in crate::programs::grid_build) fn top_cells(&self) -> u32 {
        self.build.cells.iter().product()
    }
}

/// A leaf's box along an axis: the first virtual cell in the lower half of a word, the one after the last in the upper.
pub(in crate::programs::grid_build) fn low_of(extent: u32) -> u32 {
    extent & 0xffff
}

pub(in crate::programs::grid_build) fn high_of(extent: u32) -> u32 {
    extent >> 16
}

/// The references of which half of their leaf, by `ranks.wgsl`.
pub(in crate::programs::grid_build) struct Ranks {
    bits: View,
    tally: View,
}

impl Ranks {
    pub(in crate::programs::grid_build) fn new(pass: &Pass<'_>) -> Self {
        Self { bits: pass.of("bits"), tally: pass.of("tally") }
    }

    pub(in crate::programs::grid_build) fn has(&self, pass: &Pass<'_>, half: usize, reference: u32) -> bool {
        pass.get(self.bits, half, reference / 32) >> (reference % 32) & 1 != 0
    }

    /// Number of references before this one that lie in the half.
    pub(in crate::programs::grid_build) fn rank(&self, pass: &Pass<'_>, half: usize, reference: u32) -> u32 {
        let below = pass.get(self.bits, half, reference / 32) & ((1 << (reference % 32)) - 1);
        pass.get(self.tally, half, reference / 32).wrapping_add(below.count_ones())
    }

    /// Number of these references, one after the other, that lie in the half.
    pub(in crate::programs::grid_build) fn count(
        &self,
        pass: &Pass<'_>,
        half: usize,
        first: u32,
        references: u32,
    ) -> u32 {
        if references == 0 {
            return 0;
        }
        let last = first.wrapping_add(references).wrapping_sub(1);
        let end = self.rank(pass, half, last) + u32::from(self.has(pass, half, last));
        end.wrapping_sub(self.rank(pass, half, first))
    }

    /// Stores a bit for each reference and half, and the number of bits of each group.
    pub(in crate::programs::grid_build) fn store(
        &self,
        pass: &mut Pass<'_>,
        masks: impl Iterator<Item = u32>,
        halves: usize,
    ) {
        let masks: Vec<u32> = masks.collect();
        for (group, masks) in (0..).zip(masks.chunks(32)) {
            for half in 0..halves {
                let bits = (0..).zip(masks).fold(0, |bits, (k, mask)| bits | (mask >> half & 1) << k);
                pass.set(self.bits, half, group, bits);
                pass.set(self.tally, half, group, bits.count_ones());
            }
        }
    }
}
