//! A kernel of the user's, dropped onto the window and saved again: the run follows at the same place, and a mistake stops
//! nothing.

use std::path::Path;
use std::sync::Arc;

use egui::{Role, Theme};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;
use raystep_inspector::ui::host::HostEvent;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::programs::closest_hit::kernels::INTERSECT;

use super::desk::CORNELL;
use super::stage::{Plan, Stage};

const FILE: &str = "work/my-kernel.wgsl";

#[derive(Debug)]
struct Dropped;

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        Path::new(FILE)
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the host reads it".into())
    }
}

fn changed(from: &str, to: &str) -> Vec<u8> {
    let own = INTERSECT.info().wgsl;
    assert!(own.contains(from), "{from}");
    own.replacen(from, to, 1).into_bytes()
}

/// Drops the kernel.
fn drop_kernel(stage: &mut Stage, source: Vec<u8>) {
    stage.desk.lock().expect("not poisoned").sessions = vec![(FILE.into(), source)];
    stage.harness.input_mut().dropped_files.push(Arc::new(Dropped));
    stage.frame();
    stage.settle();
}

/// Saves the kernel in an editor.
fn save(stage: &mut Stage, source: Vec<u8>) {
    stage.desk.lock().expect("not poisoned").events.push(HostEvent::Read { path: FILE.into(), bytes: source });
    stage.frame();
    stage.settle();
}

fn stage(theme: Theme) -> Stage {
    let mut stage = Stage::new(Plan { size: [760.0, 420.0], theme, ..Plan::default() });
    let settings = Settings { size: [48, 48], ..Settings::default() };
    stage.open(CORNELL, settings, Arrival { pixel: Some([20, 22]), place: Some(11), ..Arrival::default() });
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::Kernel));
    stage
}

fn hits(stage: &Stage) -> usize {
    let pass = stage.harness.state().model().last_pass().expect("a pass");
    pass.counts.iter().sum::<u32>() as usize
}

fn replaced(stage: &Stage) -> Vec<String> {
    let opened = stage.harness.state().model().opened.clone().expect("a run");
    opened.plan.replaced().iter().map(|own| own.kernel.clone()).collect()
}

fn follows(theme: Theme, name: &str) {
    let mut stage = stage(theme);
    let generation = stage.harness.state().model().generation;
    drop_kernel(&mut stage, changed("tag = ISECT_HIT", "tag = SHADE"));
    assert_eq!((replaced(&stage), stage.place()), (vec!["intersect".to_owned()], 11));
    assert_eq!(stage.harness.state().model().generation, generation + 1);
    assert!(stage.paints("from my-kernel.wgsl"), "{:?}", stage.painted());
    let before = hits(&stage);

    // A mistake: the run stays, and the panel says where it is.
    save(&mut stage, changed("item += 1u;", "item += 1u\n    oops;"));
    assert_eq!((stage.harness.state().model().generation, stage.place()), (generation + 1, 11));
    let error = stage.harness.state().last_error().unwrap_or_default().to_owned();
    assert!(error.starts_with("work/my-kernel.wgsl:") && error.contains("expected"), "{error}");
    assert!(stage.paints("The version before it still runs."), "{:?}", stage.painted());
    assert_eq!((replaced(&stage).len(), hits(&stage)), (1, before));
    stage.snapshot(name);

    // Mended: it is used, and the message goes.
    save(&mut stage, changed("item += 1u;", "item += 1u; // as it was"));
    assert_eq!((stage.harness.state().model().generation, stage.place()), (generation + 2, 11));
    assert!(!stage.paints("The version before it still runs."));
    // The same text once more changes nothing.
    save(&mut stage, changed("item += 1u;", "item += 1u; // as it was"));
    assert_eq!(stage.harness.state().model().generation, generation + 2);

    // What the command line named may have another ending.
    let before = stage.harness.state().model().opened.clone().expect("a run").settings.clone();
    let named = Replacement { file: "my.txt".into(), ..Replacement::clone(&before.replaced[0]) };
    stage.inspector().plan(Settings { replaced: vec![Arc::new(named)], ..before });
    stage.settle();
    let bytes = changed("item += 1u;", "item += 1u; // saved");
    stage.desk.lock().expect("not poisoned").events.push(HostEvent::Read { path: "my.txt".into(), bytes });
    stage.frame();
    stage.settle();
    let own = stage.harness.state().model().opened.clone().expect("a run").plan.replaced();
    assert!(own[0].source.contains("// saved") && own[0].kernel == "intersect" && own[0].file == "my.txt");

    stage.click(Role::Button, Command::BuiltInKernels.name());
    stage.settle();
    assert_eq!((replaced(&stage).len(), stage.place()), (0, 11));
}

#[test]
fn a_run_follows_a_kernel_that_is_saved_and_stays_if_it_is_wrong_on_dark() {
    follows(Theme::Dark, "own-kernel-dark");
}

#[test]
fn a_run_follows_a_kernel_that_is_saved_and_stays_if_it_is_wrong_on_light() {
    follows(Theme::Light, "own-kernel-light");
}

#[test]
fn a_kernel_that_does_not_end_fits_nothing_or_is_no_text_leaves_the_run_as_it_is() {
    let mut stage = stage(Theme::Dark);
    let generation = stage.harness.state().model().generation;
    let endless = changed(
        "    let ray = load_ray(texel);",
        "    var n = 1u; while (n > 0u) { n ^= 2u; }\n    let ray = load_ray(texel);",
    );
    for (source, why) in [
        (endless, "a loop has not ended after "),
        (changed("fn intersect(", "fn intersects("), "no kernel is named intersects"),
        (b"fn helper() {}".to_vec(), "no @compute function"),
        (vec![0xff; 9], "not a text in UTF-8"),
        (vec![b' '; (1 << 20) + 1], "larger than 1 MiB"),
    ] {
        drop_kernel(&mut stage, source);
        let error = stage.harness.state().last_error().unwrap_or_default().to_owned();
        assert!(error.contains(FILE) && error.contains(why), "{error}: not {why}");
        assert_eq!((stage.harness.state().model().generation, stage.place()), (generation, 11), "{why}");
        assert_eq!(replaced(&stage).len(), 0);
    }
    // The device is still there.
    stage.perform(Command::NextPass);
    assert_eq!(stage.place(), 12);
}

#[test]
fn rays_that_a_users_kernel_treats_otherwise_are_those_that_diverge() {
    let mut stage = stage(Theme::Dark);
    drop_kernel(&mut stage, changed("bitcast<u32>(candidate.u)", "bitcast<u32>(candidate.v)"));
    stage.perform(Command::Divergence);
    stage.settle();
    assert!(stage.paints("First in pass "), "{:?}", stage.painted());
    let told = stage.painted().into_iter().find(|text| text.starts_with("First in pass ")).expect("the first ray");
    assert!(told.contains("intersect") && told.contains("hit.u is ") && told.contains(", expected "), "{told}");
    stage.click(Role::Button, "Go there");
    stage.settle();
    let pass = stage.harness.state().model().last_pass().expect("a pass");
    assert!(told.contains(&format!("pass {}", pass.index)), "{told}: pass {}", pass.index);
}
