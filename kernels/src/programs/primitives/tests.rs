//! Prefix sums of the CPU reference functions; a program of guests.

use std::borrow::Cow;
use std::ops::ControlFlow;

use super::add::add;
use super::radix::digits_of;
use super::scan::{SCAN_BLOCK, scan};
use super::*;
use crate::executor::cpu::agree;
use crate::options::{Accelerator, Options, RaySource};
use crate::plan::over::{Over, in_rows};
use crate::plan::{Limits, Plan, PlanError};
use crate::program::schedule::{Count as Counted, Schedule, Step};
use crate::program::{Instance, Kernel, Program};
#[cfg(feature = "gpu")]
use crate::programs::grid_build::device::tests::gpu;
use crate::renderer::{Device, RenderError, Renderer};
use crate::scene_data::{Contents, SceneData};
use crate::shared;
use crate::shared::launch::MOST_ELEMENTS;
use crate::tables::elements::Size;
use crate::tables::state::States;
use crate::tables::stream::{Meaning, StreamData, streams};

/// Prefix sums, level by level; returns the total.
pub(crate) fn prefix(values: &mut [u32]) -> u32 {
    let mut sums = vec![0; values.len().div_ceil(SCAN_BLOCK)];
    scan(values, &mut sums);
    if sums.len() < 2 {
        return sums.first().copied().unwrap_or(0);
    }
    let total = prefix(&mut sums);
    add(values, &sums);
    total
}

#[test]
fn sums_that_are_too_large_stay_at_the_largest_number() {
    // In a single block, and in several.
    let mut values = vec![1 << 30; 1000];
    assert_eq!(prefix(&mut vec![1 << 16; 9 * SCAN_BLOCK]), u32::MAX);
    assert_eq!(prefix(&mut values), u32::MAX);
    assert_eq!(values[3..6], [3 << 30, u32::MAX, u32::MAX]);
    assert_eq!(values[999], u32::MAX);
}

#[test]
fn as_many_digits_as_the_largest_key_has() {
    let wanted = [(0, 0), (1, 0), (2, 1), (16, 1), (17, 2), (256, 2), (257, 3), (1 << 28, 7)];
    assert_eq!(wanted.map(|(below, _)| (below, digits_of(below))), wanted);
}

static PAIRS: Elements = Elements { name: "pairs", count: Count::Given };
static PAIR_TALLIES: Elements = tallies("pair_tallies", "pairs");
static TALLY_BLOCKS: Elements = blocks("pair_tally_blocks", "pair_tallies");
static ALL_TALLIES: Elements = blocks("all_pair_tallies", "pair_tally_blocks");
static PAIR_BLOCKS: Elements = blocks("pair_blocks", "pairs");
static ALL_PAIRS: Elements = blocks("all_pairs", "pair_blocks");
static KEPT: Elements = Elements { name: "kept_pairs", count: Count::Found { in_stream: "kept_in_all", layer: 0 } };

/// Kernels find most of them by their names.
#[allow(dead_code, unreachable_pub)]
mod rows {
    use super::*;

    streams! {
        KEY of PAIRS: "key_here" U32 &["key"], meaning: &[Meaning::Count], unit: "", unwritten: &[0], why_absent: every;
        VALUE of PAIRS: "value_here" U32 &["value", "complement"], meaning: &[Meaning::Id; 2], unit: "", unwritten: &[0; 2],
            why_absent: every;
        KEY_THERE of PAIRS: "key_there" U32 &["key"], meaning: &[Meaning::Count], unit: "", unwritten: &[0], why_absent: every;
        VALUE_THERE of PAIRS: "value_there" U32 &["value", "complement"], meaning: &[Meaning::Id; 2], unit: "", unwritten: &[0; 2],
            why_absent: every;
        TALLY of PAIR_TALLIES: "digits" U32 &["n"], meaning: &[Meaning::Count], unit: "", unwritten: &[0], why_absent: every;
        TALLY_SUM of TALLY_BLOCKS: "digits_of_block" U32 &["n"], meaning: &[Meaning::Count], unit: "", unwritten: &[0],
            why_absent: every;
        TALLY_TOTAL of ALL_TALLIES: "digits_in_all" U32 &["n"], meaning: &[Meaning::Count], unit: "", unwritten: &[0],
            why_absent: every;
        WANTED of PAIRS: "wanted" U32 &["is"], meaning: &[Meaning::Count], unit: "", unwritten: &[0], why_absent: every;
        WANTED_SUM of PAIR_BLOCKS: "wanted_of_block" U32 &["n"], meaning: &[Meaning::Count], unit: "", unwritten: &[0],
            why_absent: every;
        WANTED_TOTAL of ALL_PAIRS: "kept_in_all" U32 &["n"], meaning: &[Meaning::Count], unit: "", unwritten: &[0],
            why_absent: every;
        KEPT_VALUE of KEPT: "kept_value" U32 &["value", "complement"], meaning: &[Meaning::Id; 2], unit: "", unwritten: &[0; 2], why_absent: every;
    }
}
use rows::{KEPT_VALUE, KEY, STREAMS, VALUE, WANTED};

