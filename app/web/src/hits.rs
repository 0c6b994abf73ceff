//! Hits of whole pictures, for a test that compares WebGPU and WebGL 2 with the CPU reference kernels.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use futures_channel::oneshot;
use raystep_inspector::hits::hit_words;
use raystep_inspector::link::Link;
use raystep_kernels::{Device, Gpu};
use wasm_bindgen::prelude::*;
use web_sys::OffscreenCanvas;

use crate::files::Files;
use crate::{device, shell, tasks};

thread_local! {
    static GPU: RefCell<Option<Arc<Gpu>>> = const { RefCell::new(None) };
}

async fn gpu() -> Result<Arc<Gpu>, String> {
    if let Some(gpu) = GPU.with_borrow(Clone::clone) {
        return Ok(gpu);
    }
    let canvas = OffscreenCanvas::new(1, 1).map_err(|e| shell::reason(&e))?;
    let gpu = device::open(&canvas).await?.gpu;
    tasks::poll(&gpu);
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
    let (sender, found) = oneshot::channel();
    // What waits for a device is a task.
    tasks::spawn(async move {
        // Nobody waits for it any more.
        let _ = sender.send(traced(&link, on_gpu).await);
    });
    Ok(found.await.map_err(|e| e.to_string())??)
}

async fn traced(link: &str, on_gpu: bool) -> Result<Vec<u32>, String> {
    let link: Link = link.parse().map_err(|e: raystep_inspector::link::LinkError| e.to_string())?;
    let path = link.scene.clone().ok_or("the link has no scene")?;
    let load = Rc::new(Files::default()).loader(&path, link.scene_index);
    let scene = load(Box::new(|_, _| true)).await?;
    let device = if on_gpu { Device::Gpu(gpu().await?) } else { Device::Cpu(None) };
    hit_words(&link, &scene.scene, &device).await.map_err(|e| e.to_string())
}

/// The names of the adapters that WebGPU lists.
#[wasm_bindgen]
pub async fn adapters() -> Vec<String> {
    raystep_kernels::adapters().await.into_iter().map(|adapter| adapter.info.name).collect()
}
