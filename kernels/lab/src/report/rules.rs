//! Which numerical rules a scene needs: replaces one rule at a time by the paper's, and measures what that saves and
//! which rays it loses.
//!
//! Rays start inside the scene's box, so that the rules for origins outside do not hide the others, and are aimed in
//! equal numbers at the places where the rules differ: each kind of place is a stratum. Every rule is judged on the same
//! rays as robust numerics, so what counts is the rays that only one of the two gets wrong (McNemar 1947), adjusted for
//! the number of rules (Holm 1979).

mod figure;
mod words;

use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Numerics, Options, Ray, RaySource, Rule, ScheduleKind, Skip};

use super::judge::{Judge, Judged};
use super::page::Part;
use super::times::{self, Times};
use super::work::{Built, Work};
use crate::Error;
use crate::configuration::{Configuration, has_rule, numerics_of};
use crate::portions::Portions;
use crate::rays::{Aim, Planes, aimed};
use crate::statistics::proportion::{holm, mcnemar};
use crate::tidy::fill::{Drawn, verdicts};
use crate::tidy::{KEYS, RATIO, Row, TIMES, Table, VERDICTS, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![accelerator schedule numerics order rule stratum rays cells_x cells_y cells_z],
    TIMES,
    RATIO,
    VERDICTS,
    columns![wrong_here_only wrong_robust_only p_value p_value_holm is_needed],
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// The name of all strata together.
const ALL: &str = "all";

fn id(work: &Work<'_>, configuration: &Configuration) -> String {
    work.configuration(&[configuration.accelerator.name(), &configuration.rules()])
}

/// With each structure robust numerics, robust without a rule, and the paper's; and with hits ordered by exact t, with and
/// without that.
fn configurations(work: &Work<'_>, rays: usize) -> Vec<Configuration> {
    let most: usize = work.either(1 << 25, 1 << 27);
    let can_test_all = work.subject.scene.triangles.len().saturating_mul(rays) <= most;
    let mut all = Vec::new();
    for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::Irregular, Accelerator::None] {
        if accelerator == Accelerator::None && !can_test_all || !work.only.has(accelerator) {
            continue;
        }
        // Only one difference at a time: some rules cannot skip empty cells, so none do.
        let usual = Configuration::usual(accelerator, ScheduleKind::Fused);
        let robust = Configuration { skip: Skip::Off, grid: Some(work.grid_of(accelerator)), ..usual };
        let rules = Rule::ALL.iter().filter(|rule| has_rule(accelerator, **rule));
        all.push(robust);
        all.extend(rules.map(|&rule| Configuration { without: Some(rule), ..robust }));
        all.extend(numerics_of(accelerator).contains(&Numerics::Paper).then(|| robust.paper()));
        all.extend([robust.exact(), Configuration { without: Some(Rule::ExactOrder), ..robust.exact() }]);
    }
    all
}

/// The rays, and the ends of their strata.
struct Strata {
    rays: Vec<Ray>,
    ends: Vec<(&'static str, usize)>,
}

impl Strata {
    fn new(work: &Work<'_>) -> Result<Self, Error> {
        let scene = &work.subject.scene;
        // Ray origins slightly affect the grid, so its planes are those for an origin like those of the rays.
        let bounds = scene.bounds();
        let middle = Ray::new((bounds.min * 0.5 + bounds.max * 0.5).to_array(), [1.0, 0.0, 0.0]);
        let options = Options { shade: false, grid: work.grid, ..Options::new(RaySource::Given(vec![middle])) };
        let (_, data) = Plan::new(scene, &options, &work.machine().limits())?;
        let planes = Planes::of(&data);
        let aims = [Aim::Corners, Aim::Middles, Aim::Along, Aim::Faces(&planes), Aim::Anywhere];
        let each = work.either(1024, 8192).min(Judge::most_rays(work) / aims.len()).max(16);
        let (mut rays, mut ends) = (Vec::new(), Vec::new());
        for (i, aim) in (0..).zip(aims) {
            rays.extend(aimed(scene, aim, each, work.seed().wrapping_add(i)));
            ends.push((aim.name(), rays.len()));
        }
        Ok(Self { rays, ends })
    }

    fn of(&self, ray: usize) -> &'static str {
        self.ends.iter().find(|(_, end)| ray < *end).map_or(ALL, |(name, _)| name)
    }
}

struct Measured {
    configuration: Configuration,
    built: Built,
    times: Times,
    judged: Judged,
}

