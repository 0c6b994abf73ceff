//! The error of t in scenes far from the origin, and in scenes with tiny or huge units.
//!
//! Two errors are distinguished, on the same rays. The *arithmetic error* comes from tracing the scene as it is in f32:
//! it is measured against f64 with the same f32 inputs, and predicted for each ray by the bound in `crate::reference`.
//! A result with a small one is right for a scene close to the given one: its backward error is small. The *forward
//! error* is measured against the scene before it was moved or scaled, and so includes the rounding of every coordinate
//! to f32, off by up to half a unit in the last place, h. A plane with the normal n through vertices c is hit where
//! (o + t·d − c)·n = 0. To first order, with vertex weights that add up to 1, rounding changes t by
//!
//! ```text
//! |Δt| ≤ Σ |n_axis| · (h(o_axis) + max h(c_axis)) / |d·n|
//! ```
//!
//! Both bounds are worst cases. A tighter line, though not a bound, is one rounding, 2⁻²⁴, of the depth of the farthest
//! vertex of the hit triangle: t is a mean of the vertices' depths, each rounded, and errors of their weights change it
//! only as far as the depths differ.
//!
//! Errors of t are converted to distances along the ray, relative to the scene's extent, so that all transforms are
//! comparable. Rays are judged by strata: in any direction, and at corners, at middles of edges and along edges of the
//! moved scene.

mod errors;
mod plots;
mod words;

use std::fmt;
use std::ops::ControlFlow;

use glam::DVec3;
use raystep_kernels::{Numerics, Options, Ray, RaySource};
use raystep_scenes::Scene;

use super::judge::Judge;
use super::page::Part;
use super::work::Work;
use crate::Error;
use crate::meter::Ended;
use crate::rays::{Aim, aimed};
use crate::statistics::proportion::interval_or_bound;
use crate::subject::Subject;
use crate::tidy::fill::{Drawn, per_million, verdicts};
use crate::tidy::{KEYS, Row, Table, VERDICTS, count, joined};
use errors::measure;

const ERRORS: &[&str] = columns![
    numerics stratum rays measured_rays arithmetic_error_extents_largest arithmetic_error_extents_median
    arithmetic_bound_extents_largest arithmetic_bound_extents_median arithmetic_error_by_bound_largest
    depth_rounding_extents_largest arithmetic_by_depth_rounding forward_error_extents_largest
    forward_error_extents_median forward_bound_extents_largest forward_bound_extents_median
    forward_error_by_bound_largest beyond_forward_bound_rays changed_rays changed_per_million
    changed_per_million_low changed_per_million_high
];

const MOVED: &[&[&str]] = &[KEYS, &["offset_extents"], ERRORS, VERDICTS];
const SCALED: &[&[&str]] = &[KEYS, &["scale"], ERRORS, VERDICTS];

/// Columns of the section `moved`.
pub(super) const COLUMNS: &[&str] = &joined::<{ count(MOVED) }>(MOVED);

/// Columns of the section `scaled`.
pub(super) const SCALED_COLUMNS: &[&str] = &joined::<{ count(SCALED) }>(SCALED);

/// What rays are aimed at, a stratum each. Those in any direction come first, and are traced again after every transform.
const STRATA: [Aim<'static>; 4] = [Aim::Anywhere, Aim::Corners, Aim::Middles, Aim::Along];

/// How the scene is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Transform {
    /// Moved by this many extents.
    Moved(f64),
    /// Scaled by this factor.
    Scaled(f64),
}

/// Direction in which scenes are moved: neither an axis nor a diagonal.
const DIRECTION: DVec3 = DVec3::new(1.0, -0.7, 0.4);

pub(super) fn moved(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    run(work, table, "offset_extents", &(0..=6).map(|k| Transform::Moved(10f64.powi(k))).collect::<Vec<_>>())
}

pub(super) fn scaled(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    run(work, table, "scale", &(-4..=4).map(|k| Transform::Scaled(10f64.powi(5 * k))).collect::<Vec<_>>())
}

fn run(work: &Work<'_>, table: &mut Table, column: &'static str, transforms: &[Transform]) -> Result<Part, Error> {
    let mut part = Part::default();
    let scene = &work.subject.scene;
    if scene.triangles.is_empty() {
        part.notes.push("the scene has no triangle to aim at".into());
        return Ok(part);
    }
    let first = table.rows.len();
    let count = work.either(256, 1024).min(Judge::most_rays(work) / STRATA.len());
    let here = Here::new(work, count)?;
    let mut left_out = Vec::new();
    for (i, &transform) in transforms.iter().enumerate() {
        if work.is_past(1.0) {
            left_out.push(transform.to_string());
            continue;
        }
        work.stage(&format!("error at {transform}"));
        work.reporter.part("scenes", i as u64, transforms.len() as u64);
        let rows = one(work, &here, transform, table.columns, &mut part);
        table.rows.extend(work.noted(&mut part, &transform.to_string(), rows)?.into_iter().flatten());
    }
    part.notes.extend(work.left_out(&left_out));
    let rows = &table.rows[first..];
    part.figure("error", plots::errors(column, rows), words::errors_caption(rows));
    part.figure("bound", plots::by_bound(column, rows), words::bound_caption(rows));
    part.figure("wrong", plots::wrong(column, rows), words::wrong_caption(column, rows));
    part.figure("changed", plots::changed(column, rows), words::changed_caption(column, rows));
    part.table(rows);
    words::say(column, rows, &mut part);
    Ok(part)
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
        let mut renderer = work.wait(work.build(&options))?.renderer;
        work.wait(renderer.run(|_| ControlFlow::Continue(())))?;
        // All of them: there are few enough to judge.
        let traced: Vec<_> = rays
            .iter()
            .map(|ray| {
                let (ray, _) = raystep_kernels::scene_data::traced_ray(ray, renderer.data().units);
                [ray.origin, ray.direction]
            })
            .collect();
        let judging = crate::reference::candidates_of(&renderer.data().vertices, &traced);
        let candidates = work.wait(judging);
        let exact = candidates.iter().enumerate().map(|(i, c)| c.exact.map(|(k, t)| (k, t * renderer.t_scale(i))));
        Ok(Self { extent: extent(scene), exact: exact.collect(), rays })
    }
}

