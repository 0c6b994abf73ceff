//! Sessions as files: saved, opened again, and refused as a whole if they are broken.

use egui::{Key, Modifiers, Role};
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::link::Link;
use raystep_inspector::session_file::SessionFile;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::Accelerator;
use raystep_kernels::Choices;
use raystep_lab::Hash;

use crate::ui::desk::{CORNELL, TRIANGLE};
use crate::ui::stage::{Plan, Stage};

const NAME: &str = "box.raystep-session";
const PLACE: usize = 12;
const PIXEL: [u32; 2] = [20, 22];

fn settings(device: DeviceKind) -> Settings {
    Settings { size: [32, 32], device, ..Settings::default() }
}

fn open(stage: &mut Stage, settings: Settings) {
    stage.open(CORNELL, settings, Arrival { pixel: Some(PIXEL), place: Some(PLACE), ..Arrival::default() });
}

/// The session that was saved last.
fn saved(stage: &mut Stage) -> Vec<u8> {
    stage.perform(Command::SaveSession);
    let desk = stage.desk.lock().expect("not poisoned");
    desk.saved.last().expect("a session").bytes.clone()
}

/// Opens a session by its name, as one that was dropped, or chosen in a dialog.
fn open_session(stage: &mut Stage, bytes: &[u8]) {
    {
        let mut desk = stage.desk.lock().expect("not poisoned");
        desk.session = Some(NAME.into());
        desk.sessions = vec![(NAME.into(), bytes.to_vec())];
    }
    stage.perform(Command::OpenSession);
}

#[test]
fn a_session_opens_as_it_was_saved() {
    let mut stage = Stage::new(Plan { size: [1000.0, 700.0], ..Plan::default() });
    open(&mut stage, settings(DeviceKind::CpuF64));
    stage.perform(Command::KeepRun);
    open(
        &mut stage,
        Settings {
            choices: Choices { accelerator: Accelerator::Bvh, ..settings(DeviceKind::Cpu).choices },
            ..settings(DeviceKind::Cpu)
        },
    );
    // Of the run that is kept next, one texel is edited.
    stage.perform(Command::EditTexel);
    stage.answer("2");
    stage.perform(Command::KeepRun);
    stage.arrange(Layout::Overview);
    stage.perform(Command::Show(PaneKind::Runs));
    stage.click(Role::Button, "Notes");
    stage.settle();
    stage.get(Role::MultilineTextInput, "notes").focus();
    stage.frames(2);
    stage.text("where the grid lost");
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    let bytes = saved(&mut stage);
    let panes = stage.harness.state().panes_in_view();
    let edits = stage.harness.state().model().edits.clone();
    assert_eq!(edits.len(), 1);

    let mut again = Stage::new(Plan { size: [1000.0, 700.0], ..Plan::default() });
    again.open(TRIANGLE, settings(DeviceKind::Cpu), Arrival::default());
    open_session(&mut again, &bytes);
    let inspector = again.harness.state();
    let model = inspector.model();
    let opened = model.opened.as_ref().expect("a run");
    assert_eq!((opened.scene.name.as_str(), opened.settings.choices.accelerator), ("cornell-box", Accelerator::Bvh));
    assert_eq!((again.place(), inspector.pixel(), &model.edits), (PLACE, Some(PIXEL), &edits));
    assert_eq!(inspector.panes_in_view(), panes);
    assert!(again.reads("where the grid lost"), "{}", again.read_out());
    let recipes = |stage: &Stage| -> Vec<_> {
        let runs = stage.harness.state().kept_runs().list();
        runs.iter().map(|kept| (kept.name.clone(), kept.recipe.clone(), kept.hash.clone())).collect()
    };
    assert_eq!(recipes(&again), recipes(&stage));
    let file = |bytes: &[u8]| {
        let mut file = SessionFile::from_bytes(bytes).expect("a session");
        // The panels are compared above; their order in the text is arbitrary.
        assert!(file.layout.take().is_some());
        file
    };
    assert_eq!(file(&saved(&mut again)), file(&bytes), "saved again, it is the same session");

    // Results are not in the file: they are made again, with the same bits.
    for i in 0..2 {
        assert!(again.harness.state().kept_runs().list()[i].outcome.is_none());
        again.click(Role::Button, "Run again");
        again.settle();
        let [ours, theirs] = [&again, &stage].map(|s| s.harness.state().kept_runs().list()[i].picture.clone());
        let (ours, theirs) = (ours.expect("a picture"), theirs.expect("a picture"));
        assert_eq!(ours.streams, theirs.streams, "run {i}");
    }
    assert_eq!(again.place(), PLACE);
}

