//! Watches stop a run forwards and back; edits, and passes run by twins, persist when moving through the run.

use raystep_inspector::{Direction, Fired, Session, Target, Watch, go_on};
use raystep_kernels::programs::closest_hit::streams::STATE_CELL;
use raystep_kernels::programs::closest_hit::{kernels, states, streams};
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Accelerator, Device, RenderError, Renderer, ScheduleKind};
use raystep_tests::configurations::{Configuration, STEPPED};
use raystep_tests::sessions::{go, streams};
use raystep_tests::{block_on, devices, gpu_of, options, scene, streams_of};

const CONFIGURATIONS: [Configuration; 3] = [
    STEPPED,
    Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 1),
    Configuration::new(Accelerator::Bvh, ScheduleKind::Second, 1),
];

async fn new_session(configuration: Configuration, device: &Device) -> Session {
    let scene = scene("cornell-box.gltf");
    let options = configuration.of(&options(&scene, 16, 12));
    let mut session = Session::new(&scene, &options, device).await.expect("a session");
    session.set_span(6 * 192);
    session
}

async fn run_to(session: &mut Session, watch: Watch, direction: Direction) -> Option<Fired> {
    let fired = session.run_to_watch(&[watch], direction, &mut go_on).await.expect("a run");
    if let Some(fired) = &fired {
        assert_eq!((fired.place, fired.watch), (session.place(), watch), "it stops elsewhere");
    }
    fired
}

/// Every place at which a watch fires, forwards from the start, and then backwards from the end.
async fn both_ways(session: &mut Session, watch: Watch) -> Vec<Fired> {
    go(session, Target::Start).await;
    let mut forward = Vec::new();
    while let Some(fired) = run_to(session, watch, Direction::Forward).await {
        forward.push(fired);
    }
    let last = session.place();
    assert_eq!(session.renderer().next_kernel(), None, "no more matches: at the end");
    let mut back = Vec::new();
    while let Some(fired) = run_to(session, watch, Direction::Back).await {
        back.push(fired);
    }
    assert_eq!(session.place(), 0, "no more matches: at the start");
    back.reverse();
    // Going back starts at the end, so it does not stop there.
    forward.retain(|fired| fired.place < last);
    assert_eq!(forward, back, "{watch:?}");
    forward
}

#[test]
fn a_ray_is_watched_forward_and_back() {
    for (name, device) in devices() {
        for configuration in CONFIGURATIONS {
            block_on(gpu_of(&device), async {
                let mut session = new_session(configuration, &device).await;
                session.select(9, 7);
                let history = session.follow([9, 7], &mut go_on).await.expect("a history");
                let changes = history
                    .rows
                    .iter()
                    .filter(|row| row.state_before != row.after.state && row.place() < history.passes);
                let expected: Vec<usize> = changes.filter_map(|row| row.place()).collect();
                let states = both_ways(&mut session, Watch::RayState).await;
                assert_eq!(states.iter().map(|f| f.place).collect::<Vec<_>>(), expected, "{name} {configuration}");
                assert_eq!(states[0].value, "UNWRITTEN > TRAV_SETUP");
                assert!(states.iter().all(|f| f.ray == [9, 7]));

                let hits = both_ways(&mut session, Watch::RayHit).await;
                let triangle = history.rows.last().and_then(|row| row.after.triangle).expect("a hit");
                let last = &hits.last().expect("a hit").value;
                assert!(last.contains(&format!("> triangle {triangle} at t ")), "{name} {configuration}: {last}");

                let cells = both_ways(&mut session, Watch::RayCell).await;
                let walked = history.rows.windows(2).filter(|w| w[0].after.cell_index != w[1].after.cell_index).count();
                assert!(
                    cells.len().abs_diff(walked) <= 1 && walked > 1,
                    "{name} {configuration}: {} and {walked}",
                    cells.len()
                );
                assert!(
                    both_ways(&mut session, Watch::NonFinite).await.is_empty(),
                    "{name} {configuration}: not finite"
                );
                assert!(
                    both_ways(&mut session, Watch::TMaxBackwards).await.is_empty(),
                    "{name} {configuration}: backwards"
                );
            });
        }
    }
}

