//! Kernels, with the streams and buffers that they read and write; the last pass is highlighted.
//!
//! Touches: asks.

mod paint;

use egui::{Color32, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, vec2};
use raystep_kernels::{Kernel, Plan};
use raystep_lab::text::counted;

use super::legend::{Entry, line};
use crate::command::Command;
use crate::dataflow::{DataFlow, NodeKind};
use crate::session::Model;
use crate::ui::host::FileToSave;
use crate::ui::pane::{Context, Panel};
use crate::ui::svg::{self, Titles};
use paint::{LEAST, Paint, access_color};

/// Distance in points within which the cursor selects an edge.
const TOUCH: f32 = 5.0;

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct Dataflow {
    flow: Option<(u64, DataFlow)>,
    /// Screen points per graph point, along x and y; `None` fits the graph into the panel.
    scale: Option<Vec2>,
    /// The graph's point in the middle of the panel.
    center: Vec2,
    /// What is to be in view if the whole graph does not fit, in fractions of its size.
    middle: [f32; 2],
    /// Whether a part of the graph is out of view.
    is_cropped: bool,
}

/// The item under the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Touched {
    /// By its index.
    Node(usize),
    /// By its index.
    Edge(usize),
}

impl Panel for Dataflow {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("Open a scene to see its kernels and streams.");
            return;
        };
        let plan = opened.plan.clone();
        if self.flow.as_ref().is_none_or(|(of, _)| *of != cx.model.generation) {
            self.flow = Some((cx.model.generation, DataFlow::new(&plan)));
        }
        self.tools(ui, cx);
        let (rect, response) =
            ui.allocate_exact_size(ui.available_size().max(vec2(40.0, 40.0)), Sense::click_and_drag());
        let Some((_, flow)) = &self.flow else { return };
        let size = Vec2::from(flow.size);
        let (last, next) = (cx.model.last_pass().map(|pass| pass.kernel), cx.model.next);
        let rays = waiting(&plan, cx.model);
        self.middle = last
            .and_then(|last| flow.nodes.iter().find(|node| node.kind == NodeKind::Kernel(last)))
            .map_or([0.5; 2], |node| [0, 1].map(|axis| 0.5 * (node.min[axis] + node.max[axis])));
        let (scale, origin) = self.placement(rect, size);
        let place = |[x, y]: [f32; 2]| origin + vec2(x, y) * size * scale;
        let touched = response.hover_pos().and_then(|at| touched(flow, at, &place));
        self.is_cropped = !rect.expand(1.0).contains_rect(Rect::from_min_size(origin, size * scale));
        Paint { ui, rect, flow, place: &place, last, next, rays: &rays, touched }.all();
        let text = format!(
            "{}, {}; last {}, next {}",
            counted(plan.variants.len(), "kernel"),
            counted(flow.edges.len(), "binding"),
            last.map_or("none", Kernel::name),
            next.map_or("none", Kernel::name)
        );
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        if let Some(touched) = touched {
            let text = about(flow, touched, &rays);
            response.clone().on_hover_text_at_pointer(text);
        }
        self.move_view(ui, &response, rect, size);
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if command != Command::ExportDataflow {
            return false;
        }
        let Some(opened) = &cx.model.opened else { return false };
        let (last, rays) = (cx.model.last_pass().map(|pass| pass.kernel), waiting(&opened.plan, cx.model));
        let bytes = drawing(&DataFlow::new(&opened.plan), last, &rays).into_bytes();
        cx.asks.files.push(FileToSave { name: "data-flow.svg".into(), bytes, holds: "a drawing".into() });
        true
    }
}

/// The graph as an SVG drawing, with what each kernel worked on.
fn drawing(flow: &DataFlow, last: Option<Kernel>, rays: &[(Kernel, u64)]) -> String {
    svg::drawing(flow.size[0] + 24.0, false, |ui, titles| {
        let (rect, _) = ui.allocate_exact_size(Vec2::from(flow.size), Sense::hover());
        let place = |[x, y]: [f32; 2]| rect.min + vec2(x, y) * rect.size();
        Paint { ui, rect, flow, place: &place, last, next: None, rays, touched: None }.all();
        add_titles(titles, ui.painter(), flow, &place);
        ui.horizontal(|ui| legend(ui, flow));
    })
}

