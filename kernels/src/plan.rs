//! What a run needs, worked out before any GPU call, and what it leaves out, with the reason.
//!
//! The plan follows from reflection: a stream or buffer is allocated if, and only if, a kernel of the
//! schedule, compiled with the run's options, binds it.

use std::collections::BTreeSet;
use std::fmt;

use raystep_scenes::{Light, Projection, Scene};

use crate::buffer::{self, BUFFERS};
use crate::features::Features;
use crate::grid::{self, GridError, GridSize};
use crate::kernel::{KERNELS, Kernel};
use crate::options::{Accelerator, Numerics, Options, RaySource};
use crate::scene_data::{SceneData, traced_camera};
use crate::schedule::Schedule;
use crate::shader::{Resource, ShaderError, Variant};
use crate::state;
use crate::stream::{STREAMS, Stream};
use crate::units::Units;

/// What an executor can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest image side in pixels.
    pub image_side: u32,
    /// Most bytes of one storage buffer.
    pub storage_bytes: u64,
    /// Most rays.
    pub rays: u64,
}

impl Limits {
    /// The CPU twins': memory is the only limit, images are kept to 2²⁶ pixels, some 6 GB of streams.
    pub const CPU: Self = Self { image_side: 32_768, storage_bytes: 1 << 32, rays: 1 << 26 };
}

impl From<&wgpu::Limits> for Limits {
    fn from(limits: &wgpu::Limits) -> Self {
        let groups = limits.max_compute_workgroups_per_dimension;
        let side = limits.max_texture_dimension_2d.min(groups.saturating_mul(crate::shared::constants::WORKGROUP));
        Self {
            image_side: side,
            storage_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            rays: 1 << 28,
        }
    }
}

/// A run that cannot be planned.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The image has no pixels, or more than fit.
    #[error(
        "an image of {width}x{height} pixels cannot be traced here: each side must be 1 to {side}, and their product at most {rays}"
    )]
    ImageSize {
        /// Pixels a row.
        width: u64,
        /// Rows.
        height: u64,
        /// Largest side.
        side: u32,
        /// Most pixels.
        rays: u64,
    },
    /// A buffer is larger than the adapter binds.
    #[error("{name} needs {} in one buffer, the adapter binds at most {}: {} too many", Bytes(*bytes), Bytes(*limit), Bytes(bytes - limit))]
    BufferSize {
        /// The buffer.
        name: &'static str,
        /// Its size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// More triangles than an id can name.
    #[error("the scene has {0} triangles, at most {max} can be traced", max = u32::MAX / 9)]
    TooManyTriangles(usize),
    /// The scene is so small for its distance from the origin that f32 cannot tell its points apart.
    #[error(
        "the scene's points are not finite, or are a hundred million times farther from the origin than from each other: move the scene to the origin"
    )]
    Extent,
    /// The camera cannot make rays.
    #[error("the camera cannot make rays: {0}")]
    Camera(String),
    /// A ray that was given cannot be traced.
    #[error("ray {index} cannot be traced: {reason}")]
    Ray {
        /// Its place in the list.
        index: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// An attribute of the scene has the wrong number of entries.
    #[error("the scene has {triangles} triangles, but {entries} entries of {name}")]
    Attribute {
        /// The attribute.
        name: &'static str,
        /// Its entries.
        entries: usize,
        /// Triangles.
        triangles: usize,
    },
    /// A texture whose texels do not match its size, or more texels than can be indexed.
    #[error(
        "texture {index} of {width}x{height} has {texels} texels; they must match, and all textures together have at most {MAX_TEXELS}"
    )]
    Texture {
        /// Its place in the scene.
        index: usize,
        /// Texels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Texels that it has.
        texels: usize,
    },
    /// The grid cannot be built.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A kernel of ours is wrong.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

/// Most texels of all textures: two words each must have a 32-bit index, and a row's product a sign.
pub const MAX_TEXELS: u64 = 1 << 30;

/// Something with a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planned<T> {
    /// What it is.
    pub what: T,
    /// Its bytes on the executor.
    pub bytes: u64,
}

/// Who made it unnecessary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Because {
    /// The scene does not have it.
    Scene,
    /// The options do not ask for it.
    Options,
    /// The result that is wanted does not show it.
    View,
}

