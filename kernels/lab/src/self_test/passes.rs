//! Every kernel of every program against its CPU reference, after every pass of small scenes.

mod building;
mod scenes;

use raystep_kernels::options::Integrator;
use raystep_kernels::options::ProgramName::{GridBuild, Sort};
use raystep_kernels::options::features::Features;
use raystep_kernels::options::mapping::{Cull, Fragment, Mapping, Targets, Update};
use raystep_kernels::programs::{light, named, path, photons};
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Kernel, Limits, Options};

use self::scenes::{Place, Traced};
use super::{Bench, Check, Finding, Found, Group, Step, Verdict};
use crate::compared::{Compared, Sums};
use crate::configuration::{COVERING, Configuration, FAST, STEPPED};
use crate::parity::{Parity, ParityError, compare};
use crate::stability::Ceiling;
pub(super) use building::steps as building;

/// The check that all configurations of a group were run.
const ALL: &str = "all configurations";

/// A check for each row of these kernels, and one for the configurations.
fn checks_of(
    kernels: impl Iterator<Item = Kernel>,
    group: Group,
    is_there: fn(&Kernel) -> bool,
    shows: &'static str,
) -> Vec<Check> {
    let mut all: Vec<Check> = Vec::new();
    for kernel in kernels.filter(is_there) {
        let row = kernel.info();
        if all.iter().all(|check| check.name != row.name) {
            all.push(Check { group, name: row.name, shows: row.summary });
        }
    }
    all.push(Check { group, name: ALL, shows });
    all
}

pub(super) fn checks_of_tracing() -> Vec<Check> {
    let shows = "every structure, schedule and set of rules was compared, in whole and in divided passes";
    let kernels = [&*light::PROGRAM, &*path::PROGRAM, &*photons::PROGRAM].into_iter().flat_map(|of| of.kernels());
    checks_of(kernels, Group::Tracing, |_| true, shows)
}

pub(super) fn checks_of_building() -> Vec<Check> {
    let shows = "uniform, two-level and irregular grids were built, and are the host's, bit for bit";
    let mut all = checks_of(named(GridBuild).kernels(), Group::Building, |_| true, shows);
    let of_sort = named(Sort).kernels().map(Kernel::info);
    all.extend(of_sort.map(|row| Check { group: Group::Building, name: row.name, shows: row.summary }));
    all
}

/// Whether a kernel can be drawn: it works on the pixels' rays, and what it always binds, itself or by a module, fits texels of
/// four components.
pub(super) fn is_drawn(kernel: &Kernel) -> bool {
    if kernel.course().map(|course| course.stream) != kernel.program().state_stream() {
        return false;
    }
    let modules = (kernel.program().modules)(&Features::default());
    let own = kernel.info().wgsl;
    let imported = modules.iter().filter(|(name, _)| own.contains(&format!("import package::{name}::")));
    let mut always = imported.flat_map(|(_, source)| source.lines()).chain(own.lines());
    let is_large = |line: &str| {
        let name = line.strip_prefix("@group(0)")?.split_once("var ")?.1.split_once(':')?.0;
        kernel.program().stream(name).filter(|stream| stream.layers() > 4)
    };
    !matches!(kernel.role(), Role::Walk | Role::Whole | Role::Sample) && !always.any(|line| is_large(line).is_some())
}

/// Kernels that take one step can be drawn, and those that begin and end a ray's course.
pub(super) fn checks_of_drawing() -> Vec<Check> {
    let shows = "every structure was traced, with each choice of the mapping";
    checks_of(light::PROGRAM.kernels(), Group::Drawing, is_drawn, shows)
}

