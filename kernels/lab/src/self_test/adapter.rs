//! The adapter: its limits, how it handles long loops, its clock, and that it stays.

use std::ops::ControlFlow;

use raystep_kernels::plan::Bytes;
use raystep_kernels::{Accelerator, Device, Limits, Loops, Options, RaySource, RenderError, Renderer, ScheduleKind};
use raystep_scenes::{Camera, generate};

use super::{Bench, Check, Finding, Found, Group, Step, Verdict};
use crate::Error;
use crate::configuration::{Configuration, STEPPED};
use crate::judge::{Traced, check_rays};
use crate::machine::now_ns;
use crate::rays;
use crate::stability::probe::Bits;
use crate::text::counted;

pub(super) const LIMITS: &str = "limits";
pub(super) const STAYS: &str = "device";
const LOOPS: &str = "loops";
const LONG_LOOPS: &str = "long loops";
const CLOCK: &str = "clock";
const TIMESTAMPS: &str = "timestamps";

pub(super) fn checks() -> Vec<Check> {
    let check = |name, shows| Check { group: Group::Adapter, name, shows };
    vec![
        check(LIMITS, "the adapter has the limits and features that raystep needs, and gives a device"),
        check(LOOPS, "after how many iterations the driver ends a loop without an error"),
        check(LONG_LOOPS, "walks with more iterations than that are divided, and lose no hit"),
        check(CLOCK, "its timestamps agree with the host's clock about the same work"),
        check(TIMESTAMPS, "no pass ends before it begins, or begins before an earlier one"),
        check(STAYS, "the device is not lost and reports no error, in the whole self-test"),
    ]
}

pub(super) fn steps() -> Vec<Step> {
    let step =
        |name, checks: &[&'static str], run: fn(&mut Bench) -> Found| Step::new(Group::Adapter, name, checks, run);
    vec![
        step("limits and loops", &[LIMITS, LOOPS, STAYS], limits),
        step("long loops", &[LONG_LOOPS], long_loops),
        step("clock", &[CLOCK, TIMESTAMPS], clock),
    ]
}

fn found(check: &str, verdict: Verdict, says: impl Into<String>) -> Finding {
    Finding::new(Group::Adapter, check, verdict, says)
}

fn limits(bench: &mut Bench) -> Found {
    let (gpu, planned) = (&bench.gpu, Limits::from(&*bench.gpu));
    bench.machine.wait(gpu.finish())?;
    let limits = gpu.device.limits();
    let says = format!(
        "images of up to {0} x {0} pixels, buffers of {1}, {2} storage buffers and {3} storage textures a stage",
        planned.image_side,
        Bytes(planned.storage_bytes),
        limits.max_storage_buffers_per_shader_stage,
        limits.max_storage_textures_per_shader_stage,
    );
    let loops = match gpu.loops {
        _ if !gpu.computes => "not tested: it has no compute shaders".to_owned(),
        Loops::Unlimited => "no loop was ended".to_owned(),
        Loops::EndAfter(turns) => {
            format!("the driver ends loops after {turns} iterations; raystep divides longer walks")
        }
    };
    let all = vec![
        found(LIMITS, Verdict::Right, says),
        found(LOOPS, Verdict::Information, loops),
        found(STAYS, Verdict::Right, "no loss and no error was reported"),
    ];
    Ok((all, Vec::new()))
}

/// An icosphere divided six times has 81,920 triangles: a ray that tests all of them takes more iterations than Mesa's
/// software Vulkan allows, 65,535.
const SUBDIVISIONS: u64 = 6;

/// A workgroup.
const RAYS: usize = 64;

/// Every ray tests every triangle, in several passes if loops end early. The hits are those of a BVH, whose walks are
/// short, and right by f64 brute force.
fn long_loops(bench: &mut Bench) -> Found {
    let scene = generate::icosphere(SUBDIVISIONS)?;
    let rays = rays::random(&scene.bounds(), RAYS, 1);
    let base = Options { shade: false, ..Options::new(RaySource::Given(rays)) };
    let run = |accelerator| {
        let options = Configuration::new(accelerator, ScheduleKind::Fused, 1).of(&base);
        bench.machine.wait(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Gpu(bench.gpu.clone())).await?;
            renderer.run(|_| ControlFlow::Continue(())).await?;
            let (bits, passes) = (Bits::of(&renderer).await?, renderer.pass_count());
            let report = check_rays(&Traced::read(&renderer).await?, |_, _| ControlFlow::Continue(()));
            Ok::<_, RenderError>((bits, passes, report))
        })
    };
    let ((long, passes, report), (short, ..)) = (run(Accelerator::None)?, run(Accelerator::Bvh)?);
    let differing = long.rays.iter().zip(&short.rays).filter(|(a, b)| a != b).count();
    let mut wrong = Vec::new();
    if report.errors() > 0 {
        wrong.push(format!("{} triangles a ray: {report}", scene.triangles.len()));
    }
    if differing > 0 {
        wrong.push(format!("{differing} of {} hits are not those of short walks through a BVH", long.rays.len()));
    }
    let says = format!("{} tests a ray in {}", scene.triangles.len(), counted(passes, "pass"));
    Ok((vec![found(LONG_LOOPS, Verdict::Right, says).wrong_by(wrong)], Vec::new()))
}

fn clock(bench: &mut Bench) -> Found {
    bench.machine.wait(bench.gpu.check_clock(now_ns))?;
    let clock = match (bench.gpu.why_no_times(), bench.gpu.clock_check()) {
        (None, Some(check)) => found(CLOCK, Verdict::Right, format!("{check}")),
        (why, _) => {
            let why = why.unwrap_or_else(|| "it has no clock".into());
            found(CLOCK, Verdict::Information, format!("{why}; passes are not timed"))
        }
    };
    Ok((vec![clock, timestamps(bench)?], Vec::new()))
}

fn timestamps(bench: &Bench) -> Result<Finding, Error> {
    if bench.gpu.clock_period_ns().is_none() {
        return Ok(found(TIMESTAMPS, Verdict::NotApplicable, "passes are not timed"));
    }
    let scene = generate::cornell_box();
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
    let rays = RaySource::Camera { camera, width: 64, height: 64 };
    let options = Options { timings: true, ..STEPPED.of(&Options::new(rays)) };
    let passes = bench.machine.wait(async {
        let mut renderer = Renderer::new(&scene, &options, &Device::Gpu(bench.gpu.clone())).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        Ok::<_, RenderError>(renderer.passes().to_vec())
    })?;
    let begins: Vec<u64> = passes.iter().filter_map(|pass| pass.begin_ns).collect();
    let untimed =
        passes.iter().filter(|pass| pass.begin_ns.is_none() || pass.rounding.is_none() && pass.duration_ns.is_none());
    let (untimed, back) = (untimed.count(), begins.windows(2).filter(|pair| pair[1] < pair[0]).count());
    let mut wrong = Vec::new();
    if back > 0 {
        wrong.push(format!("{back} of {} passes begin before the pass before them", passes.len()));
    }
    // A driver may fail to time one in a while: such a pass has no time, and says so.
    if untimed * 10 > passes.len() {
        wrong.push(format!("{untimed} of {} passes have no valid time", passes.len()));
    }
    let says = format!("{} passes in order, {untimed} without a time", passes.len());
    Ok(found(TIMESTAMPS, Verdict::Right, says).wrong_by(wrong))
}
