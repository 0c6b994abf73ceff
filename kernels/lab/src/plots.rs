//! Plots, as SVG and PDF files for pages and papers, or as [pictures](picture) for a window.
//!
//! Every plot is laid out for the width that it is shown at: on a screen, or in one or two columns of a paper. Texts are
//! measured with the metrics of their [font], so that none covers another, a mark or an axis. Colours are few, and a
//! page's style sheet replaces them in dark mode; marks and dashes tell series apart without them.

mod axis;
mod bars;
mod draw;
pub mod font;
mod forest;
mod frame;
mod labels;
mod legend;
mod lines;
mod pdf;
pub mod picture;
pub mod precision;
mod svg;

pub use axis::{Axis, Scale};
pub use bars::{Bars, Part};
use draw::PALETTE;
pub use forest::Forest;
pub use frame::Frame;
pub use lines::{Panel, Plot};
use picture::{BLACK, Color, GRID, Picture, WHITE};
use raystep_kernels::named;

/// Where a plot is shown: its width, and the size of its texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// On a screen.
    Screen,
    /// One column of a paper: 84 mm.
    OneColumn,
    /// Two columns of a paper: 178 mm.
    TwoColumns,
}

/// Points (1/72 inch) of a unit on paper: texts of 12 units have 7.4 points.
const PAPER: f64 = 0.62;
/// Points of a pixel of a page.
const SCREEN: f64 = 0.75;

named!(Format, Screen "screen", OneColumn "one-column", TwoColumns "two-columns");

impl Format {
    /// Those for papers.
    pub const PAPER: [Self; 2] = [Self::OneColumn, Self::TwoColumns];

    /// Width in units, of a plot that is so wide on a screen.
    fn width(self, screen: f64) -> f64 {
        const POINTS_OF_MM: f64 = 72.0 / 25.4;
        match self {
            Self::Screen => screen,
            Self::OneColumn => 84.0 * POINTS_OF_MM / PAPER,
            Self::TwoColumns => 178.0 * POINTS_OF_MM / PAPER,
        }
    }

    /// Points of a unit.
    fn point(self) -> f64 {
        if self == Self::Screen { SCREEN } else { PAPER }
    }
}

/// What can be drawn.
pub trait Draw: std::fmt::Debug {
    /// The heading, and the title of files.
    fn title(&self) -> &str;

    /// The picture for a width; `None` if there is nothing to show.
    fn picture(&self, format: Format) -> Option<Picture>;

    /// As an element of an HTML page: no namespace, one image to screen readers.
    fn inline(&self) -> Option<String> {
        let svg = self.picture(Format::Screen)?.svg();
        Some(svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", " role=\"img\"", 1))
    }

    /// The files for papers, PDF and SVG of each width: `STEM-one-column.pdf` and so on.
    fn files(&self, stem: &str) -> Vec<(String, Vec<u8>)> {
        let pictures = Format::PAPER.into_iter().filter_map(|format| Some((format, self.picture(format)?)));
        let of_format = |(format, picture): (Format, Picture)| {
            let stem = format!("{stem}-{}", format.name());
            [(format!("{stem}.pdf"), picture.pdf(self.title())), (format!("{stem}.svg"), picture.svg().into_bytes())]
        };
        pictures.flat_map(of_format).collect()
    }
}

/// How points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// No mark.
    None,
    /// The mark of the colour: each has its own, as colours are alike in greyscale. None is a triangle that points up.
    Own,
    /// Discs.
    Dot,
    /// Squares.
    Square,
    /// Triangles that point up.
    Triangle,
    /// Triangles that point down.
    Down,
    /// Squares on a corner.
    Diamond,
    /// Crosses of diagonal lines.
    Cross,
    /// Crosses of upright lines.
    Plus,
}

/// How points are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Not at all.
    None,
    /// From point to point.
    Line(Dash),
    /// Each value holds until the next; only the last point has a mark.
    Steps(Dash),
}

/// The pattern of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dashes and dots in turn.
    DashDot,
}

/// A data series.
#[derive(Clone, Debug)]
pub struct Series {
    /// Label in the legend. Series with the same name share an entry; an empty name has none.
    pub name: String,
    /// x and y of each point.
    pub points: Vec<(f64, f64)>,
    /// Lower and upper end along y, one per point; or empty.
    pub whiskers: Vec<(f64, f64)>,
    /// Index into the palette.
    pub color: usize,
    /// How points are drawn.
    pub mark: Mark,
    /// How they are connected.
    pub stroke: Stroke,
}

impl Series {
    /// A line with a mark at each point.
    pub fn line(name: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        let name = name.into();
        Self { name, points, whiskers: Vec::new(), color, mark: Mark::Own, stroke: Stroke::Line(Dash::Solid) }
    }

    /// A theoretical line: dashed, without marks.
    pub fn dashed(name: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::None, stroke: Stroke::Line(Dash::Dashed), ..Self::line(name, color, points) }
    }
}

/// Colours on a dark background: lighter ones of the same hue as those of the palette.
const DARK: [Color; 7] = [
    [0x4a, 0xa8, 0xe0],
    [0xff, 0x8a, 0x3d],
    [0x2f, 0xc7, 0x9a],
    [0xe5, 0x9c, 0xc4],
    [0x8f, 0xd0, 0xf5],
    [0xd0, 0xb8, 0x4a],
    [0xdd, 0xdd, 0xdd],
];

/// What a colour of a plot stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// The background.
    Paper,
    /// Lines behind the data.
    Rule,
    /// Text, axes and frames.
    Text,
    /// Data: the colours on a light and on a dark background.
    Data([Color; 2]),
}

impl Ink {
    /// What the colour of an [element](picture::Element) stands for.
    #[must_use]
    pub fn of(color: Color) -> Self {
        match color {
            WHITE => Self::Paper,
            GRID => Self::Rule,
            BLACK => Self::Text,
            data => {
                let at = PALETTE.iter().position(|known| *known == data);
                Self::Data([data, at.map_or(data, |at| DARK[at])])
            }
        }
    }
}

/// The style sheet of a page with plots. Plots are drawn for light mode; in dark mode their colours are replaced, those
/// of lines by lighter ones of the same hue.
#[must_use]
pub fn style() -> String {
    let mut style = String::from(
        "figure svg{max-width:100%;height:auto}@media(prefers-color-scheme:dark){svg [fill=\"#FFFFFF\"]{fill:\
         var(--paper)}svg [stroke=\"#E6E6E6\"]{stroke:var(--rule)}",
    );
    for (light, [red, green, blue]) in PALETTE.iter().zip(DARK) {
        let [r, g, b] = light;
        let light = format!("#{r:02X}{g:02X}{b:02X}");
        let dark = format!("#{red:02x}{green:02x}{blue:02x}");
        style += &format!("svg [fill=\"{light}\"]{{fill:{dark}}}svg [stroke=\"{light}\"]{{stroke:{dark}}}");
    }
    style + "}"
}

#[cfg(test)]
mod tests;
