//! Where the light of a pixel comes from: its tree as a table and in 3D.

use egui::accesskit::Toggled;
use egui::{Role, Theme};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::export::light_tree::{Fate, LightTree, VertexKind};
use raystep_kernels::options::Integrator;
use raystep_kernels::{Accelerator, Choices};

use crate::ui::desk::{CORNELL, GLOW, ROOM};
use crate::ui::stage::{Plan, Stage};

/// Of the floor, in the shadow of a box.
const PIXEL: [u32; 2] = [24, 55];

fn settings(integrator: Integrator) -> Settings {
    let choices = Choices { integrator, accelerator: Accelerator::Grid, ..Choices::stepped() };
    Settings { size: [64, 64], device: DeviceKind::Cpu, choices, ..Settings::default() }
}

/// One panel in a window of this size, at the end of a run with shadow rays.
fn stage(size: [f32; 2], theme: Theme, kind: PaneKind) -> Stage {
    let mut stage = Stage::new(Plan { size, theme, ..Plan::default() });
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(usize::MAX), ..Arrival::default() };
    stage.open(ROOM, settings(Integrator::Shadows), arrival);
    stage.close_panels();
    stage.perform(Command::Show(kind));
    stage
}

fn tree(stage: &Stage) -> LightTree {
    let model = stage.harness.state().model();
    let (history, opened) = (model.history.as_ref().expect("a ray"), model.opened.as_ref().expect("a run"));
    LightTree::of(&history.rows, opened.plan.program, &opened.data).expect("a tree")
}

/// The rows of the table, and the highlighted one.
fn rows(stage: &Stage) -> (Vec<String>, Option<String>) {
    let nodes = stage.nodes().into_iter().filter(|node| node.accesskit_node().role() == Role::Row);
    let rows: Vec<_> = nodes
        .filter_map(|node| {
            Some((node.accesskit_node().label()?, node.accesskit_node().toggled() == Some(Toggled::True)))
        })
        .collect();
    let current = rows.iter().find(|(_, is_current)| *is_current).map(|(name, _)| name.clone());
    (rows.into_iter().map(|(name, _)| name).collect(), current)
}

/// The table and the 3D view.
fn seen(theme: Theme, name: &str) {
    let mut stage = stage([900.0, 360.0], theme, PaneKind::LightTree);
    stage.snapshot(&format!("light-tree-{name}"));
    stage.perform(Command::Show(PaneKind::LightTree));
    stage.perform(Command::Show(PaneKind::Walk3d));
    stage.snapshot(&format!("light-tree-3d-{name}"));
}

#[test]
fn a_pixels_light_is_seen_on_dark() {
    seen(Theme::Dark, "dark");
}

#[test]
fn a_pixels_light_is_seen_on_light() {
    seen(Theme::Light, "light");
}

#[test]
fn a_narrow_panel_has_reasons_below() {
    stage([420.0, 400.0], Theme::Dark, PaneKind::LightTree).snapshot("light-tree-narrow");
}

#[test]
fn a_click_on_a_vertex_goes_to_the_pass_that_decided_it_which_highlights_its_row() {
    let mut stage = stage([900.0, 400.0], Theme::Dark, PaneKind::LightTree);
    let tree = tree(&stage);
    let blocked = |vertex: &raystep_kernels::export::light_tree::Vertex| matches!(vertex.fate, Fate::Occluded { .. });
    let at = tree.vertices.iter().position(blocked).expect("an occluded light");
    let vertex = &tree.vertices[at];
    let Fate::Occluded { triangle, .. } = vertex.fate else { unreachable!() };
    let (named, _) = rows(&stage);
    assert_eq!(named.len(), tree.vertices.len(), "{named:?}");
    let row = named.iter().find(|row| row.starts_with(&vertex.name())).expect("its row").clone();
    assert!(row.contains(&vertex.why), "{row}");
    stage.click(Role::Row, &row);
    stage.settle();
    let decided = vertex.decided.and_then(|step| step.pass).expect("a pass");
    assert_eq!(stage.place(), decided + 1);
    assert_eq!(rows(&stage).1, Some(row.clone()));
    // Its blocker is selected in all panels.
    stage.perform(Command::Show(PaneKind::Walk3d));
    assert!(stage.reads(&format!("triangle {triangle}: ")), "{}", stage.read_out());
    stage.perform(Command::Show(PaneKind::LightTree));
    // The pass before its ray was cast is of another vertex.
    let before = vertex.cast.pass.expect("a pass");
    while stage.place() > before {
        stage.perform(Command::PreviousPass);
    }
    let current = rows(&stage).1;
    assert!(current.is_some() && current != Some(row), "{current:?}");
    // As many swatches as there are lights and sums.
    assert!(tree.vertices.iter().any(|v| v.kind == VertexKind::Light && v.fate == Fate::NotCast), "{tree:#?}");
}

