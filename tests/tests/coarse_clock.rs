//! Clocks as coarse as those of browsers: passes are repeated from restored copies, which changes nothing but their times.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::{Accelerator, AdapterChoice, Device, Gpu, Options, Pass, Renderer, Samples, ScheduleKind};
use raystep_scenes::Scene;
use raystep_tests::configurations::Configuration;
use raystep_tests::{block_on, now_ns, options, scene, streams_of, thorough, values};

const MS: u64 = 1_000_000;

/// A device with a checked clock, of its own because tests round it.
fn device() -> Arc<Gpu> {
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter");
    block_on(Some(&gpu), gpu.check_clock(now_ns)).expect("a device");
    assert!(gpu.clock_check().is_some_and(|check| check.agrees()), "{:?}", gpu.clock_check());
    gpu
}

fn rounded(step_ns: u64) -> Arc<Gpu> {
    let gpu = device();
    gpu.round_times(step_ns);
    gpu
}

fn renderer(scene: &Scene, options: &Options, gpu: &Arc<Gpu>) -> Renderer {
    let options = Options { timings: true, ..options.clone() };
    block_on(Some(gpu), Renderer::new(scene, &options, &Device::Gpu(gpu.clone()))).expect("a renderer")
}

fn step(renderer: &mut Renderer) -> Option<Pass> {
    let gpu = renderer.gpu().expect("a GPU").gpu().clone();
    block_on(Some(&gpu), renderer.step()).expect("a pass")
}

/// The passes of a run from its start.
fn passes(renderer: &mut Renderer) -> Vec<Pass> {
    let gpu = renderer.gpu().expect("a GPU").gpu().clone();
    renderer.restart();
    block_on(Some(&gpu), renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
    renderer.passes().to_vec()
}

/// The same after a first run, in which drivers may still compile.
fn warm_passes(renderer: &mut Renderer) -> Vec<Pass> {
    passes(renderer);
    passes(renderer)
}

#[test]
fn the_step_of_a_rounded_clock_is_found_from_its_times() {
    let fine = device();
    let step_ns = fine.clock_step_ns().expect("a valid clock");
    assert!(step_ns <= 1000.0 && Some(step_ns) == fine.clock_period_ns(), "{step_ns} ns");
    for step_ns in [20_000, 65_536, 100_000] {
        let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter");
        gpu.round_times(step_ns);
        block_on(Some(&gpu), gpu.check_clock(now_ns)).expect("a device");
        assert_eq!(gpu.clock_step_ns(), Some(step_ns as f64), "{:?}", gpu.clock_check());
    }
}

#[test]
fn repeated_passes_leave_every_stream_as_a_single_run_does() {
    let (fine, coarse) = (device(), rounded(MS / 5));
    let scene = scene("cornell-box.gltf");
    let (mut repeated, mut all) = (0, 0);
    for (i, schedule) in [ScheduleKind::Compact, ScheduleKind::Second, ScheduleKind::First].into_iter().enumerate() {
        let both = [Accelerator::Grid, Accelerator::Bvh];
        let accelerators = if thorough() { &both[..] } else { &both[i % 2..][..1] };
        for &accelerator in accelerators {
            let configuration = Configuration::new(accelerator, schedule, 1);
            let mut options = configuration.of(&options(&scene, 40, 24));
            // Counters are added to in place.
            options.counters = true;
            if (accelerator, schedule) == (Accelerator::Grid, ScheduleKind::Compact) {
                options.samples = Samples { count: 2, ..Samples::default() };
            }
            let (mut once, mut often) = (renderer(&scene, &options, &fine), renderer(&scene, &options, &coarse));
            while let Some(expected) = step(&mut once) {
                let pass = step(&mut often).expect("as many passes");
                let what = format!("{configuration}, pass {}: {}", pass.index, pass.kernel.name());
                assert_eq!((pass.kernel, &pass.counts), (expected.kernel, &expected.counts), "{what}");
                assert_eq!((expected.rounding, expected.below_ns()), (None, None), "{what}");
                for stream in streams_of(once.plan()) {
                    assert_eq!(values(&often, stream), values(&once, stream), "{what}, {}", stream.name());
                }
                repeated += usize::from(pass.rounding.expect("a coarse clock").runs > 1);
                all += 1;
            }
            assert_eq!(step(&mut often), None, "{configuration}");
            // All passes at once, and back to before the first.
            let mut counts = Vec::new();
            for renderer in [&mut once, &mut often] {
                counts.push(passes(renderer).iter().map(|pass| (pass.kernel, pass.counts.clone())).collect::<Vec<_>>());
            }
            assert_eq!(counts[0], counts[1], "{configuration}");
            for stream in streams_of(once.plan()) {
                assert_eq!(values(&often, stream), values(&once, stream), "{configuration}, {}", stream.name());
            }
            let names =
                |renderer: &Renderer| renderer.gpu().expect("a GPU").allocated().into_iter().map(|(name, _)| name);
            assert!(names(&often).any(|name| name == "slots_kept") && !names(&once).any(|name| name == "slots_kept"));
        }
    }
    assert!(repeated * 2 > all, "{repeated} of {all} passes were repeated");
}

/// Median durations by kernel, of those that run often: single passes are disturbed by other work on the machine.
fn medians(passes: &[Pass]) -> BTreeMap<&'static str, f64> {
    let mut times: BTreeMap<_, Vec<u64>> = BTreeMap::new();
    for pass in passes {
        times.entry(pass.kernel.name()).or_default().extend(pass.duration_ns);
    }
    let median = |(kernel, mut times): (_, Vec<u64>)| {
        let middle = times.len() / 2;
        (times.len() >= 5).then(|| (kernel, *times.select_nth_unstable(middle).1 as f64))
    };
    times.into_iter().filter_map(median).collect()
}

