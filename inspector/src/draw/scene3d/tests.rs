//! Pictures of known walks: a few pixels that have to be as they are, on whatever adapter there is.

use std::sync::Arc;

use glam::DVec2;
use raystep_kernels::{Accelerator, AdapterChoice, Gpu, Options};

use super::*;
use crate::draw::picture::picture;
use crate::walk::tests::{CORNELL, TEAPOT, options, scene, traced};

const SIZE: [u32; 2] = [960, 640];

struct Picture(Vec<u8>);

impl Picture {
    /// The pixel at which a point is seen.
    fn at(&self, camera: &Orbit, point: DVec3) -> [u8; 3] {
        let (pixel, _) = camera.pixel(point, DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]))).expect("in front");
        let at = 4 * (pixel.y as usize * SIZE[0] as usize + pixel.x as usize);
        [self.0[at], self.0[at + 1], self.0[at + 2]]
    }
}

fn gpu() -> Arc<Gpu> {
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter");
    eprintln!("adapter: {} ({})", gpu.info.name, gpu.info.backend);
    gpu
}

/// Draws; keeps the picture where `RAYSTEP_PICTURES` names a folder.
fn drawn(
    gpu: &Gpu,
    view: &mut Scene3d,
    camera: &Orbit,
    walk: Option<&WalkGeometry>,
    settings: &Settings,
    name: String,
) -> Picture {
    drawn_around(gpu, view, camera, walk, &Around::default(), settings, name)
}

fn drawn_around(
    gpu: &Gpu,
    view: &mut Scene3d,
    camera: &Orbit,
    walk: Option<&WalkGeometry>,
    around: &Around,
    settings: &Settings,
    name: String,
) -> Picture {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let texture = picture(&gpu.device, SIZE);
    view.draw(&texture.create_view(&wgpu::TextureViewDescriptor::default()), SIZE, camera, walk, around, settings);
    let bytes = u64::from(SIZE[0] * SIZE[1] * 4);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("pixels"),
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE[0] * 4), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    gpu.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device");
    assert_eq!(pollster::block_on(scope.pop()).map(|error| error.to_string()), None, "{name}");
    let pixels = buffer.get_mapped_range(..).expect("mapped").to_vec();
    if let Ok(folder) = std::env::var("RAYSTEP_PICTURES") {
        let file = std::path::Path::new(&folder).join(format!("{name}.png"));
        image::save_buffer(file, &pixels, SIZE[0], SIZE[1], image::ColorType::Rgba8).expect("a file");
    }
    Picture(pixels)
}

fn view_of(gpu: &Arc<Gpu>, data: &SceneData) -> (Scene3d, Orbit) {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let mut view = Scene3d::new(gpu);
    assert_eq!(pollster::block_on(scope.pop()).map(|error| error.to_string()), None);
    assert_eq!(
        view.set_scene(data),
        Shown { drawn: data.info.triangles as usize, of: data.info.triangles as usize, every: 1 }
    );
    let camera = Orbit::framing(&view.bounds(), f64::from(SIZE[0]) / f64::from(SIZE[1]));
    (view, camera)
}

fn is_near(color: [u8; 3], wanted: [u8; 3], most: u8) -> bool {
    color.iter().zip(wanted).all(|(&c, w)| c.abs_diff(w) <= most)
}

#[test]
fn the_walk_through_the_cornell_box_is_seen() {
    let gpu = gpu();
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &options(&scene), [20, 40]);
    let (mut view, camera) = view_of(&gpu, &data);
    let middle = WalkGeometry::new(&trace, &data, trace.rows.len() / 2);
    let end = WalkGeometry::new(&trace, &data, usize::MAX);
    let background = [0x15, 0x18, 0x1d];
    let mut shown = |walk: Option<&WalkGeometry>, triangles, name: String| {
        let settings = Settings { triangles, ..Settings::default() };
        drawn(&gpu, &mut view, &camera, walk, &settings, name)
    };
    for (style, name) in [
        (TriangleStyle::Hidden, "hidden"),
        (TriangleStyle::Wireframe, "wireframe"),
        (TriangleStyle::Translucent, "translucent"),
        (TriangleStyle::Opaque, "opaque"),
    ] {
        let empty = shown(None, style, format!("cornell-{name}-empty"));
        let half = shown(Some(&middle), style, format!("cornell-{name}-half"));
        let whole = shown(Some(&end), style, format!("cornell-{name}-end"));
        assert_eq!(&whole.0[..3], background, "{name}: a corner of the picture");
        let hit = end.hit.expect("a hit").point;
        let [r, g, b] = whole.at(&camera, hit);
        if style != TriangleStyle::Opaque {
            assert!(is_near([r, g, b], [80, 225, 130], 12), "{name}: {r} {g} {b} at the hit");
        }
        assert!(whole.at(&camera, hit) != empty.at(&camera, hit), "{name}: the hit");
        // Half-way through a cell, away from the dots at its planes.
        let on_ray = middle.point((middle.cells[3].t_in + middle.cells[3].t_out) * 0.5);
        let [seen, before] = [half.at(&camera, on_ray), empty.at(&camera, on_ray)];
        match style {
            // Behind the walls: faint.
            TriangleStyle::Opaque => assert!(seen != before, "{name}: {seen:?}"),
            _ => assert!(is_near(seen, [255; 3], 10), "{name}: {seen:?}"),
        }
        assert!(whole.0 != half.0);
    }
}

