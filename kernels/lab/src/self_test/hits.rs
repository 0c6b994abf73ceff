//! Hits of all structures and schedules: the same bits, and right.

use std::ops::ControlFlow;

use raystep_kernels::{Accelerator, Options, Ray, RaySource, Renderer};
use raystep_scenes::{Scene, generate};

use super::{Bench, Check, Finding, Found, Group, Step, Verdict};
use crate::configuration::{Configuration, EVERY};
use crate::judge::{Report, Traced, check_rays};
use crate::rays;
use crate::stability::probe::Bits;
use crate::{Error, watertight};

const BRUTE_FORCE: &str = "f64 brute force";

/// A check a structure, and one of all.
const STRUCTURES: [(Accelerator, &str, &str); 4] = [
    (Accelerator::Grid, "grid", "every schedule finds the same hits through a grid, bit for bit"),
    (Accelerator::Irregular, "irregular grid", "and through an irregular grid"),
    (Accelerator::Bvh, "BVH", "and through a BVH"),
    (Accelerator::None, "no structure", "and without any"),
];

pub(super) fn checks() -> Vec<Check> {
    let check = |name, shows| Check { group: Group::Hits, name, shows };
    let shows = "no hit is missed, false or wrong, but for ties that f32 cannot decide";
    let structures = STRUCTURES.map(|(_, name, shows)| check(name, shows));
    [&structures[..], &[check(BRUTE_FORCE, shows)]].concat()
}

type Make = fn() -> Result<(Scene, Vec<Ray>), Error>;

/// What is traced: rays from everywhere, and rays at the edges of a closed mesh, which none may leave.
const PLACES: [(&str, Make); 2] = [
    ("the Cornell box", || {
        let scene = generate::cornell_box();
        let rays = rays::mixed(&scene, 1024, 5);
        Ok((scene, rays))
    }),
    ("edges of a sphere", || {
        let scene = watertight::closed_mesh(1.0)?;
        let rays = rays::at_edges(&scene, [0.3, -0.2, 0.1], 1024, 6);
        Ok((scene, rays))
    }),
];

fn check_of(one: Configuration) -> &'static str {
    STRUCTURES.iter().find(|(accelerator, ..)| *accelerator == one.accelerator).map_or(BRUTE_FORCE, |(_, name, _)| name)
}

/// A step a configuration in every place, the one that the others are compared with first.
pub(super) fn steps() -> Vec<Step> {
    let all = EVERY.into_iter().flat_map(|one| (0..PLACES.len()).map(move |place| (one, place)));
    let step = |(one, place): (Configuration, usize)| {
        let checks = if one == EVERY[0] { vec![check_of(one), BRUTE_FORCE] } else { vec![check_of(one)] };
        Step::new(Group::Hits, format!("{one}, {}", PLACES[place].0), &checks, move |bench| trace(bench, one, place))
    };
    all.map(step).collect()
}

/// Hits, and if wanted their verdicts.
fn run(bench: &Bench, one: Configuration, place: usize, is_judged: bool) -> Result<(Bits, Option<Report>), Error> {
    let (scene, rays) = PLACES[place].1()?;
    let options = one.of(&Options { shade: false, ..Options::new(RaySource::Given(rays)) });
    bench.machine.wait(async {
        let mut renderer = Renderer::new(&scene, &options, &bench.machine.device).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        let traced = if is_judged { Some(Traced::read(&renderer).await?) } else { None };
        Ok((Bits::of(&renderer).await?, traced.map(|traced| check_rays(&traced, |_, _| ControlFlow::Continue(())))))
    })
}

fn trace(bench: &mut Bench, one: Configuration, place: usize) -> Found {
    bench.hits.resize(PLACES.len(), None);
    let (bits, mut report) = run(bench, one, place, one == EVERY[0])?;
    let base = match bench.hits[place].take() {
        Some(base) => base,
        // It has run, unless this is another process.
        None if one == EVERY[0] => bits.clone(),
        None => run(bench, EVERY[0], place, false)?.0,
    };
    let (name, rays) = (PLACES[place].0, bits.rays.len());
    let differing: Vec<usize> = (0..rays).filter(|&ray| bits.rays[ray] != base.rays[ray]).collect();
    let difference = |&ray: &usize| {
        let of = |[triangle, t, ..]: [u32; 4]| format!("triangle {triangle} at t {:e}", f32::from_bits(t));
        let (here, there) = (of(bits.rays[ray]), of(base.rays[ray]));
        let count = differing.len();
        format!("{one}, {name}: {count} of {rays} hits differ from {}, first ray {ray}: {here}, not {there}", EVERY[0])
    };
    let agrees = Finding::new(Group::Hits, check_of(one), Verdict::Right, "")
        .counting(&[("runs", 1), ("hits", rays as u64)])
        .wrong_by(differing.first().map(difference).into_iter().collect());
    // The same bits are as right as those that were judged.
    if report.is_none() && !differing.is_empty() {
        report = run(bench, one, place, true)?.1;
    }
    let right = report.map(|report| {
        let mut wrong = Vec::new();
        if report.errors() > 0 {
            wrong.push(format!("{one}, {name}: {report}"));
            wrong.extend(report.mistakes.iter().map(|mistake| format!("{mistake:?}")));
        }
        Finding::new(Group::Hits, BRUTE_FORCE, Verdict::Right, "")
            .counting(&[("runs", 1), ("hits", rays as u64), ("undecided", report.counts.ties)])
            .wrong_by(wrong)
    });
    bench.hits[place] = Some(base);
    Ok((std::iter::once(agrees).chain(right).collect(), Vec::new()))
}
