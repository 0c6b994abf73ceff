//! Mistakes in users' kernels are named with their places, and our own kernels are taken back as they are.

use std::collections::{BTreeSet, HashSet};
use std::fmt::Write as _;
use std::sync::Arc;

use raystep_scenes::{Camera, Scene, generate};

use super::{Mistake, Place};
use crate::compose::{WordKind, words};
use crate::options::features::Features;
use crate::options::replacement::Replacement;
use crate::options::samples::Samples;
use crate::options::{Accelerator, Integrator, Numerics, Options, Order, RaySource, ScheduleKind};
use crate::plan::{Limits, Plan};
use crate::program::live::{self, LiveList};
use crate::program::{Kernel, Twin};
use crate::programs;
use crate::programs::closest_hit::kernels::TRAVERSE_GRID;
use crate::shader::{ShaderError, Variant};

/// A kernel with this WGSL in place of its own, or what is wrong with it.
fn replaced(kernel: Kernel, features: &Features, lists: &[LiveList], source: &str) -> Result<Variant, Mistake> {
    let (kernel_name, source) = (kernel.name().to_owned(), source.to_owned());
    let by = Arc::new(Replacement { kernel: kernel_name, file: "my.wgsl".into(), source });
    Variant::replaced(kernel, features, lists, &by).map_err(|error| match error {
        ShaderError::Mistake(mistake) => *mistake,
        other => panic!("{other}"),
    })
}

fn options_of(scene: &Scene) -> Options {
    let camera = Camera::framing(&scene.bounds());
    Options::new(RaySource::Camera { camera, width: 8, height: 8 })
}

fn kernels_of(plan: &Plan) -> Vec<Kernel> {
    plan.variants.iter().map(|variant| variant.kernel).collect()
}

/// Shows where a mistake is expected; removed before the kernel is read.
const HERE: char = '‸';

