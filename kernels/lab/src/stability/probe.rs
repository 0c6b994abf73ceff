//! Compares pipelines: traces the same ray/triangle pairs through every pipeline that contains the triangle test.
//!
//! The test's source becomes part of several pipelines, and each is compiled separately: a compiler may contract or
//! reorder in one of them, and t then differs in its last bits. Grid, BVH and `none` agree bit for bit on a device only
//! if this probe finds no difference there.

use raystep_kernels::numbers::real::ulps;
use raystep_kernels::options::{Accelerator, Options, RaySource, ScheduleKind, Skip};
use raystep_kernels::renderer::{Device, RenderError, Renderer};
use raystep_kernels::shared::constants::NO_TRIANGLE;
use serde::Serialize;

use crate::Error;
use crate::stability::row::DeviceName;
use crate::stability::{Workload, make};
use crate::tidy;

/// A pipeline that contains the triangle test.
#[derive(Clone, Debug, PartialEq)]
pub struct Pipeline {
    /// Its name in reports: accelerator, schedule, and other differences.
    pub name: String,
    /// Whether it traces a camera's rays, which the fused kernel generates itself, or input rays.
    pub is_camera: bool,
    options: Options,
}

/// The hits of all rays, as bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bits {
    /// Triangle, t, u and v of each ray; [`NO_TRIANGLE`] without a hit.
    pub rays: Vec<[u32; 4]>,
}

/// How a pipeline's results differ from another's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit the same triangle in both pipelines: these pairs are compared.
    pub pairs: u64,
    /// Rays that hit another triangle, or none, in one of the pipelines.
    pub other_triangle: u64,
    /// Pairs whose t, u and v differ in any bit.
    pub differing: [u64; 3],
    /// Largest differences: t in units in the last place, u and v in those of 1, 2⁻²³.
    pub largest: [f64; 3],
}

/// The scene and rays of the probe, by [`Pipeline::is_camera`].
///
/// # Errors
/// If the scene cannot be generated.
pub fn workloads(rays: usize) -> Result<[Workload; 2], Error> {
    let side = rays.isqrt().max(1) as u32;
    Ok([make::given(make::sphere(3, |p| p)?, make::inside(0.5, rays)), make::picture(side, side, 60.0)?])
}

/// Every pipeline with a triangle test; the others are compared with the first one that traces the same kind of rays.
#[must_use]
pub fn pipelines(workloads: &[Workload; 2]) -> Vec<Pipeline> {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, Fused, Second};
    let mut all = Vec::new();
    for accelerator in [None, Bvh, Grid] {
        for (schedule, steps) in [(Second, 1), (Compact, 1), (Compact, 8), (Fused, 1)] {
            let base = Options {
                accelerator,
                schedule,
                steps_per_pass: if accelerator == None && schedule == Compact && steps > 1 { 128 } else { steps },
                shade: false,
                skip: Skip::Off,
                ..Options::new(workloads[0].rays.clone())
            };
            let name = match steps {
                1 => format!("{accelerator} {schedule}"),
                _ => format!("{accelerator} {schedule} {} steps", base.steps_per_pass),
            };
            let mut add = |suffix: &str, options: Options| {
                let is_camera = matches!(options.rays, RaySource::Camera { .. });
                all.push(Pipeline { name: format!("{name}{suffix}"), is_camera, options });
            };
            add("", base.clone());
            add(" with counters", Options { counters: true, ..base.clone() });
            if accelerator == Grid {
                add(" skipping", Options { skip: Skip::On, ..base.clone() });
            }
            add(" fma", Options { contracted: true, ..base.clone() });
            if schedule != Compact {
                // Stepped schedules generate rays in a separate kernel, `fused` in the kernel that traces them.
                add(" of a camera", Options { rays: workloads[1].rays.clone(), ..base });
            }
        }
    }
    all
}

