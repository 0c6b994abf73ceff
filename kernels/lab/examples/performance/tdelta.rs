//! §4.2.3 of the paper: tDelta and step are constant along a ray, but the paper recomputes them in every pass, to save
//! memory and because computation may be cheaper than a lookup (Fatahalian et al. 2004).
//!
//! Compares the traverse kernel with the paper's numerics, as raystep composes it, with two edited versions that load
//! these values. All rays stay in TRAV and none leaves the grid, so that every pass processes all of them.

use raystep_kernels::Gpu;
use raystep_kernels::options::features::Features;
use raystep_kernels::programs::closest_hit::kernels;
use raystep_kernels::programs::closest_hit::states::TRAV;
use raystep_kernels::shader::Variant;

use crate::bytes::bytes_per_ray;
use crate::measure::Section;
use crate::probe::{Job, Kernel, Stopwatch, buffer, layers, texture};

/// Cells along each axis; rays start in the middle.
const CELLS: i32 = 200;
const WIDTH: f32 = 0.01;
/// Passes per submission: fewer than the steps from the middle to a face.
const PASSES: u64 = 64;

/// Name, source text that provides the ray's constants, and what is loaded as origin and direction.
type Loading = (&'static str, &'static str, fn(&Rays) -> [&Vec<u32>; 2]);

const VARIANTS: [Loading; 3] = [
    ("worked out", WORKED_OUT, |rays| [&rays.origin, &rays.direction]),
    ("loaded, 6 layers", "let ray = GridRay(vec3f(0.0), load_direction(texel), load_origin(texel));", |rays| {
        [&rays.delta, &rays.step]
    }),
    (
        "loaded, 3 layers",
        "let delta = load_origin(texel);\n    let ray = GridRay(vec3f(0.0), delta, abs(delta));",
        // The second stream is not loaded.
        |rays| [&rays.signed_delta, &rays.step],
    ),
];
const WORKED_OUT: &str = "let ray = grid_ray(load_origin(texel), load_direction(texel));";

pub(crate) fn measure(section: &mut Section<'_>) -> Result<(), String> {
    let setup = section.setup;
    let Some(watch) = Stopwatch::new(setup) else {
        section.notes.push("on the CPU, a ray's streams are in one row, so there is no texture to load from".into());
        return Ok(());
    };
    let sizes: &[[u32; 2]] = if setup.is_quick { &[[128, 128]] } else { &[[512, 512], [1920, 1080]] };
    for &size in sizes {
        let runs =
            VARIANTS.iter().map(|variant| Steps::new(watch.gpu, size, variant)).collect::<Result<Vec<_>, _>>()?;
        let jobs = VARIANTS.iter().zip(&runs).map(|((what, ..), steps)| -> Job<'_> {
            let bytes = steps.bytes_per_ray * u64::from(size[0]) * u64::from(size[1]) * PASSES;
            let row = section.row().set("what", *what).set("width_px", size[0]).set("height_px", size[1]);
            (row.set("passes", PASSES).set("bytes", bytes), Box::new(|| steps.time(&watch)))
        });
        let first = section.table.rows.len();
        section.time(jobs.collect());
        let cells = runs.iter().map(|steps| steps.cells(&watch)).collect::<Result<Vec<_>, _>>()?;
        for (row, other) in section.table.rows[first..].iter_mut().zip(&cells) {
            let differ = other.iter().zip(&cells[0]).filter(|(a, b)| a != b).count();
            *row = row.clone().set("value", differ as f64 / other.len() as f64);
        }
    }
    Ok(())
}

/// One variant, ready to run.
struct Steps {
    size: [u32; 2],
    kernel: Kernel,
    /// State and tmax, and their initial values.
    streams: [[wgpu::Texture; 2]; 2],
    bytes_per_ray: u64,
}

impl Steps {
    fn new(gpu: &Gpu, size: [u32; 2], (_, ray, constants): &Loading) -> Result<Self, String> {
        let features = Features { grid: true, perspective: true, ..Features::default() };
        let variant = Variant::new(kernels::TRAVERSE_GRID, &features, &[]).map_err(|e| e.to_string())?;
        // Rays that are not intersected in between continue at once.
        let next = "let tag = select(ISECT_NO_HIT, ISECT_HIT, keeps_hit(texel));";
        let source = replaced(&variant.source, next, "let tag = TRAV;")?;
        let source = replaced(&source, WORKED_OUT, ray)?;
        let (loads_origin, loads_direction) = (ray.contains("load_origin"), ray.contains("load_direction"));
        // If the constants are computed, the origin is dead code, and compilers remove it.
        let needs_origin = loads_origin && *ray != WORKED_OUT;
        let dead = 12 * (u64::from(!needs_origin) + u64::from(!loads_direction));
        let bytes_per_ray = bytes_per_ray(&variant)? - dead;

        use wgpu::TextureFormat::{R32Float, R32Uint};
        let rays = Rays::new(size);
        let filled = |count, format, words: &[u32]| {
            let texture = texture(gpu, size, count, format);
            gpu.write_texture(texture.as_image_copy(), texture.size(), bytemuck::cast_slice(words));
            texture
        };
        let constants = constants(&rays).map(|words| filled(3, R32Float, words));
        let streams = [(4, R32Uint, &rays.state), (3, R32Float, &rays.tmax)]
            .map(|(count, format, words)| [texture(gpu, size, count, format), filled(count, format, words)]);
        let views = [&constants[0], &constants[1], &streams[0][0], &streams[1][0]].map(layers);
        let is_used = [loads_origin, loads_direction, true, true];
        let resources = (0..).zip(&views).zip(is_used).filter(|(_, used)| *used);
        let resources: Vec<_> = resources.map(|((i, view), _)| (i, wgpu::BindingResource::TextureView(view))).collect();
        let buffer = |contents: &[u32], usage| gpu.filled_buffer("measured", bytemuck::cast_slice(contents), usage);
        let grid = buffer(&grid(), wgpu::BufferUsages::UNIFORM);
        let sent = buffer(&[0; 8], wgpu::BufferUsages::STORAGE);
        let groups = [&resources[..], &[(1, grid.as_entire_binding())], &[(0, sent.as_entire_binding())]];
        let kernel = Kernel::new(gpu, &source, "traverse_grid", &groups);
        Ok(Self { size, kernel, streams, bytes_per_ray })
    }

