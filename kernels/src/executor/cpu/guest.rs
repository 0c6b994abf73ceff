//! Runs a twin on one element of a program: as the twin's own program has it, or as an instance has renamed it.

use std::borrow::Cow;

use crate::program::Kernel;
use crate::program::kernel::{ElementTwin, Precision};
use crate::scene_data::SceneData;
use crate::tables::state::Tag;
use crate::tables::stream::{STATE_TAG, Stream};
use crate::tables::texels::{Layout, Texels};

/// A twin of a kernel, for elements whose texels are laid out in some way.
pub(crate) struct OnElement<'a, R: Precision> {
    twin: ElementTwin<R>,
    /// The layout by the streams that the twin names.
    layout: Cow<'a, Layout>,
    /// Where the tag is, and pairs of a tag in the program and the one that the twin means, if they differ.
    renamed: Option<(usize, Vec<(Tag, Tag)>)>,
}

impl<'a, R: Precision> OnElement<'a, R> {
    /// For the layout of a set's streams in the kernel's program.
    pub(crate) fn new(kernel: Kernel, twin: ElementTwin<R>, layout: &'a Layout) -> Self {
        let renamed = kernel.instance().renamed.and_then(|renamed| {
            let tag = layout.first[kernel.course()?.stream.index()]? + STATE_TAG;
            Some((tag, renamed.tags.iter().map(|&(own, here)| (here, own)).collect()))
        });
        if kernel.is_at_home() {
            return Self { twin, layout: Cow::Borrowed(layout), renamed };
        }
        let table = kernel.info().home.streams;
        let mut own = Layout { table, stride: layout.stride, ..Layout::of(table, std::iter::empty()) };
        for info in table {
            own.first[info.index] = kernel.stream(Stream::of(info)).and_then(|bound| layout.first[bound.index()]);
        }
        Self { twin, layout: Cow::Owned(own), renamed }
    }

    /// Runs the twin on the element at this texel.
    pub(crate) fn run(&self, row: &mut [R::Bits], x: u32, y: u32, scene: &SceneData) {
        let Some((at, tags)) = &self.renamed else {
            return (self.twin)(&mut Texels::new(row, &self.layout, x, y), scene);
        };
        // The twin has no work for elements in states that it does not know.
        let Some((_, own)) = tags.iter().find(|(here, _)| *here == R::bits_to_u32(row[*at])) else { return };
        row[*at] = R::bits_from_u32(*own);
        (self.twin)(&mut Texels::new(row, &self.layout, x, y), scene);
        let left = R::bits_to_u32(row[*at]);
        if let Some((here, _)) = tags.iter().find(|(_, own)| *own == left) {
            row[*at] = R::bits_from_u32(*here);
        }
    }
}
