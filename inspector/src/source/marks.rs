//! Which lines of a kernel's file ran: its blocks are gone through as the kernel goes through them, with the table of
//! conditions in place of values.

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};

use raystep_kernels::Kernel;
use raystep_kernels::compose::left_out;
use raystep_kernels::options::features::Features;

use super::Mark;
use super::block::{Block, Function, Kind, Statement, functions};
use super::words::words;
use raystep_kernels::programs::closest_hit::conditions::Case;

/// Whether the ray came to a place.
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

/// How a block is left.
#[derive(Clone, Copy)]
struct Left {
    /// By its end.
    falls: Reach,
    /// By a jump or return that was or may have been reached.
    has_jumped: bool,
    /// By a return that was or may have been reached.
    has_returned: bool,
}

/// A mark for every line. Without a case, only what options leave out is marked.
pub(super) fn marks(kernel: Kernel, text: &str, features: &Features, case: Option<&Case>) -> Vec<Mark> {
    let count = text.split('\n').count();
    let options = features.list();
    let option = |name: &str| options.iter().find(|o| o.0 == name).map(|o| o.1);
    let (Some(file), Ok(left_out)) = (functions(text, &words(text)), left_out(kernel.name(), text, &option)) else {
        return vec![if case.is_some() { Mark::Unknown } else { Mark::Plain }; count];
    };
    let mut walker = Walker { kernel, case, left_out, marks: vec![Mark::Plain; count], calls: BTreeMap::new() };
    for (start, lines) in &file.declarations {
        if walker.is_left_out(*start) {
            walker.set(lines, Mark::LeftOut);
        }
    }
    // What is called is declared before what calls it.
    walker.calls.insert(kernel.name().to_owned(), Reach::Yes);
    for function in file.functions.iter().rev() {
        match walker.is_left_out(function.start) {
            true => walker.set(&function.lines, Mark::LeftOut),
            false => walker.function(function),
        }
    }
    let lines = text.split('\n').map(str::trim);
    let is_bare = |line: &str| line.is_empty() || line.starts_with("//");
    walker.marks.iter().zip(lines).map(|(&mark, line)| if is_bare(line) { Mark::Plain } else { mark }).collect()
}

struct Walker<'a> {
    kernel: Kernel,
    case: Option<&'a Case<'a>>,
    /// Bytes that the options leave out.
    left_out: Vec<Range<usize>>,
    marks: Vec<Mark>,
    /// Whether each function was called.
    calls: BTreeMap<String, Reach>,
}

impl Walker<'_> {
    /// Whether the options leave out what begins at a byte.
    fn is_left_out(&self, start: usize) -> bool {
        self.left_out.iter().any(|range| range.contains(&start))
    }

    fn set(&mut self, lines: &RangeInclusive<usize>, mark: Mark) {
        // Without a pass, nothing has run.
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
        for statement in &block.statements {
            if self.is_left_out(statement.start) {
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
            // An else without a condition takes what the others leave.
            let held = condition.as_ref().map_or(Some(true), |text| self.held(text));
            let arm = rest.and(held);
            let first = *block.lines.start();
            // The line of an else belongs to its own arm.
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

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;

    use super::*;

    #[test]
    fn of_several_arms_all_but_the_first_that_holds_are_left_out() {
        let text = "@if(grid) const A = 1u;\n@else @if(bvh) const A = 2u;\n@else const A = 3u;\n\
                    fn setup() {\n    @if(grid) x();\n    @else @if(bvh) y();\n    @else z();\n}\n";
        for (grid, bvh, kept) in [(true, true, 0), (true, false, 0), (false, true, 1), (false, false, 2)] {
            let features = Features { grid, bvh, ..Features::default() };
            let marks = marks(kernels::SETUP, text, &features, None);
            let left_out: Vec<usize> = (0..marks.len()).filter(|&line| marks[line] == Mark::LeftOut).collect();
            let expected: Vec<usize> = [0, 1, 2, 4, 5, 6].into_iter().filter(|line| line % 4 != kept).collect();
            assert_eq!(left_out, expected, "{grid} {bvh}");
        }
    }
}
