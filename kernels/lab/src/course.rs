//! The course: exercises, each a kernel with a hole, or a schedule to change, and the check of what a student has written.
//!
//! [`exercises::EXERCISES`] is the only place that knows which files there are, and what each is checked with. A student's
//! kernel is compared with the one that it replaces; nothing that is told contains lines of that one.

mod check;
mod check_schedule;
pub mod exercises;
mod files;
mod hints;
mod judge;

pub use check::{CheckError, Found};
pub use files::{FileOfCourse, files};
pub use judge::check_view;

use std::fmt;

use raystep_kernels::options::replacement::{Replacement, ReplacementError};
use raystep_kernels::options::rows::ROWS;
use raystep_kernels::{Accelerator, Choices, Options, RaySource, ScheduleKind};
use raystep_scenes::{Camera, LoadError, LoadOptions, NoFiles, Projection, Scene, generate, load};
use serde::Serialize;

use crate::check_kernel::Difference;
use crate::subject::Size;

/// One exercise.
#[derive(Debug)]
pub struct Exercise {
    /// Its place in the course, from 1.
    pub number: u8,
    /// Name of its files, without ending, such as `1-tmax`.
    pub name: &'static str,
    /// What it is about, in a few words.
    pub title: &'static str,
    /// What the student completes.
    pub task: Task,
}

/// What [`Task::kernel`] is for a schedule, which is no kernel.
pub const SCHEDULE: &str = "schedule";

/// A kernel to complete, or a schedule to change.
#[derive(Debug)]
pub struct Task {
    /// The kernel that it replaces, or [`SCHEDULE`].
    pub kernel: &'static str,
    /// It, with its hole.
    pub hole: &'static str,
    /// Options of all views that are not the defaults, by the names of their rows.
    pub options: &'static [(&'static str, &'static str)],
    /// What the kernel is checked with, the easiest first.
    pub views: &'static [View],
    /// Whether a ray may go another way where f32 cannot tell which is right.
    pub may_round: bool,
    /// Whether every ray has to hit something that does so with the kernel of ours.
    pub is_watertight: bool,
    hints: &'static [Hint],
}

/// A scene, as a camera sees it.
#[derive(Debug)]
pub struct View {
    /// Where the scene is from.
    pub scene: Source,
    /// Eye, the point that it looks at, and the vertical field of view in degrees; `None` for the scene's first camera.
    pub camera: Option<([f64; 3], [f64; 3], f64)>,
    /// Pixels.
    pub size: Size,
    /// Cells of the grid, as `--grid` takes them; `None` for as many as suit the scene.
    pub grid: Option<&'static str>,
    /// What is particular about it.
    pub why: &'static str,
}

/// Where a scene is from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// The generator with this name.
    Generated(&'static str),
    /// A file of the course.
    File(FileOfCourse),
}

/// Why a view cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The scene cannot be generated.
    #[error(transparent)]
    Generate(#[from] generate::GenerateError),
    /// The scene's file cannot be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The camera has no direction, or an option no such value.
    #[error("{0}")]
    View(String),
}

/// Something to look at, where a value differs.
#[derive(Debug)]
struct Hint {
    /// Where: the name of the stream, with or without the layer; empty for anywhere.
    at: &'static str,
    /// And with which values.
    when: fn(&Difference) -> bool,
    text: &'static str,
}

/// What became of an exercise.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// The kernel does what the one does that it replaces.
    Passed {
        /// Views that it was checked with.
        views: usize,
        /// Rays that it worked on, summed over passes and views.
        rays: u64,
    },
    /// A value differs.
    Differs(Box<Difference>),
    /// A ray passes between triangles.
    Leaks {
        /// Column and row of the first such ray's pixel.
        pixel: [u32; 2],
        /// How many there are.
        rays: usize,
    },
    /// The schedule has the right results, after too many passes.
    Slow {
        /// Its passes.
        passes: usize,
        /// As many are enough.
        enough: usize,
    },
    /// Rays are not counted in the states that were stored.
    Miscounts {
        /// The pass, from 0.
        pass: usize,
        /// Name of the state, rays counted, and rays with its tag.
        states: Vec<(&'static str, u32, u32)>,
    },
    /// It does not run to its end.
    Fails {
        /// Place and reason.
        message: String,
    },
    /// The file is no kernel that can run.
    Mistake {
        /// Place and reason.
        message: String,
        /// From 1; 0 if no line is to blame.
        line: usize,
        /// From 1; 0 if no line is to blame.
        column: usize,
    },
    /// The file is as it was, with its hole.
    Untouched,
    /// There is no such file.
    Missing,
}

impl Verdict {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Passed { .. } => "passed",
            Self::Differs(_) => "differs",
            Self::Leaks { .. } => "leaks",
            Self::Slow { .. } => "slow",
            Self::Miscounts { .. } => "miscounts",
            Self::Fails { .. } => "fails",
            Self::Mistake { .. } => "mistake",
            Self::Untouched => "untouched",
            Self::Missing => "missing",
        }
    }
}

