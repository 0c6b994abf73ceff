//! The settings of a run, as plain data for the options panel and for saving.

use std::sync::Arc;

use glam::DVec3;
use raystep_kernels::options::Choices;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::options::rows::{MOST_STEPS, Row, Values};
use raystep_kernels::program::Program;
use raystep_kernels::{Accelerator, Device, Gpu, Options, RaySource, Samples, ScheduleKind, Traversal, programs};
use raystep_scenes::{Camera, Projection, Scene};
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

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

    /// Resolves `Auto`.
    fn on(self, gpu: &Arc<Gpu>) -> Self {
        match self {
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, SmartDefault)]
pub struct Settings {
    /// The options that are rows of the table.
    #[default(Choices::stepped())]
    #[serde(flatten)]
    pub choices: Choices,
    /// Width and height in pixels.
    #[default([512, 512])]
    pub size: [u32; 2],
    /// The view of the scene.
    #[default(View::Scene(0))]
    pub view: View,
    /// A single ray instead of an image.
    pub ray: Option<GivenRay>,
    /// Counts cells, tests and repeated tests per ray.
    #[default(true)]
    pub counters: bool,
    /// Where passes run.
    pub device: DeviceKind,
    /// Kernels whose WGSL is the user's: neither links nor sessions have them.
    #[serde(skip)]
    pub replaced: Vec<Arc<Replacement>>,
    /// A user's program, which was opened as scenes are.
    #[serde(skip)]
    pub folder: Option<Arc<Folder>>,
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
            choices: possible(link.choices),
            size: link.size,
            view,
            ray,
            device: match link.device {
                // An adapter's name is the name of a GPU.
                // What needs a GPU runs on one, if only in software.
                LinkDevice::Auto if link.adapter.is_none() && !link.choices.needs_gpu() => DeviceKind::Auto,
                LinkDevice::Auto | LinkDevice::Gpu => DeviceKind::Gpu,
                LinkDevice::Cpu => DeviceKind::Cpu,
            },
            ..Self::default()
        }
    }
}

/// The choices that go together, with a schedule that can be stepped.
fn possible(mut choices: Choices) -> Choices {
    if !choices.schedule.is_stepped() {
        choices.schedule = ScheduleKind::Compact;
    }
    choices.settled(None)
}

impl Settings {
    /// Whether the program traces rays.
    #[must_use]
    pub fn traces_rays(&self) -> bool {
        self.folder.is_none() && traces_rays(programs::chosen(&self.choices).program())
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
            choices: self.taken(),
            device: match self.device {
                DeviceKind::Auto => LinkDevice::Auto,
                DeviceKind::Gpu => LinkDevice::Gpu,
                DeviceKind::Cpu | DeviceKind::CpuF64 => LinkDevice::Cpu,
            },
            ray: given,
            ..Link::default()
        }
    }

    /// The same where the window has this adapter, on a device that is chosen. An adapter that only draws runs kernels as
    /// fragment programs with lists in textures; what cannot be drawn so runs on the CPU.
    #[must_use]
    pub fn on(self, gpu: &Arc<Gpu>) -> Self {
        let device = self.device.on(gpu);
        if gpu.computes {
            return Self { device, ..self };
        }
        let drawn = possible(self.choices).drawn(|_| false);
        match device {
            DeviceKind::Gpu if drawn.go_together() => Self { device, choices: drawn, ..self },
            _ => Self { device, ..self }.computed(),
        }
    }

    /// Whether a GPU was asked for these, and runs them in another way.
    #[must_use]
    pub fn is_drawn_otherwise(&self, run: &Self) -> bool {
        let way = |settings: &Self| (settings.device, settings.choices.mapping, settings.choices.scene_data);
        self.device == DeviceKind::Gpu && way(self) != way(run)
    }

    /// The same on the CPU.
    #[must_use]
    pub fn computed(self) -> Self {
        let device = if self.device == DeviceKind::CpuF64 { self.device } else { DeviceKind::Cpu };
        Self { device, choices: self.choices.computed(), ..self }
    }

    /// The same through another structure.
    #[must_use]
    pub fn through(mut self, accelerator: Accelerator) -> Self {
        self.choices = Choices { accelerator, ..self.choices }.settled(Row::named("accelerator"));
        self
    }

    /// Chooses a value of an option. What does not go together with it gives way.
    ///
    /// # Errors
    /// What would be right, if the option has no such value.
    pub fn choose(&mut self, row: &Row, value: &str) -> Result<(), String> {
        row.set(&mut self.choices, value)?;
        self.choices = self.choices.settled(Some(row));
        if self.choices.needs_gpu() {
            self.device = DeviceKind::Gpu;
        }
        Ok(())
    }

    /// The values that panels offer of an option with names: not those that do not go together with the others, whatever
    /// gives way, nor what cannot be stepped.
    #[must_use]
    pub fn offered(&self, row: &Row) -> Vec<&'static str> {
        let Values::Names(names) = row.values else { return Vec::new() };
        let is_offered = |name: &&str| {
            let mut chosen = self.clone();
            let is_chosen = chosen.choose(row, name).is_ok();
            is_chosen && chosen.choices == chosen.choices.settled(None) && chosen.choices.schedule.is_stepped()
        };
        names().into_iter().filter(is_offered).collect()
    }

    /// The schedule, with the mapping if it is not the usual one.
    #[must_use]
    pub fn order(&self) -> String {
        let Choices { schedule, mapping, .. } = self.choices;
        match mapping {
            Mapping::Compute => schedule.to_string(),
            fragment @ Mapping::Fragment(_) => format!("{schedule} {fragment}"),
        }
    }

    /// The numerics, with the traversal if it is not the usual one.
    #[must_use]
    pub fn rules(&self) -> String {
        let Choices { numerics, traversal, .. } = self.taken();
        match traversal {
            Traversal::AmanatidesWoo => numerics.to_string(),
            dda @ Traversal::Dda3d => format!("{numerics} {dda}"),
        }
    }

    /// The choices of the run: a single ray has no pixel to distribute samples over, and a file may hold anything.
    fn taken(&self) -> Choices {
        let mut choices = possible(self.choices);
        if self.ray.is_some() {
            choices.samples = Samples::default();
        }
        let is_compact = choices.schedule == ScheduleKind::Compact;
        choices.steps_per_pass = if is_compact { choices.steps_per_pass.clamp(1, MOST_STEPS) } else { 1 };
        choices
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
        let (counters, replaced, folder) = (self.counters, self.replaced.clone(), self.folder.clone());
        Options { counters, timings: true, replaced, folder, ..Options::new(rays).chosen(&self.taken()) }
    }
}
