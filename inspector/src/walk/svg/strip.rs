//! The walk unfolded: cells side by side with their tmax bars above, or nodes below each other.

use glam::DVec2;

use super::super::{Entry, Outcome, Spacing, Strip, StripCell, StripTest, Ticks, WalkGeometry};
use super::sheet::{Sheet, short, viridis};

/// Heights of the tmax bars, of a cell, and of a row of nodes.
const BARS: f64 = 84.0;
const CELL: f64 = 46.0;
const LINE: f64 = 14.0;
/// Narrower columns have no numbers of tmax; the height of a line of them.
const ROOM_FOR_TMAX: f64 = 50.0;
const NUMBER: f64 = 11.0;
/// Most tests listed in words, and the width of a letter.
const MOST_TESTS: usize = 200;
const LETTER: f64 = 5.6;

pub(super) fn draw(sheet: &mut Sheet, walk: &WalkGeometry, strip: &Strip, spacing: Spacing) {
    match (strip.cells.is_empty(), strip.nodes.is_empty()) {
        (false, _) => cells(sheet, walk, strip, spacing),
        (true, false) => nodes(sheet, walk, strip),
        (true, true) => tests_alone(sheet, walk, strip),
    }
    axis(sheet, strip, spacing);
    tests_in_words(sheet, walk);
}

/// Every test with its t and why it was not accepted, in order.
fn tests_in_words(sheet: &mut Sheet, walk: &WalkGeometry) {
    let words = walk.tested.iter().take(MOST_TESTS).map(|test| {
        let t = test.t.map_or_else(String::new, |t| format!(" at t {}", short(t)));
        match test.outcome {
            Outcome::Nearest => format!("{}: hit{t}", test.triangle),
            Outcome::NotNearest => format!("{}: hit{t}, {}", test.triangle, test.why),
            Outcome::Missed => format!("{}: missed, {}", test.triangle, test.why),
        }
    });
    let most = ((sheet.width - 2.0 * sheet.left) / LETTER).max(40.0) as usize;
    let mut line = String::from("Tested, in order");
    for (i, word) in words.enumerate() {
        line += if i == 0 { ": " } else { "; " };
        if line.len() + word.len() > most {
            sheet.text(sheet.left, sheet.y + 8.0, "note", line.trim_end());
            sheet.y += 14.0;
            line.clear();
        }
        line += &word;
    }
    if walk.tested.len() > MOST_TESTS {
        line += &format!("; and {} more", walk.tested.len() - MOST_TESTS);
    }
    if !walk.tested.is_empty() {
        sheet.text(sheet.left, sheet.y + 8.0, "note", &line);
        sheet.y += 18.0;
    }
}