#[test]
fn what_hides_the_walk_is_cut_away_and_what_was_picked_is_outlined() {
    let gpu = gpu();
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &options(&scene), [20, 40]);
    let (mut view, mut camera) = view_of(&gpu, &data);
    let walk = WalkGeometry::new(&trace, &data, usize::MAX);
    let points = walk.extent();
    camera.frame_from_side(&points, walk.direction, 1.5, 0.1);
    let forward = camera.pose.axes()[2];
    let nearest = points.iter().map(|p| p.dot(forward)).fold(f64::INFINITY, f64::min);
    // Through the wall of the box, at the ray within one of its cells.
    let on_ray = walk.point((walk.cells[3].t_in + walk.cells[3].t_out) * 0.5);
    let settings = Settings { triangles: TriangleStyle::Opaque, ..Settings::default() };
    let mut seen = |around: Around, settings: Settings, name: &str| {
        let picture = drawn_around(&gpu, &mut view, &camera, Some(&walk), &around, &settings, name.into());
        (picture.at(&camera, on_ray), picture)
    };
    let cut = Around { cut: Some(nearest), marked: None };
    let (through, _) = seen(cut, settings, "cornell-cut");
    assert!(is_near(through, [255; 3], 10), "cut away: {through:?}");
    for (around, settings) in [(Around::default(), settings), (cut, Settings { cut: false, ..settings })] {
        let (hidden, _) = seen(around, settings, "cornell-uncut");
        assert!(!is_near(hidden, [255; 3], 10), "behind the wall: {hidden:?}");
    }
    // An edge of a cell that was picked, away from the ray.
    let bounds = walk.cells[3].bounds;
    let [a, b] = bounds.edges()[0];
    let (_, marked) = seen(Around { marked: Some(Marked::Box(bounds)), ..cut }, settings, "cornell-picked");
    let color = marked.at(&camera, (a + b) * 0.5);
    assert!(is_near(color, [255, 80, 200], 60), "{color:?}");
}

#[test]
fn the_teapot_is_seen_with_its_cells_its_tree_and_its_triangles() {
    let gpu = gpu();
    let scene = scene(TEAPOT);
    for (accelerator, name) in [(Accelerator::Grid, "grid"), (Accelerator::Bvh, "bvh")] {
        let (trace, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, [28, 30]);
        let (mut view, mut camera) = view_of(&gpu, &data);
        for (at, part) in [(trace.rows.len() * 2 / 3, "two-thirds"), (trace.rows.len(), "end")] {
            let walk = WalkGeometry::new(&trace, &data, at);
            for (triangles, style) in [(TriangleStyle::Translucent, "translucent"), (TriangleStyle::Opaque, "opaque")] {
                let settings = Settings { triangles, ..Settings::default() };
                let file = format!("teapot-{name}-{style}-{part}");
                let with = drawn(&gpu, &mut view, &camera, Some(&walk), &settings, file.clone());
                let without = drawn(&gpu, &mut view, &camera, None, &settings, format!("{file}-scene"));
                let triangle = walk.tested.iter().find(|test| test.outcome.is_hit());
                if let Some(test) = triangle.filter(|_| triangles == TriangleStyle::Translucent) {
                    let middle = (test.corners[0] + test.corners[1] + test.corners[2]) / 3.0;
                    assert!(with.at(&camera, middle) != without.at(&camera, middle), "{file}: the triangle hit");
                }
                assert!(without.0.as_chunks::<4>().0.iter().filter(|p| p[0] > 40).count() > 20_000, "{file}");
            }
        }
        // From where the rays come from, and very near, where lines end behind the eye.
        let traced_camera =
            scene.cameras.first().cloned().unwrap_or_else(|| raystep_scenes::Camera::framing(&scene.bounds()));
        let walk = WalkGeometry::new(&trace, &data, usize::MAX);
        camera.zoom(0.12, walk.hit.map_or(DVec3::ZERO, |hit| hit.point));
        drawn(&gpu, &mut view, &camera, Some(&walk), &Settings::default(), format!("teapot-{name}-near"));
        let scale = data.units.scale();
        let bounds = Aabb { min: view.bounds().min / scale, max: view.bounds().max / scale };
        let eye = Orbit::from_camera(&traced_camera, &bounds).scaled(scale);
        drawn(
            &gpu,
            &mut view,
            &eye,
            Some(&walk),
            &Settings { is_dark: false, ..Settings::default() },
            format!("teapot-{name}-eye"),
        );
        let mut parallel = Orbit::framing(&view.bounds(), 1.5);
        parallel.pose.lens = Lens::Orthographic { half_height: 1.0 };
        parallel.frame(&view.bounds(), 1.5);
        let settings = Settings { triangles: TriangleStyle::Opaque, ..Settings::default() };
        drawn(&gpu, &mut view, &parallel, Some(&walk), &settings, format!("teapot-{name}-parallel"));
    }
}

