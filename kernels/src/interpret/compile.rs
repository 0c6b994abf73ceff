//! Gives every value of a kernel a place, and every condition an index.

mod cost;
mod flow;
mod globals;
mod marked;
mod parts;
mod text;

use std::ops::Range;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Arena, Block, Expression, Function, Handle, Literal, Module, Span, Statement, TypeInner};

use super::InterpretError;
use super::code::{
    Argument, Body, CONSTANT, Cell, Code, Holds, If, Local, MOST_SLOTS, NONE, Op, Site, SiteKind, What, kind, slots,
};
use crate::shader::{Variant, call_of, statement_of};
pub(super) use flow::finds_elements;
use flow::{called, has_jump, skipped};
use globals::globals;
use parts::{evaluated, holds, inner, is_known};
pub(super) use parts::{part, pointee};
pub(super) use text::line_of;
use text::{arguments, last_of};

/// `is_whole`: for all threads of a pass, not for one element.
pub(super) fn compile(
    variant: &Variant,
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
    is_whole: bool,
) -> Result<Code, InterpretError> {
    let mut code = Code::default();
    let Some(point) = module.entry_points.get(entry) else { return Ok(code) };
    globals(variant, module, info.get_entry_point(entry), is_whole, &mut code)?;
    let skipped = skipped(variant, module, info, is_whole);
    let is_skipped = |function: Handle<Function>| skipped.contains(&function);
    let called = called(module, &point.function, &is_skipped);
    let source = &variant.source;
    for (handle, function) in module.functions.iter() {
        if !called.contains(&handle) {
            code.bodies.push(Body::default());
            continue;
        }
        let (info, code) = (&info[handle], &mut code);
        let body = Compiler { source, module, function, info, code, is_whole, is_skipped: &is_skipped };
        let body = body.function(Some(handle))?;
        code.bodies.push(body);
    }
    let (info, function) = (info.get_entry_point(entry), &point.function);
    let body = Compiler { source, module, function, info, code: &mut code, is_whole, is_skipped: &is_skipped };
    let body = body.function(None)?;
    code.entry = code.bodies.len();
    code.bodies.push(body);
    Ok(code)
}

struct Compiler<'a> {
    source: &'a str,
    module: &'a Module,
    function: &'a Function,
    info: &'a FunctionInfo,
    code: &'a mut Code,
    is_whole: bool,
    is_skipped: &'a dyn Fn(Handle<Function>) -> bool,
}

/// A body without its statements.
struct Frame {
    cells: Vec<Cell>,
    /// Place and width of local variables.
    locals: Vec<Local>,
}

