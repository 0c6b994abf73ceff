//! What all plots consist of: heading, axes, lines and marks.

use super::axis::Ranged;
use super::font::{self, wrapped};
use super::frame::Frame;
use super::picture::{BLACK, Color, Dashes, Form, GRID, LINE, Picture, Point, SIZE, Side, THICK};
use super::{Dash, Mark, Series, Stroke};

/// Okabe and Ito's palette, distinguishable with colour vision deficiency.
pub(super) const PALETTE: [Color; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [150, 130, 20], [0, 0, 0]];

pub(super) fn color(index: usize) -> Color {
    PALETTE[index % PALETTE.len()]
}

/// Between a picture's edge and what is drawn.
pub(super) const MARGIN: f64 = 8.0;

/// Size of headings, which only screens have: on paper the caption says it.
const HEADING: f64 = 15.0;

/// The heading, on screens; returns where it ends.
pub(super) fn heading(picture: &mut Picture, title: &str) -> f64 {
    let mut y = 4.0;
    if picture.is_screen() {
        for line in wrapped(title, HEADING, picture.width() - 2.0 * MARGIN) {
            picture.sized(&line, (MARGIN, y), HEADING, [Side::Start, Side::Start]);
            y += LINE + 4.0;
        }
    }
    y
}

/// Width of the widest line.
pub(super) fn widest(lines: &[String]) -> f64 {
    lines.iter().map(|line| font::width(line, SIZE)).fold(0.0, f64::max)
}

/// The name of a vertical axis above it, at the picture's left side; returns where the plot begins.
pub(super) fn above(picture: &mut Picture, label: &str, y: f64) -> f64 {
    if label.is_empty() {
        return y + 4.0;
    }
    let lines = wrapped(label, SIZE, picture.width() - 2.0 * MARGIN);
    picture.lines(&lines, (MARGIN, y + LINE / 2.0), [Side::Start, Side::Middle]);
    y + LINE * lines.len() as f64 + 6.0
}

/// Values of a vertical axis, of which a unit is so high, with their labels, and the left side of the plot beside them.
pub(super) fn left_of(y: &Ranged, height: f64) -> (Vec<(f64, String)>, f64) {
    let is_apart =
        |ticks: &[(f64, String)]| ticks.windows(2).all(|pair| height * (y.part(pair[1].0) - y.part(pair[0].0)) >= SIZE);
    let ticks = y.ticks(is_apart);
    let labels: Vec<String> = ticks.iter().map(|tick| tick.1.clone()).collect();
    (ticks, MARGIN + widest(&labels) + 6.0)
}

/// A value's height.
pub(super) fn up(frame: Frame, y: &Ranged, value: f64) -> f64 {
    frame.bottom - (frame.bottom - frame.top) * y.part(value)
}

/// A value's place across.
pub(super) fn across(frame: Frame, x: &Ranged, value: f64) -> f64 {
    frame.left + (frame.right - frame.left) * x.part(value)
}

/// Lines behind the data at values of the vertical axis, and their labels.
pub(super) fn beside(picture: &mut Picture, frame: Frame, y: &Ranged, ticks: &[(f64, String)]) {
    for (value, text) in ticks {
        let at = up(frame, y, *value);
        picture.thin(GRID, (frame.left, at), (frame.right, at));
        picture.text(text, (frame.left - 6.0, at), [Side::End, Side::Middle]);
    }
}

/// The values of a horizontal axis that have labels: as many as do not touch.
pub(super) fn columns(picture: &Picture, frame: Frame, x: &Ranged) -> Vec<(f64, String)> {
    const APART: f64 = 8.0;
    let reach = |(value, text): &(f64, String)| {
        let (at, half) = (across(frame, x, *value), font::width(text, SIZE) / 2.0);
        [at - half, at + half]
    };
    let is_free = |ticks: &[(f64, String)]| {
        let is_inside = |[low, high]: [f64; 2]| low > 1.0 && high < picture.width() - 1.0;
        ticks.iter().all(|tick| is_inside(reach(tick)))
            && ticks.windows(2).all(|pair| reach(&pair[0])[1] + APART <= reach(&pair[1])[0])
    };
    x.ticks(is_free)
}

/// Lines behind the data at values of the horizontal axis.
pub(super) fn upright(picture: &mut Picture, frame: Frame, x: &Ranged, ticks: &[(f64, String)]) {
    for (value, _) in ticks {
        let at = across(frame, x, *value);
        picture.thin(GRID, (at, frame.top), (at, frame.bottom));
    }
}