#[test]
fn triangles_and_boxes_are_seen_in_the_colours_they_are_given() {
    let gpu = gpu();
    let scene = scene(CORNELL);
    let (trace, data) = traced(&scene, &options(&scene), [20, 40]);
    let (mut view, camera) = view_of(&gpu, &data);
    let walk = WalkGeometry::new(&trace, &data, usize::MAX);
    let settings = Settings { edges: false, cut: false, axes: false, ..Settings::default() };
    let seen =
        |view: &mut Scene3d, name: &str| drawn(&gpu, view, &camera, None, &settings, format!("painted-{name}")).0;
    let green = |pixels: &[u8]| {
        pixels.as_chunks::<4>().0.iter().filter(|p| i32::from(p[1]) > 40 + i32::from(p[0].max(p[2]))).count()
    };
    let (triangles, bright) = (data.info.triangles as usize, [30, 250, 30, 255]);
    let black = vec![[0, 0, 0, 255]; triangles];
    let materials = seen(&mut view, "materials");
    view.paint(&data, Some(&black), Vec::new());
    assert_eq!(green(&seen(&mut view, "black")), 0);
    view.paint(&data, Some(&vec![bright; triangles]), Vec::new());
    let all = green(&seen(&mut view, "green"));
    // Each triangle has its own colour, where it is: alone, they have as many pixels as all together, but for those on
    // their edges.
    let size = DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
    let mut alone = 0;
    for triangle in 0..triangles {
        let mut colors = black.clone();
        colors[triangle] = bright;
        view.paint(&data, Some(&colors), Vec::new());
        let pixels = seen(&mut view, "triangle");
        alone += green(&pixels);
        let corners = crate::walk::corners(&data, triangle as u32).expect("its corners");
        let corners = corners.map(|corner| camera.pixel(corner, size).expect("in front").0);
        let low = corners[0].min(corners[1]).min(corners[2]) - 1.0;
        let high = corners[0].max(corners[1]).max(corners[2]) + 1.0;
        for (i, pixel) in pixels.as_chunks::<4>().0.iter().enumerate().filter(|(_, pixel)| pixel[1] > 100) {
            let at = DVec2::new((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
            let is_green = i32::from(pixel[1]) > 40 + i32::from(pixel[0].max(pixel[2]));
            assert!(!is_green || at.cmpge(low).all() && at.cmple(high).all(), "triangle {triangle}: {at}");
        }
    }
    assert!(all > 50_000 && all.abs_diff(alone) < all / 20, "{all} green pixels, {alone} one by one");
    let boxed = PaintedBox { bounds: walk.bounds, color: [30, 250, 30, 120] };
    view.paint(&data, Some(&black), vec![boxed]);
    assert!(green(&seen(&mut view, "box")) > 50_000);
    view.paint(&data, None, Vec::new());
    assert!(seen(&mut view, "again") == materials, "the colours of materials come back");
}

#[test]
fn of_more_triangles_than_can_be_drawn_every_nth_is() {
    assert_eq!(Shown::of(0), Shown { drawn: 0, of: 0, every: 1 });
    assert_eq!(Shown::of(MOST_TRIANGLES).every, 1);
    assert_eq!(Shown::of(MOST_TRIANGLES).to_string(), "");
    let many = Shown::of(2 * MOST_TRIANGLES + 1);
    assert_eq!((many.every, many.drawn), (3, (2 * MOST_TRIANGLES + 1).div_ceil(3)));
    assert!(many.to_string().contains("one in 3"), "{many}");
}
