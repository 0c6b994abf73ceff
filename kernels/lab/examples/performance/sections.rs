//! What the sections that trace rays compare.

use raystep_kernels::{Accelerator, GridSize, Numerics, ScheduleKind, Skip};
use raystep_lab::configuration::Configuration;
use raystep_lab::paper::{GRID, SECONDS};
use raystep_lab::{RayKind, Size, Subject};

use crate::measure::Section;
use crate::subjects::{Mesh, generated};

/// Triangles of the terrain that represents an ordinary scene.
const TERRAIN: u64 = 20_000;

fn fused(accelerator: Accelerator) -> Configuration {
    Configuration::new(accelerator, ScheduleKind::Fused, 1)
}

fn compact(accelerator: Accelerator, steps: u32) -> Configuration {
    Configuration::new(accelerator, ScheduleKind::Compact, steps)
}

/// The paper's scene, and a larger one.
pub(crate) fn two_scenes() -> Result<[Subject; 2], String> {
    Ok([generated("cornell-box", None)?, generated("terrain", Some(TERRAIN))?])
}

impl Section<'_> {
    /// The image size for sections that measure only one.
    fn one_size(&self) -> Size {
        let [width, height] = self.setup.choose([1920, 1080], [512, 512], [128, 128]);
        Size { width, height }
    }

    pub(crate) fn paper(&mut self) -> Result<(), String> {
        use Accelerator::{Bvh, Grid, Irregular, None};
        use ScheduleKind::{First, Second};
        let grid = Some(GRID);
        let mut all = Vec::new();
        for numerics in [Numerics::Paper, Numerics::Robust] {
            let of = |accelerator, schedule| Configuration { numerics, ..Configuration::new(accelerator, schedule, 1) };
            for grid in [GRID, GridSize::Auto].map(Some) {
                all.extend([First, Second].map(|schedule| Configuration { grid, ..of(Grid, schedule) }));
            }
            all.push(of(None, Second));
        }
        for one in [compact(Grid, 1), compact(Grid, 8), fused(Grid)] {
            all.extend([one, one.skipping(), Configuration { grid, ..one }]);
        }
        for accelerator in [Bvh, Irregular, None] {
            all.extend([compact(accelerator, 1), compact(accelerator, 8), fused(accelerator)]);
        }
        let subject = generated("cornell-box", Option::None)?;
        for (side, _) in SECONDS.into_iter().take(if self.setup.is_quick { 2 } else { SECONDS.len() }) {
            self.group(&subject, RayKind::Primary, Size { width: side, height: side }, all.clone());
        }
        Ok(())
    }

    pub(crate) fn resolution(&mut self) -> Result<(), String> {
        use Accelerator::{Bvh, Grid};
        // From 0.25 to 8.3 million pixels.
        const SIZES: [[u32; 2]; 7] =
            [[640, 384], [960, 540], [1280, 720], [1920, 1080], [2560, 1440], [3200, 1800], [3840, 2160]];
        const SMALL: [[u32; 2]; 4] = [[128, 96], [256, 192], [320, 240], [512, 384]];
        for subject in &two_scenes()? {
            for &[width, height] in self.setup.choose(&SIZES[..], &SIZES[..4], &SMALL[..]) {
                let all = vec![fused(Bvh), fused(Grid), compact(Bvh, 8), compact(Grid, 8)];
                self.group(subject, RayKind::Primary, Size { width, height }, all);
            }
        }
        Ok(())
    }

    pub(crate) fn steps(&mut self) -> Result<(), String> {
        let steps = |accelerator| [1, 2, 4, 8, 16, 32, 64].map(|steps| compact(accelerator, steps));
        let of = |accelerator| [vec![fused(accelerator)], steps(accelerator).into()].concat();
        for subject in &two_scenes()? {
            let all = [of(Accelerator::Grid), of(Accelerator::Bvh)].concat();
            self.group(subject, RayKind::Primary, self.one_size(), all);
        }
        Ok(())
    }

    /// By kind first: if time runs out, every scene has at least its primary rays.
    pub(crate) fn meshes(&mut self, meshes: &[Mesh]) -> Result<(), String> {
        use Accelerator::{Bvh, Grid, Irregular};
        let of = |one: fn(Accelerator) -> Configuration| [Bvh, Irregular, Grid].map(one);
        let mut all = Vec::new();
        for eight_or_all in [of(fused), of(|accelerator| compact(accelerator, 8))] {
            all.extend(eight_or_all);
            all.push(eight_or_all[2].skipping());
        }
        all.extend(of(|accelerator| compact(accelerator, 1)));
        all.extend(of(|accelerator| Configuration::new(accelerator, ScheduleKind::Second, 1)));
        let mut subjects = vec![generated("cornell-box", None)?];
        for mesh in meshes {
            subjects.push(mesh.read()?);
        }
        for &kind in RayKind::ALL {
            for subject in &subjects {
                self.group(subject, kind, self.one_size(), all.clone());
            }
        }
        Ok(())
    }

    pub(crate) fn triangles(&mut self) -> Result<(), String> {
        use Accelerator::{Bvh, Grid, Irregular};
        const COUNTS: [u64; 14] =
            [2, 8, 18, 32, 72, 128, 512, 2_048, 8_192, 32_768, 131_072, 524_288, 2_000_000, 10_000_000];
        /// A run without an accelerator is skipped if it is expected to take longer than this.
        const MOST_NS: f64 = 0.5e9;
        /// Most triangles for which the host builds an irregular grid: it takes some 5 s for a million.
        const MOST_IRREGULAR: u64 = 600_000;
        let fast = if self.setup.is_quick { (131_072, 512) } else { (10_000_000, 1024) };
        let (most, side) = self.setup.choose(fast, (2_000_000, 256), (8_192, 128));
        // The last time without an accelerator, per scene: it is proportional to triangles from a few hundred up.
        let mut last = [None::<(f64, f64)>; 2];
        for count in COUNTS.into_iter().filter(|&count| count <= most) {
            for (scene, last) in ["terrain", "soup"].into_iter().zip(&mut last) {
                if self.is_over() {
                    self.late(&format!("{scene} of {count} triangles"));
                    continue;
                }
                let subject = generated(scene, Some(count))?;
                let triangles = subject.scene.triangles.len() as f64;
                let expected_ns = last.map_or(0.0, |(before, ns)| ns * triangles / before);
                let of_grid = |one: Configuration| Configuration { skip: Skip::Auto, ..one };
                let mut all = vec![of_grid(fused(Grid)), fused(Bvh), of_grid(compact(Grid, 8)), compact(Bvh, 8)];
                if count <= MOST_IRREGULAR {
                    all.insert(1, fused(Irregular));
                }
                if expected_ns < MOST_NS {
                    all.push(fused(Accelerator::None));
                } else {
                    let seconds = expected_ns / 1e9;
                    self.notes.push(format!(
                        "omitted: {scene} of {count} triangles, {}: {seconds:.1} s were expected",
                        fused(Accelerator::None)
                    ));
                }
                let rows = self.group(&subject, RayKind::Primary, Size { width: side, height: side }, all);
                let none = rows.iter().find(|row| row.get("accelerator") == "none");
                *last = none.and_then(|row| row.number("median_ns")).map(|ns| (triangles, ns)).or(*last);
            }
        }
        Ok(())
    }
}
