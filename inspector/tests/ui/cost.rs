//! Where the cost is: heatmap, distribution, warps, the tree and the grid's layers, as a user meets them.

use egui::{Role, pos2};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::options::ProgramName;
use raystep_kernels::{Accelerator, Choices, GridSize, ScheduleKind};
use raystep_lab::structure_stats::Slice;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

fn settings() -> Settings {
    Settings { size: [64, 64], device: DeviceKind::Cpu, ..Settings::default() }
}

/// A stage of which one panel fills all, after some passes.
fn alone(settings: Settings, place: usize, kind: PaneKind) -> Stage {
    let mut stage = Stage::new(Plan { size: [1000.0, 700.0], ..Plan::default() });
    let arrival = Arrival { pixel: Some([40, 44]), place: Some(place), ..Arrival::default() };
    stage.open(CORNELL, settings, arrival);
    stage.close_panels();
    stage.perform(Command::Show(kind));
    assert_eq!(stage.harness.state().panes_in_view(), [kind]);
    stage
}

/// The name of the image that begins like this.
#[track_caller]
fn image(stage: &Stage, begins: &str) -> String {
    let found = stage.find(Role::Image, |name| name.starts_with(begins));
    let name = found.and_then(|node| node.accesskit_node().label());
    name.unwrap_or_else(|| panic!("no image {begins:?}\n{}", stage.read_out()))
}

fn heatmap(stage: &Stage) -> String {
    image(stage, "heatmap of 64 by 64 pixels")
}

/// The middle of the first text like this below a heading.
#[track_caller]
fn below(stage: &Stage, heading: &str, text: &str) -> egui::Pos2 {
    let reads = |node: &egui_kittest::Node<'_>, wanted: &str| {
        let node = node.accesskit_node();
        node.role() == Role::Label && node.label().or(node.value()).is_some_and(|found| found == wanted)
    };
    let nodes = stage.nodes();
    let top = nodes.iter().find(|node| reads(node, heading)).map(|node| node.rect().bottom());
    let is_it = |node: &&egui_kittest::Node<'_>| reads(node, text) && Some(node.rect().top()) >= top;
    let found = nodes.iter().find(is_it).map(|node| node.rect().center());
    found.unwrap_or_else(|| panic!("no {text:?} below {heading:?}\n{}", stage.read_out()))
}

#[test]
fn costs_are_shown_before_the_end_and_of_the_whole_run_beside_it() {
    let mut stage = alone(settings(), 20, PaneKind::Cost);
    assert!(stage.reads("up to and including pass 19"), "{}", stage.read_out());
    // What was found comes first.
    let top = |wanted: &str| {
        let nodes = stage.nodes().into_iter().filter(|node| node.accesskit_node().role() == Role::Label);
        let mut found = nodes.filter(|node| node.accesskit_node().value().is_some_and(|text| text.contains(wanted)));
        found.next().map(|node| node.rect().top())
    };
    assert!(top("half of it is in ") < top("up to and including pass 19"), "{}", stage.read_out());
    assert!(top("half of it is in ").is_some());
    let early = heatmap(&stage);
    stage.click(Role::Button, "Count the whole run");
    stage.settle();
    assert!(stage.reads("of the whole run, from a second run"), "{}", stage.read_out());
    let whole = heatmap(&stage);
    assert_ne!(whole, early);
    assert_eq!(stage.place(), 20, "the view stays where it is");
    stage.click(Role::CheckBox, "up to this pass");
    stage.settle();
    assert_eq!(heatmap(&stage), early);
    stage.perform(Command::End);
    // The run's own counters are those of the second run.
    assert!(stage.reads("of the whole run") && !stage.reads("from a second run"), "{}", stage.read_out());
    assert_eq!(heatmap(&stage), whole);
}

#[test]
fn a_click_on_the_heatmap_selects_the_ray_and_one_on_a_bar_shows_its_rays_alone() {
    let mut stage = alone(settings(), 200, PaneKind::Cost);
    let picture = stage.find(Role::Image, |name| name.starts_with("heatmap")).expect("a heatmap").rect();
    let scale = picture.width().min(picture.height()) / 64.0;
    // Texel 10,50, from the middle of a picture that fits.
    stage.click_at(picture.center() + scale * egui::vec2(10.5 - 32.0, 50.5 - 32.0));
    stage.settle();
    assert_eq!(stage.inspector().pixel(), Some([10, 50]));
    let bars = stage.find(Role::Image, |name| name.starts_with("rays by")).expect("a histogram").rect();
    stage.click_at(pos2(bars.left() + 0.4 * bars.width(), bars.bottom() - 30.0));
    stage.settle();
    assert!(stage.reads("Shown alone: "), "{}", stage.read_out());
    stage.snapshot("cost-bar");
    stage.click(Role::Button, "Show all");
    stage.settle();
    assert!(!stage.reads("Shown alone: "));
}

