//! The commands of a lesson, one a line.

use super::comparison::Comparison;
use super::error::Wrong;
use super::expression::Expression;
use super::fact::is_label;
use super::prose::quoted;
use super::question::{Choice, Question};
use crate::command::{Command, PaneKind};
use crate::link::{Link, LinkDevice, LinkStream};

/// Most steps from cell to cell that a lesson makes by itself.
const MOST_PLAYED: usize = 100;

/// Which values of a step from cell to cell are shown for after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Values {
    /// The axis of the step.
    pub axis: bool,
    /// The new cell.
    pub cell: bool,
    /// The new tMax.
    pub tmax: bool,
    /// The new state.
    pub state: bool,
}

impl Values {
    /// Reads their names.
    pub(super) fn parse(rest: &str) -> Result<Self, Wrong> {
        let mut values = Self::default();
        for word in rest.split_whitespace() {
            let value = match word {
                "axis" => &mut values.axis,
                "cell" => &mut values.cell,
                "tmax" => &mut values.tmax,
                "state" => &mut values.state,
                _ => {
                    return Err(Wrong::Argument(
                        "before-after",
                        format!("{word:?}: expected axis, cell, tmax or state"),
                    ));
                }
            };
            *value = true;
        }
        Ok(values)
    }
}

/// What a step sets up.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Opens a scene.
    Open(Box<Link>),
    /// Selects a ray.
    Pixel([u32; 2]),
    /// Selects the nearest ray for which all of this holds.
    Find(Vec<Comparison>),
    /// Goes to a pass.
    Go(Goal),
    /// Shows exactly these panels, in rows.
    Only(Vec<Vec<PaneKind>>),
    /// Shows a panel.
    Show(PaneKind),
    /// Shows a stream.
    Stream(LinkStream),
    /// Enlarges it: points a texel, and the pixel in the middle, if it is not the selected one.
    Zoom(f32, Option<[f32; 2]>),
    /// Performs a command.
    Do(Command),
    /// Measures a run.
    Measure(String, Box<Link>),
    /// Shows measured runs.
    Bars(Vec<String>),
    /// Shows what the ray may hit.
    Candidates,
    /// Shows a step from cell to cell, before and after.
    BeforeAfter(Values),
    /// Shows the states of a ray.
    States,
    /// Marks a function in the kernel panel.
    Code(String),
    /// Goes on by itself for this many steps from cell to cell.
    Play(usize),
}

/// Where to go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Goal {
    /// After this many passes.
    Passes(usize),
    /// After the last pass.
    End,
    /// After the pass of the ray's N-th row, from 1, whose reason contains a text.
    Row(usize, String),
}

/// What has to hold.
#[derive(Clone, Debug, PartialEq)]
pub enum Expect {
    /// A panel is in view.
    Panel(PaneKind),
    /// A text can be read outside of the lesson.
    Text(String),
    /// Values compare so.
    Values(Comparison),
}

/// A line of commands.
pub(super) enum Line {
    /// To set up.
    Action(Action),
    /// To check.
    Expect(Expect),
    /// A question.
    Question(Question),
    /// A choice of the question before.
    Choice(Choice),
}

/// The name of a panel in lessons: that of the menu, in lower case with hyphens.
#[must_use]
pub fn panel_name(kind: PaneKind) -> String {
    Command::Show(kind).name().to_lowercase().replace(' ', "-")
}

