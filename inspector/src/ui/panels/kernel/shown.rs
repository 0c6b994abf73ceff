//! Which kernel's lines are displayed, for which element and pass.

use std::sync::Arc;

use raystep_kernels::Kernel;
use raystep_kernels::export::trace::Trace;

/// Key of the displayed lines.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) generation: u64,
    pub(super) edition: u64,
    pub(super) kernel: Kernel,
    /// The ray's history, and the current row.
    pub(super) row: Option<(Arc<Trace>, usize)>,
    /// The selected element and the last pass, in a program whose elements have no history.
    pub(super) element: Option<([u32; 2], usize)>,
    pub(super) composed: bool,
    /// The function to mark.
    pub(super) code: Option<String>,
}

impl Shown {
    /// The pass that is looked at.
    pub(super) fn pass(&self) -> Option<usize> {
        match &self.row {
            Some((history, row)) => history.rows.get(*row)?.pass,
            None => self.element.map(|(_, pass)| pass),
        }
    }
}

impl PartialEq for Shown {
    fn eq(&self, other: &Self) -> bool {
        let same_row = match (&self.row, &other.row) {
            (Some((a, i)), Some((b, j))) => Arc::ptr_eq(a, b) && i == j,
            (a, b) => a.is_none() && b.is_none(),
        };
        let key = |shown: &Self| (shown.generation, shown.edition, shown.kernel, shown.element, shown.composed);
        same_row && key(self) == key(other) && self.code == other.code
    }
}