/// What edges and nodes are, for a viewer of the drawing.
fn add_titles(titles: &Titles, painter: &Painter, flow: &DataFlow, place: &dyn Fn([f32; 2]) -> Pos2) {
    for edge in &flow.edges {
        let [kernel, data] = [edge.kernel, edge.data].map(|node| &flow.nodes[node].label);
        let stroke = Stroke::new(2.0 * TOUCH, Color32::BLACK);
        let line = Shape::line_segment([place(edge.at_kernel), place(edge.at_data)], stroke);
        titles.add(painter, line, format!("{kernel}: {} {data}", edge.access.verb()));
    }
    for node in &flow.nodes {
        let rect = Rect::from_two_pos(place(node.min), place(node.max));
        titles.add(painter, Shape::rect_filled(rect, 0.0, Color32::BLACK), format!("{}: {}", node.label, node.about));
    }
}

/// The colours of edges.
fn legend(ui: &mut Ui, flow: &DataFlow) {
    let entry = |access| {
        let stroke = Stroke::new(2.5, access_color(access, ui));
        Entry::painted(access.verb(), "", move |painter, rect| {
            painter.hline(rect.x_range(), rect.center().y, stroke);
        })
    };
    let entries: Vec<_> = flow.accesses().map(entry).collect();
    line(ui, &entries);
}

impl Dataflow {
    fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.horizontal_wrapped(|ui| {
            if let Some((_, flow)) = &self.flow {
                legend(ui, flow);
            }
            let zoom = self.scale.map_or_else(|| "fit".into(), |scale| format!("{:.0}%", scale.min_elem() * 100.0));
            if ui.button(zoom).on_hover_text("fit to panel (double click)").clicked() {
                self.scale = None;
            }
            if self.is_cropped {
                ui.weak("drag to pan");
            }
            if ui.button("SVG…").on_hover_text("save as SVG").clicked() {
                cx.asks.commands.push(Command::ExportDataflow);
            }
        });
    }

    fn placement(&self, rect: Rect, size: Vec2) -> (Vec2, Pos2) {
        placement(rect, size, self.scale, self.center, Vec2::from(self.middle) * size)
    }

    fn move_view(&mut self, ui: &Ui, response: &egui::Response, rect: Rect, size: Vec2) {
        let (scale, origin) = self.placement(rect, size);
        let zoom = match response.hovered() {
            true => ui.input(|input| input.zoom_delta() * (input.smooth_scroll_delta().y / 200.0).exp()),
            false => 1.0,
        };
        if response.double_clicked() {
            self.scale = None;
        } else if zoom != 1.0
            && let Some(at) = response.hover_pos()
        {
            let under = (at - origin) / scale;
            let scale = (scale * zoom).clamp(Vec2::splat(0.05), Vec2::splat(8.0));
            (self.scale, self.center) = (Some(scale), under + (rect.center() - at) / scale);
        } else if response.dragged() && response.drag_delta() != Vec2::ZERO {
            (self.scale, self.center) = (Some(scale), (rect.center() - origin - response.drag_delta()) / scale);
        }
    }
}

/// Screen points per graph point, and the position of its corner. Panels are often wide and low: the graph is then
/// stretched horizontally. Where it is too large for names to be read, a part of it is shown, with `middle` in view.
fn placement(rect: Rect, size: Vec2, scale: Option<Vec2>, center: Vec2, middle: Vec2) -> (Vec2, Pos2) {
    match scale {
        Some(scale) => (scale, rect.center() - center * scale),
        None => {
            let scale = (rect.size() / size).clamp(Vec2::splat(0.05), Vec2::splat(1.6));
            // Stretched by a factor of two at most.
            let scale = scale.min(Vec2::splat(2.0 * scale.min_elem())).max(LEAST);
            let inside = |axis: usize| {
                let (whole, room) = (scale[axis] * size[axis], rect.size()[axis]);
                if whole <= room {
                    return 0.5 * (room - whole);
                }
                (0.5 * room - middle[axis] * scale[axis]).clamp(room - whole, 0.0)
            };
            (scale, rect.min + vec2(inside(0), inside(1)))
        }
    }
}

