//! Several samples per pixel: the image is the mean of the images of its samples, in every configuration, and the image
//! with one sample is unchanged.

use std::ops::ControlFlow;

use raystep_kernels::plan::PlanError;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::renderer::image::Merge;
use raystep_kernels::{
    Accelerator, Device, Kernel, Limits, Numerics, Options, Plan, Ray, RaySource, Renderer, Sampler, Samples,
    ScheduleKind, StreamData,
};
use raystep_scenes::{Camera, Projection, Scene};
use raystep_tests::configurations::{Configuration, EVERY};
use raystep_tests::{block_on, devices, gpu, gpu_of, options, scene, traced, values};

const SIZE: [u32; 2] = [40, 30];

fn with(options: &Options, count: u32, sampler: Sampler) -> Options {
    Options { samples: Samples { count, sampler, seed: 3, first: 0 }, ..options.clone() }
}

fn after(options: &Options, first: u32, count: u32) -> Options {
    Options { samples: Samples { first, count, ..Samples::default() }, ..options.clone() }
}

fn room() -> (Scene, Options) {
    let scene = scene("cornell-box.gltf");
    let options = options(&scene, SIZE[0], SIZE[1]);
    (scene, options)
}

fn names(plan: &Plan) -> Vec<&'static str> {
    plan.schedule.kernels().into_iter().map(Kernel::name).collect()
}

#[test]
fn one_sample_leaves_everything_out_and_says_why() {
    let (scene, options) = room();
    for configuration in EVERY {
        let one = configuration.of(&options);
        let (plain, _) = Plan::new(&scene, &one, &Limits::CPU).expect("a plan");
        // With one sample, seed and sampler have no effect.
        let (seeded, _) = Plan::new(&scene, &with(&one, 1, Sampler::Random), &Limits::CPU).expect("a plan");
        assert_eq!(plain.to_string(), seeded.to_string(), "{configuration}");
        for part in ["kernel accumulate", "stream accumulated", "buffer sampling"] {
            let left_out = plain.left_out.iter().find(|l| l.what == part).expect(part);
            assert_eq!(left_out.reason, "needed only with --spp 2 or more");
        }
        let source: String = plain.variants.iter().map(|v| v.source.as_str()).collect();
        assert!(!source.contains("jitter") && !source.contains("accumulated"), "{configuration}");
        let (several, _) = Plan::new(&scene, &with(&one, 2, Sampler::Sobol), &Limits::CPU).expect("a plan");
        assert_eq!(names(&several), [names(&plain), vec!["accumulate"]].concat(), "{configuration}");
        assert!(
            !several.left_out.iter().any(|l| l.reason == "needed only with --spp 2 or more"),
            "{configuration}\n{several}"
        );
        let source: String = several.variants.iter().map(|v| v.source.as_str()).collect();
        assert!(source.contains("scrambled") && several.has_stream(streams::ACCUMULATED), "{configuration}");
        let (random, _) = Plan::new(&scene, &with(&one, 2, Sampler::Random), &Limits::CPU).expect("a plan");
        assert!(random.variants.iter().all(|v| !v.source.contains("scrambled")), "{configuration}");
    }
}

/// A camera whose single pixel has its centre at a sample of the given camera's pixel.
fn through(camera: &Camera, [x, y]: [f64; 2]) -> Camera {
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let half = match camera.projection {
        Projection::Perspective { vertical_fov } => (vertical_fov / 2.0).tan(),
        Projection::Orthographic { half_height } => half_height,
    };
    let across = camera.right * (half * aspect * (2.0 * x / f64::from(SIZE[0]) - 1.0));
    let up = camera.up * (half * (1.0 - 2.0 * y / f64::from(SIZE[1])));
    match camera.projection {
        Projection::Perspective { .. } => Camera { forward: camera.forward + across + up, ..camera.clone() },
        Projection::Orthographic { .. } => Camera { eye: camera.eye + across + up, ..camera.clone() },
    }
}

