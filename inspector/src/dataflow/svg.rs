//! The graph as SVG 1.1. Arrowheads are drawn, as not every viewer knows markers.

use raystep_kernels::Kernel;
use raystep_lab::text::counted;
use svg::node::element::{Group, Line, Polygon, Rectangle, Text, Title};
use svg::{Document, Node as _};

use super::{Access, DataFlow, Edge, Node, NodeKind};

/// Points below the graph, for the legend.
const LEGEND: f32 = 34.0;
/// Length of an arrowhead, points.
const HEAD: f32 = 8.0;

/// Of edges that are not the current kernel's. No opacity: not every viewer knows it.
const FADED: &str = "#dcdcdc";

/// Blue, orange, purple, green: apart for every kind of colour vision, and by their arrowheads without any.
fn color(access: Access) -> &'static str {
    match access {
        Access::Read => "#2a6fbb",
        Access::Write => "#c8621b",
        Access::Update => "#7a3b9a",
        Access::Redraw => "#147a5a",
    }
}

impl DataFlow {
    /// The graph as an SVG file. What `current` does not bind is faded; `rays` is what each kernel worked on, where
    /// that is known.
    #[must_use]
    pub fn svg(&self, current: Option<Kernel>, rays: &[(Kernel, u64)]) -> String {
        let [width, height] = self.size;
        let mut out = Document::new()
            .set("width", width)
            .set("height", height + LEGEND)
            .set("viewBox", format!("0 0 {width} {}", height + LEGEND))
            .set("font-family", "sans-serif")
            .set("font-size", 12)
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#ffffff"));
        // What is faded lies below.
        let is_faded = |edge: &&Edge| current.is_some_and(|k| self.nodes[edge.kernel].kind != NodeKind::Kernel(k));
        for edge in self.edges.iter().filter(|e| is_faded(e)) {
            out.append(self.edge(edge, FADED));
        }
        for edge in self.edges.iter().filter(|e| !is_faded(e)) {
            out.append(self.edge(edge, color(edge.access)));
        }
        for node in &self.nodes {
            out.append(self.node(node, current, rays));
        }
        let mut x = 16.0;
        let y = height + LEGEND / 2.0 - 4.0;
        for access in self.accesses() {
            let [kernel, data] = [[x, y], [x + 40.0, y]];
            out.append(arrow(Group::new(), access, kernel, data, color(access)));
            let name = format!("kernel {}", access.verb());
            out.append(text([x + 48.0, y + 4.0], "start", "#222222", &name));
            x += 190.0;
        }
        format!("{out}\n")
    }

    fn points(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [x * self.size[0], y * self.size[1]]
    }

    fn edge(&self, edge: &Edge, color: &str) -> Group {
        let (kernel, data) = (&self.nodes[edge.kernel].label, &self.nodes[edge.data].label);
        let group = Group::new().add(Title::new(format!("{kernel}: {} {data}", edge.access.verb())));
        arrow(group, edge.access, self.points(edge.at_kernel), self.points(edge.at_data), color)
    }

    fn node(&self, node: &Node, current: Option<Kernel>, rays: &[(Kernel, u64)]) -> Group {
        let (min, max) = (self.points(node.min), self.points(node.max));
        let [width, height] = [max[0] - min[0], max[1] - min[1]];
        let is_current = current.is_some_and(|k| node.kind == NodeKind::Kernel(k));
        let (fill, ink, corner) = match node.kind {
            NodeKind::Kernel(_) => ("#ffe7bd", "#2b2000", 6.0),
            NodeKind::Stream(_) => ("#dcefe6", "#12352a", height / 2.0),
            NodeKind::Buffer(_) => ("#ececec", "#222222", 0.0),
        };
        let (stroke, stroke_width) = if is_current { ("#b00020", 4) } else { ("#888888", 1) };
        let detail = match node.kind {
            NodeKind::Kernel(kernel) => {
                let found = rays.iter().find(|(k, _)| *k == kernel);
                found.map(|(_, n)| counted(*n, "ray")).unwrap_or_default()
            }
            _ => node.detail.clone(),
        };
        let rectangle = Rectangle::new()
            .set("x", n(min[0]))
            .set("y", n(min[1]))
            .set("width", n(width))
            .set("height", n(height))
            .set("rx", corner)
            .set("fill", fill)
            .set("stroke", stroke)
            .set("stroke-width", stroke_width);
        let title = Title::new(format!("{}: {}", node.label, node.about));
        let middle = (min[0] + max[0]) / 2.0;
        let first = if detail.is_empty() { 24.0 } else { 17.0 };
        let group = Group::new().add(title).add(rectangle);
        let group = group.add(text([middle, min[1] + first], "middle", ink, &node.label));
        if detail.is_empty() { group } else { group.add(text([middle, min[1] + 32.0], "middle", ink, &detail)) }
    }
}

/// Adds a line with a head wherever data goes.
fn arrow(mut group: Group, access: Access, kernel: [f32; 2], data: [f32; 2], color: &str) -> Group {
    let ([x1, y1], [x2, y2]) = (kernel.map(n), data.map(n));
    let line = Line::new().set("x1", x1).set("y1", y1).set("x2", x2).set("y2", y2);
    group.append(line.set("stroke", color).set("stroke-width", 1.5));
    let mut head = |[x, y]: [f32; 2], [fx, fy]: [f32; 2]| {
        let length = (x - fx).hypot(y - fy).max(1e-6);
        let (dx, dy) = ((x - fx) / length * HEAD, (y - fy) / length * HEAD);
        let (left, right) = ([x - dx - dy * 0.4, y - dy + dx * 0.4], [x - dx + dy * 0.4, y - dy - dx * 0.4]);
        let points = [[x, y], left, right].map(|p| format!("{},{}", n(p[0]), n(p[1])));
        group.append(Polygon::new().set("points", points.join(" ")).set("fill", color));
    };
    if access != Access::Write {
        head(kernel, data);
    }
    if access != Access::Read {
        head(data, kernel);
    }
    group
}

fn text([x, y]: [f32; 2], anchor: &str, ink: &str, label: &str) -> Text {
    Text::new(label).set("x", n(x)).set("y", n(y)).set("text-anchor", anchor).set("fill", ink)
}

/// A tenth of a point is precise enough.
fn n(value: f32) -> f32 {
    (value * 10.0).round() / 10.0
}
