//! The two walks through a uniform grid.

use std::ops::ControlFlow;

use raystep_kernels::programs::closest_hit::kernels;
use raystep_kernels::programs::closest_hit::streams::{CONTROL, COUNTERS, TMAX};
use raystep_kernels::{
    Accelerator, Device, GridSize, Limits, Numerics, Options, Plan, PlanError, Renderer, ScheduleKind, Traversal,
};
use raystep_tests::{block_on, devices, gpu, options, scene};

/// The hits of a run, and the cells that each ray visits.
fn traced(options: &Options, device: &Device) -> (Vec<Option<(u32, f32)>>, Vec<u32>) {
    let scene = scene("cornell-box.gltf");
    block_on(Some(&gpu()), async {
        let mut renderer = Renderer::new(&scene, options, device).await.expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        let hits = renderer.hits().await.expect("hits");
        let hits = hits.iter().map(|hit| hit.map(|hit| (hit.triangle, hit.t as f32))).collect();
        (hits, renderer.values(COUNTERS).await.expect("counters").layer(0).to_vec())
    })
}

#[test]
fn both_walks_find_the_same_hits_in_the_same_cells() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        for (schedule, steps_per_pass) in
            [(ScheduleKind::Second, 1), (ScheduleKind::Compact, 8), (ScheduleKind::Fused, 1)]
        {
            let base = Options { schedule, steps_per_pass, counters: true, ..options(&scene, 96, 96) };
            let base = Options { numerics: Numerics::Paper, grid: GridSize::Cells([20; 3]), ..base };
            let (hits, cells) = traced(&base, &device);
            let (found, visited) = traced(&Options { traversal: Traversal::Dda3d, ..base }, &device);
            let count = |n: usize| n * 1000 / hits.len();
            // A ray that rounding sends around an edge of a cell the other way visits one cell more, or less; or misses
            // the triangle there, as the paper's rules accept a hit only in its own cell.
            let other = visited.iter().zip(&cells).filter(|(a, b)| a != b).count();
            let differing = found.iter().zip(&hits).filter(|(a, b)| a != b).count();
            assert!(count(other) < 2 && count(differing) < 2, "{name} {schedule}: {other} cells, {differing} hits");
            assert!(hits.iter().flatten().count() > 9000 && cells.iter().max() > Some(&10), "{name} {schedule}");
        }
    }
}

#[test]
fn a_3d_dda_keeps_control_terms_and_no_t() {
    let scene = scene("cornell-box.gltf");
    let base = Options { numerics: Numerics::Paper, traversal: Traversal::Dda3d, ..options(&scene, 16, 16) };
    let plan = |options: &Options| Plan::new(&scene, options, &Limits::CPU).map(|(plan, _)| plan);
    for (schedule, steps_per_pass) in [(ScheduleKind::First, 1), (ScheduleKind::Compact, 8)] {
        let plan = plan(&Options { schedule, steps_per_pass, ..base.clone() }).expect("a plan");
        assert!(plan.has_stream(CONTROL) && !plan.has_stream(TMAX), "{schedule}");
        let without = plan.left_out.iter().find(|left_out| left_out.what == "stream tmax").expect("left out");
        assert_eq!(without.reason, "needed only with --traversal amanatides-woo");
    }
    // Without it, a run compiles nothing of it.
    let without = plan(&Options { traversal: Traversal::AmanatidesWoo, ..base.clone() }).expect("a plan");
    let setup = without.variant(kernels::SETUP).expect("setup");
    assert!(without.has_stream(TMAX) && !without.has_stream(CONTROL) && !setup.source.contains("control"));
    for (accelerator, numerics) in [
        (Accelerator::Bvh, Numerics::Paper),
        (Accelerator::None, Numerics::Paper),
        (Accelerator::Auto, Numerics::Paper),
        (Accelerator::Grid, Numerics::Robust),
    ] {
        let refused = plan(&Options { accelerator, numerics, ..base.clone() });
        assert!(
            matches!(&refused, Err(PlanError::Refused(why)) if why.starts_with("--traversal 3d-dda")),
            "{accelerator} {numerics}"
        );
    }
}
