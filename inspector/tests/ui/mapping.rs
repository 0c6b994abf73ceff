//! Kernels as fragment programs: their streams are drawn where they are, and their draws are timed.

use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::options::mapping::{Cull, Fragment, Mapping, Update};
use raystep_kernels::programs::closest_hit::streams::{COUNTERS, HIT, STATE, TMAX};
use raystep_kernels::{Choices, Numerics, ScheduleKind};

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

const PLACE: usize = 17;

fn stage(mapping: Mapping) -> Stage {
    let settings = Settings {
        size: [40, 30],
        device: DeviceKind::Gpu,
        choices: Choices { schedule: ScheduleKind::Second, numerics: Numerics::Paper, mapping, ..Choices::stepped() },
        ..Settings::default()
    };
    Stage::with_scene(CORNELL, settings, Arrival { place: Some(PLACE), ..Arrival::default() })
}

/// The picture of a layer as it is shown.
fn picture(stage: &mut Stage, stream: raystep_kernels::Stream, layer: &str) -> Vec<u8> {
    stage.show_stream(stream, layer);
    stage.settle();
    stage.perform(Command::ExportView);
    stage.settle();
    stage.desk.lock().expect("not poisoned").saved.pop().expect("a picture").bytes
}

/// Pictures of layers of every kind, here and after going back.
fn pictures(stage: &mut Stage) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for place in 0..3 {
        for (stream, layer) in [(STATE, "tag"), (STATE, "t"), (TMAX, "y"), (HIT, "triangle"), (COUNTERS, "triangles")] {
            all.push(picture(stage, stream, layer));
        }
        assert_eq!(stage.place(), PLACE - place);
        stage.perform(Command::PreviousPass);
    }
    all
}

#[test]
fn streams_that_are_drawn_into_look_like_those_of_compute_shaders() {
    let wanted = pictures(&mut stage(Mapping::Compute));
    assert!(wanted.windows(2).all(|two| two[0] != two[1]), "every picture shows something else");
    for update in [Update::Copy, Update::Swap] {
        let how = Fragment::of(None, Some(update), None, None);
        let mut stage = stage(Mapping::Fragment(how));
        let format = stage.inspector().model().texture(STATE).expect("a texture").format();
        assert_eq!(format, wgpu::TextureFormat::Rgba32Uint, "not a copy");
        for (index, (found, wanted)) in pictures(&mut stage).iter().zip(&wanted).enumerate() {
            assert!(found == wanted, "{update}: picture {index} differs");
        }
    }
}

#[test]
fn every_copy_and_draw_is_timed() {
    let mut stage = stage(Mapping::Fragment(Fragment { cull: Cull::EarlyZ, ..Fragment::default() }));
    stage.perform(Command::End);
    stage.perform(Command::Show(PaneKind::Timings));
    stage.perform(Command::Maximise);
    stage.settle();
    for part in ["copy counters state", "draw depths", "draw tmax", "draw color"] {
        assert!(stage.paints(part), "{part:?} is not among {:?}", stage.painted());
    }
    stage.perform(Command::ExportTrace);
    let desk = stage.desk.lock().expect("not poisoned");
    let json: serde_json::Value = serde_json::from_slice(&desk.saved[0].bytes).expect("JSON");
    let events = json["traceEvents"].as_array().expect("events");
    let of = |cat: &str| events.iter().filter(|event| event["cat"] == cat).count();
    assert!(of("draw") > 3 * of("pass") && of("pass") > PLACE, "{} draws, {} passes", of("draw"), of("pass"));
}