fn color(renderer: &Renderer, ray: usize) -> [f64; 3] {
    let colors = values(renderer, streams::COLOR);
    [0, 1, 2].map(|layer| f64::from(colors.get_f32(layer, ray)))
}

/// For some pixels, each sample is traced as an image of one pixel by the f64 twins.
#[test]
fn the_mean_of_four_is_that_of_four_pictures_of_one_sample() {
    let (scene, mut options) = room();
    let RaySource::Camera { camera, .. } = options.rays.clone() else { panic!("a camera") };
    for projection in [camera.projection, Projection::Orthographic { half_height: 0.9 }] {
        let camera = Camera { projection, ..camera.clone() };
        options.rays = RaySource::Camera { camera: camera.clone(), width: SIZE[0], height: SIZE[1] };
        for &sampler in Sampler::ALL {
            let run = traced(&scene, &with(&options, 4, sampler), &Device::CpuF64(None));
            for [x, y] in [[3, 2], [20, 15], [21, 3], [39, 29], [11, 22], [30, 8]] {
                let mut mean = [0.0; 3];
                for sample in 0..4 {
                    let [jx, jy] = sampler.place([x, y], sample, 3).map(f64::from);
                    let camera = through(&camera, [f64::from(x) + jx, f64::from(y) + jy]);
                    // Only the pixel's centre matters: any angle of view will do.
                    let rays = RaySource::Camera { camera, width: 1, height: 1 };
                    let one = traced(&scene, &Options { rays, ..options.clone() }, &Device::CpuF64(None));
                    let of_one = color(&one, 0);
                    (0..3).for_each(|c| mean[c] += of_one[c] / 4.0);
                }
                let found = color(&run, (y * SIZE[0] + x) as usize);
                for (found, mean) in found.into_iter().zip(mean) {
                    // The camera's f32 vectors differ by their rounding, some 2⁻²³ of the view plane, and shading turns
                    // that into an error of colour of the same size; the stream is rounded to f32.
                    assert!((found - mean).abs() < 2e-6, "{sampler} pixel {x},{y}: {found} and {mean}");
                }
            }
        }
    }
}

fn streams(renderer: &Renderer) -> [StreamData; 4] {
    [streams::COLOR, streams::ACCUMULATED, streams::HIT, streams::RAY_DIRECTION].map(|s| values(renderer, s))
}

/// On some GPUs t rounds differently in kernels that are compiled separately, and with it colours; not on the CPU, and
/// not on software Vulkan.
#[test]
fn every_way_ends_in_the_same_bits_and_so_does_the_second_run() {
    let (scene, options) = room();
    for (name, device) in devices() {
        let mut first: Option<[StreamData; 4]> = None;
        for configuration in EVERY {
            let renderer = traced(&scene, &with(&configuration.of(&options), 5, Sampler::Sobol), &device);
            assert_eq!(renderer.samples(), 5);
            let found = streams(&renderer);
            assert!(found[1].layer(4).iter().all(|&n| f32::from_bits(n) == 5.0), "{name} {configuration}");
            let mean: Vec<u32> = (0..3).flat_map(|layer| found[1].layer(layer).to_vec()).collect();
            assert!(mean == found[0].bits, "{name} {configuration}: color is the mean");
            let expected = first.get_or_insert_with(|| found.clone());
            assert!(*expected == found, "{name} {configuration}: other bits than {}", EVERY[0]);
            let again = traced(&scene, &with(&configuration.of(&options), 5, Sampler::Sobol), &device);
            assert!(streams(&again) == found, "{name} {configuration}: other bits the second time");
        }
    }
}

#[test]
fn gpu_and_twins_make_the_same_picture() {
    let (scene, options) = room();
    for numerics in [Numerics::Robust, Numerics::Paper] {
        let options = Options { numerics, ..with(&options, 8, Sampler::Sobol) };
        let picture = |device: Device| {
            let renderer = traced(&scene, &options, &device);
            block_on(gpu_of(&device), renderer.image()).expect("an image").pixels
        };
        let [on_gpu, on_cpu] = [Device::Gpu(gpu()), Device::Cpu(None)].map(picture);
        let pairs = || on_gpu.as_flattened().iter().zip(on_cpu.as_flattened());
        let apart = pairs().filter(|(a, b)| (*a - *b).abs() > 1e-5).count();
        // A ray that f32 cannot decide changes its pixel by an eighth.
        assert!(apart * 1000 < on_gpu.len(), "{numerics}: {apart} of {}", on_gpu.len());
    }
}

