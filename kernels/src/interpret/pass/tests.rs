//! Barriers, atomics, races and errors of small kernels of our own.

mod followed;

use std::borrow::Cow;

use super::*;
use crate::options::features::Features;
use crate::options::reasons::{Because, Reason, Run};
use crate::program::breaks::{Break, as_it_is};
use crate::program::{Instance, KernelInfo, Program};
use crate::shared;
use crate::tables::elements::{Count, Elements};
use crate::tables::state::States;
use crate::tables::stream::{Meaning, streams};

static ITEMS: Elements = Elements { name: "items", count: Count::Given };
static OTHERS: Elements = Elements { name: "others", count: Count::Given };

fn every(_: &Run<'_>) -> Reason {
    (Because::Options, "every test needs it")
}

#[allow(dead_code, unreachable_pub)]
mod rows {
    use super::*;

    streams! {
        A of ITEMS: "a" U32 &["x", "y"], meaning: &[Meaning::Count; 2], unit: "", unwritten: &[0; 2], why_absent: every;
        B of OTHERS: "b" U32 &["x"], meaning: &[Meaning::Count], unit: "", unwritten: &[0], why_absent: every;
        F of ITEMS: "f" F32 &["x"], meaning: &[Meaning::Float], unit: "", unwritten: &[0], why_absent: every;
    }
}

const HEAD: &str = "
import package::launch::{BLOCK, launch, element, texel};
@group(0) @binding(0) var a: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var b: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(2) var f: texture_2d_array<f32>;
fn load(i: u32) -> u32 { return textureLoad(a, texel(i, textureDimensions(a).x), 0).x; }
fn store(i: u32, value: u32) { textureStore(a, texel(i, textureDimensions(a).x), 0, vec4u(value)); }
fn tell(i: u32, value: u32) { textureStore(b, texel(i, textureDimensions(b).x), 0, vec4u(value)); }
";

