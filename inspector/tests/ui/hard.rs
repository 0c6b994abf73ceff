//! Errors, and unusual sizes of windows and scenes: a clear message, and no panic.

use egui::{Key, Modifiers, Rect, Vec2};
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::saved::Saved;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;
use raystep_kernels::programs::closest_hit::streams::{RAY_DIRECTION, RAY_ORIGIN, STATE, TMAX};

use crate::ui::adapter::own_gpu;
use crate::ui::desk::{BROKEN, CORNELL, EMPTY, TRIANGLE};
use crate::ui::stage::{Plan, Stage};

fn small() -> Settings {
    Settings { size: [32, 32], ..Settings::default() }
}

/// Presses every key and shows every panel.
fn tour(stage: &mut Stage) {
    for &kind in PaneKind::ALL {
        stage.perform(Command::Show(kind));
    }
    stage.arrange(Layout::Step);
    for command in [Command::NextPass, Command::End, Command::PreviousPass, Command::Start, Command::Compare] {
        stage.perform(command);
    }
    for command in [Command::Divergence, Command::Normalise, Command::Pin, Command::Fit, Command::End] {
        stage.perform(command);
    }
    stage.arrange(Layout::Overview);
    stage.harness.render().expect("it can be drawn");
}

#[test]
fn a_window_of_200_by_150() {
    let mut stage = Stage::new(Plan { size: [200.0, 150.0], ..Plan::default() });
    stage.open(CORNELL, small(), Arrival::default());
    stage.snapshot("window-200x150");
    tour(&mut stage);
    for command in [Command::Palette, Command::Help, Command::EditTexel, Command::Lesson(0)] {
        stage.perform(command);
        stage.key(Modifiers::NONE, Key::Escape);
    }
    assert!(stage.place() > 0);
}

#[test]
fn a_picture_of_one_pixel() {
    let settings = Settings { size: [1, 1], ..Settings::default() };
    let mut stage = Stage::with_scene(CORNELL, settings, Arrival::default());
    assert_eq!(stage.inspector().pixel(), Some([0, 0]));
    tour(&mut stage);
    stage.key(Modifiers::NONE, Key::ArrowRight);
    stage.settle();
    assert_eq!(stage.inspector().pixel(), Some([0, 0]));
}

#[test]
fn a_scene_of_one_triangle() {
    let mut stage = Stage::with_scene(TRIANGLE, small(), Arrival::default());
    assert_eq!(stage.inspector().model().opened.as_ref().map(|o| o.plan.triangles), Some(1));
    tour(&mut stage);
    stage.perform(Command::End);
    assert_eq!(hits(&mut stage, "14,18"), Some(0));
    assert_eq!(hits(&mut stage, "0,0"), None);
}

/// The triangle hit by a pixel's ray.
fn hits(stage: &mut Stage, pixel: &str) -> Option<u32> {
    stage.perform(Command::GoToPixel);
    stage.answer(pixel);
    let history = stage.inspector().model().history.clone().expect("a history");
    history.rows.last().expect("a pass").after.triangle
}

#[test]
fn an_empty_scene() {
    let mut stage = Stage::with_scene(EMPTY, small(), Arrival::default());
    assert_eq!(stage.inspector().model().opened.as_ref().map(|o| o.plan.triangles), Some(0));
    tour(&mut stage);
    stage.perform(Command::End);
    assert_eq!(hits(&mut stage, "14,18"), None);
}

#[test]
fn a_broken_file_shows_its_error_and_keeps_the_scene() {
    let mut stage = Stage::with_scene(CORNELL, small(), Arrival { place: Some(9), ..Arrival::default() });
    let (title, generation) = (stage.inspector().title(), stage.inspector().model().generation);
    stage.perform(Command::Show(PaneKind::Log));
    stage.desk.lock().expect("not poisoned").choice = Some(BROKEN.into());
    stage.perform(Command::OpenScene);
    let told = stage.nodes().into_iter().filter(|node| {
        use egui_kittest::kittest::NodeT as _;
        let node = node.accesskit_node();
        node.value().or(node.label()).is_some_and(|text| text.contains("opening the scene: "))
    });
    assert!(told.count() >= 1, "the error is not in the log\n{}", stage.read_out());
    assert_eq!((stage.inspector().title(), stage.inspector().model().generation), (title, generation));
    stage.perform(Command::NextPass);
    assert_eq!(stage.place(), 10, "the old run is still open");
    let link = stage.inspector().link().expect("a link");
    assert_eq!(link.scene.as_deref(), Some(CORNELL), "the link has the wrong scene");
}

#[test]
fn a_lost_device() {
    let gpu = own_gpu();
    let mut stage = Stage::new(Plan { gpu: gpu.clone(), ..Plan::default() });
    stage.open(CORNELL, small(), Arrival { place: Some(9), ..Arrival::default() });
    stage.perform(Command::Show(PaneKind::Log));
    let hash = stage.inspector().link().and_then(|link| link.scene_hash).expect("a hash");
    gpu.device.destroy();
    stage.perform(Command::NextPass);
    stage.perform(Command::End);
    stage.frames(5);
    assert!(gpu.health().is_err());
    assert!(stage.reads("the GPU device was lost"), "{}", stage.read_out());
    let link = format!("raystep:1?scene=cornell-box&scene-hash={hash}&size=32x32&device=gpu&pixel=16,9&pass=9");
    assert_eq!(stage.inspector().how_to_go_on(), format!("; to resume: raystep inspect --link \"{link}\""));
    tour_without_drawing(&mut stage);
}