const THERE: &[(&str, &str)] = &[
    ("key_in", "key_here"),
    ("value_in", "value_here"),
    ("tally", "digits"),
    ("key_out", "key_there"),
    ("value_out", "value_there"),
];
const BACK: &[(&str, &str)] = &[
    ("key_in", "key_there"),
    ("value_in", "value_there"),
    ("tally", "digits"),
    ("key_out", "key_here"),
    ("value_out", "value_here"),
];
const TALLIED: &[(&str, &str)] = &[("values", "digits"), ("sums", "digits_of_block")];
const ALL_TALLIED: &[(&str, &str)] = &[("values", "digits_of_block"), ("sums", "digits_in_all")];
const PLACED: &[(&str, &str)] = &[("values", "wanted"), ("sums", "wanted_of_block")];
const ALL_PLACED: &[(&str, &str)] = &[("values", "wanted_of_block"), ("sums", "kept_in_all")];

const fn guest(
    name: &'static str,
    kernel: KernelInfo,
    over: &'static Elements,
    binds: &'static [(&'static str, &'static str)],
) -> Instance {
    Instance { name, binds, ..Instance::of(kernel, over) }
}

static GUESTS: Program = Program {
    name: "pairs",
    summary: "pairs that are sorted, and compacted",
    elements: &[&PAIRS, &PAIR_TALLIES, &TALLY_BLOCKS, &ALL_TALLIES, &PAIR_BLOCKS, &ALL_PAIRS, &KEPT],
    streams: &STREAMS,
    states: States(&[]),
    courses: &[],
    rays: None,
    results: None,
    buffers: &[],
    lists: &[],
    kernels: &[
        guest("count_there", HISTOGRAM, &PAIRS, THERE),
        guest("count_back", HISTOGRAM, &PAIRS, BACK),
        guest("sum_digits", SCAN, &PAIR_TALLIES, TALLIED),
        guest("sum_blocks_of_digits", SCAN, &TALLY_BLOCKS, ALL_TALLIED),
        guest("add_digits", ADD, &PAIR_TALLIES, TALLIED),
        guest("move_there", SCATTER, &PAIRS, THERE),
        guest("move_back", SCATTER, &PAIRS, BACK),
        guest("sum_wanted", SCAN, &PAIRS, PLACED),
        guest("sum_blocks_of_wanted", SCAN, &PAIR_BLOCKS, ALL_PLACED),
        guest("add_wanted", ADD, &PAIRS, PLACED),
        guest(
            "keep",
            COMPACT,
            &PAIRS,
            &[("place", "wanted"), ("total", "kept_in_all"), ("value_in", "value_here"), ("value_out", "kept_value")],
        ),
    ],
    modules: |_| shared::MODULES.iter().chain(MODULES).map(|&(name, wgsl)| (name, Cow::Borrowed(wgsl))).collect(),
    files: &[],
};

/// Sorts by pairs of digits, there and back, and keeps what is wanted.
fn schedule(digit_pairs: u32) -> Schedule {
    let kernel = |index| Kernel::at(&GUESTS, index);
    let by = |index, first| Step::RunBy(kernel(index), Counted { first, by: &[2] });
    let run = |all: &[usize]| all.iter().map(|&index| Step::Run(kernel(index))).collect::<Vec<_>>();
    let sums = run(&[2, 3, 4]);
    let pass = |count, place, digit| [vec![by(count, digit)], sums.clone(), vec![by(place, digit)]].concat();
    let body = [pass(0, 5, 0), pass(1, 6, 1)].concat();
    let mut steps = vec![Step::Repeat("digit pair", Counted::always(digit_pairs), body)];
    steps.extend(run(&[7, 8, 9, 10]));
    Schedule { steps }
}

/// Keys and values, and whether a value is wanted, before the first pass.
fn inputs(count: usize, size: Size) -> [Vec<u32>; 3] {
    let mut random = fastrand::Rng::with_seed(count as u64);
    let texels = size.texels() as usize;
    let mut of = |most| {
        let mut all: Vec<u32> = (0..count).map(|_| random.u32(..most)).collect();
        all.resize(texels, 0);
        all
    };
    // Few keys, so that many are equal: the sort keeps their order.
    [of(200), of(u32::MAX), of(2)]
}

/// A plan of the program for so many pairs, and its data.
fn planned(
    count: usize,
    limits: &Limits,
    [keys, values, wanted]: &[Vec<u32>; 3],
) -> Result<(Plan, SceneData), PlanError> {
    let size = Size::folded(count as u64, limits.image_side).expect("a size");
    let given = |stream, bits: Vec<u32>| StreamData { stream, width: size.width, height: size.height, bits };
    let twice = values.iter().copied().chain(values.iter().map(|value| !value)).collect();
    let inputs = vec![given(KEY, keys.clone()), given(VALUE, twice), given(WANTED, wanted.clone())];
    let data = SceneData::from(Contents { inputs, ..Contents::default() });
    let sets = [in_rows(&PAIRS, count as u64, limits).expect("a size")];
    let run = Over { program: &GUESTS, schedule: schedule(1), sizes: &sets, accelerator: Accelerator::None };
    let options = Options::new(RaySource::Given(Vec::new()));
    Ok((run.plan(&data, &options, limits)?, data))
}

