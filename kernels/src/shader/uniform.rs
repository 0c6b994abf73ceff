//! Whether every thread of a workgroup reaches a kernel's barriers.

use naga::{
    AddressSpace, Binding, Block, BuiltIn, Expression, Function, Handle, ImageClass, Module, Span, Statement,
    StorageAccess, TypeInner,
};

/// A barrier that some threads of a workgroup may not reach: in a branch or loop whose condition may differ between threads,
/// or after a `return` of one. As in WGSL, a value is known to be the same for all threads if it is made of constants, uniforms
/// and the workgroup's own index, or returned by a function that makes it of such arguments. Of a function's arguments nothing
/// is known where it has a barrier itself.
pub(super) fn astray(module: &Module, entry: &Function) -> Option<Span> {
    // A function comes before those that call it.
    let (mut barriers, mut returns) = (Vec::new(), Vec::new());
    for (_, function) in module.functions.iter() {
        barriers.push(are_in(&barriers, &function.body));
        let mut threads = Threads::new(module, function, Arguments::Same, (&barriers, &returns));
        threads.settle();
        returns.push(threads.returns);
    }
    let functions = module.functions.iter().map(|(_, function)| (function, Arguments::Unknown));
    std::iter::once((entry, Arguments::BuiltIn)).chain(functions).find_map(|(function, arguments)| {
        let mut threads = Threads::new(module, function, arguments, (&barriers, &returns));
        threads.settle();
        threads.walk(&function.body, false, &mut false)
    })
}

/// What is known of a function's arguments.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Arguments {
    /// They are an entry point's.
    BuiltIn,
    /// Those that are values are taken to be the same in all threads.
    Same,
    Unknown,
}

/// Whether a statement is a barrier; `barriers` says it of functions.
fn is_one(barriers: &[bool], statement: &Statement) -> bool {
    match statement {
        Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. } => true,
        Statement::Call { function, .. } => barriers.get(function.index()).copied().unwrap_or_default(),
        _ => false,
    }
}

fn are_in(barriers: &[bool], block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Block(block) => are_in(barriers, block),
        Statement::If { accept, reject, .. } => are_in(barriers, accept) || are_in(barriers, reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| are_in(barriers, &case.body)),
        Statement::Loop { body, continuing, .. } => are_in(barriers, body) || are_in(barriers, continuing),
        other => is_one(barriers, other),
    })
}

/// What is the same for all threads of a workgroup in a function.
struct Threads<'a> {
    module: &'a Module,
    function: &'a Function,
    arguments: Arguments,
    barriers: &'a [bool],
    /// Of each function before this one, whether it returns the same value in all threads for the same arguments.
    of_functions: &'a [bool],
    /// Of each local variable, whether it has the same value in all threads, as far as is known yet.
    same: Vec<bool>,
    /// The same of each expression that is the result of a call.
    results: Vec<bool>,
    /// The same of what this function returns.
    returns: bool,
    /// Whether one was found to differ.
    changed: bool,
    /// Whether some threads may have returned.
    has_left: bool,
}

impl<'a> Threads<'a> {
    fn new(
        module: &'a Module,
        function: &'a Function,
        arguments: Arguments,
        (barriers, of_functions): (&'a [bool], &'a [bool]),
    ) -> Self {
        let same = vec![true; function.local_variables.len()];
        let results = vec![true; function.expressions.len()];
        let (changed, has_left, returns) = (true, false, true);
        Self { module, function, arguments, barriers, of_functions, same, results, returns, changed, has_left }
    }

    /// Finds what differs.
    fn settle(&mut self) {
        let function = self.function;
        while std::mem::take(&mut self.changed) {
            self.has_left = false;
            self.walk(&function.body, false, &mut false);
        }
        self.has_left = false;
    }

