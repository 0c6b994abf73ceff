//! The branch that decided, in the kernel panel, and the rays that took it, over the image.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::programs::closest_hit::kernels;
use raystep_kernels::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT};
use raystep_kernels::{Choices, Pass, ScheduleKind};
use raystep_lab::human::grouped;

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

/// After the first pass of `intersect` in which some lists have ended, with the kernel beside the stream.
fn stage(settings: Settings) -> Stage {
    let settings = Settings {
        size: [48, 40],
        choices: Choices { schedule: ScheduleKind::Second, ..settings.choices },
        ..settings
    };
    let mut stage =
        Stage::with_scene(CORNELL, settings, Arrival { pixel: Some([24, 30]), place: Some(3), ..Arrival::default() });
    stage.arrange(Layout::Step);
    if !stage.harness.state().panes_in_view().contains(&PaneKind::Kernel) {
        stage.perform(Command::Show(PaneKind::Kernel));
    }
    assert_eq!(stage.harness.state().model().last_pass().map(|pass| pass.kernel), Some(kernels::INTERSECT));
    stage
}

/// Rays whose list has not ended in a pass of `intersect`.
fn staying(pass: &Pass) -> u32 {
    pass.counts[ISECT_NO_HIT as usize] + pass.counts[ISECT_HIT as usize]
}

/// The line about the branch in view.
fn branch(stage: &Stage) -> String {
    let text = |node: &egui_kittest::Node<'_>| node.accesskit_node().label().or(node.accesskit_node().value());
    let found = stage.nodes().iter().filter_map(text).find(|text| text.starts_with("Branch "));
    found.unwrap_or_else(|| panic!("no branch:\n{}", stage.read_out()))
}

/// Selects a condition by its text, by going through the branches that the ray reached.
fn go_to(stage: &mut Stage, condition: &str) {
    for _ in 0..40 {
        if branch(stage).ends_with(&format!(": {condition}")) {
            return;
        }
        stage.key(Modifiers::NONE, Key::F7);
        stage.settle();
    }
    panic!("no branch {condition}:\n{}", stage.read_out());
}

#[test]
fn the_rays_that_took_a_branch_are_those_that_left_the_state() {
    for device in [DeviceKind::Gpu, DeviceKind::Cpu] {
        let mut stage = stage(Settings { device, ..Settings::default() });
        assert!(stage.reads("deciding"), "{}", stage.read_out());
        // To a pass of this ray in which some lists have ended, and others have not.
        for _ in 0..40 {
            let model = stage.harness.state().model();
            let has_row = model.history.as_ref().is_some_and(|l| l.rows.iter().any(|r| r.place() == Some(model.place)));
            let some = model.last_pass().filter(|pass| has_row && pass.kernel == kernels::INTERSECT);
            if some.is_some_and(|pass| (1..pass.rays_in).contains(&staying(pass))) {
                break;
            }
            stage.perform(Command::NextPass);
        }
        go_to(&mut stage, "ended");
        stage.key(Modifiers::COMMAND, Key::F7);
        stage.settle();
        let model = stage.harness.state().model();
        let pass = model.last_pass().expect("a pass").clone();
        let stay = staying(&pass);
        let taken = u64::from(pass.rays_in - stay);
        // Beside the line of the condition, too.
        assert!(stage.reads(&format!(" of {}: {taken} true", pass.rays_in)), "{}", stage.read_out());
        let text = format!("{} of {} rays took this branch", grouped(taken), pass.rays_in);
        assert!((1..pass.rays_in).contains(&stay) && stage.reads(&text), "{text}:\n{}", stage.read_out());
        // The run is where it was, and so it is with an edited texel: one ray fewer.
        let place = model.place;
        stage.perform(Command::PreviousPass);
        stage.perform(Command::EditTexel);
        stage.answer("7");
        stage.perform(Command::NextPass);
        assert_eq!(stage.place(), place);
        let after = stage.harness.state().model().last_pass().expect("a pass").clone();
        assert_eq!(after.rays_in, pass.rays_in - 1);
        stage.inspector().perform(Command::NudgeLeft);
        stage.settle();
        stage.perform(Command::MaskBranch);
        assert!(stage.reads(&format!(" of {} rays", after.rays_in)), "{}", stage.read_out());
        assert_eq!(stage.place(), place);
        stage.click(Role::Button, "Remove mask");
        stage.settle();
        assert!(stage.find(Role::Button, |name| name == "Remove mask").is_none());
    }
}

