//! Where the element is among its steps, and how it goes from there.

use std::collections::BTreeSet;

use raystep_kernels::interpret::{Followed, View};
use serde_json::{Value, json};

use super::breakpoints::Breakpoints;
use super::reply::{Refused, text};
use super::target::Target;
use super::values::{Values, find, streams};

/// Why it stands where it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Because {
    Entry,
    Step,
    Breakpoint,
    /// It has come to its end, or has failed there.
    End,
}

/// A way to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Go {
    On,
    Over,
    Into,
    Out,
    Back,
    ReverseOn,
}

/// An element that is debugged.
pub(super) struct Session {
    pub(super) target: Target,
    pub(super) breakpoints: Breakpoints,
    followed: Followed,
    always: BTreeSet<u32>,
    held: BTreeSet<usize>,
    /// An index of the steps; behind the last at the end.
    position: usize,
    because: Because,
    view: Option<View>,
    values: Values,
}

impl Session {
    pub(super) fn new(target: Target) -> Self {
        Self {
            target,
            breakpoints: Breakpoints::default(),
            followed: Followed::default(),
            always: BTreeSet::new(),
            held: BTreeSet::new(),
            position: 0,
            because: Because::Entry,
            view: None,
            values: Values::default(),
        }
    }

    /// Follows the element, with the breakpoints as they are now; the position stays.
    pub(super) fn follow(&mut self) -> Result<(), Refused> {
        self.followed = self.target.follow(&self.breakpoints.conditional())?;
        self.always = self.breakpoints.always();
        self.held = self.followed.held.iter().map(|(step, _)| *step).collect();
        self.position = self.position.min(self.end());
        Ok(())
    }

    /// Follows from the beginning, and stands there, or at the first breakpoint.
    pub(super) fn begin(&mut self, stops_at_once: bool) -> Result<(), Refused> {
        self.position = 0;
        self.follow()?;
        self.because = Because::Entry;
        if !stops_at_once {
            let first = (0..self.end()).find(|&at| self.is_breakpoint(at));
            self.stand(first.unwrap_or(self.end()), Because::Breakpoint);
        } else {
            self.stand(0, Because::Entry);
        }
        Ok(())
    }

    fn end(&self) -> usize {
        self.followed.steps.len()
    }

    fn depth(&self, at: usize) -> u32 {
        self.followed.steps.get(at).map_or(0, |step| step.depth)
    }

    fn is_breakpoint(&self, at: usize) -> bool {
        let statement = self.followed.steps.get(at).map(|step| step.statement);
        statement.is_some_and(|statement| self.always.contains(&statement)) || self.held.contains(&at)
    }

    fn stand(&mut self, at: usize, because: Because) {
        self.position = at;
        self.because = if at >= self.end() { Because::End } else { because };
        self.view = None;
        self.values.clear();
    }

    /// Goes on or back. Returns false if it stood at the end and was to go on.
    pub(super) fn go(&mut self, go: Go) -> bool {
        let (here, end) = (self.position, self.end());
        let own = self.depth(here);
        if here >= end && !matches!(go, Go::Back | Go::ReverseOn) {
            return false;
        }
        let is_there = |at: usize| match go {
            Go::Into => true,
            Go::Over => self.depth(at) <= own,
            Go::Out => self.depth(at) < own,
            _ => false,
        };
        let (at, because) = match go {
            Go::Back => {
                let above = if here >= end { u32::MAX } else { own };
                let before = (0..here).rev().find(|&at| self.depth(at) <= above);
                (before.unwrap_or(0), Because::Step)
            }
            Go::ReverseOn => match (0..here).rev().find(|&at| self.is_breakpoint(at)) {
                Some(at) => (at, Because::Breakpoint),
                None => (0, Because::Entry),
            },
            _ => match (here + 1..end).find(|&at| is_there(at) || self.is_breakpoint(at)) {
                Some(at) if is_there(at) => (at, Because::Step),
                Some(at) => (at, Because::Breakpoint),
                None => (end, Because::End),
            },
        };
        self.stand(at, because);
        true
    }

    /// The body of the event that tells where it stands.
    pub(super) fn stopped(&self) -> Value {
        let mut body = json!({ "threadId": 1, "allThreadsStopped": true });
        let failed = self.followed.failed.as_ref().filter(|_| self.because == Because::End);
        body["reason"] = json!(match self.because {
            Because::Entry => "entry",
            Because::Step => "step",
            Because::Breakpoint => "breakpoint",
            Because::End if failed.is_some() => "exception",
            Because::End => "pause",
        });
        match (failed, self.because) {
            (Some(_), _) => {
                body["text"] = json!(self.failure().unwrap_or_default());
                body["description"] = json!("the interpreter stops here");
            }
            (None, Because::End) if self.followed.is_cut => {
                body["description"] = json!("more steps than are kept");
            }
            (None, Because::End) => body["description"] = json!("at the end of the pass"),
            _ => {}
        }
        body
    }

