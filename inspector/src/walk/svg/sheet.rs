//! The sheet that a drawing is written on.

use glam::DVec2;
use svg::node::element::{Circle, ClipPath, Group, Line, Polygon, Rectangle, Style, Text, Title};
use svg::{Document, Node};

/// An SVG file under construction.
pub(super) struct Sheet {
    body: Group,
    /// Groups that are open, the innermost last.
    groups: Vec<Group>,
    style: String,
    pub(super) width: f64,
    /// Left margin; the right one has the same width.
    pub(super) left: f64,
    /// Top of the next part.
    pub(super) y: f64,
    clips: usize,
}

/// Colours of the classes: light, dark.
const COLORS: [(&str, &str, &str); 9] = [
    ("paper", "#ffffff", "#15181d"),
    ("ink", "#1d2127", "#e6e9ee"),
    ("faint", "#5c6570", "#98a2ae"),
    ("grid", "#d7dbe0", "#343a42"),
    ("ray", "#d1222f", "#ff6b5e"),
    ("hit", "#12813c", "#4fd07f"),
    ("missed", "#a04a00", "#f2994a"),
    ("current", "#1d2127", "#ffffff"),
    ("bar", "#b8bfc7", "#4a525c"),
];

impl Sheet {
    pub(super) fn new(width: f64, is_dark: bool) -> Self {
        let color =
            |name: &str| COLORS.iter().find(|c| c.0 == name).map_or("#000000", |c| if is_dark { c.2 } else { c.1 });
        let [paper, ink, faint, grid, ray, hit, missed, current, bar] =
            ["paper", "ink", "faint", "grid", "ray", "hit", "missed", "current", "bar"].map(color);
        let style = format!(
            "text{{font:11px system-ui,'Segoe UI',Helvetica,Arial,sans-serif;fill:{ink}}}\
             .title{{font-size:15px;font-weight:600}}.note{{fill:{faint}}}.small{{font-size:9px;fill:{faint}}}\
             .middle{{text-anchor:middle}}.end{{text-anchor:end}}.letter{{text-anchor:middle;font-style:italic;font-size:13px}}\
             .paper{{fill:{paper}}}.grid{{stroke:{grid};fill:none}}.frame{{stroke:{faint};fill:none}}\
             .ray{{stroke:{ray};stroke-width:1.8;fill:none}}.rest{{stroke:{ray};stroke-width:1.2;stroke-dasharray:3 4;fill:none}}\
             .cross{{fill:{paper};stroke:{ray};stroke-width:1.3}}.at{{fill:{ray}}}\
             .cell{{fill-opacity:.42;stroke-opacity:.9}}.current{{stroke:{current};stroke-width:2;fill:none}}\
             .hit{{stroke:{hit};fill:{hit};fill-opacity:.18}}.farther{{stroke:{hit};fill:none;stroke-dasharray:2 2}}\
             .missed{{stroke:{missed};fill:{missed};fill-opacity:.08;stroke-opacity:.75}}\
             .dot-hit{{fill:{hit}}}.dot-farther{{fill:{paper};stroke:{hit};stroke-width:1.5}}.dot-missed{{fill:{missed}}}\
             .bar{{fill:{bar}}}.bar-exit,.least{{fill:{ray}}}\
             .leap{{stroke:{faint};stroke-dasharray:3 3;fill:none}}.wrap{{stroke:{missed};stroke-dasharray:1 3;fill:none}}"
        );
        Self { body: Group::new(), groups: Vec::new(), style, width, left: 24.0, y: 16.0, clips: 0 }
    }

    /// Adds an element to the innermost open group.
    fn add(&mut self, element: impl Into<Box<dyn Node>>) {
        self.groups.last_mut().unwrap_or(&mut self.body).append(element);
    }

    pub(super) fn text(&mut self, x: f64, y: f64, class: &str, text: &str) {
        self.add(Text::new(printable(text)).set("x", n(x)).set("y", n(y)).set("class", class));
    }

    pub(super) fn line(&mut self, from: DVec2, to: DVec2, class: &str) {
        let line = Line::new().set("x1", n(from.x)).set("y1", n(from.y)).set("x2", n(to.x)).set("y2", n(to.y));
        self.add(line.set("class", class));
    }

    /// `more` are attributes beside those of the class.
    pub(super) fn rect(&mut self, min: DVec2, size: DVec2, class: &str, more: &[(&str, &str)]) {
        let rect = rectangle(min, size).set("class", class);
        self.add(more.iter().fold(rect, |rect, &(name, value)| rect.set(name, value)));
    }

    pub(super) fn circle(&mut self, at: DVec2, radius: f64, class: &str, title: &str) {
        let circle = Circle::new().set("cx", n(at.x)).set("cy", n(at.y)).set("r", n(radius));
        self.add(circle.set("class", class).add(Title::new(printable(title))));
    }

    pub(super) fn polygon(&mut self, points: &[DVec2], class: &str, title: &str) {
        let list: Vec<String> = points.iter().map(|p| format!("{},{}", n(p.x), n(p.y))).collect();
        let polygon = Polygon::new().set("points", list.join(" "));
        self.add(polygon.set("class", class).add(Title::new(printable(title))));
    }

    /// Clips everything drawn until [`unclip`](Self::unclip) to a rectangle.
    pub(super) fn clip(&mut self, min: DVec2, size: DVec2) {
        self.clips += 1;
        let id = format!("clip{}", self.clips);
        self.add(ClipPath::new().set("id", id.as_str()).add(rectangle(min, size)));
        self.groups.push(Group::new().set("clip-path", format!("url(#{id})")));
    }

    pub(super) fn unclip(&mut self) {
        if let Some(group) = self.groups.pop() {
            self.add(group);
        }
    }

    pub(super) fn finish(mut self) -> String {
        while !self.groups.is_empty() {
            self.unclip();
        }
        let [w, h] = [self.width, self.y + 12.0].map(n);
        let document = Document::new()
            .set("width", w)
            .set("height", h)
            .set("viewBox", format!("0 0 {w} {h}"))
            .add(Style::new(self.style))
            .add(Rectangle::new().set("width", w).set("height", h).set("class", "paper"))
            .add(self.body);
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{document}\n")
    }
}

fn rectangle(min: DVec2, size: DVec2) -> Rectangle {
    let [x, y, w, h] = [min.x, min.y, size.x.max(0.0), size.y.max(0.0)].map(n);
    Rectangle::new().set("x", x).set("y", y).set("width", w).set("height", h)
}

/// A number with the precision that a drawing needs.
fn n(value: f64) -> f64 {
    // No drawing is that large; SVG has no infinities or NaN.
    let value = if value.is_finite() { value.clamp(-1e6, 1e6) } else { 0.0 };
    (value * 100.0).round() / 100.0
}

/// XML does not allow control characters.
fn printable(text: &str) -> String {
    text.replace(char::is_control, " ")
}

/// Four significant digits.
pub(in crate::walk) fn short(t: f64) -> String {
    // No minus before a zero.
    let t = t + 0.0;
    let size = t.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{t:.2e}");
    }
    let digits = if size >= 1000.0 {
        0
    } else if size >= 100.0 {
        1
    } else if size >= 10.0 {
        2
    } else {
        3
    };
    format!("{t:.digits$}")
}

/// A viridis colour, from the first to the last of a walk.
pub(super) fn viridis(i: usize, count: usize) -> String {
    let at = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.5 };
    let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(0.15 + 0.85 * at);
    format!("#{r:02x}{g:02x}{b:02x}")
}
