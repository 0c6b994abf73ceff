//! The hits of the picture that a link describes, to compare devices with each other.

use std::ops::ControlFlow;

use raystep_kernels::{Device, Options, RenderError, Renderer};
use raystep_scenes::Scene;

use crate::link::Link;
use crate::settings::Settings;

/// Words per ray of [`hit_words`].
pub const HIT_WORDS: usize = 5;

/// Traces the picture that a link describes, with its schedule. Five words a ray: the triangle, the two halves of t as
/// f64, u and v; all bits set for a miss.
///
/// # Errors
/// If the scene cannot be traced so, or the device fails.
pub async fn hit_words(link: &Link, scene: &Scene, device: &Device) -> Result<Vec<u32>, RenderError> {
    let options = Options { schedule: link.choices.schedule, timings: false, ..Settings::from(link).options(scene) };
    let mut renderer = Renderer::new(scene, &options, device).await?;
    renderer.run(|_| ControlFlow::Continue(())).await?;
    let hits = renderer.hits().await?;
    let words = hits.iter().flat_map(|hit| match hit {
        None => [u32::MAX; HIT_WORDS],
        Some(hit) => {
            let t = hit.t.to_bits();
            [hit.triangle, (t >> 32) as u32, t as u32, hit.u.to_bits(), hit.v.to_bits()]
        }
    });
    Ok(words.collect())
}