fn cells(sheet: &mut Sheet, walk: &WalkGeometry, strip: &Strip, spacing: Spacing) {
    let width = sheet.width - 2.0 * sheet.left;
    let note = match spacing {
        Spacing::ByT => "Unfolded: width of a cell proportional to its length along the ray",
        Spacing::Equal => "Unfolded: cells equally wide",
    };
    let bars = "above each cell its tmax along x, y and z, the smallest in red; inside it the triangles tested";
    sheet.text(sheet.left, sheet.y + 8.0, "note", &format!("{note}; {bars}"));
    let top = sheet.y + 30.0;
    let cells_top = top + BARS + 16.0;
    let columns = strip.columns(spacing);
    for (i, (cell, &[left, right])) in strip.cells.iter().zip(&columns).enumerate() {
        if let Some(next) = columns.get(i + 1).filter(|_| cell.is_left_by_a_leap()) {
            let [from, to] =
                [right, next[0]].map(|share| DVec2::new(sheet.left + share * width, cells_top + CELL * 0.5));
            leap(sheet, cell, from, to);
        }
        let (x, wide) = (sheet.left + left * width, (right - left) * width);
        let color = viridis(cell.visit, strip.cells.len());
        let bar = (wide / 4.0).min(14.0);
        let down = if wide >= ROOM_FOR_TMAX { 3.0 * NUMBER + 4.0 } else { 0.0 };
        for (axis, tmax) in cell.tmax.iter().enumerate().filter(|_| wide >= ROOM_FOR_TMAX) {
            let class = if axis == cell.exit_axis && tmax.is_some() { "small middle least" } else { "small middle" };
            let text = format!("{} {}", ["x", "y", "z"][axis], tmax.map_or_else(|| "never".into(), short));
            sheet.text(x + wide * 0.5, top + NUMBER * (axis as f64 + 0.6), class, &text);
        }
        for (axis, tmax) in cell.tmax.iter().enumerate() {
            let Some(tmax) = tmax else { continue };
            let height = (strip.tmax_height(*tmax).min(1.0) * (BARS - down)).max(1.0);
            let at = x + wide * 0.5 + (axis as f64 - 1.5) * bar;
            let class = if axis == cell.exit_axis { "bar-exit" } else { "bar" };
            sheet.rect(DVec2::new(at + 0.5, top + BARS - height), DVec2::new(bar - 1.0, height), class, &[]);
            if strip.tmax_height(*tmax) > 1.0 {
                // Truncated.
                for gap in [6.0, 10.0] {
                    sheet.rect(DVec2::new(at, top + down + gap), DVec2::new(bar, 2.0), "paper", &[]);
                }
            }
            if bar >= 8.0 {
                sheet.text(at + bar * 0.5, top + BARS + 11.0, "small middle", ["x", "y", "z"][axis]);
            }
        }
        let colors = [("fill", color.as_str()), ("stroke", color.as_str())];
        sheet.rect(DVec2::new(x, cells_top), DVec2::new(wide, CELL), "cell", &colors);
        if cell.is_current {
            sheet.rect(DVec2::new(x, cells_top), DVec2::new(wide, CELL), "current", &[]);
        }
        if wide >= 12.0 {
            sheet.text(x + wide * 0.5, cells_top + 14.0, "letter", &cell.letters);
        }
        if wide >= 44.0 {
            let [i, j, k] = cell.cell;
            sheet.text(x + wide * 0.5, cells_top + CELL + 12.0, "small middle", &format!("{i}, {j}, {k}"));
        }
        let count = cell.tests.len() as f64;
        for (i, test) in cell.tests.iter().enumerate() {
            // In test order: their t often lies outside the cell.
            let at = DVec2::new(x + wide * (i as f64 + 0.5) / count, cells_top + 31.0);
            dot(sheet, at, (wide / (2.6 * count)).clamp(0.6, 4.0), walk, test);
        }
    }
    sheet.y = cells_top + CELL + 20.0;
}

/// The way from a cell to one that is not its neighbour.
fn leap(sheet: &mut Sheet, cell: &StripCell, from: DVec2, to: DVec2) {
    let is_wrap = cell.next == Some(Entry::Wrap);
    let (class, name) = if is_wrap { ("wrap", "wrap") } else { ("leap", "leap") };
    sheet.line(from, to, class);
    for by in [-3.0, 3.0] {
        sheet.line(to, to + DVec2::new(-4.0, by), class);
    }
    if to.x - from.x >= 24.0 {
        sheet.text((from.x + to.x) * 0.5, from.y - 4.0, "small middle", name);
    }
}

fn nodes(sheet: &mut Sheet, walk: &WalkGeometry, strip: &Strip) {
    let width = sheet.width - 2.0 * sheet.left;
    let note = "Unfolded: a bar for each node, from where the ray enters its box to where it leaves, below its parent";
    let more = "Outlines: boxes not entered before the nearest hit. Dots: triangles tested";
    sheet.text(sheet.left, sheet.y + 8.0, "note", note);
    sheet.text(sheet.left, sheet.y + 23.0, "note", more);
    let top = sheet.y + 34.0;
    for node in &strip.nodes {
        let Some(t) = node.t else { continue };
        let [left, right] = t.map(|t| sheet.left + strip.place(t, Spacing::ByT) * width);
        let at = DVec2::new(left, top + node.line as f64 * LINE);
        let size = DVec2::new((right - left).max(1.0), LINE - 2.0);
        let color = viridis(node.visit, strip.nodes.len());
        let fill = if node.is_met { color.as_str() } else { "none" };
        sheet.rect(at, size, "cell", &[("fill", fill), ("stroke", color.as_str())]);
        if node.is_current {
            sheet.rect(at, size, "current", &[]);
        }
        let names = [format!("{}: {} to {}", node.node, short(t[0]), short(t[1])), node.node.to_string()];
        if let Some(name) = names.into_iter().find(|name| size.x > LETTER * name.len() as f64 + 14.0) {
            // Beside the dots, which lie where the ray enters as often as not.
            let (x, class) = if node.tests.is_empty() { (left + 4.0, "small") } else { (right - 4.0, "small end") };
            sheet.text(x, at.y + 9.5, class, &name);
        }
        for test in &node.tests {
            if let Some(t) = test.t.filter(|t| (strip.t[0]..=strip.t[1]).contains(t)) {
                let x = sheet.left + strip.place(t, Spacing::ByT) * width;
                dot(sheet, DVec2::new(x, at.y + size.y * 0.5), 3.0, walk, test);
            }
        }
    }
    sheet.y = top + strip.lines() as f64 * LINE + 6.0;
}

