//! Hits of whole pictures, for a test that compares WebGPU with the CPU reference kernels.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use raystep_inspector::hits::hit_words;
use raystep_inspector::link::Link;
use raystep_kernels::{AdapterChoice, Device, Gpu};
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

/// The hits of the picture that a link describes: see `raystep_inspector::hits::hit_words`. Rejects with a sentence.
#[wasm_bindgen]
pub async fn hits(link: String, on_gpu: bool) -> Result<Vec<u32>, JsValue> {
    let link: Link = link.parse().map_err(|e: raystep_inspector::link::LinkError| e.to_string())?;
    let path = link.scene.clone().ok_or("the link has no scene")?;
    let load = Rc::new(Files::default()).loader(&path, link.scene_index);
    let scene = load(Box::new(|_, _| true)).await?;
    let device = if on_gpu { Device::Gpu(gpu().await?) } else { Device::Cpu(None) };
    Ok(hit_words(&link, &scene, &device).await.map_err(|e| e.to_string())?)
}
