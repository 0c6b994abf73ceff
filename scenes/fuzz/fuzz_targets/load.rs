//! Loads arbitrary bytes: no panic, no hang, no large allocation, and scenes that satisfy the guarantees of `Scene`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use raystep_scenes::{FileError, Light, LoadOptions, Resolver, load};

/// A file beside the scene, so that external buffers and images are reached.
struct Beside;

const PNG: &[u8] = include_bytes!("../beside.png");

impl Resolver for Beside {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
        match path {
            "a.png" => Ok(PNG.to_vec()),
            "a.bin" => Ok((0..=255).collect()),
            _ => Err("there is no such file".into()),
        }
    }
}

/// Text up to a zero byte and the bytes after it, as the two chunks of a GLB. If a mutation changes the length of a
/// real GLB's JSON, the lengths in its headers are wrong; few such files would reach the geometry.
fn as_glb(bytes: &[u8]) -> Option<Vec<u8>> {
    let zero = bytes.iter().position(|&byte| byte == 0).filter(|_| bytes.starts_with(b"{"))?;
    let (json, bin) = (&bytes[..zero], &bytes[zero + 1..]);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + bytes.len() as u32 - 1).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    Some(glb)
}

/// The bytes after a `P` as an OBJ of one polygon, each three the coordinates of a corner on a lattice, where corners and
/// edges often touch. Mutations of text seldom keep so many corners.
fn as_polygon(bytes: &[u8]) -> Option<Vec<u8>> {
    let corners = bytes.strip_prefix(b"P")?.chunks_exact(3);
    let mut obj: String =
        corners.clone().map(|corner| format!("v {} {} {}\n", corner[0], corner[1], corner[2] / 64)).collect();
    obj += "f";
    (1..=corners.len()).for_each(|corner| obj += &format!(" {corner}"));
    Some(obj.into_bytes())
}

/// A name with an ending where the contents do not show the format: binary STL seldom has the right length, and OBJ has
/// no mark at all.
fn name(bytes: &[u8]) -> &'static str {
    if bytes.starts_with(b"STL") { "fuzz.stl" } else { "fuzz.obj" }
}

fuzz_target!(|bytes: &[u8]| {
    let made = as_glb(bytes).or_else(|| as_polygon(bytes));
    let options = LoadOptions { max_bytes: 16 << 20, ..LoadOptions::default() };
    let Ok(scene) = load(name(bytes), made.as_deref().unwrap_or(bytes), &Beside, &options) else { return };
    let count = scene.triangles.len();
    assert!(scene.offset.is_finite());
    assert!(scene.triangles.iter().flatten().flatten().all(|c| c.is_finite()));
    assert_eq!(scene.triangle_materials.len(), count);
    assert!(scene.triangle_materials.iter().all(|&m| (m as usize) < scene.materials.len()));
    assert!(!scene.materials.is_empty());
    for material in &scene.materials {
        assert!(material.texture.is_none_or(|t| (t as usize) < scene.textures.len()));
        assert!(material.base_color.iter().chain(&material.emissive).all(|c| c.is_finite()));
    }
    for texture in &scene.textures {
        assert_eq!(texture.texels.len(), texture.width as usize * texture.height as usize);
        assert!(!texture.texels.is_empty());
    }
    if let Some(normals) = &scene.normals {
        assert_eq!(normals.len(), count);
        for normal in normals.iter().flatten() {
            let square: f32 = normal.iter().map(|c| c * c).sum();
            assert!((square - 1.0).abs() < 1e-5, "{normal:?}");
        }
    }
    if let Some(texcoords) = &scene.texcoords {
        assert_eq!(texcoords.len(), count);
        assert!(texcoords.iter().flatten().flatten().all(|c| c.is_finite()));
    }
    if let Some(colors) = &scene.colors {
        assert_eq!(colors.len(), count);
        assert!(colors.iter().flatten().flatten().all(|c| c.is_finite()));
    }
    for camera in &scene.cameras {
        assert!((camera.right.cross(camera.up) + camera.forward).length() < 1e-9, "{camera:?}");
        assert!(camera.eye.is_finite());
    }
    for light in &scene.lights {
        if let Light::Spot { inner_cone, outer_cone, .. } = *light {
            assert!(
                0.0 <= inner_cone && inner_cone < outer_cone && outer_cone <= std::f32::consts::FRAC_PI_2,
                "{light:?}"
            );
        }
    }
    for note in &scene.notes {
        assert!(!note.0.contains('\n'), "{note:?}");
    }
});
