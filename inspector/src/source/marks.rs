//! Which lines of a kernel's file ran: walks through its blocks like the kernel, with the table of conditions instead
//! of values.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use raystep_kernels::Kernel;
use raystep_kernels::compose::holds;
use raystep_kernels::options::features::Features;

use super::Mark;
use super::block::{Block, Choice, Function, Kind, Statement, functions};
use super::conditions::Case;
use super::words::words;

/// Whether the ray reached a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    No,
    Maybe,
    Yes,
}

impl Reach {
    fn and(self, condition: Option<bool>) -> Self {
        match (self, condition) {
            (Self::No, _) | (_, Some(false)) => Self::No,
            (reach, Some(true)) => reach,
            (_, None) => Self::Maybe,
        }
    }

    fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Yes, _) | (_, Self::Yes) => Self::Yes,
            (Self::No, Self::No) => Self::No,
            _ => Self::Maybe,
        }
    }

    fn mark(self) -> Mark {
        match self {
            Self::No => Mark::NotRun,
            Self::Maybe => Mark::Unknown,
            Self::Yes => Mark::Run,
        }
    }
}

/// How control leaves a block.
#[derive(Clone, Copy)]
struct Left {
    /// At its end.
    falls: Reach,
    /// By a jump or return that was, or may have been, reached.
    has_jumped: bool,
    /// By a return that was, or may have been, reached.
    has_returned: bool,
}

/// A mark for every line. Without a case, only lines that options omit are marked.
pub(super) fn marks(kernel: Kernel, text: &str, features: &Features, case: Option<&Case>) -> Vec<Mark> {
    let count = text.split('\n').count();
    let mut walker =
        Walker { kernel, case, options: features.list(), marks: vec![Mark::Plain; count], calls: BTreeMap::new() };
    let Some(file) = functions(text, &words(text)) else {
        return vec![if case.is_some() { Mark::Unknown } else { Mark::Plain }; count];
    };
    let mut before = None;
    for (choice, lines) in &file.declarations {
        if !walker.is_in(choice.as_ref(), &mut before) {
            walker.set(lines, Mark::LeftOut);
        }
    }
    let mut before = None;
    let is_in: Vec<bool> = file.functions.iter().map(|f| walker.is_in(f.choice.as_ref(), &mut before)).collect();
    // Callees are declared before their callers.
    walker.calls.insert(kernel.name().to_owned(), Reach::Yes);
    for (function, is_in) in file.functions.iter().zip(is_in).rev() {
        match is_in {
            true => walker.function(function),
            false => walker.set(&function.lines, Mark::LeftOut),
        }
    }
    let lines = text.split('\n').map(str::trim);
    let is_bare = |line: &str| line.is_empty() || line.starts_with("//");
    walker.marks.iter().zip(lines).map(|(&mark, line)| if is_bare(line) { Mark::Plain } else { mark }).collect()
}

struct Walker<'a> {
    kernel: Kernel,
    case: Option<&'a Case<'a>>,
    options: Vec<(&'static str, bool)>,
    marks: Vec<Mark>,
    /// Whether each function was called.
    calls: BTreeMap<String, Reach>,
}

impl Walker<'_> {
    /// Whether the options include a choice; `before` is the preceding `@if`, for `@else`.
    fn is_in(&self, choice: Option<&Choice>, before: &mut Option<bool>) -> bool {
        let is_in = match choice {
            None => return true,
            Some(Choice::If(condition)) => {
                let option = |name: &str| self.options.iter().find(|o| o.0 == name).map(|o| o.1);
                holds(condition, &option).unwrap_or(false)
            }
            Some(Choice::Else) => before.is_some_and(|taken| !taken),
        };
        *before = Some(is_in);
        is_in
    }

    fn set(&mut self, lines: &RangeInclusive<usize>, mark: Mark) {
        // Without a pass, nothing ran.
        if self.case.is_some() || mark == Mark::LeftOut {
            self.marks[lines.clone()].fill(mark);
        }
    }

    fn function(&mut self, function: &Function) {
        let reach = self.calls.get(&function.name).copied().unwrap_or(Reach::No);
        self.set(&function.lines, reach.mark());
        self.block(&function.body, reach);
    }

    fn called(&mut self, names: &[String], reach: Reach) {
        for name in names {
            let so_far = self.calls.entry(name.clone()).or_insert(Reach::No);
            *so_far = so_far.or(reach);
        }
    }

    fn block(&mut self, block: &Block, mut reach: Reach) -> Left {
        let (first, last) = (*block.lines.start(), *block.lines.end());
        self.set(&(first + 1..=last), reach.mark());
        let mut left = Left { falls: reach, has_jumped: false, has_returned: false };
        let mut before = None;
        for statement in &block.statements {
            if !self.is_in(statement.choice.as_ref(), &mut before) {
                self.set(&statement.lines, Mark::LeftOut);
                continue;
            }
            let after = self.statement(statement, reach);
            reach = after.falls;
            left.has_jumped |= after.has_jumped;
            left.has_returned |= after.has_returned;
        }
        left.falls = reach;
        left
    }

    fn statement(&mut self, statement: &Statement, reach: Reach) -> Left {
        self.set(&statement.lines, reach.mark());
        self.called(&statement.calls, reach);
        let is_reached = reach != Reach::No;
        let goes_on = Left { falls: reach, has_jumped: false, has_returned: false };
        match &statement.kind {
            Kind::Plain => goes_on,
            Kind::Return => Left { falls: Reach::No, has_jumped: is_reached, has_returned: is_reached },
            Kind::Jump => Left { falls: Reach::No, has_jumped: is_reached, has_returned: false },
            Kind::Block(block) => self.block(block, reach),
            Kind::If(arms) => self.branch(arms, reach),
            Kind::Loop(head, body) => {
                let condition = self.held(head);
                let inside = self.block(body, reach.and(condition));
                let falls = if inside.has_returned { reach.and(None) } else { reach };
                Left { falls, has_jumped: inside.has_returned, has_returned: inside.has_returned }
            }
        }
    }

    fn branch(&mut self, arms: &[(Option<String>, Block)], reach: Reach) -> Left {
        let mut rest = reach;
        let mut left = Left { falls: Reach::No, has_jumped: false, has_returned: false };
        for (condition, block) in arms {
            // An else without a condition takes the remaining cases.
            let held = condition.as_ref().map_or(Some(true), |text| self.held(text));
            let arm = rest.and(held);
            let first = *block.lines.start();
            // The line of an else belongs to its own branch.
            if !std::ptr::eq(block, &arms[0].1) {
                self.set(&(first..=first), arm.mark());
            }
            let after = self.block(block, arm);
            left.falls = left.falls.or(after.falls);
            left.has_jumped |= after.has_jumped;
            left.has_returned |= after.has_returned;
            rest = rest.and(held.map(|held| !held));
        }
        left.falls = left.falls.or(rest);
        if !left.has_jumped {
            left.falls = reach;
        }
        left
    }

    fn held(&self, text: &str) -> Option<bool> {
        self.case.and_then(|case| case.held(self.kernel, text))
    }
}
