//! The compact schedule with one step per pass is the paper's second strategy, except for what it launches.

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Accelerator, Device, ScheduleKind};
use raystep_scenes::Scene;
use raystep_tests::configurations::Configuration;
use raystep_tests::{block_on, devices, hits, options, scene, values};

/// The sequence of each ray's states (tag, t, cell or node, item), and the final hits.
fn lives(scene: &Scene, configuration: Configuration, device: &Device) -> (Vec<Vec<[u32; 4]>>, [Vec<u32>; 4]) {
    let mut options = configuration.of(&options(scene, 21, 19));
    options.shade = false;
    let start = raystep_kernels::Renderer::new(scene, &options, device);
    let gpu = match device {
        Device::Gpu(gpu) => Some(&**gpu),
        _ => None,
    };
    let mut renderer = block_on(gpu, start).expect("a renderer");
    let mut lives: Vec<Vec<[u32; 4]>> = vec![Vec::new(); 21 * 19];
    loop {
        let state = values(&renderer, streams::STATE);
        for (ray, life) in lives.iter_mut().enumerate() {
            let now = [0, 1, 2, 3].map(|layer| state.get(layer, ray));
            if life.last() != Some(&now) {
                life.push(now);
            }
        }
        if block_on(gpu, renderer.step()).expect("a pass").is_none() {
            return (lives, hits(&renderer));
        }
    }
}

#[test]
fn one_step_a_pass_is_the_second_strategy_ray_by_ray() {
    for file in ["cornell-box.gltf", "primitives.gltf", "skin-and-morph.gltf", "empty.gltf"] {
        let scene = scene(file);
        for (name, device) in devices() {
            for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
                let second = Configuration::new(accelerator, ScheduleKind::Second, 1);
                let compact = Configuration::new(accelerator, ScheduleKind::Compact, 1);
                for (second, compact) in [(second, compact), (second.skipping(), compact.skipping())] {
                    if compact.accelerator != Accelerator::Grid && compact == compact.skipping() {
                        continue;
                    }
                    let label = format!("{file} {name} {compact}");
                    let [(expected, hits), (found, hits_too)] =
                        [second, compact].map(|configuration| lives(&scene, configuration, &device));
                    let parted = expected.iter().zip(&found).position(|(a, b)| a != b);
                    assert_eq!(parted, None, "{label}: the first ray with another history");
                    assert!(hits == hits_too, "{label}: other hits");
                    assert!(scene.triangles.is_empty() || expected.iter().any(|life| life.len() > 5), "{label}");
                }
            }
        }
    }
}
