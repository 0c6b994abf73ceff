//! `raystep info`

mod self_test;

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use glam::Vec3;
use raystep_kernels::export::json::AdapterInfo;
use raystep_kernels::plan::Bytes;
use raystep_kernels::{AdapterChoice, AdapterSummary, Loops};
use raystep_lab::block_on;
use raystep_lab::text::visible;
use raystep_scenes::{Light, Optics, Projection, Scene};
use serde::Serialize;

use crate::args::{DeviceArgs, DeviceKind, ReadArgs, SceneArgs, counted};
use crate::device::{AboutClock, choose, open};
use crate::error::Error;
use crate::scene_file;
use crate::terminal::print;

/// List GPU adapters and the default device, describe a scene, or test whether raystep works on an adapter
///
/// With --self-test, every kernel runs on the adapter and is compared with its CPU reference, pass by pass; the hits of
/// all structures and schedules are compared with each other and with f64 brute force; and the arithmetic, the loops
/// and the clock of the driver are checked. The exit code is 0 if nothing is wrong, and 1 if anything is. If it is,
/// please send us the bundle: it has the results, the names of adapter, driver and system, and nothing about you.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep info
  raystep info teapot
  raystep info --self-test
  raystep info --self-test --bundle self-test.zip
  raystep info --self-test --adapter Radeon --seconds 300
  raystep info --json | jq '.adapters[].name'")]
pub(crate) struct InfoArgs {
    /// Describe this scene instead
    scene: Option<PathBuf>,
    /// Index of the scene in a file with several, counted from 0
    #[arg(long, value_name = "N", requires = "scene", value_parser = counted, allow_negative_numbers = true)]
    scene_index: Option<usize>,
    #[command(flatten)]
    read: ReadArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    self_test: self_test::SelfTestArgs,
}

pub(crate) fn run(args: &InfoArgs) -> Result<(), Error> {
    if args.self_test.is_wanted() {
        return self_test::run(&args.self_test, args.json);
    }
    match &args.scene {
        Some(path) => {
            let file = SceneArgs { scene: path.clone(), scene_index: args.scene_index, read: args.read };
            let scene = scene_file::read(&file)?.scene;
            let about = AboutScene::of(&scene);
            print(&if args.json { super::json_text(&about)? } else { about.text() })
        }
        None => {
            let adapters = block_on(None, raystep_kernels::adapters());
            let chosen = choose(&DeviceArgs { device: DeviceKind::Auto, adapter: None })?;
            let about = AboutDevices {
                adapters: adapters.iter().map(AboutAdapter::of).collect(),
                device: chosen.kind(),
                name: chosen.name(),
                reason: chosen.reason.clone(),
            };
            print(&if args.json { super::json_text(&about)? } else { about.text() })
        }
    }
}

#[derive(Serialize)]
struct AboutDevices {
    adapters: Vec<AboutAdapter>,
    /// The device that `--device auto` selects.
    device: &'static str,
    name: String,
    reason: String,
}

#[derive(Serialize)]
struct AboutAdapter {
    #[serde(flatten)]
    info: AdapterInfo,
    is_usable: bool,
    /// Whether it runs kernels only as fragment programs, with the scene in textures.
    only_draws: bool,
    has_timestamps: bool,
    /// Time of some work by its clock and by the host's; `null` if it has no clock.
    clock: Option<AboutClock>,
    image_side_px: u32,
    storage_binding_bytes: u64,
    buffer_bytes: u64,
    workgroups_per_dimension: u32,
    storage_textures_per_stage: u32,
    storage_buffers_per_stage: u32,
}

/// Opens the adapter, and checks its clock.
fn clock(adapter: &AdapterSummary) -> Option<AboutClock> {
    if !adapter.is_usable || !adapter.has_timestamps {
        return None;
    }
    // An adapter that cannot be opened is reported when it is used.
    let gpu = open(&AdapterChoice::Named(adapter.info.name.clone())).ok()?;
    gpu.clock_check().map(AboutClock::from)
}

impl AboutAdapter {
    fn timestamps(&self) -> String {
        match &self.clock {
            _ if !self.has_timestamps => "no: passes cannot be timed".into(),
            None => "yes, but not compared with the host's clock".into(),
            Some(clock) if clock.agrees => format!("yes: {clock}"),
            Some(clock) => format!("wrong, so passes cannot be timed: {clock}"),
        }
    }

