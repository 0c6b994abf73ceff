//! The settings of a run, as plain data for the options panel and for saving.

use std::sync::Arc;

use glam::DVec3;
use raystep_kernels::options::mapping::{Fragment, Mapping, MappingName};
use raystep_kernels::options::{ELEMENTS, ProgramName};
use raystep_kernels::program::Program;
use raystep_kernels::{
    Accelerator, Device, Gpu, GridSize, Keep, Numerics, Options, RaySource, Samples, ScheduleKind, Skip, Traversal,
    programs,
};
use raystep_scenes::{Camera, Projection, Scene};
use serde::{Deserialize, Serialize};

use crate::link::{Link, LinkCamera, LinkDevice, LinkRay};
use crate::ray_text::GivenRay;

/// Whether a program traces rays: whether its elements have states, and its results are hits. This is the only question
/// asked about what a program is.
#[must_use]
pub fn traces_rays(program: &Program) -> bool {
    program.results.is_some()
}

/// Where passes run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum DeviceKind {
    /// As on the command line: the adapter that the window renders with, or the CPU reference in f32 if that adapter is
    /// software. An open run has one of the other values.
    Auto,
    /// The adapter that the window renders with.
    #[default]
    Gpu,
    /// The CPU reference in f32.
    Cpu,
    /// The CPU reference in f64.
    CpuF64,
}

impl DeviceKind {
    /// Every value that a run can have.
    pub const ALL: [Self; 3] = [Self::Gpu, Self::Cpu, Self::CpuF64];

    /// Resolves `Auto`, and replaces a GPU that only draws.
    #[must_use]
    pub fn on(self, gpu: &Arc<Gpu>) -> Self {
        match self {
            Self::Gpu if !gpu.computes => Self::Cpu,
            Self::Auto if Device::auto(gpu.clone(), None).is_gpu() => Self::Gpu,
            Self::Auto => Self::Cpu,
            chosen => chosen,
        }
    }

    /// The displayed name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "GPU",
            Self::Cpu => "CPU, f32",
            Self::CpuF64 => "CPU, f64",
        }
    }
}

/// The view of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum View {
    /// A camera of the scene, counted from 0; one that frames the scene where it has none.
    Scene(usize),
    /// A custom camera.
    Free {
        /// Where it is, in the coordinates of the scene's file.
        eye: [f64; 3],
        /// The point it looks at.
        look_at: [f64; 3],
        /// The up direction.
        up: [f64; 3],
        /// Vertical angle of view, degrees; `None` for parallel rays.
        fov_deg: Option<f64>,
        /// Half the picture's height in scene units, for parallel rays.
        half_height: f64,
    },
}

/// All settings of a run except the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// What runs.
    #[serde(default)]
    pub program: ProgramName,
    /// How many elements a program works on that needs no scene.
    #[serde(default = "elements")]
    pub elements: u32,
    /// The acceleration structure.
    pub accelerator: Accelerator,
    /// The schedule, one with steps.
    pub schedule: ScheduleKind,
    /// How kernels are mapped to a GPU.
    #[serde(default)]
    pub mapping: Mapping,
    /// The rules for planes, steps and hits.
    pub numerics: Numerics,
    /// How rays walk through a uniform grid.
    #[serde(default)]
    pub traversal: Traversal,
    /// How fine the grid is.
    pub grid: GridSize,
    /// Whether rays skip over empty cells.
    pub skip: Skip,
    /// Most steps of a ray in one pass of the compact schedule; 1 shows one cell, node or triangle per pass.
    pub steps_per_pass: u32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The view of the scene.
    pub view: View,
    /// A single ray instead of an image.
    pub ray: Option<GivenRay>,
    /// Counts cells, tests and repeated tests per ray.
    pub counters: bool,
    /// Omits nothing from the plan.
    pub keep_all: bool,
    /// Samples per pixel.
    #[serde(default)]
    pub samples: Samples,
    /// Where passes run.
    pub device: DeviceKind,
}

