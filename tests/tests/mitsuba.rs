//! Pictures along paths against those of Mitsuba 3, another path tracer: how its references were made, and which conventions
//! differ, is in `tests/data/mitsuba/make.py`.

use std::ops::ControlFlow;

use glam::DVec3;
use raystep_kernels::options::Integrator;
use raystep_kernels::{Accelerator, Device, Options, RaySource, Renderer, Samples, ScheduleKind};
use raystep_scenes::{Camera, Light, Material, Projection, Scene};
use raystep_tests::{block_on, scene};
use serde_json::Value;

const SCENES: &str = include_str!("../data/mitsuba/scenes.json");
const REFERENCES: &str = include_str!("../data/mitsuba/references.csv");

const SIDE: u32 = 64;
/// Pixels of a block along an axis, and blocks.
const BLOCK: usize = 4;
const BLOCKS: usize = SIDE as usize / BLOCK;
/// Independent scrambles, and samples of each.
const SCRAMBLES: u32 = 16;
const SAMPLES: u32 = 8;
/// Student's t of 15 degrees of freedom at a level of 0.001 by Bonferroni, which is the first step of Holm's test: for each of
/// 2,304 blocks and channels, and for the mean of each of nine.
const MOST_OF_BLOCKS: f64 = 8.45;
const MOST_OF_PICTURES: f64 = 5.18;
/// The mean square of the scores of 256 blocks is 15 / 13, with a standard deviation of 0.115 between pictures: four of these
/// more.
const MOST_SQUARE: f64 = 1.62;
/// Relative error by six digits, and by sums of f32: all that is left where a block sees nothing but the sky.
const ROUNDING: f64 = 1e-5;
/// What tells pictures apart: the standard error of a picture's mean, relative to it, is below this.
const PRECISION: f64 = 0.004;

/// Red, green and blue of each block.
type Means = Vec<[f64; 3]>;

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| value[i].as_f64().expect("a number")))
}

fn rgb(value: &Value) -> [f32; 3] {
    vector(value).as_vec3().to_array()
}

/// A scene of the list: what the file has, flat, under other lights.
fn scene_of(row: &Value) -> Scene {
    let mut scene = scene(row["file"].as_str().expect("a name"));
    scene.normals = None;
    let lamp = &row["lamp"];
    if !lamp.is_null() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| rgb(&lamp["corners"][i]));
        scene.triangles.extend([[a, b, c], [a, c, d]]);
        scene.triangle_materials.extend([scene.materials.len() as u32; 2]);
        let emissive = rgb(&lamp["radiance"]);
        scene.materials.push(Material { base_color: [0.0; 3], emissive, ..Material::default() });
    }
    let light = |light: &Value| {
        let (color, intensity) = (rgb(&light["color"]), light["intensity"].as_f64().expect("a number") as f32);
        match light.get("position") {
            Some(position) => Light::Point { position: rgb(position), color, intensity },
            None => {
                let direction = vector(&light["direction"]).normalize().as_vec3().to_array();
                Light::Directional { direction, color, intensity }
            }
        }
    };
    scene.lights = row["lights"].as_array().expect("a list").iter().map(light).collect();
    scene
}

fn options_of(row: &Value, seed: u32) -> Options {
    let camera = &row["camera"];
    let projection =
        Projection::Perspective { vertical_fov: camera["fov_degrees"].as_f64().expect("an angle").to_radians() };
    let camera = Camera::look_at(vector(&camera["eye"]), vector(&camera["look_at"]), DVec3::Y, projection);
    let camera = camera.expect("a camera");
    Options {
        integrator: Integrator::Path,
        accelerator: Accelerator::Bvh,
        schedule: ScheduleKind::Fused,
        max_depth: row["max_depth"].as_u64().expect("a depth") as u32,
        samples: Samples { count: SAMPLES, seed, ..Samples::default() },
        ..Options::new(RaySource::Camera { camera, width: SIDE, height: SIDE })
    }
}

fn means_of(scene: &Scene, options: &Options) -> Means {
    let image = block_on(None, async {
        let mut renderer = Renderer::new(scene, options, &Device::Cpu(None)).await.expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        renderer.image().await.expect("an image")
    });
    let mut means = vec![[0.0; 3]; BLOCKS * BLOCKS];
    for (i, pixel) in image.pixels.iter().enumerate() {
        let (x, y) = (i % SIDE as usize, i / SIDE as usize);
        for (mean, value) in means[y / BLOCK * BLOCKS + x / BLOCK].iter_mut().zip(pixel) {
            *mean += f64::from(*value) / (BLOCK * BLOCK) as f64;
        }
    }
    means
}

/// Mitsuba's means of a scene, and their standard errors.
fn reference(number: usize) -> [Means; 2] {
    let rows = REFERENCES.lines().skip(1).map(|line| {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().expect("a number")).collect();
        values
    });
    let of_scene = rows.filter(|row| row[0] == number as f64);
    let (means, errors) = of_scene.map(|row| ([row[3], row[4], row[5]], [row[6], row[7], row[8]])).unzip();
    [means, errors]
}

/// A difference, and its standard error, which follows from the scrambles and from the reference's own.
fn compared(scrambles: &[f64], expected: f64, its_error: f64) -> [f64; 2] {
    let n = scrambles.len() as f64;
    let mean = scrambles.iter().sum::<f64>() / n;
    let variance = scrambles.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean - expected, (variance / n + its_error.powi(2) + (ROUNDING * expected).powi(2)).sqrt()]
}

#[test]
fn pictures_agree_with_those_of_mitsuba() {
    let scenes: Vec<Value> = serde_json::from_str(SCENES).expect("JSON");
    for (number, row) in scenes.iter().enumerate() {
        let scene = scene_of(row);
        let scrambles: Vec<Means> = (0..SCRAMBLES).map(|seed| means_of(&scene, &options_of(row, seed))).collect();
        let [expected, errors] = reference(number);
        assert_eq!(expected.len(), BLOCKS * BLOCKS);
        for channel in 0..3 {
            let score_of = |i: usize| {
                let values: Vec<f64> = scrambles.iter().map(|means| means[i][channel]).collect();
                let [difference, error] = compared(&values, expected[i][channel], errors[i][channel]);
                difference / error
            };
            let scores: Vec<f64> = (0..BLOCKS * BLOCKS).map(score_of).collect();
            let most = scores.iter().fold(0.0f64, |most, score| most.max(score.abs()));
            let square = scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64;
            let mean = |means: &Means| means.iter().map(|rgb| rgb[channel]).sum::<f64>() / means.len() as f64;
            let its_error = errors.iter().map(|rgb| rgb[channel].powi(2)).sum::<f64>().sqrt() / errors.len() as f64;
            let total = mean(&expected);
            let [difference, error] = compared(&scrambles.iter().map(mean).collect::<Vec<_>>(), total, its_error);
            let text = format!(
                "{}, channel {channel}: mean {total:.6} off by {:+.3}% ± {:.3}%; blocks: largest score {most:.2}, mean \
                 square {square:.2}",
                row["name"],
                100.0 * difference / total,
                100.0 * error / total
            );
            println!("{text}");
            assert!(most < MOST_OF_BLOCKS && square < MOST_SQUARE, "{text}");
            assert!(difference.abs() < MOST_OF_PICTURES * error && error < PRECISION * total, "{text}");
        }
    }
}
