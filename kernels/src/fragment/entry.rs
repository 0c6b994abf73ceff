//! The WGSL of entry points, to be appended to a kernel's before it is rewritten.

use std::fmt::Write as _;

use naga::{BuiltIn, FunctionArgument, Module, ScalarKind, TypeInner, VectorSize};

use super::uses::Uses;
use super::{BODY, ENTRY, STREAMS_GROUP, depth_of, input, is_written, takes, value};
use crate::options::mapping::Cull;
use crate::program::Kernel;
use crate::shader::ShaderError;
use crate::tables::stream::{Stream, Texel};

/// The type of a texel of the compute mapping.
fn texel_type(stream: Stream) -> &'static str {
    match stream.info().texel {
        Texel::F32 => "vec4<f32>",
        Texel::U32 => "vec4<u32>",
    }
}

/// Declares what a rewritten kernel accesses: the textures of streams, a variable for each layer, and one for whether a
/// stream was `written`.
fn declarations(state: Stream, uses: &Uses, read: &[Stream], written: &[Stream]) -> String {
    let mut text = String::new();
    let mut textures: Vec<Stream> = read.to_vec();
    if uses.asks_size && !textures.contains(&state) {
        textures.push(state);
    }
    for (index, &stream) in textures.iter().enumerate() {
        let name = input(stream);
        _ = writeln!(text, "@group({STREAMS_GROUP}) @binding({index}) var {name}: texture_2d<u32>;");
    }
    let mut touched: Vec<Stream> = uses.loaded.iter().copied().chain(uses.written()).collect();
    touched.sort();
    touched.dedup();
    for stream in touched {
        for layer in 0..stream.layers() {
            _ = writeln!(text, "var<private> {}: {};", value(stream, layer), texel_type(stream));
        }
    }
    for &stream in written {
        _ = writeln!(text, "var<private> {}: bool;", is_written(stream));
    }
    text
}

/// Assigns a stream's texel to the variables of its layers.
fn take(stream: Stream) -> String {
    let layer = |layer: usize| {
        let bits = format!("bits[{layer}u]");
        let value_of = match stream.info().texel {
            Texel::F32 => format!("bitcast<f32>({bits})"),
            Texel::U32 => bits,
        };
        format!("        {} = {}({value_of});\n", value(stream, layer), texel_type(stream))
    };
    let layers: String = (0..stream.layers()).map(layer).collect();
    format!("    {{\n        let bits = {};\n{layers}    }}\n", load(stream))
}

/// The texel that the variables of a stream's layers make up.
fn give(stream: Stream) -> String {
    let layer = |layer: usize| match stream.info().texel {
        _ if layer >= stream.layers() => "0u".to_owned(),
        Texel::F32 => format!("bitcast<u32>({}.x)", value(stream, layer)),
        Texel::U32 => format!("{}.x", value(stream, layer)),
    };
    format!("vec4<u32>({})", [0, 1, 2, 3].map(layer).join(", "))
}

fn load(stream: Stream) -> String {
    format!("textureLoad({}, texel, 0)", input(stream))
}

/// The function that becomes the kernel's, and a call of it. `builtin` gives the value of an argument.
fn body(
    kernel: Kernel,
    module: &Module,
    builtin: impl Fn(BuiltIn) -> Option<&'static str>,
) -> Result<(String, String), ShaderError> {
    let unknown = || ShaderError::Invalid { kernel: kernel.name(), message: "an argument that fragments lack".into() };
    let entry = module.entry_points.iter().find(|entry| entry.name == kernel.info().name).ok_or_else(unknown)?;
    let (mut parameters, mut arguments) = (Vec::new(), Vec::new());
    for (index, FunctionArgument { ty, binding, .. }) in entry.function.arguments.iter().enumerate() {
        let Some(naga::Binding::BuiltIn(of)) = binding else { return Err(unknown()) };
        let is_u32 = |scalar: naga::Scalar| scalar.kind == ScalarKind::Uint;
        let type_name = match module.types[*ty].inner {
            TypeInner::Scalar(scalar) if is_u32(scalar) => "u32",
            TypeInner::Vector { size: VectorSize::Tri, scalar } if is_u32(scalar) => "vec3<u32>",
            _ => return Err(unknown()),
        };
        parameters.push(format!("argument_{index}: {type_name}"));
        arguments.push(builtin(*of).ok_or_else(unknown)?);
    }
    let stub = format!("fn {BODY}({}) {{}}\n", parameters.join(", "));
    Ok((stub, format!("{BODY}({});", arguments.join(", "))))
}

