//! Kernels as fragment programs leave the same bits in every stream as compute shaders, after every pass.

use std::ops::ControlFlow;

use raystep_kernels::options::mapping::{Cull, Fragment, Mapping, Update};
use raystep_kernels::plan::DrawnPlan;
use raystep_kernels::programs::closest_hit::{kernels, states};
use raystep_kernels::shader::{Binding, Resource};
use raystep_kernels::{
    Accelerator, AdapterChoice, BuiltBy, Caster, Device, Gpu, Kernel, Limits, Numerics, Options, Pass, Plan, Ray,
    Renderer, ScheduleKind, Traversal,
};
use raystep_tests::{block_on, differences, gpu, options, scene, scene_files, streams_of, thorough};

/// The next pass that worked on a ray: a query only finds out with a pass more that a kernel has none.
async fn next_with_rays(renderer: &mut Renderer) -> Option<Pass> {
    loop {
        match renderer.step().await.expect("a pass") {
            Some(pass) if pass.rays_in == 0 => {}
            other => return other,
        }
    }
}

/// Runs both mappings side by side, the drawn one with a changed plan; returns the number of passes that were compared, or
/// what differs.
fn compare(name: &str, options: &Options, how: Fragment, change: impl FnOnce(&mut DrawnPlan)) -> Result<usize, String> {
    let (gpu, scene) = (gpu(), scene(name));
    let device = Device::Gpu(gpu.clone());
    block_on(Some(&gpu), async {
        let mut computed = Renderer::new(&scene, options, &device).await.expect("a renderer");
        let options = Options { mapping: Mapping::Fragment(how), ..options.clone() };
        let (mut plan, data) = Plan::new(&scene, &options, &Limits::from(&*gpu)).map_err(|e| e.to_string())?;
        change(plan.drawn.as_mut().expect("draws"));
        let mut drawn = Renderer::from_plan(plan, data, &options, &device).await.map_err(|e| e.to_string())?;
        let mut passes = 0;
        loop {
            let (wanted, found) = (next_with_rays(&mut computed).await, next_with_rays(&mut drawn).await);
            let what = |pass: &Pass| (pass.kernel, pass.rays_in);
            if wanted.as_ref().map(what) != found.as_ref().map(what) {
                return Err(format!(
                    "pass {passes} is {:?}, not {:?}",
                    found.map(|p| what(&p)),
                    wanted.map(|p| what(&p))
                ));
            }
            let Some(kernel) = wanted.as_ref().map(|pass| pass.kernel) else { return Ok(passes) };
            for stream in streams_of(computed.plan()) {
                let (a, b) =
                    (computed.values(stream).await.expect("values"), drawn.values(stream).await.expect("values"));
                if let Some(first) = differences(&a, &b).next() {
                    return Err(format!("{kernel:?}: {stream:?} differs after pass {passes}: {first:?}"));
                }
            }
            if wanted.as_ref().map(|pass| &pass.counts) != found.as_ref().map(|pass| &pass.counts) {
                return Err(format!("{kernel:?}: rays are counted wrong after pass {passes}"));
            }
            passes += 1;
        }
    })
}

#[test]
fn fragment_programs_leave_the_bits_of_compute_shaders() {
    // In short, each choice of the mapping with a part of the other options; in the long form all together in one scene, and a
    // part in every other.
    let cornell = "cornell-box.gltf".to_owned();
    let others = scene_files().into_iter().filter(|name| *name != cornell);
    let names: Vec<String> = std::iter::once(cornell.clone()).chain(others.filter(|_| thorough())).collect();
    let mut block = 0;
    for name in &names {
        let is_whole = thorough() && *name == cornell;
        // Rays that all miss are generated, set up and shaded.
        let fewest = if *name == cornell { 6 } else { 3 };
        let scene = scene(name);
        let base = options(&scene, 20, 16);
        for (accelerator, numerics, traversal) in [
            (Accelerator::Grid, Numerics::Robust, Traversal::AmanatidesWoo),
            (Accelerator::Grid, Numerics::Paper, Traversal::AmanatidesWoo),
            (Accelerator::Grid, Numerics::Paper, Traversal::Dda3d),
            (Accelerator::Irregular, Numerics::Robust, Traversal::AmanatidesWoo),
            (Accelerator::Bvh, Numerics::Robust, Traversal::AmanatidesWoo),
            (Accelerator::None, Numerics::Robust, Traversal::AmanatidesWoo),
        ] {
            if accelerator == Accelerator::None && scene.triangles.len() > 200 {
                // A pass a triangle.
                continue;
            }
            for schedule in [ScheduleKind::First, ScheduleKind::Second] {
                block += 1;
                for (index, how) in Fragment::all().enumerate() {
                    // Over ten of the twelve blocks, each choice comes twice.
                    if !is_whole && (block + index) % 5 != 0 {
                        continue;
                    }
                    let counters = (block + index / 5) % 2 == 0;
                    let options = Options { accelerator, numerics, traversal, schedule, counters, ..base.clone() };
                    let which = format!("{name} {accelerator} {schedule} {numerics} {traversal} {how:?}");
                    match compare(name, &options, how, |_| {}) {
                        Ok(passes) => assert!(passes >= fewest, "{which}: {passes} passes"),
                        Err(difference) => panic!("{which}: {difference}"),
                    }
                }
            }
        }
    }
}

