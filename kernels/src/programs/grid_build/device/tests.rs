//! Compares the whole program, run by the executors, with the host's build.

use std::ops::ControlFlow;
#[cfg(feature = "gpu")]
use std::sync::Arc;

use crate::compose::compose;
#[cfg(feature = "gpu")]
use crate::executor::gpu::{AdapterChoice, Gpu};
use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::{Options, RaySource};
use crate::programs::grid_build::modules;
use crate::programs::grid_build::plan::{self as grid_build, What};
use crate::programs::grid_build::streams::FIRST_SPAN;
use crate::programs::grid_build::tests::{cases, scenes};
use crate::renderer::{Device, Lists, Renderer};
use crate::structures::grid::GridData;
use crate::structures::irregular::{self, IrregularData, Layout, Site};

/// A kernel and its imports, as one text.
pub(crate) fn composed(root: &str, wgsl: &str) -> String {
    let modules = modules(&Features::default());
    let constants = crate::shared::constants::wgsl_module(0, 0, 0);
    let source = |name: &str| match name {
        "constants" => Some(constants.as_str()),
        _ if name == root => Some(wgsl),
        _ => modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_ref()),
    };
    compose(root, root, &source, &|_| None).expect("a text")
}

/// An adapter, or a message that there is none.
#[cfg(feature = "gpu")]
pub(crate) fn gpu() -> Option<Arc<Gpu>> {
    match pollster::block_on(Gpu::new(&AdapterChoice::Best)) {
        Ok(gpu) => {
            eprintln!("adapter: {} ({}, {})", gpu.info.name, gpu.info.backend, gpu.info.driver_info);
            Some(gpu)
        }
        Err(error) => {
            eprintln!("not tested: {error}");
            None
        }
    }
}

/// What a shader leaves in its second buffer of so many words, from these bytes in its first, in workgroups of 64.
#[cfg(feature = "gpu")]
pub(crate) fn computed(gpu: &Gpu, (root, wgsl): (&str, &str), given: &[u8], words: usize, groups: u32) -> Vec<u32> {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(root),
        source: wgpu::ShaderSource::Wgsl(composed(root, wgsl).into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(root),
        layout: None,
        module: &module,
        entry_point: Some(root),
        compilation_options: Default::default(),
        cache: None,
    });
    let inputs = gpu.filled_buffer("given", given, wgpu::BufferUsages::STORAGE);
    let outputs = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("results"),
        size: 4 * words as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: inputs.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: outputs.as_entire_binding() },
        ],
    });
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: outputs.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&outputs, 0, &copy, 0, outputs.size());
    gpu.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    gpu.health().expect("a device that works");
    let view = copy.get_mapped_range(..).expect("mapped");
    bytemuck::pod_collect_to_vec(&view)
}

/// A run that builds these lists.
fn renderer(vertices: &[f32], wanted: &GridData, device: &Device) -> Renderer {
    let options = Options::new(RaySource::Given(Vec::new()));
    let units = Units::default();
    let planned = grid_build::of(
        &What::Uniform { grid: wanted.grid, growth: wanted.growth, leaps: false },
        vertices.to_vec(),
        units,
        &options,
        &device.limits(),
    );
    let (plan, data) = planned.expect("a plan");
    pollster::block_on(Renderer::from_plan(plan, data, &options, device)).expect("a run")
}

fn compare(device: &Device) {
    for (name, vertices, wanted) in cases() {
        let mut renderer = renderer(&vertices, &wanted, device);
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a build");
        let lists = pollster::block_on(Lists::of(&renderer)).expect("lists");
        assert!(lists.cells == wanted.cells, "{name}: other starts");
        assert!(lists.items == wanted.items, "{name}: other lists");
    }
}

#[cfg(feature = "gpu")]
#[test]
fn a_device_builds_the_grids_that_the_host_builds() {
    let Some(gpu) = gpu() else { return };
    compare(&Device::Gpu(gpu));
}