/// Traces the rays through one pipeline.
///
/// # Errors
/// If the device fails.
pub async fn run(pipeline: &Pipeline, workloads: &[Workload; 2], device: &Device) -> Result<Bits, Error> {
    let scene = &workloads[usize::from(pipeline.is_camera)].scene;
    let mut renderer = Renderer::new(scene, &pipeline.options, device).await?;
    renderer.run(|_| std::ops::ControlFlow::Continue(())).await?;
    Ok(Bits::of(&renderer).await?)
}

/// Pipelines that are run one by one, each compared with the first that traced the same rays.
pub struct Comparison {
    workloads: [Workload; 2],
    bases: [Option<(String, Bits)>; 2],
}

impl Comparison {
    /// None so far, with so many rays each.
    ///
    /// # Errors
    /// If the scene cannot be generated.
    pub fn new(rays: usize) -> Result<Self, Error> {
        Ok(Self { workloads: workloads(rays)?, bases: [None, None] })
    }

    /// Every [pipeline](pipelines).
    #[must_use]
    pub fn pipelines(&self) -> Vec<Pipeline> {
        pipelines(&self.workloads)
    }

    /// Whether one with the same rays has run.
    #[must_use]
    pub fn has_base(&self, pipeline: &Pipeline) -> bool {
        self.bases[usize::from(pipeline.is_camera)].is_some()
    }

    /// Runs a pipeline on a device, and compares it.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn run(
        &mut self,
        run_id: &str,
        name: &DeviceName,
        pipeline: &Pipeline,
        device: &Device,
    ) -> Result<Row, Error> {
        let bits = run(pipeline, &self.workloads, device).await?;
        let (base_name, base) = self.bases[usize::from(pipeline.is_camera)]
            .get_or_insert_with(|| (format!("{}: {}", name.kind, pipeline.name), bits.clone()));
        Ok(Row::new(run_id, name, pipeline, base_name, bits.difference(base)))
    }
}

impl Bits {
    /// The hits of a run.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn of(renderer: &Renderer) -> Result<Self, RenderError> {
        let results = renderer.results()?;
        let (t, hit) = (renderer.values(results.t.stream).await?, renderer.values(results.triangle.stream).await?);
        let [u, v] = results.weights;
        let rays = renderer.plan().rays as usize;
        let of =
            |ray| [hit.get(results.triangle.layer, ray), t.get(results.t.layer, ray), hit.get(u, ray), hit.get(v, ray)];
        Ok(Self { rays: (0..rays).map(of).collect() })
    }

    /// Compares two results ray by ray.
    #[must_use]
    pub fn difference(&self, base: &Self) -> Difference {
        let mut found = Difference { rays: self.rays.len() as u64, ..Difference::default() };
        for (&[triangle, t, u, v], &[base_triangle, base_t, base_u, base_v]) in self.rays.iter().zip(&base.rays) {
            if triangle != base_triangle {
                found.other_triangle += 1;
                continue;
            }
            if triangle == NO_TRIANGLE {
                continue;
            }
            found.pairs += 1;
            let weight =
                |a: u32, b: u32| f64::from((f32::from_bits(a) - f32::from_bits(b)).abs()) / f64::from(f32::EPSILON);
            let by = [ulps(t, base_t) as f64, weight(u, base_u), weight(v, base_v)];
            for (i, differs) in [t != base_t, u != base_u, v != base_v].into_iter().enumerate() {
                found.differing[i] += u64::from(differs);
                found.largest[i] = found.largest[i].max(by[i]);
            }
        }
        found
    }
}

/// The file of a report's comparisons.
pub const FILE: &str = "pipelines.csv";

/// Columns of `pipelines.csv`: one row a pipeline, with its [`Difference`] from the pipeline of the first device that
/// traced the same rays.
pub const COLUMNS: &[&str] = columns![
    schema_version run_id configuration device adapter pipeline compared_with rays pairs other_triangle
    differing_t differing_u differing_v t_ulp u_ulp v_ulp
];

