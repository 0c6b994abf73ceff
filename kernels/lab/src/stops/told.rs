//! The elements that stop, in words.

use std::fmt::Write as _;

use raystep_kernels::interpret::{Stopped, Watched};
use raystep_kernels::shader::{FileLine, Sourced};
use raystep_kernels::tables::elements::Count;

use super::StoppedPass;

/// The elements of a pass, and what was asked.
pub struct Told<'a> {
    /// What was found.
    pub found: &'a StoppedPass,
    /// The kernel.
    pub of: &'a Sourced,
    /// The line.
    pub at: FileLine,
    /// The condition.
    pub when: Option<&'a str>,
    /// The variables of the condition.
    pub names: &'a [String],
    /// Their values' types.
    pub watched: &'a [Watched],
}

impl<'a> Told<'a> {
    /// Whether the elements are the pixels of an image.
    #[must_use]
    pub fn is_image(&self) -> bool {
        self.of.variant.kernel.instance().over.count == Count::Image
    }

    /// What an element is called: column and row, or its place in its set.
    #[must_use]
    pub fn name_of(&self, element: usize) -> String {
        let width = self.found.size.width.max(1) as usize;
        match self.is_image() {
            true => format!("{},{}", element % width, element / width),
            false => element.to_string(),
        }
    }

    /// The variables with their values.
    pub fn values<'b>(&'b self, stopped: &'b Stopped) -> impl Iterator<Item = (&'a str, Watched, &'b [u32])> {
        let mut first = 0;
        self.watched.iter().filter_map(move |watched| {
            let end = first + watched.words as usize;
            let values = stopped.values.get(first..end)?;
            first = end;
            Some((self.names.get(watched.index)?.as_str(), *watched, values))
        })
    }

    /// How many elements come to the line, and for how many the condition holds.
    #[must_use]
    pub fn head(&self) -> String {
        let Self { found, of, at, .. } = self;
        let kernel = of.variant.kernel;
        let (name, count) = (&of.files[at.file].name, found.elements.len());
        let place = format!("pass {}, {}, {name}:{}", found.pass, kernel.name(), at.line);
        let all = format!("{count} of {} {}", found.size.count, kernel.instance().over.name);
        match self.when {
            Some(when) => format!("{place}: {all} come here, {when} holds for {}", found.held().count()),
            None => format!("{place}: {all} come here"),
        }
    }

    /// What an element had: the variables of the condition, and how often.
    #[must_use]
    pub fn element(&self, stopped: &Stopped) -> String {
        let mut text = String::new();
        for (name, watched, values) in self.values(stopped) {
            let _ = write!(text, "  {name} = {}", watched.told(values));
        }
        match (self.when, stopped.reached, stopped.held) {
            (_, 1, _) => {}
            (None, reached, _) => _ = write!(text, "  {reached} times"),
            (Some(_), reached, held) => _ = write!(text, "  {held} of {reached} times"),
        }
        text
    }
}