/// A kernel of the paper, its WGSL with each text replaced by another, and a part of the message. Without a mark, no line is named.
type Case = (&'static str, &'static [(&'static str, &'static str)], &'static str);

const HIT: &str = "@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;";

/// Where another global can stand, and where it can be used.
const ABOVE: &str = "fn step_item(";
const BODY: &str = "    let list = list_of(cell);";

const MISTAKES: &[Case] = &[
    // Globals and what they are bound to.
    (
        "intersect",
        &[(HIT, ""), ("entry.triangle, nearest_t, textureLoad(hit,", "entry.triangle, nearest_t, textureLoad(‸hit,")],
        "no definition in scope for identifier: `hit`",
    ),
    (
        "intersect",
        &[("@binding(3) var hit", "@binding(2) ‸var hit")],
        "hit and state have the same @group(0) @binding(2)",
    ),
    (
        "setup",
        &[
            ("var tmax: texture_storage_2d_array<r32float", "var tmax: texture_storage_2d_array<r32uint"),
            ("tmax, texel, 0, vec4f(", "tmax, texel, 0, ‸vec4f("),
        ],
        "cannot convert elements of `vec4<f32>` to `u32`",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(0) @binding(30) ‸var color: texture_2d_array<u32>;\nfn step_item("),
            (BODY, "    _ = textureDimensions(color);\n    let list = list_of(cell);"),
        ],
        "the stream color is texture_2d_array<f32>, or texture_storage_2d_array<r32float, read_write>",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(0) @binding(30) ‸var color: sampler;\nfn step_item("),
            (BODY, "    _ = color;\n    let list = list_of(cell);"),
        ],
        "the stream color is texture_2d_array<f32>",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(1) @binding(30) ‸var<storage, read_write> materials: array<u32>;\nfn step_item("),
            (BODY, "    materials[0] = 1u;\n    let list = list_of(cell);"),
        ],
        "the buffer materials is var<storage, read>: a kernel only reads it",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(0) @binding(30) ‸var hits: texture_storage_2d_array<r32uint, write>;\nfn step_item("),
            (BODY, "    textureStore(hits, texel, 0, vec4u(1u));\n    let list = list_of(cell);"),
        ],
        "no stream is named hits; there are accumulated, ",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(1) @binding(30) ‸var<storage, read> mine: array<u32>;\nfn step_item("),
            (BODY, "    _ = mine[0];\n    let list = list_of(cell);"),
        ],
        "no buffer is named mine; there are ",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(2) @binding(30) ‸var color: texture_2d_array<f32>;\nfn step_item("),
            (BODY, "    _ = textureDimensions(color);\n    let list = list_of(cell);"),
        ],
        "color is in @group(2) @binding(30): streams and scene data belong to groups 0 and 1",
    ),
    (
        "intersect",
        &[
            (ABOVE, "@group(0) @binding(640) ‸var color: texture_2d_array<f32>;\nfn step_item("),
            (BODY, "    _ = textureDimensions(color);\n    let list = list_of(cell);"),
        ],
        "no binding is above 639",
    ),
    (
        "intersect",
        &[(ABOVE, "‸override bias: u32;\nfn step_item("), ("item += 1u", "item += bias")],
        "an override gets no value here: use a const",
    ),
    (
        "intersect",
        &[(ABOVE, "‸var<workgroup> big: array<u32, 5000>;\nfn step_item("), ("item += 1u", "item += big[0]")],
        "workgroup",
    ),
    // The entry point.
    (
        "intersect",
        &[("@workgroup_size(LIST_SIDE, LIST_SIDE)\nfn ", "@workgroup_size(64)\nfn ‸")],
        "its workgroups have 64×1×1 threads, but intersect is launched with @workgroup_size(16, 16)",
    ),
    ("intersect", &[("fn intersect(", "fn mine(")], "it has no @compute function named intersect"),
    (
        "intersect",
        &[("@compute @workgroup_size(LIST_SIDE, LIST_SIDE)\n", "")],
        "it has no @compute function named intersect",
    ),
    ("intersect", &[("builtin(workgroup_id)", "builtin(‸workgroup)")], "unknown builtin"),
    (
        "intersect",
        &[("send(lane, texel, step_item(texel))", "_ = step_item(texel)"), ("fn intersect(", "fn ‸intersect(")],
        "it does not tell where its elements go: the last call of every thread must be send(lane, texel, tag)",
    ),
    (
        "intersect",
        &[("    send(lane", "    if (lane < 8u) { return; }\n    ‸send(lane")],
        "some threads of a workgroup may not reach this",
    ),
    (
        "traverse_grid",
        &[(
            "    send(lane, texel, step_cell(texel));",
            "    if (lane < 8u) {\n\t\t‸send(lane, texel, step_cell(texel));\n    }",
        )],
        "some threads of a workgroup may not reach this",
    ),
    // Names and imports.
    ("intersect", &[("package::corners::", "package::‸corner::")], "no module is named package::corner"),
    (
        "intersect",
        &[("{vertex}", "{vertex, ‸edge}"), (BODY, "    _ = edge(0u);\n    let list = list_of(cell);")],
        "package::corners does not declare edge in this run",
    ),
    (
        "intersect",
        &[(ABOVE, "fn ‸load_ray(texel: vec2u) -> u32 {\n    return 0u;\n}\nfn step_item(")],
        "load_ray is declared here, and in package::ray",
    ),
    (
        "intersect",
        &[("fn step_item(", "fn step_item() {}\nfn ‸step_item(")],
        "step_item is declared twice in this file",
    ),
    (
        "intersect",
        &[("has_item(list, item)", "‸hasitem(list, item)")],
        "no definition in scope for identifier: `hasitem`",
    ),
    // Options.
    ("intersect", &[(BODY, "    ‸@else let list = list_of(cell);")], "@else without an @if right before it"),
    ("intersect", &[(BODY, "    ‸@if(fog) let list = list_of(cell);")], "no option is named \"fog\""),
    ("intersect", &[(BODY, "    ‸@if(robust let list = list_of(cell);")], "@if without (expression)"),
    // Syntax.
    ("intersect", &[("texel, 3).x;\n    let list", "texel, 3).x\n    ‸let list")], "expected `;`"),
    (
        "intersect",
        &[("return tag;\n}\n\n@compute", "return tag;\n\n@compute"), ("fn step_item(", "‸fn step_item(")],
        "does not end",
    ),
    (
        "traverse_grid",
        &[("import package::constants", "‸enable f16;\nimport package::constants")],
        "neither an import nor a declaration",
    ),
    // Types and functions.
    ("intersect", &[("let cell = ", "let ‸cell: f32 = ")], "the type of `cell` is expected to be `f32`, but got `u32`"),
    ("intersect", &[("load_ray(texel)", "‸load_ray(texel, 1u)")], "Requires 1 arguments, but 2 are provided"),
    ("intersect", &[("vertex(entry.triangle, 0u)", "vertex(entry.triangle, ‸0.5)")], "u32"),
    (
        "intersect",
        &[("fn step_item(", "fn ‸step_item("), (BODY, "    _ = step_item(texel);\n    let list = list_of(cell);")],
        "declaration of `step_item` is recursive",
    ),
    (
        "intersect",
        &[("return tag;\n}\n\n@compute", "}\n\n@compute"), ("fn step_item(", "‸fn step_item(")],
        "a way through step_item ends without a return",
    ),
    ("traverse_grid", &[("!walk.inside", "!walk.‸outside")], "invalid field accessor `outside`"),
    (
        "traverse_grid",
        &[("var walk", "let walk"), ("@else walk = advance", "@else ‸walk = advance")],
        "invalid left-hand side of assignment",
    ),
    ("traverse_grid", &[("load_per_axis(texel), true)", "true)"), ("= Walk(", "= ‸Walk(")], "3 components"),
];

/// The text without the mark, and the line, column and text of the line that has it.
fn unmarked(text: &str) -> (String, Option<(usize, usize, String)>) {
    let here = text.lines().enumerate().find_map(|(index, line)| {
        let (before, after) = line.split_once(HERE)?;
        Some((index + 1, before.chars().count() + 1, format!("{before}{after}")))
    });
    (text.replace(HERE, ""), here)
}

#[test]
fn every_mistake_is_named_with_its_place() {
    let scene = generate::cornell_box();
    let options = Options {
        accelerator: Accelerator::Grid,
        schedule: ScheduleKind::Compact,
        steps_per_pass: 1,
        ..options_of(&scene)
    };
    let (plan, _) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
    let lists = live::lists(&kernels_of(&plan), &plan.features);
    let mut faults = String::new();
    for (name, edits, message) in MISTAKES {
        let kernel = plan.program.kernel(name).expect("a kernel");
        let mut source = kernel.info().wgsl.to_owned();
        for (from, to) in *edits {
            assert!(source.contains(from), "{name} has no {from:?}");
            source = source.replacen(from, to, 1);
        }
        // The place is also right after characters of several bytes and a tab, and where lines end as on Windows.
        let below_unicode = source.replacen(HERE, "/* Dreieck △ größer 世界 */\t‸", 1);
        let on_windows = below_unicode.replace('\n', "\r\n");
        for (how, text) in [("as it is", source), ("unicode", below_unicode), ("windows", on_windows)] {
            let (text, here) = unmarked(&text);
            let lists = live::lists_of(kernel, &lists);
            let Err(found) = replaced(kernel, &plan.features, &lists, &text) else {
                _ = writeln!(faults, "{edits:?} {how}: it is accepted");
                continue;
            };
            let Place { line, column, text, .. } = found.place.clone();
            let place = (line > 0).then_some((line, column, text));
            if place != here || !found.message.contains(message) {
                _ = writeln!(faults, "{edits:?} {how}: {found} {place:?}; expected {here:?} and {message:?}");
            }
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// Each function calls the one before it twice: few lines, and more statements than a driver could ever compile.
#[test]
fn calls_that_double_are_refused_at_once() {
    let mut functions = String::from("fn twice_0(x: f32) -> f32 {\n    return x + 1.0;\n}\n\n");
    for depth in 1..60 {
        let below = depth - 1;
        write!(
            functions,
            "fn twice_{depth}(x: f32) -> f32 {{\n    return twice_{below}(x) + twice_{below}(2.0 * x);\n}}\n\n"
        )
        .expect("a text");
    }
    let with = |depth: usize| {
        let own = TRAVERSE_GRID.info().wgsl;
        let call = format!(
            "    if (twice_{depth}(walk.tmax.x) < 0.0) {{\n        return NOBODY;\n    }}\n    if (!walk.inside) {{"
        );
        let source = own.replacen("fn step_cell", &format!("{functions}fn step_cell"), 1);
        let source = source.replacen("    if (!walk.inside) {", &call, 1);
        replaced(TRAVERSE_GRID, &Features { grid: true, ..Features::default() }, &[], &source)
    };
    with(8).expect("few");
    let mistake = with(59).expect_err("too many");
    assert!(mistake.message.contains("more than 131072 statements"), "{mistake}");
}

#[test]
fn an_excerpt_has_a_caret_below_the_place() {
    let place = |column, text: &str| Place { file: "my.wgsl".into(), line: 7, column, text: text.into() };
    let excerpt = |place| Mistake { place, message: "it is wrong".into() }.excerpt();
    // A tab before the place is a tab before the caret, whatever its width.
    assert_eq!(excerpt(place(5, "\té = x;  ")).as_deref(), Some("    \té = x;\n    \t   ^"));
    assert_eq!(excerpt(place(1, "x")).as_deref(), Some("    x\n    ^"));
    assert_eq!(excerpt(Place { line: 0, ..place(0, "") }), None);
    let mistake = Mistake { place: place(5, "x"), message: "it is wrong".into() };
    assert_eq!(mistake.to_string(), "my.wgsl:7:5: it is wrong");
}

/// Options with which every kernel of elements is in some run.
fn option_sets(scene: &Scene) -> Vec<Options> {
    let base = options_of(scene);
    let mut all = Vec::new();
    for &integrator in Integrator::ALL {
        for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
            for (schedule, steps_per_pass) in [
                (ScheduleKind::Second, 1),
                (ScheduleKind::Compact, 1),
                (ScheduleKind::Compact, 8),
                (ScheduleKind::Fused, 1),
            ] {
                let one = Options { integrator, accelerator, schedule, steps_per_pass, ..base.clone() };
                all.push(one.clone());
                let samples = Samples { count: 32, ..Samples::default() };
                all.push(Options { counters: true, samples, ..one.clone() });
                if integrator == Integrator::Local && accelerator == Accelerator::Grid {
                    all.push(Options { order: Order::Exact, ..one.clone() });
                    all.push(Options { numerics: Numerics::Paper, ..one });
                }
            }
        }
    }
    all
}

/// A user who changes nothing gets the same shader with the same bindings, and each of its words has its place in the file.
#[test]
fn our_own_kernels_are_taken_back_as_they_are() {
    let scene = generate::whitted(1).expect("a scene");
    let (mut seen, mut kernels) = (HashSet::new(), BTreeSet::new());
    for options in option_sets(&scene) {
        // Not every schedule has every structure.
        let Ok((plan, _)) = Plan::new(&scene, &options, &Limits::CPU) else { continue };
        let lists = live::lists(&kernels_of(&plan), &plan.features);
        for kernel in kernels_of(&plan).into_iter().filter(|kernel| can_be_replaced(*kernel)) {
            let lists = live::lists_of(kernel, &lists);
            if !seen.insert((kernel, kernel.features(&plan.features), lists.clone())) {
                continue;
            }
            kernels.insert(kernel.info().name);
            let own = Variant::new(kernel, &plan.features, &lists).expect("a variant");
            let back = replaced(kernel, &plan.features, &lists, kernel.info().wgsl);
            let back = back.unwrap_or_else(|mistake| panic!("{}: {mistake}", own.label()));
            assert_eq!(back.bindings, own.bindings, "{}", own.label());
            assert_eq!((&back.structs, &back.arrays), (&own.structs, &own.arrays), "{}", own.label());
            assert!(code_of(&back) == code_of(&own), "{}:\n{}\n{}", own.label(), back.source, own.source);
            assert_places(&back);
        }
    }
    let all = programs::all().flat_map(|program| program.kernels()).filter(|kernel| can_be_replaced(*kernel));
    let missing: BTreeSet<_> = all.map(|kernel| kernel.info().name).filter(|name| !kernels.contains(name)).collect();
    assert!(missing.is_empty(), "{missing:?} were in no run");
}

fn can_be_replaced(kernel: Kernel) -> bool {
    kernel.course().is_some() && matches!(kernel.info().twin, Twin::Element { .. })
}

/// The words of the composed WGSL, without comments.
fn code_of(variant: &Variant) -> Vec<&str> {
    let code = words(&variant.source).into_iter().filter(|word| word.kind != WordKind::Comment);
    code.map(|word| word.text).collect()
}

fn assert_places(variant: &Variant) {
    let of = variant.replaced.as_ref().expect("a user's");
    let mut own = 0;
    for word in words(&variant.source).iter().filter(|word| word.kind != WordKind::Comment).step_by(3) {
        let Some(place) = of.place(word.start) else { continue };
        let rest: String = place.text.chars().skip(place.column - 1).collect();
        assert!(rest.starts_with(word.text), "{}: {:?} at {place}: {rest:?}", variant.label(), word.text);
        assert_eq!(of.by.source.lines().nth(place.line - 1), Some(&*place.text));
        own += 1;
    }
    assert!(own > 10, "{}: {own} words are the file's own", variant.label());
}
