//! Kernels of a user's own: those that do what ours do leave the same bits; typical mistakes are found by comparison, with pass,
//! pixel, stream, value and line; and what does not end is ended, on a device that works afterwards.

mod printed;

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::options::Integrator;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::programs::closest_hit::PROGRAM;
use raystep_kernels::programs::closest_hit::streams::{COLOR, HIT, STATE};
use raystep_kernels::{Accelerator, Device, GpuError, Numerics, Options, RenderError, Renderer, ScheduleKind};
use raystep_lab::check_kernel::{Difference, Outcome, check_kernel};
use raystep_lab::divergence::divergence;
use raystep_scenes::{Scene, generate};
use raystep_tests::{block_on, devices, gpu, gpu_of, options, values};

/// Single steps through the grid, for which there are all kernels of the paper.
fn single_steps(scene: &Scene) -> Options {
    Options {
        accelerator: Accelerator::Grid,
        schedule: ScheduleKind::Compact,
        steps_per_pass: 1,
        ..options(scene, 16, 12)
    }
}

/// A kernel of ours in which a text is replaced by another, as a user's file.
fn own(kernel: &str, from: &str, to: &str) -> Arc<Replacement> {
    let wgsl = PROGRAM.kernel(kernel).expect("a kernel").info().wgsl;
    assert!(wgsl.contains(from), "{kernel} has no {from:?}");
    let source = wgsl.replacen(from, to, 1);
    Arc::new(Replacement { kernel: kernel.into(), file: format!("my-{kernel}.wgsl"), source })
}

fn unchanged(kernel: &str) -> Arc<Replacement> {
    own(kernel, "fn ", "fn ")
}

fn run(scene: &Scene, options: &Options, device: &Device) -> Result<Renderer, RenderError> {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, options, device).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        Ok(renderer)
    })
}

fn checked(scene: &Scene, by: Arc<Replacement>, device: &Device) -> Outcome {
    let options = Options { replaced: vec![by], ..single_steps(scene) };
    block_on(gpu_of(device), check_kernel(scene, &options, device)).expect("a comparison")
}

fn difference(scene: &Scene, by: Arc<Replacement>, device: &Device) -> Difference {
    match checked(scene, by, device) {
        Outcome::Differs(difference) => *difference,
        other => panic!("{other:?}"),
    }
}

/// The line, from 1, of a user's file that has this text.
fn line_of(by: &Replacement, text: &str) -> usize {
    1 + by.source.lines().position(|line| line.contains(text)).unwrap_or_else(|| panic!("no line has {text:?}"))
}

/// Several at once, one of them with loops, which are guarded on a GPU.
#[test]
fn our_own_kernels_given_back_leave_the_same_bits() {
    let scene = generate::cornell_box();
    let steps = single_steps(&scene);
    let several = Options { steps_per_pass: 8, ..steps.clone() };
    let fused = Options { schedule: ScheduleKind::Fused, ..steps.clone() };
    let shadows = Options { integrator: Integrator::Shadows, schedule: ScheduleKind::Second, ..steps.clone() };
    for (options, kernels) in [
        (steps, &["generate", "setup", "traverse_grid", "intersect", "shade"][..]),
        (several, &["walk"]),
        (fused, &["fused"]),
        (shadows, &["traverse_grid", "intersect"]),
    ] {
        for (name, device) in devices() {
            let label = format!("{kernels:?} on {name}");
            let replaced: Vec<_> = kernels.iter().map(|kernel| unchanged(kernel)).collect();
            let expected = run(&scene, &options, &device).expect("a run");
            let found = run(&scene, &Options { replaced, ..options.clone() }, &device).expect("a run");
            assert_eq!(found.plan().replaced().len(), kernels.len(), "{label}");
            assert_eq!(found.pass_count(), expected.pass_count(), "{label}");
            for stream in [STATE, HIT, COLOR] {
                assert!(values(&found, stream).bits == values(&expected, stream).bits, "{label}: {stream:?}");
            }
        }
    }
}

/// A mistake, and what is said about the first ray that is treated otherwise.
struct Mistake {
    kernel: &'static str,
    from: &'static str,
    to: &'static str,
    /// Stream and layer.
    at: (&'static str, &'static str),
    value: &'static str,
    expected: &'static str,
    /// In the line that stored the value; `None` if none did.
    stored: Option<&'static str>,
}

