//! The self-test: right on this adapter, complete, and wrong where something is broken.

use std::collections::BTreeSet;
use std::sync::Arc;

use raystep_kernels::options::{Integrator, ProgramName};
use raystep_kernels::program::breaks::Break;
use raystep_kernels::programs::{self, closest_hit};
use raystep_kernels::{Accelerator, AdapterChoice, Gpu, GridSize, Limits, Options, Plan, Samples};
use raystep_lab::self_test::{
    Bench, Faults, Group, Outcome, Results, STAYS, Step, Verdict, checks, probe, steps, text,
};
use raystep_tests::configurations::COVERING;
use raystep_tests::{gpu, options, parity, scene, thorough};

use crate::path::glowing;

fn bench(faults: Faults) -> Bench {
    Bench::new(gpu(), "1-2".into(), faults)
}

/// The names of what is wrong.
fn wrong(outcome: &Outcome) -> Vec<&str> {
    outcome.findings.iter().filter(|f| f.verdict == Verdict::Wrong).map(|f| f.check.as_str()).collect()
}

/// In short, a few of the extreme cases and pipelines.
fn is_run(step: &Step) -> bool {
    let few = ["axis-0", "long-walk", "edges", "none second", "none second fma", "bvh fused"];
    thorough() || !matches!(step.group, Group::Extremes | Group::Pipelines) || few.contains(&step.name.as_str())
}

#[test]
fn everything_is_right_on_this_adapter_and_every_kernel_of_every_program_was_compared() {
    let (steps, mut bench) = (steps(), bench(Faults::default()));
    let mut results = Results::new(&steps);
    let names: BTreeSet<_> = checks().into_iter().map(|check| (check.group, check.name.to_owned())).collect();
    for (index, step) in steps.iter().enumerate().filter(|(_, step)| is_run(step)) {
        let outcome = step.run(&mut bench);
        assert_eq!(wrong(&outcome), [""; 0], "{}: {:?}", step.name, outcome.findings);
        assert!(!outcome.is_device_lost && !outcome.findings.is_empty(), "{}", step.name);
        for finding in &outcome.findings {
            assert!(names.contains(&(finding.group, finding.check.clone())), "{}: {finding:?}", step.name);
        }
        results.add(index, outcome);
    }
    println!("{}", text(&results));
    let rows = results.rows();
    let is_right =
        |group, name: &str| rows.iter().any(|r| r.group == group && r.name == name && r.verdict == Verdict::Right);
    for program in programs::all() {
        let group = if program.course().is_some() { Group::Tracing } else { Group::Building };
        for kernel in program.kernels() {
            assert!(is_right(group, kernel.info().name), "{} was not compared", kernel.name());
        }
    }
    for row in rows.iter().filter(|row| !matches!(row.group, Group::Extremes | Group::Pipelines)) {
        assert!(!matches!(row.verdict, Verdict::NotRun | Verdict::Wrong), "{row:?}");
    }
    // A walk's error is in a file of its own, and the cases' rows in one.
    let files = results.files();
    assert_eq!(files.keys().collect::<Vec<_>>(), ["pipelines.csv", "stability.csv", "tmax.csv"]);
    assert_eq!(files["stability.csv"].matches("schema_version").count(), 1);
}

/// Breaks every variant of a kernel that has the line in every plan.
fn breaking(name: &'static str, broken: &Break) -> Faults {
    let (from, to) = (broken.from, broken.to);
    let plan = move |plan: &mut Plan| {
        for variant in plan.variants.iter_mut().filter(|variant| variant.kernel.info().name == name) {
            if let Some(changed) = parity::changed(&variant.source, from, to) {
                variant.source = changed;
            }
        }
    };
    Faults { plan: Arc::new(plan), ..Faults::default() }
}

