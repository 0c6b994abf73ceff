//! Which rays diverged, where, and what that means: arrays with one entry per ray, drawn over the image.

use raystep_kernels::executor::cpu::OutOfMemory;
use raystep_kernels::numbers::real::ulps;
use raystep_kernels::{Kernel, Plan, Program, Stream, named};

use crate::rounding::{Component, Judged, Verdict};
use crate::text::counted;

/// The pass of a ray that never diverged.
pub const NEVER: u32 = u32::MAX;

/// Bytes per ray for one class: pass, place, two values.
const BYTES: u64 = 4 + 2 + 8;

/// Maximum bytes of a map per ray.
pub(super) const MOST_BYTES_A_RAY: u64 = BYTES * Class::ALL.len() as u64;

/// What a divergence means; later classes are more serious.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// The device's floats differ from the twin's within the rounding bound; the ray takes the same path.
    Rounding,
    /// The ray takes another path than in the f32 twin, and f32 cannot decide which is right.
    Tie,
    /// f64 and f32 decide differently, beyond the bound on f32's errors.
    Precision,
    /// The device's floats differ by more than the rounding bound; the ray takes the same path.
    Excess,
    /// The device decides differently from the f32 twin although f32 can tell which is right.
    Decision,
}

named!(Class, Rounding "rounding", Tie "tie", Precision "precision", Excess "excess", Decision "decision");

impl Class {
    /// One sentence about it.
    #[must_use]
    pub fn summary(self) -> &'static str {
        match self {
            Self::Rounding => "floats differ within rounding",
            Self::Tie => "a different branch, which f32 cannot decide",
            Self::Precision => "f64 decides otherwise, beyond the error bound of f32",
            Self::Excess => "floats differ by more than rounding",
            Self::Decision => "the device decides otherwise than the CPU reference",
        }
    }
}

/// What the f32 twin differs from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Against {
    /// The device.
    Device,
    /// The f64 twin.
    F64,
}

/// The first divergence of a ray in a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parting {
    /// What it means.
    pub class: Class,
    /// After which pass.
    pub pass: usize,
    /// That pass's kernel.
    pub kernel: Kernel,
    /// What the f32 twin differs from.
    pub against: Against,
    /// The stream that differs; if several do, preferably one that determines the ray's path.
    pub stream: Stream,
    /// Its layer.
    pub layer: usize,
    /// The bits of [`against`](Self::against); f64 is rounded to f32.
    pub theirs: u32,
    /// The f32 twin's bits.
    pub twin: u32,
    /// Distance of floats in units in the last place; `None` for integers.
    pub ulps: Option<u64>,
}

/// The first divergence of each ray in one class.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Firsts {
    pass: Vec<u32>,
    place: Vec<u16>,
    values: Vec<[u32; 2]>,
    count: u64,
}

/// The result of comparing all passes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DivergenceMap {
    width: u32,
    height: u32,
    kernels: Vec<Kernel>,
    classes: [Option<Firsts>; Class::ALL.len()],
    refused: Option<OutOfMemory>,
    /// Whether kernels are a user's, and compared with those that they replace.
    has_replaced: bool,
}

/// Packs eight bits of stream, seven of layer, one of `against`.
fn place(stream: Stream, layer: usize, against: Against) -> u16 {
    ((stream.index() as u16) << 8) | ((layer as u16) << 1) | u16::from(against == Against::F64)
}

fn of_place(program: &'static Program, place: u16) -> Option<(Stream, usize, Against)> {
    let against = if place & 1 == 1 { Against::F64 } else { Against::Device };
    let stream = program.streams.get(usize::from(place >> 8)).map(Stream::of)?;
    Some((stream, usize::from(place >> 1 & 127), against))
}

impl Firsts {
    fn new(rays: usize) -> Result<Self, OutOfMemory> {
        fn filled<T: Clone>(rays: usize, value: T) -> Result<Vec<T>, OutOfMemory> {
            let mut all = Vec::new();
            let refused = OutOfMemory { bytes: (rays * size_of::<T>()) as u64 };
            all.try_reserve_exact(rays).map_err(|_| refused)?;
            all.resize(rays, value);
            Ok(all)
        }
        Ok(Self { pass: filled(rays, NEVER)?, place: filled(rays, 0)?, values: filled(rays, [0; 2])?, count: 0 })
    }
}

impl DivergenceMap {
    /// The map of a run before its first pass. A class takes memory once its first ray diverges.
    pub(super) fn new(plan: &Plan) -> Self {
        let (width, height) = (plan.width, plan.height);
        let has_replaced = plan.variants.iter().any(|variant| variant.replaced.is_some());
        Self { width, height, kernels: Vec::new(), classes: [const { None }; 5], refused: None, has_replaced }
    }