const ENTRY: &str = "
@compute @workgroup_size(BLOCK)
fn tested(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
";

/// A kernel with these declarations and this body, launched over a list or over an image.
fn variant(source: String, launch: crate::tables::kernel::Launch, workgroup: u32) -> Variant {
    let source = Box::leak(source.into_boxed_str());
    let breaks = vec![Break::new(as_it_is, "a", "b")].leak();
    let info = KernelInfo::once(("tested", source), |_, _| {}, [0; 3], "", every, breaks);
    let info = KernelInfo { launch, workgroup, ..info };
    let program = Program {
        name: "test",
        summary: "",
        elements: vec![&ITEMS, &OTHERS].leak(),
        streams: &rows::STREAMS,
        states: States(&[]),
        courses: &[],
        rays: None,
        results: None,
        buffers: &[],
        lists: &[],
        kernels: vec![Instance::of(info, &ITEMS)].leak(),
        modules: |_| shared::MODULES.iter().map(|&(name, wgsl)| (name, Cow::Borrowed(wgsl))).collect(),
        files: &[],
    };
    let kernel = Kernel::at(Box::leak(Box::new(program)), 0);
    Variant::new(kernel, &Features::default(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn listed(declarations: &str, body: &str) -> Variant {
    let all = crate::tables::kernel::Launch::List { each: 1, weight: 1 };
    variant(format!("{HEAD}{declarations}{ENTRY}{body}\n}}\n"), all, 256)
}

/// Streams of so many elements, the others of half as many; `a.x` is 3 i, and `f` is i / 2.
fn streams(pass: &Pass, size: Size) -> Vec<StreamData> {
    let of = |&stream: &Stream| {
        let size =
            if stream == rows::B { Size::folded(u64::from(size.count) / 2, 1 << 12).expect("a size") } else { size };
        let texels = size.texels() as usize;
        let value = |at: usize| match stream {
            _ if stream == rows::F => (at as f32 / 2.0).to_bits(),
            _ if stream == rows::A && at < texels => 3 * at as u32,
            _ => 0,
        };
        StreamData {
            stream,
            width: size.width,
            height: size.height,
            bits: (0..texels * stream.layers()).map(value).collect(),
        }
    };
    pass.streams().iter().map(of).collect()
}

fn run_over(variant: &Variant, size: Size) -> Result<Passed, PassError> {
    let pass = Pass::new(variant).map_err(PassError::before)?.limited(1 << 16);
    let streams = streams(&pass, size);
    let data = SceneData::default();
    pass.run(&Given { data: &data, size, parameter: 7, streams: &streams })
}

/// The kernel over 700 elements: three workgroups, the last of which is not full.
fn run(declarations: &str, body: &str) -> Result<Passed, PassError> {
    run_over(&listed(declarations, body), Size::folded(700, 1 << 12).expect("a size"))
}

fn of(passed: &Passed, stream: Stream) -> &StreamData {
    passed.streams.iter().find(|data| data.stream == stream).expect("a written stream")
}

/// The line of the composed source in which this stands.
fn line_with(variant: &Variant, text: &str) -> usize {
    1 + variant.source.lines().position(|line| line.contains(text)).expect(text)
}

#[test]
fn threads_see_what_others_store_behind_a_barrier_and_streams_as_before() {
    let declarations = "var<workgroup> all: array<u32, 256>;
struct Pair { x: u32, y: array<vec2u, 2> }
var<workgroup> pair: Pair;
var<private> of_thread: u32 = 5u;";
    // Twice, so that a thread goes on where it was: in a loop, in a function that is called in a branch.
    let body = "
    var sum = 0u;
    for (var turn = 0u; turn < 2u; turn++) {
        var own = 0u;
        if (i < launch.elements) { own = load(i); }
        all[lane] = own + turn;
        if (launch.parameter == 7u) {
            sum += neighbour(lane);
        }
        workgroupBarrier();
    }
    if (lane == 9u) { pair.y[1].x = 40u; }
    workgroupBarrier();
    of_thread += pair.y[1].x + pair.x;
    if (i < launch.elements) { store(i, sum + of_thread); }";
    let declarations = format!(
        "{declarations}\nfn neighbour(lane: u32) -> u32 {{ workgroupBarrier(); return all[(lane + 1u) % BLOCK]; }}"
    );
    let passed = run(&declarations, body).expect("a pass");
    let expected = |i: usize| {
        let next = i / 256 * 256 + (i + 1) % 256;
        if next < 700 { 2 * 3 * next as u32 + 1 + 45 } else { 1 + 45 }
    };
    let found = of(&passed, rows::A);
    assert!((0..700).all(|i| found.get(0, i) == expected(i)), "{:?}", &found.bits[..8]);
    assert_eq!(passed.race, None);
    assert_eq!(found.get(0, 700), 3 * 700, "what is not stored stays");
    // Work of all threads: each stores one component.
    assert_eq!(passed.work.stream_bytes_written, 4 * 700);
}

#[test]
fn atomics_are_those_of_wgsl_in_the_order_of_threads() {
    let declarations = "var<workgroup> n: atomic<u32>;
var<workgroup> s: array<atomic<i32>, 4>;
var<workgroup> w: array<atomic<u32>, 8>;";
    let body = "
    let place = atomicAdd(&n, 2u);
    atomicMin(&s[0], -i32(lane)); atomicMax(&s[1], i32(lane) - 300); atomicSub(&s[2], 2);
    atomicOr(&w[lane / 32u], 1u << (lane % 32u));
    let old = atomicCompareExchangeWeak(&s[3], i32(lane), i32(lane) + 1);
    workgroupBarrier();
    let swapped = atomicExchange(&n, lane);
    workgroupBarrier();
    atomicAnd(&w[0], 0xffu); atomicXor(&w[1], select(0u, 5u, lane == 0u));
    workgroupBarrier();
    if (lane == 0u) {
        atomicStore(&n, 77u);
        let sum = u32(-atomicLoad(&s[0])) + u32(-atomicLoad(&s[1])) + u32(-atomicLoad(&s[2]));
        tell(i / BLOCK, sum + atomicLoad(&n) + atomicLoad(&w[0]) + atomicLoad(&w[1]) + u32(atomicLoad(&s[3])));
    }
    if (i < launch.elements) { store(i, place + 1000u * u32(old.old_value == i32(lane) && old.exchanged) + 10000u * swapped); }";
    let passed = run(declarations, body).expect("a pass");
    let expected = |lane: u32| 2 * lane + 1000 + 10000 * if lane == 0 { 512 } else { lane - 1 };
    let found = of(&passed, rows::A);
    assert!((0..700).all(|i| found.get(0, i) == expected(i as u32 % 256)), "{:?}", &found.bits[..8]);
    let sum = (255u32 + 512 + 77 + 255 + 256).wrapping_add(!5);
    assert_eq!(of(&passed, rows::B).get(0, 1), sum);
    assert_eq!(passed.race, None);
}

#[test]
fn a_uniform_load_waits_before_and_after_it() {
    let declarations = "var<workgroup> shared_one: u32;";
    let body = "
    var sum = 0u;
    for (var turn = 0u; turn < 3u; turn++) {
        if (lane == 255u - turn) { shared_one = 10u * turn + 1u; }
        let seen = workgroupUniformLoad(&shared_one);
        sum += seen;
        if (seen == 11u) { continue; }
    }
    if (i < launch.elements) { store(i, sum); }";
    let passed = run(declarations, body).expect("a pass");
    assert!((0..700).all(|i| of(&passed, rows::A).get(0, i) == 1 + 11 + 21));
    assert_eq!(passed.race, None);
}

#[test]
fn a_thread_sees_its_own_stores_and_behind_a_barrier_those_of_its_workgroup() {
    let body = "
    if (i < launch.elements) { store(i, load(i) + 1u); store(i, load(i) + 1u); }
    BARRIER
    let other = i / BLOCK * BLOCK + (lane + 1u) % BLOCK;
    if (i < 512u) { textureStore(a, texel(i, textureDimensions(a).x), 1, vec4u(load(other))); }";
    let seen = |barrier: &str| run("", &body.replace("BARRIER", barrier)).expect("a pass");
    let passed = seen("textureBarrier();");
    assert_eq!([of(&passed, rows::A).get(0, 600), of(&passed, rows::A).get(1, 300)], [1802, 3 * 301 + 2]);
    assert_eq!(passed.race, None);
    for barrier in ["", "storageBarrier();"] {
        let passed = seen(barrier);
        assert_eq!(of(&passed, rows::A).get(1, 300), 3 * 301);
        // Thread 0 loads what thread 1 stores.
        let (stream, layer) = (rows::A, 0);
        let race = passed.race.expect("a race");
        assert_eq!((race.texels, race.what), ([[0, 0], [1, 0]], Raced::Loaded { stream, layer, texel: [1, 0] }));
    }
}

#[test]
fn different_values_in_one_component_are_a_race_and_the_same_are_not() {
    let passed = run("", "    if (lane >= 3u) { tell(lane % 4u, 5u); }").expect("a pass");
    assert_eq!(passed.race, None);
    let all = listed("", "\n    if (i >= 3u) {\n        tell(i % 4u, 4u + i / 256u);\n    }");
    let passed = run_over(&all, Size::folded(700, 1 << 12).expect("a size")).expect("a pass");
    // Elements 3 and 259 are the first of component 3.
    let race = passed.race.as_ref().expect("a race");
    assert_eq!(race.texels, [[3, 0], [259 % 32, 259 / 32]]);
    assert_eq!(race.line, line_with(&all, "fn tell"));
    assert_eq!(of(&passed, rows::B).get(0, 1), 6, "the last one stays");
}

#[test]
fn accesses_of_a_variable_that_no_barrier_orders_are_a_race() {
    let of_body = |body: &str| {
        let all = listed("var<workgroup> before: array<u32, 3>;\nvar<workgroup> all: array<u32, 256>;", body);
        let race = run_over(&all, Size::folded(700, 1 << 12).expect("a size")).expect("a pass").race;
        race.map(|race| (race.texels.map(|[x, y]| 32 * y + x), race.line, race.what, all))
    };
    let passes = "\n    all[lane] = i;\n    workgroupBarrier();\n    let x = all[255u - lane];\n    workgroupBarrier();\n    all[lane] = x;";
    assert!(of_body(passes).is_none());
    let reads =
        "\n    all[lane] = i;\n    let x = all[max(lane, 6u) - 5u];\n    workgroupBarrier();\n    all[lane] = x;";
    let (elements, line, what, all) = of_body(reads).expect("a race");
    assert_eq!((elements, what), ([0, 1], Raced::Variable("all".into())));
    assert_eq!(line, line_with(&all, "all[lane] = i;"));
    let writes = "\n    if (i >= 256u) { before[lane / 200u] = 1u; }";
    let (elements, _, what, _) = of_body(writes).expect("a race");
    assert_eq!((elements, what), ([256, 257], Raced::Variable("before".into())));
    // A barrier for other memory does not help.
    assert!(of_body(&passes.replacen("workgroupBarrier", "storageBarrier", 1)).is_some());
}

#[test]
fn a_barrier_that_only_some_threads_reach_is_an_error_with_its_line() {
    let of_body = |body: &str| {
        let all = listed("", body);
        let error = run_over(&all, Size::folded(700, 1 << 12).expect("a size")).expect_err("an error");
        let InterpretError::Barrier(missing) = error.why else { panic!("{error}") };
        (
            missing.thread,
            missing.has_ended,
            error.texel,
            error.lines[0] == line_with(&all, "workgroupBarrier(); // here"),
        )
    };
    let returned = "\n    if (i == 300u) { return; }\n    workgroupBarrier(); // here";
    assert_eq!(of_body(returned), (300 - 256, true, [0, 8], true));
    let other = "\n    if (lane < 10u) {\n        workgroupBarrier(); // here\n    } else {\n        workgroupBarrier();\n    }";
    assert_eq!(of_body(other), (10, false, [0, 0], true));
    let turn = "
    for (var t = 0u; t < 3u; t++) {
        if (lane == 4u && t == 0u) { continue; }
        workgroupBarrier(); // here
    }";
    assert_eq!(of_body(turn), (4, false, [0, 0], true));
}

#[test]
fn what_a_device_need_not_define_is_an_error_with_line_and_element() {
    let error = |declarations: &str, body: &str| {
        let all = listed(declarations, body);
        let error = run_over(&all, Size::folded(700, 1 << 12).expect("a size")).expect_err("an error");
        (error.to_string(), error.lines, all)
    };
    let (said, lines, all) = error("", "\n    if (i > 400u) {\n        tell(i, 1u);\n    }");
    // 350 others are 11 rows of 32.
    assert_eq!(said, "index 12 is outside of the 11 rows of b, for the element at 17,12");
    assert_eq!(lines, [line_with(&all, "fn tell"), line_with(&all, "tell(i, 1u);")]);
    let (said, ..) = error("", "\n    if (i == 5u) { textureStore(b, vec2i(-1, 0), 0, vec4u()); }");
    assert_eq!(said, "index 4294967295 is outside of the 32 columns of b, for the element at 5,0");
    let (said, ..) = error("var<workgroup> all: array<u32, 256>;", "\n    all[lane + 3u] = 1u;");
    assert_eq!(said, "index 256 is outside of an array, which has 256 elements, for the element at 29,7");
    let (said, ..) = error("", "\n    loop { if (i == 99999u) { break; } }");
    assert_eq!(said, "a loop has not ended after 65536 turns, for the element at 0,0");
    let (said, ..) = error("", "\n    store(0u, textureLoad(a, vec2u(0u), 7).x);");
    assert_eq!(said, "index 7 is outside of the 2 layers of a, for the element at 0,0");
}

#[test]
fn what_is_not_known_is_refused_with_its_line() {
    let refused = |declarations: &str, body: &str| {
        let all = listed(declarations, body);
        run_over(&all, Size::folded(700, 1 << 12).expect("a size")).expect_err("an error").to_string()
    };
    for (declarations, body) in [
        ("var<workgroup> large: array<array<u32, 20000>, 20000>;", "\n    large[0][1] = 1u;"),
        ("", "\n    var large: array<array<u32, 20000>, 20000>;\n    large[lane][i] = 1u;"),
        ("", "\n    let h = u32(f64(i));\n    store(h, h);"),
    ] {
        let said = refused(declarations, body);
        assert!(said.starts_with("line ") && said.contains("not supported"), "{said}");
    }
}

#[test]
fn a_pass_over_an_image_has_the_threads_of_its_pixels() {
    let source = format!(
        "{HEAD}
struct Ids {{ @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_id) local: vec3u }}
@compute @workgroup_size(8, 8)
fn tested(ids: Ids, @builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) index: u32) {{
    let size = textureDimensions(a);
    if (any(ids.id.xy >= size) || any(ids.id.xy != 8u * group.xy + ids.local.xy) || index != ids.local.y * 8u + ids.local.x) {{
        return;
    }}
    textureStore(a, ids.id.xy, 0, vec4u(100u * groups.x + groups.y, 0u, 0u, 0u));
    textureStore(a, ids.id.xy, 1, vec4u(u32(2.0 * textureLoad(f, ids.id.xy, 0, 0).x), 0u, 0u, 0u));
}}
"
    );
    let all = variant(source, crate::tables::kernel::Launch::Whole, 8);
    let size = Size { width: 21, height: 10, count: 210 };
    let passed = run_over(&all, size).expect("a pass");
    assert!(of(&passed, rows::A).layer(0).iter().all(|&n| n == 302));
    assert!(of(&passed, rows::A).layer(1).iter().copied().eq(0..210));
}

#[test]
fn what_an_element_prints_and_asserts_is_that_of_its_thread() {
    let all = listed(
        "fn note___0(value: u32) { }\nfn assert___0(holds: bool) { }",
        "\n    if (i % 2u == 0u) { note___0(i); }\n    workgroupBarrier();\n    note___0(i + 1u);\n    assert___0(i != 300u || launch.parameter != 8u);",
    );
    let mut pass = Pass::new(&all).expect("valid WGSL");
    pass.0.notes.noted.push(Noted { label: "i".into(), kind: naga::ScalarKind::Uint, words: 1 });
    pass.0.notes.asserted.push("not 300".into());
    let size = Size::folded(700, 1 << 12).expect("a size");
    let (streams, data) = (streams(&pass, size), SceneData::default());
    let passed = pass.run(&Given { data: &data, size, parameter: 7, streams: &streams }).expect("a pass");
    assert_eq!([passed.noted[4], passed.noted[5]], [([5, 0, 0, 0], 2), ([6, 0, 0, 0], 1)]);
    let failed = pass.run(&Given { data: &data, size, parameter: 8, streams: &streams }).expect_err("an error");
    assert_eq!((failed.why, failed.texel), (InterpretError::Assertion("not 300".into()), [300 % 32, 300 / 32]));
}

#[test]
fn a_recording_has_the_decisions_of_its_thread_alone() {
    let all = listed(
        "var<workgroup> most: atomic<u32>;",
        "
    atomicMax(&most, load(min(i, 699u)));
    workgroupBarrier();
    if (atomicLoad(&most) > 3u * 511u) {
        if (i < launch.elements) {
            textureStore(a, texel(i, textureDimensions(a).x), 1, vec4u(atomicLoad(&most)));
        }
    }",
    );
    let pass = Pass::new(&all).expect("valid WGSL");
    let size = Size::folded(700, 1 << 12).expect("a size");
    let (streams, data) = (streams(&pass, size), SceneData::default());
    let given = Given { data: &data, size, parameter: 0, streams: &streams };
    let recording = pass.record(&given, [600 % 32, 600 / 32]).expect("a recording");
    let compared: Vec<_> = (0..recording.decisions.len()).map(|at| recording.comparisons(pass.code(), at)[0]).collect();
    assert_eq!(
        compared.iter().map(|c| (c.values.map(|v| v.bits), c.holds)).collect::<Vec<_>>(),
        [([3 * 699, 3 * 511], true), ([600, 700], true)]
    );
    assert_eq!(recording.stored[1], Some(line_with(&all, "vec4u(atomicLoad(&most))") - 1));
    assert_eq!(recording.stored[0], None);
    let recording = pass.record(&given, [0, 0]).expect("a recording");
    assert_eq!(recording.decisions.len(), 1, "the first workgroup has smaller ones");
    assert!(pass.record(&given, [0, 99]).is_err());
}
