//! The order of kernels is data: the first passes of every schedule, and when a plan skips empty cells.

use raystep_kernels::plan::Because;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Accelerator, Device, GridSize, Kernel, Limits, Plan, ScheduleKind, Skip};
use raystep_scenes::{Scene, generate};
use raystep_tests::configurations::{Configuration, STEPPED};
use raystep_tests::{options, scene, traced};

fn letter(kernel: Kernel) -> char {
    match kernel.name() {
        "generate" => 'g',
        "setup" => 's',
        "intersect" => 'i',
        // Step to the next cell or node.
        "traverse_grid" => 'c',
        "traverse_bvh" => 'n',
        "walk" => 'w',
        "fused" => 'f',
        "shade" => '*',
        "accumulate" => '+',
        _ => '?',
    }
}

/// The room has 26 triangles, and a ray visits at most 16 of its 7 × 7 × 9 cells before its hit. The BVH of a single
/// triangle is one leaf, whatever the builder. Kernels of a loop run to the end of the iteration: the last one may have
/// no rays.
#[test]
fn the_first_dozen_passes_are_those_of_the_schedule() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, First, Fused, Second};
    let room = "cornell-box.gltf";
    let one = "single-triangle.gltf";
    for (file, accelerator, schedule, steps, expected) in [
        (room, Grid, Second, 1, "gsicicicicic"),
        (room, Grid, First, 1, "gsicicicicic"),
        (room, Grid, Compact, 1, "gsicicicicic"),
        (room, Grid, Compact, 2, "gswwwwwwww*"),
        (room, Grid, Compact, 8, "gsww*"),
        (room, Grid, Fused, 1, "gf*"),
        (room, Bvh, Second, 1, "gsninininini"),
        (room, Bvh, Compact, 1, "gsninininini"),
        (one, Bvh, Second, 1, "gsnini*"),
        (one, Bvh, First, 1, "gsnin*"),
        (one, Bvh, Compact, 1, "gsnini*"),
        (one, Bvh, Compact, 8, "gsw*"),
        (one, Bvh, Fused, 8, "gf*"),
        (room, None, Second, 1, "gsiiiiiiiiii"),
        (room, None, First, 1, "gsiiiiiiiiii"),
        (room, None, Compact, 1, "gsiiiiiiiiii"),
        (room, None, Compact, 8, "gswwww*"),
        (room, None, Compact, 100, "gsw*"),
        (room, None, Fused, 1, "gf*"),
        (one, None, Second, 1, "gsi*"),
        // Only the compact schedule takes several steps per pass.
        (room, Grid, Second, 8, "gsicicicicic"),
        (one, Bvh, First, 8, "gsnin*"),
    ] {
        let (scene, configuration) = (scene(file), Configuration::new(accelerator, schedule, steps));
        let mut options = configuration.of(&options(&scene, 8, 8));
        options.grid = GridSize::Cells([7, 7, 9]);
        let renderer = traced(&scene, &options, &Device::Cpu(Option::None));
        let passes: String = renderer.passes().iter().take(12).map(|p| letter(p.kernel)).collect();
        assert_eq!(passes, expected, "{file} {configuration}");
        // Every kernel in the plan is in the schedule, and every one of them ran. Counting has no step of its own: it
        // runs within another kernel's pass.
        let variants = renderer.plan().variants.iter().map(|v| v.kernel);
        let planned: Vec<Kernel> = variants.filter(|kernel| kernel.role() != Role::Count).collect();
        assert_eq!(renderer.plan().schedule.kernels(), planned, "{file} {configuration}");
        let never = planned.iter().find(|&&k| renderer.passes().iter().all(|p| p.kernel != k));
        assert_eq!(never, Option::None, "{file} {configuration}: planned, but never run");
    }
}

/// Whether a plan skips empty cells, or why not.
fn leaps(
    scene: &Scene,
    configuration: Configuration,
    skip: Skip,
    grid: GridSize,
) -> Result<(), (Because, &'static str)> {
    let mut options = configuration.of(&options(scene, 8, 8));
    (options.skip, options.grid) = (skip, grid);
    let (plan, data) = Plan::new(scene, &options, &Limits::CPU).expect("a plan");
    let left_out = plan.left_out.iter().find(|l| l.what == "buffer grid_distances");
    let is_bound = plan.variants.iter().flat_map(|v| &v.bindings).any(|b| b.name == "grid_distances");
    let is_planned = plan.buffers.iter().any(|b| b.what == "grid_distances");
    assert_eq!(plan.features.skip, is_bound, "{configuration} {skip}");
    assert_eq!((is_planned, left_out.is_none()), (is_bound, is_bound), "{configuration} {skip}\n{plan}");
    assert_eq!(!data.grid_distances.is_empty(), is_bound, "{configuration} {skip}: distances");
    left_out.map_or(Ok(()), |l| Err((l.because, l.reason)))
}

#[test]
fn rays_leap_where_most_cells_are_empty_and_the_plan_says_why_not() {
    let (sparse, dense) = (scene("teapot.glb"), generate::soup(5_000, 1).expect("a small scene"));
    let dense_grid = GridSize::Cells([5; 3]);
    let compact = Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 8);
    for configuration in [compact, STEPPED, Configuration::new(Accelerator::Grid, ScheduleKind::Fused, 1)] {
        assert_eq!(leaps(&sparse, configuration, Skip::Auto, GridSize::Auto), Ok(()), "{configuration}");
        assert_eq!(leaps(&dense, configuration, Skip::On, dense_grid), Ok(()), "{configuration}");
        let crowded = leaps(&dense, configuration, Skip::Auto, dense_grid);
        assert_eq!(crowded, Err((Because::Scene, "too few cells are empty for --skip auto")), "{configuration}");
        let (because, reason) =
            leaps(&sparse, configuration, Skip::Off, GridSize::Auto).expect_err("no empty-space skipping");
        assert!(because == Because::Options && reason.contains("--skip on"), "{configuration}: {reason}");
    }
    for accelerator in [Accelerator::Bvh, Accelerator::None] {
        let configuration = Configuration { accelerator, ..compact };
        let (_, reason) = leaps(&sparse, configuration, Skip::On, GridSize::Auto).expect_err("no grid");
        assert_eq!(reason, "needed only with --accelerator grid", "{accelerator}");
    }
}
