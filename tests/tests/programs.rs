//! A program whose elements are not rays: the same on every executor, forwards and back, edited and watched.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use raystep_inspector::{Direction, Session, Target, Watch, go_on};
use raystep_kernels::options::ProgramName;
use raystep_kernels::programs::grid_build::PROGRAM;
use raystep_kernels::programs::grid_build::elements::{REFERENCES, SPANS};
use raystep_kernels::programs::grid_build::streams::{
    BOX, CELL, FIRST_SPAN, ITEM, MAP_BELOW, MAP_TOP, START, TRIANGLE_EVEN,
};
use raystep_kernels::renderer::{Lists, build_on_host};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::structures::grid;
use raystep_kernels::structures::irregular::IrregularData;
use raystep_kernels::{
    Accelerator, BuiltBy, Device, GridSize, Limits, Options, Plan, RenderError, Renderer, StreamData,
};
use raystep_lab::lockstep::lockstep;
use raystep_scenes::{Scene, generate};
use raystep_tests::sessions::go;
use raystep_tests::{block_on, devices, gpu, gpu_of, options, parity, scene, streams_of};

fn build(scene: &Scene, grid: GridSize) -> Options {
    Options { program: ProgramName::GridBuild, grid, ..options(scene, 8, 8) }
}

fn irregular(scene: &Scene) -> Options {
    Options { accelerator: Accelerator::Irregular, ..build(scene, GridSize::Auto) }
}

/// All streams whose number of elements is known.
async fn known_streams(renderer: &Renderer) -> Vec<StreamData> {
    let mut all = Vec::new();
    for stream in streams_of(renderer.plan()) {
        match renderer.values(stream).await {
            Ok(values) => all.push(values),
            Err(error) => assert!(matches!(error, RenderError::NotCounted { .. }), "{error}"),
        }
    }
    all
}

fn scenes() -> Vec<(Scene, Options)> {
    let soup = generate::soup(300, 4).expect("soup");
    let nothing = Scene { materials: scene("cornell-box.gltf").materials, ..Scene::default() };
    let sized = |scene: Scene, grid| {
        let options = build(&scene, grid);
        (scene, options)
    };
    let irregular = |scene: Scene| {
        let options = irregular(&scene);
        (scene, options)
    };
    vec![
        sized(scene("cornell-box.gltf"), GridSize::Auto),
        sized(scene("teapot.glb"), GridSize::Auto),
        sized(scene("teapot.glb"), GridSize::Cells([70, 3, 40])),
        sized(soup.clone(), GridSize::Cells([16, 16, 17])),
        sized(nothing.clone(), GridSize::Auto),
        // Half of its triangles are in one cell, which is divided.
        sized(crowd(), GridSize::Auto),
        irregular(scene("cornell-box.gltf")),
        irregular(generate::soup(60, 4).expect("soup")),
        irregular(nothing),
        // Twelve triangles are set aside.
        irregular(generate::tiny_in_room(200, 100).expect("a room")),
    ]
}

/// Triangles all over a cube, and as many at one place in it.
fn crowd() -> Scene {
    let mut scene = generate::soup(600, 4).expect("soup");
    let mut knot = scene.triangles.clone();
    knot.iter_mut().flatten().flatten().for_each(|v| *v = 0.3 + 0.01 * *v);
    scene.triangles.extend(knot);
    scene.triangle_materials.extend(scene.triangle_materials.clone());
    scene
}

#[test]
fn every_pass_of_a_build_leaves_the_same_on_gpu_and_twins_and_the_grid_is_the_hosts() {
    let gpu = Device::Gpu(gpu());
    let (mut divided, mut aside) = (0, 0);
    for (scene, options) in scenes() {
        block_on(gpu_of(&gpu), async {
            let mut ours = Renderer::new(&scene, &options, &gpu).await?;
            let mut twins = Renderer::new(&scene, &options, &Device::Cpu(None)).await?;
            let found = lockstep(&mut ours, &mut twins, |_| ControlFlow::Continue(())).await?;
            assert_eq!(found.first, None, "{}", scene.name);
            assert!(
                found.compared.total().passes >= 14 && ours.next_kernel().is_none() && twins.next_kernel().is_none(),
                "{found:?}"
            );
            assert_eq!(known_streams(&ours).await, known_streams(&twins).await);
            let data = ours.data();
            if ours.plan().accelerator == Accelerator::Irregular {
                let host = build_on_host(data, u64::MAX).expect("a grid");
                let built = IrregularData::of(&ours).await?;
                assert!(built == host, "{}", scene.name);
                divided += usize::from(options.accelerator == Accelerator::Grid);
                aside += built.aside;
            } else {
                let host = grid::lists(&data.grid, data.growth, &data.vertices, u64::MAX).expect("lists");
                let lists = Lists::of(&ours).await?;
                assert_eq!((&lists.cells, &lists.items), (&host.cells, &host.items), "{}", scene.name);
                let references = ours.size(&REFERENCES).map(|size| size.count as usize);
                assert_eq!(references, Some(lists.items.len()));
            }
            Ok::<(), RenderError>(())
        })
        .expect("both builds");
    }
    assert_eq!((divided, aside), (1, 12));
}