#[test]
fn the_ray_that_takes_too_many_steps_is_found() {
    for (name, device) in devices() {
        for configuration in CONFIGURATIONS {
            block_on(gpu_of(&device), async {
                let mut session = new_session(configuration, &device).await;
                let fired = both_ways(&mut session, Watch::MoreSteps(3)).await;
                let place = fired.first().expect("some walk far").place;
                go(&mut session, Target::Pass(place)).await;
                let walks = |p: &raystep_kernels::Pass| p.kernel.role() == Role::Step;
                let passes = session.passes().iter().filter(|p| walks(p)).count();
                assert_eq!(passes, 4, "{name} {configuration}: not the fourth step of a ray");
                assert_eq!(fired[0].value, "4 steps");

                // Counters give the same, except that they include the cell where the walk starts.
                let scene = scene("cornell-box.gltf");
                let mut options = session.options().clone();
                options.counters = true;
                let mut counted = Session::new(&scene, &options, &device).await.expect("a session");
                let first = u32::from(configuration.accelerator == Accelerator::Grid);
                let by_counters = both_ways(&mut counted, Watch::MoreSteps(3 + first)).await;
                let places = |fired: &[Fired]| fired.iter().map(|f| (f.place, f.rays, f.ray)).collect::<Vec<_>>();
                assert_eq!(places(&by_counters), places(&fired), "{name} {configuration}");
                assert!(both_ways(&mut session, Watch::MoreSteps(10_000)).await.is_empty());
            });
        }
    }
}

#[test]
fn a_number_that_is_not_finite_is_found_where_it_came_in() {
    for (name, device) in devices() {
        block_on(gpu_of(&device), async {
            let mut session = new_session(STEPPED, &device).await;
            go(&mut session, Target::NextOf(kernels::TRAVERSE_GRID)).await;
            let place = go(&mut session, Target::Next).await;
            session.edit(streams::TMAX, 1, 5, 6, f32::NAN.to_bits()).await.expect("an edit");
            session.edit(streams::TMAX, 2, 3, 2, (-1.0f32).to_bits()).await.expect("an edit");
            go(&mut session, Target::End).await;

            let fired = run_to(&mut session, Watch::NonFinite, Direction::Back).await.expect("a NaN");
            let last = fired.place;
            let all = both_ways(&mut session, Watch::NonFinite).await;
            assert_eq!(all.last().map(|f| f.place), Some(last), "{name}");
            assert_eq!((all[0].place, all[0].ray, all[0].rays), (place, [5, 6], 1), "{name}");
            assert_eq!(all[0].value, "tmax.y is NaN");
            let backwards = both_ways(&mut session, Watch::TMaxBackwards).await;
            assert_eq!((backwards[0].place, backwards[0].ray), (place, [3, 2]), "{name}");
            assert!(backwards[0].value.starts_with("tmax.z from "), "{}", backwards[0].value);

            assert_eq!(session.edits().len(), 2);
            session.clear_edits(&mut go_on).await.expect("no edits");
            assert!(session.edits().is_empty());
            assert!(both_ways(&mut session, Watch::NonFinite).await.is_empty(), "{name}");
        });
    }
}

#[test]
fn an_edit_is_made_again_wherever_one_goes() {
    for (name, device) in devices() {
        for configuration in CONFIGURATIONS {
            block_on(gpu_of(&device), async {
                let mut session = new_session(configuration, &device).await;
                let last = go(&mut session, Target::End).await;
                let image = session.stream(streams::COLOR).await.expect("colours");
                let place = 9;
                go(&mut session, Target::Pass(place)).await;
                let before = session.stream(streams::STATE).await.expect("state");
                // A ray that waits for the walk is sent to the background; another is moved to the first cell.
                let walking = |i: &usize| before.get(STATE_TAG, *i) == states::TRAV;
                let rays: Vec<usize> = (0..192).filter(walking).take(2).collect();
                let ([gone, moved], true) = ([rays[0], rays[1]], rays.len() == 2) else { panic!("no ray is walking") };
                let pixel = |ray: usize| ((ray % 16) as u32, (ray / 16) as u32);
                let (x, y) = pixel(gone);
                session.edit(streams::STATE, STATE_TAG, x, y, states::BACKGROUND).await.expect("an edit");
                session.edit(streams::STATE, STATE_TAG, x, y, states::BACKGROUND).await.expect("the same again");
                let (x, y) = pixel(moved);
                session.edit(streams::STATE, STATE_CELL, x, y, 0).await.expect("an edit");
                assert_eq!(session.edits().len(), 2);
                assert_eq!(
                    session.renderer().live()[states::BACKGROUND as usize],
                    1 + before.layer(0).iter().filter(|&&t| t == states::BACKGROUND).count() as u32
                );
                assert_eq!(session.known().len(), place, "later passes are unknown after an edit");

                let mut seen = vec![streams(&session).await];
                while go(&mut session, Target::Next).await == place + seen.len() {
                    seen.push(streams(&session).await);
                }
                let changed = session.stream(streams::COLOR).await.expect("colours");
                let hit = session.stream(streams::HIT).await.expect("hits");
                assert_eq!(hit.get(2, gone), u32::MAX, "{name} {configuration}: it hit nothing");
                for ray in (0..192).filter(|ray| ![gone, moved].contains(ray)) {
                    assert_eq!(changed.get(0, ray), image.get(0, ray), "{name} {configuration}: another ray changed");
                }
                let end = session.place();
                for (back, budget) in [(1, u64::MAX), (5, u64::MAX), (end - place + 1, 0), (end, 0)] {
                    session.set_budget(budget);
                    go(&mut session, Target::Pass(end - back)).await;
                    for at in [place, place + 3, end] {
                        go(&mut session, Target::Pass(at)).await;
                        assert!(
                            streams(&session).await == seen[at - place],
                            "{name} {configuration}: {at}, {back} back"
                        );
                    }
                }
                go(&mut session, Target::Pass(place - 1)).await;
                assert!(!session.edits().is_empty());

                session.clear_edits(&mut go_on).await.expect("no edits");
                assert_eq!(go(&mut session, Target::End).await, last);
                assert!(
                    session.stream(streams::COLOR).await.expect("colours") == image,
                    "{name} {configuration}: as before"
                );
                let outside = session.edit(streams::HIT, 0, 16, 0, 0).await;
                assert!(matches!(outside, Err(RenderError::NoPixel { .. })), "{outside:?}");
                let deep = session.edit(streams::HIT, 3, 0, 0, 0).await;
                assert!(matches!(deep, Err(RenderError::NoLayer { .. })), "{deep:?}");
                assert!(session.edits().is_empty());
            });
        }
    }
}

