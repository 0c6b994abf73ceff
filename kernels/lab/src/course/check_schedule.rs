//! A student's schedule in one view: it has the results of ours, and not after more passes.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::export::program::program;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::own;
use raystep_kernels::{Device, Options, Program, RenderError, Renderer, ScheduleKind};
use raystep_scenes::Scene;

use super::check::{CheckError, Found};
use super::{Task, Verdict, View};
use crate::text::counted;

/// More passes than ours that a schedule may take: one that begins with the other kernel, and ends with it.
const MORE: usize = 2;

/// What a run has left.
struct Ran {
    passes: usize,
    /// Whether it has come to its end.
    has_ended: bool,
    /// Tag and triangle of every ray.
    rays: Vec<[u32; 2]>,
    program: &'static Program,
}

/// Far more passes than any schedule needs that gets on, and few enough that nobody waits for those of one that does not end.
fn most_passes(ours: usize) -> usize {
    8 * ours + 64
}

/// Runs the kernels of ours in the student's order, and in that of the second schedule.
pub(super) async fn check_schedule(
    task: &Task,
    view: &View,
    by: &Arc<Replacement>,
    device: &Device,
) -> Result<Found, CheckError> {
    let (scene, second) = task.run(view)?;
    let second = Options { schedule: ScheduleKind::Second, ..second };
    let ours = ran(&scene, &second, device, usize::MAX).await?;

    let (plan, data) = Plan::on(&scene, &second, device).await?;
    let mut files = program(&plan, &data, &second, None)?;
    let manifest = files.get(Folder::MANIFEST).map(|text| String::from_utf8_lossy(text).into_owned());
    let manifest = manifest.unwrap_or_default();
    // The student's lines come first, so that a mistake is told with its place.
    let text = format!("{}\n{}", by.source, without_schedule(&manifest));
    files.insert(Folder::MANIFEST.to_owned(), text.into_bytes());
    let folder = Arc::new(Folder::new("schedule".into(), String::new(), files)?);
    let told =
        |message: String, line: usize, column: usize| Ok(Found::Wrong(Verdict::Mistake { message, line, column }));
    if let Err(mistake) = own::read(&folder) {
        return told(mistake.message.clone(), mistake.place.line, mistake.place.column);
    }
    let options = Options { folder: Some(folder), ..Options::new(second.rays) };
    let theirs = match ran(&scene, &options, device, most_passes(ours.passes)).await {
        Ok(theirs) => theirs,
        Err(error @ RenderError::Plan(_)) => return told(error.to_string(), 0, 0),
        Err(error) => return Err(error.into()),
    };
    if !theirs.has_ended {
        let message = endless(&ours, &theirs, view.size.width);
        return Ok(Found::Wrong(Verdict::Fails { message }));
    }
    let differs = ours.rays.iter().zip(&theirs.rays).position(|(ours, theirs)| ours != theirs);
    if let Some(ray) = differs {
        let (x, y) = (ray as u32 % view.size.width, ray as u32 / view.size.width);
        let [[tag, triangle], [right, other]] = [theirs.rays[ray], ours.rays[ray]];
        let message = if tag == right {
            format!("at the end, the ray of pixel {x},{y} has hit triangle {triangle}, and should have hit {other}")
        } else {
            let [tag, right] = [theirs.program.states.name(tag), ours.program.states.name(right)];
            format!("at the end, the ray of pixel {x},{y} is in state {tag}, and should be in {right}")
        };
        return Ok(Found::Wrong(Verdict::Fails { message }));
    }
    if theirs.passes > ours.passes + MORE {
        return Ok(Found::Wrong(Verdict::Slow { passes: theirs.passes, enough: ours.passes }));
    }
    Ok(Found::Right(ours.rays.len() as u64))
}

/// The tables of a manifest of ours but the schedule.
fn without_schedule(manifest: &str) -> String {
    let tables = manifest.split_inclusive("\n\n").filter(|table| !table.starts_with("[schedule]"));
    // What is before the first table cannot come after another one.
    tables.skip_while(|table| !table.starts_with('[')).collect()
}

/// What keeps a schedule from ending: the first ray that is not done, and all that wait as it does.
fn endless(ours: &Ran, theirs: &Ran, width: u32) -> String {
    let Ran { passes, rays, program, .. } = theirs;
    let is_waiting = |(ours, theirs): (&[u32; 2], &[u32; 2])| ours[0] != theirs[0];
    let Some(first) = ours.rays.iter().zip(rays).position(is_waiting) else {
        return format!("after {passes} passes, all rays are done, but its loops have not ended");
    };
    let tag = rays[first][0];
    let waiting = rays.iter().filter(|ray| ray[0] == tag).count();
    let verb = if waiting == 1 { "is" } else { "are" };
    let waiting = counted(waiting as u64, "ray");
    let kernel = program.kernels().find(|kernel| kernel.takes().contains(&tag));
    let waits_for = kernel.map(|kernel| format!(", where {} would take them on", kernel.name())).unwrap_or_default();
    let (state, x, y) = (program.states.name(tag), first as u32 % width, first as u32 / width);
    format!(
        "after {passes} passes, it has not ended: {waiting} {verb} still in state {state}{waits_for}; the first is that of \
         pixel {x},{y}"
    )
}

/// Runs at most so many passes.
async fn ran(scene: &Scene, options: &Options, device: &Device, most: usize) -> Result<Ran, RenderError> {
    let mut renderer = Renderer::new(scene, options, device).await?;
    renderer.run_to(most, |_| ControlFlow::Continue(())).await?;
    let program = renderer.plan().program;
    let stream = |name: &'static str| program.stream(name).ok_or(RenderError::NoStream(name));
    let values = [stream("state")?, stream("hit")?];
    let tags = renderer.values(values[0]).await?;
    let hits = renderer.values(values[1]).await?;
    let triangle = values[1].info().layers.iter().position(|layer| *layer == "triangle").unwrap_or(0);
    let rays = tags.layer(0).iter().zip(hits.layer(triangle)).map(|(tag, triangle)| [*tag, *triangle]).collect();
    let has_ended = renderer.next_kernel().is_none();
    Ok(Ran { passes: renderer.pass_count(), has_ended, rays, program })
}
