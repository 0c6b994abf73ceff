//! Programs of users: the examples, on a device and in the interpreter.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use pollster::block_on;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Device, Options, RaySource, Renderer, StreamData};
use raystep_lab::check_program::{Outcome, TOLERANCE, Wanted, check};
use raystep_scenes::Scene;
use raystep_tests::gpu;

/// An example, with some texts of its files replaced: smaller sets and fewer turns.
fn example(name: &str, changes: &[(&str, &str)]) -> Options {
    let path = format!("{}/../app/programs/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(path).expect("the example") {
        let entry = entry.expect("a file");
        let mut text = std::fs::read_to_string(entry.path()).expect("a text");
        for (from, to) in changes {
            text = text.replace(from, to);
        }
        files.insert(entry.file_name().into_string().expect("a name"), text.into_bytes());
    }
    let folder = Folder::new(name.into(), name.into(), files).expect("a folder");
    Options { folder: Some(Arc::new(folder)), ..Options::new(RaySource::Given(Vec::new())) }
}

fn ran(options: &Options, device: &Device, stream: &str) -> StreamData {
    block_on(async {
        let (plan, data) = Plan::on(&Scene::default(), options, device).await.expect("a plan");
        let stream = plan.program.stream(stream).expect("a stream");
        let mut renderer = Renderer::from_plan(plan, data, options, device).await.expect("a run");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("no failure");
        renderer.values(stream).await.expect("values")
    })
}

/// Life on the host.
fn lived(side: usize, generations: usize, start: &[u32]) -> Vec<u32> {
    let mut cells = start.to_vec();
    for _ in 0..generations {
        let next = |at: usize| {
            let (x, y) = (at % side, at / side);
            let around = (0..9).filter(|i| *i != 4);
            let alive: u32 =
                around.map(|i| cells[(y + side + i / 3 - 1) % side * side + (x + side + i % 3 - 1) % side]).sum();
            u32::from(alive == 3 || alive == 2 && cells[at] == 1)
        };
        cells = (0..side * side).map(next).collect();
    }
    cells
}

#[test]
fn life_is_that_of_the_host_on_a_device_and_in_the_interpreter() {
    let gpu = Device::Gpu(gpu());
    let of = |generations: &str, device: &Device| {
        let changes = [("[256, 256]", "[32, 32]"), ("repeat = 200", generations)];
        ran(&example("life", &changes), device, "cell").bits
    };
    let start = of("repeat = 0", &gpu);
    assert!(start.iter().sum::<u32>() > 200);
    let expected = lived(32, 60, &start);
    assert_eq!(of("repeat = 60", &gpu), expected);
    let expected = lived(32, 4, &start);
    assert_eq!(of("repeat = 4", &Device::Cpu(None)), expected);
}

#[test]
fn numbers_are_sorted_summed_and_found() {
    let gpu = Device::Gpu(gpu());
    let sorted = ran(&example("bitonic-sort", &[]), &gpu, "number");
    let numbers = &sorted.layer(0)[..1024];
    assert!(numbers.is_sorted() && numbers[0] < numbers[1023]);
    let mut shuffled =
        ran(&example("bitonic-sort", &[("repeat = 10", "repeat = 0")]), &gpu, "number").layer(0)[..1024].to_vec();
    assert!(!shuffled.is_sorted());
    shuffled.sort_unstable();
    assert_eq!(shuffled, numbers);

    let sums = ran(&example("prefix-sum", &[]), &gpu, "value");
    let expected = (0..20_000u32).scan(0, |sum, i| Some(std::mem::replace(sum, *sum + i % 3)));
    assert!(sums.layer(0)[..20_000].iter().copied().eq(expected));

    let found = ran(&example("binary-search", &[]), &gpu, "interval");
    let first = |i: u32| (0..1000u32).position(|entry| entry * entry >= 250 * i).unwrap_or(1000) as u32;
    for i in 0..4096u32 {
        assert_eq!([0, 1].map(|layer| found.get(layer, i as usize)), [first(i); 2], "{i}");
    }
}

/// The interpreter is the second witness of every kernel of the examples.
#[test]
fn the_interpreter_has_the_values_of_the_device() {
    let device = Device::Gpu(gpu());
    let cases: [(&str, &[(&str, &str)]); 8] = [
        ("life", &[("[256, 256]", "[40, 24]")]),
        ("reaction-diffusion", &[("[192, 192]", "[48, 56]"), ("repeat = 2000", "repeat = 5")]),
        ("bitonic-sort", &[("1024", "256"), ("repeat = 10", "repeat = 8")]),
        ("prefix-sum", &[("20000", "3000")]),
        ("binary-search", &[("4096", "600")]),
        ("sphere-tracer", &[("[256, 192]", "[32, 24]")]),
        ("n-body", &[("1024", "300"), ("[192, 192]", "[16, 16]"), ("repeat = 100", "repeat = 3")]),
        ("fluid", &[("[128, 128]", "[24, 32]"), ("repeat = 120", "repeat = 3"), ("repeat = 20", "repeat = 3")]),
    ];
    for (name, changes) in cases {
        let options = example(name, changes);
        let outcome = block_on(async {
            let planned = Plan::on(&Scene::default(), &options, &device).await.expect("a plan");
            let wanted = Wanted { passes: 2, tolerance: TOLERANCE };
            check(&device, planned, &options, wanted, |_| true).await
        });
        match outcome {
            Ok(Outcome::Same { passes, of, values, .. }) => {
                assert!(passes >= 3 && of >= passes && values > 100, "{name}")
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}
