//! Traces triangles in memory on the GPU, pass by pass.

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, RaySource, RenderError, Renderer, Stream};
use raystep_scenes::{Camera, Scene};

fn main() -> Result<(), RenderError> {
    pollster::block_on(async {
        let scene = Scene::from_triangles(vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]);
        let camera = Camera::framing(&scene.bounds());
        let options = Options::new(RaySource::Camera { camera, width: 64, height: 64 });
        let device = Device::Gpu(Gpu::new(&AdapterChoice::Best).await?);
        let mut renderer = Renderer::new(&scene, &options, &device).await?;
        while let Some(pass) = renderer.step().await? {
            println!("{:>3} {:<14} {} rays", pass.index, pass.kernel.name(), pass.rays_in);
        }
        let hit = renderer.values(streams::HIT).await?;
        println!("the centre pixel sees triangle {}", hit.get(2, 32 * 64 + 32));
        Ok(())
    })
}