/// Keys, values and kept values, each with the name of its layer, after a run.
async fn found(plan: Plan, data: SceneData, device: &Device) -> Result<Vec<(&'static str, Vec<u32>)>, RenderError> {
    let options = Options::new(RaySource::Given(Vec::new()));
    let mut renderer = Renderer::from_plan(plan, data, &options, device).await?;
    renderer.run(|_| ControlFlow::Continue(())).await?;
    let mut all = Vec::new();
    for (name, stream, layer) in
        [("keys", KEY, 0), ("values", VALUE, 0), ("their complements", VALUE, 1), ("kept values", KEPT_VALUE, 0)]
    {
        let count = renderer.size(stream.info().elements).map_or(0, |size| size.count as usize);
        all.push((name, renderer.values(stream).await?.layer(layer)[..count].to_vec()));
    }
    Ok(all)
}

/// The same, as the host sorts and keeps.
fn expected(count: usize, [keys, values, wanted]: &[Vec<u32>; 3]) -> Vec<(&'static str, Vec<u32>)> {
    let mut sorted: Vec<(u32, u32)> = keys.iter().copied().zip(values.iter().copied()).take(count).collect();
    sorted.sort_by_key(|&(key, _)| key);
    let kept = sorted.iter().zip(wanted).filter(|(_, wanted)| **wanted == 1).map(|(pair, _)| pair.1).collect();
    let (keys, values): (Vec<u32>, Vec<u32>) = sorted.into_iter().unzip();
    let complements = values.iter().map(|value| !value).collect();
    vec![("keys", keys), ("values", values), ("their complements", complements), ("kept values", kept)]
}

fn devices() -> Vec<(&'static str, Device)> {
    #[allow(unused_mut)]
    let mut devices = vec![("the host", Device::Cpu(None))];
    #[cfg(feature = "gpu")]
    devices.extend(gpu().map(|gpu| ("a GPU", Device::Gpu(gpu))));
    devices
}

#[test]
fn a_program_sorts_and_compacts_by_kernels_that_are_not_its_own() {
    assert_eq!(GUESTS.faults(), []);
    // One block, several of the sort, and several of the prefix sums.
    for count in [1, 700, 20_000] {
        for (on, device) in devices() {
            let limits = device.limits();
            let inputs = inputs(count, Size::folded(count as u64, limits.image_side).expect("a size"));
            let (plan, data) = planned(count, &limits, &inputs).expect("a plan");
            let found = pollster::block_on(found(plan, data, &device)).expect("a run");
            for ((name, expected), (_, found)) in expected(count, &inputs).into_iter().zip(found) {
                assert!(found == expected, "{name} of {count} on {on}: {} {}", found.len(), expected.len());
            }
        }
    }
}

#[test]
fn primitives_are_interpreted_as_their_twins_compute() {
    for count in [1, 700, 20_000] {
        let inputs = inputs(count, Size::folded(count as u64, Limits::CPU.image_side).expect("a size"));
        let planned = || planned(count, &Limits::CPU, &inputs).expect("a plan");
        let (plan, data) = planned();
        assert_eq!(agree::<f32>(plan, &data).len(), GUESTS.kernels.len());
        agree::<f64>(planned().0, &data);
    }
}

/// Each row's defect is one that the comparison with the host finds.
#[cfg(feature = "gpu")]
#[test]
fn a_broken_primitive_is_noticed() {
    let Some(gpu) = gpu() else { return };
    let (count, device) = (20_000, Device::Gpu(gpu));
    let limits = device.limits();
    let inputs = inputs(count, Size::folded(count as u64, limits.image_side).expect("a size"));
    let expected = expected(count, &inputs);
    for row in [SCAN, ADD, HISTOGRAM, SCATTER, COMPACT] {
        let (mut plan, data) = planned(count, &limits, &inputs).expect("a plan");
        let Break { from, to, .. } = row.breaks[0];
        for variant in plan.variants.iter_mut().filter(|variant| variant.kernel.info().name == row.name) {
            assert!(variant.source.contains(from), "{}: {from}", row.name);
            variant.source = variant.source.replace(from, to);
        }
        let found = pollster::block_on(found(plan, data, &device));
        assert!(found.is_err() || found.is_ok_and(|found| found != expected), "{}", row.name);
    }
}

#[test]
fn a_set_that_two_levels_of_sums_do_not_span_is_refused() {
    let limits = Limits { image_side: 1 << 14, ..Limits::CPU };
    let refused = in_rows(&PAIRS, MOST_ELEMENTS + 1, &limits);
    let said = PlanError::from(refused.expect_err("too many")).to_string();
    assert_eq!(said, "67108865 pairs are too many: at most 67108864 fit here; use fewer cells");
}