#[test]
fn a_broken_kernel_is_wrong_by_its_name() {
    let steps = steps();
    let mut tried = BTreeSet::new();
    for (place, kernel) in programs::all().flat_map(|program| program.kernels()).enumerate() {
        let row = kernel.info();
        let group = if kernel.program().course().is_some() { Group::Tracing } else { Group::Building };
        // In short, some of each program.
        let few = ["setup", "walk", "count", "scan", "divide"];
        if !(thorough() || few.contains(&row.name)) || !tried.insert((group, row.name)) {
            continue;
        }
        let broken = &row.breaks[place % row.breaks.len()];
        let mut bench = bench(breaking(row.name, broken));
        let outcomes = steps.iter().filter(|step| step.group == group).map(|step| (step, step.run(&mut bench)));
        let found = outcomes.into_iter().find(|(_, outcome)| !wrong(outcome).is_empty());
        let (step, outcome) = found.unwrap_or_else(|| panic!("{} with {:?} is not found", row.name, broken.to));
        assert_eq!(wrong(&outcome), [row.name], "{:?} in {}: {:?}", broken.to, step.name, outcome.findings);
        let finding = outcome.findings.iter().find(|f| f.verdict == Verdict::Wrong).expect("a finding");
        assert!(finding.says.contains(&step.name) && finding.details.contains(&finding.says), "{finding:?}");
    }
    assert!(tried.len() >= 5, "{tried:?}");
}

#[test]
fn a_kernel_that_does_not_compile_is_wrong_and_leaves_the_others() {
    // Only as a fragment program, whose draws have a source of their own.
    let plan = |plan: &mut Plan| {
        for drawn in plan
            .drawn
            .iter_mut()
            .flat_map(|drawn| &mut drawn.kernels)
            .filter(|d| d.kernel == closest_hit::kernels::SHADE)
        {
            drawn.draws.iter_mut().for_each(|draw| draw.shader.source += "this is no WGSL");
        }
    };
    let (steps, mut bench) = (steps(), bench(Faults { plan: Arc::new(plan), ..Faults::default() }));
    let first = |group| steps.iter().find(|step| step.group == group).expect("a step");
    assert_eq!(wrong(&first(Group::Tracing).run(&mut bench)), [""; 0]);
    let outcome = first(Group::Drawing).run(&mut bench);
    assert_eq!(wrong(&outcome).len(), 1, "{:?}", outcome.findings);
    assert!(!outcome.is_device_lost && outcome.findings[0].says.contains("shade"), "{:?}", outcome.findings);
    assert_eq!(wrong(&first(Group::Hits).run(&mut bench)), [""; 0]);
}

#[test]
fn a_wrong_operation_is_wrong_by_its_name() {
    let steps = steps();
    let step = steps.iter().find(|step| step.name == "operations").expect("a step");
    for (from, to, check) in [
        ("return bitcast<u32>(floor(a));", "return bitcast<u32>(ceil(a));", "floor, min, …"),
        ("return bitcast<u32>(a * b);", "return bitcast<u32>(a * b * 1.000001);", "a + b, a * b"),
        ("return bitcast<u32>(a / b);", "return bitcast<u32>(a / b * 1.000001);", "a / b"),
        ("return bitcast<u32>(sqrt(a));", "return bitcast<u32>(sqrt(a) * 1.000002);", "sqrt(a)"),
        ("return bitcast<u32>((a + b) + c);", "return bitcast<u32>((a + c) + b);", "(a + b) + c"),
        ("return bitcast<u32>(a * b + c);", "return bitcast<u32>(a * b + c * 1.000001);", "a * b + c"),
        ("return u32(i32(a));", "return u32(i32(floor(a)));", "conversions"),
        ("return x % y;", "return x / y;", "integers"),
        ("a * b >= c * d", "a * b > c * d", "a * b >= c * d"),
    ] {
        let operations = move |source: String| {
            assert!(source.contains(from), "{from}");
            source.replace(from, to)
        };
        let outcome = step.run(&mut bench(Faults { operations: Arc::new(operations), ..Faults::default() }));
        let says = outcome.findings.iter().find(|f| f.verdict == Verdict::Wrong).map(|f| f.says.clone());
        assert_eq!(wrong(&outcome), [check], "{to}: {says:?}");
    }
}

#[test]
fn a_lost_device_is_a_finding_and_no_panic() {
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter");
    let (steps, mut bench) = (steps(), Bench::new(gpu.clone(), "1-2".into(), Faults::default()));
    let mut groups = BTreeSet::new();
    gpu.device.destroy();
    for step in steps.iter().filter(|step| groups.insert(step.group)) {
        let outcome = step.run(&mut bench);
        assert!(outcome.is_device_lost, "{}", step.name);
        assert!(wrong(&outcome).contains(&STAYS), "{}: {:?}", step.name, outcome.findings);
        assert!(wrong(&outcome).len() > 1, "{}: {:?}", step.name, outcome.findings);
    }
    assert_eq!(groups.len(), Group::ALL.len());
}

