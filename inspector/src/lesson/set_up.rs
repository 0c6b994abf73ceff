//! The whole set-up of a step, as plain data.

use super::{Action, Comparison, Goal, Lesson};
use crate::link::Link;
use crate::ui::Shown;
use crate::ui::command::Command;
use crate::ui::pane::PaneKind;

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
    /// Runs to measure, of all steps so far.
    pub measurements: Vec<Measurement>,
    /// Measured runs that the step shows.
    pub bars: Vec<String>,
    /// Whether the step shows what the ray may hit.
    pub has_candidates: bool,
}

impl Lesson {
    /// The whole set-up of a step, from 0.
    #[must_use]
    pub fn set_up(&self, step: usize) -> SetUp {
        let mut all = SetUp::default();
        for (i, step_of) in self.steps.iter().enumerate().take(step.saturating_add(1)) {
            for (line, action) in &step_of.actions {
                all.add(*line, action, i == step);
            }
        }
        all
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
            Action::Bars(_) | Action::Candidates => {}
        }
    }
}
