//! Lists in textures give the results of lists in buffers, and kernels bind no more than core WebGPU allows.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_kernels::fragment::Shader;
use raystep_kernels::options::ProgramName;
use raystep_kernels::options::mapping::{Cull, Fragment, Mapping, MappingName, Targets, Until, Update};
use raystep_kernels::options::scene_data::SceneDataKind;
use raystep_kernels::plan::DrawnPlan;
use raystep_kernels::shader::{Binding, Resource};
use raystep_kernels::{
    Accelerator, AdapterChoice, Choices, Device, Gpu, Keep, Limits, Loops, Numerics, Options, Plan, PlanError,
    Renderer, Samples, ScheduleKind, Stream,
};
use raystep_tests::{block_on, differences, gpu, options, scene, streams_of, thorough};

const STRUCTURES: [Accelerator; 4] = [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None];

/// Runs passes with lists in buffers and in textures side by side, the latter with changed shaders; returns the number of
/// passes, or what differs.
fn compare(name: &str, options: &Options, change: impl FnOnce(&mut DrawnPlan)) -> Result<usize, String> {
    compare_on(&gpu(), name, options, change)
}

/// The same with the lists in textures on another device.
fn compare_on(
    other: &Arc<Gpu>,
    name: &str,
    options: &Options,
    change: impl FnOnce(&mut DrawnPlan),
) -> Result<usize, String> {
    let (gpu, scene) = (gpu(), scene(name));
    block_on(Some(&gpu), async {
        let mut wanted = Renderer::new(&scene, options, &Device::Gpu(gpu.clone())).await.expect("a renderer");
        let options = Options { scene_data: SceneDataKind::Textures, ..options.clone() };
        let (mut plan, data) = Plan::new(&scene, &options, &Limits::from(&**other)).map_err(|e| e.to_string())?;
        if let Some(drawn) = &mut plan.drawn {
            change(drawn);
        }
        let device = Device::Gpu(other.clone());
        let mut found = Renderer::from_plan(plan, data, &options, &device).await.map_err(|e| e.to_string())?;
        let mut passes = 0;
        loop {
            let (a, b) = (wanted.step().await.expect("a pass"), found.step().await.map_err(|e| e.to_string())?);
            let what = |pass: &raystep_kernels::Pass| (pass.kernel, pass.rays_in, pass.counts.clone());
            if a.as_ref().map(what) != b.as_ref().map(what) {
                return Err(format!("pass {passes} is {:?}, not {:?}", b.map(|b| what(&b)), a.map(|a| what(&a))));
            }
            let Some(pass) = a else { return Ok(passes) };
            let is_counted = |stream: &Stream| wanted.size(stream.info().elements).is_some();
            for stream in streams_of(wanted.plan()).into_iter().filter(is_counted) {
                let (a, b) =
                    (wanted.values(stream).await.expect("values"), found.values(stream).await.expect("values"));
                if let Some(first) = differences(&a, &b).next() {
                    return Err(format!("{:?}: {stream:?} differs after pass {passes}: {first:?}", pass.kernel));
                }
            }
            passes += 1;
        }
    })
}

/// Runs of both mappings, of every structure and schedule.
#[test]
fn lists_in_textures_leave_the_bits_of_lists_in_buffers_after_every_pass() {
    // Every structure with few triangles; all lists of shading.
    for (name, shade) in [("cornell-box.gltf", true), ("textures.gltf", true), ("lights.gltf", true)] {
        let scene = scene(name);
        let base = Options { shade, ..options(&scene, 20, 16) };
        for (block, accelerator) in STRUCTURES.into_iter().enumerate() {
            if name != "cornell-box.gltf" && !thorough() && accelerator != Accelerator::Grid {
                continue;
            }
            if accelerator == Accelerator::None && scene.triangles.len() > 200 {
                // A pass a triangle.
                continue;
            }
            for &schedule in ScheduleKind::ALL {
                let drawn = [Fragment::default(), Fragment { targets: Targets::Many, ..Fragment::default() }];
                let drawn = drawn
                    .into_iter()
                    .map(Mapping::Fragment)
                    .filter(|_| matches!(schedule, ScheduleKind::First | ScheduleKind::Second));
                for mapping in std::iter::once(Mapping::Compute).chain(drawn) {
                    let counters = block % 2 == 0;
                    let options = Options { accelerator, schedule, mapping, counters, ..base.clone() };
                    let which = format!("{name} {accelerator} {schedule} {mapping}");
                    match compare(name, &options, |_| {}) {
                        // The fused schedule takes the fewest.
                        Ok(passes) => assert!(passes >= 2, "{which}: {passes} passes"),
                        Err(difference) => panic!("{which}: {difference}"),
                    }
                }
            }
        }
    }
}