/// Operations in a module: what is done to which kind of numbers.
fn operations_of(source: &str) -> BTreeSet<String> {
    use naga::Expression as E;
    let module = naga::front::wgsl::parse_str(source).expect("WGSL");
    let mut validator = naga::valid::Validator::new(Default::default(), naga::valid::Capabilities::all());
    let info = validator.validate(&module).expect("a valid module");
    let functions = module.functions.iter().map(|(handle, function)| (function, &info[handle]));
    let entries = (0..).zip(&module.entry_points).map(|(i, entry)| (&entry.function, info.get_entry_point(i)));
    let mut all = BTreeSet::new();
    for (function, info) in functions.chain(entries) {
        let kind = |handle: naga::Handle<E>| info[handle].ty.inner_with(&module.types).scalar_kind();
        for (handle, expression) in function.expressions.iter() {
            all.extend(match *expression {
                E::Math { fun, arg, .. } => Some(format!("{fun:?} of {:?}", kind(arg))),
                E::Relational { fun, .. } => Some(format!("{fun:?}")),
                E::Binary { op, left, .. } => Some(format!("{op:?} of {:?}", kind(left))),
                E::Unary { op, expr } => Some(format!("{op:?} of {:?}", kind(expr))),
                E::Select { accept, .. } => Some(format!("select of {:?}", kind(accept))),
                E::As { expr, convert, .. } => {
                    let how = if convert.is_some() { "converted" } else { "cast" };
                    Some(format!("{:?} {how} to {:?}", kind(expr), kind(handle)))
                }
                E::Derivative { .. } | E::ImageSample { .. } => Some(format!("{expression:?}")),
                _ => None,
            });
        }
    }
    all
}

/// A kernel that begins to use another operation needs a row of it.
#[test]
fn every_operation_of_every_kernel_is_probed() {
    let probed = operations_of(&probe::source());
    let limits = Limits { turns: 6, ..Limits::CPU };
    let mut plans = Vec::new();
    for (file, samples) in [("textures.gltf", 1), ("lights.gltf", 19), ("cornell-box.gltf", 1)] {
        let scene = scene(file);
        for configuration in COVERING {
            let samples = Samples { count: samples, ..Samples::default() };
            let options = Options { counters: true, samples, ..configuration.of(&options(&scene, 8, 8)) };
            plans.push(Plan::new(&scene, &options, &limits).expect(file).0);
            plans.push(Plan::new(&scene, &options, &Limits::CPU).expect(file).0);
            let with_shadows = Options { integrator: Integrator::Shadows, ..options };
            plans.push(Plan::new(&scene, &with_shadows, &limits).expect(file).0);
        }
        for (accelerator, grid) in
            [(Accelerator::Grid, GridSize::Cells([32; 3])), (Accelerator::Irregular, GridSize::Auto)]
        {
            let options = Options { program: ProgramName::GridBuild, accelerator, grid, ..options(&scene, 8, 8) };
            plans.push(Plan::new(&scene, &options, &limits).expect(file).0);
        }
    }
    let glowing = glowing();
    let lit = [Integrator::Whitted, Integrator::Path, Integrator::Photons];
    for (configuration, integrator) in COVERING.into_iter().flat_map(|one| lit.map(|it| (one, it))) {
        let samples = Samples { count: 2, ..Samples::default() };
        let options = Options { integrator, samples, ..configuration.of(&options(&glowing, 8, 8)) };
        plans.push(Plan::new(&glowing, &options, &limits).expect("a plan").0);
        plans.push(Plan::new(&glowing, &options, &Limits::CPU).expect("a plan").0);
    }
    let sort = Options { program: ProgramName::Sort, ..options(&scene("empty.gltf"), 8, 8) };
    plans.push(Plan::new(&scene("empty.gltf"), &sort, &limits).expect("a sort").0);
    let mut kernels = BTreeSet::new();
    let mut sources = BTreeSet::new();
    for variant in plans.iter().flat_map(|plan| &plan.variants) {
        kernels.insert(variant.kernel.info().name);
        sources.insert(variant.source.clone());
    }
    for kernel in programs::all().flat_map(|program| program.kernels()) {
        assert!(kernels.contains(kernel.info().name), "no plan has {}", kernel.name());
    }
    let used: BTreeSet<String> = sources.iter().flat_map(|source| operations_of(source)).collect();
    let missing: Vec<_> = used.difference(&probed).collect();
    assert!(missing.is_empty(), "kernels use what is not probed: {missing:#?}");
}
