//! One compute shader with every operation in it.

use std::fmt::Write as _;
use std::sync::Arc;

use raystep_kernels::{Gpu, GpuError};

use super::operations;
use super::shader::Shader;

/// The bits of a, b, c and d.
pub(super) type Inputs = [u32; 4];

/// Inputs of an operation.
pub(super) const VALUES: u32 = 2048;

const WORKGROUP: u32 = 64;

/// The inputs as floats.
pub(super) fn floats(inputs: Inputs) -> [f32; 4] {
    inputs.map(f32::from_bits)
}

/// A float as an f64, which is exact.
pub(super) fn wide(bits: u32) -> f64 {
    f64::from(f32::from_bits(bits))
}

/// Its WGSL. A row of workgroups is for one operation: with a branch a piece, no compiler merges two of them.
#[must_use]
pub fn source() -> String {
    let mut cases = String::new();
    for (index, operation) in operations::all().iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = writeln!(cases, "        case {index}u: {{ return {}; }}", operation.wgsl);
    }
    format!(
        "\
@group(0) @binding(0) var<storage, read> inputs: array<vec4u>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;

fn operation(which: u32, bits: vec4u) -> u32 {{
    let x = bits.x;
    let y = bits.y;
    let z = bits.z;
    let w = bits.w;
    let a = bitcast<f32>(x);
    let b = bitcast<f32>(y);
    let c = bitcast<f32>(z);
    let d = bitcast<f32>(w);
    switch (which) {{
{cases}        default: {{ return 0u; }}
    }}
}}

@compute @workgroup_size({WORKGROUP})
fn operations(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {{
    let at = group.y * {VALUES}u + group.x * {WORKGROUP}u + lane;
    results[at] = operation(group.y, inputs[at]);
}}
"
    )
}

/// Runs it on inputs for every operation, one after the other.
pub(super) async fn run(gpu: &Arc<Gpu>, source: String, inputs: &[Inputs]) -> Result<Vec<u32>, GpuError> {
    let shader = Shader::new(gpu, "operations", source);
    let (given, results) = (shader.given(inputs.as_flattened()), shader.room(inputs.len()));
    let resources = [given.as_entire_binding(), results.as_entire_binding()];
    let groups = [VALUES / WORKGROUP, inputs.len() as u32 / VALUES];
    let copy = |encoder: &mut wgpu::CommandEncoder, read_back: &wgpu::Buffer| {
        encoder.copy_buffer_to_buffer(&results, 0, read_back, 0, read_back.size());
    };
    shader.run(resources, groups, inputs.len(), copy).await
}