/// Reads a line with this number.
pub(super) fn line(number: usize, text: &str) -> Result<Line, Wrong> {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim();
    let action = match word {
        "open" => Action::Open(Box::new(link("open", rest)?)),
        "pixel" => Action::Pixel(pair("pixel", rest)?),
        "find" => find(rest)?,
        "start" => nothing("start", rest, Action::Go(Goal::Passes(0)))?,
        "end" => nothing("end", rest, Action::Go(Goal::End))?,
        "pass" => {
            let pass = rest.parse::<usize>().ok().and_then(|pass| pass.checked_add(1));
            Action::Go(Goal::Passes(pass.ok_or_else(|| wrong("pass", "expected the index of a pass, such as 14"))?))
        }
        "row" => Action::Go(row(rest)?),
        "only" => Action::Only(rows(rest)?),
        "show" => Action::Show(panel("show", rest)?),
        "stream" => Action::Stream(stream(rest)?),
        "zoom" => zoom(rest)?,
        "do" => Action::Do(command(rest)?),
        "measure" => measure(rest)?,
        "bars" => {
            let names: Vec<String> = rest.split_whitespace().map(str::to_owned).collect();
            if names.is_empty() {
                return Err(wrong("bars", "expected the names of measured runs"));
            }
            Action::Bars(names)
        }
        "candidates" => nothing("candidates", rest, Action::Candidates)?,
        "before-after" => Action::BeforeAfter(Values::parse(rest)?),
        "states" => nothing("states", rest, Action::States)?,
        "code" => {
            let is_name = !rest.is_empty() && rest.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            let name = is_name.then(|| rest.to_owned());
            Action::Code(name.ok_or_else(|| wrong("code", "expected the name of a function, such as cell_exit"))?)
        }
        "play" => {
            let steps = rest.parse().ok().filter(|steps| (1..=MOST_PLAYED).contains(steps));
            Action::Play(steps.ok_or_else(|| wrong("play", format!("expected 1 to {MOST_PLAYED} steps")))?)
        }
        "question" => return Question::parse(number, rest).map(Line::Question),
        "choice" => return Choice::parse(number, rest).map(Line::Choice),
        "expect" => return expect(rest).map(Line::Expect),
        _ => return Err(Wrong::Command(text.chars().take(40).collect())),
    };
    Ok(Line::Action(action))
}

fn wrong(word: &'static str, wanted: impl Into<String>) -> Wrong {
    Wrong::Argument(word, wanted.into())
}

fn find(rest: &str) -> Result<Action, Wrong> {
    let all = Comparison::parse_all("find", rest)?;
    let mut names = all.iter().flat_map(Comparison::expressions).flat_map(Expression::names);
    if let Some(other) = names.find(|name| !name.is_of_tie()) {
        return Err(wrong("find", format!("{other} is not a value of tie, and only those are known of every ray")));
    }
    drop(names);
    Ok(Action::Find(all))
}

fn nothing(word: &'static str, rest: &str, action: Action) -> Result<Action, Wrong> {
    if rest.is_empty() { Ok(action) } else { Err(wrong(word, format!("takes nothing, but {rest:?} follows"))) }
}

/// A link, or pairs of one.
fn link(word: &'static str, rest: &str) -> Result<Link, Wrong> {
    let text = match rest.starts_with("raystep:") {
        true => rest.to_owned(),
        false => format!("raystep:{}?{}", crate::link::VERSION, rest.split_whitespace().collect::<Vec<_>>().join("&")),
    };
    let link: Link = text.parse().map_err(|error| Wrong::Link(word, error))?;
    if word == "open" && link.scene.is_none() {
        return Err(wrong("open", "expected a scene, such as scene=built-in:cornell-box"));
    }
    Ok(link)
}

fn pair<T: std::str::FromStr>(word: &'static str, text: &str) -> Result<[T; 2], Wrong> {
    let parts = text.split_once(',').and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
    parts.ok_or_else(|| wrong(word, "expected two numbers, such as 96,180"))
}

fn row(rest: &str) -> Result<Goal, Wrong> {
    let (number, text) = match rest.split_once(char::is_whitespace).filter(|_| !rest.starts_with('"')) {
        Some((number, text)) => {
            let number = number.parse().ok().filter(|&number: &usize| number > 0);
            (number.ok_or_else(|| wrong("row", "expected a number of at least 1, or a text in double quotes"))?, text)
        }
        None => (1, rest),
    };
    Ok(Goal::Row(number, quoted("row", text.trim())?))
}