/// What is wrong with a draw is found by the comparison, in the kernel's pass.
#[test]
fn a_broken_draw_is_named() {
    let name = "cornell-box.gltf";
    let options = Options { schedule: ScheduleKind::Second, ..options(&scene(name), 20, 16) };
    let paper = Fragment::default();
    let broken = |how, change: fn(&mut DrawnPlan)| compare(name, &options, how, change).expect_err("a difference");

    let early = Fragment { cull: Cull::EarlyZ, ..paper };
    let found = broken(early, |drawn| {
        let depths = drawn.depths.as_mut().expect("depths");
        depths.source = depths.source.replace("return 0.0234375", "return 0.0234376");
    });
    assert!(found.contains("intersect"), "another depth: {found}");

    // Texels that are discarded then hold what they held two passes before.
    let found = broken(paper, |drawn| drawn.how.update = Update::Swap);
    assert!(found.contains("differs"), "no copy: {found}");

    // The query of the last draw then counts hits.
    let found = broken(paper, |drawn| drawn.kernels.iter_mut().for_each(|kernel| kernel.draws.reverse()));
    assert!(found.contains("pass"), "states first: {found}");
}

/// Makes the draws of a kernel count the fragments that run, as rays in a state that has none after the first pass. A counter
/// alone would make the depth test late, so it is forced to be early.
fn count_fragments(drawn: &mut DrawnPlan, kernel: Kernel) {
    const COUNTER: &str = "@group(2) @binding(0) var<storage, read_write> sent: array<atomic<u32>, 8>;\n";
    let is_tested = drawn.depths.is_some();
    for draw in drawn.kernels.iter_mut().filter(|drawn| drawn.kernel == kernel).flat_map(|drawn| &mut drawn.draws) {
        let (declarations, entry) = draw.shader.source.split_once("@fragment").expect("an entry point");
        let (head, body) = entry.split_once("-> Targets {").expect("a body");
        let early = if is_tested { "@early_depth_test(force) " } else { "" };
        let count = "atomicAdd(&sent[0], 1u);";
        draw.shader.source = format!("{COUNTER}{declarations}{early}@fragment{head}-> Targets {{ {count}{body}");
        let (name, resource) = ("sent".to_owned(), Resource::Live { writable: true });
        draw.shader.bindings.push(Binding { group: 2, index: 0, name, resource, reads: true, writes: true });
    }
}

/// With a depth test, only fragments with a ray run; without, all of them do.
#[test]
fn a_depth_test_keeps_the_kernel_from_running() {
    let features = wgpu::Features::SHADER_EARLY_DEPTH_TEST;
    let gpu = pollster::block_on(Gpu::with_features(&AdapterChoice::Best, features)).expect("a device");
    assert!(gpu.device.features().contains(features), "Vulkan adapters can force depth tests to be early");
    let (scene, device) = (scene("cornell-box.gltf"), Device::Gpu(gpu.clone()));
    let rays = 64 * 48;
    for cull in [Cull::Discard, Cull::EarlyZ] {
        let mapping = Mapping::Fragment(Fragment { cull, ..Fragment::default() });
        let options = Options { schedule: ScheduleKind::Second, mapping, ..options(&scene, 64, 48) };
        let (mut plan, data) = Plan::new(&scene, &options, &Limits::from(&*gpu)).expect("a plan");
        let drawn = plan.drawn.as_mut().expect("draws");
        count_fragments(drawn, kernels::INTERSECT);
        let draws = drawn.of(kernels::INTERSECT).expect("draws").draws.len() as u32;
        block_on(Some(&gpu), async {
            let mut renderer = Renderer::from_plan(plan, data, &options, &device).await.expect("a renderer");
            let mut partial = 0;
            while let Some(pass) = renderer.step().await.expect("a pass") {
                if pass.kernel == kernels::INTERSECT {
                    let ran = pass.counts[states::UNWRITTEN as usize];
                    let expected = if cull == Cull::EarlyZ { pass.rays_in } else { rays };
                    assert_eq!(ran, draws * expected, "{cull}: {pass:?}");
                    partial += u32::from(pass.rays_in < rays);
                }
            }
            assert!(partial > 10, "{partial} passes with a part of the rays");
        });
    }
}

/// What is not drawn still works beside it: a device that builds the grid, and rays that are cast.
#[test]
fn grids_are_built_and_rays_cast_with_the_options_of_a_drawn_run() {
    let (gpu, scene) = (gpu(), scene("cornell-box.gltf"));
    let device = Device::Gpu(gpu.clone());
    let mapping = Mapping::Fragment(Fragment::default());
    let accelerator = Accelerator::Irregular;
    let base = Options { accelerator, schedule: ScheduleKind::Second, mapping, ..options(&scene, 20, 16) };
    let hits = |build| {
        let options = Options { build, ..base.clone() };
        let hits = async {
            let mut renderer = Renderer::new(&scene, &options, &device).await?;
            renderer.run(|_| ControlFlow::Continue(())).await?;
            renderer.hits().await
        };
        block_on(Some(&gpu), hits).expect("a run")
    };
    let wanted = hits(BuiltBy::Host);
    assert!(wanted.iter().all(Option::is_some), "the box is closed");
    assert_eq!(hits(BuiltBy::Device), wanted);
    let ray = Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    let cast = async { Caster::new(scene.clone(), &base, &device).await?.cast(&[ray]).await };
    assert!(block_on(Some(&gpu), cast).expect("a hit")[0].t.is_finite());
}
