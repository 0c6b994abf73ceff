//! Exports, handed to the host for saving.

use crate::exports::EXPORTING;

use raystep_kernels::export::Recorded;
use raystep_kernels::export::csv::{RunContext, Timer};
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::renderer::{CounterSums, Counting};
use raystep_kernels::{Choices, Progress, RenderError, Stream};
use raystep_lab::machine::{clock_step_ns, session_id};

use super::Inspector;
use crate::command::Command;
use crate::exports::{self, Export, ExportError};
use crate::session::request::{Job, JobContext, Request, answered, flow, job};
use crate::session::{OnProgress, Session, Target, go_on};
use crate::settings::DeviceKind;
use crate::ui::host::FileToSave;

impl From<Export> for FileToSave {
    fn from(export: Export) -> Self {
        Self { name: export.file_name(), bytes: export.bytes, holds: export.holds }
    }
}

impl Inspector {
    /// Performs an export command.
    pub(super) fn take(&mut self, command: Command) {
        let export = match command {
            Command::ExportPasses => return self.take_passes(Write::Csv),
            Command::ExportTrace => return self.take_passes(Write::Trace),
            Command::ExportRay => self.take_ray(),
            Command::ExportExr | Command::ExportNpy => {
                let Some(stream) = self.state.display.stream else { return };
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

    /// All passes, or those up to here if that was chosen.
    fn take_passes(&mut self, write: Write) {
        let is_up_to_here = std::mem::take(&mut self.state.asks.is_up_to_here);
        let Some(run) = self.context() else { return };
        let target = if is_up_to_here { Target::Pass(self.model.place) } else { Target::End };
        self.model.ask(Request::Job(EXPORTING, run_and_write(run, write, target)));
    }

    /// All rows of the selected ray, or those up to here if that was chosen. Says how many are predicted.
    fn take_ray(&mut self) -> Option<Result<Export, ExportError>> {
        let is_up_to_here = std::mem::take(&mut self.state.asks.is_up_to_here);
        let model = &self.model;
        let history = model.history.as_ref()?;
        let is_wanted = |row: &&TraceRow| !is_up_to_here || row.is_within(model.place);
        let rows: Vec<TraceRow> = history.rows.iter().filter(is_wanted).cloned().collect();
        let predicted = rows.iter().filter(|row| model.is_predicted(row)).count();
        let export = exports::ray_csv(&Trace { rows, ..Trace::clone(history) });
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
                None => Timer::Host { resolution_ns: clock_step_ns() },
            }),
            DeviceKind::Auto | DeviceKind::Cpu | DeviceKind::CpuF64 => {
                self.devices.clock.map(|_| Timer::CpuClock { resolution_ns: clock_step_ns() })
            }
        };
        Some(RunContext {
            run_id: format!("{}-{}", session_id(), self.model.generation),
            configuration: "0".into(),
            scene: opened.scene.name.clone(),
            choices: Choices { accelerator: plan.accelerator, ..settings.choices },
            adapter: if settings.device == DeviceKind::Gpu { opened.device.clone() } else { "cpu".into() },
            width_px: Some(plan.width),
            height_px: Some(plan.height),
            repeat: 0,
            is_warmup: false,
            timer,
            host_run_ns: None,
        })
    }

    /// Hands over the exports made by jobs and panels.
    pub(super) fn hand_over(&mut self) {
        if let Some(export) = self.model.take_answer::<Export>(EXPORTING) {
            self.state.asks.files.push((*export).into());
        }
        for file in std::mem::take(&mut self.state.asks.files) {
            self.host.save(file);
        }
    }
}

/// A file of passes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Write {
    Csv,
    Trace,
}

/// Runs to a place, writes all passes before it, and returns.
fn run_and_write(run: RunContext, write: Write, target: Target) -> Job {
    job!(context, {
        let JobContext { session, progress, .. } = context;
        let here = session.place();
        let mut tell = |at: &Progress| flow(progress(at.rays_decided, at.rays));
        let is_counted = write == Write::Csv && session.renderer().plan().counters().is_some();
        let counted = match is_counted {
            true => count(session, target, &mut tell).await,
            false => session.step(target, &mut tell).await.map(|_| Vec::new()),
        };
        let export = counted.map_err(|e| e.to_string()).and_then(|counted| {
            let run = RunContext { host_run_ns: session.renderer().host_ns(), ..run };
            let recorded = Recorded::of(&run, session.renderer(), &counted);
            let write = if write == Write::Csv { exports::passes_csv } else { exports::passes_trace };
            write(&recorded).map_err(|e| e.to_string())
        });
        // Returns even if it was stopped: an export must not move the user's view.
        session.step(Target::Pass(here), &mut go_on).await.map_err(|e| e.to_string())?;
        answered(export?)
    })
}

/// Runs from the start to a place, a pass at a time: what each of them adds to the counters.
async fn count(
    session: &mut Session,
    target: Target,
    progress: &mut OnProgress<'_>,
) -> Result<Vec<CounterSums>, RenderError> {
    let place = if let Target::Pass(place) = target { place } else { usize::MAX };
    let (mut counted, mut counting) = (Vec::new(), Counting::default());
    session.step(Target::Start, progress).await?;
    while session.place() < place {
        let before = session.place();
        session.step(Target::Next, progress).await?;
        let Some(pass) = session.passes().last().filter(|_| session.place() > before) else { break };
        counted.extend(counting.added(session.renderer(), pass).await?);
        // A step of one pass ends before it asks.
        if progress(&session.renderer().progress()).is_break() {
            return Err(RenderError::Cancelled { passes: session.place() });
        }
    }
    Ok(counted)
}

type WriteStream = fn(&raystep_kernels::StreamData, Option<usize>) -> Result<Export, ExportError>;

/// Reads the current stream, and writes it as a file.
fn read(stream: Stream, write: WriteStream) -> Job {
    job!(context, {
        let data = context.session.stream(stream).await.map_err(|e| e.to_string())?;
        let export = write(&data, context.session.place().checked_sub(1)).map_err(|e| e.to_string())?;
        answered(export)
    })
}