    /// Adds a pass, whose rays are recorded next.
    pub(super) fn begin(&mut self, kernel: Kernel) {
        self.kernels.push(kernel);
    }

    /// Records a ray that differs after this pass.
    pub(super) fn record(&mut self, against: Against, judged: &Judged<'_>) {
        let is_off = |c: &&Component| judged.verdict == Verdict::Rounding || !c.is_allowed;
        let is_integer = |c: &&Component| !c.stream.is_float_layer(c.layer);
        let decision = judged.components.iter().filter(is_off).find(is_integer);
        let Some(shown) = decision.or_else(|| judged.components.iter().find(is_off)) else { return };
        let class = match (judged.verdict, against) {
            (Verdict::Rounding, _) => Class::Rounding,
            (Verdict::Tie, _) => Class::Tie,
            (Verdict::Breach, Against::F64) => Class::Precision,
            (Verdict::Breach, Against::Device) if decision.is_none() => Class::Excess,
            (Verdict::Breach, Against::Device) => Class::Decision,
        };
        let rays = self.width as usize * self.height as usize;
        let slot = &mut self.classes[class as usize];
        if slot.is_none() {
            match Firsts::new(rays) {
                Ok(firsts) => *slot = Some(firsts),
                Err(refused) => self.refused = Some(refused),
            }
        }
        let Some(firsts) = slot else { return };
        if judged.ray < rays && firsts.pass[judged.ray] == NEVER {
            firsts.pass[judged.ray] = self.kernels.len().saturating_sub(1) as u32;
            firsts.place[judged.ray] = place(shown.stream, shown.layer, against);
            firsts.values[judged.ray] = [shown.ours, shown.twin];
            firsts.count += 1;
        }
    }