/// Something that a run does without.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// `kernel shade`, `stream counters`, `buffer normals`, `code for spot lights`, …
    pub what: String,
    /// Where the reason lies.
    pub because: Because,
    /// The reason.
    pub reason: &'static str,
}

/// A run, before it starts.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Texels a row of every stream.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rays; fewer than texels where given rays do not fill the last row.
    pub rays: u64,
    /// Triangles.
    pub triangles: u64,
    /// Options decided.
    pub features: Features,
    /// Order of kernels.
    pub schedule: Schedule,
    /// The kernels as they will be compiled, in order of first use.
    pub variants: Vec<Variant>,
    /// Streams to allocate.
    pub streams: Vec<Planned<Stream>>,
    /// Uniforms and buffers to allocate, by name.
    pub buffers: Vec<Planned<&'static str>>,
    /// What is left out.
    pub left_out: Vec<LeftOut>,
}

/// The housekeeping buffers of the GPU executor: live counts, one slot a pass of a batch, and their copy
/// for reading back.
pub const COUNT_SLOTS: u64 = 256;
/// Bytes between two slots: a dynamic offset's alignment on every adapter.
pub const COUNT_SLOT_BYTES: u64 = 256;

impl Plan {
    /// Plans a run and prepares the bytes that it binds. No GPU is involved.
    ///
    /// # Errors
    /// Where the scene or the options do not fit `limits`, with the numbers.
    pub fn new(scene: &Scene, options: &Options, limits: &Limits) -> Result<(Self, SceneData), PlanError> {
        let units = Units::of(&scene.bounds());
        let (width, height, rays) = image_size(options, limits)?;
        check_scene(scene, units)?;
        check_rays(options, units)?;
        let features = features(scene, options, units);

        let given = matches!(options.rays, RaySource::Given(_));
        let schedule = Schedule::new(options.schedule, options.accelerator, given, options.shade);
        let variants =
            schedule.kernels().into_iter().map(|k| Variant::new(k, &features)).collect::<Result<Vec<_>, _>>()?;
        let bound: BTreeSet<&str> = variants.iter().flat_map(|v| &v.bindings).map(|b| b.name.as_str()).collect();

        // What is known before the grid is built is refused before it is built.
        let triangles = scene.triangles.len() as u64;
        for (name, bytes) in [("vertices", 36), ("normals", 36), ("texcoords", 24), ("vertex_colors", 36)] {
            if bound.contains(name) {
                check_buffer(name, triangles * bytes, limits)?;
            }
        }
        if let GridSize::Cells(cells) = options.grid
            && bound.contains("grid_cells")
        {
            check_buffer("grid_cells", 4 * (grid::check_cells(cells)? + 1), limits)?;
        }
        let data =
            SceneData::build(scene, options, features, units, limits.storage_bytes, |name| bound.contains(name))?;

        let streams = STREAMS
            .iter()
            .filter(|s| bound.contains(s.name))
            .map(|s| Planned {
                what: s.stream,
                bytes: u64::from(width) * u64::from(height) * 4 * s.layers.len() as u64,
            })
            .collect();
        let mut buffers = Vec::new();
        for info in BUFFERS.iter().filter(|b| bound.contains(b.name)) {
            let bytes = data.bytes(info.name).map_or(0, |b| b.len() as u64);
            if !info.is_uniform {
                check_buffer(info.name, bytes, limits)?;
            }
            buffers.push(Planned { what: info.name, bytes });
        }
        for name in ["live_counts", "live_counts_copy"] {
            buffers.push(Planned { what: name, bytes: COUNT_SLOTS * COUNT_SLOT_BYTES });
        }
        let mut plan = Self {
            width,
            height,
            rays,
            triangles,
            features,
            schedule,
            variants,
            streams,
            buffers,
            left_out: Vec::new(),
        };
        plan.left_out = left_out(&plan, scene, options);
        Ok((plan, data))
    }