/// A run of sixteen samples passes through the results of shorter runs.
#[test]
fn a_run_can_be_read_after_every_sample_and_go_on() {
    let (scene, options) = room();
    for (name, device) in devices() {
        for configuration in [EVERY[0], EVERY[3], EVERY[4], EVERY[8]] {
            let options = configuration.of(&options);
            let image = |renderer: &Renderer| block_on(gpu_of(&device), renderer.image()).expect("an image");
            let mut long =
                block_on(gpu_of(&device), Renderer::new(&scene, &with(&options, 16, Sampler::Sobol), &device))
                    .expect("a renderer");
            assert_eq!((long.samples(), image(&long).pixels[0]), (0, [0.0; 4]));
            for samples in [2, 3, 8, 16] {
                let mut last = long.samples();
                let seen = |progress: &raystep_kernels::Progress| {
                    assert!((last..=samples).contains(&progress.samples) && progress.samples_wanted == 16);
                    last = progress.samples;
                    ControlFlow::Continue(())
                };
                block_on(gpu_of(&device), long.run_to_sample(samples, seen)).expect("a run");
                assert_eq!(long.samples(), samples, "{name} {configuration}");
                let short = traced(&scene, &with(&options, samples, Sampler::Sobol), &device);
                assert!(image(&long) == image(&short), "{name} {configuration}: after {samples}");
            }
            assert_eq!(long.next_kernel(), None);
            // Stepping pass by pass gives the same image, and a checkpoint in the middle of a sample can be restored.
            let end = image(&long);
            long.restart();
            block_on(gpu_of(&device), async {
                long.run_to_sample(5, |_| ControlFlow::Continue(())).await.expect("a run");
                long.step().await.expect("a pass");
                let (kept, place) = (long.checkpoint().await.expect("a checkpoint"), long.pass_count());
                long.run(|_| ControlFlow::Continue(())).await.expect("a run");
                let passes = long.passes().to_vec();
                long.restore(&kept).expect("its own");
                assert_eq!((long.samples(), long.pass_count()), (5, place));
                while long.step().await.expect("a pass").is_some() {}
                let kernels = |passes: &[raystep_kernels::Pass]| {
                    passes
                        .iter()
                        .map(|p| (p.index, p.iteration, p.kernel, p.rays_in, p.counts.clone()))
                        .collect::<Vec<_>>()
                };
                assert_eq!(kernels(long.passes()), kernels(&passes), "{name} {configuration}");
            });
            assert!(image(&long) == end, "{name} {configuration}: pass by pass");
        }
    }
}

