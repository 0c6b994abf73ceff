//! Kernels as guests: one program runs the tracer's kernels for two sets of rays, each with streams, states and lists of
//! its own, under other names and in another order, and nothing is copied.

use std::sync::LazyLock;

use raystep_kernels::program::schedule::{Schedule, Step};
use raystep_kernels::program::{Course, Instance, Program, Renamed};
use raystep_kernels::programs::closest_hit::{PROGRAM, kernels, schedule, states, streams};
use raystep_kernels::tables::elements::{Count, Elements};
use raystep_kernels::tables::kernel::{ListInfo, Role};
use raystep_kernels::tables::state::{StateInfo, States, Tag};
use raystep_kernels::tables::stream::{STATE_TAG, StreamInfo};
use raystep_kernels::{Accelerator, Device, Kernel, Options, Plan, Renderer, ScheduleKind, Stream};
use raystep_lab::parity;
use raystep_tests::{block_on, devices, gpu, gpu_of, options, scene};

static NEAR: Elements = Elements { name: "near", count: Count::Image };
static FAR: Elements = Elements { name: "far", count: Count::Image };
const SETS: [&Elements; 2] = [&NEAR, &FAR];

fn leaked<T>(values: Vec<T>) -> &'static [T] {
    Vec::leak(values)
}

fn renamed(set: &Elements, name: &str) -> &'static str {
    format!("{}_{name}", set.name).leak()
}

/// The tag of a state of the tracer's, for rays of a set.
fn tag(set: usize, own: Tag) -> Tag {
    let count = states::STATES.0.len() as Tag;
    // Those of the first set descend.
    if set == 0 { count - 1 - own } else { count + own }
}

static GUESTS: LazyLock<&'static Program> = LazyLock::new(|| {
    let all_states = SETS.iter().enumerate().flat_map(|(set, elements)| {
        let of = move |state: &StateInfo| StateInfo {
            tag: tag(set, state.tag),
            name: renamed(elements, state.name),
            ..*state
        };
        states::STATES.iter().map(of)
    });
    let mut all_states: Vec<StateInfo> = all_states.collect();
    all_states.sort_by_key(|state| state.tag);
    let states = States(leaked(all_states));
    let own = SETS.iter().enumerate().flat_map(|(set, &elements)| {
        streams::OF_LIGHT.iter().rev().map(move |info| {
            let mut unwritten = info.unwritten.to_vec();
            if info.name == streams::STATE.name() {
                unwritten[STATE_TAG] = tag(set, states::UNWRITTEN);
            }
            let index = set * streams::OF_LIGHT.len() + streams::OF_LIGHT.len() - 1 - info.index;
            StreamInfo { index, name: renamed(elements, info.name), elements, unwritten: leaked(unwritten), ..*info }
        })
    });
    let own = leaked(own.collect());
    let stream = |set: usize, of: Stream| {
        Stream::of(own.iter().find(|info| info.name == renamed(SETS[set], of.name())).expect("a stream"))
    };
    let lists = SETS.iter().flat_map(|set| {
        PROGRAM
            .lists
            .iter()
            .map(|list| ListInfo { name: renamed(set, list.name), slots: list.slots.map(|slots| renamed(set, slots)) })
    });
    let kernels = SETS.iter().flat_map(|&over| {
        PROGRAM.kernels.iter().map(move |instance| {
            let names =
                streams::OF_LIGHT.iter().map(|info| info.name).chain(PROGRAM.lists.iter().map(|list| list.name));
            let binds = names.map(|name| (name, renamed(over, name)));
            let pairs: Vec<_> = states::STATES.iter().map(|state| (state.name, renamed(over, state.name))).collect();
            let states = Renamed::new(&instance.kernel, states, &pairs).expect("its states");
            let name = renamed(over, instance.name);
            let binds = leaked(binds.collect());
            Instance { name, over, binds, renamed: Some(Box::leak(Box::new(states))), ..*instance }
        })
    });
    let course = |set: usize| Course {
        stream: stream(set, streams::STATE),
        inputs: &[],
        unborn: tag(set, states::UNWRITTEN),
        born: tag(set, states::TRAV_SETUP),
        given_up: if set == 0 { |_| tag(0, states::BACKGROUND) } else { |_| tag(1, states::BACKGROUND) },
        done: tag(set, states::DONE),
    };
    let program = Program {
        name: "guests",
        summary: "two sets of rays through one scene",
        elements: &SETS,
        streams: own,
        states,
        courses: leaked(vec![course(0), course(1)]),
        rays: None,
        results: None,
        lists: leaked(lists.collect()),
        kernels: leaked(kernels.collect()),
        ..PROGRAM
    };
    Box::leak(Box::new(program))
});

/// The kernel of the guests that is one of the tracer's for a set.
fn guest(set: usize, of: Kernel) -> Kernel {
    GUESTS.kernel(&format!("{}_{}", SETS[set].name, of.name())).expect("a kernel")
}

