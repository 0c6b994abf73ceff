//! Arithmetic intensity: how many operations each kernel does for a byte that it moves, counted while the interpreter
//! executes the final WGSL for every ray of every pass. What counts as an operation and as a byte is defined at
//! [`Work`].
//!
//! An element is a ray in a pass that works on it; threads without a ray are not counted.

use raystep_kernels::interpret::{InterpretError, Interpreter, Many, Work};
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::{Device, Kernel, Options, RaySource, Renderer, StreamData};
use raystep_scenes::Scene;
use serde::Serialize;

use crate::Error;
use crate::reporter::Reporter;
use crate::text::aligned;
use crate::tidy::{Row, Table};

/// Most rays that are counted: the image is made smaller until it has no more.
const MOST_RAYS: u64 = 64 * 64;

/// The columns of the CSV file.
pub const COLUMNS: &[&str] = columns![
    schema_version scene kernel passes elements float_operations integer_operations comparisons
    stream_bytes_read stream_bytes_written buffer_bytes_read uniform_bytes_read float_operations_per_byte
    operations_per_byte
];

/// A kernel's work in a whole run.
#[derive(Clone, Copy, Debug)]
pub struct KernelWork {
    /// The kernel.
    pub kernel: Kernel,
    /// Passes in which it worked on a ray.
    pub passes: u64,
    /// Rays that it worked on, added over these passes.
    pub elements: u64,
    /// What they took together.
    pub work: Work,
}

/// All kernels of a run, in order of first use.
#[derive(Clone, Debug)]
pub struct Intensity {
    scene: String,
    size: [u32; 2],
    /// Sums of each kernel that worked on a ray.
    pub works: Vec<KernelWork>,
}

/// Counts a run with these options on the CPU, as compute shaders. A view of more than 4,096 rays is counted in a
/// smaller image.
///
/// # Errors
/// If the scene cannot be planned, a kernel cannot be interpreted, or the reporter cancels.
pub async fn intensity(scene: &Scene, options: &Options, reporter: &dyn Reporter) -> Result<Intensity, Error> {
    let options = Options { rays: reduced(&options.rays), mapping: Mapping::Compute, ..options.clone() };
    let mut renderer = Renderer::new(scene, &options, &Device::Cpu(None)).await?;
    let plan = renderer.shared_plan();
    let mut counted = Vec::new();
    for variant in &plan.variants {
        match Interpreter::new(variant) {
            Ok(interpreter) => {
                counted.push((
                    interpreter,
                    KernelWork { kernel: variant.kernel, passes: 0, elements: 0, work: Work::default() },
                ));
            }
            Err(InterpretError::NotAlone(_)) => {}
            Err(error) => return Err(error.into()),
        }
    }
    while let Some(kernel) = renderer.next_kernel() {
        if reporter.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let progress = renderer.progress();
        reporter.part("counting operations", progress.rays_decided, progress.rays);
        if let Some((interpreter, sum)) = counted.iter_mut().find(|(_, sum)| sum.kernel == kernel) {
            let streams = before(&renderer, interpreter).await?;
            let many = Many { kernel: interpreter, data: renderer.data(), streams: &streams };
            let (elements, work) = many.work(0..usize::MAX)?;
            sum.passes += u64::from(elements > 0);
            sum.elements += elements;
            sum.work.add(&work, 1);
        }
        renderer.step().await?;
    }
    let works = counted.into_iter().map(|(_, sum)| sum).filter(|sum| sum.elements > 0).collect();
    Ok(Intensity { scene: scene.name.clone(), size: [plan.width, plan.height], works })
}

async fn before(renderer: &Renderer, interpreter: &Interpreter) -> Result<Vec<StreamData>, Error> {
    let mut streams = Vec::new();
    for &stream in interpreter.streams() {
        streams.push(renderer.values(stream).await?);
    }
    Ok(streams)
}

/// The same view in at most [`MOST_RAYS`] pixels.
fn reduced(rays: &RaySource) -> RaySource {
    match rays {
        RaySource::Camera { camera, width, height } => {
            let pixels = u64::from(*width) * u64::from(*height);
            let factor = (MOST_RAYS as f64 / pixels.max(1) as f64).sqrt().min(1.0);
            let side = |pixels: u32| ((f64::from(pixels) * factor) as u32).clamp(1, MOST_RAYS as u32);
            RaySource::Camera { camera: camera.clone(), width: side(*width), height: side(*height) }
        }
        RaySource::Given(rays) => RaySource::Given(rays.iter().take(MOST_RAYS as usize).copied().collect()),
    }
}

/// A kernel's means: a row of the CSV file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the columns of the CSV file, described in `tidy::columns`")]
pub struct KernelMeans {
    pub kernel: &'static str,
    pub passes: u64,
    pub elements: u64,
    pub float_operations: f64,
    pub integer_operations: f64,
    pub comparisons: f64,
    pub stream_bytes_read: f64,
    pub stream_bytes_written: f64,
    pub buffer_bytes_read: f64,
    pub uniform_bytes_read: f64,
    pub float_operations_per_byte: f64,
    pub operations_per_byte: f64,
}

impl KernelWork {
    /// Per element.
    #[must_use]
    pub fn means(&self) -> KernelMeans {
        let work = &self.work;
        let mean = |sum: u64| sum as f64 / self.elements.max(1) as f64;
        let per_byte = |operations: u64| operations as f64 / work.bytes().max(1) as f64;
        KernelMeans {
            kernel: self.kernel.name(),
            passes: self.passes,
            elements: self.elements,
            float_operations: mean(work.float_operations),
            integer_operations: mean(work.integer_operations),
            comparisons: mean(work.comparisons),
            stream_bytes_read: mean(work.stream_bytes_read),
            stream_bytes_written: mean(work.stream_bytes_written),
            buffer_bytes_read: mean(work.buffer_bytes_read),
            uniform_bytes_read: mean(work.uniform_bytes_read),
            float_operations_per_byte: per_byte(work.float_operations),
            operations_per_byte: per_byte(work.operations()),
        }
    }
}

