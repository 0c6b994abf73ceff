//! Reads the lines of a lesson. The text is untrusted: it may be wrong in any way, and nothing panics.

use super::command::{self, Line};
use super::error::Wrong;
use super::prose::{Paragraph, paragraph};
use super::question::Question;
use super::{Action, Lesson, LessonError, MOST_BYTES, MOST_COMMANDS, MOST_STEPS, Name, Step};

/// The fence of a block of commands.
const BLOCK: &str = "```raystep";
const FENCE: &str = "```";

pub(super) fn lesson(file: &str, text: &str) -> Result<Lesson, LessonError> {
    let at = |(line, wrong)| LessonError { file: file.to_owned(), line, wrong };
    let (title, about, steps) = sections(text).map_err(at)?;
    let lesson = Lesson { file: file.to_owned(), title, about, steps };
    check(&lesson).map_err(at)?;
    Ok(lesson)
}

type Mistake = (usize, Wrong);

/// The title, what is before the first step, and the steps.
fn sections(text: &str) -> Result<(String, Vec<Paragraph>, Vec<Step>), Mistake> {
    if text.len() > MOST_BYTES {
        return Err((1, Wrong::TooLong(text.len())));
    }
    let mut title = None;
    let (mut about, mut steps): (Vec<Paragraph>, Vec<Step>) = (Vec::new(), Vec::new());
    let mut pending: Pending<'_> = Pending::default();
    let mut lines = text.strip_prefix('\u{feff}').unwrap_or(text).lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
    let mut last = 1;
    while let Some((number, line)) = lines.next() {
        last = number;
        let is_break = line.is_empty() || line.starts_with('#') || line.starts_with(FENCE) || line.starts_with("- ");
        if is_break {
            pending.end(texts(&mut about, &mut steps))?;
        }
        if line.is_empty() {
            continue;
        }
        if title.is_none() {
            let words = line.strip_prefix("# ").map(str::trim).filter(|words| !words.is_empty());
            title = Some(words.ok_or((number, Wrong::NoTitle))?.to_owned());
        } else if let Some(words) = line.strip_prefix("## ") {
            if steps.len() == MOST_STEPS {
                return Err((number, Wrong::TooManySteps));
            }
            steps.push(Step { line: number, title: words.trim().to_owned(), ..Step::default() });
        } else if line.starts_with("# ") {
            return Err((number, Wrong::SecondTitle));
        } else if line.starts_with('#') {
            return Err((number, Wrong::Heading));
        } else if line.starts_with(FENCE) {
            if line != BLOCK {
                return Err((number, Wrong::Block(line.chars().take(40).collect())));
            }
            let step = steps.last_mut().ok_or((number, Wrong::NoStep))?;
            block(step, number, &mut lines)?;
        } else {
            pending.is_item |= line.starts_with("- ");
            pending.lines.push((number, line.strip_prefix("- ").unwrap_or(line)));
        }
    }
    pending.end(texts(&mut about, &mut steps))?;
    let title = title.ok_or((1, Wrong::NoTitle))?;
    if steps.is_empty() {
        return Err((last, Wrong::NoSteps));
    }
    Ok((title, about, steps))
}

/// Where a paragraph belongs.
fn texts<'a>(about: &'a mut Vec<Paragraph>, steps: &'a mut [Step]) -> &'a mut Vec<Paragraph> {
    steps.last_mut().map_or(about, |step| &mut step.last_mut().text)
}

/// The lines of a paragraph so far.
#[derive(Default)]
struct Pending<'a> {
    lines: Vec<(usize, &'a str)>,
    is_item: bool,
}

impl Pending<'_> {
    fn end(&mut self, texts: &mut Vec<Paragraph>) -> Result<(), Mistake> {
        let Self { lines, is_item } = std::mem::take(self);
        if !lines.is_empty() {
            texts.push(paragraph(&lines, is_item)?);
        }
        Ok(())
    }
}

/// The commands up to the end of a block that begins in line `first`.
fn block<'a>(step: &mut Step, first: usize, lines: &mut impl Iterator<Item = (usize, &'a str)>) -> Result<(), Mistake> {
    let mut question = None;
    for (number, line) in lines {
        if line == FENCE {
            let check = |question: &Question| question.check().map_err(|wrong| (question.line, wrong));
            question.as_ref().map_or(Ok(()), check)?;
            step.question = question.or(step.question.take());
            return Ok(());
        }
        if line.is_empty() {
            continue;
        }
        let asked = question.as_ref().map_or(0, |question| 1 + question.choices.len());
        if step.commands() + asked == MOST_COMMANDS {
            return Err((number, Wrong::TooManyCommands));
        }
        add(step, &mut question, number, line).map_err(|wrong| (number, wrong))?;
    }
    Err((first, Wrong::OpenBlock))
}

/// Adds a line of a block.
fn add(step: &mut Step, question: &mut Option<Question>, number: usize, line: &str) -> Result<(), Wrong> {
    match (command::line(number, line)?, question) {
        (Line::Action(action), _) => step.last_mut().actions.push((number, action)),
        (Line::Expect(expect), _) => step.last_mut().expects.push((number, expect)),
        (Line::Question(new), question @ None) if step.question.is_none() => *question = Some(new),
        (Line::Question(_), _) => return Err(Wrong::Argument("question", "a step asks one question".into())),
        (Line::Choice(choice), Some(question)) => question.add(choice)?,
        (Line::Choice(_), None) => {
            return Err(Wrong::Argument("choice", "ask first: add 'question \"…\"' above it in this block".into()));
        }
    }
    Ok(())
}

/// What depends on several lines: that a scene is open, and that all names are known.
fn check(lesson: &Lesson) -> Result<(), Mistake> {
    let mut measured: Vec<&str> = Vec::new();
    let mut has_stream = false;
    let is_open = |action: &Action| matches!(action, Action::Open(_));
    let first = lesson.steps.first();
    if let Some(step) = first
        && !step.first.actions.first().is_some_and(|(_, action)| is_open(action))
    {
        return Err((step.first.actions.first().map_or(step.line, |(line, _)| *line), Wrong::NothingOpen));
    }
    for step in &lesson.steps {
        let actions = || step.sections().into_iter().flat_map(|section| &section.actions);
        for (line, action) in actions() {
            let fail = |wrong| Err((*line, wrong));
            match action {
                Action::Open(link) => has_stream = link.stream.is_some(),
                Action::Stream(_) => has_stream = true,
                Action::Zoom(..) if !has_stream => {
                    return fail(Wrong::Argument("zoom", "name the stream first: add 'stream color'".into()));
                }
                Action::Measure(name, _) if measured.contains(&name.as_str()) => {
                    return fail(Wrong::Argument("measure", format!("{name} was measured already")));
                }
                Action::Measure(name, _) => measured.push(name),
                Action::Bars(names) => {
                    if let Some(unknown) = names.iter().find(|name| !measured.contains(&name.as_str())) {
                        return fail(Wrong::NotMeasured(unknown.clone()));
                    }
                }
                _ => {}
            }
        }
        let has_candidates = actions().any(|(_, action)| *action == Action::Candidates);
        for (line, expression) in lesson.expressions(step) {
            for name in expression.names() {
                match name {
                    Name::Measured(of, _) if !measured.contains(&of.as_str()) => {
                        return Err((line, Wrong::NotMeasured(of.clone())));
                    }
                    name if name.is_of_tie() && !has_candidates => {
                        return Err((line, Wrong::NoCandidates(name.to_string())));
                    }
                    _ => {}
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
