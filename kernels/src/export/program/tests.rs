use std::sync::Arc;

use raystep_scenes::Scene;

use super::*;
use crate::options::folder::Folder;
use crate::options::samples::Samples;
use crate::options::{Accelerator, Integrator, ProgramName, ScheduleKind};
use crate::plan::Limits;
use crate::programs::light::tests::{options, room};
use crate::renderer::{Device, RenderError, Renderer};
use crate::scene_data::SceneData;
use crate::tables::stream::StreamData;

/// The program of a run, read from the folder that is written of it.
fn folder_of(scene: &Scene, options: &Options) -> (Plan, SceneData, Arc<Folder>) {
    let (plan, data) = Plan::new(scene, options, &Limits::CPU).expect("a plan");
    let files = program(&plan, &data, options, Some("room")).expect("files");
    let folder = Folder::new("exported".into(), String::new(), files).expect("a folder");
    (plan, data, Arc::new(folder))
}

/// The streams that are there after each pass, of as many passes as that.
fn passes(plan: Plan, data: SceneData, options: &Options, most: usize) -> Vec<(String, u32, Vec<StreamData>)> {
    let ran = pollster::block_on(async {
        let mut renderer = Renderer::from_plan(plan, data, options, &Device::Cpu(None)).await?;
        let mut all = Vec::new();
        while let Some(pass) = renderer.step().await? {
            let (kernel, parameter) = (pass.kernel.name().to_owned(), pass.parameter);
            let mut streams = Vec::new();
            let planned: Vec<Stream> = renderer.plan().streams.iter().map(|planned| planned.what).collect();
            for stream in planned {
                if renderer.size(stream.info().elements).is_some() {
                    streams.push(renderer.values(stream).await?);
                }
            }
            all.push((kernel, parameter, streams));
            if all.len() >= most {
                break;
            }
        }
        Ok::<_, RenderError>(all)
    });
    ran.expect("a run")
}

/// The elements of a stream, if they are known before the run.
fn size_of(sets: &[crate::plan::PlannedSet], stream: Stream) -> usize {
    let set = sets.iter().find(|set| set.what.name == stream.info().elements.name);
    set.and_then(|set| set.size).map_or(usize::MAX, |size| size.count as usize)
}

/// The same passes of both, with the same bits in every stream after each of them.
fn is_the_same(scene: &Scene, options: &Options, most: usize) {
    let (plan, data, folder) = folder_of(scene, options);
    let text = String::from_utf8_lossy(folder.file(Folder::MANIFEST).unwrap_or_default()).into_owned();
    let rays = options.rays.clone();
    let own = Options { folder: Some(folder), ..Options::new(rays) };
    let (own_plan, own_data) = Plan::new(scene, &own, &Limits::CPU).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let allocated = |plan: &Plan| {
        let streams = plan.streams.iter().map(|stream| (stream.what.name(), stream.bytes));
        let buffers = plan.buffers.iter().filter(|buffer| plan.program.buffer(buffer.what).is_some());
        let mut all: Vec<_> = streams.chain(buffers.map(|buffer| (buffer.what, buffer.bytes))).collect();
        all.sort_unstable();
        all
    };
    assert_eq!(allocated(&plan), allocated(&own_plan), "{text}");
    let name = format!("{} {:?}", plan.program.name, options.choices());
    let plan_sets = plan.sets.clone();
    let (ours, theirs) = (passes(plan, data, options, most), passes(own_plan, own_data, &own, most));
    for (index, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
        assert_eq!((&ours.0, ours.1), (&theirs.0, theirs.1), "pass {index} of {name}");
        for stream in &ours.2 {
            let other = theirs.2.iter().find(|other| other.stream.name() == stream.stream.name());
            let other = other.unwrap_or_else(|| panic!("pass {index} of {name} has no {}", stream.stream.name()));
            // Texels behind the last element have no value.
            let count = size_of(&plan_sets, stream.stream);
            let of = |data: &StreamData| -> Vec<u32> {
                (0..data.stream.layers())
                    .flat_map(|layer| data.layer(layer)[..count.min(data.layer(layer).len())].to_vec())
                    .collect()
            };
            assert!(of(stream) == of(other), "{} after pass {index} ({}) of {name}", stream.stream.name(), ours.0);
        }
    }
    assert_eq!(ours.len(), theirs.len(), "{name}");
    assert!(ours.len() > 1, "{name}");
}

#[test]
fn tracers_are_the_same_from_their_folder() {
    let scene = room();
    let usual = |accelerator, schedule, integrator| Options {
        accelerator,
        schedule,
        integrator,
        steps_per_pass: 1,
        ..options(&scene, 9, 7)
    };
    for (accelerator, schedule) in [
        (Accelerator::Grid, ScheduleKind::Second),
        (Accelerator::Grid, ScheduleKind::First),
        (Accelerator::Bvh, ScheduleKind::Second),
        (Accelerator::None, ScheduleKind::Second),
        (Accelerator::Irregular, ScheduleKind::Second),
        (Accelerator::Grid, ScheduleKind::Fused),
    ] {
        is_the_same(&scene, &usual(accelerator, schedule, Integrator::Local), 1000);
    }
    for integrator in [Integrator::Shadows, Integrator::Whitted, Integrator::Path] {
        is_the_same(&scene, &usual(Accelerator::Grid, ScheduleKind::Second, integrator), 120);
    }
    let samples = Samples { count: 2, ..Samples::default() };
    let local = usual(Accelerator::Grid, ScheduleKind::Second, Integrator::Local);
    is_the_same(&scene, &Options { samples, ..local }, 1000);
}

#[test]
fn a_sort_and_a_build_are_the_same_from_their_folder() {
    let scene = room();
    let sort = Options { program: ProgramName::Sort, elements: 300, ..options(&scene, 4, 4) };
    is_the_same(&scene, &sort, 1000);
    let build = Options { program: ProgramName::GridBuild, accelerator: Accelerator::Grid, ..options(&scene, 4, 4) };
    is_the_same(&scene, &build, 1000);
}

#[test]
fn what_a_folder_cannot_say_is_refused() {
    let scene = room();
    let given = Options { rays: RaySource::Given(Vec::new()), ..options(&scene, 4, 4) };
    let (plan, data) = Plan::new(&scene, &options(&scene, 4, 4), &Limits::CPU).expect("a plan");
    let error = program(&plan, &data, &given, None).expect_err("refused");
    assert_eq!(error.to_string(), "a run of rays that a file has cannot be a folder");
    let build =
        Options { program: ProgramName::GridBuild, accelerator: Accelerator::Irregular, ..options(&scene, 4, 4) };
    let (plan, data) = Plan::new(&scene, &build, &Limits::CPU).expect("a plan");
    let error = program(&plan, &data, &build, None).expect_err("refused");
    assert!(error.to_string().starts_with("the build of an irregular grid"), "{error}");
}
