//! Kept runs: bit for bit those of other runs, flipped through, compared and measured.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::runs::differ::{Aspect, differences};
use raystep_inspector::session::go_on;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_inspector::{Session, Target};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Accelerator, Choices, Device, Numerics, ScheduleKind};
use raystep_scenes::generate::cornell_box;

use crate::ui::adapter::{block_on, gpu};
use crate::ui::desk::{CORNELL, TRIANGLE};
use crate::ui::stage::{Plan, Stage};

const PLACE: usize = 12;
const PIXEL: [u32; 2] = [20, 22];

fn settings() -> Settings {
    Settings { size: [32, 32], device: DeviceKind::Cpu, ..Settings::default() }
}

fn open(stage: &mut Stage, settings: Settings) {
    stage.open(CORNELL, settings, Arrival { pixel: Some(PIXEL), place: Some(PLACE), ..Arrival::default() });
}

/// A stage on which these runs are kept.
fn kept(size: [f32; 2], all: &[Settings]) -> Stage {
    let mut stage = Stage::new(Plan { size, ..Plan::default() });
    for settings in all {
        open(&mut stage, settings.clone());
        stage.perform(Command::KeepRun);
    }
    stage
}

#[test]
fn a_kept_run_has_the_bits_of_a_run_of_its_own_and_the_view_stays() {
    let bvh = Settings {
        device: DeviceKind::Gpu,
        choices: Choices { accelerator: Accelerator::Bvh, ..settings().choices },
        ..settings()
    };
    let second = Settings {
        device: DeviceKind::CpuF64,
        choices: Choices { schedule: ScheduleKind::Second, ..settings().choices },
        ..settings()
    };
    let all = [settings(), bvh, second];
    let stage = kept([800.0, 500.0], &all);
    assert_eq!(stage.place(), PLACE, "keeping a run moves nothing");
    let runs = stage.harness.state().kept_runs().list();
    assert_eq!(runs.len(), all.len());
    let gpu = gpu();
    for (kept, settings) in runs.iter().zip(&all) {
        let device = match settings.device {
            DeviceKind::Gpu => Device::Gpu(gpu.clone()),
            DeviceKind::CpuF64 => Device::CpuF64(None),
            _ => Device::Cpu(None),
        };
        let scene = cornell_box();
        let mut own = block_on(&gpu, Session::new(&scene, &settings.options(&scene), &device)).expect("a run");
        block_on(&gpu, own.step(Target::End, &mut go_on)).expect("its end");
        let picture = kept.picture.as_ref().expect("a picture");
        for stream in [streams::COLOR, streams::HIT, streams::STATE, streams::COUNTERS] {
            let expected = block_on(&gpu, own.stream(stream)).expect("a stream");
            assert_eq!(picture.stream(stream), Some(&expected), "{}: {}", kept.name, stream.name());
        }
        let outcome = kept.outcome.as_ref().expect("an outcome");
        assert_eq!(outcome.passes.len(), own.place(), "{}", kept.name);
        let hits = block_on(&gpu, own.renderer().hits()).expect("hits").iter().flatten().count();
        assert_eq!(outcome.hits, Some(hits as u64), "{}", kept.name);
    }
}

#[test]
fn keys_flip_between_kept_runs_in_the_same_view() {
    let mut stage = kept(
        [900.0, 600.0],
        &[
            settings(),
            Settings { choices: Choices { accelerator: Accelerator::Bvh, ..settings().choices }, ..settings() },
        ],
    );
    stage.show_stream(streams::COLOR, "rgb");
    let picture = |stage: &mut Stage| {
        stage.settle();
        let node = stage.find(Role::Image, |name| name.contains("color after ")).expect("the stream").rect();
        let image = stage.harness.render().expect("an image");
        // Below the label.
        let [left, top, right, bottom] =
            [node.left(), node.top() + 40.0, node.right(), node.bottom()].map(|v| v as u32);
        (left..right).flat_map(|x| (top..bottom).map(move |y| (x, y))).map(|(x, y)| image.get_pixel(x, y).0).collect()
    };
    let here: Vec<[u8; 4]> = picture(&mut stage);
    stage.key(Modifiers::NONE, Key::Period);
    let first: Vec<[u8; 4]> = picture(&mut stage);
    assert!(stage.paints("kept run 1 of 2: grid compact robust"), "{:?}", stage.painted());
    let differing = here.iter().zip(&first).filter(|(a, b)| a != b).count();
    assert!(differing > 10_000, "{differing} pixels differ: after pass {PLACE}, nothing is shaded");
    stage.key(Modifiers::NONE, Key::Period);
    assert!(stage.paints("kept run 2 of 2: bvh compact robust"));
    assert_eq!(picture(&mut stage), first, "the same image, at the same zoom");
    stage.key(Modifiers::NONE, Key::Period);
    assert_eq!(picture(&mut stage), here, "after the last, the open run");
    stage.perform(Command::End);
    assert_eq!(picture(&mut stage), first, "what the open run comes to, too");
    stage.key(Modifiers::NONE, Key::Comma);
    assert!(stage.paints("kept run 2 of 2"));
    stage.show_stream(streams::RAY_ORIGIN, "x");
    assert!(
        stage.paints("not shown: ray_origin was not kept, only color, hit, state, counters"),
        "{:?}",
        stage.painted()
    );
}

