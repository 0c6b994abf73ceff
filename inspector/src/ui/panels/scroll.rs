//! Keeps a row of a table in view.

/// Passes of egui in which a table is scrolled: the first may be discarded, and the second finds the columns' widths.
const PASSES: u8 = 3;

/// Where a table was last scrolled to.
#[derive(Default)]
pub(super) struct Scroll {
    at: Option<usize>,
    left: u8,
}

impl Scroll {
    /// The row to scroll to now: none once it is there, so that the user can scroll away.
    pub(super) fn to(&mut self, ui: &egui::Ui, at: Option<usize>) -> Option<usize> {
        if self.at != at {
            (self.at, self.left) = (at, PASSES);
        }
        self.left = self.left.checked_sub(1)?;
        ui.ctx().request_repaint();
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_scrolled_to_when_it_changes_and_then_left_alone() {
        let mut scroll = Scroll::default();
        let mut asked = Vec::new();
        for row in [Some(4), Some(4), Some(4), Some(4), Some(9), None, None] {
            egui::__run_test_ui(|ui| asked.push(scroll.to(ui, row)));
        }
        asked.dedup();
        assert_eq!(asked, [Some(4), None, Some(9), None]);
    }
}