fn tour_without_drawing(stage: &mut Stage) {
    for &kind in PaneKind::ALL {
        stage.perform(Command::Show(kind));
    }
    for command in [Command::Arrange(Layout::Step), Command::Compare, Command::Pin, Command::ExportExr, Command::Start]
    {
        stage.perform(command);
    }
}

#[test]
fn moved_between_scale_factors() {
    let mut stage = Stage::with_scene(CORNELL, small(), Arrival { place: Some(9), ..Arrival::default() });
    stage.arrange(Layout::Step);
    for scale in [2.0, 1.25, 3.0, 0.5, 1.0] {
        stage.harness.set_pixels_per_point(scale);
        stage.settle();
        let picture = stage.harness.render().expect("it can be drawn");
        let side = (1280.0 * scale).round() as u32;
        assert!(scale != 1.0 || picture.width().abs_diff(side) <= 16, "{} at {scale}", picture.width());
        assert_eq!(stage.harness.ctx.pixels_per_point(), scale);
    }
    assert_eq!(stage.place(), 9);
}

#[test]
fn minimised_and_back() {
    let mut stage = Stage::with_scene(CORNELL, small(), Arrival { place: Some(9), ..Arrival::default() });
    for size in [Vec2::ZERO, Vec2::splat(1.0), Vec2::ZERO] {
        for _ in 0..4 {
            stage.harness.input_mut().screen_rect = Some(Rect::from_min_size(egui::Pos2::ZERO, size));
            stage.frame();
        }
        stage.perform(Command::NextPass);
        tour_without_drawing(&mut stage);
    }
    stage.harness.set_size(Vec2::new(1280.0, 800.0));
    stage.perform(Command::EndCompare);
    stage.arrange(Layout::Overview);
    stage.perform(Command::End);
    let picture = stage.harness.render().expect("it can be drawn");
    assert_eq!((picture.width(), picture.height()), (1280, 800));
    assert!(stage.find(egui::Role::Image, |name| name.contains("after")).is_some(), "{}", stage.read_out());
}

#[test]
fn numbers_that_are_none_can_be_typed_into_texels() {
    let mut stage =
        Stage::with_scene(CORNELL, small(), Arrival { pixel: Some([12, 20]), place: Some(9), ..Arrival::default() });
    for (typed, stream) in [("NaN", TMAX), ("-inf", RAY_DIRECTION), ("0xffffffff", RAY_ORIGIN)] {
        stage.show_stream(stream, "x");
        stage.perform(Command::EditTexel);
        stage.answer(typed);
    }
    let edits: Vec<f32> = stage.inspector().model().edits.iter().map(|edit| f32::from_bits(edit.bits)).collect();
    assert!(edits.len() == 3 && edits[0].is_nan() && edits[1] == f32::NEG_INFINITY && edits[2].is_nan(), "{edits:?}");
    // A state is no float.
    stage.show_stream(STATE, "tag");
    stage.perform(Command::EditTexel);
    stage.answer("NaN");
    assert!(stage.reads("\"NaN\": expected an integer of at least 0"), "{}", stage.read_out());
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    for &kind in PaneKind::ALL {
        stage.perform(Command::Show(kind));
    }
    stage.arrange(Layout::Ray);
    for command in [Command::End, Command::PreviousPass, Command::Start] {
        stage.perform(command);
        stage.harness.render().expect("it can be drawn");
    }
    let error = stage.inspector().last_error().unwrap_or_default().to_owned();
    assert!(error.starts_with("\"NaN\": expected an integer"), "{error}");
}

/// A file that the user drops into the window.
#[derive(Debug)]
struct Dropped(&'static str);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &std::path::Path {
        std::path::Path::new(self.0)
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("no such file".into())
    }
}

#[test]
fn a_dropped_or_recent_file_that_is_gone_is_named_and_keeps_what_is_open() {
    const GONE: [&str; 2] = ["gone.glb", "gone.raystep-session"];
    let mut saved = Saved::default();
    GONE.iter().for_each(|path| saved.opened(path));
    let mut stage = Stage::new(Plan::default());
    stage.inspector().restore(saved.to_text().expect("JSON").as_bytes());
    let error = |stage: &Stage| stage.harness.state().last_error().unwrap_or_default().to_owned();
    for path in GONE {
        stage.frame();
        stage.click(egui::Role::Link, path);
        stage.settle();
        assert!(error(&stage).contains(&format!("{path}: no such file")), "{}", error(&stage));
        // The other one can be tried.
        assert!(stage.reads("or start with a lesson"), "{}", stage.read_out());
    }
    stage.open(CORNELL, small(), Arrival { place: Some(9), ..Arrival::default() });
    for path in GONE {
        stage.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path)));
        stage.frame();
        stage.settle();
        assert!(error(&stage).contains(&format!("{path}: no such file")), "{}", error(&stage));
        assert_eq!(stage.place(), 9, "what was open is gone");
    }
}