#[test]
fn what_cannot_be_flipped_to_is_said() {
    let mut stage = kept([900.0, 600.0], &[settings()]);
    open(&mut stage, Settings { size: [16, 16], ..settings() });
    stage.key(Modifiers::NONE, Key::Period);
    stage.settle();
    assert!(stage.paints("(grid compact robust: it has 32 × 32 pixels, not 16 × 16)"), "{:?}", stage.painted());
    stage.open(TRIANGLE, settings(), Arrival::default());
    stage.key(Modifiers::NONE, Key::Period);
    stage.settle();
    assert!(stage.paints("(grid compact robust: it is of another scene)"), "{:?}", stage.painted());
    assert!(!stage.paints("kept run 1 of"));
}

#[test]
fn rays_that_differ_are_counted_and_selected_one_after_the_other() {
    let of = |accelerator, numerics| Settings {
        size: [64, 64],
        choices: Choices { accelerator, numerics, ..settings().choices },
        ..settings()
    };
    let all = [
        of(Accelerator::Grid, Numerics::Paper),
        of(Accelerator::Bvh, Numerics::Paper),
        of(Accelerator::Grid, Numerics::Robust),
        of(Accelerator::Bvh, Numerics::Robust),
    ];
    let mut stage = kept([1000.0, 700.0], &all);
    let found = |stage: &Stage, a: usize, b: usize, aspect| {
        let runs = stage.harness.state().kept_runs().list();
        let [a, b] = [a, b].map(|i| runs[i].picture.as_ref().expect("a picture"));
        differences(a, b, aspect).expect("the same size")
    };
    let (paper, robust) = (found(&stage, 0, 1, Aspect::Triangle), found(&stage, 2, 3, Aspect::Triangle));
    println!("paper: {:?}", paper.counts);
    println!("robust: {:?}", robust.counts);
    assert!(!paper.rays.is_empty(), "{:?}", paper.counts);
    assert_eq!(robust.counts.hit_or_miss, 0, "{:?}", robust.counts);

    // The pair is the first run and the last; then the paper's rules in the BVH.
    stage.arrange(Layout::Overview);
    stage.perform(Command::Show(PaneKind::Runs));
    stage.click(Role::RadioButton, "compared: bvh compact paper");
    stage.settle();
    let text = format!(
        "bvh compact paper against grid compact paper: of 4096 rays, {} differ in triangle",
        paper.counts.triangle
    );
    assert!(stage.reads(&text), "{text}: {}", stage.read_out());
    stage.get(Role::Image, &format!("map of {} rays that differ in triangle", paper.rays.len()));
    let pixel = |ray: u32| Some([ray % 64, ray / 64]);
    let mut seen = Vec::new();
    for _ in 0..=paper.rays.len() {
        stage.perform(Command::NextDifferingRay);
        seen.push(stage.harness.state().pixel());
    }
    let (last, distinct) = (seen.pop().expect("a ray"), seen.len());
    seen.sort_by_key(|pixel| pixel.map(|[x, y]| [y, x]));
    assert_eq!(seen, paper.rays.iter().map(|&ray| pixel(ray)).collect::<Vec<_>>());
    assert!(distinct == 1 || last != pixel(paper.rays[distinct - 1]) || distinct == paper.rays.len());
    assert_eq!(stage.harness.unnamed_widgets(), Vec::<String>::new());
}

#[test]
fn kept_runs_are_measured_in_turns() {
    let mut stage = kept(
        [1000.0, 700.0],
        &[
            settings(),
            Settings { choices: Choices { accelerator: Accelerator::Bvh, ..settings().choices }, ..settings() },
        ],
    );
    stage.arrange(Layout::Overview);
    stage.perform(Command::Show(PaneKind::Runs));
    stage.click(Role::Button, "Times");
    stage.settle();
    assert!(stage.reads("No run has been measured."));
    stage.click(Role::Button, "Measure both");
    stage.settle();
    let runs = stage.harness.state().kept_runs().list();
    for kept in runs {
        let measured = kept.measured.as_ref().expect("times");
        assert_eq!((measured.repeats.len(), measured.together), (6, 1), "{}", kept.name);
        assert!(measured.repeats.iter().all(|repeat| repeat.device_ns.is_some_and(|ns| ns > 0)));
        let kernels: Vec<&str> = measured.repeats[0].kernels.iter().map(|(name, _)| *name).collect();
        let walk = if kept.name.starts_with("grid") { "traverse_grid" } else { "traverse_bvh" };
        assert!(kernels.contains(&walk) && kernels.contains(&"intersect"), "{kernels:?}");
    }
    for text in ["traverse_grid", "traverse_bvh", "all passes", "whole run, host", "95% interval"] {
        assert!(stage.reads(text), "{text}: {}", stage.read_out());
    }
    assert_eq!(stage.place(), PLACE, "measuring moves nothing");

    // A measurement that is cancelled leaves the times as they were.
    stage.click(Role::Button, "Measure both");
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    let runs = stage.harness.state().kept_runs().list();
    assert!(runs.iter().all(|kept| kept.measured.as_ref().is_some_and(|measured| measured.together == 1)));
}

