//! The interpreter does what the CPU reference kernels do, to the last bit: every kernel of rays, on every repository
//! scene.

use std::collections::BTreeMap;

use raystep_inspector::branches::Branches;
use raystep_inspector::source::Mark;
use raystep_kernels::interpret::{Element, InterpretError, Interpreter, MOST_SITES, Recording, SiteKind, Work};
use raystep_kernels::options::ProgramName;
use raystep_kernels::programs::closest_hit::states::{DONE, ISECT_HIT, ISECT_NO_HIT, SHADE, STATES, TRAV, TRAV_SETUP};
use raystep_kernels::programs::closest_hit::streams::{STATE, STATE_ITEM, STATE_T};
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{
    Accelerator, Device, Keep, Kernel, Limits, Numerics, Options, Plan, Renderer, Rule, Samples, ScheduleKind,
    StreamData,
};
use raystep_scenes::{Scene, generate};

use crate::data::common::{options, scenes};

/// One ray in one pass.
struct Seen<'a> {
    kernel: Kernel,
    interpreter: &'a Interpreter,
    recording: &'a Recording,
    before: &'a [u32],
    after: &'a [u32],
}

fn component(interpreter: &Interpreter, layer: usize) -> usize {
    let before = interpreter.streams().iter().take_while(|stream| **stream != STATE);
    before.map(|stream| stream.layers()).sum::<usize>() + layer
}

/// A NaN's payload is not defined.
fn is_same(a: u32, b: u32) -> bool {
    a == b || (f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan())
}

/// Runs to the end, interprets every pass of every ray, and compares; returns the number of comparisons by kernel.
fn compare(
    what: &str,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
    mut look: impl FnMut(&Seen<'_>),
) -> BTreeMap<&'static str, usize> {
    let (plan, data) = Plan::new(scene, options, limits).unwrap_or_else(|e| panic!("{what}: {e}"));
    let interpreters: BTreeMap<Kernel, Interpreter> = plan
        .variants
        .iter()
        .filter(|variant| !variant.kernel.takes().is_empty())
        .map(|variant| (variant.kernel, Interpreter::new(variant).expect("a kernel of rays")))
        .collect();
    for interpreter in interpreters.values() {
        assert!(interpreter.sites().len() <= MOST_SITES, "{}", interpreter.sites().len());
    }
    let size = [plan.width, plan.height];
    let renderer = Renderer::from_plan(plan, data, options, &Device::Cpu(None));
    let mut renderer = pollster::block_on(renderer).expect("a small scene");
    let all = |renderer: &Renderer| -> Vec<StreamData> {
        let streams = renderer.plan().streams.iter().map(|s| s.what);
        streams.map(|stream| pollster::block_on(renderer.values(stream)).expect("a stream")).collect()
    };
    let texels = |streams: &[StreamData], interpreter: &Interpreter, ray: usize| -> Vec<u32> {
        let of = |stream| streams.iter().find(|data| data.stream == stream).expect("a stream of the plan");
        let own = interpreter.streams().iter().map(|&stream| of(stream));
        own.flat_map(|data| (0..data.stream.layers()).map(|layer| data.get(layer, ray))).collect()
    };
    let mut counts = BTreeMap::new();
    let mut before = all(&renderer);
    while let Some(pass) = pollster::block_on(renderer.step()).expect("a pass") {
        let after = all(&renderer);
        let Some(interpreter) = interpreters.get(&pass.kernel) else { continue };
        let data = renderer.data();
        let mut counter = interpreter.counter(data);
        for ray in 0..(size[0] * size[1]) as usize {
            let (input, expected) = (texels(&before, interpreter, ray), texels(&after, interpreter, ray));
            let tag = input[component(interpreter, STATE_TAG)];
            let element = Element { texel: [ray as u32 % size[0], ray as u32 / size[0]], size };
            let is_worked_on = pass.kernel.takes().contains(&tag) || pass.rays_in == size[0] * size[1];
            if !is_worked_on && ray % 16 != 0 {
                continue;
            }
            let what = || format!("{what}, pass {}, {} of ray {ray}", pass.index, pass.kernel.name());
            let mut output = input.clone();
            let recording =
                interpreter.record(data, element, &mut output).unwrap_or_else(|e| panic!("{}: {e}", what()));
            let same = output.iter().zip(&expected).all(|(&a, &b)| is_same(a, b));
            assert!(same, "{}: {:?}\n{output:x?}\n{expected:x?}", what(), interpreter.streams());
            let mut counted = input.clone();
            let outcomes = counter.run(element, &mut counted).expect("as above");
            assert_eq!(counted, output, "{}: counting and recording differ", what());
            for (site, [taken, not]) in recording.counts.iter().enumerate() {
                let bit = 1u128 << site;
                assert_eq!((outcomes.reached & bit != 0, outcomes.taken & bit != 0), (taken + not > 0, *taken > 0));
            }
            assert!(recording.deciding.is_some(), "{}: nothing decides", what());
            if is_worked_on {
                *counts.entry(pass.kernel.name()).or_insert(0) += 1;
                look(&Seen { kernel: pass.kernel, interpreter, recording: &recording, before: &input, after: &output });
            }
        }
        before = after;
    }
    counts
}

