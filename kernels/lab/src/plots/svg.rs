//! A picture as SVG.

use svg::node::element::Element as Node;
use svg::{Document, Node as _};

use super::font::{self, FAMILY};
use super::picture::{Color, Dashes, Element, Form, Picture, Point, begin};

impl Picture {
    /// As an SVG file. Its texts are texts, as wide as the plot was laid out for.
    #[must_use]
    pub fn svg(&self) -> String {
        let [width, height] = [self.size.0, self.size.1].map(number);
        let [wide, high] = [self.size.0, self.size.1].map(|side| format!("{}pt", number(side * self.point)));
        let paper = node("rect", [("width", "100%"), ("height", "100%"), ("fill", "#FFFFFF")]);
        let document = Document::new()
            .set("width", wide)
            .set("height", high)
            .set("viewBox", format!("0 0 {width} {height}"))
            .set("font-family", FAMILY)
            .add(paper);
        let document = self.elements.iter().fold(document, |document, element| document.add(element.node()));
        format!("{document}\n")
    }
}

impl Element {
    fn node(&self) -> Node {
        let mut node = match &self.form {
            Form::Line { points, width, dashes } => dashed(self.outlined(path(points), Some(*width)), dashes),
            Form::Polygon { points, outline } => self.outlined(node("polygon", [("points", list(points))]), *outline),
            Form::Circle { center: (x, y), radius, outline } => {
                let circle = node("circle", [("cx", number(*x)), ("cy", number(*y)), ("r", number(*radius))]);
                self.outlined(circle, *outline)
            }
            Form::Text { text, at, size, align } => {
                let (x, y) = begin(text, *at, *size, *align);
                let mut words = node("text", [("x", number(x)), ("y", number(y)), ("font-size", number(*size))]);
                // Other fonts are wider: the text keeps its room.
                words.assign("textLength", number(font::width(text, *size)));
                words.assign("lengthAdjust", "spacingAndGlyphs");
                words.append(svg::node::Text::new(text));
                self.outlined(words, None)
            }
        };
        if self.opacity < 1.0 {
            node.assign("opacity", number(self.opacity));
        }
        node
    }

    /// In its colour: filled, or with an outline of a width.
    fn outlined(&self, mut node: Node, outline: Option<f64>) -> Node {
        let [red, green, blue]: Color = self.color;
        let color = format!("#{red:02X}{green:02X}{blue:02X}");
        match outline {
            None => node.assign("fill", color),
            Some(width) => {
                node.assign("fill", "none");
                node.assign("stroke", color);
                node.assign("stroke-width", number(width));
            }
        }
        node
    }
}

fn node<V: Into<svg::node::Value>, const N: usize>(name: &str, attributes: [(&str, V); N]) -> Node {
    let mut node = Node::new(name);
    attributes.into_iter().for_each(|(name, value)| node.assign(name, value));
    node
}

fn path(points: &[Point]) -> Node {
    match points {
        [from, to] => {
            node("line", [("x1", from.0), ("y1", from.1), ("x2", to.0), ("y2", to.1)].map(|(n, v)| (n, number(v))))
        }
        _ => node("polyline", [("points", list(points))]),
    }
}

fn dashed(mut node: Node, dashes: Dashes) -> Node {
    if !dashes.is_empty() {
        node.assign("stroke-dasharray", dashes.iter().map(f32::to_string).collect::<Vec<_>>().join(" "));
    }
    node
}

fn list(points: &[Point]) -> String {
    points.iter().map(|&(x, y)| format!("{},{}", number(x), number(y))).collect::<Vec<_>>().join(" ")
}

/// To a hundredth.
fn number(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    // Not -0.
    (rounded + 0.0).to_string()
}
