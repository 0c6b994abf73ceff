//! `cargo run --release -p raystep-lab --example traversals -- FOLDER`: how exactly Amanatides and Woo's walk, a
//! 3D-DDA and the walk with robust numerics decide which face a ray crosses next, with the twins in f32.
//!
//! All compare, for each axis, where the ray is when it reaches the next face along its driving axis: how far past the
//! next face of that axis, in cells. That is a control term; of tMax, it is the difference of two, times the cells that
//! the ray crosses per t. Its error is taken from the same value in f64, from the coordinates of the cell, after each
//! step of random lines through a cube. Writes FOLDER/traversals.csv and traversals.svg.

use std::fmt::Write as _;
use std::path::PathBuf;

use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::shared::grid_walk::{Grid, WalkRules};
use raystep_lab::plots::{Axis, Draw as _, Format, Mark, Plot, Scale, Series};
use raystep_lab::rays::Random;
use raystep_lab::statistics::median;

const RAYS: usize = 4000;
const RESOLUTIONS: [i32; 3] = [10, 100, 1000];
/// The paper's rules.
const PAPER: WalkRules = WalkRules { robust: false, clip: false, drifting: false, dda: false };
/// Walks, by name.
const WALKS: [(&str, WalkRules); 3] = [
    ("amanatides-woo", PAPER),
    ("3d-dda", WalkRules { dda: true, ..PAPER }),
    ("robust numerics", WalkRules { robust: true, ..PAPER }),
];

/// Errors after so many steps, of all rays that take them.
struct Sample {
    walk: &'static str,
    resolution: i32,
    steps: usize,
    errors: Vec<f64>,
}

/// How far the ray is past the next face of each axis when it reaches that of the driving axis, in cells, in f64.
fn exact(grid: &Grid, origin: [f32; 3], direction: [f32; 3], cell: [i32; 3], driving: usize) -> [f64; 3] {
    let width = grid.width.map(f64::from);
    let (o, d) = (origin.map(f64::from), direction.map(f64::from));
    let plane = [0, 1, 2].map(|a| width[a] * f64::from(cell[a] + i32::from(d[a] > 0.0)));
    let t = (plane[driving] - o[driving]) / d[driving];
    [0, 1, 2].map(|a| (o[a] + d[a] * t - plane[a]) * d[a].signum() / width[a])
}

/// The errors after 1, 2, 4 … steps, how many rays visit other cells than in f64, and of how many: those that are nearly
/// parallel to an axis are left out, as the paper's rules take them as parallel.
fn measure(walk: &'static str, rules: WalkRules, resolution: i32) -> (Vec<Sample>, [usize; 2]) {
    let mut random = Random::new(1);
    let width = [1.0 / resolution as f32; 3];
    let mut grid = Grid::default();
    (grid.cells, grid.width, grid.inverse_width) = ([resolution; 3], width, width.map(|w| 1.0 / w));
    let mut samples: Vec<Sample> = Vec::new();
    let [mut other, mut all] = [0, 0];
    for _ in 0..RAYS {
        let point = |random: &mut Random| [(); 3].map(|()| random.unit() as f32);
        let (from, to) = (point(&mut random), point(&mut random));
        let direction = [0, 1, 2].map(|a| to[a] - from[a]);
        // Almost at the side where it enters the cube, so that it crosses as many cells as a ray from outside.
        let behind = |a: usize| from[a] - f32::from(u8::from(direction[a] < 0.0));
        let t = (0..3).map(|a| behind(a) / direction[a]).fold(f32::INFINITY, f32::min) * 0.999;
        let origin = [0, 1, 2].map(|a| direction[a].mul_add(-t, from[a]));
        if direction.iter().any(|d| d.abs() < 1e-3) {
            continue;
        }
        all += 1;
        let [o, d] = [origin, direction].map(Vec3::<f32>::from_f32);
        let ray = grid.ray(rules, o, d);
        let mut walked = grid.enter(rules, &ray);
        let [o, d] = [origin, direction].map(Vec3::<f64>::from_f32);
        let reference = grid.ray(PAPER, o, d);
        let mut truth = grid.enter(PAPER, &reference);
        let speed = [0, 1, 2].map(|a| f64::from(direction[a].abs()) / f64::from(width[a]));
        let driving = (0..3).fold(0, |most, a| if speed[a] > speed[most] { a } else { most });
        let mut differs = false;
        for steps in 1usize.. {
            walked = grid.advance(rules, walked, &ray);
            truth = grid.advance(PAPER, truth, &reference);
            if !grid.is_in_grid(walked.cell) || !grid.is_in_grid(truth.cell) {
                break;
            }
            differs |= walked.cell != truth.cell;
            let per_axis = walked.per_axis.to_array().map(f64::from);
            let wanted = exact(&grid, origin, direction, walked.cell, driving);
            let error = (0..3).filter(|&a| a != driving).map(|a| {
                let term = if rules.dda { per_axis[a] } else { (per_axis[driving] - per_axis[a]) * speed[a] };
                (term - wanted[a]).abs()
            });
            if steps.is_power_of_two() {
                let place = samples.iter().position(|s| s.steps == steps).unwrap_or(samples.len());
                if place == samples.len() {
                    samples.push(Sample { walk, resolution, steps, errors: Vec::new() });
                }
                samples[place].errors.push(error.fold(0.0, f64::max));
            }
        }
        other += usize::from(differs);
    }
    (samples, [other, all])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("expected a folder")?);
    let mut csv = "traversal,cells_along_axis,steps,rays,median_error_cells,largest_error_cells\r\n".to_owned();
    let mut series = Vec::new();
    for resolution in RESOLUTIONS {
        for (color, (walk, rules)) in WALKS.into_iter().enumerate() {
            let (samples, [other, all]) = measure(walk, rules, resolution);
            println!("{walk}, {resolution}³ cells: {other} of {all} rays visit other cells than in f64");
            let mut points = Vec::new();
            for Sample { walk, resolution, steps, errors } in samples.iter().filter(|s| s.errors.len() >= RAYS / 4) {
                let (middle, most) = (median(errors).unwrap_or_default(), errors.iter().copied().fold(0.0, f64::max));
                write!(csv, "{walk},{resolution},{steps},{},{middle:e},{most:e}\r\n", errors.len())?;
                points.push((*steps as f64, middle));
            }
            let mark = [Mark::Dot, Mark::Square, Mark::Triangle]
                [RESOLUTIONS.iter().position(|r| *r == resolution).unwrap_or_default()];
            series.push(Series { mark, ..Series::line(format!("{walk}, {resolution}³"), color, points) });
        }
    }
    let plot = Plot::new(
        "Error of what decides a step: median of rays",
        Axis::new("steps", Scale::Log),
        Axis::new("cells", Scale::Log),
        series,
    );
    std::fs::write(folder.join("traversals.csv"), csv)?;
    std::fs::write(folder.join("traversals.svg"), plot.picture(Format::Screen).ok_or("nothing to plot")?.svg())?;
    Ok(())
}