/// A row of `pipelines.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was compared.
    pub difference: Difference,
    /// The row's text.
    pub(super) fields: tidy::Row,
}

impl Row {
    /// The row of a comparison.
    #[must_use]
    pub fn new(
        run_id: &str,
        device: &DeviceName,
        pipeline: &Pipeline,
        compared_with: &str,
        difference: Difference,
    ) -> Self {
        let [t, u, v] = difference.differing;
        let [t_ulp, u_ulp, v_ulp] = difference.largest;
        // Weights differ by multiples of half a unit.
        let short = |value: f64| format!("{value:.3}").parse::<f64>().unwrap_or(value);
        let fields = tidy::Row::new(COLUMNS)
            .set("run_id", run_id)
            .set("configuration", format!("pipelines/{}/{}", device.kind, pipeline.name))
            .with(device)
            .set("pipeline", &*pipeline.name)
            .set("compared_with", compared_with)
            .with(&difference)
            .set("differing_t", t)
            .set("differing_u", u)
            .set("differing_v", v)
            .set("t_ulp", t_ulp)
            .set("u_ulp", short(u_ulp))
            .set("v_ulp", short(v_ulp));
        Self { difference, fields }
    }

    /// A field by its column's name.
    #[must_use]
    pub fn field(&self, column: &str) -> &str {
        self.fields.get(column)
    }
}

/// All rows as one table.
pub(crate) fn table(rows: &[Row]) -> tidy::Table {
    tidy::Table { columns: COLUMNS, rows: rows.iter().map(|row| row.fields.clone()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_that_differ_are_counted_where_the_triangle_is_the_same() {
        let one = 1f32.to_bits();
        let base = Bits { rays: vec![[7, one, one, 0], [8, one, 0, 0], [9, one, 0, 0], [NO_TRIANGLE, 5, 0, 0]] };
        let mut other = base.clone();
        other.rays[0] = [7, one + 2, one - 1, 0];
        other.rays[1][0] = 3;
        other.rays[3][1] = 6;
        let found = other.difference(&base);
        assert_eq!((found.rays, found.pairs, found.other_triangle), (4, 2, 1), "rays without a hit are not compared");
        assert_eq!((found.differing, found.largest), ([1, 1, 0], [2.0, 0.5, 0.0]));
        assert_eq!(base.difference(&base).differing, [0; 3]);
    }

    /// All pipelines run the same twins on the CPU, so only explicit fma makes a difference.
    #[test]
    fn the_twins_have_the_same_bits_in_every_pipeline() {
        let workloads = workloads(64).expect("scenes");
        let run = |p: &Pipeline| pollster::block_on(run(p, &workloads, &Device::Cpu(None))).expect("hits");
        let (mut bases, mut contracted) = ([None, None], 0);
        for pipeline in pipelines(&workloads) {
            let bits = run(&pipeline);
            let base: &mut Bits = bases[usize::from(pipeline.is_camera)].get_or_insert_with(|| bits.clone());
            let found = bits.difference(base);
            let differing: u64 = found.differing.iter().sum();
            assert_eq!((found.pairs, found.other_triangle), (64, 0), "{}", pipeline.name);
            assert_eq!(differing > 0, pipeline.options.contracted, "{}: {found:?}", pipeline.name);
            contracted += usize::from(pipeline.options.contracted);
        }
        assert_eq!(contracted, 12);
    }

    #[test]
    fn every_pipeline_has_a_name_of_its_own_and_something_to_compare_it_with() {
        let workloads = workloads(64).expect("scenes");
        let all = pipelines(&workloads);
        let names: std::collections::BTreeSet<_> = all.iter().map(|p| &p.name).collect();
        assert_eq!(names.len(), all.len());
        assert!(all.iter().filter(|p| p.is_camera).count() >= 6 && !all[0].is_camera);
    }
}
