//! Materials that are drawn as diffuse surfaces, although they are not.

use raystep_kernels::Options;
use raystep_kernels::options::Integrator;
use raystep_scenes::{Optics, Scene};

/// Note for users if rays go on from hits, but not as the scene's rough metals and rough glass would have it.
#[must_use]
pub fn drawn_as_diffuse(scene: &Scene, options: &Options) -> Option<String> {
    if !options.shade || !matches!(options.integrator, Integrator::Whitted | Integrator::Path | Integrator::Photons) {
        return None;
    }
    let is_used = |i: usize| scene.triangle_materials.iter().any(|&material| material as usize == i);
    let is_rough = |&(i, material): &(usize, &raystep_scenes::Material)| material.optics == Optics::Rough && is_used(i);
    let mut rough = scene.materials.iter().enumerate().filter(is_rough).map(|(_, material)| material);
    let first = rough.next()?;
    let (name, others) = (&first.name, rough.count());
    Some(match others {
        0 => format!("material {name:?} is a rough metal or rough glass, and is drawn as a diffuse surface"),
        _ => format!(
            "{} materials, such as {name:?}, are rough metals or rough glass, and are drawn as diffuse surfaces",
            others + 1
        ),
    })
}
