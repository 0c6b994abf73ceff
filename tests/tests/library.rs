//! The crates as used by other programs: no window, no command line, any executor.

use std::future::poll_fn;
use std::pin::pin;
use std::sync::mpsc;
use std::task::Poll;
use std::time::Duration;

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, RaySource, RenderError, Renderer};
use raystep_scenes::{Camera, Scene};
use raystep_tests::block_on;

fn triangle() -> Scene {
    Scene::from_triangles(vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]])
}

fn camera() -> Camera {
    Camera::framing(&triangle().bounds())
}

/// The triangle seen at the centre pixel, traced on the GPU: the complete code that a program needs.
async fn seen_triangle() -> Result<u32, RenderError> {
    let (scene, camera) = (triangle(), camera());
    let options = Options::new(RaySource::Camera { camera, width: 32, height: 32 });
    let device = Device::Gpu(Gpu::new(&AdapterChoice::Best).await?);
    let mut renderer = Renderer::new(&scene, &options, &device).await?;
    while renderer.step().await?.is_some() {}
    Ok(renderer.values(streams::HIT).await?.get(2, 16 * 32 + 16))
}

/// An executor that does not poll the device.
type Executor = fn() -> Result<u32, RenderError>;

#[test]
fn futures_complete_under_any_executor() {
    let executors: [(&str, Executor); 3] = [
        ("pollster", || pollster::block_on(seen_triangle())),
        ("futures", || futures_executor::block_on(seen_triangle())),
        ("tokio", || {
            let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
            runtime.block_on(seen_triangle())
        }),
    ];
    let begun = executors.map(|(name, run)| (name, begin(run)));
    assert_eq!(begun.map(|(name, answer)| (name, in_time(&answer))), executors.map(|(name, _)| (name, Some(Ok(0)))));
}

/// Runs on a separate thread.
fn begin(run: Executor) -> mpsc::Receiver<Result<u32, String>> {
    let (sender, answer) = mpsc::channel();
    std::thread::spawn(move || sender.send(run().map_err(|e| e.to_string())));
    answer
}

/// The answer, which normally takes some milliseconds; `None` if nothing polls the device and it would take forever.
fn in_time(answer: &mpsc::Receiver<Result<u32, String>>) -> Option<Result<u32, String>> {
    answer.recv_timeout(Duration::from_secs(60)).ok()
}

/// After a host has polled for a while, the device's own thread polls again.
#[test]
fn a_host_polls_only_while_it_says_so() {
    let after_a_host = || {
        let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best))?;
        let options = Options::new(RaySource::Camera { camera: camera(), width: 32, height: 32 });
        let device = Device::Gpu(gpu.clone());
        let mut renderer = block_on(Some(&gpu), Renderer::new(&triangle(), &options, &device))?;
        // Work started while the host polls but not finished is completed without it, and so is later work.
        let was_ready = {
            let mut step = pin!(renderer.step());
            let was_ready = block_on(Some(&gpu), poll_fn(|cx| Poll::Ready(step.as_mut().poll(cx).is_ready())));
            if !was_ready {
                pollster::block_on(step)?;
            }
            was_ready
        };
        block_on(Some(&gpu), renderer.step())?;
        pollster::block_on(renderer.step())?;
        Ok(u32::from(was_ready))
    };
    assert_eq!(in_time(&begin(after_a_host)), Some(Ok(0)), "1 if the read-back was complete at once");
}
