//! A student's schedule in one view: it has the results of ours, and not after more passes.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::export::program::program;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::own;
use raystep_kernels::{Device, Options, RenderError, Renderer, ScheduleKind};
use raystep_scenes::Scene;

use super::check::{CheckError, Found};
use super::{Task, Verdict, View};

/// More passes than ours that a schedule may take: one that begins with the other kernel, and ends with it.
const MORE: usize = 2;

/// What a run has left.
struct Ran {
    passes: usize,
    /// Tag and triangle of every ray.
    rays: Vec<[u32; 2]>,
    states: raystep_kernels::tables::state::States,
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
    let ours = ran(&scene, &second, device).await?;

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
    let theirs = match ran(&scene, &options, device).await {
        Ok(theirs) => theirs,
        Err(error @ (RenderError::Plan(_) | RenderError::Endless { .. })) => return told(error.to_string(), 0, 0),
        Err(error) => return Err(error.into()),
    };
    let differs = ours.rays.iter().zip(&theirs.rays).position(|(ours, theirs)| ours != theirs);
    if let Some(ray) = differs {
        let (x, y) = (ray as u32 % view.size.width, ray as u32 / view.size.width);
        let [[tag, triangle], [right, other]] = [theirs.rays[ray], ours.rays[ray]];
        let message = if tag == right {
            format!("at the end, the ray of pixel {x},{y} has hit triangle {triangle}, and should have hit {other}")
        } else {
            let [tag, right] = [theirs.states.name(tag), ours.states.name(right)];
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

async fn ran(scene: &Scene, options: &Options, device: &Device) -> Result<Ran, RenderError> {
    let mut renderer = Renderer::new(scene, options, device).await?;
    renderer.run(|_| ControlFlow::Continue(())).await?;
    let program = renderer.plan().program;
    let stream = |name: &'static str| program.stream(name).ok_or(RenderError::NoStream(name));
    let values = [stream("state")?, stream("hit")?];
    let tags = renderer.values(values[0]).await?;
    let hits = renderer.values(values[1]).await?;
    let triangle = values[1].info().layers.iter().position(|layer| *layer == "triangle").unwrap_or(0);
    let rays = tags.layer(0).iter().zip(hits.layer(triangle)).map(|(tag, triangle)| [*tag, *triangle]).collect();
    Ok(Ran { passes: renderer.pass_count(), rays, states: program.states })
}
