//! The kernels on a device, one launch at a time: as little as it takes to compare them with the host's build.

use std::collections::BTreeMap;
use std::sync::Arc;

use wgpu::util::DeviceExt as _;

use crate::compose::compose;
use crate::executor::gpu::{AdapterChoice, Gpu};
use crate::programs::grid_build::build::Build;
use crate::programs::grid_build::launch::Launch;
use crate::programs::grid_build::radix::digits_of;
use crate::programs::grid_build::tests::cases;
use crate::programs::grid_build::{KERNELS, modules};

/// What streams hold before a kernel writes them; nothing compared may have kept it.
const POISON: u32 = 0xdead_beef;

/// A kernel and what it imports, as one text.
pub(crate) fn composed(root: &str, wgsl: &str) -> String {
    let modules = modules();
    let source = |name: &str| {
        if name == root {
            return Some(wgsl);
        }
        modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_str())
    };
    compose(root, root, &source, &|_| None).expect("a text")
}

/// An adapter, or a word that there is none.
pub(crate) fn gpu() -> Option<Arc<Gpu>> {
    match pollster::block_on(Gpu::new(&AdapterChoice::Best)) {
        Ok(gpu) => {
            eprintln!("adapter: {} ({}, {})", gpu.info.name, gpu.info.backend, gpu.info.driver_info);
            Some(gpu)
        }
        Err(error) => {
            eprintln!("not tested: {error}");
            None
        }
    }
}

/// All words of a buffer.
pub(crate) fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<u32> {
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |result| result.expect("mapped"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    gpu.health().expect("a device that works");
    let view = copy.get_mapped_range(..).expect("mapped");
    bytemuck::pod_collect_to_vec(&view)
}

struct Stream {
    texture: wgpu::Texture,
    elements: u32,
}

struct Compiled {
    pipeline: wgpu::ComputePipeline,
    /// The group and index of each of its globals.
    globals: BTreeMap<String, (u32, u32)>,
}

struct Device {
    gpu: Arc<Gpu>,
    kernels: BTreeMap<&'static str, Compiled>,
}

/// A grid that is being built.
struct Run<'a> {
    device: &'a Device,
    build: wgpu::Buffer,
    vertices: wgpu::Buffer,
    streams: BTreeMap<String, Stream>,
}

impl Device {
    fn new(gpu: Arc<Gpu>) -> Self {
        let kernels = KERNELS.iter().map(|&(name, wgsl)| {
            let source = composed(name, wgsl);
            let module = naga::front::wgsl::parse_str(&source).expect("valid");
            let globals = module.global_variables.iter().filter_map(|(_, global)| {
                let at = global.binding?;
                Some((global.name.clone()?, (at.group, at.binding)))
            });
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some(name),
                // Nothing here counts on memory of a workgroup being 0.
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: None,
            });
            (name, Compiled { pipeline, globals: globals.collect() })
        });
        let kernels = kernels.collect();
        Self { gpu, kernels }
    }

    fn run(&self, build: &Build, vertices: &[f32]) -> Run<'_> {
        let buffer = |contents: &[u8], usage| {
            self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let some = if vertices.is_empty() { &[0.0; 9] } else { vertices };
        Run {
            device: self,
            build: buffer(bytemuck::bytes_of(build), wgpu::BufferUsages::UNIFORM),
            vertices: buffer(bytemuck::cast_slice(some), wgpu::BufferUsages::STORAGE),
            streams: BTreeMap::new(),
        }
    }
}

