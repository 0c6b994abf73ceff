//! Checks what an adapter that only draws traces.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::options::mapping::{Fragment, Mapping};
use raystep_kernels::options::scene_data::SceneDataKind;
use raystep_kernels::{Accelerator, Device, Gpu, Options, RaySource, RenderError, Renderer, ScheduleKind};
use raystep_scenes::generate;

use crate::error::Error;

const SIDE: u32 = 8;

/// Most rays whose triangle may be another: rounding may decide at an edge.
const MOST_OTHERS: usize = 4;

/// Compares a small picture of an adapter that only draws with the CPU's: some drivers of OpenGL draw kernels wrongly, and
/// report no error.
pub(crate) async fn check(gpu: &Arc<Gpu>) -> Result<(), Error> {
    if gpu.computes {
        return Ok(());
    }
    let (drawn, computed) = (triangles(&Device::Gpu(gpu.clone())).await?, triangles(&Device::Cpu(None)).await?);
    let others = others(&drawn, &computed);
    if others <= MOST_OTHERS {
        return Ok(());
    }
    Err(Error::failed(format!(
        "{}: this driver of OpenGL draws kernels wrongly, {others} of {} rays hit other triangles than on the CPU: use an \
         adapter of Vulkan, or --device cpu",
        gpu.info.name,
        computed.len()
    )))
}

/// How many rays hit other triangles.
fn others(found: &[u32], expected: &[u32]) -> usize {
    expected.iter().zip(found).filter(|(expected, found)| expected != found).count()
}

/// The triangle that each ray hits.
async fn triangles(device: &Device) -> Result<Vec<u32>, RenderError> {
    let scene = generate::cornell_box();
    let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: SIDE, height: SIDE };
    let computed = Options {
        accelerator: Accelerator::Grid,
        schedule: ScheduleKind::Second,
        shade: false,
        keep_passes: false,
        ..Options::new(rays)
    };
    let options = match device {
        Device::Gpu(_) => {
            Options { mapping: Mapping::Fragment(Fragment::default()), scene_data: SceneDataKind::Textures, ..computed }
        }
        _ => computed,
    };
    let mut renderer = Renderer::new(&scene, &options, device).await?;
    renderer.run(|_| ControlFlow::Continue(())).await?;
    let triangle = renderer.results()?.triangle;
    Ok(renderer.values(triangle.stream).await?.layer(triangle.layer).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{DeviceArgs, DeviceKind};
    use crate::device::choose;

    #[test]
    fn a_picture_that_is_drawn_agrees_with_the_cpu_and_an_empty_one_does_not() {
        let chosen =
            choose(&DeviceArgs { device: DeviceKind::Gpu, adapter: None }).expect("an adapter, if only software");
        let drawn = chosen.wait(triangles(&chosen.device)).expect("a picture");
        let computed = chosen.wait(triangles(&Device::Cpu(None))).expect("a picture");
        assert_eq!(others(&drawn, &computed), 0);
        let empty = vec![u32::MAX; computed.len()];
        assert!(others(&empty, &computed) > MOST_OTHERS);
    }
}
