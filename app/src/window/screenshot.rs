//! Draws the inspector into an image by egui's own renderer, without a display.

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, mutex::RwLock};
use eframe::egui_wgpu::{Renderer, RendererOptions};
use raystep_inspector::command::Command;
use raystep_inspector::draw::picture::{FORMAT, picture};
use raystep_inspector::ui::latency::Script;
use raystep_inspector::ui::{CheckedStep, Inspector, background, offscreen};
use raystep_kernels::Gpu;
use raystep_lab::block_on;
use raystep_lab::machine::now_ns;

use super::driven::wait_until_drawn;
use super::{Start, inspector};
use crate::error::Error;
use crate::terminal::say;

/// How long to wait for work before the screenshot is taken anyway.
const PATIENCE: Duration = Duration::from_secs(300);

/// Sets up every step of the lesson that `start` begins, and checks that what it speaks of is on the screen, also once
/// its question is answered. `tell` gets each step, and the time that a reader waits for it.
pub(crate) fn check_lesson(
    gpu: &Arc<Gpu>,
    start: Start,
    mut tell: impl FnMut(&CheckedStep, Duration) -> Result<(), Error>,
) -> Result<(), Error> {
    let (mut stage, _) = Stage::new(gpu, start, 1.0)?;
    let (_, steps) = stage.inspector.lesson_step().unwrap_or_default();
    for step in 0..steps {
        if step > 0 {
            // As the reader does, from the step before.
            stage.inspector.perform(Command::NextStep);
        }
        let begin = Instant::now();
        stage.settle()?;
        let waited = begin.elapsed();
        if let Some(mut checked) = stage.check_step() {
            while stage.inspector.go_on_with_step() {
                stage.settle()?;
                stage.check_step().into_iter().for_each(|more| checked.add(more));
            }
            tell(&checked, waited)?;
        }
    }
    Ok(())
}

/// Draws the interface once all work is done. `commands` are performed first, one after the other.
pub(crate) fn screenshot(
    gpu: &Arc<Gpu>,
    start: Start,
    scale: f32,
    commands: &[Command],
) -> Result<image::RgbaImage, Error> {
    let is_asked = start.scene.is_some() || start.session.is_some() || start.lesson.is_some();
    let (mut stage, [width, height]) = Stage::new(gpu, start, scale)?;
    stage.settle()?;
    if is_asked {
        stage.expect_scene()?;
    }
    for &command in commands {
        stage.inspector.perform(command);
        stage.settle()?;
    }
    let jobs = stage.frame(Vec::new());
    let drawing = offscreen::draw(gpu, &stage.renderer, &jobs, background(&stage.ctx), [width, height], scale);
    Ok(block_on(Some(gpu), drawing)?)
}

/// Measures how long the window would take to respond, where there is no display to open it on: a table.
pub(crate) fn latency(gpu: &Arc<Gpu>, start: Start) -> Result<String, Error> {
    let mut script = Script::new(start.measured_from.unwrap_or_default());
    let (mut stage, size) = Stage::new(gpu, start, 1.0)?;
    let (begin, target) = (Instant::now(), picture(&gpu.device, size));
    while let Some(events) = script.frame(now_ns(), &mut stage.inspector) {
        gpu.health()?;
        if let Some(progress) = script.progress(now_ns()) {
            say(progress);
        }
        stage.time = begin.elapsed().as_secs_f64();
        let jobs = stage.frame(events);
        let background = background(&stage.ctx);
        offscreen::submit(gpu, &mut stage.renderer.write(), &jobs, background, &target, 1.0);
        wait_until_drawn(gpu);
        if !stage.inspector.is_busy() {
            stage.expect_scene()?;
        }
        let (shown, goes_on) = (Instant::now(), script.after(&stage.inspector));
        while !goes_on && !stage.ctx.has_requested_repaint() && shown.elapsed() < Duration::from_secs(1) {
            std::thread::sleep(Duration::from_micros(200));
        }
    }
    Ok(script.table(&format!("{} without a window", gpu.info.name)))
}

struct Stage {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    renderer: Arc<RwLock<Renderer>>,
    inspector: Inspector,
    points: [f32; 2],
    time: f64,
    scale: f32,
    /// What the last frame drew.
    shapes: Vec<egui::epaint::ClippedShape>,
}

impl Stage {
    /// A window without a display, and its size in pixels.
    fn new(gpu: &Arc<Gpu>, start: Start, scale: f32) -> Result<(Self, [u32; 2]), Error> {
        let size = start.size.map(|side| (side * scale).round().max(1.0) as u32);
        let most = gpu.device.limits().max_texture_dimension_2d;
        if size.iter().any(|&side| side > most) {
            return Err(Error::failed(format!("--window: the adapter supports at most {most} pixels per side")));
        }
        let ctx = egui::Context::default();
        ctx.set_pixels_per_point(scale);
        let renderer = Arc::new(RwLock::new(Renderer::new(&gpu.device, FORMAT, RendererOptions::PREDICTABLE)));
        let points = start.size;
        let inspector = inspector(&ctx, gpu, renderer.clone(), start);
        let (gpu, shapes) = (gpu.clone(), Vec::new());
        Ok((Self { ctx, gpu, renderer, inspector, points, time: 0.0, scale, shapes }, size))
    }

    fn expect_scene(&self) -> Result<(), Error> {
        match self.inspector.model().opened {
            Some(_) => Ok(()),
            None => Err(Error::failed(self.inspector.last_error().unwrap_or("the scene could not be opened"))),
        }
    }

    /// Runs frames until no work is left, and some more because layouts need several frames to settle.
    fn settle(&mut self) -> Result<(), Error> {
        let begin = Instant::now();
        let mut calm = 0;
        while calm < 6 {
            self.gpu.health()?;
            self.frame(Vec::new());
            calm = if self.inspector.is_busy() { 0 } else { calm + 1 };
            if calm == 0 {
                if begin.elapsed() > PATIENCE {
                    return Err(Error::failed(format!("the scene was not ready after {PATIENCE:?}")));
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        Ok(())
    }

    /// Checks what the lesson's step shows now.
    fn check_step(&mut self) -> Option<CheckedStep> {
        self.frame(Vec::new());
        self.inspector.check_step(&self.shapes, self.points.into())
    }

    fn frame(&mut self, events: Vec<egui::Event>) -> Vec<egui::ClippedPrimitive> {
        self.time += 1.0 / 60.0;
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, self.points.into());
        let input = egui::RawInput { screen_rect: Some(rect), time: Some(self.time), events, ..Default::default() };
        let mut output = self.ctx.run_ui(input, |ui| self.inspector.ui(ui));
        let mut renderer = self.renderer.write();
        for (id, delta) in output.textures_delta.set.iter().flat_map(|(id, all)| all.iter().map(move |d| (id, d))) {
            renderer.update_texture(&self.gpu.device, &self.gpu.queue, *id, delta);
        }
        self.shapes.clone_from(&output.shapes);
        let jobs = self.ctx.tessellate(output.shapes, self.scale);
        // This frame's shapes still use textures that are freed now.
        self.gpu.submit([]);
        for id in &output.textures_delta.free {
            renderer.free_texture(id);
        }
        output.textures_delta.clear();
        jobs
    }
}
