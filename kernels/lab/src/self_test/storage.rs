//! Bits on their way through textures and buffers: streams are textures of floats and of words, and must keep both.

use std::sync::Arc;

use raystep_kernels::shared::constants::INF;
use raystep_kernels::{Gpu, GpuError};

use super::shader::{Shader, bytes_of};
use super::{Bench, Check, Finding, Found, Group, Step, Verdict};
use crate::rays::Random;

const NORMAL: &str = "streams";
const SUBNORMAL: &str = "streams: subnormals";
const NOT_FINITE: &str = "streams: NaN";

pub(super) fn checks() -> [Check; 3] {
    let check = |name, shows| Check { group: Group::Arithmetic, name, shows };
    [
        check(NORMAL, "textures and buffers keep every bit of words and of normal floats"),
        check(SUBNORMAL, "whether they keep floats below 2^-126, or flush them to 0"),
        check(NOT_FINITE, "whether they keep NaNs with their payload, and infinities"),
    ]
}

pub(super) fn step() -> Step {
    Step::new(Group::Arithmetic, "textures and buffers", &[NORMAL, SUBNORMAL, NOT_FINITE], run)
}

/// Texels of each texture.
const TEXELS: u32 = 256;

/// One row of them.
const EXTENT: wgpu::Extent3d = wgpu::Extent3d { width: TEXELS, height: 1, depth_or_array_layers: 1 };

/// What the words of a texture are before.
const WORDS: u32 = 0x9e37_79b9;

/// The paths of bits, in the order in which they are read back.
const PATHS: [&str; 5] = [
    "loaded from r32float",
    "through r32float in place",
    "stored to r32float",
    "through r32uint",
    "through a buffer of f32",
];

/// The one of words.
const PATH_OF_WORDS: usize = 3;

fn patterns() -> Vec<u32> {
    const EDGES: [u32; 16] = [
        0,
        0x8000_0000,
        1,
        0x8000_0001,
        0x007f_ffff,
        0x0080_0000,
        0x807f_ffff,
        0x7f7f_ffff,
        0xff7f_ffff,
        0x7f80_0000,
        0xff80_0000,
        0x7fc0_0000,
        0x7fc0_dead,
        0xffff_ffff,
        0x7f80_0001,
        0xffa5_5aa5,
    ];
    let other = |i| {
        let bits = Random::of(i, 77).bits() as u32;
        // One in four is subnormal, one in four not finite.
        match i % 4 {
            0 => bits & 0x807f_ffff,
            1 => bits | 0x7f80_0000,
            _ => bits,
        }
    };
    EDGES.into_iter().chain([INF.to_bits(), 1f32.to_bits()]).chain((0..).map(other)).take(TEXELS as usize).collect()
}

fn run(bench: &mut Bench) -> Found {
    let patterns = patterns();
    let read = bench.machine.wait(through(&bench.gpu, &patterns))?;
    // What of these bits has changed on a path.
    let changed = |is: fn(u32) -> bool, path: usize| {
        let pairs = patterns.iter().zip(&read[path]).filter(|(given, read)| is(**given) && given != read);
        pairs.map(|(given, read)| (*given, *read)).collect::<Vec<_>>()
    };
    // Words have no classes; of floats, only normal ones must stay.
    let must_stay = |path| if path == PATH_OF_WORDS { |_| true } else { is_normal as fn(u32) -> bool };
    let wrong = PATHS.iter().enumerate().filter_map(|(path, name)| {
        let all = changed(must_stay(path), path);
        let (given, read) = all.first()?;
        Some(format!("{name}: {given:#010x} came back as {read:#010x}, and {} others changed", all.len() - 1))
    });
    let changes = |is: fn(u32) -> bool, verb: &str| {
        let differs = |path: &usize| *path != PATH_OF_WORDS && !changed(is, *path).is_empty();
        let paths: Vec<&str> = (0..PATHS.len()).filter(differs).map(|path| PATHS[path]).collect();
        if paths.is_empty() { "all kept".to_owned() } else { format!("{verb} when {}", paths.join(", ")) }
    };
    let found = |name, verdict, says: String| Finding::new(Group::Arithmetic, name, verdict, says);
    let normal = found(NORMAL, Verdict::Right, "every bit is kept".into());
    let all = vec![
        normal.counting(&[("values", (PATHS.len() * patterns.len()) as u64)]).wrong_by(wrong.collect()),
        found(SUBNORMAL, Verdict::Information, changes(is_subnormal, "flushed")),
        found(NOT_FINITE, Verdict::Information, changes(|bits| !f32::from_bits(bits).is_finite(), "changed")),
    ];
    Ok((all, Vec::new()))
}

fn is_normal(bits: u32) -> bool {
    f32::from_bits(bits).is_finite() && !is_subnormal(bits)
}

fn is_subnormal(bits: u32) -> bool {
    f32::from_bits(bits).is_subnormal()
}

/// What comes back of these bits on each path.
async fn through(gpu: &Arc<Gpu>, patterns: &[u32]) -> Result<[Vec<u32>; 5], GpuError> {
    use wgpu::TextureFormat::{R32Float, R32Uint};
    let shader = Shader::new(gpu, "pass_bits", include_str!("storage.wgsl").into());
    let zeros = [0; TEXELS as usize];
    let textures = [
        texture(gpu, R32Float, patterns),
        texture(gpu, R32Float, &zeros),
        texture(gpu, R32Uint, &[WORDS; TEXELS as usize]),
    ];
    let views = textures.each_ref().map(|texture| {
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
    });
    let given = [(); 2].map(|()| shader.given(patterns));
    let [loaded, copied] = [(); 2].map(|()| shader.room(patterns.len()));
    let of_textures = views.iter().map(wgpu::BindingResource::TextureView);
    let resources = of_textures.chain(given.iter().chain([&loaded, &copied]).map(wgpu::Buffer::as_entire_binding));
    let size = loaded.size();
    let copy = |encoder: &mut wgpu::CommandEncoder, read_back: &wgpu::Buffer| {
        encoder.copy_buffer_to_buffer(&loaded, 0, read_back, 0, size);
        for (place, texture) in (1..).zip(&textures) {
            let (bytes_per_row, rows_per_image) = (Some(4 * TEXELS), Some(1));
            let layout = wgpu::TexelCopyBufferLayout { offset: place * size, bytes_per_row, rows_per_image };
            let to = wgpu::TexelCopyBufferInfo { buffer: read_back, layout };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), to, EXTENT);
        }
        encoder.copy_buffer_to_buffer(&copied, 0, read_back, 4 * size, size);
    };
    let words = shader.run(resources, [TEXELS / 64, 1], PATHS.len() * patterns.len(), copy).await?;
    let of_path = |path: usize| {
        let undone = if path == PATH_OF_WORDS { WORDS } else { 0 };
        words.iter().skip(path * patterns.len()).take(patterns.len()).map(|word| word ^ undone).collect()
    };
    Ok([0, 1, 2, 3, 4].map(of_path))
}

/// A stream's texture with these texels.
fn texture(gpu: &Arc<Gpu>, format: wgpu::TextureFormat, texels: &[u32]) -> wgpu::Texture {
    use wgpu::TextureUsages as U;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("pass_bits"),
        size: EXTENT,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: U::STORAGE_BINDING | U::COPY_DST | U::COPY_SRC,
        view_formats: &[],
    });
    gpu.write_texture(texture.as_image_copy(), EXTENT, &bytes_of(texels));
    texture
}