/// An entry that is read from another texel is found by the comparison.
#[test]
fn a_wrong_address_is_seen() {
    let options = Options {
        schedule: ScheduleKind::Second,
        mapping: Mapping::Fragment(Fragment::default()),
        ..options(&scene("cornell-box.gltf"), 20, 16)
    };
    let mut swaps = 0;
    let swapped = |drawn: &mut DrawnPlan| {
        let draws = drawn.kernels.iter_mut().flat_map(|kernel| &mut kernel.draws);
        for shader in draws.map(|draw| &mut draw.shader) {
            swaps += shader.source.matches(" % k), (").count();
            shader.source = shader.source.replace(" % k), (", " / k), (");
        }
    };
    let found = compare("cornell-box.gltf", &options, swapped).expect_err("a difference");
    let is_difference = found.contains("differs after pass") || found.starts_with("pass ");
    assert!(swaps > 0 && is_difference, "{swaps}: {found}");
}

/// Grids are built from triangles in a texture.
#[test]
fn a_grid_is_built_from_lists_in_textures() {
    for accelerator in [Accelerator::Grid, Accelerator::Irregular] {
        let options =
            Options { program: ProgramName::GridBuild, accelerator, ..options(&scene("cornell-box.gltf"), 8, 8) };
        let passes = compare("cornell-box.gltf", &options, |_| {}).unwrap_or_else(|e| panic!("{accelerator}: {e}"));
        assert!(passes > 10, "{accelerator}: {passes} passes");
    }
}

#[test]
fn a_list_that_fits_no_texture_is_named() {
    let scene = scene("cornell-box.gltf");
    let options = Options { scene_data: SceneDataKind::Textures, shade: false, ..options(&scene, 8, 8) };
    let limits = Limits { image_side: 8, color_bytes: 32, ..Limits::CPU };
    let error =
        Plan::new(&scene, &Options { accelerator: Accelerator::Bvh, ..options.clone() }, &limits).expect_err("8");
    // 26 or more triangles of 12 words each.
    assert!(matches!(error, PlanError::ListSize { name: "packed_triangles", side: 18, most: 8, .. }), "{error:?}");
    assert!(error.to_string().contains("--scene-data buffers allows longer lists"), "{error}");
    let error = Plan::new(&scene, &options, &Limits::CPU).expect_err("no textures");
    assert!(error.to_string().contains("--device gpu"), "{error}");
}

/// The limits that every WebGPU device has.
fn core() -> Limits {
    let limits = Limits::of_adapter(&wgpu::Limits::default(), Loops::Unlimited);
    assert_eq!((limits.storage_textures, limits.storage_buffers, limits.storage_bytes), (4, 8, 128 << 20));
    limits
}

fn is_buffer(binding: &Binding) -> bool {
    matches!(binding.resource, Resource::Storage | Resource::Live { .. })
}

/// Checks that no draw binds a storage buffer.
fn check_draws(drawn: &DrawnPlan, which: &str) {
    let draws = drawn.kernels.iter().flat_map(|kernel| kernel.draws.iter().map(move |draw| (kernel.kernel, draw)));
    let all: Vec<(&str, &Shader)> = (draws.map(|(kernel, draw)| (kernel.name(), &draw.shader)))
        .chain(drawn.depths.as_ref().map(|shader| ("depths", shader)))
        .collect();
    for (name, shader) in all {
        assert!(!shader.bindings.iter().any(is_buffer), "{which}: {name} binds {:?}", shader.bindings);
        assert!(!shader.source.contains("var<storage"), "{which}: {name}\n{}", shader.source);
    }
}

/// How many plans fit.
#[derive(Default)]
struct Planned {
    fit: usize,
}

impl Planned {
    fn add(&mut self, name: &str, options: &Options) {
        let which =
            format!("{} {name} {} {} {}", options.program, options.accelerator, options.schedule, options.mapping);
        let is_drawn = options.mapping != Mapping::Compute;
        let has_faults = is_drawn && !matches!(options.schedule, ScheduleKind::First | ScheduleKind::Second);
        let has_no_rules = options.accelerator == Accelerator::Irregular && options.numerics == Numerics::Paper;
        let plan = Plan::new(&scene(name), options, &core());
        assert_eq!(plan.is_err(), has_faults || has_no_rules, "{which}: {:?}", plan.err());
        match plan {
            Ok((plan, _)) => {
                self.fit += 1;
                let is_textured = options.scene_data == SceneDataKind::Textures;
                if let (Some(drawn), true) = (&plan.drawn, is_textured) {
                    check_draws(drawn, &which);
                }
            }
            // What cannot be drawn says so.
            Err(error @ PlanError::Refused(_)) => {
                assert!(error.to_string().contains("use "), "{which}: {error}");
            }
            Err(error) => panic!("{which}: {error}"),
        }
    }
}

