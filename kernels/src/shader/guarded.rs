//! Gives a user's kernel a budget of loop turns, so that one that does not end is an error and no lost device.
//!
//! All loops of a thread share the budget. A thread that has used it leaves all of its loops, and writes the line of the loop
//! to the last word of the pass's counters; threads that come after it see that and take few turns. naga's own bound, which
//! wgpu compiles into every loop, is 2⁶⁴.

use naga::{
    ArraySize, BinaryOperator, Block, Expression, Function, GlobalVariable, Handle, Literal, Module, Range, Span,
    Statement, Type, TypeInner, UnaryOperator,
};

use super::blocks::rewritten;
use super::notes::{MOST_ASSERTIONS, assertion, statement_of};
use super::parsed::Parsed;
use super::{Binding, Resource, ShaderError, Variant};
use crate::tables::sizes::COUNT_SLOT_BYTES;

/// The counters of a pass, whose last word tells of an endless loop.
const COUNTERS: &str = "sent";

/// Words of the counters of a pass.
pub(crate) const COUNTER_WORDS: u32 = COUNT_SLOT_BYTES as u32 / 4;

/// What guards add to a source.
const NAMES: [&str; 4] = ["turn_is_over", "turns_left", "last_counter", "counters_of_pass"];

/// Turns between two looks at the counters.
const BETWEEN_LOOKS: u32 = 1 << 10;

impl Variant {
    /// The kernel as a device gets it: if it is a user's and has loops, they end after so many turns.
    ///
    /// # Errors
    /// If naga cannot write what it has read.
    pub(crate) fn guarded(&self, turns: u32) -> Result<Option<Self>, ShaderError> {
        if self.replaced.is_none() {
            return Ok(None);
        }
        let invalid = |message| ShaderError::Invalid { kernel: self.kernel.name(), message };
        let parsed = Parsed::new(&self.source).map_err(invalid)?;
        let statements = parsed.functions().filter_map(|(function, _)| statement_of(function.name.as_deref()?));
        let has_statements = statements.count() > 0;
        if !has_statements && !parsed.functions().any(|(function, _)| has_loop(&function.body)) {
            return Ok(None);
        }
        let mut bindings = self.bindings.clone();
        let declared = bindings.iter().find(|binding| binding.name == COUNTERS).cloned();
        let counters = declared.clone().unwrap_or_else(|| {
            let is_taken = |index: &u32| bindings.iter().any(|b| b.group == 2 && b.index == *index);
            let index = (0..).find(|index| !is_taken(index)).unwrap_or(0);
            let resource = Resource::Live { writable: true };
            Binding { group: 2, index, name: COUNTERS.into(), resource, reads: true, writes: true }
        });
        if declared.is_none() {
            bindings.push(counters.clone());
            bindings.sort_by_key(|binding| (binding.group, binding.index));
        }
        let name = declared.and_then(|counters| find(&parsed, &counters)).map(|(_, name)| name);
        let source = guarded(&self.source, name, &counters, turns).map_err(invalid)?;
        Ok(Some(Self { source, bindings, ..self.clone() }))
    }
}

/// The source with guards; `name` is that of the counters, if it declares them.
fn guarded(source: &str, name: Option<String>, counters: &Binding, turns: u32) -> Result<String, String> {
    // Under names that the source does not have.
    let mut suffix = String::new();
    while NAMES.iter().any(|name| source.contains(&format!("{name}{suffix}"))) {
        suffix.push('x');
    }
    let [is_over, left, last, of_pass] = NAMES.map(|name| name.to_owned() + &suffix);
    let declaration = match name {
        Some(_) => String::new(),
        None => format!(
            "@group({}) @binding({}) var<storage, read_write> {of_pass}: array<atomic<u32>, {COUNTER_WORDS}>;\n",
            counters.group, counters.index
        ),
    };
    let name = name.unwrap_or(of_pass);
    let before = format!(
        "{declaration}var<private> {left}: u32 = {turns}u;\nvar<private> {last}: u32 = {}u;\n\
         fn {is_over}(line: u32) -> bool {{\n\
         if ({left} == 0u) {{ return true; }}\n\
         {left} -= 1u;\n\
         if ({left} == 0u) {{ atomicMax(&{name}[{last}], line); return true; }}\n\
         if ({left} % {BETWEEN_LOOKS}u == 0u && atomicLoad(&{name}[{last}]) != 0u) {{\n{left} = 0u;\n}}\n\
         return {left} == 0u;\n}}\n",
        COUNTER_WORDS - 1
    );
    // An assertion adds to its counter.
    let mut source = source.to_owned();
    for index in 0..MOST_ASSERTIONS {
        let body = format!(" if (!holds) {{ atomicAdd(&{name}[{last} - {}u], 1u); }} ", index + 1);
        let empty = assertion(index);
        source = source.replace(&empty, &empty.replace("{}", &format!("{{{body}}}")));
    }
    let source = source.as_str();
    let mut parsed = Parsed::new(&(before.clone() + source))?;
    let callee = parsed.function(&is_over)?;
    let (global, _) = find(&parsed, counters).ok_or("no counters")?;
    let TypeInner::Array { base, stride, .. } = parsed.module.types[parsed.module.global_variables[global].ty].inner
    else {
        return Err("counters that are no array".into());
    };
    let words = std::num::NonZeroU32::new(COUNTER_WORDS).ok_or("no words")?;
    let inner = TypeInner::Array { base, size: ArraySize::Constant(words), stride };
    let ty = parsed.module.types.insert(Type { name: None, inner }, Span::UNDEFINED);
    parsed.module.global_variables.get_mut(global).ty = ty;
    let line = |span: Span| {
        let at = span.to_range().map_or(0, |range| range.start.saturating_sub(before.len()));
        source.get(..at).map_or(0, |text| text.matches('\n').count()) as u32 + 1
    };
    let module = parsed.module.clone();
    parsed.rewritten(|function, _| {
        let mut function = function.clone();
        if function.name.as_ref() == Some(&is_over) {
            return Ok(function);
        }
        let body = std::mem::take(&mut function.body);
        let body = rewritten(&body, &mut |block, statement, span| {
            if !is_note(&module, statement) {
                block.push(statement.clone(), span);
            }
            Ok::<(), String>(())
        })?;
        function.body = with_turns(&mut function, body, callee, &line);
        Ok(function)
    })
}