impl Run<'_> {
    /// Adds a stream; images are as wide as `width`, so that no two sets fold alike.
    fn stream(&mut self, name: &str, elements: u32, layers: u32, width: u32, value: u32) {
        let gpu = &self.device.gpu;
        let size = wgpu::Extent3d { width, height: elements.div_ceil(width).max(1), depth_or_array_layers: layers };
        let texture = gpu.device.create_texture_with_data(
            &gpu.queue,
            &wgpu::TextureDescriptor {
                label: Some(name),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Uint,
                usage: wgpu::TextureUsages::STORAGE_BINDING
                    | wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            bytemuck::cast_slice(&vec![value; (size.width * size.height * layers) as usize]),
        );
        self.streams.insert(name.to_owned(), Stream { texture, elements });
    }

    /// Launches a kernel over so many elements; `names` are its globals and the streams bound to them.
    fn launch(&self, kernel: &str, elements: u32, parameter: u32, names: &[(&str, &str)]) {
        let gpu = &self.device.gpu;
        let Compiled { pipeline, globals } = &self.device.kernels[kernel];
        let launch = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::bytes_of(&Launch::new(elements, parameter)),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let views: BTreeMap<&str, wgpu::TextureView> = names
            .iter()
            .map(|&(global, stream)| {
                let dimension = Some(wgpu::TextureViewDimension::D2Array);
                let descriptor = wgpu::TextureViewDescriptor { dimension, ..Default::default() };
                (global, self.streams[stream].texture.create_view(&descriptor))
            })
            .collect();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            for group in 0..2 {
                let entries: Vec<_> = globals
                    .iter()
                    .filter(|(_, at)| at.0 == group)
                    .map(|(name, at)| wgpu::BindGroupEntry {
                        binding: at.1,
                        resource: match name.as_str() {
                            "launch" => launch.as_entire_binding(),
                            "build" => self.build.as_entire_binding(),
                            "vertices" => self.vertices.as_entire_binding(),
                            name => wgpu::BindingResource::TextureView(&views[name]),
                        },
                    })
                    .collect();
                let layout = &pipeline.get_bind_group_layout(group);
                let descriptor = wgpu::BindGroupDescriptor { label: Some(kernel), layout, entries: &entries };
                pass.set_bind_group(group, &gpu.device.create_bind_group(&descriptor), &[]);
            }
            // Folded, with workgroups to spare.
            pass.dispatch_workgroups(3, Launch::new(elements, 0).blocks.div_ceil(3), 1);
        }
        gpu.submit([encoder.finish()]);
    }

    /// The elements of a stream's first layer.
    fn values(&self, name: &str) -> Vec<u32> {
        let gpu = &self.device.gpu;
        let Stream { texture, elements } = &self.streams[name];
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: 4 * u64::from(size.width) * u64::from(size.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size.width), rows_per_image: None };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            size,
        );
        gpu.submit([encoder.finish()]);
        let mut values = read(gpu, &buffer);
        values.truncate(*elements as usize);
        values
    }

    /// Turns a stream into its prefix sums; returns their total.
    fn prefix(&mut self, name: &str) -> u32 {
        let elements = self.streams[name].elements;
        let blocks = elements.div_ceil(256);
        let sums = format!("sums of {name}");
        self.stream(&sums, blocks, 1, 64, POISON);
        if elements == 0 {
            return 0;
        }
        let names = [("values", name), ("sums", sums.as_str())];
        self.launch("scan", elements, 0, &names);
        if blocks == 1 {
            return self.values(&sums)[0];
        }
        let total = self.prefix(&sums);
        self.launch("add", elements, 0, &names);
        total
    }

    /// The whole build; returns starts and lists.
    fn lists(&mut self, triangles: u32, cells: u32) -> (Vec<u32>, Vec<u32>) {
        self.stream("box", triangles, 6, 320, POISON);
        self.stream("first_span", triangles, 1, 320, POISON);
        self.launch("bound", triangles, 0, &[("box", "box"), ("first_span", "first_span")]);
        let spans = self.prefix("first_span");
        let of_spans = [("triangle", 1), ("cells_at", 3), ("mask", 1), ("first_reference", 1)];
        for (name, layers) in of_spans {
            self.stream(name, spans, layers, 448, POISON);
        }
        let of_spans = of_spans.map(|(name, _)| (name, name));
        let names = [&of_spans[..], &[("box", "box"), ("first_span", "first_span")]].concat();
        self.launch("span", spans, 0, &names);
        let references = self.prefix("first_reference");
        for name in ["cell 0", "triangle 0", "cell 1", "triangle 1"] {
            self.stream(name, references, 1, 512, POISON);
        }
        let names = [&of_spans[..], &[("cell_out", "cell 0"), ("triangle_out", "triangle 0")]].concat();
        self.launch("emit", spans, 0, &names);
        let (mut from, mut to) = (("cell 0", "triangle 0"), ("cell 1", "triangle 1"));
        for digit in 0..digits_of(cells) {
            self.stream("tally", 16 * references.div_ceil(256), 1, 192, POISON);
            let names = [("cell_in", from.0), ("triangle_in", from.1), ("tally", "tally")];
            self.launch("histogram", references, digit, &names);
            self.prefix("tally");
            let names = [&names[..], &[("cell_out", to.0), ("triangle_out", to.1)]].concat();
            self.launch("scatter", references, digit, &names);
            (from, to) = (to, from);
        }
        self.stream("begin", cells, 1, 576, 0);
        self.stream("end", cells, 1, 576, 0);
        self.stream("start", cells, 1, 576, POISON);
        self.launch("mark", references, 0, &[("cell_in", from.0), ("begin", "begin"), ("end", "end")]);
        self.launch("measure", cells, 0, &[("begin", "begin"), ("end", "end"), ("start", "start")]);
        let total = self.prefix("start");
        let mut starts = self.values("start");
        starts.push(total);
        (starts, self.values(from.1))
    }
}

#[test]
fn a_device_builds_the_grids_that_the_host_builds() {
    let Some(gpu) = gpu() else { return };
    let device = Device::new(gpu);
    for (name, vertices, wanted) in cases() {
        let triangles = (vertices.len() / 9) as u32;
        let mut run = device.run(&Build::new(&wanted.grid, wanted.growth, triangles), &vertices);
        let (starts, items) = run.lists(triangles, wanted.cells.len() as u32 - 1);
        assert!(starts == wanted.cells, "{name}: other starts");
        assert!(items == wanted.items, "{name}: other lists");
    }
}

#[test]
fn sums_that_are_too_large_stay_at_the_largest_number_on_a_device() {
    let Some(gpu) = gpu() else { return };
    let device = Device::new(gpu);
    let mut run = device.run(&Build::default(), &[]);
    run.stream("values", 1000, 1, 64, 1 << 30);
    assert_eq!(run.prefix("values"), u32::MAX);
    let values = run.values("values");
    assert_eq!(values[..5], [0, 1 << 30, 2 << 30, 3 << 30, u32::MAX]);
    assert!(values[5..].iter().all(|&value| value == u32::MAX), "{values:x?}");
}