/// The entry point of a draw.
pub(super) fn fragment(
    kernel: Kernel,
    state: Stream,
    module: &Module,
    uses: &Uses,
    targets: &[Stream],
    cull: Cull,
) -> Result<String, ShaderError> {
    let (stub, call) = body(kernel, module, |builtin| match builtin {
        BuiltIn::GlobalInvocationId | BuiltIn::WorkGroupId => Some("vec3<u32>(texel, 0u)"),
        BuiltIn::LocalInvocationIndex => Some("0u"),
        _ => None,
    })?;
    // What a fragment does not write itself it writes again, unless it is sure to write all of it.
    let kept = |stream: Stream| cull == Cull::None || !uses.is_complete(stream, targets);
    let kept: Vec<Stream> = targets.iter().copied().filter(|&stream| kept(stream)).collect();
    let mut read: Vec<Stream> = uses.loaded.iter().copied().chain(kept.iter().copied()).collect();
    if cull != Cull::EarlyZ {
        read.push(state);
    }
    read.sort();
    read.dedup();
    // A kernel may write only some of its streams.
    let asked: Vec<Stream> = if cull == Cull::None { Vec::new() } else { targets.to_vec() };

    let mut text = declarations(state, uses, &read, &asked);
    text += &stub;
    text += "struct Targets {\n";
    for (index, stream) in targets.iter().enumerate() {
        _ = writeln!(text, "    @location({index}) {}: vec4<u32>,", stream.name());
    }
    text += "}\n";
    _ = writeln!(text, "@fragment fn {ENTRY}(@builtin(position) position: vec4<f32>) -> Targets {{");
    text += "    let texel = vec2<u32>(position.xy);\n";
    let take_all = |streams: &mut dyn Iterator<Item = Stream>| -> String { streams.map(take).collect() };
    if cull != Cull::EarlyZ {
        _ = writeln!(text, "    let state = {};", load(state));
    }
    match cull {
        Cull::None => {
            text += &take_all(&mut kept.iter().copied());
            _ = writeln!(text, "    if ({}) {{", takes(kernel));
            text += &take_all(&mut uses.loaded.iter().copied().filter(|stream| !kept.contains(stream)));
            _ = writeln!(text, "    {call}\n    }}");
        }
        Cull::Discard | Cull::EarlyZ => {
            if cull == Cull::Discard {
                _ = writeln!(text, "    if (!({})) {{ discard; return Targets(); }}", takes(kernel));
            }
            text += &take_all(&mut read.iter().copied().filter(|&s| uses.loaded.contains(&s) || kept.contains(&s)));
            _ = writeln!(text, "    {call}");
            let any: Vec<String> = targets.iter().map(|&stream| is_written(stream)).collect();
            _ = writeln!(text, "    if (!({})) {{ discard; return Targets(); }}", any.join(" || "));
        }
    }
    let outputs: Vec<String> = targets.iter().map(|&stream| give(stream)).collect();
    _ = writeln!(text, "    return Targets({});\n}}", outputs.join(", "));
    Ok(text)
}

/// The entry point of a compute kernel that reads streams.
pub(super) fn compute(kernel: Kernel, module: &Module, uses: &Uses) -> Result<String, ShaderError> {
    let invalid = |message: &str| ShaderError::Invalid { kernel: kernel.name(), message: message.to_owned() };
    let state = kernel.program().state_stream().ok_or_else(|| invalid("its program has no states"))?;
    if !uses.written().is_empty() {
        return Err(invalid("it writes streams"));
    }
    let (stub, call) = body(kernel, module, |builtin| match builtin {
        BuiltIn::GlobalInvocationId => Some("id"),
        BuiltIn::LocalInvocationIndex => Some("lane"),
        _ => None,
    })?;
    let read: Vec<Stream> = uses.loaded.iter().copied().collect();
    let mut text = declarations(state, uses, &read, &[]);
    text += &stub;
    let side = kernel.workgroup();
    _ = writeln!(
        text,
        "@compute @workgroup_size({side}, {side})\nfn {ENTRY}(@builtin(global_invocation_id) id: vec3<u32>, \
         @builtin(local_invocation_index) lane: u32) {{\n    let texel = id.xy;"
    );
    text.extend(read.iter().map(|&stream| take(stream)));
    _ = writeln!(text, "    {call}\n}}");
    Ok(text)
}

/// The draw that turns states into depths; 0, which names no kernel, for a state that none takes.
pub(super) fn depths(state: Stream, kernels: &[Kernel]) -> String {
    let name = input(state);
    let mut text = format!("@group({STREAMS_GROUP}) @binding(0) var {name}: texture_2d<u32>;\n");
    _ = writeln!(text, "@fragment fn {ENTRY}(@builtin(position) position: vec4<f32>) -> @builtin(frag_depth) f32 {{");
    _ = writeln!(text, "    let texel = vec2<u32>(position.xy);\n    let state = {};", load(state));
    for &kernel in kernels {
        _ = writeln!(text, "    if ({}) {{ return {:?}; }}", takes(kernel), depth_of(kernel));
    }
    text += "    return 0.0;\n}\n";
    text
}
