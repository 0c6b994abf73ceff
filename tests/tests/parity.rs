//! One-step parity of every kernel on every scene: GPU and twin, from the same streams.

use std::collections::BTreeSet;

use raystep_kernels::kernel::KERNELS;
use raystep_kernels::state::{self, TRANSITIONS};
use raystep_kernels::{Accelerator, GridSize, Kernel, Numerics, Renderer, ScheduleKind, Stream};
use raystep_tests::ways::stepped;
use raystep_tests::{block_on, devices, gpu, options, parity, scene, scene_files};

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let gpu = gpu();
    let mut failures = Vec::new();
    let (mut passes, mut components, mut tolerated, mut undecided) = (0, 0, 0, 0);
    let mut seen = Vec::new();
    let (mut rays, mut taken) = (0, BTreeSet::new());
    for file in scene_files() {
        let scene = scene(&file);
        for (accelerator, numerics) in [
            (Accelerator::Grid, Numerics::Robust),
            (Accelerator::Grid, Numerics::Paper),
            (Accelerator::None, Numerics::Robust),
            (Accelerator::None, Numerics::Paper),
        ] {
            if accelerator == Accelerator::None && scene.triangles.len() > 100 {
                continue;
            }
            let mut options = options(&scene, 45, 37);
            (options.accelerator, options.numerics, options.counters) = (accelerator, numerics, true);
            options.schedule = if numerics == Numerics::Paper { ScheduleKind::First } else { ScheduleKind::Second };
            let found = parity::compare(&gpu, &scene, &options);
            passes += found.passes;
            components += found.components;
            tolerated += found.tolerated;
            undecided += found.undecided;
            seen.extend(found.kernels);
            rays += found.rays;
            taken.extend(found.transitions);
            failures.extend(found.breaches.iter().map(|b| format!("{file} {accelerator} {numerics}: {b}")));
        }
    }
    println!(
        "{passes} passes, {components} components compared: {tolerated} equal but for rounding, {undecided} rays undecided"
    );
    // A ray is near an edge or a face by less than some 40 roundings of 2⁻²⁴ once in 10,000 tests of one triangle
    // that fills the view; most are farther.
    assert!(undecided * 10_000 < rays, "{undecided} of {rays} rays undecided");
    assert!(failures.is_empty(), "{} breaches:\n{}", failures.len(), failures.join("\n"));
    for info in KERNELS {
        assert!(seen.contains(&info.kernel), "no ray was ever in {}", info.name);
    }
    // The table of transitions is what happens: nothing else, and all of it.
    let listed: BTreeSet<_> = TRANSITIONS.iter().map(|t| (t.from, t.kernel, t.to)).collect();
    let named = |ways: Vec<&(u32, Kernel, u32)>| {
        ways.iter().map(|w| format!("{} {} {}", state::name(w.0), w.1.name(), state::name(w.2))).collect::<Vec<_>>()
    };
    assert_eq!(named(taken.difference(&listed).collect()), [""; 0], "taken, but not listed");
    // The grid's box is a margin larger than the scene, so no hit of a real scene is left over when a ray leaves it:
    // see the next test.
    let missing = named(listed.difference(&taken).collect());
    assert_eq!(missing, ["TRAV traverse_grid SHADE"], "listed, but never taken");
}

#[test]
fn a_hit_that_is_kept_survives_leaving_the_grid() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        let mut options = stepped(&scene, 16, 16);
        options.grid = GridSize::Cells([1; 3]);
        let gpu = gpu();
        block_on(Some(&gpu), async {
            let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
            renderer.step().await.expect("generate");
            renderer.step().await.expect("setup");
            let mut values = renderer.values(Stream::State).await.expect("state");
            let rays = 16 * 16;
            values.bits[..rays].fill(state::TRAV);
            values.bits[rays..2 * rays].fill(0.5f32.to_bits());
            assert!(renderer.write(&values));
            assert_eq!(renderer.live()[state::TRAV as usize], 256, "{name}");
            while renderer.step().await.expect("a pass").is_some_and(|p| p.kernel != Kernel::TraverseGrid) {}
            assert_eq!(renderer.live()[state::SHADE as usize], 256, "{name}");
        });
    }
}

/// Every kernel is broken once, in its WGSL only, and the comparison must name it.
#[test]
fn a_broken_kernel_is_named() {
    let gpu = gpu();
    let scene = scene("cornell-box.gltf");
    let breaks: [(Kernel, &str, &str); 8] = [
        (Kernel::Generate, "0.5", "0.4995"),
        (Kernel::Setup, "floor(position)", "ceil(position)"),
        (Kernel::Setup, "vec4u(ISECT_NO_HIT)", "vec4u(BACKGROUND)"),
        (Kernel::TraverseGrid, "select(vec3i(-1), vec3i(1)", "select(vec3i(1), vec3i(-1)"),
        (Kernel::TraverseGrid, "tmax.x < tmax.y && ", ""),
        (Kernel::Intersect, "nearest_t <= exit", "nearest_t < 0.5 * exit"),
        (Kernel::Intersect, "weight_b * inverse,", "weight_a * inverse,"),
        (Kernel::Shade, "max(dot3(normal, to_light), 0.0)", "abs(dot3(normal, to_light))"),
    ];
    for (kernel, from, to) in breaks {
        let mut options = options(&scene, 40, 40);
        // Not a number of cells that puts the eye on a plane, where floor and ceil agree.
        options.grid = GridSize::Cells([7, 7, 9]);
        let found = parity::compare_with(&gpu, &scene, &options, |plan| {
            let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("in the plan");
            // WESL prints expressions its own way, so spaces do not count.
            let broken = replace_ignoring_layout(&variant.source, from, to);
            assert_ne!(broken, variant.source, "{from:?} is not in\n{}", variant.source);
            variant.source = broken;
        });
        let first = found.breaches.first().unwrap_or_else(|| panic!("{} with {to:?} went unnoticed", kernel.name()));
        assert_eq!(first.kernel, kernel, "{first}");
        println!("{} with {to:?}: {first}", kernel.name());
    }
}

/// Replaces every place where the letters of `from` follow one another, whatever white space lies between.
fn replace_ignoring_layout(source: &str, from: &str, to: &str) -> String {
    let wanted: Vec<char> = from.chars().filter(|c| !c.is_whitespace()).collect();
    let mut out = String::new();
    let mut rest = source;
    'outer: while !rest.is_empty() {
        let mut matched = wanted.iter();
        for (at, c) in rest.char_indices() {
            if c.is_whitespace() && at > 0 {
                continue;
            }
            match matched.next() {
                Some(&w) if w == c => {
                    if matched.as_slice().is_empty() {
                        out.push_str(to);
                        rest = &rest[at + c.len_utf8()..];
                        continue 'outer;
                    }
                }
                _ => break,
            }
        }
        let first = rest.chars().next().unwrap_or(' ');
        out.push(first);
        rest = &rest[first.len_utf8()..];
    }
    out
}
