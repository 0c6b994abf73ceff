//! The data flow of a run, drawn from reflection: which kernel reads, writes or updates which stream and buffer (the
//! paper's Figure 4 and Table 1).
//!
//! ```text
//!   [ray_origin] [state] [tmax] [hit] [color]      streams
//!        |    \   /  |      |     |      ^
//!   (generate) (setup) (intersect) (shade)         kernels, in the order in which they first run
//!        ^        ^         ^         ^
//!   [camera]   [grid]  [grid_cells] [materials]    buffers of the scene, uniforms among them
//! ```
//!
//! Edges join neighbouring rows only, so none runs through a node.

mod layout;

use raystep_kernels::plan::Bytes;
use raystep_kernels::shader::{Binding, Resource};
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Kernel, Plan, Program, Stream};

pub(crate) use layout::{CHARACTER, HEIGHT};

/// The graph and its layout.
#[derive(Clone, Debug, PartialEq)]
pub struct DataFlow {
    /// Kernels first, in the order in which they first run, then streams, then buffers, each from left to right.
    pub nodes: Vec<Node>,
    /// Every binding of every kernel.
    pub edges: Vec<Edge>,
    /// Width and height in points at which labels fit their nodes; positions are fractions of it.
    pub size: [f32; 2],
}

/// The kind of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// A kernel.
    Kernel(Kernel),
    /// A per-ray stream.
    Stream(Stream),
    /// A buffer of scene data, or a uniform, by name.
    Buffer(&'static str),
}

/// A kernel, stream or buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it is.
    pub kind: NodeKind,
    /// Its name.
    pub label: String,
    /// A second line: the layers of a stream, the bytes of a buffer; empty for a kernel.
    pub detail: String,
    /// Its purpose, in a sentence.
    pub about: String,
    /// Left and upper edge, from 0 to 1.
    pub min: [f32; 2],
    /// Right and lower edge, from 0 to 1.
    pub max: [f32; 2],
}

/// How a kernel accesses a stream or buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Access {
    /// Only reads it.
    Read,
    /// Only writes it.
    Write,
    /// Reads and writes it: an update in place.
    Update,
    /// Reads a copy, or the other one of two textures, and draws into it.
    Redraw,
}

/// A binding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The kernel, as an index of a node.
    pub kernel: usize,
    /// The stream or buffer, as an index of a node.
    pub data: usize,
    /// The access.
    pub access: Access,
    /// The end at the kernel, from 0 to 1.
    pub at_kernel: [f32; 2],
    /// The end at the stream or buffer, from 0 to 1.
    pub at_data: [f32; 2],
}

impl Access {
    fn of(binding: &Binding) -> Self {
        match (binding.reads, binding.writes) {
            (true, true) => Self::Update,
            (false, true) => Self::Write,
            (_, false) => Self::Read,
        }
    }

    /// As in "the kernel … it".
    #[must_use]
    pub fn verb(self) -> &'static str {
        match self {
            Self::Read => "reads",
            Self::Write => "writes",
            Self::Update => "updates in place",
            Self::Redraw => "reads a copy of and draws",
        }
    }
}

impl Access {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Read, Self::Write, Self::Update, Self::Redraw];
}

impl DataFlow {
    /// The data flow of a run, without what the plan omits and without the executor's lists and counters of rays.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let variants: Vec<_> = plan.variants.iter().filter(|v| v.kernel.role() != Role::Count).collect();
        let kernels = variants.iter().map(|v| kernel_node(v.kernel));
        let streams = plan.streams.iter().map(|s| {
            let is_double = plan.drawn.as_ref().is_some_and(|drawn| drawn.is_double(s.what));
            stream_node(s.what, is_double)
        });
        let buffers = plan.buffers.iter().filter_map(|b| buffer_node(plan.program, b.what, b.bytes));
        let nodes: Vec<Node> = kernels.chain(streams).chain(buffers).collect();
        let mut edges = Vec::new();
        for (kernel, variant) in variants.iter().enumerate() {
            for binding in variant.bindings.iter().filter(|b| !matches!(b.resource, Resource::Live { .. })) {
                let is_bound = |n: &Node| !matches!(n.kind, NodeKind::Kernel(_)) && n.label == binding.name;
                if let Some(data) = nodes.iter().position(is_bound) {
                    let drawn = plan.drawn.as_ref().and_then(|drawn| drawn.of(variant.kernel));
                    let is_redrawn = drawn.zip(binding.stream()).is_some_and(|(drawn, s)| drawn.updates.contains(&s));
                    let access = if is_redrawn { Access::Redraw } else { Access::of(binding) };
                    edges.push(Edge { kernel, data, access, at_kernel: [0.0; 2], at_data: [0.0; 2] });
                }
            }
            // It reads them under the names that they have then.
            for (_, adopted) in variant.kernel.instance().adopts {
                let is_it = |n: &Node| n.kind == NodeKind::Stream(*adopted);
                if let Some(data) = nodes.iter().position(is_it) {
                    let access = Access::Read;
                    edges.push(Edge { kernel, data, access, at_kernel: [0.0; 2], at_data: [0.0; 2] });
                }
            }
        }
        layout::place(nodes, edges)
    }

    /// The kinds of access that it has.
    pub(crate) fn accesses(&self) -> impl Iterator<Item = Access> {
        Access::ALL.into_iter().filter(|&access| self.edges.iter().any(|edge| edge.access == access))
    }

    /// All accesses, in the order in which they are drawn.
    pub fn of(&self, kernel: Kernel) -> impl Iterator<Item = (&Node, Access)> {
        let is_its = move |edge: &&Edge| self.nodes[edge.kernel].kind == NodeKind::Kernel(kernel);
        self.edges.iter().filter(is_its).map(|edge| (&self.nodes[edge.data], edge.access))
    }

    /// How many pairs of edges cross.
    #[must_use]
    pub fn crossings(&self) -> usize {
        let row = |edge: &Edge| matches!(self.nodes[edge.data].kind, NodeKind::Stream(_));
        let pairs = self.edges.iter().enumerate().flat_map(|(i, a)| self.edges[..i].iter().map(move |b| (a, b)));
        let side = |a: f32, b: f32| a.total_cmp(&b);
        let cross = |&(a, b): &(&Edge, &Edge)| {
            row(a) == row(b) && side(a.at_kernel[0], b.at_kernel[0]) == side(b.at_data[0], a.at_data[0])
        };
        pairs.filter(cross).count()
    }
}

fn node(kind: NodeKind, label: &str, detail: String, about: String) -> Node {
    Node { kind, label: label.into(), detail, about, min: [0.0; 2], max: [0.0; 2] }
}

fn kernel_node(kernel: Kernel) -> Node {
    node(NodeKind::Kernel(kernel), kernel.name(), String::new(), kernel.info().summary.into())
}

/// `is_double`: it has two textures.
fn stream_node(stream: Stream, is_double: bool) -> Node {
    let info = stream.info();
    let textures = if is_double { ", 2 textures" } else { "" };
    node(NodeKind::Stream(stream), info.name, info.layer_names() + textures, info.unit.into())
}

/// `None` for buffers that are not scene data but belong to the executor.
fn buffer_node(program: &Program, name: &str, bytes: u64) -> Option<Node> {
    let info = program.buffer(name)?;
    Some(node(NodeKind::Buffer(info.name), info.name, Bytes(bytes).to_string(), info.element.into()))
}
