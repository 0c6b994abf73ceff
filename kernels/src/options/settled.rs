//! Options that go together.

use super::mapping::{Fragment, Mapping, fault_of};
use super::rows::{ROWS, Refusal, Row};
use super::scene_data::SceneDataKind;
use super::{Accelerator, Choices, ScheduleKind};

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

    /// Whether they go together.
    #[must_use]
    pub fn go_together(&self) -> bool {
        ROWS.iter().all(|row| !matches!((row.refused)(self), Some(Refusal::Impossible(_))))
    }

    /// The same for a device that only draws, where options that were not given are what it can do: fragment programs,
    /// with lists in textures.
    #[must_use]
    pub fn drawn(mut self, is_given: impl Fn(&str) -> bool) -> Self {
        if self.mapping == Mapping::Compute && !is_given("mapping") {
            self.mapping = Mapping::Fragment(Fragment::default());
        }
        if !is_given("scene-data") {
            self.scene_data = SceneDataKind::Textures;
        }
        if self.mapping != Mapping::Compute && fault_of(self.schedule).is_some() && !is_given("schedule") {
            self.schedule = ScheduleKind::Second;
            // With a schedule of several passes, the grid is usual.
            if self.accelerator == Accelerator::Auto && !is_given("accelerator") {
                self.accelerator = Accelerator::Grid;
            }
        }
        self
    }

    /// The same for the CPU, which draws nothing.
    #[must_use]
    pub fn computed(self) -> Self {
        Self { mapping: Mapping::Compute, scene_data: SceneDataKind::Buffers, ..self }
    }
}