/// Rays waiting for each kernel.
fn waiting(plan: &Plan, model: &Model) -> Vec<(Kernel, u64)> {
    let kernels = plan.variants.iter().map(|variant| variant.kernel);
    match model.last_pass() {
        Some(pass) => kernels.map(|kernel| (kernel, u64::from(kernel.live(&pass.counts)))).collect(),
        // Before the first pass all rays wait for the first kernel.
        None => kernels.map(|kernel| (kernel, if model.next == Some(kernel) { plan.rays } else { 0 })).collect(),
    }
}

/// The node or edge at a point; nodes take precedence.
fn touched(flow: &DataFlow, at: Pos2, place: &dyn Fn([f32; 2]) -> Pos2) -> Option<Touched> {
    let is_in = |node: &crate::dataflow::Node| Rect::from_two_pos(place(node.min), place(node.max)).contains(at);
    if let Some(node) = flow.nodes.iter().position(is_in) {
        return Some(Touched::Node(node));
    }
    let distances = flow.edges.iter().map(|edge| distance(at, place(edge.at_kernel), place(edge.at_data)));
    let (edge, distance) = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    (distance <= TOUCH).then_some(Touched::Edge(edge))
}

/// The distance from a point to a line segment.
fn distance(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let along = to - from;
    let part = ((at - from).dot(along) / along.length_sq().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (at - (from + part * along)).length()
}

/// Describes a node or edge.
fn about(flow: &DataFlow, touched: Touched, rays: &[(Kernel, u64)]) -> String {
    let label = |node: usize| flow.nodes[node].label.as_str();
    match touched {
        Touched::Edge(edge) => {
            let edge = &flow.edges[edge];
            format!("{} {} {}", label(edge.kernel), edge.access.verb(), label(edge.data))
        }
        Touched::Node(index) => {
            let node = &flow.nodes[index];
            let mut text = format!("{}: {}", node.label, node.about);
            if let NodeKind::Kernel(kernel) = node.kind {
                let count = rays.iter().find(|(k, _)| *k == kernel).map_or(0, |(_, count)| *count);
                text += &format!("\n{} waiting", counted(count, "ray"));
            }
            if !node.detail.is_empty() {
                text += &format!("\n{}", node.detail);
            }
            for edge in flow.edges.iter().filter(|edge| edge.kernel == index || edge.data == index) {
                text += &match edge.kernel == index {
                    true => format!("\n{} {}", edge.access.verb(), label(edge.data)),
                    false => format!("\n{} {} it", label(edge.kernel), edge.access.verb()),
                };
            }
            text
        }
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;
    use raystep_kernels::programs::closest_hit::kernels;
    use raystep_kernels::{Limits, Options, RaySource};
    use raystep_scenes::generate;

    use super::*;

    fn flow() -> DataFlow {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options::new(RaySource::Camera { camera, width: 16, height: 8 });
        DataFlow::new(&Plan::new(&scene, &options, &Limits::CPU).expect("a small scene").0)
    }

    #[test]
    fn every_node_is_found_where_it_is_and_says_what_it_is_bound_to() {
        let flow = flow();
        let place = |[x, y]: [f32; 2]| pos2(x * flow.size[0], y * flow.size[1]);
        for (i, node) in flow.nodes.iter().enumerate() {
            let middle = place(node.min) + 0.5 * (place(node.max) - place(node.min));
            assert_eq!(touched(&flow, middle, &place), Some(Touched::Node(i)));
            let lines = flow.edges.iter().filter(|e| e.kernel == i || e.data == i).count();
            let text = about(&flow, Touched::Node(i), &[]);
            assert!(text.starts_with(&node.label) && text.lines().count() > lines, "{text}");
        }
        assert_eq!(touched(&flow, pos2(-50.0, -50.0), &place), None);
    }

    #[test]
    fn the_drawing_has_every_node_and_shows_where_the_run_is() {
        let (flow, last) = (flow(), kernels::WALK);
        let rays = [(last, 4096), (kernels::SETUP, 77)];
        let text = drawing(&flow, Some(last), &rays).replace(">\n", ">").replace("\n<", "<");
        for node in &flow.nodes {
            assert!(text.contains(&format!(">{}</text>", node.label)), "{}", node.label);
            let title = format!("<title>{}: {}</title>", node.label, node.about);
            assert!(text.contains(&title), "{title}");
        }
        assert!(text.contains(">4096 rays</text>") && text.contains(">77 rays</text>"), "{text}");
        for edge in &flow.edges {
            let [kernel, data] = [edge.kernel, edge.data].map(|node| &flow.nodes[node].label);
            let title = format!("<title>{kernel}: {} {data}</title><line ", edge.access.verb());
            assert!(text.contains(&title), "{title}");
        }
        // The frame of the current kernel is twice as wide as the others.
        let framed = |text: &str| text.matches("stroke-width=\"2\"").count();
        assert_eq!((framed(&text), framed(&drawing(&flow, None, &[]))), (1, 0), "one kernel is the current one");
        // Edges of other kernels are faded.
        let lit = |text: &str| {
            let lines = text.split_once(" opacity=\"0\">").expect("titles").0.matches("<line").count();
            lines - text.matches("stroke=\"#d4d4d4\"").count()
        };
        let own = flow.of(last).count();
        let legend = flow.accesses().count();
        assert_eq!(lit(&text), own + legend);
        assert_eq!(lit(&drawing(&flow, None, &[])), flow.edges.len() + legend);
    }

    #[test]
    fn an_edge_is_found_along_its_line() {
        let flow = flow();
        let place = |[x, y]: [f32; 2]| pos2(x * flow.size[0], y * flow.size[1]);
        let edge = &flow.edges[0];
        let middle = place(edge.at_kernel) + 0.5 * (place(edge.at_data) - place(edge.at_kernel));
        let Some(Touched::Edge(found)) = touched(&flow, middle, &place) else { panic!("no edge at {middle}") };
        let found = &flow.edges[found];
        assert!(distance(middle, place(found.at_kernel), place(found.at_data)) < 1e-3);
        let (a, b) = (pos2(0.0, 0.0), pos2(10.0, 0.0));
        assert_eq!([pos2(5.0, 3.0), pos2(-4.0, 3.0), pos2(14.0, 3.0)].map(|p| distance(p, a, b)), [3.0, 5.0, 5.0]);
        assert_eq!(distance(pos2(3.0, 4.0), a, a), 5.0);
    }

    #[test]
    fn the_drawing_fits_and_keeps_its_middle() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(800.0, 300.0));
        let place = |size, scale, center, middle| placement(rect, size, scale, center, middle);
        let (scale, origin) = place(vec2(800.0, 300.0), None, Vec2::ZERO, Vec2::ZERO);
        assert_eq!((scale, origin), (vec2(1.0, 1.0), rect.min));
        // Stretched.
        let (scale, origin) = place(vec2(500.0, 600.0), None, Vec2::ZERO, Vec2::ZERO);
        assert_eq!((scale, origin), (vec2(1.0, 0.5), pos2(160.0, 20.0)));
        // Too large: from one end to the other.
        let large = vec2(1600.0, 300.0);
        let ends = [0.0, 800.0, 1600.0].map(|x| place(large, None, Vec2::ZERO, vec2(x, 0.0)));
        let room = rect.width() - ends[0].0.x * large.x;
        assert!(ends.iter().all(|(scale, _)| scale.x == LEAST.x), "{ends:?}");
        assert_eq!(ends.map(|(_, origin)| origin.x - rect.left()), [0.0, 0.5 * room, room]);
        let (scale, origin) = place(vec2(800.0, 300.0), Some(vec2(2.0, 1.0)), vec2(50.0, 60.0), Vec2::ZERO);
        assert_eq!(origin + vec2(50.0, 60.0) * scale, rect.center());
    }
}
