//! Where the parts of the diagram lie.

use super::{Choice, Precision};
use crate::plots::axis::Ranged;
use crate::plots::draw::{HALF_MARK, RING, across, beside, color, left_of, up, widest};
use crate::plots::font::{width, wrapped};
use crate::plots::frame::Frame;
use crate::plots::labels::{HALF, Obstacles, Placement, Wanted, distance, places};
use crate::plots::legend::Entry;
use crate::plots::lines::RIGHT;
use crate::plots::picture::{BLACK, LINE, Picture, Point, SIZE};
use crate::text::visible;

/// Height of a line of the strip of choices of which no ray was wrong.
const LANE: f64 = LINE;
/// Height of the logarithmic part: without marks, and for each of the first so many.
const LOG: [f64; 3] = [84.0, 9.0, 12.0];
/// Room in it for labels, above and below all marks.
const ROOM: [f64; 2] = [24.0, 15.0];
/// Between a label and what is beside it.
const GAP: f64 = 4.0;
/// The longest line from a name to its mark: beyond, the mark has a number instead.
const FAR: f64 = 60.0;
/// The largest share of the width that a name among marks has.
const WIDEST: f64 = 0.6;

/// All rays, per million.
const ALL: f64 = 1e6;

/// A choice in the diagram.
#[derive(Clone, Copy)]
pub(super) struct Mark<'a> {
    pub(super) choice: &'a Choice,
    pub(super) at: Point,
    /// From where to where its mark, interval and arrow lie.
    reach: [f64; 2],
}

/// A label.
#[derive(Clone)]
pub(super) struct Label {
    pub(super) lines: Vec<String>,
    pub(super) place: Placement,
}

impl Label {
    /// Where its lines begin.
    pub(super) fn left(&self) -> f64 {
        let Frame { left, right, .. } = self.place.frame;
        f64::midpoint(left, right - widest(&self.lines))
    }
}

/// From a label's top to the middle of its first line.
pub(super) const FIRST: f64 = HALF;

/// Where everything lies.
pub(super) struct Layout<'a> {
    x: Ranged,
    y: Ranged,
    /// Values of the vertical axis with their labels.
    rows: Vec<(f64, String)>,
    has_log: bool,
    /// The logarithmic part.
    log: Frame,
    /// That where values are.
    values: Frame,
    /// Outline of both parts.
    pub(super) frame: Frame,
    /// All choices: first those of which a ray is wrong.
    pub(super) marks: Vec<Mark<'a>>,
    /// Their labels, in the same order, and the title of the strip.
    pub(super) labels: Vec<Label>,
    /// The choices that have numbers instead of names, from 1.
    key: Vec<&'a Choice>,
}

impl<'a> Layout<'a> {
    /// Of a picture of this width, below `top`.
    pub(super) fn new(of: &'a Precision, picture: f64, top: f64) -> Self {
        let (none, some): (Vec<&Choice>, Vec<&Choice>) = of.choices.iter().partition(|c| c.wrong <= 0.0);
        let with_ends = |value: f64, ends: Option<(f64, f64)>| {
            std::iter::once(value).chain(ends.into_iter().flat_map(|(low, high)| [low, high]))
        };
        let x = of.x.over(of.choices.iter().flat_map(|c| with_ends(c.x, c.x_ends)).chain(of.from));
        let wrong = some.iter().flat_map(|c| with_ends(c.wrong, c.wrong_ends));
        let shown: Vec<f64> = wrong.chain(of.choices.iter().map(|c| c.undecided)).filter(|&v| v > 0.0).collect();
        // So wide that there is more than one label where all are alike.
        let y = of.y.over(shown.iter().flat_map(|v| [v / 1.4, v * 1.4]).map(|v| v.min(ALL)));
        let [height, of_each, most] = LOG;
        let has_log = !shown.is_empty();
        let height = if has_log { height + of_each * most.min(some.len() as f64) } else { 0.0 };
        let (rows, left) = left_of(&y, height - ROOM[0] - ROOM[1]);
        let log = Frame { left, right: picture - RIGHT, top, bottom: top };
        let mut layout = Self {
            x,
            y,
            rows,
            has_log,
            log,
            values: log,
            frame: log,
            marks: Vec::new(),
            labels: Vec::new(),
            key: Vec::new(),
        };
        layout.place_log(of, &some, height);
        layout.place_strip(of, &none);
        layout
    }

