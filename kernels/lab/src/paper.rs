//! The tables of Mølhave's paper (*Implementing a Ray Tracer on a GPU*, 2004) beside ours: the Cornell box of 26
//! triangles, a grid of 20×20×20 cells or none, the paper's schedules and rules.

mod counts;
mod outputs;
mod times;

use raystep_kernels::{GridSize, Numerics, Options, ScheduleKind};
use raystep_scenes::{Camera, Scene, generate};

use crate::intensity;
use crate::tidy::package::Resource;
use crate::{Hash, Size, Subject};
pub use counts::{Counts, counts};
pub use outputs::{Output, Outputs, outputs};
pub use times::{SECONDS, Times, times};

/// The paper's grid.
pub const GRID: GridSize = GridSize::Cells([20; 3]);

/// The CSV files: Table 1, Tables 2 and 3, arithmetic intensity (§3.1), and counts (§4.5 and §5.2).
pub const FILES: [Resource<'static>; 4] = [
    Resource { file: "table_1.csv", what: "a kernel of the paper's Table 1", columns: outputs::COLUMNS },
    Resource { file: "tables_2_3.csv", what: "a row of the paper's Table 2 or 3", columns: times::COLUMNS },
    Resource { file: "intensity.csv", what: "a kernel", columns: intensity::COLUMNS },
    Resource { file: "counts.csv", what: "a number of the paper's sections 4.5 and 5.2", columns: counts::COLUMNS },
];

/// The paper's scene, from the library: no file is needed.
#[must_use]
pub fn subject() -> Subject {
    let scene = generate::cornell_box();
    let camera = camera(&scene);
    let name = scene.name.as_bytes();
    Subject { camera, hash: Hash::of(name), file: scene.name.clone(), scene }
}

fn camera(scene: &Scene) -> Camera {
    scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()))
}

/// The paper's second strategy with its grid and its rules.
#[must_use]
pub fn options(subject: &Subject, size: Size) -> Options {
    Options {
        schedule: ScheduleKind::Second,
        numerics: Numerics::Paper,
        grid: GRID,
        ..Options::new(subject.camera_rays(size))
    }
}

/// Rows of words in columns, indented, below a title.
fn titled(title: &str, lines: &[Vec<String>], left: usize) -> String {
    let lines: String = crate::text::aligned(lines, left).iter().map(|line| format!("  {line}")).collect();
    format!("{title}\n{lines}")
}

/// Cells of text.
fn cells<const N: usize>(texts: [&str; N]) -> Vec<String> {
    texts.map(str::to_owned).into()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Limits, Plan};

    use super::*;

    #[test]
    fn every_difference_from_table_1_has_a_reason() {
        let subject = subject();
        let options = options(&subject, Size { width: 8, height: 8 });
        let (plan, _) = Plan::new(&subject.scene, &options, &Limits::CPU).expect("a small scene");
        let outputs = outputs(&plan);
        assert_eq!(outputs.0.len(), 5);
        assert!(outputs.0.iter().all(|output| output.is_explained()), "{outputs:?}");
        // As the WGSL has them today: whoever changes a kernel's outputs changes the page.
        let here: Vec<&str> = outputs.0.iter().map(|output| output.streams.as_str()).collect();
        let wanted =
            ["ray_origin, ray_direction, state, hit", "state, tmax", "state, tmax", "state, hit", "state, color"];
        assert_eq!(here, wanted);
        let csv = String::from_utf8(outputs.csv().expect("memory")).expect("UTF-8");
        assert_eq!(csv.lines().count(), 6, "{csv}");
    }

    #[test]
    fn programs_and_textures_are_those_of_the_plan() {
        let counts = counts(&subject()).expect("a small scene");
        let text = counts.text();
        for words in ["12 as fragment programs", "5 as compute shaders", "6 streams"] {
            assert!(text.contains(words), "{words}: {text}");
        }
        // The paper's own Table 1 has 12 outputs, so 12 of its 16 programs.
        let table_1: usize = outputs::PAPER.iter().map(|(_, _, streams)| streams.len()).sum();
        assert_eq!(table_1, 12);
    }

    #[test]
    fn the_papers_seconds_are_in_its_order() {
        for (_, [first, second, none]) in SECONDS {
            assert!(first > second && second > none);
        }
        // What its section 5 says of them.
        let (side, [_, second, none]) = SECONDS[3];
        assert_eq!((side, (second / none * 100.0_f64).round()), (756, 323.0));
    }
}
