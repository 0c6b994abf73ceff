//! Rays of a camera at random places of its pixels.

use glam::DVec3;
use raystep_kernels::options::Ray;
use raystep_scenes::{Camera, Projection};

use super::{Random, TILE, in_tiles, ray};

/// One ray through a random point of each pixel, in tiles of pixels, traced in tiles. Unlike the pixels' centres, these
/// rays are a random sample of what the camera sees: one from each of many equal parts.
#[must_use]
pub fn view(camera: &Camera, width: u32, height: u32, seed: u32) -> Vec<Ray> {
    let (across, down) = (width as usize, height as usize);
    let (columns, rows) = (across.div_ceil(TILE), down.div_ceil(TILE));
    let pixels = (0..columns * rows).flat_map(|tile| {
        let (left, top) = (tile % columns * TILE, tile / columns * TILE);
        (0..TILE * TILE).map(move |i| (left + i % TILE, top + i / TILE))
    });
    let aspect = f64::from(width) / f64::from(height);
    let one = |(x, y): (usize, usize)| {
        let mut random = Random::of((y * across + x) as u32, seed);
        let right = 2.0 * (x as f64 + random.unit()) / f64::from(width) - 1.0;
        let up = 1.0 - 2.0 * (y as f64 + random.unit()) / f64::from(height);
        let (origin, direction): (DVec3, DVec3) = match camera.projection {
            Projection::Perspective { vertical_fov } => {
                let half = (vertical_fov * 0.5).tan();
                let aside = camera.right * (right * half * aspect) + camera.up * (up * half);
                (camera.eye, camera.forward + aside)
            }
            Projection::Orthographic { half_height } => {
                let aside = camera.right * (right * half_height * aspect) + camera.up * (up * half_height);
                (camera.eye + aside, camera.forward)
            }
        };
        ray(origin, direction)
    };
    let is_inside = |(x, y): &(usize, usize)| *x < across && *y < down;
    in_tiles(&pixels.filter(is_inside).filter_map(one).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::{Device, Options, RaySource, Renderer};
    use raystep_scenes::{Scene, generate};

    use super::*;

    fn hits(scene: &Scene, rays: RaySource) -> Vec<u32> {
        let options = Options { shade: false, ..Options::new(rays) };
        let mut renderer = pollster::block_on(Renderer::new(scene, &options, &Device::Cpu(None))).expect("a renderer");
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
        let hits = pollster::block_on(renderer.hits()).expect("hits");
        let mut counts = vec![0; scene.triangles.len()];
        hits.iter().flatten().for_each(|hit| counts[hit.triangle as usize] += 1);
        counts
    }

    #[test]
    fn they_see_what_the_camera_sees() {
        let scene = generate::cornell_box();
        for projection in [scene.cameras[0].projection, Projection::Orthographic { half_height: 1.2 }] {
            let camera = Camera { projection, ..scene.cameras[0].clone() };
            let (width, height) = (72, 40);
            let rays = view(&camera, width, height, 3);
            assert_eq!(rays.len(), 72 * 40);
            assert_ne!(rays, view(&camera, width, height, 4));
            let ours = hits(&scene, RaySource::Given(rays));
            let theirs = hits(&scene, RaySource::Camera { camera, width, height });
            for (ours, theirs) in ours.into_iter().zip(theirs) {
                // Both see a triangle in as many pixels, but for those at its outline.
                let outline = 4.0 * f64::from(theirs.max(ours)).sqrt() + 4.0;
                assert!(f64::from(ours.abs_diff(theirs)) <= outline, "{ours} and {theirs} pixels");
            }
        }
    }
}