    /// Bytes of all streams and buffers.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.streams.iter().map(|s| s.bytes).sum::<u64>() + self.buffers.iter().map(|b| b.bytes).sum::<u64>()
    }

    /// Whether the run has this stream.
    #[must_use]
    pub fn has_stream(&self, stream: Stream) -> bool {
        self.streams.iter().any(|s| s.what == stream)
    }

    /// The variant of a kernel, if the run has it.
    #[must_use]
    pub fn variant(&self, kernel: Kernel) -> Option<&Variant> {
        self.variants.iter().find(|v| v.kernel == kernel)
    }

    /// Most passes that a run can take before it must be over: every ray visits at most nx + ny + nz + 2
    /// cells and tests no list more than once. The paper's numerics can exceed it, see `docs`.
    #[must_use]
    pub fn pass_bound(&self, data: &SceneData) -> u64 {
        let longest = data.grid_cells.windows(2).map(|w| u64::from(w[1] - w[0])).max();
        let walk = match longest {
            Some(longest) => data.grid.cells.iter().map(|&n| n as u64).sum::<u64>().saturating_add(2) * (longest + 2),
            None => self.triangles + 1,
        };
        2 * walk + 16
    }
}

fn image_size(options: &Options, limits: &Limits) -> Result<(u32, u32, u64), PlanError> {
    let (width, height, rays) = match &options.rays {
        RaySource::Camera { width, height, .. } => {
            (u64::from(*width), u64::from(*height), u64::from(*width) * u64::from(*height))
        }
        RaySource::Given(rays) => {
            let width = (rays.len() as u64).clamp(1, 4096.min(u64::from(limits.image_side)));
            (width, (rays.len() as u64).div_ceil(width).max(1), rays.len() as u64)
        }
    };
    let side = u64::from(limits.image_side);
    if width == 0 || height == 0 || width > side || height > side || width * height > limits.rays {
        return Err(PlanError::ImageSize { width, height, side: limits.image_side, rays: limits.rays });
    }
    Ok((width as u32, height as u32, rays))
}

/// Farthest coordinate in traced units, where the scene's extent is 1 to 2. From 2²⁴ on, f32 does not see
/// the scene's extent at all; up to here, t stays far below [`crate::shared::constants::INF`] even along an
/// axis that a ray is nearly parallel to.
const FARTHEST: f64 = (1u64 << 28) as f64;

fn check_scene(scene: &Scene, units: Units) -> Result<(), PlanError> {
    let bounds = scene.bounds();
    let farthest = bounds.min.abs().max(bounds.max.abs()).as_dvec3().max_element() * units.scale();
    if !scene.triangles.is_empty() && (farthest.is_nan() || farthest > FARTHEST) {
        return Err(PlanError::Extent);
    }

    let triangles = scene.triangles.len();
    if triangles > (u32::MAX / 9) as usize {
        return Err(PlanError::TooManyTriangles(triangles));
    }
    let attributes = [
        ("normals", scene.normals.as_ref().map(Vec::len)),
        ("texcoords", scene.texcoords.as_ref().map(Vec::len)),
        ("colors", scene.colors.as_ref().map(Vec::len)),
        ("triangle_materials", Some(scene.triangle_materials.len())),
    ];
    for (name, entries) in attributes {
        if let Some(entries) = entries.filter(|&n| n != triangles) {
            return Err(PlanError::Attribute { name, entries, triangles });
        }
    }
    let mut all_texels = 0;
    for (index, t) in scene.textures.iter().enumerate() {
        let (width, height, texels) = (t.width, t.height, t.texels.len());
        let size = u64::from(width) * u64::from(height);
        all_texels += size.min(MAX_TEXELS + 1);
        if size == 0 || size != texels as u64 || all_texels > MAX_TEXELS {
            return Err(PlanError::Texture { index, width, height, texels });
        }
    }
    let out_of_range = scene.triangle_materials.iter().any(|&m| m as usize >= scene.materials.len());
    let missing = scene.materials.iter().filter_map(|m| m.texture).any(|t| t as usize >= scene.textures.len());
    if scene.materials.is_empty() || out_of_range || missing {
        return Err(PlanError::Attribute { name: "materials", entries: scene.materials.len(), triangles });
    }
    Ok(())
}