impl Compiler<'_> {
    fn unsupported(&self, what: impl Into<String>, span: Span) -> InterpretError {
        let line = span.to_range().map_or(0, |range| line_of(self.source, range.start) + 1);
        InterpretError::Unsupported { what: what.into(), line }
    }

    fn function(mut self, handle: Option<Handle<Function>>) -> Result<Body, InterpretError> {
        let types = &self.module.types;
        let mut frame = 0u32;
        // More than there may be is refused below.
        let mut place = |width: u32| {
            let place = frame;
            frame = frame.saturating_add(width);
            place
        };
        let mut arguments = Vec::new();
        for argument in &self.function.arguments {
            let inner = &types[argument.ty].inner;
            let holds = holds(inner);
            let width = if holds == Holds::Value { slots(types, inner) } else { Some(1) };
            let width = width.ok_or_else(|| self.unsupported("an argument of this type", Span::UNDEFINED))?;
            arguments.push(Argument { place: place(width), width, holds });
        }
        let mut locals = Vec::new();
        for (handle, local) in self.function.local_variables.iter() {
            let span = self.function.local_variables.get_span(handle);
            let width = slots(types, &types[local.ty].inner).filter(|&width| width <= MOST_SLOTS);
            let width = width.ok_or_else(|| self.unsupported("a variable of this size", span))?;
            let init = match local.init {
                Some(init) => self.constant(&self.function.expressions, init)?,
                None => NONE,
            };
            locals.push(Local { place: place(width), width, init });
        }
        let mut cells: Vec<Cell> = Vec::new();
        for (expression, what) in self.function.expressions.iter() {
            let inner = inner(&self.info[expression].ty, &self.module.types);
            if !is_known(inner) {
                return Err(self.unsupported("a type", self.function.expressions.get_span(expression)));
            }
            let width = slots(&self.module.types, inner).unwrap_or(0);
            let rows = if let TypeInner::Matrix { rows, .. } = *inner { rows as u8 } else { 0 };
            let cell = Cell { place: NONE, width, kind: kind(inner), site: NONE, rows };
            let of = |handle: Handle<Expression>| cells.get(handle.index()).copied();
            let cell = match *what {
                _ if width == 0 => cell,
                Expression::Literal(Literal::AbstractInt(_) | Literal::AbstractFloat(_)) => cell,
                Expression::Literal(_)
                | Expression::Constant(_)
                | Expression::Override(_)
                | Expression::ZeroValue(_) => {
                    Cell { place: self.constant(&self.function.expressions, expression)?, ..cell }
                }
                Expression::FunctionArgument(index) => {
                    Cell { place: arguments.get(index as usize).map_or(NONE, |argument| argument.place), ..cell }
                }
                // A part of a value lies in the value.
                Expression::AccessIndex { base, index } if of(base).is_some_and(|base| base.width > 0) => {
                    let first = of(base).map_or(0, |base| base.place);
                    let whole = self.type_of(base);
                    Cell { place: first + self.offset(whole, index), ..cell }
                }
                Expression::Select { condition, .. } => {
                    let is_each = of(condition).is_some_and(|condition| condition.width > 1);
                    let kind = if is_each { SiteKind::SelectEach } else { SiteKind::Select };
                    let site = self.site(kind, self.chosen_by(expression, condition));
                    Cell { place: place(width), site, ..cell }
                }
                _ => Cell { place: place(width), ..cell },
            };
            cells.push(cell);
        }
        if frame > MOST_SLOTS {
            let name = self.function.name.as_deref().unwrap_or("the kernel");
            return Err(self.unsupported(format!("{name} with {frame} words of variables"), Span::UNDEFINED));
        }
        let made = Frame { cells, locals };
        let ops = self.block(&made, &self.function.body)?;
        Ok(Body { handle, cells: made.cells, arguments, locals: made.locals, frame, ops })
    }

    fn type_of(&self, expression: Handle<Expression>) -> &TypeInner {
        inner(&self.info[expression].ty, &self.module.types)
    }

    /// The slot at which a part of a composite begins.
    fn offset(&self, whole: &TypeInner, index: u32) -> u32 {
        part(&self.module.types, whole, index)
    }

    /// The value of an expression without variables, in the constants.
    fn constant(&mut self, arena: &Arena<Expression>, at: Handle<Expression>) -> Result<u32, InterpretError> {
        let value = evaluated(self.module, arena, at).ok_or_else(|| {
            // Its span is of no use if it is not of the function.
            self.unsupported("a constant expression", arena.get_span(at))
        })?;
        let place = self.code.constants.len() as u32;
        self.code.constants.extend(value);
        Ok(CONSTANT | place)
    }

    fn site(&mut self, kind: SiteKind, span: Range<usize>) -> u32 {
        self.code.sites.push(Site { kind, line: line_of(self.source, span.start), span });
        self.code.sites.len() as u32 - 1
    }

    fn span(&self, at: Handle<Expression>) -> Range<usize> {
        self.function.expressions.get_span(at).to_range().unwrap_or_default()
    }

    /// The condition of a `select`, as it stands there.
    fn chosen_by(&self, select: Handle<Expression>, condition: Handle<Expression>) -> Range<usize> {
        let inside = arguments(self.source, self.span(select).start);
        inside.and_then(|inside| last_of(self.source, inside)).unwrap_or_else(|| self.span(condition))
    }

    fn block(&mut self, frame: &Frame, block: &Block) -> Result<Vec<Op>, InterpretError> {
        block.span_iter().map(|(statement, span)| self.statement(frame, statement, *span)).collect()
    }

    fn statement(&mut self, frame: &Frame, statement: &Statement, span: Span) -> Result<Op, InterpretError> {
        let whole = span.to_range().unwrap_or_default();
        let (what, span) = match *statement {
            Statement::Emit(ref range) => {
                let is_run = |&at: &Handle<Expression>| {
                    let is_part = match self.function.expressions[at] {
                        Expression::AccessIndex { base, .. } => frame.cells[base.index()].width > 0,
                        _ => false,
                    };
                    frame.cells[at.index()].width > 0 && !is_part
                };
                (What::Emit(range.clone().filter(is_run).collect()), whole)
            }
            Statement::Block(ref block) => (What::Block(self.block(frame, block)?), 0..0),
            Statement::If { condition, ref accept, ref reject } => {
                self.branch(frame, condition, accept, reject, whole)?
            }
            Statement::Switch { selector, ref cases } => {
                let site = self.site(SiteKind::Switch, self.span(selector));
                let mut all = Vec::new();
                for case in cases {
                    let value = match case.value {
                        naga::SwitchValue::I32(value) => Some(value.cast_unsigned()),
                        naga::SwitchValue::U32(value) => Some(value),
                        naga::SwitchValue::Default => None,
                    };
                    all.push((value, self.block(frame, &case.body)?, case.fall_through));
                }
                (What::Switch { site, selector, cases: all }, self.head(whole))
            }
            Statement::Loop { ref body, ref continuing, break_if } => {
                let body = self.block(frame, body)?;
                let continuing = self.block(frame, continuing)?;
                let break_if = break_if.map(|condition| (condition, self.site(SiteKind::If, self.span(condition))));
                (What::Loop { body, continuing, break_if }, self.head(whole))
            }
            Statement::Break => (What::Break, whole),
            Statement::Continue => (What::Continue, whole),
            Statement::Return { value } => (What::Return(value), whole),
            Statement::Store { pointer, value } => {
                let is_hidden = self.hidden(pointer).is_some();
                (What::Store { pointer, value }, if is_hidden { 0..0 } else { whole })
            }
            Statement::ImageStore { image, coordinate, array_index: Some(layer), value } => {
                (What::ImageStore { image, texel: coordinate, layer, value }, whole)
            }
            Statement::Call { function, ref arguments, result } => {
                let name = self.module.functions[function].name.as_deref().unwrap_or_default();
                let what = match result {
                    _ if let Some(call) = call_of(name) => self.marked(frame, call, arguments, result),
                    None if let Some((is_assertion, index)) = statement_of(name)
                        && let &[value] = arguments.as_slice() =>
                    {
                        if is_assertion {
                            What::Assertion(index, value)
                        } else {
                            What::Note(index, value)
                        }
                    }
                    Some(result) if (self.is_skipped)(function) => What::Texel(result),
                    // The last argument is the state's tag.
                    None if (self.is_skipped)(function) => {
                        arguments.last().map_or(What::Nothing, |&tag| What::Book(tag))
                    }
                    _ => What::Call { function: function.index(), arguments: arguments.clone(), result },
                };
                (what, whole)
            }
            Statement::ControlBarrier(which) if self.is_whole && !which.contains(naga::Barrier::SUB_GROUP) => {
                self.code.barriers |= which;
                (What::Barrier(which), whole)
            }
            Statement::WorkGroupUniformLoad { pointer, result } if self.is_whole => {
                self.code.barriers |= naga::Barrier::WORK_GROUP;
                (What::UniformLoad { pointer, result }, whole)
            }
            Statement::Atomic { pointer, fun, value, result } if self.is_whole => {
                (What::Atomic { pointer, fun, value, result }, whole)
            }
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => (What::Unsupported("a barrier"), whole),
            Statement::Atomic { .. } => (What::Unsupported("an atomic operation"), whole),
            _ => (What::Unsupported("a statement"), whole),
        };
        self.code.statements.push(span);
        let statement = self.code.statements.len() as u32 - 1;
        self.cost(frame, &what, statement);
        Ok(Op { statement, what })
    }

    fn branch(
        &mut self,
        frame: &Frame,
        condition: Handle<Expression>,
        accept: &Block,
        reject: &Block,
        whole: Range<usize>,
    ) -> Result<(What, Range<usize>), InterpretError> {
        let of_condition = self.span(condition);
        let result = match (accept.last(), &reject[..]) {
            (Some(&Statement::Store { pointer, .. }), [Statement::Store { pointer: other, .. }])
                if pointer == *other =>
            {
                self.hidden(pointer)
            }
            _ => None,
        };
        let (kind, span) = match (&accept[..], &reject[..]) {
            // The condition of `||` is negated; it is the left side that is named.
            _ if result.is_some() => {
                let left = match self.function.expressions[condition] {
                    Expression::Unary { expr, .. } if of_condition == whole => expr,
                    _ => condition,
                };
                (SiteKind::ShortCircuit, self.span(left))
            }
            ([], [Statement::Break]) => (SiteKind::Loop, of_condition),
            // A condition may have been computed before, by `let`: here it is as it stands in the statement.
            _ => (SiteKind::If, arguments(self.source, whole.start).unwrap_or(of_condition)),
        };
        let head = if kind == SiteKind::If { whole.start.min(span.end)..span.end } else { span.clone() };
        let site = self.site(kind, span);
        let (accept, reject) = (self.block(frame, accept)?, self.block(frame, reject)?);
        let has_jump = has_jump(&accept, false) || has_jump(&reject, false);
        let mut writes = Vec::new();
        self.writes(frame, &accept, &mut writes);
        self.writes(frame, &reject, &mut writes);
        writes.sort_unstable();
        writes.dedup();
        Ok((What::If(Box::new(If { site, condition, accept, reject, has_jump, writes, result })), head))
    }

    /// The variable without a name that a pointer is to, if it is one: the result of `&&` or `||`.
    fn hidden(&self, pointer: Handle<Expression>) -> Option<Handle<naga::LocalVariable>> {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(local) if self.function.local_variables[local].name.is_none() => Some(local),
            _ => None,
        }
    }

    /// From a statement's first byte to the brace that opens its block.
    fn head(&self, whole: Range<usize>) -> Range<usize> {
        let text = self.source.get(whole.clone()).unwrap_or_default();
        whole.start..whole.start + text.find('{').unwrap_or(0)
    }

    /// The slots of the frame that statements may write.
    fn writes(&self, frame: &Frame, ops: &[Op], found: &mut Vec<(u32, u32)>) {
        for op in ops {
            match &op.what {
                What::Store { pointer, .. } => found.extend(self.written(frame, *pointer)),
                What::Block(ops) => self.writes(frame, ops, found),
                What::If(branch) => {
                    self.writes(frame, &branch.accept, found);
                    self.writes(frame, &branch.reject, found);
                }
                What::Switch { cases, .. } => cases.iter().for_each(|(_, ops, _)| self.writes(frame, ops, found)),
                What::Loop { body, continuing, .. } => {
                    self.writes(frame, body, found);
                    self.writes(frame, continuing, found);
                }
                _ => {}
            }
        }
    }

    /// The slots that a pointer may be to; `None` outside of the frame.
    fn written(&self, frame: &Frame, pointer: Handle<Expression>) -> Option<(u32, u32)> {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(local) => {
                let local = frame.locals.get(local.index())?;
                Some((local.place, local.width))
            }
            Expression::Access { base, .. } => self.written(frame, base),
            Expression::AccessIndex { base, index } => {
                let (place, width) = self.written(frame, base)?;
                let types = &self.module.types;
                let whole = pointee(types, self.type_of(base))?;
                // Behind an index that is not known before, all of it.
                let all = slots(types, &whole)?;
                if all != width {
                    return Some((place, width));
                }
                let part = pointee(types, self.type_of(pointer)).and_then(|inner| slots(types, &inner))?;
                Some((place + self.offset(&whole, index), part))
            }
            _ => None,
        }
    }
}
