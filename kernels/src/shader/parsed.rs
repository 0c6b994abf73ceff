//! A shader in naga's form, whose functions are rewritten, and written as WGSL again.

use std::collections::{BTreeMap, BTreeSet};

use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator};
use naga::{Block, Expression, Function, Handle, Literal, Module, Range, Span, Statement};

use super::blocks::rewritten;

/// A valid shader.
pub(super) struct Parsed {
    pub(super) module: Module,
    info: ModuleInfo,
}

fn valid(module: &Module) -> Result<ModuleInfo, String> {
    Validator::new(ValidationFlags::all(), Capabilities::all()).validate(module).map_err(|e| format!("{e:?}"))
}

impl Parsed {
    pub(super) fn new(source: &str) -> Result<Self, String> {
        let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
        let info = valid(&module)?;
        Ok(Self { module, info })
    }

    /// Every function and what naga knows of it, entry points last.
    pub(super) fn functions(&self) -> impl Iterator<Item = (&Function, &FunctionInfo)> {
        let plain = self.module.functions.iter().map(|(handle, function)| (function, &self.info[handle]));
        let entries = self.module.entry_points.iter().enumerate();
        plain.chain(entries.map(|(index, entry)| (&entry.function, self.info.get_entry_point(index))))
    }

    /// The function with a name.
    pub(super) fn function(&self, name: &str) -> Result<Handle<Function>, String> {
        let found = self.module.functions.iter().find(|(_, of)| of.name.as_deref() == Some(name));
        found.map(|(handle, _)| handle).ok_or_else(|| format!("no function {name}"))
    }

    /// The WGSL with each function as `change` makes it, without what is not mentioned any more.
    pub(super) fn rewritten(
        &self,
        change: impl Fn(&Function, &FunctionInfo) -> Result<Function, String>,
    ) -> Result<String, String> {
        let changed: Vec<Function> =
            self.functions().map(|(function, info)| change(function, info)).collect::<Result<_, _>>()?;
        let mut module = self.module.clone();
        let plain = module.functions.iter_mut().map(|(_, function)| function);
        let all = plain.chain(module.entry_points.iter_mut().map(|entry| &mut entry.function));
        all.zip(changed).for_each(|(function, changed)| *function = changed);
        compact(&mut module, KeepUnused::No);
        let info = valid(&module)?;
        let flags = naga::back::wgsl::WriterFlags::empty();
        naga::back::wgsl::write_string(&module, &info, flags).map_err(|e| e.to_string())
    }
}

/// A function and its arguments.
type Call = (Handle<Function>, Vec<Handle<Expression>>);

/// What stands in place of some expressions of a function.
#[derive(Default)]
pub(super) struct Replaced {
    /// The calls whose results these are.
    calls: BTreeMap<Handle<Expression>, Call>,
    /// Those that are not computed any more.
    gone: BTreeSet<Handle<Expression>>,
}

impl Replaced {
    /// Replaces an expression by a call.
    pub(super) fn by_call(
        &mut self,
        function: &mut Function,
        expression: Handle<Expression>,
        callee: Handle<Function>,
        arguments: Vec<Handle<Expression>>,
    ) {
        *function.expressions.get_mut(expression) = Expression::CallResult(callee);
        self.calls.insert(expression, (callee, arguments));
    }

    /// Replaces an expression by a number.
    pub(super) fn by_number(&mut self, function: &mut Function, expression: Handle<Expression>, number: u32) {
        *function.expressions.get_mut(expression) = Expression::Literal(Literal::U32(number));
        self.gone.insert(expression);
    }

    /// A body that computes what is in place of these expressions, and in which `put` appends each statement but those
    /// that compute expressions, or what stands for it.
    pub(super) fn body(
        &self,
        body: &Block,
        put: &mut impl FnMut(&mut Block, &Statement, Span) -> Result<(), String>,
    ) -> Result<Block, String> {
        rewritten(body, &mut |block, statement, span| {
            let Statement::Emit(range) = statement else { return put(block, statement, span) };
            let mut computed = None;
            for handle in range.clone() {
                if let Some((function, arguments)) = self.calls.get(&handle) {
                    emit(block, &mut computed, span);
                    let (function, arguments) = (*function, arguments.clone());
                    block.push(Statement::Call { function, arguments, result: Some(handle) }, span);
                } else if self.gone.contains(&handle) {
                    emit(block, &mut computed, span);
                } else {
                    let (first, _) = computed.unwrap_or((handle, handle));
                    computed = Some((first, handle));
                }
            }
            emit(block, &mut computed, span);
            Ok(())
        })
    }
}

/// Appends the computation of these expressions, the first and the last, if there are any.
fn emit(block: &mut Block, computed: &mut Option<(Handle<Expression>, Handle<Expression>)>, span: Span) {
    if let Some((first, last)) = computed.take() {
        block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
    }
}