/// What is traced through a grid that the device has built is what is traced through that of the host.
#[test]
fn a_grid_built_on_the_device_is_traced_like_that_of_the_host() {
    for (_, device) in devices() {
        for (scene, options) in scenes() {
            let options = Options { program: ProgramName::ClosestHit, ..options };
            block_on(gpu_of(&device), async {
                let (host_plan, host) = Plan::on(&scene, &options, &device).await?;
                let on_device = Options { build: BuiltBy::Device, ..options.clone() };
                let (plan, data) = Plan::on(&scene, &on_device, &device).await?;
                assert_eq!(plan.features, host_plan.features, "{}", scene.name);
                let sources = |plan: &Plan| plan.variants.iter().map(|v| v.source.clone()).collect::<Vec<_>>();
                assert!(sources(&plan) == sources(&host_plan), "{}", scene.name);
                assert_eq!((data.grid, data.growth, data.bounds), (host.grid, host.growth, host.bounds));
                assert_eq!((data.reach, plan.pass_bound), (host.reach, host_plan.pass_bound), "{}", scene.name);
                let words = |data: &SceneData| {
                    let of_grid = [&data.grid_cells, &data.grid_items, &data.grid_distances];
                    let of_irregular = [&data.irregular_map, &data.irregular_items, &data.irregular_lengths];
                    [of_grid, of_irregular].as_flattened().iter().map(|&words| words.clone()).collect::<Vec<_>>()
                };
                assert!(words(&data) == words(&host), "{}", scene.name);
                assert!(data.irregular_cells == host.irregular_cells, "{}", scene.name);
                Ok::<(), RenderError>(())
            })
            .expect("both plans");
        }
    }
}

/// A grid in which something is wrong is not used.
#[test]
fn a_grid_with_a_fault_is_refused() {
    for (_, device) in devices() {
        let scene = scene("cornell-box.gltf");
        // In each of what is checked, before it is checked.
        let faults = [
            (build(&scene, GridSize::Auto), START, 0, u32::MAX, "check_starts"),
            (build(&scene, GridSize::Auto), TRIANGLE_EVEN, 0, 36, "check_even"),
            (irregular(&scene), ITEM, 0, 36, "check_items"),
            (irregular(&scene), CELL, 3, 1 << 20, "check_cells"),
            (irregular(&scene), CELL, 0, u32::MAX, "check_cells"),
            (irregular(&scene), MAP_TOP, 0, u32::MAX, "check_top"),
            (irregular(&scene), MAP_BELOW, 0, 1, "check_blocks"),
        ];
        for (options, stream, layer, value, kernel) in faults {
            block_on(gpu_of(&device), async {
                let mut renderer = Renderer::new(&scene, &options, &device).await?;
                while renderer.next_kernel().is_some_and(|next| next.name() != kernel) {
                    renderer.step().await?;
                }
                let mut values = renderer.values(stream).await?;
                let texels = values.layer(layer).len();
                values.bits[layer * texels + 1] = value;
                assert!(renderer.write(&values));
                renderer.run(|_| ControlFlow::Continue(())).await?;
                let refused = match renderer.plan().accelerator {
                    Accelerator::Irregular => IrregularData::of(&renderer).await.err(),
                    _ => Lists::of(&renderer).await.err(),
                };
                assert!(matches!(refused, Some(RenderError::Faulty(_))), "{kernel}: {refused:?}");
                Ok::<(), RenderError>(())
            })
            .expect("a build");
        }
    }
}

#[test]
fn a_broken_kernel_of_a_build_is_named() {
    let (limits, gpu) = (Limits::from(&*gpu()), Device::Gpu(gpu()));
    let (teapot, box_scene) = (scene("teapot.glb"), scene("cornell-box.gltf"));
    let mut rows = BTreeSet::new();
    for kernel in PROGRAM.kernels() {
        let row = kernel.info();
        assert!(!row.breaks.is_empty(), "nothing breaks {}", row.name);
        // Once per row, however often the program contains the kernel: all its variants are broken.
        if !rows.insert(row.name) {
            continue;
        }
        for broken in row.breaks {
            let mut options = build(&teapot, GridSize::Auto);
            (broken.run)(&mut options);
            // The smaller scene is enough for kernels that only build irregular grids.
            let is_irregular = options.accelerator == Accelerator::Irregular;
            let scene = if is_irregular { &box_scene } else { &teapot };
            block_on(gpu_of(&gpu), async {
                let (mut plan, data) = Plan::new(scene, &options, &limits)?;
                let mut twins = Renderer::from_plan(plan.clone(), data.clone(), &options, &Device::Cpu(None)).await?;
                for variant in plan.variants.iter_mut().filter(|v| v.kernel.info().name == row.name) {
                    variant.source = parity::change(&variant.source, broken.from, broken.to);
                }
                let mut ours = Renderer::from_plan(plan, data, &options, &gpu).await?;
                let found = lockstep(&mut ours, &mut twins, |_| ControlFlow::Continue(())).await?;
                let named = found.first.as_ref().map(|first| first.kernel.info().name);
                assert_eq!(named, Some(row.name), "{:?}", broken.to);
                Ok::<(), RenderError>(())
            })
            .expect("both builds");
        }
    }
    assert_eq!(rows.len(), 37);
}

