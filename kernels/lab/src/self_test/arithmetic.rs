//! Operations on the device, judged against exact values.

use std::collections::BTreeMap;

use super::operations::{
    COMPARED, CONTRACTION, CONVERSIONS, DIVISION, DOT, EXACT, FMA, INTEGERS, Judge, NOT_FINITE, ORDER, Operation, ROOT,
    SIMPLIFIED, SUBNORMALS, SUMS, all,
};
use super::probe::{self, Inputs, VALUES, floats};
use super::storage;
use super::{Bench, Check, Finding, Found, Group, Step, Verdict};
use crate::rays::Random;

/// Checks of operations, what they show, and whether that is a property of the driver with which raystep works.
const CHECKS: [(&str, &str, Verdict); 14] = [
    (SUMS, "sums, differences and products are rounded to nearest", Verdict::Right),
    (COMPARED, "products are rounded before they are compared, which keeps meshes watertight", Verdict::Right),
    (ORDER, "sums and products are computed in the order in which they are written", Verdict::Right),
    (DIVISION, "quotients are as accurate as the kernels' bounds assume", Verdict::Right),
    (ROOT, "square roots are as accurate as WGSL says", Verdict::Right),
    (DOT, "dot products have no more error than three roundings a product", Verdict::Right),
    (EXACT, "functions and comparisons of floats that need no rounding are exact", Verdict::Right),
    (CONVERSIONS, "numbers are converted as WGSL says, also those out of range", Verdict::Right),
    (INTEGERS, "operations on integers are exact, modulo 2^32", Verdict::Right),
    (CONTRACTION, "whether a product that is added to something is rounded first", Verdict::Information),
    (FMA, "whether fma rounds once", Verdict::Information),
    (SIMPLIFIED, "whether sums are simplified: a + b - a to b, a * d + b * d to (a + b) * d", Verdict::Information),
    (SUBNORMALS, "whether floats below 2^-126 are kept or taken for 0", Verdict::Information),
    (NOT_FINITE, "whether comparisons treat NaN and infinity as IEEE 754 says", Verdict::Information),
];

pub(super) fn checks() -> Vec<Check> {
    let of_operations = CHECKS.map(|(name, shows, _)| Check { group: Group::Arithmetic, name, shows });
    [&of_operations[..], &storage::checks()].concat()
}

pub(super) fn steps() -> Vec<Step> {
    let names = CHECKS.map(|(name, ..)| name);
    vec![Step::new(Group::Arithmetic, "operations", &names, operations), storage::step()]
}

/// Runs every operation.
fn operations(bench: &mut Bench) -> Found {
    let all = all();
    let inputs: Vec<Inputs> = all.iter().zip(1..).flat_map(|(operation, seed)| inputs_of(operation, seed)).collect();
    let source = (bench.faults.operations)(probe::source());
    let results = bench.machine.wait(probe::run(&bench.gpu, source, &inputs))?;
    let of_each = inputs.chunks(VALUES as usize).zip(results.chunks(VALUES as usize));
    let mut tallies: BTreeMap<&str, Tally> = BTreeMap::new();
    for (operation, (inputs, results)) in all.iter().zip(of_each) {
        let tally = tallies.entry(operation.check).or_default();
        inputs.iter().zip(results).for_each(|(&inputs, &result)| tally.add(operation, inputs, result));
    }
    let finding = |(name, _, usual)| tallies.remove(name).map(|tally: Tally| tally.finding(name, usual));
    Ok((CHECKS.into_iter().filter_map(finding).collect(), Vec::new()))
}

fn inputs_of(operation: &Operation, seed: u32) -> impl Iterator<Item = Inputs> {
    let random = move |i| {
        let mut random = Random::of(i, seed);
        [(); 4].map(|()| random.bits())
    };
    (0..VALUES).map(random).map(operation.inputs)
}

/// All results of the operations of a check.
#[derive(Default)]
struct Tally {
    values: u64,
    /// Largest error, and what is allowed, in units in the last place.
    worst: Option<[f64; 2]>,
    /// Results that have a name, by operation.
    named: BTreeMap<&'static str, BTreeMap<&'static str, u64>>,
    wrong: Vec<String>,
}

/// Most wrong results that are shown of a check.
const MOST_SHOWN: usize = 20;