#[test]
fn a_run_without_counters_is_counted_in_another() {
    let mut counted = alone(settings(), 200, PaneKind::Cost);
    let mut stage = alone(Settings { counters: false, ..settings() }, 20, PaneKind::Cost);
    assert!(stage.reads("This run has no counters."), "{}", stage.read_out());
    stage.click(Role::Button, "Count in a second run");
    stage.settle();
    assert_eq!(heatmap(&stage), heatmap(&counted));
    for measure in ["cells", "triangles"] {
        for stage in [&mut stage, &mut counted] {
            stage.click(Role::Button, measure);
            stage.settle();
        }
        assert_eq!(heatmap(&stage), heatmap(&counted), "{measure}");
    }
}

#[test]
fn the_slowest_warps_name_the_rays_that_held_them() {
    for (schedule, accelerator) in
        [(ScheduleKind::Second, Accelerator::Grid), (ScheduleKind::Compact, Accelerator::Bvh)]
    {
        let mut stage = alone(
            Settings { choices: Choices { schedule, accelerator, ..settings().choices }, ..settings() },
            20,
            PaneKind::Cost,
        );
        stage.click(Role::Button, "Warps");
        stage.settle();
        assert!(stage.reads("Assumed: a warp is 32 neighbouring threads"), "{}", stage.read_out());
        stage.click(Role::Button, "Analyse the warps of all passes");
        stage.settle();
        assert!(stage.reads("slowest warps"), "{}", stage.read_out());
        let first = below(&stage, "slowest warps", "1");
        stage.click_at(first);
        stage.settle();
        assert!(stage.reads("Held by pixel "), "{}", stage.read_out());
        let [x, y] = stage.inspector().pixel().expect("a pixel");
        assert!(stage.reads(&format!("Held by pixel {x},{y}: ")), "{}", stage.read_out());
        if accelerator == Accelerator::Grid {
            stage.snapshot("cost-warps");
        }
        // No ray has more passes than the walk has in all, and the heatmap shows that number.
        stage.click(Role::Button, "passes");
        stage.settle();
        assert!(heatmap(&stage).contains(": passes from 0 to "), "{}", heatmap(&stage));
    }
}

#[test]
fn the_tree_is_expanded_to_what_is_picked() {
    let mut stage = alone(
        Settings { choices: Choices { accelerator: Accelerator::Bvh, ..settings().choices }, ..settings() },
        30,
        PaneKind::Structure,
    );
    assert!(stage.reads("binary BVH"), "{}", stage.read_out());
    assert!(stage.find(Role::Button, |name| name == "collapse node 0").is_some(), "it opens at the ray's nodes");
    stage.click(Role::Button, "collapse all");
    stage.settle();
    assert!(stage.find(Role::Button, |name| name == "expand node 1" || name == "expand node 2").is_none());
    stage.click(Role::Button, "expand node 0");
    stage.settle();
    assert!(stage.find(Role::Button, |name| name == "collapse node 0").is_some());
    stage.click(Role::Button, "collapse all");
    stage.click(Role::Button, "deepest leaf");
    stage.settle();
    assert!(stage.reads("leaf of "), "{}", stage.read_out());
    assert!(stage.find(Role::Button, |name| name == "collapse node 0").is_some(), "its ancestors are expanded");
    stage.click(Role::Button, "collapse all");
    stage.click(Role::Button, "the ray's nodes");
    stage.settle();
    assert!(stage.reads("met"), "{}", stage.read_out());
    stage.snapshot("structure-tree");
}

#[test]
fn layers_of_the_grid_have_their_numbers_and_axes() {
    let grid = GridSize::Cells([5, 4, 3]);
    let mut stage =
        alone(Settings { choices: Choices { grid, ..settings().choices }, ..settings() }, 30, PaneKind::Structure);
    let data = stage.inspector().model().opened.as_ref().expect("a run").data.clone();
    for (axis, names) in [(2, ["+x", "+y"]), (0, ["+y", "+z"]), (1, ["+x", "+z"])] {
        let name = image(&stage, "list lengths");
        let index = name.split(" at ").nth(1).and_then(|rest| rest.split(',').next()).expect("an index");
        let slice = Slice::of(&data, axis, index.parse().expect("a number")).expect("a layer");
        let painted = stage.painted();
        for name in names {
            assert!(painted.iter().any(|text| text == name), "{name}: {painted:?}");
        }
        for length in &slice.lengths {
            let wanted = slice.lengths.iter().filter(|other| *other == length).count();
            let found = painted.iter().filter(|text| **text == length.to_string()).count();
            assert!(found >= wanted, "axis {axis}: {found} times {length}, of {wanted}");
        }
        stage.perform(Command::SliceAxis);
    }
}

#[test]
fn what_a_run_does_not_have_is_said() {
    let build = Settings { choices: Choices { program: ProgramName::GridBuild, ..settings().choices }, ..settings() };
    let mut stage = alone(build, 5, PaneKind::Cost);
    assert!(stage.reads("This program has no rays."), "{}", stage.read_out());
    stage.perform(Command::Show(PaneKind::Structure));
    assert!(stage.reads("This program traces through no grid or BVH."), "{}", stage.read_out());
    let without = Settings { choices: Choices { accelerator: Accelerator::None, ..settings().choices }, ..settings() };
    let stage = alone(without, 30, PaneKind::Structure);
    assert!(stage.reads("No acceleration structure"), "{}", stage.read_out());
}