/// Every program, structure, schedule, mapping and kind of scene data fits core WebGPU, with everything that a scene may
/// need, or is refused for what its mapping or program cannot do.
#[test]
fn every_plan_fits_core_limits_or_says_why_not() {
    let mappings = [
        Mapping::Compute,
        Mapping::Fragment(Fragment::default()),
        Mapping::Fragment(Fragment::of(Some(Targets::Many), Some(Update::Swap), None, None)),
        Mapping::Fragment(Fragment::of(Some(Targets::Many), None, Some(Cull::EarlyZ), None)),
    ];
    let mut all = Planned::default();
    for name in ["cornell-box.gltf", "textures.gltf"] {
        for (keep, numerics) in
            [(Keep::NONE, Numerics::Robust), (Keep::ALL, Numerics::Robust), (Keep::ALL, Numerics::Paper)]
        {
            for &scene_data in SceneDataKind::ALL {
                let base = Options { keep, numerics, scene_data, counters: true, ..options(&scene(name), 20, 16) };
                for accelerator in STRUCTURES {
                    for &schedule in ScheduleKind::ALL {
                        for mapping in mappings {
                            let count = if mapping == Mapping::Compute && keep == Keep::ALL { 64 } else { 1 };
                            let samples = Samples { count, ..Samples::default() };
                            all.add(name, &Options { accelerator, schedule, mapping, samples, ..base.clone() });
                        }
                    }
                }
                for program in [ProgramName::GridBuild, ProgramName::Sort] {
                    for accelerator in [Accelerator::Grid, Accelerator::Irregular] {
                        all.add(name, &Options { program, accelerator, ..base.clone() });
                    }
                }
            }
        }
    }
    assert!(all.fit > 300, "{} plans", all.fit);
}

/// Where a device allows less, the error names the kernel and the binding that does not fit.
#[test]
fn a_kernel_that_binds_too_much_is_refused_with_the_name_of_what_does_not_fit() {
    let scene = scene("textures.gltf");
    let schedule = ScheduleKind::Second;
    let options = Options { keep: Keep::ALL, counters: true, schedule, ..options(&scene, 20, 16) };
    let refused = |options: &Options, limits: &Limits| match Plan::new(&scene, options, limits) {
        Err(PlanError::Bindings { kernel, kind, most, name, .. }) => (kernel, kind, most, name),
        other => panic!("{:?}", other.map(|_| ())),
    };
    let few = Limits { storage_buffers: 7, ..core() };
    let (kernel, kind, most, name) = refused(&options, &few);
    assert_eq!((kernel, kind, most), ("shade", "storage buffers", 7));
    assert!(["texels", "textures", "lights", "sent"].contains(&name.as_str()), "{name}");
    let message = Plan::new(&scene, &options, &few).expect_err("too many").to_string();
    assert!(message.ends_with("use --scene-data textures"), "{message}");
    assert!(Plan::new(&scene, &Options { scene_data: SceneDataKind::Textures, ..options.clone() }, &few).is_ok());
    // Streams of integers and of floats share no texture.
    let few = Limits { storage_textures: 1, ..core() };
    let fused = Options { schedule: ScheduleKind::Fused, ..options.clone() };
    assert_eq!(refused(&fused, &few).1, "storage textures");
    let textures =
        Options { scene_data: SceneDataKind::Textures, mapping: Mapping::Fragment(Fragment::default()), ..options };
    let few = Limits { sampled_textures: 8, storage_buffers: 0, storage_textures: 0, ..core() };
    let (kernel, kind, most, _) = refused(&textures, &few);
    assert_eq!((kernel, kind, most), ("intersect", "textures", 8));
    let message = Plan::new(&scene, &textures, &few).expect_err("too many").to_string();
    assert!(message.contains("this device allows a shader 8: "), "{message}");
    // What WebGL 2 has is enough.
    let webgl = Limits { sampled_textures: 16, ..few };
    assert!(Plan::new(&scene, &textures, &webgl).is_ok());
}

/// A device of OpenGL with no more than WebGL 2 has: it cannot compute, and has no storage buffers.
fn opengl() -> Arc<Gpu> {
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Named(", OpenGL".into())));
    let gpu = gpu.expect("an adapter of OpenGL: see tests/run.sh");
    let limits = gpu.device.limits();
    assert_eq!((limits.max_storage_buffers_per_shader_stage, limits.max_storage_textures_per_shader_stage), (0, 0));
    assert!(!gpu.computes && limits.max_compute_workgroups_per_dimension == 0);
    gpu
}

