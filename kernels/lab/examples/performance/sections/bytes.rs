//! Bytes that passes move, compared with the device's copy speed, and the cost of a pass that moves none.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::executor::gpu::GpuExecutor;
use raystep_kernels::program::schedule::Call;
use raystep_kernels::programs::closest_hit::{PROGRAM, kernels};
use raystep_kernels::shader::Variant;
use raystep_kernels::tables::state::StateCounts;
use raystep_kernels::{Accelerator, Gpu, Options, Plan, Renderer, ScheduleKind, Skip};
use raystep_lab::meter::Ended;

use super::{Deadline, two_scenes};
use crate::machine::Machine;
use crate::probe::{Job, Stopwatch, bind, in_turn, layers, pipeline, texture};
use crate::row::Probe;
use crate::scenes::Viewed;

const SECTION: &str = "bytes";

/// Dispatches per submission of the copies.
const DISPATCHES: u64 = 16;

pub(super) fn measure(machine: &Machine, deadline: Deadline) -> Result<Vec<Probe>, String> {
    let Some(gpu) = machine.gpu() else {
        let reason = "the CPU neither submits passes nor copies textures".into();
        return Ok(vec![Probe { section: SECTION.into(), reason, ..Probe::default() }]);
    };
    let sizes = match (machine.is_fast(), machine.quick) {
        (true, _) => vec![(512, 512), (1920, 1080)],
        (false, false) => vec![(256, 256), (512, 512)],
        (false, true) => vec![(128, 128)],
    };
    let watch = Stopwatch::new(machine, gpu);
    eprintln!("bytes: buffers");
    let mut probes = in_turn(machine, vec![buffers(gpu, &watch, machine.quick)]);
    for size in sizes {
        eprintln!("bytes: {}x{}", size.0, size.1);
        probes.extend(in_turn(machine, [2, 4, 8, 16].map(|n| in_place(gpu, &watch, size, n)).into()));
        probes.extend(in_turn(machine, empty(machine, size)?));
        let (mut jobs, mut left_out) = (Vec::new(), Vec::new());
        for viewed in two_scenes()? {
            for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
                let of_run = Probe {
                    scene: viewed.name.clone(),
                    accelerator: accelerator.to_string(),
                    ..probe("run of one step a pass", size, 0)
                };
                // At least one run of each size.
                if deadline.is_over() && !jobs.is_empty() {
                    left_out.push(Probe { reason: Deadline::OVER.into(), ..of_run });
                } else {
                    jobs.push(run(machine, &viewed, accelerator, size, of_run)?);
                }
            }
        }
        probes.extend(in_turn(machine, jobs));
        probes.extend(left_out);
    }
    Ok(probes)
}

fn probe(what: &str, (width_px, height_px): (u32, u32), passes: u64) -> Probe {
    Probe { section: SECTION.into(), what: what.into(), width_px, height_px, passes, ..Probe::default() }
}

/// Copies one buffer to another.
fn buffers<'a>(gpu: &Gpu, watch: &'a Stopwatch<'a>, is_quick: bool) -> Job<'a> {
    const WGSL: &str = "
@group(0) @binding(0) var<storage, read> from_words: array<vec4u>;
@group(0) @binding(1) var<storage, read_write> to_words: array<vec4u>;
@compute @workgroup_size(256)
fn copy(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 256u + id.x;
    to_words[i] = from_words[i];
}";
    let size: u64 = if is_quick { 8 << 20 } else { 128 << 20 };
    let buffer = || {
        let (label, usage) = (Some("copy"), wgpu::BufferUsages::STORAGE);
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
    };
    let pipeline = pipeline(gpu, WGSL, "copy");
    let (from, to) = (buffer(), buffer());
    let group = bind(gpu, &pipeline, 0, &[(0, from.as_entire_binding()), (1, to.as_entire_binding())]);
    let groups = (size / 16 / 256) as u32;
    let repeat = move || {
        watch.time(|pass| {
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            (0..DISPATCHES).for_each(|_| pass.dispatch_workgroups(256, groups / 256, 1));
        })
    };
    (Probe { bytes: Some(2 * size * DISPATCHES), ..probe("copy of a buffer", (0, 0), DISPATCHES) }, Box::new(repeat))
}

/// Reads and writes each texel of this many layers, as a kernel updates a stream.
fn in_place<'a>(gpu: &Gpu, watch: &'a Stopwatch<'a>, size: (u32, u32), count: u32) -> Job<'a> {
    let wgsl = format!(
        "
@group(0) @binding(0) var texels: texture_storage_2d_array<r32uint, read_write>;
@compute @workgroup_size(16, 16)
fn update(@builtin(global_invocation_id) id: vec3u) {{
    if (any(id.xy >= textureDimensions(texels))) {{
        return;
    }}
    for (var layer = 0u; layer < {count}u; layer++) {{
        textureStore(texels, id.xy, layer, textureLoad(texels, id.xy, layer) + vec4u(1u));
    }}
}}"
    );
    let pipeline = pipeline(gpu, &wgsl, "update");
    let texels = layers(&texture(gpu, size, count, wgpu::TextureFormat::R32Uint));
    let group = bind(gpu, &pipeline, 0, &[(0, wgpu::BindingResource::TextureView(&texels))]);
    let repeat = move || {
        watch.time(|pass| {
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            let groups = (size.0.div_ceil(16), size.1.div_ceil(16));
            (0..DISPATCHES).for_each(|_| pass.dispatch_workgroups(groups.0, groups.1, 1));
        })
    };
    let bytes = u64::from(size.0) * u64::from(size.1) * u64::from(count) * 8 * DISPATCHES;
    (Probe { bytes: Some(bytes), ..probe("update of textures", size, DISPATCHES) }, Box::new(repeat))
}

