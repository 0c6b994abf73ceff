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
use crate::plan::grid_build;
use crate::programs::grid_build::modules;
use crate::programs::grid_build::streams::FIRST_SPAN;
use crate::programs::grid_build::tests::cases;
use crate::renderer::{Device, Lists, Renderer};
use crate::structures::grid::GridData;

/// A kernel and its imports, as one text.
pub(crate) fn composed(root: &str, wgsl: &str) -> String {
    let modules = modules(&Features::default());
    let source = |name: &str| {
        if name == root {
            return Some(wgsl);
        }
        modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_ref())
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

/// A run that builds these lists.
fn renderer(vertices: &[f32], wanted: &GridData, device: &Device) -> Renderer {
    let options = Options::new(RaySource::Given(Vec::new()));
    let units = Units::default();
    let planned = grid_build::of(wanted.grid, wanted.growth, vertices.to_vec(), units, &options, &device.limits());
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
        assert!(said.starts_with("the run has found 4294967295 spans, at most"), "{said}");
        // After a restart, that number is unknown again.
        renderer.restart();
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a build");
        let lists = pollster::block_on(Lists::of(&renderer)).expect("lists");
        assert_eq!((lists.cells, lists.items), (wanted.cells.clone(), wanted.items.clone()));
    }
}