/// The paper's machine on OpenGL: draws, copies, occlusion queries, and the scene in textures.
#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "needs the OpenGL of Mesa, or another one with EGL")]
fn opengl_leaves_the_bits_of_vulkan_after_every_pass() {
    let gl = opengl();
    for accelerator in STRUCTURES {
        for schedule in [ScheduleKind::First, ScheduleKind::Second] {
            let mapping = Mapping::Fragment(Fragment::default());
            let options = Options { accelerator, schedule, mapping, ..options(&scene("cornell-box.gltf"), 20, 16) };
            let passes = compare_on(&gl, "cornell-box.gltf", &options, |_| {});
            let passes = passes.unwrap_or_else(|e| panic!("{accelerator} {schedule}: {e}"));
            assert!(passes > 10, "{accelerator} {schedule}: {passes} passes");
        }
    }
}

/// Passes are submitted in batches, and the image is the same; what needs compute shaders is refused.
#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "needs the OpenGL of Mesa, or another one with EGL")]
fn opengl_renders_the_image_of_vulkan() {
    let gl = opengl();
    let scene = scene("textures.gltf");
    let base = Options { schedule: ScheduleKind::Second, keep_passes: false, ..options(&scene, 40, 32) };
    let drawn = Options {
        mapping: Mapping::Fragment(Fragment::of(Some(Targets::Many), None, Some(Cull::EarlyZ), None)),
        scene_data: SceneDataKind::Textures,
        ..base.clone()
    };
    let image = |options: &Options, gpu: &Arc<Gpu>| {
        let image = async {
            let mut renderer = Renderer::new(&scene, options, &Device::Gpu(gpu.clone())).await?;
            renderer.run(|_| ControlFlow::Continue(())).await?;
            renderer.image().await
        };
        block_on(Some(gpu), image)
    };
    let wanted = image(&base, &gpu()).expect("an image");
    assert_eq!(image(&drawn, &gl).expect("an image").pixels, wanted.pixels);
    for refused in [
        base.clone(),
        Options { scene_data: SceneDataKind::Buffers, ..drawn.clone() },
        Options {
            mapping: Mapping::Fragment(Fragment { until: Until::Count, ..Fragment::default() }),
            ..drawn.clone()
        },
    ] {
        let error = image(&refused, &gl).expect_err("no compute shaders").to_string();
        assert!(error.contains("--mapping fragment --scene-data textures"), "{error}");
    }
}

/// The window takes from its adapter what that can draw; the rest runs on the CPU.
#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "needs the OpenGL of Mesa, or another one with EGL")]
fn the_window_draws_kernels_on_opengl_or_runs_them_on_the_cpu() {
    let gl = opengl();
    let on = |settings: Settings| {
        let found = settings.on(&gl);
        assert_eq!(found.clone().on(&gl), found, "it stays so");
        found
    };
    let asked = Settings::default();
    let drawn = on(asked.clone());
    let how = |s: &Settings| (s.device, s.choices.mapping.name(), s.choices.scene_data, s.choices.schedule);
    use SceneDataKind::{Buffers, Textures};
    assert_eq!(how(&drawn), (DeviceKind::Gpu, MappingName::Fragment, Textures, ScheduleKind::Second));
    assert!(asked.is_drawn_otherwise(&drawn) && !drawn.is_drawn_otherwise(&drawn));
    let first = Settings { choices: Choices { schedule: ScheduleKind::First, ..drawn.choices }, ..drawn.clone() };
    assert_eq!(on(first.clone()), first, "what was chosen stays");
    let on_cpu = (DeviceKind::Cpu, MappingName::Compute, Buffers);
    let of = |s: Settings| (s.device, s.choices.mapping.name(), s.choices.scene_data);
    let with = |choices| Settings { choices, ..asked.clone() };
    assert_eq!(of(on(with(Choices { program: ProgramName::Sort, ..asked.choices }))), on_cpu);
    let samples = Samples { count: 4, ..Samples::default() };
    assert_eq!(of(on(with(Choices { samples, ..asked.choices }))), on_cpu);
    assert_eq!(of(on(Settings { device: DeviceKind::Cpu, ..drawn.clone() })), on_cpu);
    let auto = on(Settings { device: DeviceKind::Auto, ..asked.clone() });
    assert_eq!(auto.device, DeviceKind::Cpu);
    let gpu = gpu();
    assert_eq!(drawn.clone().on(&gpu), drawn, "an adapter that computes can draw too");
    assert_eq!(asked.clone().on(&gpu), asked);
}