#[test]
fn other_values_are_reported_with_the_line_that_stored_them() {
    let scene = generate::cornell_box();
    let tag = "textureStore(state, texel, 0, vec4u(tag))";
    let item = "textureStore(state, texel, 3, vec4u(item))";
    for Mistake { kernel, from, to, at, value, expected, stored } in [
        // The second triangle of every list is left out.
        Mistake {
            kernel: "intersect",
            from: "item += 1u",
            to: "item += 2u",
            at: ("state", "item"),
            value: "2",
            expected: "1",
            stored: Some(item),
        },
        Mistake {
            kernel: "intersect",
            from: "    textureStore(state, texel, 3, vec4u(item));\n",
            to: "",
            at: ("state", "item"),
            value: "0",
            expected: "1",
            stored: None,
        },
        // An item that never advances.
        Mistake {
            kernel: "intersect",
            from: item,
            to: "textureStore(state, texel, 3, vec4u(0u))",
            at: ("state", "item"),
            value: "0",
            expected: "1",
            stored: Some("textureStore(state, texel, 3, vec4u(0u))"),
        },
        Mistake {
            kernel: "intersect",
            from: "tag = ISECT_HIT;",
            to: "tag = SHADE;",
            at: ("state", "tag"),
            value: "SHADE",
            expected: "ISECT_HIT",
            stored: Some(tag),
        },
        Mistake {
            kernel: "intersect",
            from: "bitcast<u32>(candidate.u)",
            to: "bitcast<u32>(candidate.v)",
            at: ("hit", "u"),
            value: "",
            expected: "",
            stored: Some("bitcast<u32>(candidate.v)"),
        },
    ] {
        let by = own(kernel, from, to);
        for (name, device) in devices() {
            let found = difference(&scene, by.clone(), &device);
            let label = format!("{to:?} on {name}: {found:?}");
            assert_eq!((found.stream, found.layer), at, "{label}");
            if !value.is_empty() {
                assert_eq!((&*found.value, &*found.expected), (value, expected), "{label}");
            }
            assert!(found.value != found.expected && found.rays > 0, "{label}");
            // Every ray's first pass of intersect comes after its setup.
            assert!(found.pass >= 2 && found.pixel[0] < 16 && found.pixel[1] < 12, "{label}");
            match (stored, &found.stored) {
                (None, None) => {}
                (Some(text), Some(line)) => {
                    assert_eq!((&*line.file, line.line), (&*by.file, line_of(&by, text)), "{label}");
                    assert!(line.text.contains(text), "{label}");
                }
                _ => panic!("{label}"),
            }
            let decided = found.decided.as_ref().unwrap_or_else(|| panic!("{label}"));
            assert!(!decided.how.is_empty() && !decided.at.text.is_empty(), "{label}");
        }
    }
}

/// A scene whose triangles are all there twice: every hit is a tie, which goes to the triangle of the lower number.
fn doubled() -> Scene {
    let mut scene = generate::cornell_box();
    scene.triangles.extend_from_within(..);
    scene.triangle_materials.extend_from_within(..);
    scene
}

#[test]
fn ties_resolved_otherwise_are_found_in_a_scene_that_has_them() {
    let nearer = "is_nearer(candidate.t, entry.triangle, nearest_t, textureLoad(hit, texel, 2).x)";
    let in_cell = "let accepted = candidate.t < nearest_t\n";
    let scene = doubled();
    let count = scene.triangles.len() / 2;
    for (numerics, from, to) in [
        (Numerics::Robust, nearer, "(candidate.t <= nearest_t)"),
        (Numerics::Paper, in_cell, "let accepted = candidate.t <= nearest_t\n"),
    ] {
        let by = own("intersect", from, to);
        let options = |scene| Options { numerics, replaced: vec![by.clone()], ..single_steps(scene) };
        let check = |scene, device: &Device| block_on(gpu_of(device), check_kernel(scene, &options(scene), device));
        let outcome = check(&scene, &Device::Cpu(None));
        let Ok(Outcome::Differs(found)) = outcome else { panic!("{numerics}: {outcome:?}") };
        assert_eq!((found.stream, found.layer), ("hit", "triangle"), "{numerics}: {found:?}");
        let [value, expected] = [&found.value, &found.expected].map(|id| id.parse::<usize>().expect("an id"));
        assert_eq!(value, expected + count, "{numerics}: {found:?}");
        let line = found.stored.as_ref().expect("a line");
        assert_eq!(line.line, line_of(&by, "vec4u(entry.triangle)"), "{numerics}: {found:?}");
        // The window's map names the same ray.
        let map = block_on(None, async {
            let mut renderer = Renderer::new(&scene, &options(&scene), &Device::Cpu(None)).await?;
            divergence(&mut renderer, |_| ControlFlow::Continue(())).await
        });
        let map = map.expect("a map");
        let (ray, first) = map.earliest().expect("a difference");
        let [x, y] = [ray as u32 % map.width(), ray as u32 / map.width()];
        assert_eq!((first.pass, [x, y], first.stream), (found.pass, found.pixel, HIT), "{numerics}: {first:?}");
        assert_eq!((first.theirs as usize, first.twin as usize), (value, expected), "{numerics}: {first:?}");
        // A GPU may round so that there is no tie.
        let same = check(&scene, &Device::Gpu(gpu())).expect("a comparison");
        assert!(matches!(same, Outcome::Same { passes, rays } if passes > 2 && rays > 192), "{numerics}: {same:?}");
    }
}