fn add(sum: &mut BTreeMap<&'static str, usize>, more: BTreeMap<&'static str, usize>) {
    more.into_iter().for_each(|(kernel, count)| *sum.entry(kernel).or_insert(0) += count);
}

#[test]
fn every_kernel_is_interpreted_as_its_reference_runs_on_every_scene() {
    const SCHEDULES: [ScheduleKind; 4] =
        [ScheduleKind::First, ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused];
    let mut sum = BTreeMap::new();
    for (i, (name, scene)) in scenes().iter().enumerate() {
        const ACCELERATORS: [Accelerator; 4] =
            [Accelerator::Grid, Accelerator::Bvh, Accelerator::Irregular, Accelerator::None];
        for (j, accelerator) in ACCELERATORS.into_iter().enumerate() {
            if accelerator == Accelerator::None && scene.triangles.len() > 200 {
                continue;
            }
            for (k, numerics) in [Numerics::Robust, Numerics::Paper].into_iter().enumerate() {
                if accelerator == Accelerator::Irregular && numerics == Numerics::Paper {
                    continue;
                }
                let schedule = SCHEDULES[(i + j + k) % 4];
                let some = options(scene, accelerator, schedule, [9, 7]);
                let counters = (i + k) % 2 == 0;
                let steps_per_pass = if schedule == ScheduleKind::Compact { 1 + 3 * (i as u32 % 2) } else { 1 };
                let some = Options { numerics, counters, steps_per_pass, ..some };
                let what = format!("{name}, {accelerator}, {schedule}, {numerics}");
                add(&mut sum, compare(&what, scene, &some, &Limits::CPU, |_| {}));
            }
        }
    }
    let steps = ["traverse_bvh", "traverse_grid", "traverse_irregular", "walk"];
    for kernel in ["fused", "generate", "intersect", "setup", "shade"].into_iter().chain(steps) {
        assert!(sum.get(kernel).is_some_and(|&count| count > 300), "{kernel}: {sum:?}");
    }
}

#[test]
fn every_rule_and_every_way_to_wait_is_interpreted_too() {
    let scene = generate::cornell_box();
    let mut sum = BTreeMap::new();
    // So few loop iterations that walks, searches and the sum over the lights are continued in later dispatches.
    let short = Limits { turns: 48, ..Limits::CPU };
    let rules = [Rule::TMax, Rule::Acceptance, Rule::TriangleTest].map(Some);
    for without in rules.into_iter().chain([None]) {
        for (schedule, steps_per_pass) in
            [(ScheduleKind::Second, 1), (ScheduleKind::Compact, 4), (ScheduleKind::Fused, 1)]
        {
            for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
                if accelerator == Accelerator::Irregular && without.is_some() {
                    continue;
                }
                for (limits, counters, keep) in [(Limits::CPU, false, Keep::ALL), (short, true, Keep::NONE)] {
                    let some = options(&scene, accelerator, schedule, [8, 6]);
                    let contracted = without.is_none() && counters;
                    let any_hit = without.is_none() && steps_per_pass == 4 && counters;
                    let some = Options { without, steps_per_pass, counters, keep, contracted, any_hit, ..some };
                    let what = format!("{without:?}, {schedule}, {accelerator}, {}", limits.turns);
                    add(&mut sum, compare(&what, &scene, &some, &limits, |_| {}));
                }
            }
        }
    }
    let samples = Samples { count: 3, ..Samples::default() };
    let some = Options { samples, ..options(&scene, Accelerator::Grid, ScheduleKind::Second, [6, 5]) };
    add(&mut sum, compare("samples", &scene, &some, &Limits::CPU, |_| {}));
    assert!(sum.get("accumulate").is_some_and(|&count| count > 80), "{sum:?}");
}