    /// Starts over and returns the nanoseconds of all passes.
    fn time(&self, watch: &Stopwatch<'_>) -> Option<u64> {
        let mut encoder = watch.gpu.device.create_command_encoder(&Default::default());
        for [now, first] in &self.streams {
            encoder.copy_texture_to_texture(first.as_image_copy(), now.as_image_copy(), now.size());
        }
        watch.gpu.submit([encoder.finish()]);
        watch.time(|pass| self.kernel.dispatch(pass, self.size.map(|side| side.div_ceil(16)), PASSES))
    }

    /// The cell of every ray.
    fn cells(&self, watch: &Stopwatch<'_>) -> Result<Vec<u32>, String> {
        let [width, height] = self.size;
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(row * height);
        let buffer = buffer(watch.gpu, size, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        let mut encoder = watch.gpu.device.create_command_encoder(&Default::default());
        let origin = wgpu::Origin3d { x: 0, y: 0, z: 2 };
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { origin, ..self.streams[0][0].as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        let reading = watch.gpu.read_after(encoder.finish(), buffer, size);
        let bytes = watch.setup.meter.machine.wait(reading).map_err(|e| e.to_string())?;
        let rows = bytes.chunks_exact(row as usize).map(|row| &row[..4 * width as usize]);
        Ok(rows.flat_map(|row| row.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]))).collect())
    }
}

/// Replaces text that must occur exactly once.
fn replaced(source: &str, from: &str, to: &str) -> Result<String, String> {
    match source.matches(from).count() {
        1 => Ok(source.replace(from, to)),
        n => Err(format!("the traverse kernel has {n} times, and not once: {from}")),
    }
}

/// The grid uniform: a cube around the origin.
fn grid() -> [u32; 16] {
    let corner = (-0.5 * WIDTH * CELLS as f32).to_bits();
    let (cells, width, inverse) = (CELLS as u32, WIDTH.to_bits(), (1.0 / WIDTH).to_bits());
    let mut words = [0; 16];
    for (first, word) in [(0, corner), (4, cells), (8, width), (12, inverse)] {
        words[first..first + 3].fill(word);
    }
    words
}

/// The words of every stream, layer by layer.
#[derive(Default)]
struct Rays {
    origin: Vec<u32>,
    direction: Vec<u32>,
    delta: Vec<u32>,
    signed_delta: Vec<u32>,
    step: Vec<u32>,
    state: Vec<u32>,
    tmax: Vec<u32>,
}

impl Rays {
    /// Rays of a camera in the middle, as the paper's setup kernel leaves them.
    fn new([width, height]: [u32; 2]) -> Self {
        let mut rays = Self::default();
        // Slightly off the corner of the middle cell.
        let origin = [0.3, 0.4, 0.6].map(|share| share * WIDTH);
        for axis in 0..3 {
            for pixel in 0..width * height {
                let at = |i: u32, n: u32| (i as f32 + 0.5) / n as f32 * 2.0 - 1.0;
                let direction = [at(pixel % width, width), at(pixel / width, height), -1.0][axis];
                let delta = (WIDTH / direction).abs();
                let ahead = if direction > 0.0 { WIDTH } else { 0.0 };
                // The paper's threshold (§4.2.3); INF is 2^100, as everywhere in raystep.
                let tmax = if direction.abs() < 0.001 { 100f32.exp2() } else { (ahead - origin[axis]) / direction };
                rays.origin.push(origin[axis].to_bits());
                rays.direction.push(direction.to_bits());
                rays.delta.push(delta.to_bits());
                rays.signed_delta.push(delta.copysign(direction).to_bits());
                rays.step.push(1f32.copysign(direction).to_bits());
                rays.tmax.push(tmax.to_bits());
            }
        }
        let middle = CELLS / 2;
        let cell = (middle + CELLS * (middle + CELLS * middle)) as u32;
        for word in [TRAV, 100f32.exp2().to_bits(), cell, 0] {
            rays.state.extend(std::iter::repeat_n(word, (width * height) as usize));
        }
        rays
    }
}
