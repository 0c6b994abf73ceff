//! How much of each kernel a comparison with its CPU reference has covered.

use std::collections::BTreeMap;
use std::ops::AddAssign;

use raystep_kernels::Kernel;

/// What was compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sums {
    /// Passes.
    pub passes: usize,
    /// Components after these passes.
    pub components: u64,
    /// Components that differ by no more than rounding may change.
    pub tolerated: u64,
    /// Rays that took another path because f32 cannot decide.
    pub undecided: u64,
    /// Rays that the passes worked on, summed.
    pub rays: u64,
    /// Those of them in passes whose walks, searches or sums of light may continue in the next dispatch.
    pub rays_in_parts: u64,
}

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.passes += other.passes;
        self.components += other.components;
        self.tolerated += other.tolerated;
        self.undecided += other.undecided;
        self.rays += other.rays;
        self.rays_in_parts += other.rays_in_parts;
    }
}

/// The same, by kernel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compared(BTreeMap<Kernel, Sums>);

impl Compared {
    /// Adds what was compared of a kernel.
    pub fn add(&mut self, kernel: Kernel, sums: Sums) {
        *self.0.entry(kernel).or_default() += sums;
    }

    /// Adds all of another comparison.
    pub fn merge(&mut self, other: &Self) {
        other.iter().for_each(|(kernel, sums)| self.add(kernel, sums));
    }

    /// What was compared of a kernel.
    #[must_use]
    pub fn of(&self, kernel: Kernel) -> Sums {
        self.0.get(&kernel).copied().unwrap_or_default()
    }

    /// Every kernel that was compared.
    pub fn iter(&self) -> impl Iterator<Item = (Kernel, Sums)> {
        self.0.iter().map(|(&kernel, &sums)| (kernel, sums))
    }

    /// The sums over all kernels.
    #[must_use]
    pub fn total(&self) -> Sums {
        let mut total = Sums::default();
        self.iter().for_each(|(_, sums)| total += sums);
        total
    }
}