impl Tally {
    fn add(&mut self, operation: &Operation, inputs: Inputs, result: u32) {
        self.values += 1;
        let float = f32::from_bits(result);
        let mistake = |wanted: String| {
            Some(format!("{} = {}, not {wanted}", shown(operation, inputs), either(operation, result)))
        };
        let wrong = match operation.judge {
            Judge::Bits(exact) if exact(inputs) == result => None,
            Judge::Bits(exact) => mistake(either(operation, exact(inputs))),
            Judge::Float(exact) if exact(inputs) == float => None,
            Judge::Float(exact) => mistake(format!("{:e}", exact(inputs))),
            Judge::Ulps(most, exact) => {
                let off = ulps(f64::from(float), exact(inputs));
                let worst = self.worst.map_or(0.0, |[worst, _]| worst).max(off);
                self.worst = Some([worst, most]);
                // A tie is exactly half a unit off.
                let wanted = || format!("{:e}: off by {off:.2} ulp, of {most} allowed", exact(inputs));
                if off <= most { None } else { mistake(wanted()) }
            }
            Judge::Near(exact) => {
                let [exact, most] = exact(inputs);
                let wanted = || format!("{exact:e} by up to {most:e}");
                if (f64::from(float) - exact).abs() <= most { None } else { mistake(wanted()) }
            }
            Judge::OneOf(all) => self.name(expression(operation), all(inputs), result).and_then(mistake),
        };
        self.wrong.extend(wrong.filter(|_| self.wrong.len() < MOST_SHOWN));
    }

    /// Counts a result under its name, unless it has two. Returns what it should have been if it has none.
    fn name(&mut self, operation: &'static str, all: Vec<(&'static str, u32)>, result: u32) -> Option<String> {
        // Bits of a NaN are free.
        let is = |bits: u32| bits == result || f32::from_bits(bits).is_nan() && f32::from_bits(result).is_nan();
        let mut names: Vec<&str> = all.iter().filter(|(_, bits)| is(*bits)).map(|(name, _)| *name).collect();
        names.dedup();
        match names[..] {
            [] => {
                let wanted: Vec<String> =
                    all.iter().map(|(name, bits)| format!("{:e} ({name})", f32::from_bits(*bits))).collect();
                return Some(wanted.join(" or "));
            }
            [name] => *self.named.entry(operation).or_default().entry(name).or_default() += 1,
            _ => {}
        }
        None
    }

    /// What results were, by their names: of all operations, or of each.
    fn says(&self) -> String {
        let of_one = |names: &BTreeMap<&'static str, u64>| match names.len() {
            1 => names.keys().map(|name| (*name).to_owned()).collect(),
            _ => names.iter().map(|(name, count)| format!("{name} {count} times")).collect::<Vec<_>>().join(", "),
        };
        let mut all: Vec<String> = self.named.values().map(of_one).collect();
        all.dedup();
        match &all[..] {
            [] => String::new(),
            [always] => format!("always {always}"),
            _ => self
                .named
                .iter()
                .map(|(wgsl, names)| format!("{wgsl}: {}", of_one(names)))
                .collect::<Vec<_>>()
                .join("; "),
        }
    }

    fn finding(self, name: &str, usual: Verdict) -> Finding {
        let mut says = self.says();
        if let Some([worst, most]) = self.worst {
            says = format!("off by up to {worst:.2} ulp, of {most} allowed");
        }
        Finding::new(Group::Arithmetic, name, usual, says).counting(&[("values", self.values)]).wrong_by(self.wrong)
    }
}

/// Distance from an exact number in units in its last place, as an f32.
fn ulps(value: f64, exact: f64) -> f64 {
    if value == exact {
        return 0.0;
    }
    if exact == 0.0 || !value.is_finite() {
        return f64::INFINITY;
    }
    // Exact: the exponent of a normal f64.
    let exponent = ((exact.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    (value - exact).abs() / f64::from(exponent.max(-126) - 23).exp2()
}

/// A result as it is read: a float, or an integer.
fn either(operation: &Operation, bits: u32) -> String {
    if is_float(operation) { format!("{:e}", f32::from_bits(bits)) } else { bits.to_string() }
}

fn is_float(operation: &Operation) -> bool {
    operation.wgsl.starts_with("bitcast<u32>(") && operation.wgsl.ends_with(')')
}

/// An operation as it is shown, without its conversion to u32.
fn expression(operation: &Operation) -> &'static str {
    let inner = |prefix| operation.wgsl.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(')'));
    inner("bitcast<u32>(").or(inner("select(0u, 1u, ")).unwrap_or(operation.wgsl)
}

