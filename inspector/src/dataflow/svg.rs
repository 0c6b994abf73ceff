//! The graph as SVG 1.1. Arrowheads are drawn, as not every viewer knows markers.

use std::fmt::Write as _;

use raystep_kernels::Kernel;
use raystep_lab::text::counted;

use super::{Access, DataFlow, Edge, Node, NodeKind};

/// Points below the graph, for the legend.
const LEGEND: f32 = 34.0;
/// Length of an arrowhead, points.
const HEAD: f32 = 8.0;

/// Of edges that are not the current kernel's. No opacity: not every viewer knows it.
const FADED: &str = "#dcdcdc";

/// Blue, orange, purple: apart for every kind of colour vision, and by their arrowheads without any.
fn color(access: Access) -> &'static str {
    match access {
        Access::Read => "#2a6fbb",
        Access::Write => "#c8621b",
        Access::Update => "#7a3b9a",
    }
}

impl DataFlow {
    /// The graph as an SVG file. What `current` does not bind is faded; `rays` is what each kernel worked on, where
    /// that is known.
    #[must_use]
    pub fn svg(&self, current: Option<Kernel>, rays: &[(Kernel, u64)]) -> String {
        let [width, height] = self.size;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{0}\" viewBox=\"0 0 {width} {0}\" \
             font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
            height + LEGEND
        );
        // What is faded lies below.
        let is_faded = |edge: &&Edge| current.is_some_and(|k| self.nodes[edge.kernel].kind != NodeKind::Kernel(k));
        for edge in self.edges.iter().filter(|e| is_faded(e)) {
            self.edge(&mut out, edge, FADED);
        }
        for edge in self.edges.iter().filter(|e| !is_faded(e)) {
            self.edge(&mut out, edge, color(edge.access));
        }
        for node in &self.nodes {
            self.node(&mut out, node, current, rays);
        }
        let mut x = 16.0;
        let y = height + LEGEND / 2.0 - 4.0;
        for access in [Access::Read, Access::Write, Access::Update] {
            let [kernel, data] = [[x, y], [x + 40.0, y]];
            arrow(&mut out, access, kernel, data, color(access));
            let name = format!("kernel {}", access.verb());
            text(&mut out, [x + 48.0, y + 4.0], "start", "#222222", &name);
            x += 190.0;
        }
        out.push_str("</svg>\n");
        out
    }

    fn points(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [x * self.size[0], y * self.size[1]]
    }

    fn edge(&self, out: &mut String, edge: &Edge, color: &str) {
        let (kernel, data) = (&self.nodes[edge.kernel].label, &self.nodes[edge.data].label);
        let _ = write!(out, "<g><title>{kernel}: {} {data}</title>", edge.access.verb());
        arrow(out, edge.access, self.points(edge.at_kernel), self.points(edge.at_data), color);
        out.push_str("</g>\n");
    }

    fn node(&self, out: &mut String, node: &Node, current: Option<Kernel>, rays: &[(Kernel, u64)]) {
        let (min, max) = (self.points(node.min), self.points(node.max));
        let [width, height] = [max[0] - min[0], max[1] - min[1]];
        let is_current = current.is_some_and(|k| node.kind == NodeKind::Kernel(k));
        let (fill, ink, corner) = match node.kind {
            NodeKind::Kernel(_) => ("#ffe7bd", "#2b2000", 6.0),
            NodeKind::Stream(_) => ("#dcefe6", "#12352a", height / 2.0),
            NodeKind::Buffer(_) => ("#ececec", "#222222", 0.0),
        };
        let stroke = if is_current { "stroke=\"#b00020\" stroke-width=\"4\"" } else { "stroke=\"#888888\"" };
        let detail = match node.kind {
            NodeKind::Kernel(kernel) => {
                let found = rays.iter().find(|(k, _)| *k == kernel);
                found.map(|(_, n)| counted(*n, "ray")).unwrap_or_default()
            }
            _ => node.detail.clone(),
        };
        let _ = writeln!(
            out,
            "<g><title>{}: {}</title><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             rx=\"{corner}\" fill=\"{fill}\" {stroke}/>",
            node.label,
            escaped(&node.about),
            min[0],
            min[1],
        );
        let middle = (min[0] + max[0]) / 2.0;
        let first = if detail.is_empty() { 24.0 } else { 17.0 };
        text(out, [middle, min[1] + first], "middle", ink, &node.label);
        if !detail.is_empty() {
            text(out, [middle, min[1] + 32.0], "middle", ink, &detail);
        }
        out.push_str("</g>\n");
    }
}

/// A line with a head wherever data goes.
fn arrow(out: &mut String, access: Access, kernel: [f32; 2], data: [f32; 2], color: &str) {
    let ([x1, y1], [x2, y2]) = (kernel, data);
    let _ = write!(
        out,
        "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\" stroke-width=\"1.5\"/>"
    );
    let mut head = |[x, y]: [f32; 2], [fx, fy]: [f32; 2]| {
        let length = (x - fx).hypot(y - fy).max(1e-6);
        let (dx, dy) = ((x - fx) / length * HEAD, (y - fy) / length * HEAD);
        let (left, right) = ([x - dx - dy * 0.4, y - dy + dx * 0.4], [x - dx + dy * 0.4, y - dy - dx * 0.4]);
        let _ = write!(
            out,
            "<polygon points=\"{x:.1},{y:.1} {:.1},{:.1} {:.1},{:.1}\" fill=\"{color}\" stroke=\"none\"/>",
            left[0], left[1], right[0], right[1]
        );
    };
    if access != Access::Write {
        head(kernel, data);
    }
    if access != Access::Read {
        head(data, kernel);
    }
}

fn text(out: &mut String, [x, y]: [f32; 2], anchor: &str, ink: &str, label: &str) {
    let _ = write!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{ink}\" stroke=\"none\">{}</text>",
        escaped(label)
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
