//! `cargo run --release -p raystep-tests --example watertight -- [RAYS]`: rays from inside a closed mesh, aimed at its
//! vertices and edges, at scales from 1e-6 to 1e6, through grid and BVH, on the GPU and on the CPU; prints the number
//! of misses.

use raystep_kernels::GridSize;
use raystep_tests::configurations::FAST;
use raystep_tests::{devices, watertight};

fn main() {
    let rays: usize = std::env::args().nth(1).map_or(10_000_000, |v| v.parse().expect("a number of rays"));
    const CHUNK: usize = 1 << 20;
    let mut all = 0;
    for (name, device) in devices() {
        for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6, 0.7] {
            let scene = watertight::closed_mesh(scale);
            for configuration in FAST {
                let (mut missed, mut done, mut seed) = (0, 0, 1);
                while done < rays {
                    let count = CHUNK.min(rays - done);
                    missed += watertight::misses(&device, &scene, configuration, count, GridSize::Auto, seed);
                    (done, seed) = (done + count, seed + 4);
                }
                println!("{name}, scale {scale:e}, {configuration}: {missed} of {done} rays missed");
                all += missed;
            }
        }
    }
    std::process::exit(i32::from(all > 0));
}
