//! Small OBJ, PLY and STL files, and what is read from them.
#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use glam::DVec3;
use raystep_scenes::{LoadError, LoadOptions, NoFiles, Scene, load};

pub(crate) const TRIANGLE: [[[f32; 3]; 3]; 1] = [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]];

pub(crate) fn read(name: &str, bytes: &[u8]) -> Result<Scene, LoadError> {
    load(name, bytes, &NoFiles, &LoadOptions::default())
}

#[track_caller]
pub(crate) fn scene(name: &str, bytes: &[u8]) -> Scene {
    read(name, bytes).unwrap_or_else(|error| panic!("{error}, of {:?}", String::from_utf8_lossy(bytes)))
}

#[track_caller]
pub(crate) fn obj(text: &str) -> Scene {
    scene("a.obj", text.as_bytes())
}

#[track_caller]
pub(crate) fn ply(text: &str) -> Scene {
    scene("a.ply", text.as_bytes())
}

/// The message of the error that reading must return.
#[track_caller]
pub(crate) fn error(name: &str, bytes: &[u8]) -> String {
    let text = read(name, bytes).expect_err(&String::from_utf8_lossy(bytes)).to_string();
    assert!(!text.contains(['\n', '\r']) && text.len() < 300, "{text}");
    text
}

pub(crate) fn notes(scene: &Scene) -> Vec<&str> {
    scene.notes.iter().map(|note| note.0.as_str()).collect()
}

/// The area of all triangles.
pub(crate) fn area(scene: &Scene) -> f64 {
    let area = |t: &[[f32; 3]; 3]| {
        let [a, b, c] = t.map(|p| DVec3::from(p.map(f64::from)));
        (b - a).cross(c - a).length() / 2.0
    };
    scene.triangles.iter().map(area).sum()
}