fn elements() -> u32 {
    ELEMENTS
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            program: ProgramName::ClosestHit,
            elements: ELEMENTS,
            accelerator: Accelerator::Grid,
            schedule: ScheduleKind::Compact,
            mapping: Mapping::Compute,
            numerics: Numerics::Robust,
            traversal: Traversal::AmanatidesWoo,
            grid: GridSize::Auto,
            skip: Skip::Auto,
            steps_per_pass: 1,
            size: [512, 512],
            view: View::Scene(0),
            ray: None,
            counters: true,
            keep_all: false,
            samples: Samples::default(),
            device: DeviceKind::Gpu,
        }
    }
}

impl View {
    /// The camera in a scene. An impossible view is replaced by one that frames the scene.
    #[must_use]
    pub fn camera(&self, scene: &Scene) -> Camera {
        let framing = || Camera::framing(&scene.bounds());
        match *self {
            Self::Scene(index) => scene.cameras.get(index).cloned().unwrap_or_else(framing),
            Self::Free { eye, look_at, up, fov_deg, half_height } => {
                let projection = match fov_deg {
                    Some(degrees) => Projection::Perspective { vertical_fov: degrees.clamp(0.01, 179.0).to_radians() },
                    None => Projection::Orthographic { half_height: half_height.max(f64::MIN_POSITIVE) },
                };
                let [eye, target, up] = [eye, look_at, up].map(DVec3::from_array);
                let [eye, target] = [eye, target].map(|point| point - scene.offset);
                Camera::look_at(eye, target, up, projection).unwrap_or_else(framing)
            }
        }
    }

    /// A camera of a scene as a custom view.
    #[must_use]
    pub fn of(camera: &Camera, scene: &Scene) -> Self {
        let (fov_deg, half_height) = match camera.projection {
            Projection::Perspective { vertical_fov } => (Some(vertical_fov.to_degrees()), 1.0),
            Projection::Orthographic { half_height } => (None, half_height),
        };
        let eye = scene.offset + camera.eye;
        let look_at = (eye + camera.forward).to_array();
        Self::Free { eye: eye.to_array(), look_at, up: camera.up.to_array(), fov_deg, half_height }
    }
}

impl From<&Link> for Settings {
    fn from(link: &Link) -> Self {
        let view = match link.camera {
            LinkCamera::Default => View::Scene(0),
            LinkCamera::Index(index) => View::Scene(index),
            LinkCamera::Placed { eye, look_at, up, fov_deg } => {
                View::Free { eye, look_at, up, fov_deg: Some(fov_deg), half_height: 1.0 }
            }
        };
        let ray = match link.ray {
            Some(LinkRay::Given(ray)) => Some(ray),
            _ => None,
        };
        Self {
            program: link.program,
            elements: link.elements,
            accelerator: link.accelerator,
            schedule: link.schedule,
            mapping: link.mapping,
            numerics: link.numerics,
            traversal: link.traversal,
            grid: link.grid,
            skip: link.skip,
            steps_per_pass: link.steps_per_pass,
            size: link.size,
            view,
            ray,
            keep_all: link.keep_all,
            samples: link.samples,
            device: match link.device {
                // An adapter's name is the name of a GPU.
                // Fragment programs are drawn, if only by software.
                LinkDevice::Auto if link.adapter.is_none() && link.mapping == Mapping::Compute => DeviceKind::Auto,
                LinkDevice::Auto | LinkDevice::Gpu => DeviceKind::Gpu,
                LinkDevice::Cpu => DeviceKind::Cpu,
            },
            ..Self::default()
        }
    }
}

impl Settings {
    /// Whether the program traces rays.
    #[must_use]
    pub fn traces_rays(&self) -> bool {
        traces_rays(programs::named(self.program))
    }