    fn of(adapter: &AdapterSummary) -> Self {
        let limits = &adapter.limits;
        Self {
            info: AdapterInfo::from(adapter),
            is_usable: adapter.is_usable,
            only_draws: adapter.only_draws,
            has_timestamps: adapter.has_timestamps,
            clock: clock(adapter),
            image_side_px: raystep_kernels::Limits::of_adapter(limits, Loops::Unlimited).image_side,
            storage_binding_bytes: limits.max_storage_buffer_binding_size,
            buffer_bytes: limits.max_buffer_size,
            workgroups_per_dimension: limits.max_compute_workgroups_per_dimension,
            storage_textures_per_stage: limits.max_storage_textures_per_shader_stage,
            storage_buffers_per_stage: limits.max_storage_buffers_per_shader_stage,
        }
    }
}

impl AboutDevices {
    fn text(&self) -> String {
        let mut text = String::new();
        let mut line = |line: String| text.extend([line.as_str(), "\n"]);
        if self.adapters.is_empty() {
            line("No GPU adapter was found, neither hardware nor software. Runs use the CPU.\n".into());
        }
        for a in &self.adapters {
            line(a.info.name.clone());
            line(format!("  backend     {}, {}", a.info.backend, a.info.driver));
            line(format!("  kind        {}", a.info.kind));
            line(format!(
                "  usable      {}",
                match (a.is_usable, a.only_draws) {
                    (true, _) => "yes",
                    (_, true) => "with --adapter; kernels are then drawn, from --scene-data textures",
                    _ =>
                        "no: it lacks compute shaders and drawing into floats, core limits of WebGPU or WebGL 2, or read-write r32 textures",
                }
            ));
            line(format!("  timestamps  {}", a.timestamps()));
            if let Some(turns) = a.info.loops_end_after {
                line(format!("  loops       end after {turns} iterations: longer walks take several dispatches"));
            }
            line(format!("  images      up to {} pixels per side", a.image_side_px));
            line(format!("  buffers     {} each, {} bound", Bytes(a.buffer_bytes), Bytes(a.storage_binding_bytes)));
            line(format!(
                "  a stage     {} storage textures, {} storage buffers",
                a.storage_textures_per_stage, a.storage_buffers_per_stage
            ));
            line(format!("  a dispatch  {} workgroups per dimension\n", a.workgroups_per_dimension));
        }
        line(format!(
            "--device auto selects {}: {}",
            if self.device == "cpu" { "the CPU" } else { &self.name },
            self.reason
        ));
        text
    }
}