    /// The logarithmic part: names where they fit, numbers where they do not, and more room above the marks until all
    /// have one.
    fn place_log(&mut self, of: &'a Precision, some: &[&'a Choice], height: f64) {
        const TRIES: usize = 12;
        let Frame { left, right, top, .. } = self.log;
        let is_long = |choice: &&Choice| width(&visible(&choice.label), SIZE) + GAP > WIDEST * (right - left);
        let mut has_number: Vec<bool> = some.iter().map(is_long).collect();
        let mut above = ROOM[0];
        for _ in 0..TRIES {
            let end = if self.has_log { top + height + above - ROOM[0] } else { top };
            self.log.bottom = end;
            self.values = Frame { top: (top + above).min(end), bottom: (end - ROOM[1]).max(top), ..self.log };
            self.marks = some.iter().map(|choice| self.mark(of, choice, self.up(choice.wrong))).collect();
            let texts = texts(some, &has_number);
            let placed = self.places(&texts);
            let is_placed = |i: usize| {
                let place = placed[i].filter(|place| has_number[i] || !is_far(place))?;
                Some(Label { lines: vec![texts[i].clone()], place })
            };
            let labels: Vec<Option<Label>> = (0..some.len()).map(is_placed).collect();
            let missing = labels.iter().filter(|label| label.is_none()).count();
            let named = has_number.iter().filter(|has| !**has).count();
            has_number.iter_mut().zip(&labels).for_each(|(has, label)| *has |= label.is_none());
            self.key = some.iter().zip(&has_number).filter(|(_, has)| **has).map(|(choice, _)| *choice).collect();
            self.labels = labels.into_iter().flatten().collect();
            if missing == 0 {
                return;
            }
            // Where even numbers have no room, there is more.
            if named == 0 {
                above += LINE * missing as f64;
            }
        }
    }

    /// A choice with its mark at this height.
    fn mark(&self, of: &Precision, choice: &'a Choice, y: f64) -> Mark<'a> {
        let at = (self.across(choice.x), y);
        let ends = choice.x_ends.into_iter().flat_map(|(low, high)| [low, high]).chain(of.from);
        let reach = ends.map(|v| self.across(v)).fold([at.0, at.0], |[low, high], x| [low.min(x), high.max(x)]);
        let half = half(choice);
        Mark { choice, at, reach: [reach[0].min(at.0 - half), reach[1].max(at.0 + half)] }
    }

    /// The choices of which no ray was wrong: below the strip's title a line for each.
    fn place_strip(&mut self, of: &'a Precision, none: &[&'a Choice]) {
        let Frame { left, right, .. } = self.log;
        let title = wrapped(&of.strip(), SIZE, right - left - 2.0 * GAP);
        let mut top = self.log.bottom + 3.0;
        let title_top = top;
        top += LINE * title.len() as f64;
        for &choice in none {
            let mut mark = self.mark(of, choice, top + LANE / 2.0);
            let name = visible(&choice.label);
            let text = width(&name, SIZE);
            // On the mark's own line, if there is room.
            let lefts = [mark.reach[1] + GAP, mark.reach[0] - GAP - text];
            let beside = lefts.into_iter().find(|&begin| begin > left + 1.0 && begin + text < right - 1.0);
            let (lines, begin, middle) = match beside {
                Some(begin) => (vec![name.into_owned()], begin, mark.at.1),
                None => {
                    let lines = wrapped(&choice.label, SIZE, right - left - 2.0 * GAP);
                    let wide = widest(&lines);
                    let begin = (mark.at.0 - wide / 2.0).min(right - GAP - wide).max(left + GAP);
                    let middle = mark.at.1;
                    mark.at.1 += LANE * lines.len() as f64;
                    (lines, begin, middle)
                }
            };
            top = mark.at.1 + LANE / 2.0;
            self.labels.push(label(lines, begin, middle - HALF));
            self.marks.push(mark);
        }
        // A line's height if there is none, and a little room.
        self.frame.bottom = top + 3.0 + if none.is_empty() { LANE } else { 0.0 };
        // The title is where the dashed line does not cross it.
        let lefts = [left + GAP, right - GAP - widest(&title)];
        let at = |begin: f64| label(title.clone(), begin, title_top + LINE / 2.0 - HALF);
        let is_free = |begin: &f64| !self.dashed().iter().any(|line| line.meets(at(*begin).place.frame));
        let begin = lefts.into_iter().find(is_free).unwrap_or(lefts[0]);
        self.labels.push(at(begin));
    }

    /// Places of texts in the logarithmic part.
    fn places(&self, texts: &[String]) -> Vec<Option<Placement>> {
        let mut obstacles = Obstacles::default();
        for mark in &self.marks {
            let (x, y) = mark.at;
            obstacles.hard.extend([
                Frame::around(mark.at, HALF.max(half(mark.choice))),
                Frame::along(&mark.reach.map(|x| (x, y)), 4.5),
            ]);
            let ends = mark.choice.wrong_ends.map(|(low, high)| [(x, self.up(low)), (x, self.up(high))]);
            obstacles.hard.extend(ends.map(|ends| Frame::along(&ends, 2.0)));
        }
        obstacles.soft.extend(self.marks.iter().filter_map(|mark| self.bar(mark.choice)));
        obstacles.soft.extend(self.dashed());
        let wanted = |(mark, text): (&Mark<'_>, &String)| Wanted { at: mark.at, width: width(text, SIZE) + 2.0 };
        let wanted: Vec<Wanted> = self.marks.iter().zip(texts).map(wanted).collect();
        places(self.log, &wanted, &obstacles)
    }

    pub(super) fn across(&self, value: f64) -> f64 {
        across(self.frame, &self.x, value)
    }

    pub(super) fn up(&self, value: f64) -> f64 {
        up(self.values, &self.y, value)
    }

    /// The horizontal axis.
    pub(super) fn x(&self) -> &Ranged {
        &self.x
    }

    /// Where the logarithmic part ends.
    pub(super) fn log_end(&self) -> f64 {
        self.log.bottom
    }

    /// Labels of the vertical axis, and a line below its values.
    pub(super) fn beside(&self, picture: &mut Picture) {
        beside(picture, self.values, &self.y, &self.rows);
        let Frame { left, right, bottom, .. } = self.log;
        picture.thin(BLACK, (left, bottom), (right, bottom));
    }

    /// What the numbers mean.
    pub(super) fn key(&self) -> Vec<Entry> {
        let entry = |(number, choice): (u32, &&Choice)| {
            Entry::mark(&format!("{number} {}", choice.label), color(choice.color), choice.shape, choice.is_hollow)
        };
        (1..).zip(&self.key).map(entry).collect()
    }

    /// The bar of undecided rays.
    pub(super) fn bar(&self, choice: &Choice) -> Option<Frame> {
        let x = self.across(choice.x);
        let (top, bottom) = (self.up(choice.undecided), self.log_end() - 1.0);
        (choice.undecided > 0.0).then_some(Frame { left: x - 4.0, right: x + 4.0, top, bottom })
    }

    /// Corners of the line along choices that nothing beats in both.
    pub(super) fn front(&self) -> Vec<Point> {
        let mut at: Vec<Point> = self.marks.iter().filter(|m| m.choice.is_front).map(|m| m.at).collect();
        at.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        at.windows(2).flat_map(|p| [p[0], (p[1].0, p[0].1)]).chain(at.last().copied()).collect()
    }

    /// What that line covers.
    fn dashed(&self) -> Vec<Frame> {
        self.front().windows(2).map(|pair| Frame::along(pair, 1.0)).collect()
    }
}

/// Half the size of a choice's mark, with its ring.
fn half(choice: &Choice) -> f64 {
    if choice.is_recommended { RING + 1.0 } else { HALF_MARK }
}

/// Whether a label is so far from its mark that a number is better.
fn is_far(place: &Placement) -> bool {
    place.leader.is_some_and(|[from, to]| distance(from, to) > FAR)
}

/// What is written beside marks: names, or numbers from 1.
fn texts(choices: &[&Choice], has_number: &[bool]) -> Vec<String> {
    let mut number = 0;
    let text = |(choice, has): (&&Choice, &bool)| match has {
        true => {
            number += 1;
            number.to_string()
        }
        false => visible(&choice.label).into_owned(),
    };
    choices.iter().zip(has_number).map(text).collect()
}

/// Lines of text with their upper left corner here.
fn label(lines: Vec<String>, left: f64, top: f64) -> Label {
    let right = left + widest(&lines);
    let bottom = top + 2.0 * HALF + LANE * (lines.len() as f64 - 1.0);
    Label { lines, place: Placement { frame: Frame { left, right, top, bottom }, leader: None } }
}