/// The heads of the text's numeric columns.
const HEADS: [&str; 11] =
    ["passes", "elements", "float", "integer", "compare", "read", "written", "buffer", "uniform", "float/B", "op/B"];

impl Intensity {
    /// The kernels' means.
    #[must_use]
    pub fn kernels(&self) -> Vec<KernelMeans> {
        self.works.iter().map(KernelWork::means).collect()
    }

    /// A table, and what it counts.
    #[must_use]
    pub fn text(&self) -> String {
        let [width, height] = self.size;
        let head = ["kernel"].into_iter().chain(HEADS).map(str::to_owned).collect::<Vec<_>>();
        let row = |kernel: &KernelMeans| {
            let counts = [kernel.passes, kernel.elements].map(|count| count.to_string());
            let row = Row::new(COLUMNS).with(kernel);
            let number = |(i, column): (usize, &&str)| {
                let number = row.number(column).unwrap_or_default();
                if i < 7 { format!("{number:.1}") } else { format!("{number:.2}") }
            };
            let numbers = COLUMNS[5..].iter().enumerate().map(number);
            [vec![kernel.kernel.to_owned()], counts.into(), numbers.collect()].concat()
        };
        let lines: Vec<Vec<String>> = std::iter::once(head).chain(self.kernels().iter().map(row)).collect();
        let table: String = aligned(&lines, 1).iter().map(|line| format!("  {line}")).collect();
        format!(
            "arithmetic intensity, per element: a ray in a pass that works on it; {width}x{height} rays of this view\n{table}  \
             operations: an operator or function on one component (fma and clamp: two); compare: also select, !\n  \
             bytes: streams read and written, buffers and uniforms read; a component or word is four\n  \
             float/B, op/B: operations on floats, and all, by bytes of streams and buffers\n"
        )
    }

    /// The CSV file.
    ///
    /// # Errors
    /// If memory is short.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let row = |kernel: &KernelMeans| Row::new(COLUMNS).with(kernel).set("scene", self.scene.as_str());
        Ok(Table { columns: COLUMNS, rows: self.kernels().iter().map(row).collect() }.csv()?)
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, ScheduleKind};

    use super::*;
    use crate::paper;
    use crate::reporter::Silent;
    use crate::{Size, block_on};

    fn of(options: &Options) -> Intensity {
        let subject = paper::subject();
        block_on(None, intensity(&subject.scene, options, &Silent)).expect("a small scene")
    }

    #[test]
    fn a_pass_of_the_papers_kernels_moves_the_bytes_of_its_streams() {
        let counted = of(&paper::options(&paper::subject(), Size { width: 24, height: 16 }));
        let kernels = counted.kernels();
        let kernel = |name: &str| *kernels.iter().find(|kernel| kernel.kernel == name).expect(name);
        // Each ray is generated, set up and shaded once.
        for name in ["generate", "setup", "shade"] {
            assert_eq!((kernel(name).passes, kernel(name).elements), (1, 24 * 16), "{name}");
        }
        // generate loads the tag, and stores origin, direction, hit and state: 4 + 4 (3 + 3 + 3 + 4).
        let generate = kernel("generate");
        assert_eq!((generate.stream_bytes_read, generate.stream_bytes_written), (4.0, 52.0));
        assert_eq!(generate.buffer_bytes_read, 0.0);
        // traverse_grid loads the ray, the tag, t, the cell and tMax; it stores tMax, the tag, the cell and the item. A ray
        // that leaves the grid stores its tag only.
        let traverse = kernel("traverse_grid");
        assert_eq!(traverse.stream_bytes_read, 4.0 * (6.0 + 3.0 + 3.0));
        assert!((4.0..=24.0).contains(&traverse.stream_bytes_written), "{traverse:?}");
        // A test of a triangle loads nine words of it, but not for a list that is over.
        assert!((8.0..50.0).contains(&kernel("intersect").buffer_bytes_read), "{kernels:?}");
    }

    #[test]
    fn a_large_view_is_counted_in_a_small_image_and_text_and_csv_agree() {
        let subject = paper::subject();
        let view = |width, height| Options {
            accelerator: Accelerator::Bvh,
            schedule: ScheduleKind::Fused,
            ..Options::new(subject.camera_rays(Size { width, height }))
        };
        assert_eq!(of(&view(20, 10)).size, [20, 10]);
        let counted = of(&view(512, 256));
        assert!(u64::from(counted.size[0]) * u64::from(counted.size[1]) <= MOST_RAYS, "{:?}", counted.size);
        assert_eq!(counted.size, [90, 45]);
        let csv = String::from_utf8(counted.csv().expect("memory")).expect("UTF-8");
        let mut reader = ::csv::Reader::from_reader(csv.as_bytes());
        let rows: Vec<_> = reader.records().map(|row| row.expect("as many fields as names")).collect();
        assert_eq!(rows.len(), counted.works.len());
        for (row, kernel) in rows.iter().zip(counted.kernels()) {
            assert_eq!((&row[2], &row[4]), (kernel.kernel, kernel.elements.to_string().as_str()));
            assert!(counted.text().contains(&format!("  {} ", kernel.kernel)), "{}", counted.text());
        }
    }
}
