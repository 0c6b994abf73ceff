//! The sheet that a drawing is written on.

use std::fmt::{Display, Write as _};

use glam::DVec2;

/// An SVG file under construction.
pub(super) struct Sheet {
    body: String,
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
    ("missed", "#c25d00", "#f2994a"),
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
             .bar{{fill:{bar}}}.bar-exit{{fill:{ray}}}"
        );
        Self { body: String::new(), style, width, left: 24.0, y: 16.0, clips: 0 }
    }

    pub(super) fn text(&mut self, x: f64, y: f64, class: &str, text: &str) {
        let _ = writeln!(self.body, "<text x=\"{}\" y=\"{}\" class=\"{class}\">{}</text>", N(x), N(y), escaped(text));
    }

    pub(super) fn line(&mut self, from: DVec2, to: DVec2, class: &str) {
        let [a, b, c, d] = [from.x, from.y, to.x, to.y].map(N);
        let _ = writeln!(self.body, "<line x1=\"{a}\" y1=\"{b}\" x2=\"{c}\" y2=\"{d}\" class=\"{class}\"/>");
    }

    /// `more` is inserted into the element verbatim: attributes, or nothing.
    pub(super) fn rect(&mut self, min: DVec2, size: DVec2, class: &str, more: &str) {
        let [x, y, w, h] = [min.x, min.y, size.x.max(0.0), size.y.max(0.0)].map(N);
        let _ = writeln!(
            self.body,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" class=\"{class}\"{}{more}/>",
            if more.is_empty() { "" } else { " " }
        );
    }

    pub(super) fn circle(&mut self, at: DVec2, radius: f64, class: &str, title: &str) {
        let [x, y, r] = [at.x, at.y, radius].map(N);
        let _ = write!(self.body, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" class=\"{class}\">");
        let _ = writeln!(self.body, "<title>{}</title></circle>", escaped(title));
    }

    pub(super) fn polygon(&mut self, points: &[DVec2], class: &str, title: &str) {
        let mut list = String::new();
        for p in points {
            let _ = write!(list, "{},{} ", N(p.x), N(p.y));
        }
        let _ = write!(self.body, "<polygon points=\"{}\" class=\"{class}\">", list.trim_end());
        let _ = writeln!(self.body, "<title>{}</title></polygon>", escaped(title));
    }

    /// Clips everything drawn until [`unclip`](Self::unclip) to a rectangle.
    pub(super) fn clip(&mut self, min: DVec2, size: DVec2) {
        self.clips += 1;
        let id = self.clips;
        let [x, y, w, h] = [min.x, min.y, size.x.max(0.0), size.y.max(0.0)].map(N);
        let _ = writeln!(
            self.body,
            "<clipPath id=\"clip{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\
             <g clip-path=\"url(#clip{id})\">"
        );
    }

    pub(super) fn unclip(&mut self) {
        self.body.push_str("</g>\n");
    }

    pub(super) fn finish(self) -> String {
        let [w, h] = [self.width, self.y + 12.0].map(N);
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" \
             height=\"{h}\" viewBox=\"0 0 {w} {h}\">\n<style>{}</style>\n<rect width=\"{w}\" height=\"{h}\" \
             class=\"paper\"/>\n{}</svg>\n",
            self.style, self.body
        )
    }
}

/// A number with the precision that a drawing needs.
struct N(f64);

impl Display for N {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // No drawing is that large; SVG has no infinities or NaN.
        let v = if self.0.is_finite() { self.0.clamp(-1e6, 1e6) } else { 0.0 };
        write!(f, "{}", (v * 100.0).round() / 100.0)
    }
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML does not allow such characters.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Four significant digits.
pub(super) fn short(t: f64) -> String {
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