pub(super) async fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    if work.subject.scene.triangles.is_empty() {
        part.notes.push("the scene has no triangle to aim at".into());
        return Ok(part);
    }
    let first = table.rows.len();
    let strata = Strata::new(work)?;
    let (mut ready, mut left_out): (Vec<(Configuration, Built)>, Vec<String>) = (Vec::new(), Vec::new());
    let base = Options { shade: false, ..Options::new(RaySource::Given(strata.rays.clone())) };
    for configuration in configurations(work, strata.rays.len()) {
        let name = id(work, &configuration);
        if work.is_past(times::FOR_BUILDING) {
            left_out.push(name);
            continue;
        }
        work.stage(&format!("rules: building {name}"));
        let built = work.build(&configuration.of(&base)).await;
        ready.extend(work.noted(&mut part, &name, built)?.map(|built| (configuration, built)));
    }
    work.stage("rules: timing");
    let names: Vec<String> = ready.iter().map(|(configuration, _)| id(work, configuration)).collect();
    let mut renderers: Vec<_> = ready.iter_mut().map(|(_, built)| &mut built.renderer).collect();
    let times = work.time_in_turn(&names, &mut renderers, work.either(8, 20)).await?;
    part.notes.extend(work.left_out(&left_out));
    part.notes.extend(times::notes(work, names.iter().cloned().zip(&times)));
    work.stage("rules: judging");
    let mut judge = Judge::default();
    let mut measured = Vec::new();
    for ((configuration, built), times) in ready.into_iter().zip(times).filter(|(_, times)| !times.is_missing()) {
        let (judged, name) = (judge.judge(work, &built.renderer).await?, id(work, &configuration));
        part.notes.extend(times.is_given_up().then(|| format!("{name}: {}", judged.given_up())));
        judge.record(work, &built.renderer, &judged, &name, |ray| strata.of(ray));
        measured.push(Measured { configuration, built, times, judged });
    }
    let mut portions = Portions::new();
    for m in &measured {
        portions.rest().await;
        let of_robust = Configuration { numerics: Numerics::Robust, without: None, ..m.configuration };
        let robust = measured.iter().find(|r| r.configuration == of_robust);
        table.rows.extend(rows(work, &strata, &judge, m, robust));
    }
    adjust(&mut table.rows[first..]);
    let rows = &table.rows[first..];
    part.lead_figure("rules", figure::of(rows), figure::caption(rows));
    words::say(rows, &mut part);
    part.table(rows);
    Ok(part)
}

/// One row with times for all strata together, and one for each stratum.
fn rows(work: &Work<'_>, strata: &Strata, judge: &Judge, m: &Measured, robust: Option<&Measured>) -> Vec<Row> {
    let Measured { configuration, built, times, judged } = m;
    let plan = built.renderer.plan();
    let cells = built.renderer.data().grid.cells;
    let cell = |axis: usize| (configuration.accelerator == Accelerator::Grid).then_some(cells[axis]);
    let base = || {
        work.row(COLUMNS)
            .set("configuration", id(work, configuration))
            .configured(configuration)
            .set("cells_x", cell(0))
            .set("cells_y", cell(1))
            .set("cells_z", cell(2))
    };
    let row = times.fill(base(), work.seed()).set("stratum", ALL).set("rays", plan.rays).set("clock", work.clock());
    let row = judged.fill(row, Drawn::AtRandom);
    let row = match robust.filter(|robust| robust.configuration != *configuration) {
        None => row,
        Some(robust) => {
            let name = id(work, &robust.configuration);
            let row = times.fill_ratio(&robust.times, &name, row, work.seed());
            let [here, there] = judged.discordant(&robust.judged);
            match configuration.without {
                // No ray is wrong of whose hits f32 cannot tell which is nearer.
                Some(Rule::ExactOrder) => row.set("is_needed", judged.counts.ties > robust.judged.counts.ties),
                _ => row
                    .set("wrong_here_only", here)
                    .set("wrong_robust_only", there)
                    .set("p_value", mcnemar(here, there))
                    // A single wrong ray is wrong, whatever a test of many rays can tell.
                    .set("is_needed", here > 0 || judged.at_bound > 0),
            }
        }
    };
    let of_stratum = |(name, end): &(&'static str, usize)| {
        let counts = judged.counts_of(judge, |ray| strata.of(ray) == *name);
        let begin = strata.ends.iter().map(|(_, end)| *end).filter(|e| e < end).max().unwrap_or(0);
        verdicts(base().set("stratum", *name).set("rays", end - begin), &counts, Drawn::AtRandom)
    };
    std::iter::once(row).chain(strata.ends.iter().map(of_stratum)).collect()
}

/// Adjusts the p-values of all rules together.
fn adjust(rows: &mut [Row]) {
    let of: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].number("p_value").is_some()).collect();
    let values: Vec<f64> = of.iter().filter_map(|&i| rows[i].number("p_value")).collect();
    for (i, p) in of.into_iter().zip(holm(&values)) {
        rows[i] = rows[i].clone().set("p_value_holm", p);
    }
}