#[test]
fn the_twins_build_the_grids_that_the_host_builds() {
    compare(&Device::Cpu(None));
    compare(&Device::CpuF64(None));
}

#[test]
fn more_than_fits_is_refused_with_its_number() {
    let devices = [Device::Cpu(None)].into_iter();
    #[cfg(feature = "gpu")]
    let devices = devices.chain(gpu().map(Device::Gpu));
    let (_, vertices, wanted) = cases().swap_remove(0);
    for device in devices {
        let mut renderer = renderer(&vertices, &wanted, &device);
        let error = pollster::block_on(async {
            renderer.step().await?;
            let mut spans = renderer.values(FIRST_SPAN).await?;
            spans.bits.fill(1 << 30);
            assert!(renderer.write(&spans));
            renderer.run(|_| ControlFlow::Continue(())).await
        });
        let said = error.expect_err("too many").to_string();
        assert!(said.starts_with("4294967295 spans are too many: at most"), "{said}");
        // After a restart, that number is unknown again.
        renderer.restart();
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a build");
        let lists = pollster::block_on(Lists::of(&renderer)).expect("lists");
        assert_eq!((lists.cells, lists.items), (wanted.cells.clone(), wanted.items.clone()));
    }
}

/// Irregular grids and grids of two levels, as the host builds them, and what they are planned from.
fn irregular_cases() -> Vec<(String, Vec<f32>, What, IrregularData)> {
    let mut all = Vec::new();
    for (name, vertices) in scenes() {
        if vertices.iter().any(|v| !v.is_finite() || v.abs() > 1e20 || (*v != 0.0 && v.abs() < 1e-20)) {
            continue;
        }
        // A million references tell nothing more.
        if name == "corners on those of cells" {
            continue;
        }
        let site = Site::new(&vertices, None, true, u64::MAX).expect("a grid");
        let host = irregular::build(&vertices, None, true, u64::MAX).expect("a grid");
        assert!(site.aside.is_empty(), "{name}");
        all.push((format!("{name}, irregular"), vertices.clone(), What::Irregular(site.layout), host));
        let reach = site.extent.1;
        let host = irregular::build_two_levels(&vertices, [5, 6, 7], reach, true, u64::MAX).expect("a grid");
        let layout = Layout::below(&vertices, reach, true, [5, 6, 7]);
        all.push((format!("{name}, two levels"), vertices.clone(), What::TwoLevels(layout), host));
    }
    all
}

fn compare_irregular(device: &Device) {
    for (name, vertices, what, wanted) in irregular_cases() {
        let options = Options::new(RaySource::Given(Vec::new()));
        let planned = grid_build::of(&what, vertices, Units::default(), &options, &device.limits());
        let (plan, data) = planned.expect("a plan");
        let mut renderer = pollster::block_on(Renderer::from_plan(plan, data, &options, device)).expect("a run");
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a build");
        let built = pollster::block_on(IrregularData::of(&renderer)).expect("a grid");
        println!("{name}: {} passes, {} cells, {} items", renderer.pass_count(), built.cells.len(), built.items.len());
        assert!(built.map.len() == wanted.map.len(), "{name}: {} entries, not {}", built.map.len(), wanted.map.len());
        assert!(built.lengths == wanted.lengths, "{name}: other lists");
        assert!(built.items == wanted.items, "{name}: other items");
        assert!(built.cells == wanted.cells, "{name}: other cells");
        assert!(built.map == wanted.map, "{name}: another map");
        assert_eq!(IrregularData { bounds: wanted.bounds, reach: wanted.reach, ..built }, wanted, "{name}");
    }
}

#[cfg(feature = "gpu")]
#[test]
fn a_device_builds_the_irregular_grids_that_the_host_builds() {
    let Some(gpu) = gpu() else { return };
    compare_irregular(&Device::Gpu(gpu));
}

#[test]
fn the_twins_build_the_irregular_grids_that_the_host_builds() {
    compare_irregular(&Device::Cpu(None));
}
