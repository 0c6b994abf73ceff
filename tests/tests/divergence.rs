//! The divergence map: it names a broken kernel and its pass, and a correct device never diverges.

use std::ops::ControlFlow;

use raystep_kernels::programs::closest_hit::streams::STATE_T;
use raystep_kernels::programs::closest_hit::{kernels, streams};
use raystep_kernels::{Accelerator, Device, GridSize, Kernel, Limits, Options, Plan, Renderer, ScheduleKind};
use raystep_lab::divergence::{Against, Class, DivergenceMap, divergence};
use raystep_tests::configurations::{Configuration, STEPPED};
use raystep_tests::{block_on, gpu, options, scene};

/// The room, with a grid resolution at which the eye does not lie on a plane.
fn room(configuration: Configuration) -> Options {
    let options = configuration.of(&options(&scene("cornell-box.gltf"), 40, 40));
    Options { counters: true, grid: GridSize::Cells([7, 7, 9]), ..options }
}

fn compared(options: &Options, change: impl FnOnce(&mut Plan)) -> DivergenceMap {
    let gpu = gpu();
    block_on(Some(&gpu), async {
        let limits = Limits::from(&*gpu);
        let (mut plan, data) = Plan::new(&scene("cornell-box.gltf"), options, &limits).expect("a plan");
        change(&mut plan);
        let device = Device::Gpu(gpu.clone());
        let mut renderer = Renderer::from_plan(plan, data, options, &device).await.expect("a renderer");
        divergence(&mut renderer, |_| ControlFlow::Continue(())).await.expect("a run")
    })
}

/// Changes only a kernel's WGSL. The text must be on a single line there.
fn change(kernel: Kernel, from: &'static str, to: &'static str) -> impl FnOnce(&mut Plan) {
    move |plan| {
        let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("in the plan");
        let changed = variant.source.replace(from, to);
        assert!(changed != variant.source, "{from:?} is not in\n{}", variant.source);
        variant.source = changed;
    }
}

#[test]
fn a_device_that_keeps_the_rules_parts_at_ties_only() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, First, Fused};
    for configuration in [
        STEPPED,
        STEPPED.skipping(),
        Configuration::new(Grid, Compact, 1),
        Configuration::new(Grid, Compact, 8),
        Configuration::new(Bvh, Compact, 1),
        Configuration::new(None, First, 1),
        Configuration::new(Grid, Fused, 1),
    ] {
        let map = compared(&room(configuration), |_| {});
        for class in [Class::Excess, Class::Decision, Class::Precision] {
            let first = map.rays(class).next().and_then(|ray| map.first(class, ray));
            assert_eq!(first, Option::None, "{configuration}");
        }
        // Few of the 1,600 rays are at edges; a device that rounds differently from its twin may diverge there as well.
        assert!(map.count(Class::Tie) < 40, "{configuration}: {} ties", map.count(Class::Tie));
        if gpu().info.device_type == wgpu::DeviceType::Cpu {
            assert_eq!(map.count(Class::Rounding), 0, "{configuration}: software Vulkan rounds as the twins do");
            let of_device = |ray: &usize| map.partings(*ray).iter().any(|p| p.against == Against::Device);
            assert_eq!(map.rays(Class::Tie).find(of_device), Option::None, "{configuration}");
        }
    }
}

#[test]
fn a_broken_kernel_is_named_with_its_pass() {
    let map = compared(&room(STEPPED), change(kernels::INTERSECT, "nearest_t <= exit", "nearest_t < 0.5 * exit"));
    assert!(map.count(Class::Decision) > 100, "{:?}", map.counts());
    for ray in map.rays(Class::Decision) {
        let parting = map.first(Class::Decision, ray).expect("a divergence");
        assert_eq!((parting.kernel, map.kernels()[parting.pass]), (kernels::INTERSECT, kernels::INTERSECT));
        assert_eq!((parting.against, parting.stream, parting.layer), (Against::Device, streams::STATE, 0));
        assert_ne!(parting.theirs, parting.twin);
        assert_eq!(map.class(ray), Some(Class::Decision));
    }

    let map = compared(&room(STEPPED), change(kernels::SHADE, "* diffuse", "* diffuse * 1.001"));
    assert!(map.count(Class::Excess) > 100 && map.count(Class::Decision) == 0, "{:?}", map.counts());
    let last = map.kernels().len() - 1;
    for parting in map.rays(Class::Excess).filter_map(|ray| map.first(Class::Excess, ray)) {
        assert_eq!((parting.kernel, parting.pass, parting.stream), (kernels::SHADE, last, streams::COLOR));
        assert!(parting.ulps.is_some_and(|ulps| ulps > 1000), "{parting:?}");
    }
}

#[test]
fn another_rounding_is_told_from_a_defect() {
    // As on a GPU whose division is off by one unit in the last place.
    let otherwise = change(kernels::INTERSECT, "nearest_t = candidate.t", "nearest_t = candidate.t * 1.0000001");
    let map = compared(&room(STEPPED), otherwise);
    let shown: Vec<_> = map.rays(Class::Rounding).filter_map(|ray| map.first(Class::Rounding, ray)).collect();
    assert!(shown.len() > 1000, "{:?}", map.counts());
    for parting in shown.iter().filter(|p| p.stream == streams::STATE) {
        assert_eq!((parting.kernel, parting.layer), (kernels::INTERSECT, STATE_T));
        assert!(parting.ulps.is_some_and(|ulps| ulps <= 2), "{parting:?}");
    }
    assert_eq!((map.count(Class::Excess), map.count(Class::Decision)), (0, 0));
}