#[test]
fn the_3d_view_says_which_rays_it_draws_up_to_the_pass() {
    let mut stage = stage([900.0, 500.0], Theme::Dark, PaneKind::Walk3d);
    let said = |stage: &Stage| {
        let view = stage.find(Role::Image, |name| name.contains(" visited")).expect("the 3D view");
        view.accesskit_node().label().expect("a name")
    };
    let tree = tree(&stage);
    let whole = said(&stage);
    assert!(whole.contains(&format!("light tree: {}", tree.sentence(0))), "{whole}");
    assert!(whole.contains(", occluded by triangle ") && whole.contains("to light 1"), "{whole}");
    let first = tree.vertices.iter().find(|vertex| vertex.kind == VertexKind::Light).expect("a light");
    let cast = first.cast.pass.expect("a pass");
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(cast), ..Arrival::default() };
    stage.open(ROOM, settings(Integrator::Shadows), arrival);
    let early = said(&stage);
    assert!(!early.contains(&first.name()) && early.contains("light tree: rays to triangle "), "{early}");
    stage.perform(Command::Start);
    assert!(stage.find(Role::Image, |name| name.contains("light tree")).is_none(), "{}", stage.read_out());
}

#[test]
fn a_run_without_shadow_rays_says_how_to_get_them() {
    let mut stage = Stage::new(Plan { size: [500.0, 300.0], ..Plan::default() });
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(usize::MAX), ..Arrival::default() };
    stage.open(CORNELL, settings(Integrator::Local), arrival);
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::LightTree));
    assert!(stage.paints("--integrator shadows"), "{:?}", stage.painted());
    assert_eq!(rows(&stage).0, [""; 0]);
}

/// A light tree of a path, in a window of this size.
fn of_path(size: [f32; 2], theme: Theme, settings: Settings) -> Stage {
    let mut stage = Stage::new(Plan { size, theme, ..Plan::default() });
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(usize::MAX), ..Arrival::default() };
    stage.open(GLOW, settings, arrival);
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::LightTree));
    for name in ["strategies", "precision"] {
        stage.click(Role::CheckBox, name);
        stage.settle();
    }
    stage.click(Role::Button, "Estimate by each strategy");
    stage.settle();
    stage
}

fn estimated(size: [f32; 2], theme: Theme, name: &str) -> Stage {
    let mut stage = of_path(size, theme, settings(Integrator::Path));
    for text in ["mis", "bsdf", "standard error", "f32 and f64 "] {
        assert!(stage.paints(text), "{text}: {:?}", stage.painted());
    }
    stage.snapshot(&format!("light-tree-path-{name}"));
    stage
}

#[test]
fn a_pixel_is_estimated_by_each_strategy_on_dark() {
    let mut stage = estimated([900.0, 420.0], Theme::Dark, "dark");
    assert!(stage.paints("weight"), "{:?}", stage.painted());
    // Another pixel has other estimates.
    stage.perform(Command::NudgeLeft);
    assert!(stage.paints("Estimate by each strategy") && !stage.paints("standard error"), "{:?}", stage.painted());
    // Other rays have no strategies.
    stage.open(ROOM, settings(Integrator::Shadows), Arrival { pixel: Some(PIXEL), ..Arrival::default() });
    assert!(!stage.paints("weight") && !stage.paints("strategies"), "{:?}", stage.painted());
}

#[test]
fn a_pixel_is_estimated_by_each_strategy_on_light() {
    estimated([900.0, 420.0], Theme::Light, "light");
}

#[test]
fn a_pixel_is_estimated_in_a_narrow_panel() {
    estimated([420.0, 560.0], Theme::Dark, "narrow");
}

#[test]
fn a_path_on_the_gpu_is_compared_with_f32() {
    let settings = Settings { device: DeviceKind::Gpu, ..settings(Integrator::Path) };
    let stage = of_path([900.0, 420.0], Theme::Dark, settings);
    // Software Vulkan has every bit of the CPU reference; other devices round otherwise.
    assert!(stage.paints("The GPU and f32 have the same light tree"), "{:?}", stage.painted());
    assert!(stage.paints("f32 and f64 "), "{:?}", stage.painted());
}
