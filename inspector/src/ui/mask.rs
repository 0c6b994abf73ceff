//! Which rays of a pass took a branch: a mask over the image.

use egui::Color32;
use raystep_kernels::interpret::Outcomes;
use raystep_kernels::named;
use raystep_lab::human::grouped;
use raystep_lab::text::counted;

/// How a condition came out for a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The pass did not work on the ray.
    Waiting,
    /// It did, but the ray did not reach the condition.
    Elsewhere,
    /// It was false, each time.
    NotTaken,
    /// It was true at least once.
    Taken,
    /// A comparison in it comes out differently in f64.
    Differs,
}

named!(
    Outcome,
    Waiting "not processed",
    Elsewhere "not reached",
    NotTaken "not taken",
    Taken "taken",
    Differs "f64 decides otherwise"
);

impl Outcome {
    /// All that are drawn, in the order of legends.
    pub const DRAWN: [Self; 4] = [Self::Taken, Self::NotTaken, Self::Differs, Self::Elsewhere];

    fn of(outcomes: Option<&Outcomes>, site: usize) -> Self {
        let Some(outcomes) = outcomes else { return Self::Waiting };
        let is = |bits: u128| bits.checked_shr(u32::try_from(site).unwrap_or(u32::MAX)).unwrap_or(0) & 1 == 1;
        match (is(outcomes.reached), is(outcomes.differs), is(outcomes.taken)) {
            (false, ..) => Self::Elsewhere,
            (_, true, _) => Self::Differs,
            (.., true) => Self::Taken,
            (.., false) => Self::NotTaken,
        }
    }

    /// What it means.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Waiting => "the pass did not work on these rays",
            Self::Elsewhere => "the pass worked on these rays, but they did not reach the condition",
            Self::NotTaken => "the condition was false for these rays, each time",
            Self::Taken => "the condition was true for these rays, at least once",
            Self::Differs => {
                "a comparison in the condition comes out differently in f64, from the same f32 inputs; control flow \
                 follows f32"
            }
        }
    }

    /// Its colour in legends, and its opacity over the picture: rays that the pass did not
    /// work on are darkened.
    fn shade(self) -> ([u8; 3], u8) {
        match self {
            Self::Waiting => ([0; 3], 130),
            Self::Elsewhere => ([128; 3], 235),
            Self::NotTaken => ([60, 90, 200], 235),
            Self::Taken => ([255, 225, 70], 235),
            Self::Differs => ([220, 60, 200], 255),
        }
    }

    /// Its colour in legends.
    #[must_use]
    pub fn color(self) -> Color32 {
        let [r, g, b] = self.shade().0;
        Color32::from_rgb(r, g, b)
    }

    /// Its colour over the picture.
    #[must_use]
    pub fn over_picture(self) -> Color32 {
        let ([r, g, b], opacity) = self.shade();
        Color32::from_rgba_unmultiplied(r, g, b, opacity)
    }
}

/// A condition in a pass, for all rays.
#[derive(Clone, Debug)]
pub struct Mask {
    /// The generation of its run.
    pub generation: u64,
    /// The pass, kernel and condition, for the legend.
    pub what: String,
    /// The place that it is about, as a number of passes.
    pub place: usize,
    /// Columns and rows.
    pub size: [u32; 2],
    /// By ray.
    pub rays: Vec<Outcome>,
    /// Rays that the pass processed.
    pub processed: u64,
    /// Rays for which the condition was true at least once.
    pub taken: u64,
    /// Rays with each outcome, in the order of [`Outcome::DRAWN`].
    pub counts: [u64; 4],
}

impl Mask {
    /// The mask of one condition.
    #[must_use]
    pub fn new(
        (generation, place): (u64, usize),
        what: String,
        size: [u32; 2],
        outcomes: &[Option<Outcomes>],
        site: usize,
    ) -> Self {
        let rays: Vec<Outcome> = outcomes.iter().map(|outcomes| Outcome::of(outcomes.as_ref(), site)).collect();
        let is_taken = |outcomes: &&Outcomes| {
            outcomes.taken.checked_shr(u32::try_from(site).unwrap_or(u32::MAX)).unwrap_or(0) & 1 == 1
        };
        let processed = outcomes.iter().flatten().count() as u64;
        let taken = outcomes.iter().flatten().filter(is_taken).count() as u64;
        let count = |outcome: Outcome| rays.iter().filter(|ray| **ray == outcome).count() as u64;
        let counts = Outcome::DRAWN.map(count);
        Self { generation, place, what, size, processed, taken, counts, rays }
    }
}

impl Mask {
    /// How many rays took the branch, and whether f64 would.
    #[must_use]
    pub fn sentence(&self) -> String {
        let [.., differing, _] = self.counts;
        let taken = format!("{} of {} took this branch", grouped(self.taken), counted(self.processed, "ray"));
        match differing {
            0 => format!("{taken}; f64 would decide the same for all."),
            _ => format!(
                "{taken}; f64 would decide otherwise for {}. A hit changes only where the panel Divergence reports precision.",
                grouped(differing)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_is_counted_as_what_it_did_at_this_condition() {
        let rays = [
            None,
            Some(Outcomes::default()),
            Some(Outcomes { reached: 0b100, taken: 0b011, differs: 0 }),
            Some(Outcomes { reached: 0b100, taken: 0b100, differs: 0 }),
            Some(Outcomes { reached: 0b100, taken: 0b100, differs: 0b100 }),
        ];
        let mask = Mask::new((1, 0), String::new(), [5, 1], &rays, 2);
        use Outcome::{Differs, Elsewhere, NotTaken, Taken, Waiting};
        assert_eq!(mask.rays, [Waiting, Elsewhere, NotTaken, Taken, Differs]);
        assert_eq!((mask.processed, mask.taken, mask.counts), (4, 2, [1; 4]));
        assert_eq!(Mask::new((1, 0), String::new(), [5, 1], &rays, 500).taken, 0, "no such condition");
    }
}