/// The operation and its inputs: "a / b of a 1e0, b 3e0".
fn shown(operation: &Operation, inputs: Inputs) -> String {
    let wgsl = expression(operation);
    let uses = |name: &str| operation.wgsl.split(|c: char| !c.is_alphanumeric()).any(|word| word == name);
    let [a, b, c, d] = floats(inputs);
    let of_floats = [("a", a), ("b", b), ("c", c), ("d", d)].into_iter().filter(|(name, _)| uses(name));
    let [x, y, z, w] = inputs;
    let of_bits = [("x", x), ("y", y), ("z", z), ("w", w)].into_iter().filter(|(name, _)| uses(name));
    let all = of_floats.map(|(name, v)| format!("{name} {v:e}")).chain(of_bits.map(|(name, v)| format!("{name} {v}")));
    format!("{wgsl} of {}", all.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the judge says of a result.
    fn judged(operation: &Operation, inputs: Inputs, result: u32) -> Tally {
        let mut tally = Tally::default();
        tally.add(operation, inputs, result);
        tally
    }

    /// A right result of an operation.
    fn right(operation: &Operation, inputs: Inputs) -> u32 {
        match operation.judge {
            Judge::Bits(exact) => exact(inputs),
            Judge::Float(exact) => exact(inputs).to_bits(),
            Judge::Ulps(_, exact) => (exact(inputs) as f32).to_bits(),
            Judge::Near(exact) => (exact(inputs)[0] as f32).to_bits(),
            Judge::OneOf(all) => all(inputs)[0].1,
        }
    }

    #[test]
    fn right_results_are_right_and_others_are_not() {
        for operation in all() {
            let mut refused = 0;
            for inputs in inputs_of(&operation, 1) {
                let result = right(&operation, inputs);
                let found = judged(&operation, inputs, result);
                assert_eq!(found.wrong, [""; 0], "{}", operation.wgsl);
                // Far from any rounding, and another integer.
                refused += usize::from(!judged(&operation, inputs, result ^ 0x0010_0001).wrong.is_empty());
            }
            // Of some inputs, NaNs and zeros of either sign are right.
            assert!(refused * 4 > VALUES as usize, "{}: {refused} wrong results were refused", operation.wgsl);
        }
    }

    #[test]
    fn results_are_right_up_to_their_bound() {
        let of = |check: &str| all().into_iter().find(|operation| operation.check == check).expect("an operation");
        let third = [1f32, 3.0, 0.0, 0.0].map(f32::to_bits);
        let nearest = (1f32 / 3.0).to_bits();
        // 1/3 rounded to nearest is a third of a unit above it.
        for (check, units, is_right) in [(DIVISION, 0, true), (DIVISION, 2, true), (DIVISION, 3, false)] {
            let found = judged(&of(check), third, nearest + units);
            assert_eq!(found.wrong.is_empty(), is_right, "{units}: {:?}", found.wrong);
        }
        let found = judged(&of(DIVISION), third, nearest + 3).finding(DIVISION, Verdict::Right);
        assert_eq!(found.verdict, Verdict::Wrong);
        assert!(found.says.starts_with("a / b of a 1e0, b 3e0 = 3.3333343e-1, not 3.3333"), "{}", found.says);
        // Sums have to be rounded to nearest: not down.
        let sum = [1f32, f32::EPSILON * 0.75, 0.0, 0.0].map(f32::to_bits);
        assert_eq!(judged(&of(SUMS), sum, 1f32.next_up().to_bits()).wrong, [""; 0]);
        assert!(!judged(&of(SUMS), sum, 1f32.to_bits()).wrong.is_empty());
    }

    #[test]
    fn what_a_driver_does_is_named_where_the_result_tells_it() {
        let product = all().into_iter().find(|operation| operation.check == CONTRACTION).expect("an operation");
        let (a, c) = (1.0 + 2f32.powi(-12), -1f32);
        let inputs = [a, a, c, 0.0].map(f32::to_bits);
        for (result, name) in [(a * a + c, "rounded twice"), (a.mul_add(a, c), "rounded once")] {
            let found = judged(&product, inputs, result.to_bits());
            assert_eq!(found.says(), format!("always {name}"));
        }
        let exact = judged(&product, [2f32, 3.0, 1.0, 0.0].map(f32::to_bits), 7f32.to_bits());
        assert!(exact.named.is_empty() && exact.wrong.is_empty(), "both are the same");
    }

    #[test]
    fn errors_are_in_units_of_the_exact_numbers_last_place() {
        for (value, exact, off) in
            [(1.0, 1.0, 0.0), (f64::from(1f32.next_up()), 1.0, 1.0), (2.0, 2.0 + 2f64.powi(-23), 0.5)]
        {
            assert_eq!(ulps(value, exact), off);
        }
        assert_eq!((ulps(1e-30, 0.0), ulps(f64::NAN, 1.0)), (f64::INFINITY, f64::INFINITY));
    }
}