impl Exercise {
    /// Name of the file that the student completes.
    #[must_use]
    pub fn file(&self) -> String {
        let ending = if self.task.is_schedule() { "toml" } else { "wgsl" };
        format!("{}.{ending}", self.name)
    }
}

impl Task {
    /// Whether it is a schedule.
    #[must_use]
    pub fn is_schedule(&self) -> bool {
        self.kernel == SCHEDULE
    }

    /// Reads a student's file: for this kernel, whatever its functions are called.
    ///
    /// # Errors
    /// What became of the exercise, if there is nothing to check.
    pub fn read(&self, file: String, bytes: Vec<u8>) -> Result<Replacement, Verdict> {
        let mistake = |message: String| Verdict::Mistake { message, line: 0, column: 0 };
        let by = Replacement::new(Some(self.kernel.to_owned()), file, bytes)
            .map_err(|error: ReplacementError| mistake(error.to_string()))?;
        if is_same_text(&by.source, self.hole) { Err(Verdict::Untouched) } else { Ok(by) }
    }

    /// What a student could look at.
    #[must_use]
    pub fn hint(&self, verdict: &Verdict) -> Option<&'static str> {
        let found = match verdict {
            Verdict::Differs(difference) => self.hints.iter().find(|hint| hint.fits(difference)),
            Verdict::Leaks { .. } => self.hints.iter().find(|hint| hint.at == hints::LEAK),
            Verdict::Slow { .. } => self.hints.iter().find(|hint| hint.at == hints::SLOW),
            Verdict::Fails { .. } => self.hints.iter().find(|hint| hint.at == hints::FAILS),
            _ => None,
        };
        found.map(|hint| hint.text)
    }

    /// The scene of a view, and the options of a run of ours.
    fn run(&self, view: &View) -> Result<(Scene, Options), ViewError> {
        let scene = view.scene()?;
        let Size { width, height } = view.size;
        let rays = RaySource::Camera { camera: view.camera(&scene)?, width, height };
        let options = Options::new(rays).chosen(&self.choices(view)?);
        Ok((scene, options))
    }

    /// The choices of a run.
    fn choices(&self, view: &View) -> Result<Choices, ViewError> {
        let mut choices = Choices {
            accelerator: Accelerator::Grid,
            schedule: ScheduleKind::Compact,
            steps_per_pass: 1,
            ..Choices::default()
        };
        let grid = view.grid.map(|cells| ("grid", cells));
        for (name, value) in self.options.iter().copied().chain(grid) {
            let row = ROWS.iter().find(|row| row.name == name);
            row.ok_or_else(|| format!("no option {name}"))
                .and_then(|row| row.set(&mut choices, value))
                .map_err(ViewError::View)?;
        }
        Ok(choices)
    }

    /// The arguments of a command that shows a view.
    #[must_use]
    pub fn arguments(&self, view: &View) -> String {
        let options = self.options.iter().map(|(name, value)| format!(" --{name} {value}"));
        view.to_string() + &options.collect::<String>()
    }
}

/// Whether two texts have the same lines, whatever ends them.
fn is_same_text(a: &str, b: &str) -> bool {
    a.trim_end().lines().map(str::trim_end).eq(b.trim_end().lines().map(str::trim_end))
}

impl View {
    /// Its scene.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn scene(&self) -> Result<Scene, ViewError> {
        Ok(match self.scene {
            Source::Generated(name) => generate::find(name)?.make(&[])?,
            Source::File(file) => load(file.name, file.text.as_bytes(), &NoFiles, &LoadOptions::default())?,
        })
    }

    fn camera(&self, scene: &Scene) -> Result<Camera, ViewError> {
        let Some((eye, target, degrees)) = self.camera else {
            return Ok(scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds())));
        };
        let projection = Projection::Perspective { vertical_fov: degrees.to_radians() };
        let [eye, target] = [eye, target].map(|point| glam::DVec3::from(point) - scene.offset);
        Camera::look_at(eye, target, glam::DVec3::Y, projection)
            .ok_or_else(|| ViewError::View("the camera has no direction".into()))
    }
}

/// As arguments of a command.
impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.scene {
            Source::Generated("cornell-box") => f.write_str("cornell-box")?,
            Source::Generated(name) => write!(f, "built-in:{name}")?,
            Source::File(file) => f.write_str(file.name)?,
        }
        write!(f, " --size {}x{}", self.size.width, self.size.height)?;
        if let Some(([x, y, z], [to_x, to_y, to_z], fov)) = self.camera {
            write!(f, " --eye {x},{y},{z} --look-at {to_x},{to_y},{to_z} --fov {fov}")?;
        }
        self.grid.map_or(Ok(()), |grid| write!(f, " --grid {grid}"))
    }
}