fn check_rays(options: &Options, units: Units) -> Result<(), PlanError> {
    match &options.rays {
        RaySource::Camera { camera, width, height } => {
            let positive = match camera.projection {
                Projection::Perspective { vertical_fov } => vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI,
                Projection::Orthographic { half_height } => half_height > 0.0,
            };
            if !positive {
                return Err(PlanError::Camera("its field of view is not between 0 and 180 degrees".into()));
            }
            let c = traced_camera(camera, units, *width, *height);
            let in_range = |v: &f32| v.is_finite() && f64::from(v.abs()) <= FARTHEST;
            if ![c.eye, c.right, c.up, c.forward].iter().flatten().all(in_range) {
                return Err(PlanError::Camera("it is too far from the scene for its size, or not finite".into()));
            }
            Ok(())
        }
        RaySource::Given(rays) => {
            for (index, ray) in rays.iter().enumerate() {
                let traced = ray.origin.map(|v| units.to_traced(v));
                if ray.direction.iter().chain(&ray.origin).any(|v| !v.is_finite()) {
                    return Err(PlanError::Ray { index, reason: "a component is not finite" });
                }
                if ray.direction == [0.0; 3] {
                    return Err(PlanError::Ray { index, reason: "its direction is 0" });
                }
                if traced.iter().any(|v| v.is_nan() || f64::from(v.abs()) > FARTHEST) {
                    return Err(PlanError::Ray { index, reason: "its origin is too far from the scene for its size" });
                }
            }
            Ok(())
        }
    }
}

fn check_buffer(name: &'static str, bytes: u64, limits: &Limits) -> Result<(), PlanError> {
    let limit = limits.storage_bytes;
    if bytes > limit { Err(PlanError::BufferSize { name, bytes, limit }) } else { Ok(()) }
}

/// Decides every option of the kernels.
fn features(scene: &Scene, options: &Options, units: Units) -> Features {
    let keep = options.keep_all;
    let inside = match &options.rays {
        RaySource::Camera { camera, width, height } => {
            let c = traced_camera(camera, units, *width, *height);
            let spread = match camera.projection {
                Projection::Perspective { .. } => [0.0; 3],
                Projection::Orthographic { .. } => [0, 1, 2].map(|a| c.right[a].abs() + c.up[a].abs()),
            };
            let bounds = scene.bounds();
            let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
            !bounds.is_empty()
                && (0..3).all(|a| {
                    c.eye[a] - spread[a] > units.to_traced(min[a]) && c.eye[a] + spread[a] < units.to_traced(max[a])
                })
        }
        RaySource::Given(_) => false,
    };
    let any_light = |f: fn(&Light) -> bool| keep || scene.lights.iter().any(f);
    let any_material = |f: fn(&raystep_scenes::Material) -> bool| keep || scene.materials.iter().any(f);
    Features {
        robust: options.numerics == Numerics::Robust,
        grid: options.accelerator == Accelerator::Grid,
        clip: keep || !inside,
        perspective: match &options.rays {
            RaySource::Camera { camera, .. } => matches!(camera.projection, Projection::Perspective { .. }),
            RaySource::Given(_) => true,
        },
        counters: options.counters,
        normals: keep || scene.normals.is_some(),
        textures: (keep || scene.texcoords.is_some()) && any_material(|m| m.texture.is_some()),
        vertex_colors: keep || scene.colors.is_some(),
        many_materials: keep || scene.materials.len() > 1,
        emissive: any_material(|m| m.emissive != [0.0; 3]),
        double_sided: any_material(|m| m.double_sided),
        many_lights: keep || scene.lights.len() > 1,
        directional_lights: any_light(|l| matches!(l, Light::Directional { .. })),
        spot_lights: any_light(|l| matches!(l, Light::Spot { .. })),
    }
}

