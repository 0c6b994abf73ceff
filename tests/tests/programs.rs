//! A program whose elements are not rays: the same on every executor, forwards and back, edited and watched.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use raystep_inspector::{Session, Target, Watch, Way, go_on};
use raystep_kernels::options::ProgramName;
use raystep_kernels::programs::grid_build::PROGRAM;
use raystep_kernels::programs::grid_build::elements::{REFERENCES, SPANS};
use raystep_kernels::programs::grid_build::streams::{BOX, FIRST_SPAN};
use raystep_kernels::renderer::Lists;
use raystep_kernels::structures::grid;
use raystep_kernels::{Device, GridSize, Limits, Options, Plan, RenderError, Renderer, StreamData};
use raystep_lab::lockstep::lockstep;
use raystep_scenes::Scene;
use raystep_tests::sessions::go;
use raystep_tests::{block_on, devices, gpu, gpu_of, options, parity, scene, streams_of};

fn build(scene: &Scene, grid: GridSize) -> Options {
    Options { program: ProgramName::GridBuild, grid, ..options(scene, 8, 8) }
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

fn scenes() -> Vec<(Scene, GridSize)> {
    vec![
        (scene("cornell-box.gltf"), GridSize::Auto),
        (scene("teapot.glb"), GridSize::Auto),
        (scene("teapot.glb"), GridSize::Cells([70, 3, 40])),
        (raystep_scenes::generate::soup(300, 4).expect("soup"), GridSize::Cells([16, 16, 17])),
        (Scene { materials: scene("cornell-box.gltf").materials, ..Scene::default() }, GridSize::Auto),
    ]
}

#[test]
fn every_pass_of_a_build_leaves_the_same_on_gpu_and_twins_and_the_lists_are_the_hosts() {
    let gpu = Device::Gpu(gpu());
    for (scene, size) in scenes() {
        let options = build(&scene, size);
        block_on(gpu_of(&gpu), async {
            let mut ours = Renderer::new(&scene, &options, &gpu).await?;
            let mut twins = Renderer::new(&scene, &options, &Device::Cpu(None)).await?;
            let found = lockstep(&mut ours, &mut twins, |_| ControlFlow::Continue(())).await?;
            assert_eq!(found.first, None, "{}", scene.name);
            assert!(found.passes >= 14 && ours.next_kernel().is_none() && twins.next_kernel().is_none(), "{found:?}");
            assert_eq!(known_streams(&ours).await, known_streams(&twins).await);
            let data = ours.data();
            let host = grid::lists(&data.grid, data.growth, &data.vertices, u64::MAX).expect("lists");
            let lists = Lists::of(&ours).await?;
            assert_eq!((&lists.cells, &lists.items), (&host.cells, &host.items), "{}", scene.name);
            let references = ours.size(&REFERENCES).map(|size| size.count as usize);
            assert_eq!(references, Some(lists.items.len()));
            Ok::<(), RenderError>(())
        })
        .expect("both builds");
    }
}

#[test]
fn a_broken_kernel_of_a_build_is_named() {
    let (limits, gpu) = (Limits::from(&*gpu()), Device::Gpu(gpu()));
    let scene = scene("teapot.glb");
    let mut rows = BTreeSet::new();
    for kernel in PROGRAM.kernels() {
        let row = kernel.info();
        assert!(!row.breaks.is_empty(), "nothing breaks {}", row.name);
        // Once per row, however often the program contains the kernel: all its variants are broken.
        for broken in row.breaks.iter().filter(|_| rows.insert(row.name)) {
            let mut options = build(&scene, GridSize::Auto);
            (broken.run)(&mut options);
            block_on(gpu_of(&gpu), async {
                let (mut plan, data) = Plan::new(&scene, &options, &limits)?;
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
    assert_eq!(rows.len(), 9);
}

#[test]
fn a_build_goes_back_and_forth_as_it_went() {
    let scene = scene("teapot.glb");
    for (_, device) in devices() {
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
            let fired = session.run_to_watch(&[Watch::RayState], Way::Forward, &mut go_on).await?.expect("a change");
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
