//! The scene files in this folder: each loads and has the number of triangles given in README.md, and the Cornell box
//! equals the generated one.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use raystep_scenes::{LoadOptions, Resolver, generate, load};
use std::fs;
use std::path::{Path, PathBuf};

struct Beside(PathBuf);

impl Resolver for Beside {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, raystep_scenes::FileError> {
        fs::read(self.0.join(path)).map_err(|e| e.to_string().into())
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

fn read(name: &str) -> raystep_scenes::Scene {
    let bytes = fs::read(folder().join(name)).unwrap();
    load(name, &bytes, &Beside(folder()), &LoadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn every_file_has_the_triangles_that_the_readme_says() {
    let readme = fs::read_to_string(folder().join("README.md")).unwrap();
    let mut files = 0;
    for entry in fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.ends_with(".gltf") || name.ends_with(".glb") {
            files += 1;
            let row = readme
                .lines()
                .find(|l| l.starts_with(&format!("| `{name}`")))
                .unwrap_or_else(|| panic!("no row for {name}"));
            let told = row.split('|').nth(2).unwrap().trim().replace(',', "");
            assert_eq!(told, read(&name).triangles.len().to_string(), "{name}");
        }
    }
    assert_eq!(
        files,
        readme.lines().filter(|l| l.starts_with("| `") && l.contains(".gl")).count(),
        "a row of README.md has no file"
    );
}

#[test]
fn the_cornell_box_is_the_generated_one() {
    let (file, made) = (read("cornell-box.gltf"), generate::cornell_box());
    assert_eq!(file.triangles, made.triangles);
    assert_eq!(file.materials, made.materials);
    assert_eq!(file.lights, made.lights);
    assert_eq!(file.cameras.len(), 1);
    assert!((file.cameras[0].eye - made.cameras[0].eye).length() < 1e-6);
}
