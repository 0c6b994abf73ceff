//! The walk of a ray, in 3D and unfolded: its camera, what a click picks, and the same ray through two structures.

use egui::{Key, Modifiers, Pos2, Role, pos2};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_inspector::walk::WalkGeometry;
use raystep_kernels::Accelerator;
use raystep_kernels::Choices;

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

/// The name of the button that shows the second walk.
const SHOW: &str = "Show BVH walk";

fn stage(accelerator: Accelerator) -> Stage {
    let settings = Settings {
        size: [64, 64],
        device: DeviceKind::Cpu,
        choices: Choices { accelerator, ..Choices::stepped() },
        ..Settings::default()
    };
    let arrival = Arrival { pixel: Some([40, 44]), place: Some(usize::MAX), ..Arrival::default() };
    Stage::with_scene(CORNELL, settings, arrival)
}

/// Moves the unfolded walk from its own tile to the largest one.
fn enlarge(stage: &mut Stage) {
    stage.perform(Command::Show(PaneKind::Walk2d));
    stage.perform(Command::Show(PaneKind::Walk2d));
}

fn walk(stage: &Stage) -> WalkGeometry {
    let model = stage.harness.state().model();
    let (history, opened) = (model.history.as_ref().expect("a ray"), model.opened.as_ref().expect("a run"));
    WalkGeometry::new(history, &opened.data, usize::MAX)
}

/// The middle of a cell of the unfolded walk, as it is drawn with cells of equal width.
fn cell_at(stage: &Stage, index: usize, count: usize) -> Pos2 {
    let image = stage.find(Role::Image, |name| name.contains(" visited")).expect("the unfolded walk");
    let rect = image.rect().shrink2(egui::vec2(4.0, 0.0));
    // Above the scale, the coordinates, and the dots of tests.
    pos2(rect.left() + rect.width() * (index as f32 + 0.5) / count as f32, rect.bottom() - 22.0 - 13.0 - 26.0)
}

#[test]
fn a_click_on_a_cell_goes_to_its_pass_and_every_panel_shows_it_until_escape() {
    let mut stage = stage(Accelerator::Grid);
    enlarge(&mut stage);
    let walk = walk(&stage);
    let visit = walk.cells[2];
    let [x, y, z] = visit.cell;
    let place = stage.harness.state().model().history.as_ref().expect("a ray").rows[visit.row].place();
    assert_ne!(Some(stage.place()), place);
    let at = cell_at(&stage, 2, walk.cells.len());
    stage.click_at(at);
    stage.settle();
    assert_eq!(Some(stage.place()), place);
    let about = format!("cell {x},{y},{z}: ");
    assert!(stage.reads(&about) && stage.reads("visited by this ray"), "{}", stage.read_out());
    for panel in [PaneKind::Walk3d, PaneKind::Structure] {
        stage.perform(Command::Show(panel));
        assert!(stage.reads(&about), "{panel:?}: {}", stage.read_out());
    }
    // The list of the cell that was picked elsewhere.
    assert!(stage.paints(&format!("cell {x},{y},{z}")), "{:?}", stage.painted());
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    assert!(!stage.reads(&about), "{}", stage.read_out());
    // Picked again, and again.
    stage.perform(Command::Show(PaneKind::Walk2d));
    stage.click_at(at);
    stage.settle();
    assert!(stage.reads(&about));
    stage.click_at(cell_at(&stage, 2, walk.cells.len()));
    stage.settle();
    assert!(!stage.reads(&about), "{}", stage.read_out());
}