#[test]
fn a_build_goes_back_and_forth_as_it_went() {
    let scene = scene("teapot.glb");
    // Its loops run a few times each, and its sets of elements change their sizes.
    let small = generate::soup(20, 4).expect("soup");
    for (_, device) in devices() {
        block_on(gpu_of(&device), async {
            let mut session = Session::new(&small, &irregular(&small), &device).await?;
            let mut after = vec![known_streams(session.renderer()).await];
            while go(&mut session, Target::Next).await == after.len() {
                after.push(known_streams(session.renderer()).await);
            }
            let last = after.len() - 1;
            for place in [last - 1, 60, 80, 40, 100, last, 35, 36] {
                assert_eq!(go(&mut session, Target::Pass(place)).await, place);
                assert!(known_streams(session.renderer()).await == after[place], "{place} of {last}");
            }
            Ok::<(), RenderError>(())
        })
        .expect("a session");
        block_on(gpu_of(&device), async {
            let mut session = Session::new(&scene, &build(&scene, GridSize::Auto), &device).await?;
            let mut after = vec![known_streams(session.renderer()).await];
            while go(&mut session, Target::Next).await == after.len() {
                after.push(known_streams(session.renderer()).await);
            }
            let last = after.len() - 1;
            assert!(last > 20 && after[0].len() < after[last].len(), "streams appear once their elements are counted");
            // Across both passes that count elements, and to the start.
            for place in [last - 1, 3, 9, 4, 0, last, 8, 1] {
                assert_eq!(go(&mut session, Target::Pass(place)).await, place);
                assert!(known_streams(session.renderer()).await == after[place], "{place}");
            }
            assert_eq!(go(&mut session, Target::Previous).await, 0);
            assert!(session.renderer().size(&SPANS).is_none());

            // Twins first, then the device: the same as if the device had run everything.
            session.twins_until(Some(6), &mut go_on).await?;
            go(&mut session, Target::End).await;
            assert!(known_streams(session.renderer()).await == after[last]);
            session.twins_until(None, &mut go_on).await?;

            // Edits affect what follows: a triangle's spans start elsewhere.
            go(&mut session, Target::Pass(1)).await;
            session.edit(FIRST_SPAN, 0, 2, 0, 7).await?;
            go(&mut session, Target::Pass(4)).await;
            assert!(known_streams(session.renderer()).await != after[4]);
            session.clear_edits(&mut go_on).await?;
            assert!(known_streams(session.renderer()).await == after[4]);

            // The first pass gives the selected triangle its box.
            go(&mut session, Target::Start).await;
            session.select(5, 0);
            let fired =
                session.run_to_watch(&[Watch::RayState], Direction::Forward, &mut go_on).await?.expect("a change");
            assert_eq!(fired.place, 1);
            assert!(fired.value.starts_with("box."), "{}", fired.value);
            let texel = session.renderer().texel(BOX, 5, 0).await?;
            assert!(texel[3..] != [0; 3], "{texel:?}");
            Ok::<(), RenderError>(())
        })
        .expect("a session");
    }
}

#[test]
fn a_checkpoint_keeps_how_many_elements_there_were() {
    let scene = scene("teapot.glb");
    for (_, device) in devices() {
        block_on(gpu_of(&device), async {
            let mut renderer = Renderer::new(&scene, &build(&scene, GridSize::Auto), &device).await?;
            let (mut kept, mut after) = (Vec::new(), Vec::new());
            loop {
                kept.push(renderer.checkpoint().await?);
                after.push(known_streams(&renderer).await);
                if renderer.step().await?.is_none() {
                    break;
                }
            }
            let last = after.len() - 1;
            for place in [2, 20, 6, last, 0, 10] {
                renderer.restore(&kept[place])?;
                assert!(known_streams(&renderer).await == after[place], "{place}");
            }
            while renderer.step().await?.is_some() {}
            assert!(known_streams(&renderer).await == after[last]);
            Ok::<(), RenderError>(())
        })
        .expect("a build");
    }
}