fn panel(word: &'static str, name: &str) -> Result<PaneKind, Wrong> {
    let found = PaneKind::ALL.iter().copied().find(|&kind| panel_name(kind) == name);
    found.ok_or_else(|| {
        let names: Vec<String> = PaneKind::ALL.iter().map(|&kind| panel_name(kind)).collect();
        wrong(word, format!("{name:?} is not a panel; the panels are {}", names.join(", ")))
    })
}

fn rows(rest: &str) -> Result<Vec<Vec<PaneKind>>, Wrong> {
    let mut rows = Vec::new();
    let mut seen = Vec::new();
    for row in rest.split('/') {
        let kinds = row.split_whitespace().map(|name| panel("only", name)).collect::<Result<Vec<_>, _>>()?;
        if kinds.is_empty() {
            return Err(wrong("only", "expected panels, such as 'only stream ray / unfolded-walk'"));
        }
        if let Some(twice) = kinds.iter().find(|kind| seen.contains(*kind)) {
            return Err(wrong("only", format!("{} is there twice", panel_name(*twice))));
        }
        seen.extend_from_slice(&kinds);
        rows.push(kinds);
    }
    Ok(rows)
}

fn stream(name: &str) -> Result<LinkStream, Wrong> {
    let of = |program: &str| link("stream", &format!("{program} stream={name}"));
    let found = of("").or_else(|error| of("program=grid-build").map_err(|_| error))?;
    found.stream.ok_or_else(|| wrong("stream", "expected the name of a stream, such as state.t"))
}

/// The middle of a pixel.
#[must_use]
pub fn middle_of(pixel: [u32; 2]) -> [f32; 2] {
    pixel.map(|side| side as f32 + 0.5)
}

fn zoom(rest: &str) -> Result<Action, Wrong> {
    let (points, at) = rest.split_once(" at ").map_or((rest, None), |(points, at)| (points, Some(at)));
    let points = points.trim().parse::<f32>().ok().filter(|points| (0.01..=256.0).contains(points));
    let wanted = "expected 0.01 to 256 points a texel, and perhaps a pixel, such as 'zoom 40 at 256,4'";
    let at = at.map(|at| pair::<u32>("zoom", at.trim())).transpose()?;
    Ok(Action::Zoom(points.ok_or_else(|| wrong("zoom", wanted))?, at.map(middle_of)))
}

fn command(name: &str) -> Result<Command, Wrong> {
    // A lesson that opens another, or ends itself, would have no next step.
    let found = Command::named(name).filter(|command| !command.is_of_lessons() && *command != Command::Quit);
    found.ok_or_else(|| wrong("do", format!("{name:?} is not a command that a lesson can perform; see the menus")))
}

fn measure(rest: &str) -> Result<Action, Wrong> {
    let (name, options) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    if !is_label(name) {
        return Err(wrong("measure", format!("{name:?}: expected a name of lower-case letters, digits and hyphens")));
    }
    let link = link("measure", options)?;
    let is_elsewhere = link.scene.is_some() || link.device != LinkDevice::Auto || link.adapter.is_some();
    if is_elsewhere || link.ray.is_some() || link.pass.is_some() || link.stream.is_some() {
        let why = "it traces the open scene on the open run's device: omit scene, device, adapter, pixel, ray, pass \
                   and stream";
        return Err(wrong("measure", why));
    }
    Ok(Action::Measure(name.to_owned(), Box::new(link)))
}

fn expect(rest: &str) -> Result<Expect, Wrong> {
    if let Some(name) = rest.strip_prefix("panel ") {
        return panel("expect", name.trim()).map(Expect::Panel);
    }
    if let Some(text) = rest.strip_prefix("text ") {
        return quoted("expect", text.trim()).map(Expect::Text);
    }
    Comparison::parse("expect", rest, "'panel NAME', 'text \"TEXT\"', or ").map(Expect::Values)
}
