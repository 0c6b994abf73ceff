//! Hits of whole pictures, for a test that compares WebGPU with the CPU reference kernels.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use raystep_inspector::link::Link;
use raystep_inspector::settings::Settings;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, Renderer};
use wasm_bindgen::prelude::*;

use crate::files::Files;
use crate::tasks;

thread_local! {
    static GPU: RefCell<Option<Arc<Gpu>>> = const { RefCell::new(None) };
}

async fn gpu() -> Result<Arc<Gpu>, String> {
    if let Some(gpu) = GPU.with_borrow(Clone::clone) {
        return Ok(gpu);
    }
    let gpu = Gpu::new(&AdapterChoice::Best).await.map_err(|e| e.to_string())?;
    GPU.set(Some(gpu.clone()));
    Ok(gpu)
}

/// Work that waits, for a page without a window.
#[wasm_bindgen]
pub fn work() {
    tasks::work();
}

/// The hits of the picture that a link describes, with its schedule: five words a ray, which are the triangle, the two
/// halves of t as f64, u and v; all bits set for a miss. Rejects with a sentence.
#[wasm_bindgen]
pub async fn hits(link: String, on_gpu: bool) -> Result<Vec<u32>, JsValue> {
    let link: Link = link.parse().map_err(|e: raystep_inspector::link::LinkError| e.to_string())?;
    let path = link.scene.clone().ok_or("the link has no scene")?;
    let load = Rc::new(Files::default()).loader(&path, link.scene_index);
    let scene = load(Box::new(|_, _| true)).await?;
    let settings = Settings::from(&link);
    let options = Options { schedule: link.schedule, timings: false, ..settings.options(&scene) };
    let device = if on_gpu { Device::Gpu(gpu().await?) } else { Device::Cpu(None) };
    let traced = async {
        let mut renderer = Renderer::new(&scene, &options, &device).await?;
        renderer.run(|_| std::ops::ControlFlow::Continue(())).await?;
        renderer.hits().await
    };
    let hits = traced.await.map_err(|e| e.to_string())?;
    let words = hits.iter().flat_map(|hit| match hit {
        None => [u32::MAX; 5],
        Some(hit) => {
            let t = hit.t.to_bits();
            [hit.triangle, (t >> 32) as u32, t as u32, hit.u.to_bits(), hit.v.to_bits()]
        }
    });
    Ok(words.collect())
}
