//! Going back restores every stream bit for bit, however few checkpoints are kept; kernels and iterations are found.

use std::ops::ControlFlow;

use raystep_inspector::{Session, Target, go_on};
use raystep_kernels::export::trace::{Rays, trace};
use raystep_kernels::options::ProgramName;
use raystep_kernels::options::mapping::{Fragment, Mapping, Update};
use raystep_kernels::programs::closest_hit::{kernels, streams};
use raystep_kernels::{Accelerator, Device, Options, RenderError, Samples, ScheduleKind, StreamData};
use raystep_scenes::Scene;
use raystep_tests::configurations::{Configuration, STEPPED, stepped};
use raystep_tests::sessions::{go, streams};
use raystep_tests::{block_on, devices, gpu, gpu_of, options, scene};

const TREE: Configuration = Configuration::new(Accelerator::Bvh, ScheduleKind::Second, 1);

/// Streams after every pass, starting with none.
async fn history(session: &mut Session) -> Vec<Vec<StreamData>> {
    let mut seen = vec![streams(session).await];
    while go(session, Target::Next).await == seen.len() {
        seen.push(streams(session).await);
    }
    seen
}

#[test]
fn every_pass_looks_the_same_when_it_is_reached_again() {
    let configurations = [
        ("cornell-box.gltf", STEPPED),
        ("cornell-box.gltf", TREE),
        ("flat.gltf", STEPPED),
        ("flat.gltf", TREE),
        ("teapot.glb", STEPPED),
        ("teapot.glb", TREE),
        // Lists of active rays have another order each time; results must not depend on it.
        ("cornell-box.gltf", Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 1)),
        ("cornell-box.gltf", Configuration::new(Accelerator::Bvh, ScheduleKind::Compact, 1)),
        ("cornell-box.gltf", Configuration::new(Accelerator::None, ScheduleKind::Compact, 2)),
    ];
    for (name, device) in devices() {
        for (file, configuration) in configurations {
            let scene = scene(file);
            check_history(
                &scene,
                &configuration.of(&options(&scene, 12, 10)),
                &device,
                &format!("{file} {name} {configuration}"),
            );
        }
    }
}

/// Textures that take turns must do so when they are restored, too.
#[test]
fn passes_that_are_drawn_look_the_same_when_they_are_reached_again() {
    let scene = scene("cornell-box.gltf");
    for update in [Update::Copy, Update::Swap] {
        let mapping = Mapping::Fragment(Fragment::of(None, Some(update), None, None));
        let options = Options { mapping, ..STEPPED.of(&options(&scene, 12, 10)) };
        check_history(&scene, &options, &Device::Gpu(gpu()), &mapping.to_string());
    }
}

fn check_history(scene: &Scene, options: &Options, device: &Device, which: &str) {
    block_on(gpu_of(device), async {
        let mut session = Session::new(scene, options, device).await.expect("a session");
        // Pretend that these few rays are many, for a checkpoint every few passes.
        session.set_span(3 * 120);
        let seen = history(&mut session).await;
        let last = seen.len() - 1;
        assert!(last > 10, "{which}: {last} passes");
        let (all, most) = (session.kept_bytes(), session.kept_places().count());
        assert!(most > 1, "{which}: nothing was kept of {last} passes");
        for budget in [u64::MAX, all / 2, 0] {
            session.set_budget(budget);
            assert!(session.kept_bytes() <= budget);
            assert_eq!(go(&mut session, Target::End).await, last);
            // One pass at a time down to the start; with nothing kept that takes long, so skip some.
            let every = if budget == 0 { 1 + last / 12 } else { 1 };
            for place in (0..last).rev().step_by(every) {
                let target = if every == 1 { Target::Previous } else { Target::Pass(place) };
                assert_eq!(go(&mut session, target).await, place, "{which}");
                let now = streams(&session).await;
                assert!(now == seen[place], "{which}: after {place} passes, budget {budget}");
                assert!(session.kept_bytes() <= budget);
            }
            for place in [3, last, 1, last / 2, last / 3] {
                assert_eq!(go(&mut session, Target::Pass(place)).await, place);
                assert!(streams(&session).await == seen[place], "{which}: at {place}");
            }
            assert_eq!(session.known().len(), last);
        }
    });
}

#[test]
fn what_is_kept_lies_evenly() {
    let scene = scene("teapot.glb");
    block_on(None, async {
        let options = stepped(&scene, 16, 16);
        let mut session = Session::new(&scene, &options, &Device::Cpu(None)).await.expect("a session");
        session.set_span(1);
        let last = go(&mut session, Target::End).await;
        assert_eq!(session.kept_places().count(), last, "after every pass");
        session.set_budget(session.kept_bytes() / 20);
        for _ in 0..2 {
            let places: Vec<usize> = [0].into_iter().chain(session.kept_places()).chain([last]).collect();
            let cost = |place: usize| session.known()[..place].iter().map(|p| p.threads_launched).sum::<u64>();
            let gaps: Vec<u64> = places.windows(2).map(|w| cost(w[1]) - cost(w[0])).collect();
            let longest = gaps.iter().max().copied().unwrap_or(0);
            assert!(places.len() > 8, "{places:?}");
            assert!(longest < 4 * cost(last) / places.len() as u64, "{places:?}: {longest} of {}", cost(last));
            // Again from the start, with this budget throughout.
            session = Session::new(&scene, &options, &Device::Cpu(None)).await.expect("a session");
            session.set_span(1);
            session.set_budget(session.renderer().plan().bytes() * 12);
            go(&mut session, Target::End).await;
        }
    });
}

