//! Which rays of a pass took a branch, or stop at a line: a mask over the image.

use egui::Color32;
use raystep_kernels::interpret::Outcomes;
use raystep_kernels::named;
use raystep_lab::divergence::Fate;
use raystep_lab::human::grouped;
use raystep_lab::stops::StoppedPass;
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

    /// What it is called where elements stop at a line, and what it means there.
    fn of_stop(self) -> [&'static str; 2] {
        match self {
            Self::Taken => ["stops", "the condition held for these elements, at least once"],
            Self::NotTaken => ["comes to the line", "these elements come to the line, but the condition never held"],
            _ => ["not reached", "these elements do not come to the line"],
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

/// A condition in a pass, or a stop at a line, for all rays.
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
    /// Of the rays that f64 decides otherwise: how many take another path after the pass in f64, with the same hit, and
    /// how many have another hit; if that is known.
    pub in_f64: Option<[u64; 2]>,
    /// Whether it is about a stop.
    pub is_stop: bool,
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
        Self { generation, place, what, size, processed, taken, counts, rays, in_f64: None, is_stop: false }
    }

    /// The mask of the elements that stop at a line.
    #[must_use]
    pub fn of_stop((generation, place): (u64, usize), what: String, found: &StoppedPass) -> Self {
        let mut rays = vec![Outcome::Waiting; found.size.texels() as usize];
        for (element, stopped) in &found.elements {
            if let Some(ray) = rays.get_mut(*element) {
                *ray = if stopped.held > 0 { Outcome::Taken } else { Outcome::NotTaken };
            }
        }
        let size = [found.size.width, found.size.height];
        let (processed, taken) = (found.elements.len() as u64, found.held().count() as u64);
        let counts = [taken, processed - taken, 0, 0];
        Self { generation, what, place, size, rays, processed, taken, counts, in_f64: None, is_stop: true }
    }
}

impl Mask {
    /// With how each ray fares in f64 in this pass.
    #[must_use]
    pub fn with_fates(self, fates: Option<&[Fate]>) -> Self {
        let in_f64 = fates.map(|fates| {
            let differing = || self.rays.iter().zip(fates).filter(|(ray, _)| **ray == Outcome::Differs);
            [Fate::Path, Fate::Hit].map(|fate| differing().filter(|(_, of)| **of == fate).count() as u64)
        });
        Self { in_f64, ..self }
    }

    /// What an outcome is called, and what it means.
    #[must_use]
    pub fn words(&self, outcome: Outcome) -> [&'static str; 2] {
        if self.is_stop { outcome.of_stop() } else { [outcome.name(), outcome.meaning()] }
    }

    /// How many rays took the branch, whether f64 would, and whether that changes a hit.
    #[must_use]
    pub fn sentence(&self) -> String {
        if self.is_stop {
            let stop = counted(self.taken, "element");
            let verb = if self.taken == 1 { "stops" } else { "stop" };
            return match self.processed - self.taken {
                0 => format!("{stop} {verb} at this line."),
                _ => format!("{stop} {verb} at this line, of {} that came to it.", grouped(self.processed)),
            };
        }
        let [.., differing, _] = self.counts;
        let taken = format!("{} of {} took this branch", grouped(self.taken), counted(self.processed, "ray"));
        if differing == 0 {
            return format!("{taken}; f64 would decide the same for all.");
        }
        let otherwise = format!("{taken}; f64 would decide otherwise for {}", grouped(differing));
        let rays = |count: u64| if count == 1 { "1 ray goes".into() } else { format!("{} rays go", grouped(count)) };
        match self.in_f64 {
            None => format!("{otherwise}."),
            Some([0, 0]) => format!("{otherwise}: no hit changes."),
            Some([others, 0]) => {
                format!("{otherwise}: no hit changes in this pass, but {} on to another test or cell.", rays(others))
            }
            Some([_, 1]) => format!("{otherwise}: 1 hit changes."),
            Some([_, hits]) => format!("{otherwise}: {} hits change.", grouped(hits)),
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

    #[test]
    fn a_sentence_says_whether_a_hit_changes_where_that_is_known() {
        let differs = Some(Outcomes { reached: 1, taken: 1, differs: 1 });
        let same = Some(Outcomes { reached: 1, taken: 0, differs: 0 });
        let of = |rays: &[Option<Outcomes>], fates: Option<&[Fate]>| {
            let mask = Mask::new((1, 0), String::new(), [rays.len() as u32, 1], rays, 0).with_fates(fates);
            mask.sentence().split("branch; ").nth(1).expect("a second part").to_owned()
        };
        use Fate::{Hit, Path, Same};
        let rays = [differs, differs, same, None];
        for (fates, told) in [
            (None, "f64 would decide otherwise for 2."),
            (Some([Same; 4]), "f64 would decide otherwise for 2: no hit changes."),
            // Rays that this branch does not concern.
            (Some([Same, Same, Hit, Path]), "f64 would decide otherwise for 2: no hit changes."),
            (
                Some([Path, Same, Same, Same]),
                "f64 would decide otherwise for 2: no hit changes in this pass, but 1 ray goes on to another test or cell.",
            ),
            (Some([Path, Hit, Same, Same]), "f64 would decide otherwise for 2: 1 hit changes."),
            (Some([Hit, Hit, Hit, Same]), "f64 would decide otherwise for 2: 2 hits change."),
        ] {
            assert_eq!(of(&rays, fates.as_ref().map(|fates| &fates[..])), told, "{fates:?}");
        }
        assert_eq!(of(&[same], Some(&[Same])), "f64 would decide the same for all.");
        assert_eq!(of(&[], None), "f64 would decide the same for all.");
        let one = Mask::new((1, 0), String::new(), [1, 1], &[differs], 0);
        assert!(one.sentence().starts_with("1 of 1 ray took this branch"), "{}", one.sentence());
    }
}