#[derive(Serialize)]
struct AboutScene {
    name: String,
    triangles: usize,
    /// Of all triangles, in scene units squared.
    area: f64,
    /// In the coordinates of the file.
    bounds_min: Option<[f64; 3]>,
    bounds_max: Option<[f64; 3]>,
    /// What is subtracted from the file's coordinates before they are rounded to f32.
    offset: [f64; 3],
    has_normals: bool,
    has_texcoords: bool,
    has_vertex_colors: bool,
    materials: Vec<AboutMaterial>,
    textures: Vec<[u32; 2]>,
    lights: Vec<&'static str>,
    cameras: Vec<AboutCamera>,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct AboutMaterial {
    name: String,
    triangles: usize,
    texture: Option<u32>,
    is_emissive: bool,
    is_double_sided: bool,
    optics: &'static str,
}

#[derive(Serialize)]
struct AboutCamera {
    name: String,
    projection: &'static str,
    eye: [f64; 3],
    vertical_fov_deg: Option<f64>,
}

impl AboutScene {
    fn of(scene: &Scene) -> Self {
        let bounds = Some(scene.bounds()).filter(|b| !b.is_empty());
        let offset = scene.offset.to_array();
        // Without an offset, the shortest decimals of f32.
        let coordinate = |axis: usize, v: f32| match offset[axis] {
            0.0 => v.to_string().parse().unwrap_or(v.into()),
            offset => offset + f64::from(v),
        };
        let in_file = |point: Vec3| [0, 1, 2].map(|axis| coordinate(axis, point[axis]));
        let mut counts = vec![0; scene.materials.len()];
        for &material in &scene.triangle_materials {
            counts[material as usize] += 1;
        }
        let materials = scene.materials.iter().zip(counts).map(|(m, triangles)| AboutMaterial {
            name: m.name.clone(),
            triangles,
            texture: m.texture,
            is_emissive: m.emissive != [0.0; 3],
            is_double_sided: m.double_sided,
            optics: match m.optics {
                Optics::Diffuse => "diffuse",
                Optics::Rough => "rough",
                Optics::Mirror => "mirror",
                Optics::Dielectric { is_thin: false, .. } => "dielectric",
                Optics::Dielectric { is_thin: true, .. } => "sheet",
            },
        });
        let lights = scene.lights.iter().map(|light| match light {
            Light::Point { .. } => "point",
            Light::Directional { .. } => "directional",
            Light::Spot { .. } => "spot",
        });
        let cameras = scene.cameras.iter().map(|camera| {
            let (projection, fov) = match camera.projection {
                Projection::Perspective { vertical_fov } => ("perspective", Some(vertical_fov.to_degrees())),
                Projection::Orthographic { .. } => ("orthographic", None),
            };
            let eye = (scene.offset + camera.eye).to_array();
            AboutCamera { name: camera.name.clone(), projection, eye, vertical_fov_deg: fov }
        });
        Self {
            name: scene.name.clone(),
            triangles: scene.triangles.len(),
            area: scene.area(),
            bounds_min: bounds.map(|b| in_file(b.min)),
            bounds_max: bounds.map(|b| in_file(b.max)),
            offset,
            has_normals: scene.normals.is_some(),
            has_texcoords: scene.texcoords.is_some(),
            has_vertex_colors: scene.colors.is_some(),
            materials: materials.collect(),
            textures: scene.textures.iter().map(|t| [t.width, t.height]).collect(),
            lights: lights.collect(),
            cameras: cameras.collect(),
            notes: scene.notes.iter().map(|n| n.0.clone()).collect(),
        }
    }

    fn text(&self) -> String {
        let mut text = format!("{}\n  triangles  {}\n", self.name, self.triangles);
        let mut line = |name: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {name:<9}  {value}");
        };
        if let (Some(min), Some(max)) = (self.bounds_min, self.bounds_max) {
            line("bounds", format!("{min:?} to {max:?}"));
        }
        if self.offset != [0.0; 3] {
            let why = "subtracted from all coordinates, which are too far from the origin for 32 bits";
            line("offset", format!("{:?}, {why}", self.offset));
        }
        line("area", self.area.to_string());
        let attributes: Vec<_> = [
            (self.has_normals, "normals"),
            (self.has_texcoords, "texture coordinates"),
            (self.has_vertex_colors, "vertex colours"),
        ]
        .iter()
        .filter_map(|(has, name)| has.then_some(*name))
        .collect();
        line(
            "corners",
            if attributes.is_empty() {
                "positions only".into()
            } else {
                format!("positions, {}", attributes.join(", "))
            },
        );
        for m in &self.materials {
            let texture = m.texture.map(|t| format!(", texture {t}")).unwrap_or_default();
            let emissive = if m.is_emissive { ", emissive" } else { "" };
            let sides = if m.is_double_sided { ", double-sided" } else { "" };
            let optics = if m.optics == "diffuse" { String::new() } else { format!(", {}", m.optics) };
            line("material", format!("{:?}: {} triangles{texture}{emissive}{sides}{optics}", m.name, m.triangles));
        }
        for (i, [width, height]) in self.textures.iter().enumerate() {
            line("texture", format!("{i}: {width} x {height}"));
        }
        for light in &self.lights {
            line("light", (*light).into());
        }
        for (i, c) in self.cameras.iter().enumerate() {
            let fov = c.vertical_fov_deg.map(|d| format!(", {d:.1} degrees")).unwrap_or_default();
            line("camera", format!("{i}: {:?}, {}{fov}, at {:?}", c.name, c.projection, c.eye));
        }
        for note in &self.notes {
            line("note", visible(note).into_owned());
        }
        text
    }
}
