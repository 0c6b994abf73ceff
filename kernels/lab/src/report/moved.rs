//! The error of t in scenes far from the origin, and in scenes with tiny or huge units.
//!
//! Two errors are distinguished. The *arithmetic error* comes from tracing the scene as it is in f32: it is measured
//! against f64 with the same f32 inputs, and predicted for each ray by the bound in `crate::reference`. The *rounding
//! error* comes from moving or scaling the scene, before any ray is traced: each coordinate is off by up to half a unit
//! in the last place, h. A plane with the normal n through vertices c is hit where (o + t·d − c)·n = 0. To first order,
//! with vertex weights that add up to 1,
//!
//! ```text
//! |Δt| ≤ Σ |n_axis| · (h(o_axis) + max h(c_axis)) / |d·n|
//! ```
//!
//! Both are worst cases. A tighter line, though not a bound, is one rounding, 2⁻²⁴, of the depth of the farthest vertex
//! of the hit triangle: t is a mean of the vertices' depths, each rounded, and errors of their weights change it only
//! as far as the depths differ.
//!
//! Errors of t are converted to distances along the ray, relative to the scene's extent, so that all places are
//! comparable.

mod plots;

use std::ops::ControlFlow;

use glam::DVec3;
use raystep_kernels::{Numerics, Options, Ray, RaySource};
use raystep_scenes::Scene;

use super::judge::{Drawn, Judge, Judged};
use super::page::{Part, number};
use super::work::Work;
use crate::Error;
use crate::meter::Ended;
use crate::rays::{Aim, aimed};
use crate::statistics::proportion::exact_interval;
use crate::statistics::quantile;
use crate::subject::Subject;
use crate::tidy::{KEYS, Row, Table, VERDICTS, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    &[
        "offset_extents",
        "scale",
        "numerics",
        "rays",
        "lost_per_million",
        "lost_per_million_low",
        "lost_per_million_high",
        "measured_rays",
        "t_error_extents_largest",
        "t_error_extents_median",
        "t_bound_extents_largest",
        "t_bound_extents_median",
        "t_largest_by_bound",
        "t_error_by_own_bound_largest",
        "t_bound_extents_of_largest_error",
        "t_step_extents_largest",
        "t_largest_by_step",
        "rounding_rays",
        "rounding_error_extents_largest",
        "rounding_error_extents_median",
        "rounding_bound_extents_largest",
        "rounding_bound_extents_median",
        "rounding_largest_by_bound",
        "rounding_error_by_own_bound_largest",
        "rounding_beyond_bound_rays",
    ],
    VERDICTS,
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Where the scene is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// Moved by this many extents.
    Moved(f64),
    /// Scaled by this factor.
    Scaled(f64),
}

/// Direction in which scenes are moved: neither an axis nor a diagonal.
const WAY: DVec3 = DVec3::new(1.0, -0.7, 0.4);

pub(super) fn moved(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    run(work, table, "offset_extents", &(0..=6).map(|k| Place::Moved(10f64.powi(k))).collect::<Vec<_>>())
}

pub(super) fn scaled(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    run(work, table, "scale", &(-4..=4).map(|k| Place::Scaled(10f64.powi(5 * k))).collect::<Vec<_>>())
}

fn run(work: &Work<'_>, table: &mut Table, column: &str, places: &[Place]) -> Result<Part, Error> {
    let mut part = Part::default();
    let scene = &work.subject.scene;
    if scene.triangles.is_empty() {
        part.notes.push("the scene has no triangle to aim at".into());
        return Ok(part);
    }
    let first = table.rows.len();
    let count = work.either(256, 2048).min(Judge::most_rays(work) / 2);
    let here = Here::new(work, count)?;
    for &place in places {
        work.stage(&format!("error at {place:?}"));
        if let Err(error) = one(work, &here, place, table, &mut part) {
            work.can_go_on()?;
            part.notes.push(format!("{place:?}: {}", work.explain(&error)));
        }
    }
    let rows = &table.rows[first..];
    part.figure("bound", plots::by_bound(column, rows).svg()?, "");
    part.figure("error", plots::errors(column, rows).svg()?, "");
    part.figure("wrong", plots::lost(column, rows).svg()?, "");
    let is_shown = |c: &&str| !KEYS.contains(c) && !matches!(*c, "offset_extents" | "scale" | "at_bound");
    let columns: Vec<&str> = std::iter::once(column).chain(COLUMNS.iter().copied().filter(is_shown)).collect();
    part.table(rows, &columns);
    say(rows, &mut part);
    Ok(part)
}