#[test]
fn the_first_passes_can_run_on_the_twins() {
    let device = Device::Gpu(raystep_tests::gpu());
    let gpu = gpu_of(&device);
    for configuration in CONFIGURATIONS {
        block_on(gpu, async {
            let mut session = new_session(configuration, &device).await;
            let scene = scene("cornell-box.gltf");
            let twins = Device::Cpu(None);
            let mut twin = Renderer::new(&scene, session.options(), &twins).await.expect("the twins");
            let mut device_only = Renderer::new(&scene, session.options(), &device).await.expect("a device");
            let streams_all = streams_of(twin.plan());
            let mut of_twin = Vec::new();
            loop {
                let mut now = Vec::new();
                for &stream in &streams_all {
                    now.push(twin.values(stream).await.expect("values"));
                }
                of_twin.push(now);
                if twin.step().await.expect("a pass").is_none() {
                    break;
                }
            }
            let last = of_twin.len() - 1;

            // Every pass on the CPU: as with twins alone, at every place, forwards and back.
            assert_eq!(session.twins_until(Some(last), &mut go_on).await.expect("twins"), 0);
            for place in (0..=last).chain((0..last).rev()) {
                go(&mut session, Target::Pass(place)).await;
                assert!(streams(&session).await == of_twin[place], "{configuration}: twins after {place}");
            }
            // No pass on the CPU: as with the device alone.
            go(&mut session, Target::Pass(15)).await;
            session.twins_until(Some(0), &mut go_on).await.expect("a device");
            device_only.run_to(15, |_| std::ops::ControlFlow::Continue(())).await.expect("passes");
            for (data, &stream) in streams(&session).await.iter().zip(&streams_all) {
                assert!(
                    *data == device_only.values(stream).await.expect("values"),
                    "{configuration}: {}",
                    stream.name()
                );
            }
            // Some passes on the CPU: the device continues with the twins' streams.
            let place = 11;
            assert_eq!(session.twins_until(Some(place), &mut go_on).await.expect("both"), 15, "it stays");
            assert_eq!(session.twin_passes(), Some(place));
            let mut handed = Renderer::new(&scene, session.options(), &device).await.expect("a device");
            let plan_of = |renderer: &Renderer| (renderer.shared_plan(), renderer.shared_data());
            let (plan, data) = plan_of(&handed);
            let mut twin = Renderer::from_plan(plan, data, session.options(), &twins).await.expect("the twins");
            twin.run_to(place, |_| std::ops::ControlFlow::Continue(())).await.expect("passes");
            handed.adopt(&mut twin).await.expect("the same plan");
            handed.run(|_| std::ops::ControlFlow::Continue(())).await.expect("passes");
            go(&mut session, Target::End).await;
            let kernels = |passes: &[raystep_kernels::Pass]| passes.iter().map(|p| p.kernel).collect::<Vec<_>>();
            assert_eq!(kernels(session.passes()), kernels(handed.passes()), "{configuration}: the same passes");
            for (data, &stream) in streams(&session).await.iter().zip(&streams_all) {
                assert!(*data == handed.values(stream).await.expect("values"), "{configuration}: {}", stream.name());
            }
            go(&mut session, Target::Pass(place)).await;
            assert!(streams(&session).await == of_twin[place], "{configuration}: at the hand-over");
        });
    }
}
