//! Identifies a scene by its contents.

use raystep_lab::Hash;
use raystep_scenes::{Light, Optics, Projection, Scene};

/// A hash of everything that results depend on: geometry, materials, textures, lights, cameras. Names do not count, nor
/// does the file that the scene was read from.
#[must_use]
pub fn scene_hash(scene: &Scene) -> Hash {
    let mut hash = Hash::default();
    let mut part = |tag: u8, bytes: &[u8]| {
        // Parts of other lengths must not run into each other.
        hash.add(&[tag]);
        hash.add(&(bytes.len() as u64).to_le_bytes());
        hash.add(bytes);
    };
    part(0, bytemuck::cast_slice(scene.triangles.as_flattened().as_flattened()));
    if let Some(normals) = &scene.normals {
        part(1, bytemuck::cast_slice(normals.as_flattened().as_flattened()));
    }
    if let Some(texcoords) = &scene.texcoords {
        part(2, bytemuck::cast_slice(texcoords.as_flattened().as_flattened()));
    }
    if let Some(colors) = &scene.colors {
        part(3, bytemuck::cast_slice(colors.as_flattened().as_flattened()));
    }
    part(4, bytemuck::cast_slice(&scene.triangle_materials));
    for material in &scene.materials {
        part(5, bytemuck::cast_slice(&[material.base_color, material.emissive]));
        part(6, &material.texture.unwrap_or(u32::MAX).to_le_bytes());
        part(7, &[u8::from(material.double_sided)]);
        match material.optics {
            Optics::Diffuse | Optics::Rough => {}
            Optics::Mirror => part(17, &[]),
            Optics::Dielectric { ior, is_thin } => part(18, bytemuck::cast_slice(&[ior, f32::from(u8::from(is_thin))])),
        }
    }
    for texture in &scene.textures {
        part(8, bytemuck::cast_slice(&[texture.width, texture.height]));
        part(9, texture.texels.as_flattened());
        part(10, &[texture.wrap_u as u8, texture.wrap_v as u8, u8::from(texture.linear)]);
    }
    for light in &scene.lights {
        match light {
            Light::Point { position, color, intensity } => {
                part(11, bytemuck::cast_slice(&[*position, *color, [*intensity; 3]]));
            }
            Light::Directional { direction, color, intensity } => {
                part(12, bytemuck::cast_slice(&[*direction, *color, [*intensity; 3]]));
            }
            Light::Spot { position, direction, color, intensity, inner_cone, outer_cone } => {
                let cone = [*intensity, *inner_cone, *outer_cone];
                part(13, bytemuck::cast_slice(&[*position, *direction, *color, cone]));
            }
        }
    }
    for camera in &scene.cameras {
        let axes = [camera.eye, camera.right, camera.up, camera.forward].map(|v| v.to_array());
        part(14, bytemuck::cast_slice(&axes));
        let (tag, extent) = match camera.projection {
            Projection::Perspective { vertical_fov } => (15, vertical_fov),
            Projection::Orthographic { half_height } => (16, half_height),
        };
        part(tag, &extent.to_le_bytes());
    }
    hash
}

#[cfg(test)]
mod tests {
    use raystep_scenes::generate::cornell_box;

    use super::*;

    #[test]
    fn every_part_of_a_scene_counts_and_its_name_does_not() {
        let scene = cornell_box();
        let of = |change: fn(&mut Scene)| {
            let mut changed = scene.clone();
            change(&mut changed);
            scene_hash(&changed)
        };
        assert_eq!(of(|scene| scene.name = "another".into()), scene_hash(&scene));
        let changed = [
            of(|_| {}),
            of(|scene| scene.triangles[3][1][2] += 1e-3),
            of(|scene| scene.materials[0].base_color[1] *= 0.5),
            of(|scene| scene.lights.clear()),
            of(|scene| scene.cameras[0].eye.x += 1.0),
            of(|scene| scene.triangle_materials.swap(0, 25)),
            of(|scene| scene.normals = Some(vec![[[0.0; 3]; 3]; 26])),
        ];
        for (i, a) in changed.iter().enumerate() {
            assert!(changed[..i].iter().all(|b| a != b), "change {i} is not seen");
        }
    }
}