    /// What was found and whether it matters, in one sentence: of the gravest class.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Some(class) = Class::ALL.into_iter().rev().find(|&class| self.count(class) > 0) else {
            return "No ray differs from the CPU reference in any pass, and f32 and f64 agree.".into();
        };
        let rays = counted(self.count(class), "ray");
        match class {
            Class::Excess | Class::Decision if self.has_replaced => {
                format!("{rays} differ from what the built-in kernels do. Click one.")
            }
            Class::Rounding => {
                format!("{rays} differ in their last bits, within the rounding bound: every ray takes the same path.")
            }
            Class::Tie => format!(
                "{rays} tie: f32 cannot decide their branch, so either is right. Everything else is within the rounding \
                 bound."
            ),
            Class::Precision => {
                format!("f64 decides otherwise for {rays}, beyond the error bound of f32: their hits may be wrong.")
            }
            Class::Excess => {
                format!("{rays} differ by more than rounding explains: the device computes otherwise. Click one.")
            }
            Class::Decision => format!(
                "{rays} take another path than on the CPU reference, though f32 can tell which is right: an error of the \
                 device or its driver. Click one."
            ),
        }
    }

    /// Whether there was enough memory to record everything.
    pub(super) fn check_memory(&self) -> Result<(), OutOfMemory> {
        self.refused.map_or(Ok(()), Err)
    }

    /// Columns of the image.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of the image.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The kernel of every pass.
    #[must_use]
    pub fn kernels(&self) -> &[Kernel] {
        &self.kernels
    }

    /// How many rays diverged in this class.
    #[must_use]
    pub fn count(&self, class: Class) -> u64 {
        self.classes[class as usize].as_ref().map_or(0, |firsts| firsts.count)
    }

    /// How many rays diverged in each class, in the order of [`Class::ALL`].
    #[must_use]
    pub fn counts(&self) -> [u64; Class::ALL.len()] {
        Class::ALL.map(|class| self.count(class))
    }

    /// Each ray's first divergence in this class, row by row, [`NEVER`] if it has none; `None` if no ray has one.
    #[must_use]
    pub fn passes(&self, class: Class) -> Option<&[u32]> {
        self.classes[class as usize].as_ref().map(|firsts| firsts.pass.as_slice())
    }

    /// The rays (y * width + x) that diverged in this class.
    pub fn rays(&self, class: Class) -> impl Iterator<Item = usize> + '_ {
        let passes = self.passes(class).unwrap_or_default();
        passes.iter().enumerate().filter(|(_, pass)| **pass != NEVER).map(|(ray, _)| ray)
    }

    /// Where a ray first diverged in this class.
    #[must_use]
    pub fn first(&self, class: Class, ray: usize) -> Option<Parting> {
        let firsts = self.classes[class as usize].as_ref()?;
        let pass = *firsts.pass.get(ray).filter(|&&pass| pass != NEVER)? as usize;
        let kernel = *self.kernels.get(pass)?;
        let (stream, layer, against) = of_place(kernel.program(), firsts.place[ray])?;
        let [theirs, twin] = firsts.values[ray];
        let ulps = stream.is_float_layer(layer).then(|| ulps(theirs, twin));
        Some(Parting { class, pass, kernel, against, stream, layer, theirs, twin, ulps })
    }

    /// The first ray, and where, that differs by more than rounding explains: in the earliest pass, and there the first row.
    #[must_use]
    pub fn earliest(&self) -> Option<(usize, Parting)> {
        let wrong = [Class::Excess, Class::Decision].into_iter();
        let all = wrong.flat_map(|class| self.rays(class).filter_map(move |ray| Some((ray, self.first(class, ray)?))));
        all.min_by_key(|(ray, parting)| (parting.pass, *ray))
    }

    /// All classes in which a ray diverged, the earliest first.
    #[must_use]
    pub fn partings(&self, ray: usize) -> Vec<Parting> {
        let mut all: Vec<_> = Class::ALL.into_iter().filter_map(|class| self.first(class, ray)).collect();
        all.sort_by_key(|parting| parting.pass);
        all
    }

    /// The most serious class of a ray's divergences, which the map shows.
    #[must_use]
    pub fn class(&self, ray: usize) -> Option<Class> {
        let is_there = |class: &Class| self.passes(*class).is_some_and(|p| p.get(ray).is_some_and(|&p| p != NEVER));
        Class::ALL.into_iter().rev().find(is_there)
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::{PROGRAM, kernels, streams};
    use raystep_kernels::programs::path;

    use super::*;

    #[test]
    fn a_place_is_read_back_as_it_was_packed() {
        // Paths have more streams than rays, and streams of more layers.
        for program in [&PROGRAM, &*path::PROGRAM] {
            for stream in program.streams() {
                for layer in 0..stream.layers() {
                    for against in [Against::Device, Against::F64] {
                        assert_eq!(of_place(program, place(stream, layer, against)), Some((stream, layer, against)));
                    }
                }
            }
        }
    }

    #[test]
    fn the_first_parting_of_each_class_is_kept_and_the_gravest_shown() {
        let mut map = DivergenceMap {
            width: 3,
            height: 2,
            kernels: Vec::new(),
            classes: [const { None }; 5],
            refused: None,
            has_replaced: false,
        };
        let float =
            |ours, is_allowed| Component { stream: streams::STATE, layer: 1, ours, twin: 0x3f80_0000, is_allowed };
        let tag = Component { stream: streams::STATE, layer: 0, ours: 5, twin: 2, is_allowed: false };
        let mut pass = |kernel, ray, verdict, components: &[Component], against| {
            map.begin(kernel);
            map.record(against, &Judged { ray, verdict, components });
        };
        pass(kernels::GENERATE, 4, Verdict::Rounding, &[float(0x3f80_0003, true)], Against::Device);
        pass(kernels::SETUP, 4, Verdict::Tie, &[float(0x3f80_0001, true), tag], Against::F64);
        pass(kernels::INTERSECT, 4, Verdict::Breach, &[float(0x4000_0000, false)], Against::Device);
        pass(kernels::INTERSECT, 4, Verdict::Breach, &[float(0x4000_0000, false), tag], Against::Device);
        pass(kernels::INTERSECT, 4, Verdict::Rounding, &[float(0x3f80_0001, true)], Against::Device);
        pass(kernels::INTERSECT, 1, Verdict::Breach, &[tag], Against::F64);

        let seen: Vec<_> = map.partings(4).iter().map(|p| (p.class, p.pass, p.kernel, p.layer, p.ulps)).collect();
        let expected = [
            (Class::Rounding, 0, kernels::GENERATE, 1, Some(3)),
            (Class::Tie, 1, kernels::SETUP, 0, None),
            (Class::Excess, 2, kernels::INTERSECT, 1, Some(0x80_0000)),
            (Class::Decision, 3, kernels::INTERSECT, 0, None),
        ];
        assert_eq!(seen, expected);
        assert_eq!((map.class(4), map.class(1), map.class(0)), (Some(Class::Decision), Some(Class::Precision), None));
        assert_eq!((map.counts(), map.first(Class::Tie, 99)), ([1; 5], None));
        assert_eq!(map.rays(Class::Precision).collect::<Vec<_>>(), [1]);
        let parting = map.first(Class::Precision, 1).expect("recorded");
        assert_eq!((parting.theirs, parting.twin, parting.against), (5, 2, Against::F64));
    }
}
