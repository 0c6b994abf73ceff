//! `cargo run --release -p raystep-tests --example grid_build -- [TRIANGLES …]`: time and memory to build the grid for
//! soups.

use std::time::Instant;

use raystep_kernels::structures::grid::{self, GridSize};
use raystep_scenes::generate;

fn main() {
    let given: Vec<u64> = std::env::args().skip(1).map(|v| v.parse().expect("a number of triangles")).collect();
    for triangles in if given.is_empty() { vec![10_000, 100_000, 1_000_000] } else { given } {
        let scene = generate::soup(triangles, 1).expect("soup");
        let vertices = scene.triangles.as_flattened().as_flattened();
        let mut times = Vec::new();
        let mut built = None;
        for _ in 0..5 {
            let start = Instant::now();
            built = Some(grid::build(vertices, GridSize::Auto, 4.0, u64::MAX).expect("a grid"));
            times.push(start.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        let built = built.expect("five builds");
        let stats = built.stats(vertices);
        println!(
            "{triangles} triangles: {:?} cells, {} references ({:.3}% from growth), lists {:.1} MB, median {:.3} s of 5",
            built.grid.cells,
            stats.references,
            100.0 * stats.added_by_growth as f64 / stats.references as f64,
            built.bytes() as f64 / 1e6,
            times[2]
        );
    }
}
