//! Bytes that passes move, compared with the device's copy speed, and the cost of a pass that moves none.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::executor::gpu::GpuExecutor;
use raystep_kernels::program::schedule::Call;
use raystep_kernels::programs::closest_hit::{PROGRAM, kernels};
use raystep_kernels::shader::Variant;
use raystep_kernels::tables::state::StateCounts;
use raystep_kernels::{Accelerator, Options, Plan, Renderer, ScheduleKind};
use raystep_lab::configuration::Configuration;
use raystep_lab::meter::Ended;
use raystep_lab::tidy::{Row, TIMES, count, joined};
use raystep_lab::{Size, Subject, columns};

use crate::measure::{Section, Setup};
use crate::probe::{Job, Kernel, Stopwatch, buffer, layers, texture};
use crate::sections::two_scenes;
use crate::subjects::generated;

const GROUPS: &[&[&str]] =
    &[columns![schema_version section what scene accelerator width_px height_px passes bytes], TIMES, columns![value]];

/// The columns of a section that times kernels on their own: the passes of a submission or run, the bytes that all of
/// them read and write at least, and a value that is not a time.
pub(crate) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Dispatches per submission of the copies.
const DISPATCHES: u64 = 16;

/// Time limit of a run.
const LONGEST_RUN: Duration = Duration::from_secs(20);

pub(crate) fn measure(section: &mut Section<'_>) -> Result<(), String> {
    let setup = section.setup;
    let Some(watch) = Stopwatch::new(setup) else {
        section.notes.push("the CPU neither submits passes nor copies textures".into());
        return Ok(());
    };
    section.time(vec![buffers(section, &watch)]);
    for &size in setup.choose(&[[512, 512], [1920, 1080]][..], &[[256, 256], [512, 512]], &[[128, 128]]) {
        section.time([2, 4, 8, 16].map(|layers| in_place(section, &watch, size, layers)).into());
        section.time(empty(section, &watch, size)?);
        let mut jobs = Vec::new();
        for subject in two_scenes()? {
            for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
                // At least one run of each size.
                if section.is_over() && !jobs.is_empty() {
                    let (name, [width, height]) = (&subject.scene.name, size);
                    section.late(&format!("{name} {accelerator}, {width}x{height}"));
                } else {
                    jobs.push(run(section, &subject, accelerator, size)?);
                }
            }
        }
        section.time(jobs);
    }
    Ok(())
}

fn row(section: &Section<'_>, what: &str, [width, height]: [u32; 2], passes: u64) -> Row {
    section.row().set("what", what).set("width_px", width).set("height_px", height).set("passes", passes)
}

/// Copies one buffer to another.
fn buffers<'a>(section: &Section<'_>, watch: &'a Stopwatch<'a>) -> Job<'a> {
    const WGSL: &str = "
@group(0) @binding(0) var<storage, read> from_words: array<vec4u>;
@group(0) @binding(1) var<storage, read_write> to_words: array<vec4u>;
@compute @workgroup_size(256)
fn copy(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 256u + id.x;
    to_words[i] = from_words[i];
}";
    let size: u64 = if section.setup.is_quick { 8 << 20 } else { 128 << 20 };
    let [from, to] = [(); 2].map(|()| buffer(watch.gpu, size, wgpu::BufferUsages::STORAGE));
    let kernel = Kernel::new(watch.gpu, WGSL, "copy", &[&[(0, from.as_entire_binding()), (1, to.as_entire_binding())]]);
    let row = row(section, "copy of a buffer", [0; 2], DISPATCHES).set("bytes", 2 * size * DISPATCHES);
    watch.job(row, kernel, [256, (size / 16 / 256 / 256) as u32], DISPATCHES)
}

/// Reads and writes each texel of this many layers, as a kernel updates a stream.
fn in_place<'a>(section: &Section<'_>, watch: &'a Stopwatch<'a>, size: [u32; 2], count: u32) -> Job<'a> {
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
    let texels = layers(&texture(watch.gpu, size, count, wgpu::TextureFormat::R32Uint));
    let kernel = Kernel::new(watch.gpu, &wgsl, "update", &[&[(0, wgpu::BindingResource::TextureView(&texels))]]);
    let bytes = u64::from(size[0]) * u64::from(size[1]) * u64::from(count) * 8 * DISPATCHES;
    let row = row(section, "update of textures", size, DISPATCHES).set("bytes", bytes);
    watch.job(row, kernel, size.map(|side| side.div_ceil(16)), DISPATCHES)
}