#[test]
fn the_deciding_condition_explains_the_new_state() {
    let scene = generate::cornell_box();
    let mut seen: BTreeMap<(&str, u32, u32), BTreeMap<String, usize>> = BTreeMap::new();
    for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
        let some = options(&scene, accelerator, ScheduleKind::Second, [16, 12]);
        compare("Cornell box", &scene, &some, &Limits::CPU, |ray| {
            let tag = component(ray.interpreter, STATE_TAG);
            let deciding = ray.recording.deciding.expect("a decision");
            let decision = &ray.recording.decisions[deciding];
            let site = &ray.interpreter.sites()[decision.site];
            assert_ne!(site.kind, SiteKind::ShortCircuit);
            let text = format!("{} {}", &ray.interpreter.source()[site.span.clone()], decision.is_taken);
            let key = (ray.kernel.name(), ray.before[tag], ray.after[tag]);
            *seen.entry(key).or_default().entry(text).or_insert(0) += 1;
        });
    }
    for (key, texts) in &seen {
        println!("{key:?}: {texts:?}");
    }
    let has = |key: (&'static str, u32, u32), expected: &[&str]| {
        let texts = seen.get(&key).unwrap_or_else(|| panic!("{key:?} in {seen:?}"));
        for text in expected {
            assert!(texts.contains_key(*text), "{key:?}: {text} is not in {texts:?}");
        }
        assert_eq!(texts.len(), expected.len(), "{key:?}: {texts:?}");
    };
    // A triangle is missed at an edge or behind the nearest hit, or hit; a list ends before or behind a hit.
    let edge = "!(front || back) true";
    let within = "tag == ISECT_HIT && nearest_t <= exit true";
    let beyond = "tag == ISECT_HIT && nearest_t <= exit false";
    has(("intersect", ISECT_NO_HIT, ISECT_NO_HIT), &[edge]);
    has(("intersect", ISECT_NO_HIT, ISECT_HIT), &["candidate.is_hit && accepted true"]);
    has(("intersect", ISECT_HIT, SHADE), &[within]);
    // The list is over: with nothing tested, or after a test.
    has(("intersect", ISECT_NO_HIT, TRAV), &["ended true", beyond, edge]);
    has(("traverse_grid", TRAV, ISECT_NO_HIT), &["axis true"]);

    has(("traverse_bvh", TRAV, SHADE), &["at.node == NO_NODE true"]);
    let boxes = "hits_box(node, origin, inverse, nearest_t)";
    let sibling = "is_first != goes_down(above >> 30u, direction)";
    let [is_met, is_missed] = [format!("{boxes} true"), format!("{boxes} false")];
    // On the way up no box is tested.
    let [to_sibling, to_parent] = [format!("{sibling} true"), format!("{sibling} false")];
    has(("traverse_bvh", TRAV, ISECT_NO_HIT), &[&is_met]);
    has(("traverse_bvh", TRAV, TRAV), &[&is_met, &is_missed, &to_sibling, &to_parent]);
    // The camera is in the grid: where the walk begins is decided by the direction.
    has(("setup", TRAV_SETUP, ISECT_NO_HIT), &["!walk.inside false", "ray.inverse > vec3f(0.0) true"]);
    has(("shade", SHADE, DONE), &["tag == SHADE true"]);
}

#[test]
fn lines_that_ran_are_what_the_ray_did_and_f64_seldom_differs() {
    let scene = generate::cornell_box();
    let (mut notes, mut differing, mut ways) = (0, 0, 0);
    for (accelerator, numerics) in [
        (Accelerator::Grid, Numerics::Robust),
        (Accelerator::Bvh, Numerics::Robust),
        (Accelerator::None, Numerics::Robust),
        (Accelerator::Grid, Numerics::Paper),
    ] {
        let some = options(&scene, accelerator, ScheduleKind::Second, [12, 9]);
        let some = Options { numerics, counters: true, ..some };
        compare("Cornell box", &scene, &some, &Limits::CPU, |ray| {
            let branches = Branches::new(ray.interpreter, ray.recording);
            let source: Vec<&str> = ray.interpreter.source().split('\n').collect();
            assert_eq!(branches.marks.len(), source.len());
            let lines = source.iter().zip(&branches.marks);
            let ran: Vec<&str> = lines.filter(|(_, mark)| **mark == Mark::Run).map(|(line, _)| *line).collect();
            let has_run = |part: &str| ran.iter().any(|line| line.contains(part));
            let tag = component(ray.interpreter, STATE_TAG);
            // Exactly one line stores the tag, and if it names a tag, that is the ray's.
            let stores: Vec<_> = ran.iter().filter(|line| line.contains("textureStore(state, texel, 0,")).collect();
            assert_eq!(stores.len(), 1, "{}: {stores:?}", ray.kernel.name());
            let named = STATES.iter().find(|s| stores[0].contains(&format!("({})", s.name)));
            assert!(named.is_none_or(|s| s.tag == ray.after[tag]), "{stores:?}");
            if ray.kernel.name() == "intersect" {
                let item = component(ray.interpreter, STATE_ITEM);
                assert_eq!(has_run("item += 1u"), ray.after[item] == ray.before[item] + 1);
                let t = component(ray.interpreter, STATE_T);
                assert_eq!(has_run("nearest_t = candidate.t;"), ray.after[t] != ray.before[t]);
            }
            for branch in &branches.reached {
                assert!(source[branch.line].trim().len() > 2 && !branch.condition.is_empty(), "{branch:?}");
                assert!(!branch.notes.is_empty());
                notes += branch.notes.len();
                differing += branch.notes.iter().filter(|note| note.differs).count();
            }
            ways += 1;
        });
    }
    assert!(ways > 1000 && notes > 10_000, "{ways} {notes}");
    assert!(differing > 0 && differing * 100 < notes, "{differing} of {notes}");
}