/// Grid, BVH, and the paper's rules.
fn three() -> [Settings; 3] {
    let bvh = Settings { choices: Choices { accelerator: Accelerator::Bvh, ..settings().choices }, ..settings() };
    let paper = Settings {
        choices: Choices { numerics: Numerics::Paper, schedule: ScheduleKind::First, ..settings().choices },
        ..settings()
    };
    [settings(), bvh, paper]
}

#[test]
fn the_table_fits_the_panel_and_says_once_what_all_runs_share() {
    for (size, layout) in [([1280.0, 800.0], Some(Layout::Compare)), ([600.0, 700.0], None)] {
        let mut stage = kept(size, &three());
        match layout {
            Some(layout) => stage.arrange(layout),
            None => {
                stage.close_panels();
                stage.perform(Command::Show(PaneKind::Runs));
            }
        }
        for head in ["ref.", "vs.", "name", "time", "passes", "hits", "differs in"] {
            let is_it = |node: &egui_kittest::Node<'_>| node.accesskit_node().value().as_deref() == Some(head);
            let rect = stage.nodes().into_iter().find(is_it).map(|node| node.rect());
            let rect = rect.unwrap_or_else(|| panic!("no {head}:\n{}", stage.read_out()));
            assert!(rect.left() > 0.0 && rect.right() <= size[0] + 8.0, "{head} at {size:?}: {rect}");
        }
        assert!(stage.reads("all runs: CPU, f32 · 32 × 32"), "{}", stage.read_out());
        for own in ["grid · compact · robust", "bvh · compact · robust", "grid · first · paper"] {
            assert!(stage.reads(own), "{own} at {size:?}: {}", stage.read_out());
        }
        // The note is in the menu of actions, and beside the options.
        stage.click(Role::Button, "actions: bvh compact robust");
        stage.settle();
        stage.get(Role::TextInput, "note on bvh compact robust").focus();
        stage.frame();
        stage.text("slow");
        stage.settle();
        assert_eq!(stage.harness.state().kept_runs().list()[1].note, "slow");
        assert_eq!(stage.harness.unnamed_widgets(), Vec::<String>::new());
    }
}

/// The layout Compare without kept runs, and with three.
fn layout_compare(theme: egui::Theme, size: [f32; 2], name: &str) {
    let mut stage = Stage::new(Plan { size, theme, ..Plan::default() });
    open(&mut stage, settings());
    stage.arrange(Layout::Compare);
    stage.snapshot(&format!("runs-none-{name}"));
    for settings in three() {
        open(&mut stage, settings);
        stage.perform(Command::KeepRun);
    }
    // Until the message is gone.
    stage.frames(40);
    stage.snapshot(&format!("runs-compare-{name}"));
}

#[test]
fn the_layout_compare_with_kept_runs() {
    layout_compare(egui::Theme::Dark, [1280.0, 800.0], "dark");
}

#[test]
fn the_layout_compare_with_kept_runs_in_a_large_window() {
    layout_compare(egui::Theme::Light, [1600.0, 1000.0], "light");
}

#[test]
fn before_a_run_is_kept_there_is_a_start() {
    let mut stage = Stage::new(Plan::default());
    open(&mut stage, settings());
    stage.arrange(Layout::Compare);
    assert!(stage.reads("Keep two runs to see where they differ"), "{}", stage.read_out());
    stage.click(Role::Button, "Measure choices");
    stage.settle();
    assert!(stage.harness.state().panes_in_view().contains(&PaneKind::Choices));
    stage.perform(Command::Show(PaneKind::Runs));
    stage.click(Role::Button, "Keep this run");
    stage.settle();
    assert_eq!(stage.harness.state().kept_runs().list().len(), 1);
    assert!(!stage.reads("Keep two runs to see where they differ"), "{}", stage.read_out());
}

#[test]
fn the_panel_with_three_runs() {
    let mut stage = kept([1280.0, 800.0], &three());
    stage.arrange(Layout::Overview);
    stage.perform(Command::Show(PaneKind::Ray));
    stage.perform(Command::Show(PaneKind::Runs));
    stage.snapshot("runs-difference");
    stage.click(Role::Button, "Times");
    stage.settle();
    stage.click(Role::Button, "Measure 3 runs");
    stage.settle();
    assert_eq!(stage.harness.unnamed_widgets(), Vec::<String>::new());
    stage.snapshot("runs-times");
}