    /// A link with these settings, without scene and place. A link cannot express parallel rays of a custom camera: it
    /// then has the scene's camera.
    #[must_use]
    pub fn link(&self) -> Link {
        let camera = match self.view {
            View::Scene(0) => LinkCamera::Default,
            View::Scene(index) => LinkCamera::Index(index),
            View::Free { eye, look_at, up, fov_deg: Some(fov_deg), .. } => {
                LinkCamera::Placed { eye, look_at, up, fov_deg }
            }
            View::Free { .. } => LinkCamera::Default,
        };
        let given = self.ray.map(LinkRay::Given);
        Link {
            camera,
            size: self.size,
            program: self.program,
            elements: self.elements,
            accelerator: self.accelerator,
            schedule: self.schedule,
            mapping: self.mapping,
            numerics: self.numerics,
            traversal: self.traversal,
            grid: self.grid,
            skip: self.skip,
            steps_per_pass: self.steps_per_pass,
            keep_all: self.keep_all,
            samples: self.samples_taken(),
            device: match self.device {
                DeviceKind::Auto => LinkDevice::Auto,
                DeviceKind::Gpu => LinkDevice::Gpu,
                DeviceKind::Cpu | DeviceKind::CpuF64 => LinkDevice::Cpu,
            },
            ray: given,
            ..Link::default()
        }
    }

    /// Maps kernels to a GPU in this way, and changes what does not go with it.
    pub fn map_kernels(&mut self, mapping: MappingName) {
        self.mapping = match mapping {
            MappingName::Compute => Mapping::Compute,
            MappingName::Fragment => Mapping::Fragment(Fragment::default()),
        };
        if mapping == MappingName::Fragment {
            if self.schedule == ScheduleKind::Compact {
                (self.schedule, self.steps_per_pass) = (ScheduleKind::Second, 1);
            }
            self.samples.count = 1;
            self.device = DeviceKind::Gpu;
        }
    }

    /// The schedules that can be stepped with this mapping: fragment programs append to no lists.
    #[must_use]
    pub fn schedules(&self) -> Vec<ScheduleKind> {
        let is_drawn = self.mapping != Mapping::Compute;
        let is_possible =
            |schedule: &ScheduleKind| schedule.is_stepped() && !(is_drawn && *schedule == ScheduleKind::Compact);
        ScheduleKind::ALL.iter().copied().filter(is_possible).collect()
    }

    /// Whether rays can walk by a 3D-DDA with these settings: it is for a uniform grid and the paper's rules.
    #[must_use]
    pub fn can_use_dda(&self) -> bool {
        self.accelerator == Accelerator::Grid && self.numerics == Numerics::Paper
    }

    /// The schedule, with the mapping if it is not the usual one.
    #[must_use]
    pub fn order(&self) -> String {
        match self.mapping {
            Mapping::Compute => self.schedule.to_string(),
            fragment @ Mapping::Fragment(_) => format!("{} {fragment}", self.schedule),
        }
    }

    /// The numerics, with the traversal if it is not the usual one.
    #[must_use]
    pub fn rules(&self) -> String {
        match self.traversal_taken() {
            Traversal::AmanatidesWoo => self.numerics.to_string(),
            dda @ Traversal::Dda3d => format!("{} {dda}", self.numerics),
        }
    }

    fn traversal_taken(&self) -> Traversal {
        if self.can_use_dda() { self.traversal } else { Traversal::AmanatidesWoo }
    }

    /// A single ray has no pixel to distribute samples over.
    fn samples_taken(&self) -> Samples {
        if self.ray.is_some() { Samples::default() } else { self.samples }
    }

    /// The options of a run. Passes are timed if the device supports it.
    #[must_use]
    pub fn options(&self, scene: &Scene) -> Options {
        let rays = match self.ray {
            Some(ray) => RaySource::Given(vec![ray.in_scene(scene)]),
            None => {
                let [width, height] = self.size;
                RaySource::Camera { camera: self.view.camera(scene), width, height }
            }
        };
        Options {
            program: self.program,
            elements: self.elements,
            accelerator: self.accelerator,
            schedule: if self.schedule.is_stepped() { self.schedule } else { ScheduleKind::Compact },
            mapping: self.mapping,
            numerics: self.numerics,
            traversal: self.traversal_taken(),
            grid: self.grid,
            skip: self.skip,
            steps_per_pass: self.steps_per_pass.clamp(1, 4096),
            counters: self.counters,
            timings: true,
            keep: Keep::all_if(self.keep_all),
            samples: self.samples_taken(),
            ..Options::new(rays)
        }
    }
}
