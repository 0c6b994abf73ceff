//! The Utah teapot on a table.

use glam::{DVec3, Vec3};
use raystep_scenes::{Camera, Light, Material, Projection, Scene};
use std::collections::HashMap;
use std::error::Error;

/// Reads `teapot.js`: `exports.positions=[[x,y,z],…]` and `exports.cells=[[a,b,c],…]`.
pub(crate) fn teapot(source: &str) -> Result<Scene, Box<dyn Error>> {
    let positions: Vec<[f32; 3]> = serde_json::from_value(list(source, "positions")?)?;
    let cells: Vec<[usize; 3]> = serde_json::from_value(list(source, "cells")?)?;
    let place = |i: usize| positions.get(i).map(|&p| Vec3::from(p)).ok_or("a cell names no position");
    // Vertex normals: the mean of adjacent face normals, weighted by area (Gouraud 1971). Patches have separate
    // vertices along their seams, so vertices with the same position are treated as one.
    let spot = |i: usize| positions[i].map(|v| (v * 1000.0).round() as i64);
    let mut normals = HashMap::<_, Vec3>::new();
    for &[a, b, c] in &cells {
        let normal = (place(b)? - place(a)?).cross(place(c)? - place(a)?);
        [a, b, c].iter().for_each(|&i| *normals.entry(spot(i)).or_default() += normal);
    }
    let material = |name: &str, base_color, double_sided| Material {
        name: name.to_owned(),
        base_color,
        double_sided,
        ..Material::default()
    };
    let mut scene = Scene {
        name: "teapot".to_owned(),
        // Double-sided: the inside is visible between lid and body.
        materials: vec![material("china", [0.55, 0.63, 0.70], true), material("table", [0.42, 0.26, 0.15], false)],
        ..Scene::default()
    };
    let mut corner_normals = Vec::new();
    for cell in &cells {
        scene.triangles.push(cell.map(|i| positions[i]));
        corner_normals.push(cell.map(|i| normals[&spot(i)].normalize_or(Vec3::Y).to_array()));
        scene.triangle_materials.push(0);
    }
    let bottom = scene.bounds().min.y;
    let table = [[-16.0, 14.0], [16.0, 14.0], [16.0, -14.0], [-16.0, -14.0]].map(|[x, z]| [x, bottom, z]);
    for t in [[0, 1, 2], [0, 2, 3]] {
        scene.triangles.push(t.map(|i: usize| table[i]));
        corner_normals.push([[0.0, 1.0, 0.0]; 3]);
        scene.triangle_materials.push(1);
    }
    scene.normals = Some(corner_normals);
    let lamp = |position, color| Light::Point { position, color, intensity: 900.0 };
    scene.lights = vec![lamp([12.0, 26.0, 20.0], [0.9, 0.86, 0.8]), lamp([-30.0, 10.0, 12.0], [0.2, 0.24, 0.3])];
    let projection = Projection::Perspective { vertical_fov: 40f64.to_radians() };
    let camera = Camera::look_at(DVec3::new(10.0, 24.0, 50.0), DVec3::new(0.5, 5.5, 0.0), DVec3::Y, projection);
    scene.cameras = camera.into_iter().map(|c| Camera { name: "camera".to_owned(), ..c }).collect();
    Ok(scene)
}

/// The array after `exports.NAME=`.
fn list(source: &str, name: &str) -> Result<serde_json::Value, Box<dyn Error>> {
    let start = format!("exports.{name}=");
    let at = source.find(&start).ok_or_else(|| format!("there is no '{start}'"))? + start.len();
    let value = serde_json::Deserializer::from_str(&source[at..]).into_iter().next();
    Ok(value.ok_or("the list is missing")??)
}