/// Labels of the horizontal axis and its name; returns where they end.
pub(super) fn below(picture: &mut Picture, frame: Frame, x: &Ranged, ticks: &[(f64, String)], label: &str) -> f64 {
    for (value, text) in ticks {
        picture.text(text, (across(frame, x, *value), frame.bottom + 8.0), [Side::Middle, Side::Start]);
    }
    let lines = wrapped(label, SIZE, picture.width() - 2.0 * MARGIN);
    let half = widest(&lines) / 2.0;
    let middle = ((frame.left + frame.right) / 2.0).min(picture.width() - MARGIN - half).max(MARGIN + half);
    picture.lines(&lines, (middle, frame.bottom + 24.0), [Side::Middle, Side::Start]);
    frame.bottom + 24.0 + LINE * lines.len() as f64 + 2.0
}

/// A line along points.
pub(super) fn line(picture: &mut Picture, stroke: Stroke, points: &[Point], color: Color) {
    match stroke {
        Stroke::None => {}
        Stroke::Line(dash) => picture.line(color, THICK, dash.lengths(), points),
        Stroke::Steps(dash) => {
            let corners = points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
            let corners: Vec<Point> = corners.chain(points.last().copied()).collect();
            picture.line(color, THICK, dash.lengths(), &corners);
        }
    }
}

impl Dash {
    fn lengths(self) -> Dashes {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[7.0, 4.0],
            Self::Dotted => &[1.8, 2.6],
            Self::DashDot => &[8.0, 3.0, 1.8, 3.0],
        }
    }
}

/// The points of a series, and whiskers from each along y, at their places.
pub(super) fn points(picture: &mut Picture, s: &Series, at: &[Point], whiskers: &[[Point; 2]]) {
    let color = color(s.color);
    for &[from, to] in whiskers {
        picture.thin(color, from, to);
        // Ends across the whisker.
        let (dx, dy) = if from.1 == to.1 { (0.0, 3.0) } else { (3.0, 0.0) };
        for (x, y) in [from, to] {
            picture.thin(color, (x - dx, y - dy), (x + dx, y + dy));
        }
    }
    line(picture, s.stroke, at, color);
    // Steps are many: the last point tells which curve it is.
    let marked = if matches!(s.stroke, Stroke::Steps(_)) { at.len().saturating_sub(1) } else { 0 };
    at.iter().skip(marked).for_each(|&point| draw_mark(picture, s.mark.of(s.color), false, point, color));
}

/// Half the size of a mark.
pub(super) const HALF_MARK: f64 = 5.0;

/// Radius of a ring around a mark: no larger than a line of text is high.
pub(super) const RING: f64 = 7.0;

/// A ring around a mark.
pub(super) fn ring(picture: &mut Picture, center: Point) {
    picture.add(BLACK, 1.0, Form::Circle { center, radius: RING, outline: Some(1.2) });
}

pub(super) fn draw_mark(picture: &mut Picture, mark: Mark, is_hollow: bool, (x, y): Point, color: Color) {
    let outline = is_hollow.then_some(1.5);
    let at = |(dx, dy): (f64, f64)| (x + dx, y + dy);
    let mut polygon = |corners: &[Point]| {
        let points = corners.iter().copied().map(at).collect();
        picture.add(color, 1.0, Form::Polygon { points, outline });
    };
    match mark {
        Mark::None | Mark::Own => {}
        Mark::Dot => picture.add(color, 1.0, Form::Circle { center: (x, y), radius: 4.0, outline }),
        Mark::Square => polygon(&[(-3.7, -3.7), (3.7, -3.7), (3.7, 3.7), (-3.7, 3.7)]),
        Mark::Triangle => polygon(&[(0.0, -5.0), (5.0, 4.0), (-5.0, 4.0)]),
        Mark::Down => polygon(&[(0.0, 5.0), (5.0, -4.0), (-5.0, -4.0)]),
        Mark::Diamond => polygon(&[(0.0, -5.0), (5.0, 0.0), (0.0, 5.0), (-5.0, 0.0)]),
        Mark::Cross | Mark::Plus => {
            let arms: [[Point; 2]; 2] = match mark {
                Mark::Cross => [[(-3.7, -3.7), (3.7, 3.7)], [(-3.7, 3.7), (3.7, -3.7)]],
                _ => [[(-5.0, 0.0), (5.0, 0.0)], [(0.0, -5.0), (0.0, 5.0)]],
            };
            arms.iter().for_each(|arm| picture.line(color, THICK, &[], &arm.map(at)));
        }
    }
}

impl Mark {
    /// What is drawn in a colour.
    pub(super) fn of(self, color: usize) -> Self {
        // A mark for each colour, as colours are alike in greyscale.
        const OWN: [Mark; 7] = [Mark::Dot, Mark::Square, Mark::Diamond, Mark::Down, Mark::Cross, Mark::Plus, Mark::Dot];
        if self == Self::Own { OWN[color % OWN.len()] } else { self }
    }
}
