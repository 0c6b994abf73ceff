//! The crates as somebody else's program uses them: no window, no command line, any executor.

use std::sync::mpsc;
use std::time::Duration;

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, RaySource, RenderError, Renderer};
use raystep_scenes::{Camera, Scene};

/// The triangle that the centre pixel sees, traced on the GPU: all that a program has to write.
async fn seen_triangle() -> Result<u32, RenderError> {
    let scene = Scene::from_triangles(vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]);
    let camera = Camera::framing(&scene.bounds());
    let options = Options::new(RaySource::Camera { camera, width: 32, height: 32 });
    let device = Device::Gpu(Gpu::new(&AdapterChoice::Best).await?);
    let mut renderer = Renderer::new(&scene, &options, &device).await?;
    while renderer.step().await?.is_some() {}
    Ok(renderer.values(streams::HIT).await?.get(2, 16 * 32 + 16))
}

/// An executor that nobody polls a device for.
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
    for (name, run) in executors {
        let (sender, done) = mpsc::channel();
        std::thread::spawn(move || sender.send(run().map_err(|e| e.to_string())));
        // Some milliseconds where it works; forever where nobody polls.
        let seen = done.recv_timeout(Duration::from_secs(120)).unwrap_or_else(|_| panic!("{name} hangs"));
        assert_eq!(seen, Ok(0), "{name}");
    }
}