/// The picture of 40 samples, in blocks of 16, 16 and 8: a run of all of them, and runs of one block each, in any order,
/// on a renderer of its own or on one that goes from block to block.
#[test]
fn blocks_of_samples_merge_to_the_picture_of_one_run() {
    let (scene, options) = room();
    let whole = with(&options, 40, Sampler::Sobol);
    for (name, device) in devices() {
        let image = |renderer: &Renderer| block_on(gpu_of(&device), renderer.image()).expect("an image");
        let mut long = block_on(gpu_of(&device), Renderer::new(&scene, &whole, &device)).expect("a renderer");
        let mut one = None::<Renderer>;
        let mut merge = Merge::new(SIZE[0], SIZE[1]);
        assert_eq!((merge.image(), whole.samples.blocks()), (None, 3));
        for block in 0..3 {
            let samples = whole.samples.part(block).expect("a block");
            let part = Options { samples, ..whole.clone() };
            let alone = image(&traced(&scene, &part, &device));
            let moved = match &mut one {
                Some(renderer) => renderer.take_samples(samples),
                empty => {
                    let begun = block_on(gpu_of(&device), Renderer::new(&scene, &part, &device));
                    *empty = Some(begun.expect("a renderer"));
                    true
                }
            };
            let renderer = one.as_mut().expect("begun");
            block_on(gpu_of(&device), renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
            assert!(moved && image(renderer) == alone, "{name}: block {block} of one renderer");
            assert!(merge.add(alone.clone(), samples.count), "{name}: block {block}");
            let so_far = samples.first + samples.count;
            assert_eq!((merge.samples(), so_far), (so_far, [16, 32, 40][block as usize]));
            block_on(gpu_of(&device), long.run_to_sample(so_far, |_| ControlFlow::Continue(()))).expect("a run");
            assert!(merge.image() == Some(image(&long)), "{name}: after {so_far} samples");
            assert!(block == 0 || alone != image(&long), "{name}: block {block} has samples of its own");
        }
        assert!(
            whole.samples.part(3).is_none() && !merge.add(image(&long), 16),
            "{name}: nothing follows half a block"
        );
        assert!(!long.take_samples(whole.samples.part(1).expect("a block")), "{name}: it has kernels for several");
        // In the streams, too: the sum of two blocks' means, and colours off by a rounding.
        let picture = image(&long);
        let colors = values(&long, streams::COLOR);
        let off = (0..3).flat_map(|c| (0..picture.pixels.len()).map(move |i| (c, i)));
        let off = off.map(|(c, i)| (colors.get_f32(c, i) - picture.pixels[i][c]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{name}: colours are off by {off}");
    }
}

#[test]
fn more_samples_are_nearer_to_the_mean_of_many() {
    let (scene, options) = room();
    let options = Configuration::new(Accelerator::Bvh, ScheduleKind::Compact, 8).of(&options);
    let device = Device::Cpu(None);
    let picture = |count, sampler| {
        let renderer = traced(&scene, &with(&options, count, sampler), &device);
        block_on(None, renderer.image()).expect("an image").pixels
    };
    let reference = picture(4096, Sampler::Sobol);
    let rmse = |pixels: &[[f32; 4]]| {
        let squares = pixels.as_flattened().iter().zip(reference.as_flattened()).map(|(a, b)| f64::from(a - b).powi(2));
        (squares.sum::<f64>() / reference.as_flattened().len() as f64).sqrt()
    };
    let [centre, few, many] = [1, 16, 256].map(|count| rmse(&picture(count, Sampler::Sobol)));
    let random = rmse(&picture(256, Sampler::Random));
    println!("RMSE: centre {centre:.2e}, 16 {few:.2e}, 256 {many:.2e}, 256 at random {random:.2e}");
    // 16 times the samples: an eighth of the error at edges; with random samples, a quarter.
    assert!(few < centre / 4.0 && many < few / 6.0 && many < random / 3.0);
}

#[test]
fn samples_that_mean_nothing_are_refused() {
    let (scene, options) = room();
    let given = RaySource::Given(vec![Ray::new([0.0; 3], [0.0, 0.0, -1.0])]);
    for (options, reason) in [
        (with(&options, 0, Sampler::Sobol), "1 to 65536"),
        (with(&options, 65_537, Sampler::Sobol), "1 to 65536"),
        (after(&options, 65_530, 7), "at most 65536"),
        (Options { rays: given.clone(), ..with(&options, 2, Sampler::Sobol) }, "input rays"),
        (Options { shade: false, ..with(&options, 2, Sampler::Sobol) }, "does not shade"),
    ] {
        let error = Plan::new(&scene, &options, &Limits::CPU).map(|_| ()).expect_err(reason);
        assert!(matches!(error, PlanError::Samples { .. }) && error.to_string().contains(reason), "{error}");
    }
    for options in [
        Options { rays: given, ..with(&options, 1, Sampler::Random) },
        Options { shade: false, ..with(&options, 1, Sampler::Random) },
        with(&options, 65_536, Sampler::Random),
        after(&options, 65_530, 6),
    ] {
        assert!(Plan::new(&scene, &options, &Limits::CPU).is_ok());
    }
}