#[test]
fn the_listing_shows_the_branch_that_decided_with_its_values() {
    let mut stage = stage(Settings { device: DeviceKind::Cpu, ..Settings::default() });
    // Whatever decided, its line and what it compared are in view.
    let first = branch(&stage);
    assert!(first.contains(", deciding: line ") && stage.reads("▸ "), "{}", stage.read_out());
    assert!(stage.reads("in f64: "), "{}", stage.read_out());
    stage.key(Modifiers::NONE, Key::F7);
    stage.settle();
    let second = branch(&stage);
    assert_ne!(second, first);
    stage.key(Modifiers::SHIFT, Key::F7);
    stage.settle();
    assert_eq!(branch(&stage), first);
    // The same in the kernel's own files, with what the plan omits.
    assert!(!stage.reads("@if("));
    stage.click(Role::Button, "file");
    stage.settle();
    assert!(stage.reads("@if(") && stage.reads("▸ "), "{}", stage.read_out());
}

#[test]
fn a_maximised_stream_stays_when_rays_of_a_branch_are_shown_over_it() {
    let mut stage = stage(Settings { device: DeviceKind::Cpu, ..Settings::default() });
    let in_view = |stage: &Stage| stage.harness.state().panes_in_view();
    stage.perform(Command::MaskBranch);
    stage.click(Role::Button, "Remove mask");
    stage.settle();
    stage.perform(Command::Maximise);
    if in_view(&stage) != [PaneKind::Stream] {
        stage.perform(Command::Show(PaneKind::Stream));
    }
    assert_eq!(in_view(&stage), [PaneKind::Stream]);
    stage.perform(Command::MaskBranch);
    assert_eq!(in_view(&stage), [PaneKind::Stream]);
    stage.get(Role::Button, "Remove mask");
    // Another branch is seen in the kernel's source.
    stage.perform(Command::NextBranch);
    assert_eq!(in_view(&stage), [PaneKind::Kernel]);
}

/// The sentence of the mask of the branch in view.
fn masked(stage: &mut Stage) -> String {
    stage.perform(Command::MaskBranch);
    stage.settle();
    let text = |node: &egui_kittest::Node<'_>| node.accesskit_node().label().or(node.accesskit_node().value());
    let found = stage.nodes().iter().filter_map(text).find(|text| text.contains(" took this branch"));
    found.unwrap_or_else(|| panic!("no mask:\n{}", stage.read_out()))
}

#[test]
fn where_f64_decides_otherwise_it_is_said_whether_a_hit_changes() {
    let mut stage = stage(Settings { device: DeviceKind::Cpu, ..Settings::default() });
    let mut told = Vec::new();
    for _ in 0..30 {
        let first = branch(&stage);
        for _ in 0..20 {
            told.push(masked(&mut stage));
            stage.key(Modifiers::NONE, Key::F7);
            stage.settle();
            if branch(&stage) == first {
                break;
            }
        }
        if told.iter().any(|text| text.contains("otherwise")) {
            break;
        }
        stage.perform(Command::NextEvent);
    }
    let others: Vec<_> = told.iter().filter(|text| text.contains("otherwise")).collect();
    assert!(!others.is_empty(), "{told:?}");
    for text in others {
        assert!(["no hit changes", "hit changes.", "hits change."].iter().any(|end| text.contains(end)), "{text}");
    }
}

