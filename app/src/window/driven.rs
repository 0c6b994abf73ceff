//! A window that drives itself, to measure how long it takes to respond.

use std::time::{Duration, Instant};

use eframe::egui;
use raystep_inspector::ui::Inspector;
use raystep_inspector::ui::latency::Script;
use raystep_kernels::Gpu;
use raystep_lab::machine::now_ns;

use crate::terminal::{print, say};

/// Time limit for drawing a frame.
const PATIENCE: Duration = Duration::from_secs(60);

/// The script of actions, until it has ended.
pub(super) struct Driven {
    script: Script,
    has_ended: bool,
}

impl Driven {
    /// The program began at this time.
    pub(super) fn new(begin_ns: u64) -> Self {
        Self { script: Script::new(begin_ns), has_ended: false }
    }

    /// Before a frame: adds the script's events, or prints its table and closes the window.
    pub(super) fn frame(
        &mut self,
        ctx: &egui::Context,
        input: &mut egui::RawInput,
        inspector: &mut Inspector,
        gpu: &Gpu,
    ) {
        if self.has_ended {
            return;
        }
        wait_until_drawn(gpu);
        if let Some(progress) = self.script.progress(now_ns()) {
            say(progress);
        }
        match self.script.frame(now_ns(), inspector) {
            Some(events) => input.events = events,
            None => {
                self.has_ended = true;
                // If standard output is closed, nobody wants the table.
                let _ = print(&self.script.table(&gpu.info.name));
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }

    /// After a frame.
    pub(super) fn after(&mut self, ctx: &egui::Context, inspector: &Inspector) {
        if self.script.after(inspector) {
            ctx.request_repaint();
        } else {
            // An action without a response is given up.
            ctx.request_repaint_after(Duration::from_secs(1));
        }
    }
}

/// Waits until the GPU has done all submitted work, the last frame included.
pub(super) fn wait_until_drawn(gpu: &Gpu) {
    let (done, drawn) = std::sync::mpsc::channel();
    gpu.queue.on_submitted_work_done(move || {
        // Nobody listens any more if the wait was given up.
        let _ = done.send(());
    });
    let start = Instant::now();
    while drawn.try_recv().is_err() && start.elapsed() < PATIENCE {
        // A lost device is reported by the frame.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        std::thread::sleep(Duration::from_micros(100));
    }
}