/// Configurations to compare.
fn traced() -> Vec<Traced> {
    use raystep_kernels::Accelerator::{Bvh, Grid, Irregular, None};
    use raystep_kernels::ScheduleKind::{Compact, Fused, Second};
    let of = |place: Place| move |one: Configuration| Traced::new(place, one);
    let mut all: Vec<Traced> = COVERING.into_iter().map(of(Place::Room)).collect();
    // A fused kernel that does not shade generates its rays itself.
    all.extend(
        [Grid, Irregular, Bvh, None]
            .map(|structure| of(Place::Room)(Configuration::new(structure, Fused, 1)).unshaded()),
    );
    all.extend([3, 19].map(|samples| of(Place::Room)(Configuration::new(Grid, Compact, 8)).sampled(samples)));
    let several = |structure| Configuration::new(structure, Compact, 8);
    all.extend([several(Grid), Configuration::new(Bvh, Fused, 1)].map(of(Place::Segments)));
    // What begins on a surface is open at its start.
    all.extend([several(Grid), Configuration::new(Bvh, Fused, 1)].map(|one| of(Place::Segments)(one).exactly()));
    all.push(of(Place::Room)(several(Grid)).contracted());
    // Few iterations a dispatch, so that everything that can continue in the next one does.
    let in_parts =
        [Grid, Irregular, Bvh, None].map(|structure| [several(structure), Configuration::new(structure, Fused, 1)]);
    all.extend(in_parts.into_iter().flatten().chain([STEPPED]).map(|one| of(Place::Room)(one).in_parts()));
    all.extend(
        [Configuration::new(Irregular, Second, 1), several(Irregular), Configuration::new(Irregular, Fused, 1)]
            .map(of(Place::Knot)),
    );
    // Rays from there to the light.
    all.extend([STEPPED].into_iter().chain(FAST).map(|one| of(Place::Room)(one).lit(Integrator::Shadows)));
    all.push(of(Place::Room)(several(Bvh)).lit(Integrator::Shadows).in_parts());
    all.push(of(Place::Room)(several(Grid)).lit(Integrator::Shadows).sampled(3));
    all.push(of(Place::Room)(Configuration::new(Bvh, Fused, 1)).lit(Integrator::Shadows).exactly());
    // And what goes on from there.
    for integrator in [Integrator::Whitted, Integrator::Path, Integrator::Photons] {
        all.extend(FAST.map(|one| of(Place::Balls)(one).lit(integrator)));
        all.push(of(Place::Balls)(several(Bvh)).lit(integrator).in_parts());
        all.push(of(Place::Balls)(several(Grid)).lit(integrator).sampled(3));
        all.push(of(Place::Balls)(several(Grid)).lit(integrator).exactly());
    }
    // Either sort has kernels of its own.
    all.push(of(Place::Room)(several(Grid)).lit(Integrator::Photons).bitonic());
    // Whole paths in one kernel, which binds everything that the others do: in a room with little of it.
    all.extend([Grid, Bvh, None].map(|one| of(Place::Room)(Configuration::new(one, Fused, 1)).lit(Integrator::Path)));
    // From outside, where rays miss.
    all.extend(FAST.map(of(Place::Soup)));
    all
}

pub(super) fn tracing() -> Vec<Step> {
    steps(Group::Tracing, traced())
}

/// The paper's choices, and those that differ most from them, with every structure.
fn drawn() -> Vec<Traced> {
    use raystep_kernels::Accelerator::{Bvh, Grid, Irregular, None};
    use raystep_kernels::ScheduleKind::{First, Second};
    let paper = Fragment::default();
    let depths = Fragment { targets: Targets::Many, cull: Cull::EarlyZ, ..paper };
    let swapped = Fragment::of(Some(Targets::Many), Some(Update::Swap), Option::None, Option::None);
    let all = [
        (STEPPED, paper),
        (Configuration::new(Grid, First, 1).paper(), paper),
        (Configuration::new(Bvh, Second, 1), paper),
        (Configuration::new(Irregular, Second, 1), paper),
        (Configuration::new(None, Second, 1), paper),
        (Configuration::new(Bvh, Second, 1), depths),
        (Configuration::new(Irregular, First, 1), swapped),
        (Configuration::new(Grid, Second, 1).dda(), depths),
    ];
    let shadows = Traced::new(Place::Room, STEPPED).lit(Integrator::Shadows).drawn(depths);
    all.map(|(one, how)| Traced::new(Place::Room, one).drawn(how)).into_iter().chain([shadows]).collect()
}

