//! Exports, handed to the host for saving.

use std::any::Any;
use std::ops::ControlFlow;

use raystep_kernels::DrawTime;
use raystep_kernels::export::csv::{RunContext, Timer};
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::plan::Plan;
use raystep_kernels::{Pass, Progress, Stream};

use super::Inspector;
use super::canvas::Canvas;
use super::command::Command;
use super::host::FileToSave;
use crate::exports::{self, Export, ExportError};
use crate::session::request::{Job, JobContext, JobFuture, Request};
use crate::session::{Target, go_on};
use crate::settings::DeviceKind;

/// The name of jobs that answer with an [`Export`].
pub(in crate::ui) const EXPORTING: &str = "exporting";

impl From<Export> for FileToSave {
    fn from(export: Export) -> Self {
        Self { name: export.file_name(), bytes: export.bytes, holds: export.holds }
    }
}

impl Inspector {
    /// Performs an export command.
    pub(super) fn take(&mut self, command: Command) {
        let export = match command {
            Command::ExportPasses => self.take_passes(exports::passes_csv),
            Command::ExportTrace => self.take_passes(exports::passes_trace),
            Command::ExportRay => self.take_ray(),
            Command::ExportExr | Command::ExportNpy => {
                let Some(stream) = self.shared.stream else { return };
                let write = if command == Command::ExportExr { exports::stream_exr } else { exports::stream_npy };
                self.model.ask(Request::Job(EXPORTING, read(stream, write)));
                None
            }
            _ => None,
        };
        match export {
            Some(Ok(export)) => self.host.save(export.into()),
            Some(Err(error)) => self.fail(error.to_string()),
            None => {}
        }
    }

    /// All passes, or those up to here if that was chosen. If not all are known, they are run first.
    fn take_passes(&mut self, write: WritePasses) -> Option<Result<Export, ExportError>> {
        let is_up_to_here = std::mem::take(&mut self.shared.is_up_to_here);
        let run = self.context()?;
        let (model, plan) = (&self.model, &self.model.opened.as_ref()?.plan);
        let known = &model.passes;
        let up_to = if is_up_to_here { model.place.min(known.len()) } else { known.len() };
        // The parts of passes that are drawn are with the session.
        if plan.drawn.is_none() && (is_up_to_here || model.is_complete) {
            return Some(write(&run, plan, &known[..up_to], &[]));
        }
        let target = if is_up_to_here { Target::Pass(up_to) } else { Target::End };
        self.model.ask(Request::Job(EXPORTING, run_and_write(run, write, target)));
        None
    }

    /// All rows of the selected ray, or those up to here if that was chosen. Says how many are predicted.
    fn take_ray(&mut self) -> Option<Result<Export, ExportError>> {
        let is_up_to_here = std::mem::take(&mut self.shared.is_up_to_here);
        let model = &self.model;
        let life = model.life.as_ref()?;
        let is_wanted = |row: &&TraceRow| !is_up_to_here || row.is_within(model.place);
        let rows: Vec<TraceRow> = life.rows.iter().filter(is_wanted).cloned().collect();
        let predicted = rows.iter().filter(|row| model.is_predicted(row)).count();
        let export = exports::life_csv(&Trace { rows, ..Trace::clone(life) });
        Some(export.map(|export| match predicted {
            0 => export,
            _ => {
                let holds = format!("{} ({predicted} of them predicted)", export.holds);
                Export { holds, ..export }
            }
        }))
    }