fn for_set(set: usize, steps: &[Step]) -> Vec<Step> {
    let of = |step: &Step| match step {
        Step::Run(kernel) => Step::Run(guest(set, *kernel)),
        Step::RunUntilIdle(kernel) => Step::RunUntilIdle(guest(set, *kernel)),
        Step::LoopWhileActive(kernels, body) => {
            Step::LoopWhileActive(kernels.iter().map(|&kernel| guest(set, kernel)).collect(), for_set(set, body))
        }
        other => panic!("{other:?}"),
    };
    steps.iter().map(of).collect()
}

/// The tracer's schedule for one set after the other.
fn schedule_of(options: &Options, plan: &Plan) -> Schedule {
    let steps = schedule::of(options, &plan.features).steps;
    Schedule { steps: [for_set(0, &steps), for_set(1, &steps)].concat() }
}

fn cases() -> Vec<Options> {
    let mut all = Vec::new();
    for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
        for schedule in [ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused] {
            for steps_per_pass in [1, 8] {
                if schedule == ScheduleKind::Compact || steps_per_pass == 8 {
                    let options = options(&scene("teapot.glb"), 24, 16);
                    all.push(Options { accelerator, schedule, steps_per_pass, counters: true, ..options });
                }
            }
        }
    }
    all
}

#[test]
fn the_guests_have_no_fault_and_share_every_row() {
    assert_eq!(GUESTS.faults(), []);
    for kernel in GUESTS.kernels() {
        let own = PROGRAM.kernels().find(|own| own.info().name == kernel.info().name).expect("a kernel of the tracer");
        assert!(std::ptr::eq(kernel.info().wgsl, own.info().wgsl));
        assert!(std::ptr::eq(kernel.info().home, own.info().home));
    }
}

/// In either set, every stream ends with the bits that it has in the tracer, and states are those of the same meaning.
#[test]
fn guests_trace_as_their_own_program_does() {
    let scene = scene("teapot.glb");
    for (options, (name, device)) in
        cases().iter().flat_map(|options| devices().into_iter().map(move |on| (options, on)))
    {
        let label = format!("{} {} {} on {name}", options.accelerator, options.schedule, options.steps_per_pass);
        block_on(gpu_of(&device), async {
            let limits = device.limits();
            let (plan, data) = Plan::new(&scene, options, &limits).expect("a plan");
            let guests = plan.hosted(&GUESTS, schedule_of(options, &plan), &data, &limits).expect("a plan");
            let mut own = Renderer::from_plan(plan, data.clone(), options, &device).await.expect("a run");
            let mut guests = Renderer::from_plan(guests, data, options, &device).await.expect("a run of guests");
            own.run(|_| std::ops::ControlFlow::Continue(())).await.expect("passes");
            guests.run(|_| std::ops::ControlFlow::Continue(())).await.expect("passes of guests");
            assert_eq!(guests.pass_count(), 2 * own.pass_count(), "{label}");
            for (set, elements) in SETS.iter().enumerate() {
                let counts = own.live().iter().enumerate();
                assert!(counts.clone().all(|(own, &n)| guests.live()[tag(set, own as Tag) as usize] == n), "{label}");
                for stream in own.plan().streams.iter().map(|planned| planned.what) {
                    let bound = GUESTS.stream(&format!("{}_{}", elements.name, stream.name())).expect("a stream");
                    let mut expected = own.values(stream).await.expect("values");
                    if stream == streams::STATE {
                        let rays = expected.layer(STATE_TAG).len();
                        let tags = &mut expected.bits[STATE_TAG * rays..][..rays];
                        tags.iter_mut().for_each(|own| *own = tag(set, *own));
                    }
                    assert!(guests.values(bound).await.expect("values").bits == expected.bits, "{label}: {bound:?}");
                }
            }
        });
    }
}

/// After every pass, each guest agrees with its CPU reference, which reads the streams and states that it is bound to.
#[test]
fn guests_agree_with_their_references_after_every_pass() {
    let scene = scene("teapot.glb");
    let (gpu, mut seen) = (gpu(), std::collections::BTreeSet::new());
    let limits = Device::Gpu(gpu.clone()).limits();
    for options in cases() {
        let (plan, data) = Plan::new(&scene, &options, &limits).expect("a plan");
        let plan = plan.hosted(&GUESTS, schedule_of(&options, &plan), &data, &limits).expect("a plan");
        let found = block_on(
            Some(&gpu),
            parity::compare_plan(&Device::Gpu(gpu.clone()), plan, data, &options, true, |_| false),
        )
        .expect("a comparison");
        assert!(!found.is_broken(), "{}: {:?} {:?}", options.accelerator, found.breaches, found.miscounts);
        seen.extend(found.transitions.iter().map(|(_, kernel, _)| kernel.name()));
    }
    // Integers decide nothing here: exact_order.rs compares the kernel in which they do.
    let is_idle = |kernel: &Kernel| kernel.info().name == kernels::DECIDE.info().name;
    let walk =
        GUESTS.kernels().filter(|kernel| !matches!(kernel.role(), Role::Count | Role::Sample) && !is_idle(kernel));
    let missing: Vec<_> = walk.map(Kernel::name).filter(|name| !seen.contains(name)).collect();
    assert!(missing.is_empty(), "{missing:?} were not compared");
}