pub(super) fn drawing() -> Vec<Step> {
    steps(Group::Drawing, drawn())
}

fn steps(group: Group, all: Vec<Traced>) -> Vec<Step> {
    let step = |traced: Traced| Step::new(group, traced.name(), &[ALL], move |bench| trace(bench, group, &traced));
    all.into_iter().map(step).collect()
}

/// Compares a run, up to the first pass that is wrong.
fn trace(bench: &mut Bench, group: Group, traced: &Traced) -> Found {
    let (scene, options) = traced.make()?;
    let mut limits = Limits::from(&*bench.gpu);
    if let Some(turns) = traced.turns {
        limits.turns = turns;
    }
    let change = bench.faults.plan.clone();
    let comparison = compare(&bench.gpu, &scene, &options, &limits, |plan| change(plan), Parity::is_broken);
    let name = traced.name();
    let done = Finding::new(group, ALL, Verdict::Right, "").counting(&[("configurations", 1)]);
    Ok(match bench.machine.wait(comparison) {
        Ok(parity) => {
            let of_kernels = of_parity(group, &name, traced.undecided(), &parity);
            (std::iter::once(done).chain(of_kernels).collect(), Vec::new())
        }
        Err(ParityError::Pass { kernel, error }) => {
            let says = format!("{name}: the device failed in a pass of it: {error}");
            (vec![done, of_kernel(group, kernel, Sums::default()).wrong_by(vec![says])], Vec::new())
        }
        Err(error) => (vec![done.wrong_by(vec![format!("{name}: {error}")])], Vec::new()),
    })
}

fn of_parity(group: Group, name: &str, undecided: Ceiling, parity: &Parity) -> Vec<Finding> {
    let wrong_of = |kernel: Kernel| {
        let breaches = parity.breaches.iter().filter(|breach| breach.kernel == kernel).map(|b| format!("{name}: {b}"));
        let miscounts = parity.miscounts.iter().filter(|wrong| wrong.kernel == kernel).map(|m| format!("{name}: {m}"));
        breaches.chain(miscounts).collect::<Vec<_>>()
    };
    findings(group, name, undecided, &parity.compared, wrong_of)
}

/// A finding for each kernel that worked on an element, or is wrong.
fn findings(
    group: Group,
    name: &str,
    undecided: Ceiling,
    compared: &Compared,
    wrong_of: impl Fn(Kernel) -> Vec<String>,
) -> Vec<Finding> {
    let finding = |(kernel, sums): (Kernel, Sums)| {
        let mut wrong = wrong_of(kernel);
        let most = undecided.count(sums.rays);
        if wrong.is_empty() && sums.undecided > most {
            let (undecided, rays) = (sums.undecided, sums.rays);
            wrong.push(format!("{name}: {undecided} of {rays} rays are undecided, of which at most {most} can be"));
        }
        let is_used = sums.rays > 0 || kernel.role() == Role::Count || !wrong.is_empty();
        is_used.then(|| of_kernel(group, kernel, sums).wrong_by(wrong))
    };
    compared.iter().filter_map(finding).collect()
}

fn of_kernel(group: Group, kernel: Kernel, sums: Sums) -> Finding {
    let mut counts = vec![("passes", sums.passes as u64), ("components", sums.components)];
    // A build is the same on every device.
    if group != Group::Building {
        counts.extend([("tolerated", sums.tolerated), ("undecided", sums.undecided)]);
    }
    Finding::new(group, kernel.info().name, Verdict::Right, "").counting(&counts)
}

/// Options of a run as fragment programs.
fn as_fragments(how: Fragment, options: Options) -> Options {
    Options { mapping: Mapping::Fragment(how), ..options }
}