    /// The columns that all rows of this run share.
    fn context(&self) -> Option<RunContext> {
        let opened = self.model.opened.as_ref()?;
        let (settings, plan) = (&opened.settings, &opened.plan);
        let timer = match settings.device {
            DeviceKind::Gpu => Some(match self.devices.gpu.clock_step_ns() {
                Some(resolution_ns) => Timer::GpuTimestamp { resolution_ns },
                None => Timer::Host { resolution_ns: None },
            }),
            DeviceKind::Auto | DeviceKind::Cpu | DeviceKind::CpuF64 => {
                self.devices.clock.map(|_| Timer::CpuClock { resolution_ns: None })
            }
        };
        Some(RunContext {
            run_id: format!("inspector-{}", self.model.generation),
            configuration: "0".into(),
            scene: opened.scene.name.clone(),
            accelerator: plan.accelerator.name(),
            schedule: settings.schedule.name(),
            numerics: settings.numerics.name(),
            mapping: settings.mapping.to_string(),
            traversal: settings.traversal.name(),
            adapter: if settings.device == DeviceKind::Gpu { opened.device.clone() } else { "cpu".into() },
            width_px: plan.width,
            height_px: plan.height,
            repeat: 0,
            is_warmup: false,
            timer,
            host_run_ns: self.model.host_ns,
        })
    }

    /// Hands over the exports made by jobs and panels.
    pub(super) fn hand_over(&mut self) {
        if let Some(export) = self.model.take_answer::<Export>(EXPORTING) {
            self.shared.files.push((*export).into());
        }
        for file in std::mem::take(&mut self.shared.files) {
            self.host.save(file);
        }
    }
}

type WritePasses = fn(&RunContext, &Plan, &[Pass], &[Vec<DrawTime>]) -> Result<Export, ExportError>;

/// Runs to a place, writes all passes before it, and returns.
fn run_and_write(run: RunContext, write: WritePasses, target: Target) -> Job {
    Box::new(move |context: JobContext<'_>| -> JobFuture<'_> {
        Box::pin(async move {
            let JobContext { session, progress, .. } = context;
            let here = session.place();
            let mut tell = |at: &Progress| {
                if progress(at.rays_decided, at.rays) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            let ran = session.step(target, &mut tell).await;
            let passes = session.passes()[..session.place().min(session.passes().len())].to_vec();
            let draws = session.renderer().draws().to_vec();
            // Returns even if it was stopped: an export must not move the user's view.
            session.step(Target::Pass(here), &mut go_on).await.map_err(|e| e.to_string())?;
            ran.map_err(|e| e.to_string())?;
            let export = write(&run, session.renderer().plan(), &passes, &draws).map_err(|e| e.to_string())?;
            Ok(Box::new(export) as Box<dyn Any + Send>)
        })
    })
}

type Write = fn(&raystep_kernels::StreamData, Option<usize>) -> Result<Export, ExportError>;

/// Reads the current stream, and writes it as a file.
fn read(stream: Stream, write: Write) -> Job {
    Box::new(move |context: JobContext<'_>| -> JobFuture<'_> {
        Box::pin(async move {
            let data = context.session.stream(stream).await.map_err(|e| e.to_string())?;
            let export = write(&data, context.session.place().checked_sub(1)).map_err(|e| e.to_string())?;
            Ok(Box::new(export) as Box<dyn Any + Send>)
        })
    })
}

/// Reads an image back, and writes it as PNG.
pub(in crate::ui) fn png(canvas: &Canvas, texture: &wgpu::Texture, name: String) -> Job {
    let (gpu, texture) = (canvas.gpu.clone(), texture.clone());
    Box::new(move |_: JobContext<'_>| -> JobFuture<'_> {
        Box::pin(async move {
            let texels = gpu.read_rgba8(&texture).await.map_err(|e| e.to_string())?;
            let image = image::RgbaImage::from_raw(texture.width(), texture.height(), texels);
            let image = image.ok_or("the image was returned in another size")?;
            let mut bytes = std::io::Cursor::new(Vec::new());
            image.write_to(&mut bytes, image::ImageFormat::Png).map_err(|e| e.to_string())?;
            let holds = format!("an image of {} x {} pixels", texture.width(), texture.height());
            let export = Export { name: name.replace(' ', "-"), extension: "png", bytes: bytes.into_inner(), holds };
            Ok(Box::new(export) as Box<dyn Any + Send>)
        })
    })
}
