//! Checks that memory use stays constant: while stepping forwards and back in a session, and over the samples of a run
//! that keeps no records. The exit code is 1 if it grew by more than [`MOST_GROWTH`].
//!
//! `cargo run --release -p raystep-tests --example soak -- [cpu|gpu] [STEPS] [SAMPLES]`

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Instant;

use raystep_inspector::{Session, Target, go_on};
use raystep_kernels::plan::Bytes;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, Renderer, Samples};
use raystep_tests::{block_on, options, scene};

/// Permitted growth after the first tenth, in bytes: allows for an allocator's rounding and fragmentation, but is far
/// below one record of a pass (some 100 bytes) for each of 100,000 steps.
const MOST_GROWTH: u64 = 4 << 20;

/// Memory for checkpoints, in bytes: enough for some of them.
const MOST_KEPT: u64 = 256 << 10;

/// Number of reports per part.
const REPORTS: usize = 10;

/// Resident memory of this process, in bytes.
fn resident() -> Result<u64, String> {
    let status = std::fs::read_to_string("/proc/self/status").map_err(|e| format!("/proc/self/status: {e}"))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.map(|kib| kib * 1024).ok_or_else(|| "/proc/self/status: no VmRSS".into())
}

/// Memory after each tenth of the work.
struct Watched {
    what: &'static str,
    start: Instant,
    /// After the first tenth, when everything that is allocated once has been allocated.
    first: Option<u64>,
    most: u64,
}

impl Watched {
    fn new(what: &'static str) -> Self {
        Self { what, start: Instant::now(), first: None, most: 0 }
    }

    fn report(&mut self, done: usize, about: &str) -> Result<(), String> {
        let now = resident()?;
        self.first.get_or_insert(now);
        self.most = self.most.max(now);
        println!("  {done:>7} {}: {} resident{about}, {:.1?}", self.what, Bytes(now), self.start.elapsed());
        Ok(())
    }

    fn judge(&self) -> Result<(), String> {
        let growth = self.most - self.first.unwrap_or(self.most);
        println!("  grew by {} after the first tenth, {} are allowed", Bytes(growth), Bytes(MOST_GROWTH));
        if growth > MOST_GROWTH {
            return Err(format!("memory grows over {}: by {}", self.what, Bytes(growth)));
        }
        Ok(())
    }
}

/// Steps forwards to the end, back to the start, and so on.
async fn steps(device: &Device, steps: usize) -> Result<(), String> {
    let scene = scene("cornell-box.gltf");
    let options = Options { steps_per_pass: 1, ..options(&scene, 16, 16) };
    let mut session = Session::new(&scene, &options, device).await.map_err(|e| e.to_string())?;
    // A checkpoint every few passes, and room for only some of them: they are made and dropped all the time.
    session.set_span(1024);
    session.set_budget(MOST_KEPT);
    let (mut is_back, mut farthest) = (false, 0);
    let mut watched = Watched::new("steps");
    for step in 1..=steps {
        let before = session.place();
        let target = if is_back { Target::Previous } else { Target::Next };
        let place = session.step(target, &mut go_on).await.map_err(|e| e.to_string())?;
        farthest = farthest.max(place);
        // Turn around at either end.
        if place == before || place == 0 {
            is_back = !is_back;
        }
        if step % (steps / REPORTS).max(1) == 0 {
            watched.report(step, &format!(", {} passes, {} kept", farthest, Bytes(session.kept_bytes())))?;
        }
    }
    watched.judge()
}

/// One run of many samples that keeps no records of passes.
async fn samples(device: &Device, count: u32) -> Result<(), String> {
    let scene = scene("cornell-box.gltf");
    let samples = Samples { count, ..Samples::default() };
    let options = Options { samples, keep_passes: false, ..options(&scene, 8, 8) };
    let mut renderer = Renderer::new(&scene, &options, device).await.map_err(|e| e.to_string())?;
    let mut watched = Watched::new("samples");
    for report in 1..=REPORTS as u32 {
        let until = (u64::from(count) * u64::from(report) / REPORTS as u64) as u32;
        let ran = renderer.run_to_sample(until, |_| ControlFlow::Continue(())).await;
        ran.map_err(|e| e.to_string())?;
        watched.report(renderer.samples() as usize, &format!(", {} passes", renderer.pass_count()))?;
    }
    watched.judge()
}

fn soak() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| match arguments.get(i) {
        Some(text) => text.parse().map_err(|_| format!("{text:?}: a number is wanted")),
        None => Ok(default),
    };
    let device = match arguments.first().map_or("cpu", String::as_str) {
        "cpu" => Device::Cpu(None),
        "gpu" => Device::Gpu(block_on(None, Gpu::new(&AdapterChoice::Best)).map_err(|e| e.to_string())?),
        other => return Err(format!("{other:?}: cpu or gpu is wanted")),
    };
    let gpu = match &device {
        Device::Gpu(gpu) => Some(gpu.clone()),
        _ => None,
    };
    let (count, spp) = (number(1, 100_000)?, number(2, 65_536)?);
    println!("on {}", gpu.as_ref().map_or("the twins", |gpu| &gpu.info.name));
    let spp = u32::try_from(spp).map_err(|_| format!("{spp} samples are too many"))?;
    block_on(gpu.as_deref(), async {
        steps(&device, count).await?;
        samples(&device, spp).await
    })
}

fn main() -> ExitCode {
    match soak() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
