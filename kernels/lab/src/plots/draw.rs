//! Elements of plots: text, frame, legend, lines and marks.

use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color as _, FontTransform, IntoFont as _, IntoTextStyle as _, RGBColor, ShapeStyle};

use super::picture::{Area, Picture};
use super::{Mark, Series, Stroke};
use crate::Error;

/// Okabe and Ito's palette, distinguishable with colour vision deficiency.
pub(super) const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(150, 130, 20),
    RGBColor(0, 0, 0),
];

/// Colour of grid lines behind the data.
pub(super) const GRID: RGBColor = RGBColor(230, 230, 230);

/// A rectangle of the image, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
}

pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

pub(super) const SIZE: (u32, u32) = (860, 400);
pub(super) const FRAME: Frame = Frame { left: 92, right: 600, top: 40, bottom: 340 };
pub(super) const LEGEND: i32 = 622;

/// An SVG drawn by `draw`, without what only a standalone file needs.
pub(super) fn drawn(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String, Error> {
    Picture::drawn(size, draw)?.svg()
}

pub(super) fn text_at(area: &Area<'_>, text: &str, at: (i32, i32), size: i32, (h, v): (HPos, VPos)) -> Drawn {
    let style = ("sans-serif", size).into_font().color(&BLACK).pos(Pos::new(h, v));
    area.draw(&Text::new(text.to_owned(), at, style))?;
    Ok(())
}

pub(super) fn frame(area: &Area<'_>, title: &str, x: &str, y: &str) -> Drawn {
    text_at(area, title, (FRAME.left, 14), 16, (HPos::Left, VPos::Center))?;
    text_at(area, x, ((FRAME.left + FRAME.right) / 2, FRAME.bottom + 34), 14, (HPos::Center, VPos::Top))?;
    let font = ("sans-serif", 14).into_font().transform(FontTransform::Rotate270);
    let style = font.into_text_style(area).color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
    area.draw(&Text::new(y.to_owned(), (16, (FRAME.top + FRAME.bottom) / 2), style))?;
    Ok(())
}

pub(super) fn border(area: &Area<'_>) -> Drawn {
    area.draw(&Rectangle::new([(FRAME.left, FRAME.top), (FRAME.right, FRAME.bottom)], BLACK.stroke_width(1)))?;
    Ok(())
}

pub(super) fn legend(area: &Area<'_>, series: &[Series]) -> Drawn {
    // Series with the same name share one entry.
    let mut named: Vec<&Series> = Vec::new();
    for s in series.iter().filter(|s| !s.name.is_empty()) {
        if !named.iter().any(|n| n.name == s.name) {
            named.push(s);
        }
    }
    let step = (300 / named.len().max(1) as i32).min(24);
    for (i, s) in named.iter().enumerate() {
        let (y, color) = (FRAME.top + 12 + step * i as i32, PALETTE[s.color % PALETTE.len()]);
        let line = if s.stroke == Stroke::Steps { Stroke::Solid } else { s.stroke };
        stroke(area, line, &[(LEGEND, y), (LEGEND + 28, y)], color)?;
        mark(area, s.mark, (LEGEND + 14, y), color)?;
        text_at(area, &s.name, (LEGEND + 36, y), 13, (HPos::Left, VPos::Center))?;
    }
    Ok(())
}

pub(super) fn stroke(area: &Area<'_>, stroke: Stroke, points: &[(i32, i32)], color: RGBColor) -> Drawn {
    let style = color.stroke_width(2);
    let pairs = || points.windows(2).map(|pair| [pair[0], pair[1]]);
    match stroke {
        Stroke::None => {}
        Stroke::Dashed => dashes(area, points, style)?,
        // One segment at a time: some viewers fill longer lines like shapes.
        Stroke::Solid => pairs().try_for_each(|pair| area.draw(&PathElement::new(pair, style)))?,
        Stroke::Steps => {
            for [from, to] in pairs().filter(|[from, to]| from != to) {
                let corner = (to.0, from.1);
                area.draw(&PathElement::new([from, corner], style))?;
                area.draw(&PathElement::new([corner, to], style))?;
            }
        }
    }
    Ok(())
}

/// Dashes along a line; their pattern continues across points.
pub(super) fn dashes(area: &Area<'_>, points: &[(i32, i32)], style: ShapeStyle) -> Drawn {
    const ON: f64 = 7.0;
    const PERIOD: f64 = 11.0;
    let mut walked = 0.0;
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|(x, y)| (f64::from(x), f64::from(y)));
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let at = |along: f64| {
            let share = (along / length).clamp(0.0, 1.0);
            let (x, y) = (from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share);
            (x.round() as i32, y.round() as i32)
        };
        let mut begin = -(walked % PERIOD);
        while length > 0.0 && begin < length {
            if begin + ON > 0.0 {
                area.draw(&PathElement::new([at(begin), at(begin + ON)], style))?;
            }
            begin += PERIOD;
        }
        walked += length;
    }
    Ok(())
}

pub(super) fn mark(area: &Area<'_>, mark: Mark, (x, y): (i32, i32), color: RGBColor) -> Drawn {
    let style = color.filled();
    match mark {
        Mark::None => {}
        Mark::Dot => area.draw(&Circle::new((x, y), 4, style))?,
        Mark::Triangle => area.draw(&Polygon::new([(x, y - 5), (x + 5, y + 4), (x - 5, y + 4)], style))?,
        Mark::Square => area.draw(&Rectangle::new([(x - 4, y - 4), (x + 4, y + 4)], style))?,
    }
    Ok(())
}