#[test]
fn the_place_before_the_last_pass_is_kept_and_kept_longest() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        block_on(gpu_of(&device), async {
            let options = stepped(&scene, 16, 16);
            let mut session = Session::new(&scene, &options, &device).await.expect("a session");
            // A checkpoint about every ten passes; only by chance would one lie before the end.
            session.set_span(2560);
            let last = go(&mut session, Target::End).await;
            let places: Vec<usize> = session.kept_places().collect();
            assert_eq!(session.passes().last().map(|pass| pass.kernel), Some(kernels::SHADE));
            // All hits are known there; a pass of the walk without rays may be left, and then the last one.
            assert!(places.len() < last / 2 && places.last() >= Some(&(last - 2)), "{name}: {places:?} of {last}");
            let shown = streams(&session).await;
            assert_eq!(go(&mut session, Target::Previous).await, last - 1);
            assert_eq!(go(&mut session, Target::Next).await, last);
            assert!(streams(&session).await == shown, "{name}");
            // Among many, it is dropped last.
            let mut session = Session::new(&scene, &options, &device).await.expect("a session");
            session.set_span(1);
            assert_eq!(go(&mut session, Target::End).await, last);
            session.set_budget(session.kept_bytes() / 3);
            let places: Vec<usize> = session.kept_places().collect();
            assert!(places.len() < last / 2 && places.last() == Some(&(last - 1)), "{name}: {places:?} of {last}");
            session.set_budget(0);
            assert_eq!(session.kept_places().count(), 0);
        });
    }
}

#[test]
fn a_kernel_is_found_forward_and_back_and_a_ray_is_followed() {
    let scene = scene("cornell-box.gltf");
    let device = Device::Cpu(None);
    block_on(None, async {
        let mut session = Session::new(&scene, &stepped(&scene, 16, 16), &device).await.expect("a session");
        let traverse = Target::NextOf(kernels::TRAVERSE_GRID);
        let first = go(&mut session, traverse).await;
        let second = go(&mut session, traverse).await;
        assert!(first < second && session.passes()[second - 1].kernel == kernels::TRAVERSE_GRID);
        assert_eq!(go(&mut session, Target::PreviousOf(kernels::TRAVERSE_GRID)).await, first);
        assert_eq!(go(&mut session, traverse).await, second, "found among known passes");

        assert_eq!(session.select(16, 0), None, "outside");
        assert_eq!(session.ray().await.expect("a ray"), None);
        assert_eq!(session.select(8, 8), Some([8, 8]));
        let last = go(&mut session, Target::End).await;
        let ray = session.ray().await.expect("a ray").expect("selected");
        assert!(ray.state == "DONE" && ray.triangle.is_some() && ray.color.is_some());
        assert_eq!(go(&mut session, Target::Start).await, 0);
        assert_eq!(session.ray().await.expect("a ray").expect("selected").state, "UNWRITTEN");

        go(&mut session, Target::Pass(5)).await;
        let history = session.follow([8, 8], &mut go_on).await.expect("a history");
        assert_eq!((session.place(), history.passes), (5, Some(last)), "it returns");
        let mut renderer =
            raystep_kernels::Renderer::new(&scene, session.options(), &device).await.expect("a renderer");
        let go_on = |_: &raystep_kernels::Pass| ControlFlow::Continue(());
        let told = trace(&mut renderer, 8, 8, Rays::All, go_on).await.expect("a trace");
        assert_eq!(history, told);
    });
}

#[test]
fn turns_of_the_loop_begin_and_end() {
    let scene = scene("cornell-box.gltf");
    for schedule in [ScheduleKind::First, ScheduleKind::Second] {
        block_on(None, async {
            let options = Configuration::new(Accelerator::Grid, schedule, 1).of(&options(&scene, 16, 16));
            let mut session = Session::new(&scene, &options, &Device::Cpu(None)).await.expect("a session");
            let mut ends = vec![0];
            loop {
                let place = go(&mut session, Target::IterationEnd).await;
                if Some(&place) == ends.last() {
                    break;
                }
                ends.push(place);
            }
            let passes = session.passes().to_vec();
            assert_eq!(ends.last(), Some(&passes.len()));
            assert_eq!(ends[1], 2, "generate and setup are an iteration of their own");
            for w in ends[1..ends.len() - 1].windows(2) {
                let turn = &passes[w[0]..w[1]];
                assert!(turn.iter().all(|p| p.iteration == turn[0].iteration), "{turn:?}");
                assert_eq!(turn.iter().filter(|p| p.kernel == kernels::TRAVERSE_GRID).count(), 1, "{schedule}");
            }
            for &end in ends[..ends.len() - 1].iter().rev() {
                assert_eq!(go(&mut session, Target::IterationStart).await, end, "{schedule}");
            }
            // The same forwards, now that the passes are known.
            for &end in &ends[1..] {
                assert_eq!(go(&mut session, Target::IterationEnd).await, end, "{schedule}");
            }
        });
    }
}

