//! Evaluates expressions.

use naga::{Expression, Handle, RelationalFunction, UnaryOperator};

use super::InterpretError;
use super::code::{CONSTANT, Kind, Slot};
use super::machine::{Frame, Machine};
use super::operators::{binary, comparison, convert, math};
use super::recording::{Comparison, KNOWN, Value};
use super::vectors::{is_of_vectors, of_vectors};

impl<'a> Machine<'a> {
    pub(super) fn evaluate(&mut self, frame: &Frame<'a>, at: Handle<Expression>) -> Result<(), InterpretError> {
        let cell = frame.body.cells[at.index()];
        let to = frame.base + cell.place as usize;
        let lanes = 0..cell.width;
        let unsupported = |what: &str| {
            let span = frame.function.expressions.get_span(at).to_range();
            let line = span.map_or(0, |span| super::compile::line_of(&self.kernel.source, span.start) + 1);
            InterpretError::Unsupported { what: what.into(), line }
        };
        match frame.function.expressions[at] {
            Expression::Binary { op, left, right } => {
                let kind = frame.body.cells[left.index()].kind;
                for lane in lanes {
                    let sides = [self.get(frame, left, lane), self.get(frame, right, lane)];
                    let mut value = binary(op, kind, sides).ok_or_else(|| unsupported("an operator"))?;
                    if self.recording.is_some() {
                        value.from = self.join(sides[0].from, sides[1].from);
                        if let Some(operator) = comparison(op).filter(|_| kind != Kind::Bool) {
                            value.from = self.compared(frame, [left, right], operator, lane, cell.width, value, sides);
                        } else if kind.is_float() && !f32::from_bits(value.bits).is_finite() {
                            value.from = self.computed(frame, at, &[(left, sides[0]), (right, sides[1])], value);
                        }
                    }
                    self.stack[to + lane as usize] = value;
                }
            }
            Expression::Unary { op, expr } => {
                let kind = frame.body.cells[expr.index()].kind;
                for lane in lanes {
                    let value = self.get(frame, expr, lane);
                    self.stack[to + lane as usize] = unary(op, kind, value);
                }
            }
            Expression::Math { fun, arg, arg1, .. } if is_of_vectors(fun) => {
                let of = frame.body.cells[arg.index()];
                let (kind, width) = (of.kind, of.width.min(4));
                let mut from = KNOWN;
                let sides = [Some(arg), arg1].map(|side| {
                    let mut slots = [Slot::default(); 4];
                    for (lane, slot) in (0..width).zip(&mut slots) {
                        *slot = side.map_or(Slot::default(), |side| self.get(frame, side, lane));
                        from = self.join(from, slot.from);
                    }
                    slots
                });
                let results = of_vectors(fun, kind, width as usize, sides).ok_or_else(|| unsupported("a function"))?;
                for (lane, result) in lanes.zip(results) {
                    self.stack[to + lane as usize] = Slot { from, ..result };
                }
            }
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let kind = frame.body.cells[arg.index()].kind;
                for lane in lanes {
                    let first = self.get(frame, arg, lane);
                    let mut values = [first; 3];
                    for (value, arg) in values[1..].iter_mut().zip([arg1, arg2]) {
                        // The last argument of mix may be one number for all components.
                        let of = |arg: Handle<Expression>| lane.min(frame.body.cells[arg.index()].width - 1);
                        *value = arg.map_or(Slot::default(), |arg| self.get(frame, arg, of(arg)));
                    }
                    let mut value = math(fun, kind, values).ok_or_else(|| unsupported("a function"))?;
                    let from = self.join(values[0].from, values[1].from);
                    value.from = self.join(from, values[2].from);
                    let is_float = cell.kind.is_float() && self.recording.is_some();
                    if is_float && !f32::from_bits(value.bits).is_finite() {
                        let handles = [Some(arg), arg1, arg2].into_iter().zip(values);
                        let operands: Vec<_> = handles.filter_map(|(at, value)| Some((at?, value))).collect();
                        value.from = self.computed(frame, at, &operands, value);
                    }
                    self.stack[to + lane as usize] = value;
                }
            }
            Expression::Select { condition, accept, reject } => {
                let whole = self.any(frame, condition);
                let node = self.decide(cell.site, whole);
                for lane in lanes {
                    let chosen = self.get(frame, condition, lane);
                    let mut value = self.get(frame, if chosen.bits != 0 { accept } else { reject }, lane);
                    value.from = self.join(value.from, node);
                    // A boolean that f64 would choose otherwise.
                    if cell.kind == Kind::Bool && (chosen.wide != 0.0) != (chosen.bits != 0) {
                        value.wide = self.get(frame, if chosen.bits != 0 { reject } else { accept }, lane).wide;
                    }
                    self.stack[to + lane as usize] = value;
                }
            }
            Expression::Relational { fun, argument } => {
                let is_all = match fun {
                    RelationalFunction::All => true,
                    RelationalFunction::Any => false,
                    _ => return Err(unsupported("a test of a float")),
                };
                let mut result = self.get(frame, argument, 0);
                for lane in 1..frame.body.cells[argument.index()].width {
                    let other = self.get(frame, argument, lane);
                    let from = self.join(result.from, other.from);
                    result = match is_all {
                        true => Slot { bits: result.bits & other.bits, wide: result.wide.min(other.wide), from },
                        false => Slot { bits: result.bits | other.bits, wide: result.wide.max(other.wide), from },
                    };
                }
                self.stack[to] = result;
            }
            Expression::As { expr, kind, convert: width } => {
                if width.is_some_and(|width| width != 4 && kind != naga::ScalarKind::Bool) {
                    return Err(unsupported("a type of another size"));
                }
                let before = frame.body.cells[expr.index()].kind;
                for lane in lanes {
                    let value = self.get(frame, expr, lane);
                    self.stack[to + lane as usize] = convert(value, before, cell.kind, width.is_some());
                }
            }
            Expression::Splat { value, .. } => {
                let value = self.get(frame, value, 0);
                lanes.for_each(|lane| self.stack[to + lane as usize] = value);
            }
            Expression::Swizzle { vector, pattern, .. } => {
                for (lane, component) in lanes.zip(pattern) {
                    self.stack[to + lane as usize] = self.get(frame, vector, component as u32);
                }
            }
            Expression::Compose { ref components, .. } => {
                let mut next = to;
                for &component in components {
                    for lane in 0..frame.body.cells[component.index()].width {
                        self.stack[next] = self.get(frame, component, lane);
                        next += 1;
                    }
                }
            }
            Expression::Access { base, index } => {
                let index = self.get(frame, index, 0);
                let whole = frame.body.cells[base.index()].width;
                let first = u64::from(index.bits) * u64::from(cell.width);
                if first + u64::from(cell.width) > u64::from(whole) {
                    let what = format!("a value of {} parts", whole / cell.width.max(1));
                    return Err(InterpretError::OutOfBounds { index: index.bits.into(), what });
                }
                for lane in lanes {
                    let mut value = self.get(frame, base, first as u32 + lane);
                    value.from = self.join(value.from, index.from);
                    self.stack[to + lane as usize] = value;
                }
            }
            Expression::Load { pointer } => self.load(frame, pointer, to)?,
            Expression::ImageLoad { image, coordinate, array_index: Some(layer), .. } => {
                self.image_load(frame, image, coordinate, layer, to, cell.kind.is_float())?;
            }
            Expression::ImageQuery { query: naga::ImageQuery::Size { .. }, .. } => {
                for (lane, bits) in lanes.zip(self.element.size) {
                    self.stack[to + lane as usize] = Slot { bits, ..Slot::default() };
                }
            }
            // Written by its statement.
            Expression::CallResult(_) => {}
            _ => return Err(unsupported("an expression")),
        }
        Ok(())
    }

    /// An expression as a reader would name it: what it was bound to by `let`, or its source.
    pub(super) fn text(&self, frame: &Frame<'a>, at: Handle<Expression>) -> String {
        if let Some(name) = frame.function.named_expressions.get(&at) {
            return name.clone();
        }
        let variable = match frame.function.expressions[at] {
            Expression::Load { pointer } => return self.text(frame, pointer),
            Expression::LocalVariable(local) => frame.function.local_variables[local].name.clone(),
            Expression::GlobalVariable(global) => self.kernel.module.global_variables[global].name.clone(),
            Expression::FunctionArgument(index) => {
                frame.function.arguments.get(index as usize).and_then(|argument| argument.name.clone())
            }
            _ => None,
        };
        if let Some(name) = variable {
            return name;
        }
        let source = self.kernel.source();
        let Some(mut span) = frame.function.expressions.get_span(at).to_range() else { return String::new() };
        // The span of a call is that of the function's name.
        let rest = source.get(span.end..).unwrap_or_default();
        let mut depth = 0usize;
        for (at, c) in rest.char_indices().take_while(|_| rest.starts_with('(')) {
            match c {
                '(' => depth += 1,
                ')' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                span.end += at + 1;
                break;
            }
        }
        source.get(span).unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Whether any component is true, and in f64: it differs if any component does.
    fn any(&mut self, frame: &Frame<'a>, condition: Handle<Expression>) -> Slot {
        let mut whole = self.get(frame, condition, 0);
        let mut differs = (whole.wide != 0.0) != (whole.bits != 0);
        for lane in 1..frame.body.cells[condition.index()].width {
            let slot = self.get(frame, condition, lane);
            differs |= (slot.wide != 0.0) != (slot.bits != 0);
            whole.bits |= slot.bits;
            whole.from = self.join(whole.from, slot.from);
        }
        whole.wide = f64::from(u8::from((whole.bits != 0) != differs));
        whole
    }

    /// Records a comparison, and returns its node.
    #[expect(clippy::too_many_arguments)]
    fn compared(
        &mut self,
        frame: &Frame<'a>,
        sides: [Handle<Expression>; 2],
        operator: &'static str,
        lane: u32,
        width: u32,
        result: Slot,
        values: [Slot; 2],
    ) -> u32 {
        let kind = frame.body.cells[sides[0].index()].kind;
        let comparison = Comparison {
            sides: sides.map(|side| self.text(frame, side)),
            component: (width > 1).then_some(lane as usize),
            operator,
            values: values.map(|value| Value { bits: value.bits, kind, wide: value.wide }),
            holds: result.bits != 0,
            holds_wide: result.wide != 0.0,
            has_constant: sides.iter().any(|&side| is_constant(frame, side)),
        };
        self.recording.as_mut().map_or(KNOWN, |recording| recording.compare(comparison, result.from))
    }
}

/// Whether an expression is made of literals and constants only.
fn is_constant(frame: &Frame<'_>, at: Handle<Expression>) -> bool {
    match frame.function.expressions[at] {
        Expression::Splat { value, .. } => is_constant(frame, value),
        Expression::Compose { ref components, .. } => components.iter().all(|&part| is_constant(frame, part)),
        _ => frame.body.cells[at.index()].place & CONSTANT != 0,
    }
}

fn unary(op: UnaryOperator, kind: Kind, value: Slot) -> Slot {
    match (op, kind) {
        (UnaryOperator::Negate, Kind::F32) => Slot { bits: value.bits ^ (1 << 31), wide: -value.wide, ..value },
        (UnaryOperator::Negate, _) => Slot { bits: value.bits.wrapping_neg(), wide: 0.0, ..value },
        (UnaryOperator::LogicalNot, _) => Slot { bits: 1 - value.bits.min(1), wide: 1.0 - value.wide, ..value },
        (UnaryOperator::BitwiseNot, _) => Slot { bits: !value.bits, wide: 0.0, ..value },
    }
}
