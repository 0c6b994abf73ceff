//! The scenes to trace.

use std::path::{Path, PathBuf};

use glam::DVec3;
use raystep_lab::{Hash, Subject};
use raystep_scenes::{Camera, FileError, LoadOptions, Projection, Resolver, Scene, generate};

/// A mesh to load.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mesh {
    name: String,
    file: PathBuf,
    /// Eye, look-at point, vertical field of view in radians.
    view: Option<(DVec3, DVec3, f64)>,
}

/// Parses `NAME=FILE` or `NAME=FILE:EYE:LOOK_AT:FOV`.
pub(crate) fn mesh(text: &str) -> Result<Mesh, String> {
    let (name, rest) = text.split_once('=').ok_or("expected NAME=FILE or NAME=FILE:EYE:LOOK_AT:FOV")?;
    // Split from the right: file names may contain colons.
    let parts: Vec<&str> = rest.rsplitn(4, ':').collect();
    let view = match parts[..] {
        [fov, look_at, eye, _] => point(eye).zip(point(look_at)).zip(fov.parse::<f64>().ok()),
        _ => None,
    };
    let (file, view) = match view {
        Some(((eye, look_at), fov)) => (parts[3], Some((eye, look_at, fov.to_radians()))),
        None => (rest, None),
    };
    Ok(Mesh { name: name.into(), file: file.into(), view })
}

fn point(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
    <[f64; 3]>::try_from(numbers).ok().map(DVec3::from)
}

/// The folder with a mesh's external files.
struct Beside(PathBuf);

impl Resolver for Beside {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
        std::fs::read(self.0.join(path)).map_err(|e| e.to_string().into())
    }
}

fn subject(name: &str, mut scene: Scene, hash: Hash) -> Subject {
    // Nothing is shaded, so drop normals and other attributes: there may be ten million.
    (scene.normals, scene.colors, scene.texcoords) = (None, None, None);
    scene.name = name.into();
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
    Subject { scene, camera, hash, file: name.into() }
}

/// A generated scene of about this many triangles.
pub(crate) fn generated(name: &str, triangles: Option<u64>) -> Result<Subject, String> {
    let given: Vec<_> = triangles.map(|n| ("triangles", n)).into_iter().collect();
    let scene = generate::find(name).and_then(|generator| generator.make(&given)).map_err(|e| e.to_string())?;
    Ok(subject(name, scene, Hash::of(name.as_bytes())))
}

impl Mesh {
    /// Reads the file.
    pub(crate) fn read(&self) -> Result<Subject, String> {
        let at = self.file.display().to_string();
        let wrong = |e: &dyn std::fmt::Display| format!("{at}: {e}");
        let bytes = std::fs::read(&self.file).map_err(|e| wrong(&e))?;
        let beside = Beside(self.file.parent().unwrap_or(Path::new(".")).into());
        let scene = raystep_scenes::load(&at, &bytes, &beside, &LoadOptions::default()).map_err(|e| wrong(&e))?;
        let mut subject = subject(&self.name, scene, Hash::of(&bytes));
        if let Some((eye, look_at, vertical_fov)) = self.view {
            let projection = Projection::Perspective { vertical_fov };
            subject.camera = Camera::look_at(eye, look_at, DVec3::Y, projection)
                .ok_or_else(|| format!("--mesh {}: the eye and the point looked at are the same", self.name))?;
        }
        Ok(subject)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_may_have_a_view_and_a_colon_in_its_name() {
        let view = Some((DVec3::new(1.0, -2.0, 0.5), DVec3::ZERO, 90f64.to_radians()));
        let plain = mesh("a=c:/x y.glb").expect("a mesh");
        assert_eq!((plain.file, plain.view), (PathBuf::from("c:/x y.glb"), None));
        let viewed = mesh("a=c:/x.glb:1,-2,.5:0,0,0:90").expect("a mesh");
        assert_eq!((viewed.name, viewed.file, viewed.view), ("a".into(), PathBuf::from("c:/x.glb"), view));
        assert!(mesh("x.glb").is_err());
    }
}