/// The longest side of the scene's box.
fn extent(scene: &Scene) -> f64 {
    let bounds = scene.bounds();
    f64::from((bounds.max - bounds.min).max_element())
}

impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Moved(by) => write!(f, "an offset of {by:e} extents"),
            Self::Scaled(by) => write!(f, "a scale of {by:e}"),
        }
    }
}

impl Transform {
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
            Self::Moved(by) => point + DIRECTION * (by * extent),
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

/// A row for each stratum with each numerics.
fn one(
    work: &Work<'_>,
    here: &Here,
    transform: Transform,
    columns: &'static [&'static str],
    part: &mut Part,
) -> Result<Vec<Row>, Error> {
    let mut scene = work.subject.scene.clone();
    scene.triangles.iter_mut().flatten().for_each(|p| *p = transform.point(*p, here.extent));
    let is_lost = |v: &f32| !v.is_finite() || (*v != 0.0 && v.abs() < f32::MIN_POSITIVE);
    if scene.triangles.iter().flatten().flatten().any(is_lost) {
        part.notes.push(format!("{transform}: coordinates exceed the range of f32"));
        return Ok(Vec::new());
    }
    // Rays in any direction keep theirs; the others are aimed at the edges of the moved scene.
    let again = here.rays.iter().map(|r| Ray { origin: transform.point(r.origin, here.extent), ..*r });
    let mut rays: Vec<Ray> = again.collect();
    let mut ends = vec![0, rays.len()];
    for (aim, seed) in STRATA.into_iter().zip(work.seed()..).skip(1) {
        rays.extend(aimed(&scene, aim, here.rays.len(), seed));
        ends.push(rays.len());
    }
    let Subject { camera, hash, file, .. } = work.subject;
    let subject = Subject { scene, camera: camera.clone(), hash: *hash, file: file.clone() };
    let work = Work { subject: &subject, ..*work };

    let mut judge = Judge::default();
    let mut rows = Vec::new();
    for numerics in [Numerics::Robust, Numerics::Paper] {
        let options = Options { numerics, shade: false, ..Options::new(RaySource::Given(rays.clone())) };
        let mut renderer = work.wait(work.build(&options))?.renderer;
        if work.wait(work.run(&mut renderer))? == Ended::GivenUp {
            part.notes.push(format!("{transform}, {numerics}: stopped: too slow, or endless"));
            continue;
        }
        let judged = work.wait(judge.judge(&work, &renderer))?;
        let aim_of =
            |ray: usize| STRATA[ends[1..].iter().filter(|&&end| ray >= end).count().min(STRATA.len() - 1)].name();
        judge.record(&work, &renderer, &judged, &work.configuration(&[&transform.id(), numerics.name()]), aim_of);
        let hits = work.wait(renderer.hits())?;
        for (aim, ends) in STRATA.into_iter().zip(ends.windows(2)) {
            let of = ends[0]..ends[1];
            let counts = judged.counts_of(&judge, |ray| of.contains(&ray));
            let in_stratum = judge.sample().iter().filter(|ray| of.contains(ray)).count() as u64;
            let unresolved = in_stratum - counts.rays();
            let is_again = aim == Aim::Anywhere;
            let errors =
                measure(&judged, &judge, &of, is_again.then_some((here, transform)), &subject.scene, &rays, &renderer);
            let row =
                work.row(columns).set("numerics", numerics.name()).set("stratum", aim.name()).set("rays", of.len());
            let row = row.set("configuration", work.configuration(&[&transform.id(), numerics.name()]));
            let row = match transform {
                Transform::Moved(by) => row.set("offset_extents", by),
                Transform::Scaled(by) => row.set("scale", by),
            };
            let row = errors.fill(verdicts(row, &counts, Drawn::AtRandom).set("at_bound", unresolved));
            let found = hits[of.clone()].iter().map(|hit| hit.map(|hit| hit.triangle));
            rows.push(if is_again { changed(row, found, here) } else { row });
        }
    }
    Ok(rows)
}

/// Fills the columns of rays that hit something else than before the scene was rounded.
fn changed(row: Row, found: impl ExactSizeIterator<Item = Option<u32>>, here: &Here) -> Row {
    let of = found.len() as u64;
    let exact = here.exact.iter().map(|exact| exact.map(|(triangle, _)| triangle));
    let changed = found.zip(exact).filter(|(found, exact)| found != exact).count() as u64;
    let ends = interval_or_bound(changed, of);
    row.set("changed_rays", changed)
        .set("changed_per_million", per_million(changed, of))
        .ends("changed_per_million", ends.map(|ends| ends.map(|share| 1e6 * share)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_moved_and_scaled_exactly_before_they_are_rounded() {
        assert_eq!(Transform::Moved(10.0).point([1.0, 2.0, 3.0], 2.0), [21.0, -12.0, 11.0]);
        assert_eq!(Transform::Scaled(1e5).point([1.0, -2.0, 0.0], 7.0), [1e5, -2e5, 0.0]);
    }
}