/// Adds a sentence on how tight the predictions are.
fn say(rows: &[Row], part: &mut Part) {
    let ends = |column: &str| {
        let robust = rows.iter().filter(|r| r.get("numerics") == "robust");
        let mut all: Vec<(f64, &Row)> = robust.filter_map(|r| Some((r.number(column)?, r))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some((*all.first()?, *all.last()?))
    };
    let share = |column: &str| {
        let ((_, least), (most, most_row)) = ends(column)?;
        let verdict = match most {
            m if m > 1.0 => ": the bound does not hold",
            m if m < 0.1 => ": the bound is too loose",
            _ => "",
        };
        Some(format!("{} to {} of its own bound{verdict}", number(column, least), number(column, most_row)))
    };
    if let Some(share) = share("t_error_by_own_bound_largest") {
        part.prose.push(format!(
            "With robust numerics, the arithmetic error of the ray closest to its bound is {share}. Every ray has \
             its own bound: that of a ray that grazes its triangle may be a thousand times larger."
        ));
    }
    if let Some(share) = share("rounding_error_by_own_bound_largest") {
        part.prose.push(format!(
            "The error from rounding the scene before tracing is, for the ray closest to its bound, {share}. This \
             bound follows from half a unit in the last place of each coordinate: |Δt| ≤ Σ |n| · (h(origin) + \
             h(corner)) / |d·n|, plus the arithmetic bound."
        ));
    }
    if let Some((_, (_, of_step))) = ends("t_largest_by_step") {
        part.prose.push(format!(
            "The largest error is at most {} times one rounding, 2⁻²⁴, of the largest depth.",
            number("t_largest_by_step", of_step)
        ));
    }
}

/// The original scene, and the rays whose t is compared with that of the moved or scaled scene.
struct Here {
    rays: Vec<Ray>,
    extent: f64,
    /// Triangle and t of each ray, in scene units.
    exact: Vec<Option<(u32, f64)>>,
}

impl Here {
    fn new(work: &Work<'_>, count: usize) -> Result<Self, Error> {
        let scene = &work.subject.scene;
        let rays = aimed(scene, Aim::Anywhere, count, work.seed());
        let options = Options { shade: false, ..Options::new(RaySource::Given(rays.clone())) };
        let mut renderer = work.build(&options)?.renderer;
        work.machine().wait(renderer.run(|_| ControlFlow::Continue(())))?;
        // All of them: there are few enough to judge.
        let traced: Vec<_> = rays
            .iter()
            .map(|ray| {
                let (ray, _) = raystep_kernels::scene_data::traced_ray(ray, renderer.data().units);
                [ray.origin, ray.direction]
            })
            .collect();
        let candidates = crate::reference::candidates_of(&renderer.data().vertices, &traced);
        let exact = candidates.iter().enumerate().map(|(i, c)| c.exact.map(|(k, t)| (k, t * renderer.t_scale(i))));
        Ok(Self { extent: extent(scene), exact: exact.collect(), rays })
    }
}

/// The longest side of the scene's box.
fn extent(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    f64::from((bounds.max - bounds.min).max_element())
}

impl Place {
    /// Part of a configuration's id.
    fn id(self) -> String {
        match self {
            Self::Moved(by) => format!("moved-{by:e}"),
            Self::Scaled(by) => format!("scaled-{by:e}"),
        }
    }

    /// The point after moving or scaling; exact.
    fn exact(self, point: DVec3, extent: f64) -> DVec3 {
        match self {
            Self::Moved(by) => point + WAY * (by * extent),
            Self::Scaled(by) => point * by,
        }
    }

    fn point(self, point: [f32; 3], extent: f64) -> [f32; 3] {
        self.exact(glam::Vec3::from(point).as_dvec3(), extent).as_vec3().to_array()
    }

    /// The factor for lengths.
    fn scale(self) -> f64 {
        match self {
            Self::Moved(_) => 1.0,
            Self::Scaled(by) => by,
        }
    }
}

fn one(work: &Work<'_>, here: &Here, place: Place, table: &mut Table, part: &mut Part) -> Result<(), Error> {
    let mut scene = work.subject.scene.clone();
    scene.triangles.iter_mut().flatten().for_each(|p| *p = place.point(*p, here.extent));
    let is_lost = |v: &f32| !v.is_finite() || (*v != 0.0 && v.abs() < f32::MIN_POSITIVE);
    if scene.triangles.iter().flatten().flatten().any(is_lost) {
        part.notes.push(format!("{place:?}: coordinates exceed the range of f32"));
        return Ok(());
    }
    // The first half keeps the original directions; the second half is aimed at the edges of the moved scene.
    let again = here.rays.iter().map(|r| Ray { origin: place.point(r.origin, here.extent), ..*r });
    let edges = aimed(&scene, Aim::Edges, here.rays.len(), work.seed() + 1);
    let rays: Vec<Ray> = again.chain(edges).collect();
    let Subject { camera, hash, file, .. } = work.subject;
    let subject = Subject { scene, camera: camera.clone(), hash: *hash, file: file.clone() };
    let work = Work { subject: &subject, ..*work };

    let mut judge = Judge::default();
    for numerics in [Numerics::Robust, Numerics::Paper] {
        let options = Options { numerics, shade: false, ..Options::new(RaySource::Given(rays.clone())) };
        let mut renderer = work.build(&options)?.renderer;
        if work.run(&mut renderer)? == Ended::GivenUp {
            part.notes.push(format!("{place:?}, {numerics}: stopped: too slow, or endless"));
            continue;
        }
        let judged = judge.judge(&work, &renderer)?;
        let unit = renderer.data().units.scene_units_per_stream_unit();
        let measured = measure(&judged, &judge, extent(&subject.scene) / unit);
        let rounding = rounding(&judged, &judge, &renderer, here, place, &subject.scene, &rays);
        let row = work.row(COLUMNS).set("numerics", numerics.name()).set("rays", rays.len());
        let row = row.set("configuration", work.configuration(&[&place.id(), numerics.name()]));
        let row = match place {
            Place::Moved(by) => row.set("offset_extents", by),
            Place::Scaled(by) => row.set("scale", by),
        };
        let (missed, of) = (judged.counts.missed, judged.counts.rays());
        let lost = exact_interval(missed, of);
        let row = judged
            .fill(row, Drawn::AtRandom)
            .set("lost_per_million", (of > 0).then(|| 1e6 * missed as f64 / of as f64))
            .set("lost_per_million_low", lost.map(|i| 1e6 * i[0]))
            .set("lost_per_million_high", lost.map(|i| 1e6 * i[1]));
        table.rows.push(rounding.fill("rounding", "rounding_rays", measured.fill("t", "measured_rays", row)));
    }
    Ok(())
}

/// Errors with their predictions, ray by ray, in extents.
#[derive(Default)]
struct Errors {
    errors: Vec<f64>,
    bounds: Vec<f64>,
    /// Predicted for the arithmetic: one rounding of the largest depth.
    steps: Vec<f64>,
}

impl Errors {
    fn add(&mut self, error: f64, bound: f64) {
        self.errors.push(error);
        self.bounds.push(bound);
    }

    fn fill(&self, of: &str, count: &str, row: Row) -> Row {
        let largest = |values: &[f64]| quantile(values, 1.0);
        let (error, bound) = (largest(&self.errors), largest(&self.bounds));
        let own = self.errors.iter().zip(&self.bounds).map(|(e, b)| e / b);
        let row = row
            .set(count, self.errors.len())
            .set(&format!("{of}_error_extents_largest"), error)
            .set(&format!("{of}_error_extents_median"), quantile(&self.errors, 0.5))
            .set(&format!("{of}_bound_extents_largest"), bound)
            .set(&format!("{of}_bound_extents_median"), quantile(&self.bounds, 0.5))
            .set(&format!("{of}_largest_by_bound"), error.zip(bound).map(|(e, b)| e / b));
        match of {
            "t" => {
                let step = largest(&self.steps);
                let pairs = self.errors.iter().zip(&self.bounds);
                let worst = pairs.max_by(|a, b| a.0.total_cmp(b.0)).map(|(_, bound)| *bound);
                row.set("t_error_by_own_bound_largest", own.reduce(f64::max))
                    .set("t_bound_extents_of_largest_error", worst)
                    .set("t_step_extents_largest", step)
                    .set("t_largest_by_step", error.zip(step).map(|(e, s)| e / s))
            }
            _ => row
                .set("rounding_error_by_own_bound_largest", own.clone().reduce(f64::max))
                .set("rounding_beyond_bound_rays", own.filter(|&share| share > 1.0).count()),
        }
    }
}

/// Measures the arithmetic error. `extent` is in traced units, as t is.
fn measure(judged: &Judged, judge: &Judge, extent: f64) -> Errors {
    let mut errors = Errors::default();
    for right in &judged.right {
        let length = DVec3::from(judge.direction(right.place)).length() / extent;
        errors.add((right.t - right.exact.t).abs() * length, right.exact.t_bound * length);
        errors.steps.push(0.5 * f64::from(f32::EPSILON) * right.exact.far * length);
    }
    errors
}

/// Measures how t changed, by rounding of the scene and arithmetic together.
fn rounding(
    judged: &Judged,
    judge: &Judge,
    renderer: &raystep_kernels::Renderer,
    here: &Here,
    place: Place,
    scene: &Scene,
    rays: &[Ray],
) -> Errors {
    let mut errors = Errors::default();
    for right in &judged.right {
        let index = judge.sample()[right.place];
        let Some(Some((triangle, t))) = here.exact.get(index).copied() else { continue };
        if triangle != right.exact.triangle {
            continue;
        }
        let scale = renderer.t_scale(index);
        let (ray, corners) = (&rays[index], &scene.triangles[triangle as usize]);
        let [direction, a, b, c] =
            [ray.direction, corners[0], corners[1], corners[2]].map(|v| glam::Vec3::from(v).as_dvec3());
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        let half_steps =
            |axis: usize| half_step(ray.origin[axis]) + corners.iter().map(|c| half_step(c[axis])).fold(0.0, f64::max);
        let moved: f64 =
            (0..3).map(|axis| normal[axis].abs() * half_steps(axis)).sum::<f64>() / direction.dot(normal).abs();
        let length = direction.length() / (here.extent * place.scale());
        errors
            .add((right.t * scale - t * place.scale()).abs() * length, (moved + right.exact.t_bound * scale) * length);
    }
    errors
}

/// Half the distance to the next f32: the largest error of rounding to this number.
fn half_step(value: f32) -> f64 {
    let magnitude = value.abs();
    0.5 * (f64::from(f32::from_bits(magnitude.to_bits() + 1)) - f64::from(magnitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_step_is_what_rounding_costs_at_most() {
        assert_eq!(half_step(1.0), 0.5f64.powi(24));
        assert_eq!(half_step(-3.0), 0.5f64.powi(23));
        assert_eq!(half_step(0.0), f64::from(f32::from_bits(1)) * 0.5);
    }

    #[test]
    fn points_are_moved_and_scaled_exactly_before_they_are_rounded() {
        assert_eq!(Place::Moved(10.0).point([1.0, 2.0, 3.0], 2.0), [21.0, -12.0, 11.0]);
        assert_eq!(Place::Scaled(1e5).point([1.0, -2.0, 0.0], 7.0), [1e5, -2e5, 0.0]);
    }
}
