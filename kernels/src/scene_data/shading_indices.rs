//! The condition under which a kernel shades hits and picks emitters without bounds checks, as [`super::indices`] for the
//! walk.

use super::SceneData;
use super::indices::is_counted_in_u32;
use crate::options::features::Features;
use crate::shared::emitters::PUNCTUAL;

impl SceneData {
    /// Whether every index of a triangle, a material, a light or an emitter that a kernel compiled with `features` follows
    /// from a hit is in bounds: there are as many corners, normals and colours as triangles; each has a material, of which
    /// there is one at least; and each row of the emitters is a light or a triangle, and stands for a row. Nothing is proven
    /// of textures.
    #[must_use]
    pub fn shading_indices_hold(&self, features: &Features) -> bool {
        let triangles = self.info.triangles as usize;
        let has = |values: &[f32], each: usize| {
            is_counted_in_u32(triangles, each) && is_counted_in_u32(values.len(), 1) && values.len() >= each * triangles
        };
        let materials =
            if features.specular { self.materials.len().min(self.optics.len()) } else { self.materials.len() };
        let materials_hold = match features.many_materials {
            true => {
                let of = &self.triangle_materials;
                of.len() >= triangles && of.iter().all(|&material| (material as usize) < materials)
            }
            false => materials > 0,
        };
        let rows = self.emitters.len();
        let emitters_hold = || {
            rows > 0
                && self.emission.count as usize == rows
                && self.emitters.iter().all(|row| {
                    let is_there = match row.id & PUNCTUAL {
                        0 => row.id < self.info.triangles,
                        _ => ((row.id ^ PUNCTUAL) as usize) < self.lights.len(),
                    };
                    is_there && (row.other as usize) < rows
                })
        };
        !features.textures
            && has(&self.vertices, 9)
            && (!features.normals || has(&self.normals, 9))
            && (!features.vertex_colors || has(&self.vertex_colors, 9))
            && materials_hold
            && (!features.shadows || emitters_hold())
    }
}

#[cfg(test)]
mod tests {
    use raystep_scenes::{Camera, Optics, generate};

    use super::*;
    use crate::options::{Integrator, Options, RaySource, ScheduleKind};
    use crate::plan::{Limits, Plan};

    fn of_paths(change: impl FnOnce(&mut SceneData)) -> bool {
        let mut scene = generate::cornell_box();
        scene.materials[0].emissive = [1.0; 3];
        scene.materials[1].optics = Optics::Mirror;
        let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 8, height: 8 };
        let options = Options { integrator: Integrator::Path, schedule: ScheduleKind::Fused, ..Options::new(rays) };
        let (plan, mut data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
        assert!(plan.features.whole_paths && plan.features.many_materials && data.emitters.len() > 1);
        change(&mut data);
        data.shading_indices_hold(&plan.features)
    }

    #[test]
    fn a_wrong_index_is_seen() {
        assert!(of_paths(|_| {}));
        assert!(!of_paths(|data| _ = data.vertices.pop()));
        assert!(!of_paths(|data| _ = data.triangle_materials.pop()));
        assert!(!of_paths(|data| data.triangle_materials[3] = data.materials.len() as u32));
        assert!(!of_paths(|data| _ = data.optics.pop()));
        assert!(!of_paths(|data| data.emission.count += 1));
        assert!(!of_paths(|data| data.emitters[1].other = data.emitters.len() as u32));
        assert!(!of_paths(|data| data.emitters[0].id = data.info.triangles));
        assert!(!of_paths(|data| data.emitters[0].id = PUNCTUAL | data.lights.len() as u32));
        assert!(!of_paths(|data| data.emitters.clear()));
    }
}