/// Everything that the tables have and the plan has not.
fn left_out(plan: &Plan, scene: &Scene, options: &Options) -> Vec<LeftOut> {
    use Because::{Options as O, Scene as S, View as V};
    let mut all = Vec::new();
    let mut add =
        |what: String, (because, reason): (Because, &'static str)| all.push(LeftOut { what, because, reason });
    let no_grid = (O, "--accelerator none");
    let no_shade = (V, "the result wanted is the hits, not the image");
    for k in KERNELS.iter().filter(|k| plan.variant(k.kernel).is_none()) {
        let why = match k.kernel {
            Kernel::Generate => (V, "the rays are given"),
            Kernel::TraverseGrid => no_grid,
            _ => no_shade,
        };
        add(format!("kernel {}", k.name), why);
    }
    for s in STREAMS.iter().filter(|s| !plan.has_stream(s.stream)) {
        let why = match s.stream {
            Stream::Counters => (O, "counters are not asked for"),
            Stream::Color => no_shade,
            _ => no_grid,
        };
        add(format!("stream {}", s.name), why);
    }
    for b in BUFFERS.iter().filter(|b| !plan.buffers.iter().any(|p| p.what == b.name)) {
        let why = match b.name {
            "camera" => (V, "the rays are given"),
            "scene" => (O, "the grid's lists have their own ends"),
            "grid" | "grid_cells" | "grid_items" => no_grid,
            _ if !options.shade => no_shade,
            "normals" => (S, "no vertex normals: shading is flat"),
            "vertices" => (S, "every triangle has vertex normals"),
            "texcoords" | "textures" | "texels" => (S, "no base colour texture"),
            "vertex_colors" => (S, "no vertex colours"),
            "triangle_materials" => (S, "one material"),
            _ => (S, "nothing refers to it"),
        };
        add(format!("buffer {}", b.name), why);
    }
    let f = &plan.features;
    if f.grid && f.robust && !f.clip {
        add("code that clips rays to the grid".into(), (S, "the camera is inside the grid"));
    }
    if options.shade {
        let one = if scene.lights.is_empty() { "no light: one headlight" } else { "one light" };
        let code = [
            (f.many_lights, "code for more than one light", one),
            (f.directional_lights, "code for directional lights", "no directional light"),
            (f.spot_lights, "code for spot lights", "no spot light"),
            (f.emissive, "code for emitted light", "no emissive material"),
            (f.double_sided, "code for double-sided materials", "no double-sided material"),
        ];
        for (_, what, reason) in code.into_iter().filter(|(kept, ..)| !kept) {
            add(what.into(), (S, reason));
        }
    }
    all
}

/// A byte count as people read it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [(1u64 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
        match units.iter().find(|(size, _)| self.0 >= *size) {
            Some((size, name)) => write!(f, "{:.1} {name}", self.0 as f64 / *size as f64),
            None => write!(f, "{} bytes", self.0),
        }
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} x {} texels, {} rays, {} triangles", self.width, self.height, self.rays, self.triangles)?;
        writeln!(f, "\nkernels")?;
        for variant in &self.variants {
            let info = variant.kernel.info();
            let states: Vec<_> = info.active.iter().map(|&t| state::name(t)).collect();
            writeln!(f, "  {:<14} {} (rays in {})", info.name, info.summary, states.join(", "))?;
            for binding in &variant.bindings {
                let access = match (binding.reads, binding.writes) {
                    (true, true) => "updates",
                    (false, true) => "writes ",
                    _ => "reads  ",
                };
                let kind = match binding.resource {
                    Resource::ReadStream(_) | Resource::WriteStream { .. } => "stream",
                    Resource::Uniform => "uniform",
                    Resource::Storage => "buffer",
                };
                writeln!(f, "    {access} {kind:<7} {}", binding.name)?;
            }
        }
        writeln!(f, "\nstreams")?;
        for s in &self.streams {
            let info = s.what.info();
            writeln!(
                f,
                "  {:<18} {:>10}  {}  [{}]",
                info.name,
                Bytes(s.bytes).to_string(),
                info.layers.join(" "),
                info.unit
            )?;
        }
        writeln!(f, "\nbuffers")?;
        for b in &self.buffers {
            let element = buffer::info(b.what).map_or("rays per state, one slot a pass", |i| i.element);
            writeln!(f, "  {:<18} {:>10}  {element}", b.what, Bytes(b.bytes).to_string())?;
        }
        writeln!(f, "  {:<18} {:>10}", "in all", Bytes(self.bytes()).to_string())?;
        writeln!(f, "\nleft out")?;
        for item in &self.left_out {
            let because = match item.because {
                Because::Scene => "scene",
                Because::Options => "options",
                Because::View => "view",
            };
            writeln!(f, "  {:<34} by {because:<8} {}", item.what, item.reason)?;
        }
        Ok(())
    }
}