/// Passes for which no ray waits: once launching only active rays, once launching all.
fn empty<'a>(section: &Section<'_>, watch: &'a Stopwatch<'a>, size: [u32; 2]) -> Result<Vec<Job<'a>>, String> {
    let (subject, meter) = (generated("cornell-box", None)?, &watch.setup.meter);
    let mut jobs: Vec<Job<'a>> = Vec::new();
    for (name, schedule) in
        [("empty pass, compact", ScheduleKind::Compact), ("empty pass, second", ScheduleKind::Second)]
    {
        let options = options(&subject, Accelerator::Grid, schedule, size);
        let planned = Plan::new(&subject.scene, &options, &meter.machine.limits());
        let (plan, data) = planned.map_err(|e| e.to_string())?;
        let plan = Arc::new(plan);
        for passes in [32usize, 128, 256] {
            let executor = meter.machine.wait(GpuExecutor::new(watch.gpu.clone(), &plan, &data, false));
            let mut executor = executor.map_err(|e| e.to_string())?;
            let calls = [kernels::INTERSECT, kernels::TRAVERSE_GRID].map(Call::of);
            let calls: Vec<_> = calls.into_iter().cycle().take(passes).collect();
            let repeat = move || {
                executor.clear();
                meter.machine.wait(meter.keep_clocks());
                meter.machine.wait(executor.run(&calls, &StateCounts::default())).ok()?;
                executor.device_ns().filter(|&ns| ns > 0)
            };
            jobs.push((row(section, name, size, passes as u64), Box::new(repeat)));
        }
    }
    Ok(jobs)
}

/// One step per pass.
fn options(subject: &Subject, accelerator: Accelerator, schedule: ScheduleKind, size: [u32; 2]) -> Options {
    let [width, height] = size;
    let rays = subject.camera_rays(Size { width, height });
    Configuration::new(accelerator, schedule, 1).of(&Options { shade: false, ..Options::new(rays) })
}

/// A run with one step per pass, and the bytes of all its passes.
fn run<'a>(
    section: &Section<'a>,
    subject: &Subject,
    accelerator: Accelerator,
    size: [u32; 2],
) -> Result<Job<'a>, String> {
    let setup: &'a Setup = section.setup;
    let machine = &setup.meter.machine;
    let options = options(subject, accelerator, ScheduleKind::Compact, size);
    let renderer = machine.wait(Renderer::new(&subject.scene, &options, &machine.device));
    let mut renderer = renderer.map_err(|e| e.to_string())?;
    let run = move |renderer: &mut Renderer| machine.wait(setup.meter.run_within(LONGEST_RUN, renderer));
    if run(&mut renderer).map_err(|e| e.to_string())? == Ended::GivenUp {
        return Err(format!("a run takes more than {} s", LONGEST_RUN.as_secs()));
    }
    let row = row(section, "run of one step a pass", size, renderer.pass_count() as u64);
    let row = row.set("scene", subject.scene.name.as_str()).set("accelerator", accelerator.name());
    let row = row.set("bytes", bytes_of(&renderer)?);
    let repeat = move || match run(&mut renderer) {
        Ok(Ended::Done(time)) => time.device_ns,
        _ => None,
    };
    Ok((row, Box::new(repeat)))
}

/// Bytes of streams and lists of active rays that the passes of a run may read and write.
fn bytes_of(renderer: &Renderer) -> Result<u64, String> {
    let mut bytes = 0;
    for pass in renderer.passes() {
        let variant = renderer.plan().variant(pass.kernel).ok_or("a kernel without a variant")?;
        bytes += bytes_per_ray(variant)? * u64::from(pass.rays_in);
    }
    Ok(bytes)
}

/// Bytes of streams and lists of active rays that a kernel may read and write for one ray.
///
/// # Errors
/// If the source and its reflection disagree.
pub(crate) fn bytes_per_ray(variant: &Variant) -> Result<u64, String> {
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
        assert_eq!(bytes_per_ray(&variant), Ok(4 * (12 + 6)));
        let features = Features { live_lists: true, ..features };
        let lists = live::lists(&[kernels::TRAVERSE_GRID], &features);
        let listed = Variant::new(kernels::TRAVERSE_GRID, &features, &lists).expect("a kernel");
        assert_eq!(bytes_per_ray(&listed), Ok(4 * (12 + 6) + 8));
    }
}