#[test]
fn turns_of_counted_loops_and_of_samples_begin_and_end() {
    let scene = scene("cornell-box.gltf");
    let sort = Options { program: ProgramName::Sort, elements: 40, ..options(&scene, 16, 16) };
    let samples = Samples { count: 3, ..Samples::default() };
    let samples = Options { schedule: ScheduleKind::Fused, samples, ..options(&scene, 16, 16) };
    // A stage of a sort has a step more than the one before it. A sample is generated, traced, shaded and added.
    for (options, expected) in [(sort, vec![1, 3, 6, 10, 15, 21]), (samples, vec![4, 8, 12])] {
        block_on(None, async {
            let mut session = Session::new(&scene, &options, &Device::Cpu(None)).await.expect("a session");
            let which = format!("{} {}", options.program, options.schedule);
            for known in ["not yet known", "known"] {
                go(&mut session, Target::Start).await;
                for &end in &expected {
                    assert_eq!(go(&mut session, Target::IterationEnd).await, end, "{which}, {known}");
                }
                assert_eq!(go(&mut session, Target::IterationEnd).await, expected[expected.len() - 1], "{which}");
            }
            for &start in expected.iter().rev().skip(1).chain(&[0]) {
                assert_eq!(go(&mut session, Target::IterationStart).await, start, "{which}");
            }
        });
    }
}

#[test]
fn a_step_that_is_stopped_ends_at_a_whole_pass() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        let gpu = gpu_of(&device);
        block_on(gpu, async {
            let options = STEPPED.of(&options(&scene, 16, 16));
            let mut session = Session::new(&scene, &options, &device).await.expect("a session");
            let seen = history(&mut session).await;
            let mut calls = 0;
            let mut stop = |_: &raystep_kernels::Progress| {
                calls += 1;
                if calls == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            go(&mut session, Target::Start).await;
            let stopped = session.step(Target::End, &mut stop).await;
            let place = session.place();
            assert!(matches!(stopped, Err(RenderError::Cancelled { passes }) if passes == place), "{stopped:?}");
            assert!(place > 0 && place < seen.len() - 1, "{name}: {place}");
            assert!(streams(&session).await == seen[place], "{name}: {place}");
            go(&mut session, Target::Next).await;
            assert!(streams(&session).await == seen[place + 1], "{name}: {place}");
        });
        // Dropping the future stops it, too.
        let Some(gpu) = gpu else { continue };
        let options = STEPPED.of(&raystep_tests::options(&scene, 16, 16));
        let mut session = block_on(Some(gpu), Session::new(&scene, &options, &device)).expect("a session");
        block_on(Some(gpu), go(&mut session, Target::Pass(2)));
        block_on(Some(gpu), session.edit(streams::HIT, 0, 3, 3, 7)).expect("an edit");
        block_on(Some(gpu), go(&mut session, Target::Start));
        let seen = block_on(Some(gpu), history(&mut session));
        block_on(Some(gpu), go(&mut session, Target::Pass(6)));
        {
            let mut nobody = go_on;
            let mut on_its_way = std::pin::pin!(session.step(Target::Pass(20), &mut nobody));
            let mut context = std::task::Context::from_waker(std::task::Waker::noop());
            assert!(on_its_way.as_mut().poll(&mut context).is_pending());
        }
        block_on(Some(gpu), async {
            let place = go(&mut session, Target::Next).await;
            assert!(streams(&session).await == seen[place], "{name}: after {place}");
            assert!(session.stream(streams::STATE).await.is_ok());
        });
    }
}

#[test]
fn a_session_can_go_to_another_thread() {
    fn can_move<T: Send>(value: T) -> T {
        value
    }
    let scene = scene("cornell-box.gltf");
    let mut session = block_on(None, Session::new(&scene, &stepped(&scene, 8, 8), &Device::Cpu(None))).expect("one");
    block_on(None, async {
        can_move(session.step(Target::Pass(4), &mut go_on)).await.expect("a step");
        can_move(session.follow([4, 4], &mut go_on)).await.expect("a history");
        can_move(session.twins_until(Some(2), &mut go_on)).await.expect("twins");
        can_move(session.edit(streams::HIT, 0, 0, 0, 1)).await.expect("an edit");
        can_move(session.clear_edits(&mut go_on)).await.expect("no edit");
        let forward = raystep_inspector::Direction::Forward;
        can_move(session.run_to_watch(&[], forward, &mut go_on)).await.expect("nothing");
    });
    let _session = can_move(session);
}