#[test]
fn a_click_in_the_3d_view_picks_what_is_under_it() {
    let mut stage = stage(Accelerator::Bvh);
    stage.perform(Command::Show(PaneKind::Walk3d));
    let view = stage.find(Role::Image, |name| name.contains(" visited")).expect("the 3D view").rect();
    // The walk is framed: its middle is in the picture's.
    stage.click_at(view.center());
    stage.settle();
    let picked = |stage: &Stage| stage.find(Role::Button, |name| name == "clear selection").is_some();
    assert!(picked(&stage), "{}", stage.read_out());
    assert!(stage.reads(" by this ray"), "{}", stage.read_out());
    stage.click(Role::Button, "clear selection");
    stage.settle();
    assert!(!picked(&stage));
    stage.click_at(view.left_top() + egui::vec2(2.0, 30.0));
    stage.settle();
    // The view has the keyboard focus now: Escape clears nevertheless.
    stage.click_at(view.center());
    stage.settle();
    assert!(picked(&stage));
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    assert!(!picked(&stage), "{}", stage.read_out());
}

#[test]
fn the_camera_frames_each_ray_until_it_is_moved_by_hand() {
    let mut stage = stage(Accelerator::Grid);
    stage.perform(Command::Show(PaneKind::Walk3d));
    let is_moved = |stage: &Stage| stage.reads("view moved by hand");
    let label = |stage: &Stage| stage.painted().iter().any(|text| text.contains(": hit, t "));
    assert!(!is_moved(&stage) && label(&stage), "{:?}", stage.painted());
    let view = stage.find(Role::Image, |name| name.contains(" visited")).expect("the 3D view").rect();
    stage.event(egui::Event::PointerMoved(view.center()));
    stage.event(egui::Event::Zoom(40.0));
    stage.event(egui::Event::PointerGone);
    assert!(is_moved(&stage));
    // It stays for another ray, and comes back on request; then the next ray is framed again.
    stage.perform(Command::NudgeLeft);
    assert!(is_moved(&stage));
    stage.perform(Command::FrameWalk);
    assert!(!is_moved(&stage) && label(&stage), "{:?}", stage.painted());
    stage.perform(Command::NudgeLeft);
    assert!(!is_moved(&stage) && label(&stage));
}

#[test]
fn the_walk_through_the_other_structure_is_shown_without_a_second_run_and_with_one() {
    let mut stage = stage(Accelerator::Grid);
    enlarge(&mut stage);
    assert!(stage.find(Role::Button, |name| name == SHOW).is_some(), "{}", stage.read_out());
    stage.click(Role::Button, SHOW);
    stage.settle();
    let cells = walk(&stage).cells.len();
    let reads = |stage: &Stage| {
        assert!(stage.reads(&format!("A grid: {cells} cells visited, ")), "{}", stage.read_out());
        assert!(stage.reads("B bvh: ") && stage.reads(" nodes tested, "), "{}", stage.read_out());
        assert!(stage.reads("only A tested"), "{}", stage.read_out());
        assert!(stage.paints("A grid: ") && stage.paints("B bvh: "), "{:?}", stage.painted());
    };
    reads(&stage);
    assert!(stage.find(Role::Image, |name| name.contains("hit of run B")).is_none(), "no second run was needed");
    // A triangle that only one tested is picked by its number.
    let only = stage.find(Role::Button, |name| name.contains(", tested only in A"));
    let only = only.and_then(|node| {
        use egui_kittest::kittest::NodeT as _;
        node.accesskit_node().label()
    });
    if let Some(name) = only {
        stage.click(Role::Button, &name);
        stage.settle();
        let triangle = name.split(',').next().expect("a name").to_owned();
        assert!(stage.reads(&format!("{triangle}: in ")), "{triangle}: {}", stage.read_out());
    }
    // The drawing has both.
    stage.perform(Command::ExportWalk);
    let file = stage.desk.lock().expect("not poisoned").saved.pop().expect("a file");
    assert!(String::from_utf8(file.bytes).expect("text").contains("The same ray through the bvh"));
    stage.perform(Command::Compare);
    stage.perform(Command::Show(PaneKind::Walk2d));
    stage.settle();
    reads(&stage);
    stage.perform(Command::EndCompare);
    reads(&stage);
    // Another ray has another second walk.
    let before = stage.painted();
    stage.perform(Command::NudgeLeft);
    assert_ne!(stage.painted(), before);
    stage.click(Role::Button, SHOW);
    stage.settle();
    assert!(!stage.reads("B bvh: "), "{}", stage.read_out());
}
