//! Table 1: the streams that each kernel writes.

use raystep_kernels::Plan;
use raystep_kernels::shader::{Binding, Resource};

use serde::Serialize;

use crate::Error;
use crate::tidy::{Row, Table};

pub(super) const COLUMNS: &[&str] = columns![schema_version paper_kernel kernel paper_streams streams difference];

/// The paper's kernel, ours, and the paper's output textures, each with the stream that holds the same here.
type Row1 = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

pub(super) const PAPER: [Row1; 5] = [
    (
        "eye ray generator",
        "generate",
        &[("eye ray origin", "ray_origin"), ("eye ray direction", "ray_direction"), ("state vector", "state")],
    ),
    (
        "traversal setup",
        "setup",
        &[
            ("ray origin", "ray_origin"),
            ("ray direction", "ray_direction"),
            ("state vector", "state"),
            ("traversal data", "tmax"),
        ],
    ),
    ("traversal", "traverse_grid", &[("state vector", "state"), ("traversal data", "tmax")]),
    ("intersection", "intersect", &[("state vector", "state"), ("intersection data", "hit")]),
    ("Shader", "shade", &[("Color", "color")]),
];

/// Why a kernel writes a stream in one of the two only.
const REASONS: [(&str, &str, &str); 4] = [
    ("generate", "hit", "a new ray has none; clears that of the pixel's last ray"),
    ("setup", "ray_origin", "it copies the ray; here later kernels read that of generate"),
    ("setup", "ray_direction", "as the origin"),
    ("shade", "state", "the ray becomes DONE, and no later pass takes it"),
];

/// A row of Table 1, and ours.
#[derive(Clone, Debug, Serialize)]
pub struct Output {
    /// The kernel's name in the paper.
    pub paper_kernel: &'static str,
    /// Its name here.
    pub kernel: &'static str,
    /// Output textures in the paper.
    pub paper_streams: String,
    /// Streams that it writes here, by reflection.
    pub streams: String,
    /// What it reads here: streams, buffers and uniforms.
    pub reads: String,
    /// Streams written in one of the two only, and why.
    #[serde(skip)]
    differences: Vec<(String, Option<&'static str>)>,
}

/// The rows of Table 1.
#[derive(Clone, Debug)]
pub struct Outputs(pub Vec<Output>);

/// Reflects the kernels of a plan.
#[must_use]
pub fn outputs(plan: &Plan) -> Outputs {
    Outputs(PAPER.iter().map(|row| Output::of(plan, row)).collect())
}

impl Output {
    fn of(plan: &Plan, &(paper_kernel, kernel, streams): &Row1) -> Self {
        let variant = plan.variants.iter().find(|variant| variant.kernel.name() == kernel);
        let bindings = variant.map_or(&[][..], |variant| &variant.bindings);
        let is_data = |binding: &&Binding| !matches!(binding.resource, Resource::Live { .. } | Resource::Launch);
        let names = |is_wanted: fn(&Binding) -> bool| {
            let wanted = bindings.iter().filter(is_data).filter(|binding| is_wanted(binding));
            wanted.map(|binding| binding.name.as_str()).collect::<Vec<_>>()
        };
        let (written, read) = (names(|binding| binding.writes), names(|binding| binding.reads));
        let reason = |stream: &str| {
            REASONS.iter().find(|(of, what, _)| *of == kernel && *what == stream).map(|(_, _, why)| *why)
        };
        let here = written.iter().filter(|name| streams.iter().all(|(_, stream)| stream != *name));
        let here = here.map(|name| (format!("{name} here only"), reason(name)));
        let there = streams.iter().filter(|(_, stream)| !written.contains(stream));
        let there = there.map(|(name, stream)| (format!("{name} in the paper only"), reason(stream)));
        Self {
            paper_kernel,
            kernel,
            paper_streams: streams.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "),
            differences: here.chain(there).collect(),
            streams: written.join(", "),
            reads: read.join(", "),
        }
    }

    /// Whether every difference has a reason.
    #[must_use]
    pub fn is_explained(&self) -> bool {
        self.differences.iter().all(|(_, why)| why.is_some())
    }

    fn differences(&self) -> impl Iterator<Item = String> {
        self.differences.iter().map(|(what, why)| format!("{what}: {}", why.unwrap_or("not known")))
    }
}

impl Outputs {
    /// A table.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = "Table 1: output textures of each kernel; here by reflection of its final WGSL\n".to_owned();
        for output in &self.0 {
            text += &format!("  {} = {}\n", output.paper_kernel, output.kernel);
            let rows = [("paper", &output.paper_streams), ("here", &output.streams), ("reads", &output.reads)];
            rows.iter().for_each(|(name, streams)| text += &format!("    {name:<7} {streams}\n"));
            output.differences().for_each(|difference| text += &format!("    differs {difference}\n"));
        }
        text
    }

    /// The CSV file.
    ///
    /// # Errors
    /// If memory is short.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let row = |output: &Output| {
            let differences: Vec<String> = output.differences().collect();
            Row::new(COLUMNS).with(output).set("difference", differences.join("; "))
        };
        Ok(Table { columns: COLUMNS, rows: self.0.iter().map(row).collect() }.csv()?)
    }
}
