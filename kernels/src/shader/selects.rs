//! Rewrites a shader for GLSL ES 3.0, which chooses between vectors by component only if they are floats: naga writes
//! every such `select` as `mix`, which takes no integers before GLSL ES 3.1. They become calls of functions that choose
//! component by component.

use naga::valid::FunctionInfo;
use naga::{Expression, Function, Handle, ScalarKind, TypeInner, VectorSize};

use super::ShaderError;
use super::parsed::{Parsed, Replaced};
use crate::program::Kernel;

/// A shader's WGSL without a `select` by component but between floats.
///
/// # Errors
/// If it is not valid.
pub(crate) fn by_component(kernel: Kernel, source: &str) -> Result<String, ShaderError> {
    let rewritten = || {
        // First, as a function comes before those that call it.
        let parsed = Parsed::new(&(functions() + source))?;
        parsed.rewritten(|function, info| changed(&parsed, function, info))
    };
    rewritten().map_err(|message| ShaderError::Invalid { kernel: kernel.name(), message })
}

const KINDS: [(ScalarKind, &str); 3] =
    [(ScalarKind::Sint, "i32"), (ScalarKind::Uint, "u32"), (ScalarKind::Bool, "bool")];

const SIZES: [VectorSize; 3] = [VectorSize::Bi, VectorSize::Tri, VectorSize::Quad];

fn name(size: VectorSize, kind: &str) -> String {
    format!("select_{}_{kind}s", size as u8)
}

/// A function for each type; those that nobody calls are left out in the end.
fn functions() -> String {
    let function = |size: VectorSize, kind| {
        let (name, n) = (name(size, kind), size as u8);
        let chosen = |component: &str| format!("select(reject.{component}, accept.{component}, condition.{component})");
        let components =
            ["x", "y", "z", "w"][..usize::from(n)].iter().map(|c| chosen(c)).collect::<Vec<_>>().join(", ");
        format!(
            "fn {name}(reject: vec{n}<{kind}>, accept: vec{n}<{kind}>, condition: vec{n}<bool>) -> vec{n}<{kind}> {{\n    \
             return vec{n}<{kind}>({components});\n}}\n"
        )
    };
    KINDS.iter().flat_map(|&(_, kind)| SIZES.iter().map(move |&size| function(size, kind))).collect()
}

/// A function with calls in place of such choices.
fn changed(parsed: &Parsed, original: &Function, info: &FunctionInfo) -> Result<Function, String> {
    let (mut function, mut replaced) = (original.clone(), Replaced::default());
    let inner = |handle: Handle<Expression>| info[handle].ty.inner_with(&parsed.module.types);
    for (handle, expression) in original.expressions.iter() {
        let Expression::Select { condition, accept, reject } = *expression else { continue };
        // One condition for all components is an ordinary choice.
        if !matches!(inner(condition), TypeInner::Vector { .. }) {
            continue;
        }
        let TypeInner::Vector { size, scalar } = *inner(handle) else { continue };
        let Some((_, kind)) = KINDS.iter().find(|(kind, _)| *kind == scalar.kind) else { continue };
        let callee = parsed.function(&name(size, kind))?;
        replaced.by_call(&mut function, handle, callee, vec![reject, accept, condition]);
    }
    function.body = replaced.body(&original.body, &mut |block, statement, span| {
        block.push(statement.clone(), span);
        Ok(())
    })?;
    Ok(function)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::programs::closest_hit::kernels;

    const SHADER: &str = "
@group(0) @binding(0) var<storage, read_write> sums: array<vec3i>;

@compute @workgroup_size(1)
fn setup(@builtin(global_invocation_id) id: vec3u) {
    let axis = id > vec3u(3u);
    let forward = select(vec3i(-1), vec3i(1), axis);
    let place = select(sums[0], forward + select(vec3i(0), vec3i(id), axis), axis);
    let near = select(vec2f(1.0), vec2f(id.xy), axis.xy);
    sums[id.x] = select(place, vec3i(vec3f(near, 2.0)), axis.x);
}
";

    #[test]
    fn vectors_of_integers_are_chosen_by_component_and_others_as_before() {
        let source = by_component(kernels::SETUP, SHADER).expect("a shader");
        // One function, called three times; the others are left out.
        assert_eq!(source.matches("select_3_i32s(").count(), 4, "{source}");
        assert_eq!(source.matches("fn select_").count(), 1, "{source}");
        let body = source.split("fn setup").nth(1).expect("the kernel");
        assert_eq!(body.matches(" select(").count(), 2, "of floats, and of a whole vector: {source}");
    }
}
