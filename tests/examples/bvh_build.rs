//! `cargo run --release -p raystep-tests --example bvh_build -- [TRIANGLES]`: time to build the BVH at each quality,
//! and the cost to trace it, for generated scenes.

use std::time::Instant;

use raystep_kernels::structures::bvh::{self, BvhOptions, BvhQuality};
use raystep_scenes::{Scene, generate};

/// The fastest of this many builds is reported.
const BUILDS: usize = 3;

fn main() {
    let triangles: u64 = std::env::args().nth(1).map_or(1_000_000, |v| v.parse().expect("a number of triangles"));
    let scenes: [(&str, Scene); 5] = [
        ("soup", generate::soup(triangles, 1).expect("soup")),
        ("terrain", generate::terrain(triangles, 1).expect("terrain")),
        ("hair", generate::hair(triangles / 32, 1).expect("hair")),
        ("flake", generate::sphere_flake(4, 3).expect("flake")),
        ("room", generate::tiny_in_room(triangles / 4, 1000).expect("room")),
    ];
    println!(
        "scene    quality   triangles references |   nodes depth    cost seconds |   wide depth    cost repaired seconds"
    );
    for (name, scene) in &scenes {
        let vertices = scene.triangles.as_flattened().as_flattened();
        for quality in BvhQuality::ALL {
            let options = BvhOptions { quality, ..BvhOptions::default() };
            let (tree, seconds) = timed(|| bvh::build(vertices, 1e-6, &options).expect("a tree"));
            let (wide, wide_seconds) = timed(|| bvh::build_wide(vertices, 1e-6, &options).expect("a tree"));
            println!(
                "{name:8} {:9} {:9} {:10} | {:7} {:5} {:7.2} {seconds:7.3} | {:6} {:5} {:7.2} {:8} {wide_seconds:7.3} {:?}",
                format!("{quality:?}"),
                scene.triangles.len(),
                tree.references,
                tree.nodes.len(),
                tree.depth,
                tree.cost,
                wide.nodes.len(),
                wide.depth,
                wide.cost,
                wide.repaired,
                wide.shape,
            );
        }
    }
}

/// The last result, and the shortest time of [`BUILDS`].
fn timed<T>(f: impl Fn() -> T) -> (T, f64) {
    let once = || {
        let start = Instant::now();
        let result = f();
        (result, start.elapsed().as_secs_f64())
    };
    (1..BUILDS).fold(once(), |best, _| {
        let (result, seconds) = once();
        (result, seconds.min(best.1))
    })
}
