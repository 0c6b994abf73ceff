//! One-step parity of every kernel on every scene: GPU and twin, from the same streams.

use raystep_kernels::kernel::KERNELS;
use raystep_kernels::{Accelerator, GridSize, Kernel, Numerics, ScheduleKind};
use raystep_tests::{gpu, options, parity, scene, scene_files};

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let gpu = gpu();
    let mut failures = Vec::new();
    let (mut passes, mut components, mut tolerated, mut undecided) = (0, 0, 0, 0);
    let mut seen = Vec::new();
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
            failures.extend(found.breaches.iter().map(|b| format!("{file} {accelerator} {numerics}: {b}")));
        }
    }
    println!(
        "{passes} passes, {components} components compared: {tolerated} equal but for rounding, {undecided} rays undecided"
    );
    // A ray is near an edge or a face by less than some 30 roundings once in 10,000 tests, by far less on most scenes.
    assert!(undecided * 10_000 < components, "{undecided} rays undecided");
    assert!(failures.is_empty(), "{} breaches:\n{}", failures.len(), failures.join("\n"));
    for info in KERNELS {
        assert!(seen.contains(&info.kernel), "no ray was ever in {}", info.name);
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
            // WESL prints expressions its own way, so spaces and brackets do not count.
            let broken = replace_ignoring_layout(&variant.source, from, to);
            assert_ne!(broken, variant.source, "{from:?} is not in\n{}", variant.source);
            variant.source = broken;
        });
        let first = found.breaches.first().unwrap_or_else(|| panic!("{} with {to:?} went unnoticed", kernel.name()));
        assert_eq!(first.kernel, kernel, "{first}");
        println!("{} with {to:?}: {first}", kernel.name());
    }
}

/// Replaces every place where the letters of `from` follow one another, whatever white space and
/// parentheses lie between them.
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