/// Passes for which no ray waits: once launching only active rays, once launching all.
fn empty<'a>(machine: &'a Machine, size: (u32, u32)) -> Result<Vec<Job<'a>>, String> {
    let gpu = machine.gpu().ok_or("no GPU")?;
    let viewed = Viewed::generated("cornell-box", None)?;
    let mut jobs: Vec<Job<'a>> = Vec::new();
    for (name, schedule) in
        [("empty pass, compact", ScheduleKind::Compact), ("empty pass, second", ScheduleKind::Second)]
    {
        let options = options(&viewed, Accelerator::Grid, schedule, size);
        let (plan, data) = Plan::new(&viewed.scene, &options, &machine.limits()).map_err(|e| e.to_string())?;
        let plan = Arc::new(plan);
        for passes in [32usize, 128, 256] {
            let executor = machine.wait(GpuExecutor::new(gpu.clone(), &plan, &data, false));
            let mut executor = executor.map_err(|e| e.to_string())?;
            let calls = [kernels::INTERSECT, kernels::TRAVERSE_GRID].map(Call::of);
            let calls: Vec<_> = calls.into_iter().cycle().take(passes).collect();
            let repeat = move || {
                executor.clear();
                machine.keep_clocks();
                machine.wait(executor.run(&calls, &StateCounts::default())).ok()?;
                executor.device_ns().filter(|&ns| ns > 0)
            };
            jobs.push((probe(name, size, passes as u64), Box::new(repeat)));
        }
    }
    Ok(jobs)
}

fn options(viewed: &Viewed, accelerator: Accelerator, schedule: ScheduleKind, size: (u32, u32)) -> Options {
    let (skip, steps_per_pass, shade) = (Skip::Off, 1, false);
    Options { accelerator, schedule, skip, steps_per_pass, shade, ..Options::new(viewed.primary(size)) }
}

/// A run with one step per pass, and the bytes of all its passes.
fn run<'a>(
    machine: &'a Machine,
    viewed: &Viewed,
    accelerator: Accelerator,
    size: (u32, u32),
    of_run: Probe,
) -> Result<Job<'a>, String> {
    let most = Duration::from_secs(20);
    let options = options(viewed, accelerator, ScheduleKind::Compact, size);
    let renderer = machine.wait(Renderer::new(&viewed.scene, &options, machine.device()));
    let mut renderer = renderer.map_err(|e| e.to_string())?;
    if machine.run(&mut renderer, most).map_err(|e| e.to_string())? == Ended::GivenUp {
        return Err(format!("a run takes more than {} s", most.as_secs_f64()));
    }
    let mut bytes = 0;
    for pass in renderer.passes() {
        let variant = renderer.plan().variant(pass.kernel).ok_or("a kernel without a variant")?;
        bytes += bytes_a_ray(variant)? * u64::from(pass.rays_in);
    }
    let probe = Probe { bytes: Some(bytes), passes: renderer.pass_count() as u64, ..of_run };
    let repeat = move || match machine.run(&mut renderer, most) {
        Ok(Ended::Done(time)) => time.device_ns,
        _ => None,
    };
    Ok((probe, Box::new(repeat)))
}

/// Bytes of streams and lists of active rays that a kernel may read and write for one ray.
///
/// # Errors
/// If the source and its reflection disagree.
pub(super) fn bytes_a_ray(variant: &Variant) -> Result<u64, String> {
    let (loads, stores) = (texels(&variant.source, "textureLoad("), texels(&variant.source, "textureStore("));
    for (stream, binding) in variant.streams() {
        let has = |texels: &BTreeSet<(String, String)>| texels.iter().any(|(name, _)| name == stream.name());
        if (has(&loads), has(&stores)) != (binding.reads, binding.writes) {
            return Err(format!("{}: the source of {} is not read right", variant.kernel.name(), stream.name()));
        }
    }
    let is_listed = variant.bindings.iter().any(|b| b.name == "live_rays");
    Ok(4 * (loads.len() + stores.len()) as u64 + if is_listed { 8 } else { 0 })
}

/// Stream and layer of every access in a composed source, each once.
fn texels(source: &str, call: &str) -> BTreeSet<(String, String)> {
    let accesses = source.match_indices(call).filter_map(|(at, _)| {
        let mut arguments = source[at + call.len()..].splitn(4, ',').map(str::trim);
        let (stream, _texel, layer) = (arguments.next()?, arguments.next()?, arguments.next()?);
        let layer: String = layer.chars().take_while(char::is_ascii_digit).collect();
        (PROGRAM.stream(stream).is_some() && !layer.is_empty()).then(|| (stream.to_owned(), layer))
    });
    accesses.collect()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::options::features::Features;
    use raystep_kernels::program::live;

    use super::*;

    #[test]
    fn texels_of_a_step_through_the_grid() {
        let features = Features { robust: true, grid: true, perspective: true, ..Features::default() };
        let variant = Variant::new(kernels::TRAVERSE_GRID, &features, &[]).expect("a kernel");
        // Loads: origin and direction 6, state tag, t and cell 3, tmax 3. Stores: tmax 3, state tag, cell, item 3.
        assert_eq!(bytes_a_ray(&variant), Ok(4 * (12 + 6)));
        let features = Features { live_lists: true, ..features };
        let lists = live::lists(&[kernels::TRAVERSE_GRID], &features);
        let listed = Variant::new(kernels::TRAVERSE_GRID, &features, &lists).expect("a kernel");
        assert_eq!(bytes_a_ray(&listed), Ok(4 * (12 + 6) + 8));
    }
}