    /// Why the element does not come to its end, if it stands there.
    pub(super) fn failure(&self) -> Option<String> {
        let (why, lines) = self.followed.failed.as_ref().filter(|_| self.position >= self.end())?;
        let place = lines.first().map_or_else(String::new, |&line| format!("{}: ", self.target.of.named_line(line)));
        Some(format!("{place}{why}"))
    }

    fn view(&mut self) -> Result<&View, Refused> {
        let view = match self.view.take() {
            Some(view) => view,
            None => self.target.view(self.position)?,
        };
        Ok(self.view.insert(view))
    }

    /// The file that a number stands for, or a path, as a client opens it.
    fn source(&self, file: usize) -> Value {
        let own = &self.target.of.files[file];
        match self.target.paths.get(file).and_then(Option::as_ref) {
            Some(path) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                json!({ "name": name, "path": path.to_string_lossy() })
            }
            None => json!({ "name": own.name, "sourceReference": file + 1, "origin": "raystep" }),
        }
    }

    /// The functions that it is in.
    pub(super) fn stack(&mut self, first: usize, count: usize) -> Result<Value, Refused> {
        let frames: Vec<(String, usize)> =
            self.view()?.frames.iter().map(|frame| (frame.function.clone(), frame.line)).collect();
        let total = frames.len();
        let count = if count == 0 { usize::MAX } else { count };
        let mut shown = Vec::new();
        for (at, (function, line)) in frames.into_iter().enumerate().skip(first).take(count) {
            let mut frame = json!({ "id": at + 1, "name": function, "line": 0, "column": 0 });
            if let Some(place) = self.target.of.place(line) {
                let text = self.target.of.text_of(place);
                let indent = text.chars().count() - text.trim_start().chars().count();
                frame["source"] = self.source(place.file);
                frame["line"] = json!(place.line);
                frame["column"] = json!(indent + 1);
            }
            shown.push(frame);
        }
        Ok(json!({ "stackFrames": shown, "totalFrames": total }))
    }

    /// The scopes of a frame.
    pub(super) fn scopes(&mut self, frame: usize) -> Result<Value, Refused> {
        let program = self.target.of.variant.kernel.program();
        let view = self.view()?;
        let own = view.frames.get(frame.wrapping_sub(1)).ok_or("there is no such frame")?;
        let all = [
            ("Locals", "locals", own.variables.clone()),
            ("Streams", "streams", streams(view, program)),
            ("Module", "module", view.module.clone()),
            ("Thread", "thread", view.thread.clone()),
        ];
        let scopes = all.into_iter().filter(|(.., variables)| !variables.is_empty()).map(|(name, hint, variables)| {
            let number = self.values.number(&variables);
            json!({ "name": name, "presentationHint": hint, "variablesReference": number, "expensive": false })
        });
        let scopes: Vec<Value> = scopes.collect();
        Ok(json!({ "scopes": scopes }))
    }

    /// The parts of a scope or of a composite.
    pub(super) fn variables(&mut self, number: usize, first: usize, count: usize) -> Result<Value, Refused> {
        let list = self.values.list(number, first, count).ok_or("there are no such variables any more")?;
        Ok(json!({ "variables": list }))
    }

    /// The value of an expression: in the innermost function any, in others that of a variable.
    pub(super) fn evaluate(&mut self, arguments: &Value) -> Result<Value, Refused> {
        let expression = text(arguments, "expression").ok_or("evaluate needs \"expression\"")?;
        let frame = super::reply::whole(arguments, "frameId").unwrap_or(1).saturating_sub(1);
        let program = self.target.of.variant.kernel.program();
        let view = self.view()?;
        let own = view.frames.get(frame).map_or(&[][..], |frame| &frame.variables);
        let streams = streams(view, program);
        let all = own.iter().rev().chain(&view.module).chain(&view.thread);
        let named = streams.iter().find(|stream| stream.name == expression.trim());
        let found = find(all, expression).or(named).cloned();
        let found = match (found, self.followed.steps.get(self.position)) {
            (Some(found), _) => found,
            (None, Some(step)) if frame == 0 => {
                let at = self.target.evaluate(self.position, step.statement as usize, expression)?;
                at.evaluated.ok_or("it has no value")?
            }
            (None, _) => return Err("no variable has this name here".into()),
        };
        Ok(self.values.result(&found))
    }

    /// The text of a file of ours.
    pub(super) fn text(&self, arguments: &Value) -> Result<Value, Refused> {
        let source = arguments.get("source").unwrap_or(arguments);
        let file = self.target.file(source).or_else(|| self.target.file(arguments)).ok_or("there is no such source")?;
        Ok(json!({ "content": self.target.of.files[file].text, "mimeType": "text/wgsl" }))
    }

    /// The files of the kernel.
    pub(super) fn sources(&self) -> Value {
        let all: Vec<Value> = (0..self.target.of.files.len()).map(|file| self.source(file)).collect();
        json!({ "sources": all })
    }

    /// What the thread is called.
    pub(super) fn thread(&self) -> String {
        let [x, y] = self.target.texel;
        let (kernel, pass) = (self.target.of.variant.kernel.name(), self.target.begun.pass.index);
        format!("element {x},{y} of {kernel}, pass {pass}")
    }
}
