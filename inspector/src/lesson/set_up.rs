//! The whole set-up of a step, as plain data.

use super::command::Values;
use super::{Action, Comparison, Expect, Expression, Goal, Lesson, Name, Step};
use crate::command::{Command, PaneKind};
use crate::link::{Link, Shown};

/// A run to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Its name.
    pub name: String,
    /// Its options.
    pub link: Link,
    /// The line of the command.
    pub line: usize,
}

/// Everything that a step needs: what its own commands say, and those before it, back to the last `open`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetUp {
    /// The scene and its options.
    pub link: Link,
    /// The line of `open`.
    pub line: usize,
    /// The selected ray.
    pub pixel: Option<[u32; 2]>,
    /// What has to hold for the selected ray, and the line that says so: the nearest one is taken.
    pub find: Option<(usize, Vec<Comparison>)>,
    /// Where to be, and the line that says so.
    pub goal: Option<(usize, Goal)>,
    /// The panels, in rows; `None` for those that are there at the start.
    pub panels: Option<Vec<Vec<PaneKind>>>,
    /// Further panels.
    pub more: Vec<PaneKind>,
    /// What the stream panel shows; if that is enlarged around no point, the selected pixel is in the middle.
    pub shown: Option<Shown>,
    /// Commands to perform.
    pub commands: Vec<Command>,
    /// Runs that the step shows values of, and that were not measured in the run of another scene.
    pub measurements: Vec<Measurement>,
    /// Measured runs that the step shows.
    pub bars: Vec<String>,
    /// Whether the step shows what the ray may hit.
    pub has_candidates: bool,
    /// Whether it shows a step from cell to cell before and after, and which values of after.
    pub before_after: Option<Values>,
    /// Whether it shows the states of a ray.
    pub has_states: bool,
    /// The function that is marked in the kernel panel.
    pub code: Option<String>,
    /// The steps from cell to cell that it makes by itself.
    pub play: Option<usize>,
}

impl Lesson {
    /// The whole set-up of a step, from 0; of its answer as well if its question `is_answered`.
    #[must_use]
    pub fn set_up(&self, step: usize, is_answered: bool) -> SetUp {
        let mut all = SetUp::default();
        for (i, step_of) in self.steps.iter().enumerate().take(step.saturating_add(1)) {
            let sections = step_of.sections();
            let count = if i < step || is_answered { 2 } else { 1 };
            for (line, action) in sections.into_iter().take(count).flat_map(|section| &section.actions) {
                all.add(*line, action, i == step);
            }
        }
        let wanted = self.steps.get(step).map(|step_of| self.measured_by(step_of)).unwrap_or_default();
        all.measurements.retain(|known| wanted.contains(&known.name));
        all
    }

    /// The names of the measured runs that a step shows or compares.
    fn measured_by(&self, step: &Step) -> Vec<String> {
        let of_values =
            self.expressions(step).flat_map(|(_, expression)| expression.names()).filter_map(|name| match name {
                Name::Measured(of, _) => Some(of.clone()),
                Name::Fact(_) => None,
            });
        let actions = step.sections().into_iter().flat_map(|section| &section.actions);
        let of_bars = actions.filter_map(|(_, action)| match action {
            Action::Bars(names) => Some(names.clone()),
            _ => None,
        });
        of_values.chain(of_bars.flatten()).collect()
    }

    /// The values that a step shows or compares, with their lines. What is before the first step belongs to it.
    pub(super) fn expressions<'a>(&'a self, step: &'a Step) -> impl Iterator<Item = (usize, &'a Expression)> {
        let about = self.about.iter().filter(|_| self.steps.first().is_some_and(|first| std::ptr::eq(first, step)));
        let texts = about.chain(step.sections().into_iter().flat_map(|section| &section.text));
        let texts = texts.chain(step.question.iter().flat_map(|question| question.texts()));
        let expects = step.sections().into_iter().flat_map(|section| &section.expects);
        let expected = expects.filter_map(|(line, expect)| match expect {
            Expect::Values(comparison) => Some((*line, comparison)),
            Expect::Panel(_) | Expect::Text(_) => None,
        });
        let compared = expected.chain(step.question.iter().flat_map(|question| question.conditions()));
        let compared = compared.flat_map(|(line, both)| both.expressions().map(move |expression| (line, expression)));
        texts.flat_map(|text| text.values()).chain(compared)
    }
}

impl SetUp {
    fn add(&mut self, line: usize, action: &Action, is_own: bool) {
        match action {
            Action::Open(link) => {
                let pixel = match link.ray {
                    Some(crate::link::LinkRay::Pixel(pixel)) => Some(pixel),
                    _ => None,
                };
                *self = Self {
                    link: (**link).clone(),
                    line,
                    pixel,
                    goal: link.pass.map(|passes| (line, Goal::Passes(passes))),
                    shown: Shown::of(link),
                    measurements: std::mem::take(&mut self.measurements),
                    ..Self::default()
                };
            }
            Action::Pixel(pixel) => (self.pixel, self.find) = (Some(*pixel), None),
            Action::Find(all) => self.find = Some((line, all.clone())),
            Action::Go(goal) => self.goal = Some((line, goal.clone())),
            Action::Only(panels) => {
                (self.panels, self.more) = (Some(panels.clone()), Vec::new());
                // Many commands show a panel: it would come back.
                self.commands.clear();
                self.code = None;
            }
            Action::Show(kind) => self.more.push(*kind),
            Action::Stream(stream) => self.shown = Some(Shown { stream: *stream, zoom: None, pan: None }),
            Action::Zoom(points, at) => {
                self.shown = self.shown.map(|shown| Shown { zoom: Some(*points), pan: *at, ..shown });
            }
            Action::Do(command) => self.commands.push(*command),
            Action::Measure(name, link) => {
                self.measurements.push(Measurement { name: name.clone(), link: (**link).clone(), line });
            }
            Action::Bars(names) if is_own => self.bars.clone_from(names),
            Action::Candidates if is_own => self.has_candidates = true,
            Action::BeforeAfter(values) if is_own => self.before_after = Some(*values),
            Action::States if is_own => self.has_states = true,
            Action::Code(function) => self.code = Some(function.clone()),
            Action::Play(steps) if is_own => self.play = Some(*steps),
            Action::Bars(_) | Action::Candidates | Action::BeforeAfter(_) | Action::States | Action::Play(_) => {}
        }
    }
}