    /// The first barrier of a block that threads reach apart. `apart`: only some of them may run the block. `leaves` becomes
    /// true if some may leave the loop around it, or go on to its next turn, before others.
    fn walk(&mut self, block: &Block, apart: bool, leaves: &mut bool) -> Option<Span> {
        for (statement, &span) in block.span_iter() {
            let now = apart || self.has_left || *leaves;
            if now && is_one(self.barriers, statement) {
                return Some(span);
            }
            let found = match statement {
                Statement::Block(block) => self.walk(block, apart, leaves),
                Statement::If { condition, accept, reject } => {
                    let apart = now || !self.is_same(*condition);
                    self.walk(accept, apart, leaves).or_else(|| self.walk(reject, apart, leaves))
                }
                Statement::Switch { selector, cases } => {
                    let apart = now || !self.is_same(*selector);
                    // A `break` in it ends the case.
                    cases.iter().find_map(|case| self.walk(&case.body, apart, leaves))
                }
                Statement::Loop { body, continuing, break_if } => {
                    // Whether threads leave it apart is known after its body.
                    let mut apart_in = false;
                    self.walk(body, now, &mut apart_in);
                    self.walk(continuing, now, &mut apart_in);
                    apart_in |= break_if.is_some_and(|condition| !self.is_same(condition));
                    let apart = now || apart_in;
                    self.walk(body, apart, &mut apart_in).or_else(|| self.walk(continuing, apart, &mut apart_in))
                }
                Statement::Break | Statement::Continue => {
                    *leaves |= now;
                    None
                }
                Statement::Return { value } => {
                    self.has_left |= now;
                    self.returns &= !now && value.is_none_or(|value| self.is_same(value));
                    None
                }
                Statement::Store { pointer, value } => {
                    if now || !self.is_same(*value) || !self.is_same_index(*pointer) {
                        self.differs(*pointer);
                    }
                    None
                }
                Statement::Call { function, arguments, result } => {
                    let is_same = self.of_functions.get(function.index()).copied().unwrap_or_default();
                    let is_same = is_same && arguments.iter().all(|&argument| self.is_same(argument));
                    if let Some(result) = result.filter(|_| !is_same) {
                        self.changed |= std::mem::take(&mut self.results[result.index()]);
                    }
                    // A function may store what is pointed to.
                    arguments.iter().for_each(|&argument| self.differs(argument));
                    None
                }
                _ => None,
            };
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// The variable that a pointer leads to is not the same in all threads.
    fn differs(&mut self, pointer: Handle<Expression>) {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(local) => self.changed |= std::mem::take(&mut self.same[local.index()]),
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.differs(base),
            _ => {}
        }
    }

    /// Whether all threads store at the same place of a variable.
    fn is_same_index(&self, pointer: Handle<Expression>) -> bool {
        match self.function.expressions[pointer] {
            Expression::Access { base, index } => self.is_same(index) && self.is_same_index(base),
            Expression::AccessIndex { base, .. } => self.is_same_index(base),
            _ => true,
        }
    }

    fn is_same(&self, at: Handle<Expression>) -> bool {
        let all = |parts: &[Handle<Expression>]| parts.iter().all(|&part| self.is_same(part));
        match &self.function.expressions[at] {
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::ZeroValue(_)
            | Expression::WorkGroupUniformLoadResult { .. } => true,
            Expression::FunctionArgument(index) => {
                let argument = self.function.arguments.get(*index as usize);
                let binding = argument.and_then(|argument| argument.binding.as_ref());
                let of_group = [BuiltIn::WorkGroupId, BuiltIn::NumWorkGroups].map(Binding::BuiltIn);
                match self.arguments {
                    Arguments::BuiltIn => binding.is_some_and(|binding| of_group.contains(binding)),
                    // What a pointer leads to, and what a texture has, is not known.
                    Arguments::Same => argument.is_some_and(|argument| {
                        let inner = &self.module.types[argument.ty].inner;
                        !matches!(
                            inner,
                            TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } | TypeInner::Image { .. }
                        )
                    }),
                    Arguments::Unknown => false,
                }
            }
            Expression::CallResult(_) => self.results[at.index()],
            Expression::GlobalVariable(global) => {
                let global = &self.module.global_variables[*global];
                match global.space {
                    AddressSpace::Uniform => true,
                    AddressSpace::Storage { access } => !access.contains(StorageAccess::STORE),
                    AddressSpace::Handle => matches!(
                        self.module.types[global.ty].inner,
                        TypeInner::Image { class: ImageClass::Sampled { .. }, .. }
                    ),
                    _ => false,
                }
            }
            Expression::LocalVariable(local) => self.same[local.index()],
            Expression::Load { pointer } => self.is_same(*pointer),
            Expression::AccessIndex { base, .. } => self.is_same(*base),
            Expression::Access { base, index } => all(&[*base, *index]),
            Expression::Splat { value, .. } => self.is_same(*value),
            Expression::Swizzle { vector, .. } => self.is_same(*vector),
            Expression::Compose { components, .. } => all(components),
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => self.is_same(*expr),
            Expression::Relational { argument, .. } => self.is_same(*argument),
            Expression::Binary { left, right, .. } => all(&[*left, *right]),
            Expression::Select { condition, accept, reject } => all(&[*condition, *accept, *reject]),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().all(|part| self.is_same(part))
            }
            // The size of a texture; of a pointer to one, nothing is known.
            Expression::ImageQuery { image, .. } => {
                matches!(self.function.expressions[*image], Expression::GlobalVariable(_))
            }
            Expression::ArrayLength(array) => self.is_same(*array),
            Expression::ImageLoad { image, coordinate, array_index: Some(layer), level: Some(level), .. } => {
                all(&[*image, *coordinate, *layer, *level])
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text at the barrier that threads reach apart, in a kernel with this body.
    fn found(body: &str) -> Option<String> {
        let source = format!(
            "@group(0) @binding(0) var<uniform> size: vec4u;\nvar<workgroup> row: array<u32, 64>;\n\
             fn inner() {{ workgroupBarrier(); }}\n\
             fn at(block: u32) -> u32 {{ var sum = size.z; for (var i = 0u; i < block; i++) {{ sum += 2u; }} return sum; }}\n\
             fn of_row(block: u32) -> u32 {{ return row[block]; }}\n\
             fn early(block: u32) -> u32 {{ if (row[block] == 1u) {{ return 1u; }} return 2u; }}\n\
             fn through(n: ptr<function, u32>) -> u32 {{ return *n; }}\n\
             @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) lane: u32, \
             @builtin(workgroup_id) group: vec3u) {{\n{body}\n}}"
        );
        let module = naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
        let span = astray(&module, &module.entry_points[0].function)?;
        span.to_range().map(|range| source[range].to_owned())
    }

    #[test]
    fn threads_stay_together_where_conditions_are_the_same_for_all() {
        for body in [
            "workgroupBarrier();",
            "for (var i = 0u; i < size.x; i += 64u) { row[lane] = i; workgroupBarrier(); }",
            "var reach = 1u; while (reach < 64u) { workgroupBarrier(); reach *= 2u; }",
            "if (group.x > size.y) { return; } workgroupBarrier();",
            "if (lane < size.x) { row[lane] = 1u; } workgroupBarrier();",
            "var now = 0u; for (var i = 0u; i < 6u; i++) { workgroupBarrier(); now = 1u - now; } if (now == 1u) { inner(); }",
            "switch group.x { case 0u: { workgroupBarrier(); } default: {} }",
            "let block = at(group.x); if (block > size.y) { return; } workgroupBarrier();",
        ] {
            assert_eq!(found(body), None, "{body}");
        }
    }

    #[test]
    fn a_barrier_that_threads_reach_apart_is_found() {
        for body in [
            "if (lane < 32u) { workgroupBarrier(); }",
            "if (lane >= size.x) { return; } workgroupBarrier();",
            "for (var i = 0u; i < lane; i++) { workgroupBarrier(); }",
            "loop { if (lane == 3u) { break; } workgroupBarrier(); if (size.x == 1u) { break; } }",
            "for (var i = 0u; i < 4u; i++) { if (lane == i) { continue; } workgroupBarrier(); }",
            "var n = 1u; if (lane == 0u) { n = 2u; } for (var i = 0u; i < n; i++) { workgroupBarrier(); }",
            "var n = size.x; for (var i = 0u; i < 2u; i++) { if (n == 7u) { workgroupBarrier(); } n = lane; }",
            "if (row[0] == 1u) { workgroupBarrier(); }",
            "if (at(lane) > size.y) { return; } workgroupBarrier();",
            "if (of_row(group.x) > size.y) { return; } workgroupBarrier();",
            "if (early(group.x) > size.y) { return; } workgroupBarrier();",
            "var n = group.x; if (through(&n) > size.y) { return; } workgroupBarrier();",
            "for (var i = 0u; i < 9u; i++) { if (i == lane) { return; } } workgroupBarrier();",
        ] {
            assert_eq!(found(body).as_deref(), Some("workgroupBarrier"), "{body}");
        }
        assert_eq!(found("if (lane == 1u) { inner(); }").as_deref(), Some("inner()"));
    }
}