/// A step is twice what passes take, so that each single time is 0 or a step, and tells nothing.
#[test]
fn times_of_repeated_passes_are_those_of_a_fine_clock() {
    let scene = scene("cornell-box.gltf");
    let options = Configuration::new(Accelerator::Grid, ScheduleKind::Second, 1).of(&options(&scene, 64, 64));
    let mut fine = renderer(&scene, &options, &device());
    let longest = medians(&warm_passes(&mut fine)).into_values().fold(0.0, f64::max);
    let step_ns = 2.0 * longest.floor();
    let mut coarse = renderer(&scene, &options, &rounded(step_ns as u64));
    passes(&mut coarse);
    // In turn, so that other work on the machine disturbs both.
    fine.restart();
    coarse.restart();
    while step(&mut fine).is_some() && step(&mut coarse).is_some() {}
    let passes = coarse.passes();
    for pass in passes {
        let rounding = pass.rounding.expect("a coarse clock");
        let error_ns = step_ns / (2.0 * f64::from(rounding.runs).sqrt());
        assert!((rounding.error_ns as f64 - error_ns).abs() <= 1.0, "{pass:?}");
        match pass.duration_ns {
            Some(ns) => assert!(rounding.error_ns as f64 <= 0.25 * ns as f64 + 1.0, "{pass:?}"),
            None => assert!(rounding.below_ns as f64 >= step_ns - 1.0, "{pass:?}"),
        }
    }
    let told = passes.iter().filter(|pass| pass.duration_ns.is_some()).count();
    assert!(told * 2 > passes.len(), "{told} of {} passes: {passes:?}", passes.len());
    let (fine, coarse) = (medians(fine.passes()), medians(passes));
    assert!(fine.len() >= 2 && fine.keys().eq(coarse.keys()), "{fine:?} {coarse:?}");
    for (kernel, ns) in coarse {
        // A standard error of at most 25% each, and less in the median. On software Vulkan a single run takes up to twice
        // as long as one right after another: its threads were asleep. The rest is other work on the machine.
        let ratio = ns / fine[kernel];
        assert!((0.25..2.5).contains(&ratio), "{kernel}: {ns} ns, {} ns by the fine clock", fine[kernel]);
    }
}

#[test]
fn a_pass_far_below_the_step_is_marked_as_too_short() {
    const STEP_NS: u64 = 20 * MS;
    let scene = scene("cornell-box.gltf");
    let options = Configuration::new(Accelerator::Bvh, ScheduleKind::Compact, 1).of(&options(&scene, 8, 8));
    let mut renderer = renderer(&scene, &options, &rounded(STEP_NS));
    let passes = passes(&mut renderer);
    let short: Vec<&Pass> = passes.iter().filter(|pass| pass.duration_ns.is_none()).collect();
    // Other work on the machine may delay some.
    assert!(short.len() * 4 >= passes.len() * 3, "{passes:?}");
    for pass in short {
        let below_ns = pass.below_ns().expect("it was timed");
        assert!((STEP_NS..2 * STEP_NS).contains(&below_ns), "{pass:?}");
        assert!(pass.rounding.is_some_and(|rounding| rounding.runs > 1), "{pass:?}");
    }
    assert_eq!(renderer.totals().duration_ns, None, "a sum of unknown times is unknown");
    assert!(renderer.device_ns().is_some(), "but their estimates are known");
}