/// Whether a statement prints something: a device does without.
fn is_note(module: &Module, statement: &Statement) -> bool {
    let Statement::Call { function, .. } = statement else { return false };
    matches!(module.functions[*function].name.as_deref().and_then(statement_of), Some((false, _)))
}

/// The global that a binding is of, and its name.
fn find(parsed: &Parsed, binding: &Binding) -> Option<(Handle<GlobalVariable>, String)> {
    let is_it = |global: &GlobalVariable| {
        global.binding.as_ref().is_some_and(|at| (at.group, at.binding) == (binding.group, binding.index))
    };
    let mut globals = parsed.module.global_variables.iter();
    globals.find(|(_, global)| is_it(global)).and_then(|(handle, global)| Some((handle, global.name.clone()?)))
}

fn has_loop(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Loop { .. } => true,
        Statement::Block(block) => has_loop(block),
        Statement::If { accept, reject, .. } => has_loop(accept) || has_loop(reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| has_loop(&case.body)),
        _ => false,
    })
}

/// A block in which every turn of a loop is counted first.
fn with_turns(
    function: &mut Function,
    block: Block,
    callee: Handle<naga::Function>,
    line: &dyn Fn(Span) -> u32,
) -> Block {
    let mut all = Block::with_capacity(block.len());
    for (statement, span) in block.span_into_iter() {
        let mut inner = |block: Block| with_turns(function, block, callee, line);
        let statement = match statement {
            Statement::Block(block) => Statement::Block(inner(block)),
            Statement::If { condition, accept, reject } => {
                Statement::If { condition, accept: inner(accept), reject: inner(reject) }
            }
            Statement::Switch { selector, mut cases } => {
                for case in &mut cases {
                    case.body = inner(std::mem::take(&mut case.body));
                }
                Statement::Switch { selector, cases }
            }
            Statement::Loop { body, continuing, break_if } => {
                let (body, continuing) = (inner(body), inner(continuing));
                Statement::Loop { body: counted(function, body, callee, line(span)), continuing, break_if }
            }
            other => other,
        };
        all.push(statement, span);
    }
    all
}

/// A loop's body that ends the loop if this turn is one too many. Where the body begins with the condition of a `while` or
/// `for`, that becomes false, so the loop still has one exit: Mesa's software Vulkan is known to err with several.
fn counted(function: &mut Function, body: Block, callee: Handle<naga::Function>, line: u32) -> Block {
    let span = Span::UNDEFINED;
    let mut put = |expression: Expression| function.expressions.append(expression, span);
    let argument = put(Expression::Literal(Literal::U32(line)));
    let is_over = put(Expression::CallResult(callee));
    let mut counted = Block::with_capacity(body.len() + 2);
    counted.push(Statement::Call { function: callee, arguments: vec![argument], result: Some(is_over) }, span);
    let is_exit = |statement: &Statement| {
        let Statement::If { accept, reject, .. } = statement else { return false };
        accept.is_empty() && matches!(&reject[..], [Statement::Break])
    };
    let exit =
        body.iter().position(|statement| !matches!(statement, Statement::Emit(_))).filter(|&at| is_exit(&body[at]));
    let Some(exit) = exit else {
        let accept = Block::from_vec(vec![Statement::Break]);
        counted.push(Statement::If { condition: is_over, accept, reject: Block::new() }, span);
        counted.extend_block(body);
        return counted;
    };
    for (index, (statement, span)) in body.span_into_iter().enumerate() {
        match statement {
            Statement::If { condition, accept, reject } if index == exit => {
                let goes_on = put(Expression::Unary { op: UnaryOperator::LogicalNot, expr: is_over });
                let op = BinaryOperator::LogicalAnd;
                let both = put(Expression::Binary { op, left: condition, right: goes_on });
                counted.push(Statement::Emit(Range::new_from_bounds(goes_on, both)), span);
                counted.push(Statement::If { condition: both, accept, reject }, span);
            }
            other => counted.push(other, span),
        }
    }
    counted
}

#[cfg(test)]
mod tests;
