//! The functions of a kernel's file and their blocks: as much of the grammar of WGSL, and of WESL's `@if`, as is needed
//! to assign lines to branches.

use std::ops::RangeInclusive;

use super::words::{Class, Word};

/// A parsed file.
pub(super) struct File {
    /// In the file's order.
    pub(super) functions: Vec<Function>,
    /// Declarations that an option may omit: the option, and their lines.
    pub(super) declarations: Vec<(Option<Choice>, RangeInclusive<usize>)>,
    /// Every condition and loop head, in the file's order.
    pub(super) conditions: Vec<String>,
}

/// `@if(…)` with its expression, or the `@else` of the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    If(String),
    Else,
}

pub(super) struct Function {
    pub(super) name: String,
    pub(super) choice: Option<Choice>,
    /// From its attributes to its closing brace; lines are counted from 0.
    pub(super) lines: RangeInclusive<usize>,
    pub(super) body: Block,
}

pub(super) struct Block {
    pub(super) statements: Vec<Statement>,
    pub(super) lines: RangeInclusive<usize>,
}

pub(super) struct Statement {
    pub(super) choice: Option<Choice>,
    pub(super) lines: RangeInclusive<usize>,
    /// Functions that it calls directly, outside its blocks.
    pub(super) calls: Vec<String>,
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    /// Continues with the next statement.
    Plain,
    Return,
    /// `break`, `continue`
    Jump,
    Block(Block),
    /// Arms with their conditions; the last may be without.
    If(Vec<(Option<String>, Block)>),
    /// Head and body.
    Loop(String, Block),
}

/// Parses a file; `None` if it cannot be parsed.
pub(super) fn functions(text: &str, words: &[Word]) -> Option<File> {
    let words = words.iter().filter(|w| w.class != Class::Comment).cloned().collect();
    let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let mut parser = Parser { text, words, at: 0, line_starts, conditions: Vec::new() };
    let (mut functions, mut declarations) = (Vec::new(), Vec::new());
    while parser.at < parser.words.len() {
        let start = parser.line();
        let choice = parser.attributes();
        if parser.word() == "fn" {
            parser.at += 1;
            let name = parser.word().to_owned();
            while parser.word() != "{" {
                parser.next()?;
            }
            let body = parser.block()?;
            functions.push(Function { name, choice, lines: start..=*body.lines.end(), body });
        } else {
            parser.declaration()?;
            declarations.push((choice, start..=parser.last_line()));
        }
    }
    Some(File { functions, declarations, conditions: parser.conditions })
}

struct Parser<'a> {
    text: &'a str,
    words: Vec<Word>,
    at: usize,
    line_starts: Vec<usize>,
    conditions: Vec<String>,
}

impl Parser<'_> {
    /// The current word; empty at the end.
    fn word(&self) -> &str {
        self.words.get(self.at).map_or("", |w| &self.text[w.range.clone()])
    }

    fn next(&mut self) -> Option<()> {
        self.at += 1;
        (self.at < self.words.len()).then_some(())
    }

    fn line_of(&self, word: usize) -> usize {
        let at = self.words.get(word).map_or(self.text.len(), |w| w.range.start);
        self.line_starts.partition_point(|&start| start <= at).saturating_sub(1)
    }

    fn line(&self) -> usize {
        self.line_of(self.at)
    }

    /// The line of the previous word.
    fn last_line(&self) -> usize {
        self.line_of(self.at.saturating_sub(1))
    }

    /// Skips attributes; returns the option among them.
    fn attributes(&mut self) -> Option<Choice> {
        let mut choice = None;
        while self.word().starts_with('@') {
            let condition = self.word().strip_prefix("@if(").and_then(|rest| rest.strip_suffix(')'));
            choice = match (condition, self.word()) {
                (Some(condition), _) => Some(Choice::If(condition.to_owned())),
                (None, "@else") => Some(Choice::Else),
                _ => choice,
            };
            self.at += 1;
        }
        choice
    }

    /// Skips to after the semicolon, or the brace of a struct.
    fn declaration(&mut self) -> Option<()> {
        let is_struct = self.word() == "struct";
        let mut depth = 0usize;
        loop {
            match self.word() {
                "" => return None,
                "{" => depth += 1,
                "}" => {
                    depth = depth.checked_sub(1)?;
                    if depth == 0 && is_struct {
                        self.at += 1;
                        return Some(());
                    }
                }
                ";" if depth == 0 => {
                    self.at += 1;
                    return Some(());
                }
                _ => {}
            }
            self.at += 1;
        }
    }

    fn block(&mut self) -> Option<Block> {
        let start = self.line();
        if self.word() != "{" {
            return None;
        }
        self.next()?;
        let mut statements = Vec::new();
        while self.word() != "}" {
            statements.push(self.statement()?);
        }
        let lines = start..=self.line();
        self.at += 1;
        Some(Block { statements, lines })
    }

    fn statement(&mut self) -> Option<Statement> {
        let start = self.line();
        let choice = self.attributes();
        let (kind, calls) = match self.word() {
            "{" => (Kind::Block(self.block()?), Vec::new()),
            "if" => self.branch()?,
            "for" | "while" | "loop" | "switch" => {
                self.next()?;
                let (head, calls) = if self.word() == "(" { self.head()? } else { Default::default() };
                self.conditions.push(head.clone());
                (Kind::Loop(head, self.block()?), calls)
            }
            first => {
                let kind = match first {
                    "return" => Kind::Return,
                    "break" | "continue" => Kind::Jump,
                    _ => Kind::Plain,
                };
                let from = self.at;
                while self.word() != ";" {
                    // A block here would be an unknown kind of statement.
                    if matches!(self.word(), "{" | "}") {
                        return None;
                    }
                    self.next()?;
                }
                let calls = self.calls(from);
                self.at += 1;
                (kind, calls)
            }
        };
        Some(Statement { choice, lines: start..=self.last_line(), calls, kind })
    }

    fn branch(&mut self) -> Option<(Kind, Vec<String>)> {
        let (mut arms, mut all_calls) = (Vec::new(), Vec::new());
        loop {
            self.next()?;
            let (condition, calls) = self.head()?;
            all_calls.extend(calls);
            self.conditions.push(condition.clone());
            arms.push((Some(condition), self.block()?));
            if self.word() != "else" {
                break;
            }
            self.next()?;
            if self.word() != "if" {
                arms.push((None, self.block()?));
                break;
            }
        }
        Some((Kind::If(arms), all_calls))
    }

    /// The text in parentheses, and the functions it calls.
    fn head(&mut self) -> Option<(String, Vec<String>)> {
        if self.word() != "(" {
            return None;
        }
        let open = self.at;
        let mut depth = 1usize;
        while depth > 0 {
            self.next()?;
            match self.word() {
                "(" => depth += 1,
                ")" => depth -= 1,
                _ => {}
            }
        }
        let inside = &self.text[self.words[open].range.end..self.words[self.at].range.start];
        let head = inside.split_whitespace().collect::<Vec<_>>().join(" ");
        let calls = self.calls(open);
        self.at += 1;
        Some((head, calls))
    }

    /// Functions called between a word and the current one.
    fn calls(&self, from: usize) -> Vec<String> {
        let words = self.words[from..self.at].iter().filter(|w| w.class == Class::Function);
        words.map(|w| self.text[w.range.clone()].to_owned()).collect()
    }
}