#[test]
fn a_broken_session_changes_nothing() {
    let mut stage = Stage::new(Plan { size: [900.0, 600.0], ..Plan::default() });
    open(&mut stage, settings(DeviceKind::Cpu));
    stage.perform(Command::KeepRun);
    let before = saved(&mut stage);
    let text = String::from_utf8(before.clone()).expect("text");
    let generation = stage.harness.state().model().generation;
    let no_scene = text.replace(CORNELL, "nowhere.glb");
    for (broken, message) in [
        ("{", "line 1, column 1: EOF"),
        (&text.replace("\"version\": 1", "\"version\": 7"), "version 7"),
        (&text.replace("\"watches\"", "\"watched\""), "unknown field `watched`"),
        (&no_scene, "nowhere.glb: no such file"),
    ] {
        open_session(&mut stage, broken.as_bytes());
        let error = stage.harness.state().last_error().unwrap_or_default().to_owned();
        assert!(error.contains(message), "{message}: {error}");
        assert_eq!(stage.harness.state().model().generation, generation, "{message}");
    }
    let runs = |bytes: &[u8]| SessionFile::from_bytes(bytes).map(|file| (file.here, file.runs, file.watches));
    assert_eq!(runs(&saved(&mut stage)), runs(&before));
}

#[test]
fn a_link_tells_another_scene_of_the_same_name() {
    let mut stage = Stage::new(Plan { size: [900.0, 600.0], ..Plan::default() });
    open(&mut stage, settings(DeviceKind::Cpu));
    let link = stage.inspector().link().expect("a link").to_string();
    assert!(link.contains("&scene-hash=fnv1a64:"), "{link}");
    stage.inspector().go_to_link(&link);
    stage.settle();
    assert_eq!(stage.inspector().last_error(), None);
    let mut other: Link = link.parse().expect("a link");
    other.scene_hash = Some(Hash::of(b"another"));
    stage.inspector().follow_link(&other);
    stage.settle();
    let error = stage.inspector().last_error().unwrap_or_default().to_owned();
    assert!(error.contains("cornell-box is not the scene that the link was made with"), "{error}");
}

#[test]
fn another_scene_of_the_same_name_is_said() {
    let mut stage = Stage::new(Plan { size: [900.0, 600.0], ..Plan::default() });
    open(&mut stage, settings(DeviceKind::Cpu));
    stage.perform(Command::KeepRun);
    let text = String::from_utf8(saved(&mut stage)).expect("text");
    let other = text.replace("fnv1a64:", "fnv1a64:0");
    open_session(&mut stage, other.as_bytes());
    let error = stage.harness.state().last_error().unwrap_or_default().to_owned();
    assert!(error.contains("cornell-box is not the scene that the session was made with"), "{error}");
    stage.arrange(Layout::Overview);
    stage.perform(Command::Show(PaneKind::Runs));
    assert!(stage.reads("other scene"), "{}", stage.read_out());
    // The kept run is refused, too: it would be one of another scene.
    let file = SessionFile::from_bytes(text.as_bytes()).expect("a session");
    assert_eq!(file.runs.len(), 1);
    open_session(&mut stage, text.as_bytes());
    assert!(!stage.reads("other scene"), "{}", stage.read_out());
}
