//! Options that go together.

use super::mapping::{Fragment, Mapping};
use super::rows::{ROWS, Refusal, Row};
use super::{Choices, ScheduleKind};

impl Choices {
    /// The same without what does not go together: an option that a row refuses has its usual value instead, but for the
    /// one that was chosen last.
    #[must_use]
    pub fn settled(mut self, chosen: Option<&Row>) -> Self {
        let mut usual = Self::stepped();
        if self.mapping != Mapping::Compute {
            (usual.mapping, usual.schedule) = (Mapping::Fragment(Fragment::default()), ScheduleKind::Second);
        }
        for row in ROWS.iter().filter(|row| chosen.is_none_or(|chosen| chosen.name != row.name)) {
            if let Some(Refusal::Impossible(_)) = (row.refused)(&self) {
                // A row has its usual value.
                _ = row.set(&mut self, &row.get(&usual).to_string());
            }
        }
        self
    }
}
