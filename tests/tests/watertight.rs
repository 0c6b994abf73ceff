//! No ray passes between two triangles that share an edge, or leaves through the last cell.

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Accelerator, GridSize};
use raystep_tests::configurations::FAST;
use raystep_tests::{devices, options, scene, thorough, traced, values, watertight};

#[test]
fn a_closed_mesh_loses_no_ray_at_any_scale() {
    // 10 million take minutes here: cargo run --release -p raystep-tests --example watertight
    let count = if thorough() { 10_000 } else { 1_200 };
    let scales = if thorough() { &[1e-6, 1e-3, 1.0, 0.7, 1e3, 1e6][..] } else { &[1e-6, 0.7, 1e6] };
    for (name, device) in devices() {
        for &scale in scales {
            let scene = watertight::closed_mesh(scale);
            for configuration in FAST {
                let missed = watertight::misses(&device, &scene, configuration, count, GridSize::Auto, 3);
                assert_eq!(missed, 0, "{name}, scale {scale:e}, {configuration}");
            }
            for configuration in [FAST[0], FAST[2]] {
                let missed = watertight::misses(&device, &scene, configuration, 400, GridSize::Cells([1; 3]), 3);
                assert_eq!(missed, 0, "{name}, scale {scale:e}, {configuration}, one cell");
            }
        }
    }
}

/// Every wall is a face of the scene's box, so every hit on it is at the exit of the last cell.
#[test]
fn walls_that_are_the_bounds_lose_no_ray() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        for cells in [[1, 1, 1], [2, 3, 5], [16, 16, 16], [20, 20, 20], [31, 64, 7]] {
            for configuration in FAST.iter().filter(|configuration| configuration.accelerator == Accelerator::Grid) {
                let mut options = configuration.of(&options(&scene, 256, 256));
                (options.shade, options.grid) = (false, GridSize::Cells(cells));
                let hit = values(&traced(&scene, &options, &device), streams::HIT);
                // The room is open only behind the camera; every ray hits a wall.
                let lost = hit.layer(2).iter().filter(|&&t| t == NO_TRIANGLE).count();
                assert_eq!(lost, 0, "{name} {cells:?} {configuration}");
            }
        }
    }
}