fn tests_alone(sheet: &mut Sheet, walk: &WalkGeometry, strip: &Strip) {
    let width = sheet.width - 2.0 * sheet.left;
    sheet.text(sheet.left, sheet.y + 8.0, "note", "Unfolded: where the ray meets the planes of the triangles tested");
    let middle = sheet.y + 34.0;
    sheet.line(DVec2::new(sheet.left, middle), DVec2::new(sheet.left + width, middle), "grid");
    for test in &strip.tests {
        if let Some(t) = test.t.filter(|t| (strip.t[0]..=strip.t[1]).contains(t)) {
            let x = sheet.left + strip.place(t, Spacing::ByT) * width;
            dot(sheet, DVec2::new(x, middle), 3.5, walk, test);
        }
    }
    sheet.y = middle + 16.0;
}

fn dot(sheet: &mut Sheet, at: DVec2, radius: f64, walk: &WalkGeometry, test: &StripTest) {
    let class = match test.outcome {
        Outcome::Nearest => "dot-hit",
        Outcome::NotNearest => "dot-farther",
        Outcome::Missed => "dot-missed",
    };
    let t = test.t.map_or_else(|| "never meets its plane".into(), |t| format!("t {}", short(t)));
    let why = walk.tested.get(test.test).filter(|_| test.outcome != Outcome::Nearest);
    let why = why.map_or_else(String::new, |tested| format!(" ({})", tested.why));
    sheet.circle(at, radius, class, &format!("triangle {}: {}{why}, {t}", test.triangle, test.outcome.name()));
}

/// A scale of t: at the ends of cells if these are equally wide, otherwise evenly spaced.
fn axis(sheet: &mut Sheet, strip: &Strip, spacing: Spacing) {
    let width = sheet.width - 2.0 * sheet.left;
    let y = sheet.y + 2.0;
    let marks: Vec<(f64, String)> = match spacing {
        Spacing::Equal if !strip.cells.is_empty() => {
            let every = strip.cells.len().div_ceil((width / 52.0) as usize);
            let ends = strip.cells.iter().map(|cell| cell.t[1]).skip(every - 1).step_by(every);
            std::iter::once(strip.t[0]).chain(ends).map(|t| (t, short(t))).collect()
        }
        _ => {
            let ticks = Ticks::of(strip.t, ((width / 70.0) as usize).clamp(4, 24));
            ticks.values.iter().map(|&t| (t, ticks.text(t))).collect()
        }
    };
    sheet.line(DVec2::new(sheet.left, y), DVec2::new(sheet.left + width, y), "frame");
    let last = marks.len().saturating_sub(1);
    let mut written = f64::NEG_INFINITY;
    for (i, (t, text)) in marks.into_iter().enumerate() {
        let x = sheet.left + strip.place(t, spacing) * width;
        sheet.line(DVec2::new(x, y), DVec2::new(x, y + 4.0), "frame");
        // Cells that the ray barely touches end at the same t.
        if x - written < 40.0 {
            continue;
        }
        written = x;
        let class = if i == 0 {
            "small"
        } else if i == last {
            "small end"
        } else {
            "small middle"
        };
        sheet.text(x, y + 14.0, class, &if i == 0 { format!("t {text}") } else { text });
    }
    if let Some(hit) = strip.hit.filter(|t| (strip.t[0]..=strip.t[1]).contains(t)) {
        let x = sheet.left + strip.place(hit, spacing) * width;
        sheet.circle(DVec2::new(x, y), 4.0, "dot-hit", &format!("nearest hit, t {}", short(hit)));
    }
    sheet.y = y + 20.0;
}