fn message(scene: &Scene, by: Arc<Replacement>, device: &Device) -> String {
    match checked(scene, by, device) {
        Outcome::Fails { message } => message,
        other => panic!("{other:?}"),
    }
}

const LIST: &str = "let list = list_of(cell);";

#[test]
fn what_an_interpreted_kernel_must_not_do_is_reported_with_line_and_pixel() {
    let scene = generate::cornell_box();
    for (from, to, text) in [
        (LIST, "let list = list_of(cell + 100000u);", " is outside of grid_cells, which has "),
        (
            "textureStore(state, texel, 3, vec4u(item))",
            "textureStore(state, texel + vec2u(1u, 0u), 3, vec4u(item))",
            " of state belongs to another element, whose thread runs at the same time",
        ),
        (
            LIST,
            "let list = list_of(cell);\n    while (item < 9u) { _ = item; }",
            "a loop has not ended after 1048576 turns",
        ),
    ] {
        let by = own("intersect", from, to);
        let found = message(&scene, by.clone(), &Device::Cpu(None));
        let line = line_of(&by, to.lines().last().unwrap_or(to).trim());
        assert!(found.starts_with(&format!("my-intersect.wgsl:{line}: ")), "{found}");
        assert!(found.contains(text), "{found}");
        let (_, pixel) = found.split_once(", for the ray of pixel ").expect("a pixel");
        assert!(pixel.split(',').all(|n| n.parse::<u32>().is_ok_and(|n| n < 16)), "{found}");
    }
}

/// A loop without end is ended with its line, and the device still works: the next run has the bits of the one before.
#[test]
fn a_loop_without_end_is_ended_and_the_device_is_not_lost() {
    let scene = generate::cornell_box();
    let options = single_steps(&scene);
    let endless = own("intersect", LIST, "let list = list_of(cell);\n    var n = 1u;\n    while (n > 0u) { n ^= 2u; }");
    for (name, device) in devices() {
        let before = run(&scene, &options, &device).expect("a run");
        let found = message(&scene, endless.clone(), &device);
        let line = line_of(&endless, "while");
        assert!(
            found.starts_with(&format!("my-intersect.wgsl:{line}: a loop has not ended after ")),
            "{name}: {found}"
        );
        // A run that nothing is compared with fails as well.
        let wrong = Options { replaced: vec![endless.clone()], ..options.clone() };
        match run(&scene, &wrong, &device) {
            Err(RenderError::Gpu(GpuError::Endless { place, .. })) => {
                assert_eq!(place, format!("my-intersect.wgsl:{line}"));
            }
            Err(RenderError::Failed(failed)) => assert_eq!(failed.place, format!("my-intersect.wgsl:{line}")),
            other => panic!("{name}: {:?}", other.err()),
        }
        let after = run(&scene, &options, &device).expect("a run");
        for stream in [STATE, HIT, COLOR] {
            assert!(values(&after, stream).bits == values(&before, stream).bits, "{name}: {stream:?}");
        }
    }
}

/// Rays that wait for a kernel for ever are given up at the bound on passes.
#[test]
fn a_kernel_that_never_advances_ends_at_the_bound_on_passes() {
    let scene = generate::cornell_box();
    let stays =
        own("intersect", "textureStore(state, texel, 3, vec4u(item))", "textureStore(state, texel, 3, vec4u(0u))");
    let options = Options { replaced: vec![stays], ..single_steps(&scene) };
    for (name, device) in devices() {
        let renderer = run(&scene, &options, &device).expect("a run");
        let (passes, bound) = (renderer.pass_count() as u64, renderer.plan().pass_bound);
        // The GPU finds out after a batch.
        assert!(passes >= bound && passes < 4 * bound, "{name}: {passes} passes, {bound} at most");
        assert!(renderer.unfinished() > 0, "{name}");
    }
}

/// Our kernels go on with what a user's has stored, whatever that is.
#[test]
fn a_cell_that_there_is_not_has_no_triangles() {
    let scene = generate::cornell_box();
    let by = own("setup", "vec4u(cell_index(walk.cell))", "vec4u(99999u)");
    let options = Options { replaced: vec![by], ..single_steps(&scene) };
    let renderer = run(&scene, &options, &Device::Cpu(None)).expect("a run");
    let hit = block_on(None, renderer.values(HIT)).expect("the hits");
    assert!(hit.layer(2).iter().all(|&triangle| triangle == u32::MAX), "nothing is listed outside of the grid");
}