#[test]
fn an_element_that_a_pass_does_not_have_is_told() {
    let settings = Settings {
        size: [16, 12],
        choices: Choices { program: raystep_kernels::options::ProgramName::GridBuild, ..Choices::stepped() },
        ..Settings::default()
    };
    let stage = Stage::with_scene(CORNELL, settings, Arrival { place: Some(3), ..Arrival::default() });
    assert_eq!(stage.harness.state().layout(), "Step");
    assert!(stage.reads("this pass has 1 column and 1 row, and no element at "), "{}", stage.read_out());
}

#[test]
fn elements_that_stop_at_a_line_are_counted_and_the_run_goes_to_the_next_pass_with_one() {
    let mut stage = stage(Settings { device: DeviceKind::Cpu, ..Settings::default() });
    let pass = stage.place() - 1;
    let line =
        kernels::INTERSECT.info().wgsl.lines().position(|line| line.contains("if (candidate.is_hit && accepted)"));
    let line = line.expect("the line") + 1;
    let told = |stage: &Stage| {
        let text = |node: &egui_kittest::Node<'_>| node.accesskit_node().label().or(node.accesskit_node().value());
        let found = stage.nodes().iter().filter_map(text).find(|text| text.contains(" come here, "));
        found.unwrap_or_else(|| panic!("nothing is told:\n{}", stage.read_out()))
    };
    let count = |text: &str| text.rsplit(' ').next().and_then(|word| word.replace(',', "").parse::<u64>().ok());
    stage.fill("Stop at", &format!("intersect.wgsl:{line}"));
    stage.fill("when", "candidate.is_hit && accepted");
    stage.click(Role::Button, "next pass");
    stage.settle();
    let model = stage.harness.state().model();
    assert_eq!(model.last_pass().map(|pass| pass.kernel), Some(kernels::INTERSECT));
    assert!(stage.place() > pass + 1);
    let next = told(&stage);
    let begin = format!("pass {}, intersect, intersect.wgsl:{line}: ", stage.place() - 1);
    assert!(next.starts_with(&begin) && next.contains("candidate.is_hit && accepted holds for "), "{next}");
    assert!(count(&next) > Some(0) && stage.reads(" at this line"), "{next}");

    // As many as the branch has; the mask is then the branch's.
    let is_place =
        |name: &str| name.split_once(',').is_some_and(|(x, y)| x.parse::<u32>().and(y.parse::<u32>()).is_ok());
    let first = stage.find(Role::Button, is_place).and_then(|node| node.accesskit_node().label()).expect("an element");
    stage.click(Role::Button, &first);
    stage.settle();
    go_to(&mut stage, "candidate.is_hit && accepted");
    let branch = masked(&mut stage);
    assert!(branch.starts_with(&format!("{} of ", grouped(count(&next).expect("a number")))), "{branch} {next}");
    stage.click(Role::Button, "this pass");
    stage.settle();
    assert_eq!(told(&stage), next);
    stage.click(Role::Button, "Remove mask");

    for (field, text, wrong) in [
        ("when", "candidate.is_hot", "condition, column 11: "),
        (
            "Stop at",
            "intersect.wgsl:1",
            "intersect.wgsl:1: no statement of intersect begins in this line; the next is in line ",
        ),
        ("Stop at", "other.wgsl:7", "other.wgsl: intersect has no such file; its files are intersect.wgsl, "),
        ("Stop at", "here", "here: expected a line, such as intersect.wgsl:20"),
    ] {
        stage.fill(field, text);
        stage.click(Role::Button, "this pass");
        stage.settle();
        assert!(stage.reads(wrong), "{wrong}:\n{}", stage.read_out());
    }
    // None stops: the run stays where it is.
    let place = stage.place();
    stage.fill("Stop at", &line.to_string());
    stage.fill("when", "candidate.t < -1.0");
    stage.click(Role::Button, "next pass");
    stage.settle();
    assert!(stage.reads("No element stops from here on, of "), "{}", stage.read_out());
    assert_eq!(stage.place(), place);
}
