//! The history of a ray that the CPU reference kernels tell alone is that of the run's own streams, row by row; and what
//! is predicted after the known passes is what comes.

use std::ops::ControlFlow;

use raystep_kernels::export::trace::{RayState, RunSoFar, Trace, TraceRow};
use raystep_kernels::{Accelerator, Device, Options, Ray, RaySource, Region, Renderer, Samples, ScheduleKind};
use raystep_tests::configurations::Configuration;
use raystep_tests::{block_on, devices, gpu_of, options, scene, scene_files};

const WIDTH: u32 = 20;
const HEIGHT: u32 = 10;

fn pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..WIDTH * HEIGHT).map(|ray| [ray % WIDTH, ray / WIDTH])
}

/// All rays as they are now.
async fn states(renderer: &Renderer) -> Vec<RayState> {
    let rays = renderer.plan().program.rays.expect("rays");
    let whole = Region { x: 0, y: 0, width: WIDTH, height: HEIGHT };
    let mut streams = Vec::new();
    for stream in rays.streams.iter().copied().filter(|&stream| renderer.plan().has_stream(stream)) {
        streams.push(renderer.region(stream, whole).await.expect("a stream"));
    }
    let of = |ray: usize| {
        let texels: Vec<Vec<u32>> =
            streams.iter().map(|s| (0..s.stream.layers()).map(|layer| s.layer(layer)[ray]).collect()).collect();
        (rays.decode)(&|stream| streams.iter().position(|s| s.stream == stream).map(|i| texels[i].as_slice()))
    };
    (0..(WIDTH * HEIGHT) as usize).map(of).collect()
}

/// The rows of every ray, from the streams before and after each pass.
async fn rows(renderer: &mut Renderer) -> Vec<Vec<TraceRow>> {
    let mut rows = vec![Vec::new(); (WIDTH * HEIGHT) as usize];
    let mut before = states(renderer).await;
    while let Some(pass) = renderer.step().await.expect("a pass") {
        let after = states(renderer).await;
        for ((rows, before), after) in rows.iter_mut().zip(&before).zip(&after) {
            if pass.kernel.takes().contains(&before.tag) {
                rows.push(TraceRow::new(&pass, renderer.data(), before, after));
            }
        }
        before = after;
    }
    rows
}

fn follow(renderer: &Renderer, known: usize, pixel: [u32; 2], is_f64: bool) -> Option<Trace> {
    let passes = renderer.passes();
    let (plan, data) = (renderer.plan(), renderer.data());
    let run = RunSoFar { plan, data, passes: &passes[..known], is_complete: known == passes.len() };
    if is_f64 { run.follow::<f64>(pixel) } else { run.follow::<f32>(pixel) }
}

/// Debug prints every float so that it reads back as the same bits.
fn text(rows: &[TraceRow]) -> Vec<String> {
    rows.iter().map(|row| format!("{row:?}")).collect()
}

fn check(label: &str, options: &Options, scene: &raystep_scenes::Scene, device: &Device) {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
        let expected = rows(&mut renderer).await;
        let passes = renderer.passes().len();
        let is_f64 = matches!(device, Device::CpuF64(_));
        for (pixel, expected) in pixels().zip(&expected) {
            let whole = follow(&renderer, passes, pixel, is_f64).expect("a history");
            assert_eq!(text(&whole.rows), text(expected), "{label}, ray {pixel:?}");
            assert_eq!((whole.passes, whole.rays), (Some(passes), renderer.plan().rays), "{label}");
        }
        // What comes after a few passes, or after none.
        let is_told = renderer.plan().can_go_alone();
        for (pixel, expected) in pixels().zip(&expected).step_by(23) {
            for known in [0, passes / 3] {
                let predicted = follow(&renderer, known, pixel, is_f64).expect("a history");
                assert_eq!(predicted.rows.len(), expected.len(), "{label}, ray {pixel:?} after {known}");
                for (row, expected) in predicted.rows.iter().zip(expected) {
                    let is_walk = row.kernel != "shade" && is_told;
                    let pass = row.pass.or(expected.pass.filter(|pass| *pass >= known && !is_walk));
                    let row = TraceRow { pass, ..row.clone() };
                    assert_eq!(format!("{row:?}"), format!("{expected:?}"), "{label}, ray {pixel:?} after {known}");
                }
            }
        }
    });
}

#[test]
fn a_ray_alone_has_the_history_that_the_streams_tell() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, First, Second};
    let configurations = [
        Configuration::new(Grid, Compact, 1).skipping(),
        Configuration::new(Bvh, Compact, 1),
        Configuration::new(Grid, Second, 1),
        Configuration::new(Grid, Second, 1).paper(),
        Configuration::new(Grid, First, 1),
        Configuration::new(Grid, Compact, 8),
        Configuration::new(None, Second, 1),
    ];
    for file in scene_files() {
        let scene = scene(&file);
        for (i, configuration) in
            configurations.iter().enumerate().filter(|(_, w)| w.accelerator != None || scene.triangles.len() <= 200)
        {
            // On the adapter the two usual configurations; all of them for one scene.
            let on_adapter = i < 2 || file == "cornell-box.gltf";
            for (name, device) in devices().into_iter().filter(|(name, _)| *name == "cpu" || on_adapter) {
                check(
                    &format!("{file} {name} {configuration}"),
                    &configuration.of(&options(&scene, WIDTH, HEIGHT)),
                    &scene,
                    &device,
                );
            }
        }
    }
    let scene = scene("cornell-box.gltf");
    let options = options(&scene, WIDTH, HEIGHT);
    let configuration = configurations[0];
    check("f64", &configuration.of(&options), &scene, &Device::CpuF64(Option::None));
    let samples = Samples { count: 3, ..Samples::default() };
    check("samples", &Options { samples, ..configuration.of(&options) }, &scene, &Device::Cpu(Option::None));
}

#[test]
fn what_a_ray_alone_cannot_tell_is_not_told() {
    let scene = scene("cornell-box.gltf");
    let camera = options(&scene, WIDTH, HEIGHT);
    let given = Options::new(RaySource::Given(vec![Ray::new([0.0; 3], [0.0, 0.0, 1.0]); 9]));
    let fused = Options { schedule: ScheduleKind::Fused, ..camera.clone() };
    block_on(None, async {
        for (options, pixel) in [(&camera, [WIDTH, 0]), (&camera, [0, HEIGHT]), (&given, [0, 0]), (&fused, [0, 0])] {
            let mut renderer = Renderer::new(&scene, options, &Device::Cpu(None)).await.expect("a renderer");
            renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
            assert_eq!(follow(&renderer, renderer.passes().len(), pixel, false), None, "{options:?} {pixel:?}");
        }
    });
}
