//! One-step parity of every kernel on every scene: GPU and twin, from the same streams.

use raystep_kernels::kernel::KERNELS;
use raystep_kernels::{Accelerator, Numerics, ScheduleKind};
use raystep_tests::{gpu, options, parity, scene, scene_files};

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let gpu = gpu();
    let mut failures = Vec::new();
    let (mut passes, mut components, mut tolerated) = (0, 0, 0);
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
            seen.extend(found.kernels);
            failures.extend(found.breaches.iter().map(|b| format!("{file} {accelerator} {numerics}: {b}")));
        }
    }
    println!("{passes} passes, {components} components compared, {tolerated} within tolerance but not equal");
    assert!(failures.is_empty(), "{} breaches:\n{}", failures.len(), failures.join("\n"));
    for info in KERNELS {
        assert!(seen.contains(&info.kernel), "no ray was ever in {}", info.name);
    }
}