#[test]
fn a_program_whose_elements_read_each_other_is_refused() {
    let scene = generate::cornell_box();
    let some = options(&scene, Accelerator::Grid, ScheduleKind::Second, [4, 3]);
    let some = Options { program: ProgramName::GridBuild, ..some };
    let (plan, _) = Plan::new(&scene, &some, &Limits::CPU).expect("a plan");
    assert!(!plan.variants.is_empty());
    for variant in &plan.variants {
        assert!(matches!(Interpreter::new(variant), Err(InterpretError::NotAlone(_))), "{}", variant.kernel.name());
    }
}

/// A kernel whose operations and bytes can be counted by hand, with the bindings and the name of `traverse_grid`.
const BY_HAND: &str = "
struct Grid { a: vec3f, b: u32 }
@group(0) @binding(0) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var tmax: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(2) var<uniform> grid: Grid;
fn twice(x: f32) -> f32 { return x + x; }
@compute @workgroup_size(1)
fn traverse_grid(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    let tag = textureLoad(state, texel, 0).x;   // 4 bytes
    let a = grid.a;                             // 12 bytes of a uniform
    var sum = a * 2.0 - vec3f(1.0);             // 6 floats
    for (var i = 0u; i < 3u; i++) {             // 4 comparisons, 3 integers
        sum.x = twice(sum.x);                   // 3 floats
    }
    let f = fma(sum.x, sum.y, clamp(sum.z, 0.0, 1.0));          // 4 floats
    let n = u32(abs(f)) + (tag << 2u);          // 1 float; 3 integers: a conversion, a sum, a shift
    let chosen = select(n, tag, sum.x < f);     // 2 comparisons
    if (chosen == 4294967295u) {                // 1 comparison
        textureStore(tmax, texel, 0, vec4f(sqrt(f)));           // not reached
    }
    textureStore(state, texel, 0, vec4u(chosen));               // 4 bytes
    textureStore(tmax, texel, 1, vec4f(bitcast<f32>(chosen)));  // 4 bytes
}
";

#[test]
fn operations_and_bytes_are_those_counted_by_hand() {
    let scene = generate::cornell_box();
    let some = options(&scene, Accelerator::Grid, ScheduleKind::Second, [4, 3]);
    let some = Options { numerics: Numerics::Paper, ..some };
    let (plan, data) = Plan::new(&scene, &some, &Limits::CPU).expect("a plan");
    let mut variant = plan.variants.iter().find(|v| v.kernel.name() == "traverse_grid").expect("a grid").clone();
    variant.source = BY_HAND.to_owned();
    let interpreter = Interpreter::new(&variant).expect("valid WGSL");
    let mut counter = interpreter.counter(&data);
    let by_hand = Work {
        float_operations: 6 + 3 + 4 + 1,
        integer_operations: 3 + 3,
        comparisons: 4 + 2 + 1,
        stream_bytes_read: 4,
        stream_bytes_written: 8,
        buffer_bytes_read: 0,
        uniform_bytes_read: 12,
    };
    let mut sum = Work::default();
    for x in 0..4 {
        let mut texels = vec![7; interpreter.components()];
        counter.run(Element { texel: [x, 1], size: [4, 3] }, &mut texels).expect("it ends");
        sum.add(&by_hand, 1);
        assert_eq!(counter.work(), sum, "after {} rays", x + 1);
    }
    assert_eq!((by_hand.operations(), by_hand.bytes()), (27, 12));
}
