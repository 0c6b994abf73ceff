//! Exports: everything is exported unless less was chosen, and the outcome is always shown.

use std::sync::atomic::{AtomicU64, Ordering};

use egui::{Key, Modifiers, Role};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::{AdapterChoice, Gpu};

use crate::ui::adapter::block_on;
use crate::ui::desk::{CORNELL, Dialogs, NO_DIALOG, TRIANGLE};
use crate::ui::stage::{Plan, Stage};

const PLACE: usize = 12;

fn stage() -> Stage {
    stage_of([32, 32])
}

fn stage_of(size: [u32; 2]) -> Stage {
    let settings = Settings { size, device: DeviceKind::Cpu, ..Settings::default() };
    let mut stage = Stage::new(Plan { size: [600.0, 400.0], ..Plan::default() });
    stage.open(CORNELL, settings, Arrival { place: Some(PLACE), ..Arrival::default() });
    stage
}

fn dialogs(stage: &Stage, dialogs: Dialogs) {
    stage.desk.lock().expect("not poisoned").dialogs = dialogs;
}

/// Number of rows of each saved table.
fn rows(stage: &Stage) -> Vec<usize> {
    let desk = stage.desk.lock().expect("not poisoned");
    desk.saved.iter().map(|file| csv::Reader::from_reader(file.bytes.as_slice()).records().count()).collect()
}

#[track_caller]
fn says(stage: &Stage, text: &str) {
    assert!(stage.paints(text), "{text:?} is not among {:?}", stage.painted());
}

#[test]
fn passes_are_exported_up_to_here_only_if_that_is_chosen() {
    let mut stage = stage();
    stage.perform(Command::Export);
    stage.frames(2);
    assert!(stage.reads("the whole run; its remaining passes run first") && stage.reads("Passes: a row per pass"));
    stage.click(Role::RadioButton, "up to here: 12 passes");
    stage.frame();
    assert!(stage.reads("Passes: 12 rows"), "{}", stage.read_out());
    stage.click(Role::Button, Command::ExportPasses.name());
    stage.settle();
    says(&stage, "12 rows written to cornell-box.passes.csv");
    // The choice applies to one export only.
    stage.perform(Command::ExportPasses);
    stage.perform(Command::End);
    assert_eq!(rows(&stage), [PLACE, stage.place()]);
    assert!(stage.place() > PLACE + 20);
}

/// A column of the last saved table.
fn column(stage: &Stage, name: &str) -> Vec<String> {
    let desk = stage.desk.lock().expect("not poisoned");
    let mut csv = csv::Reader::from_reader(desk.saved.last().expect("a file").bytes.as_slice());
    let at = csv.headers().expect("heads").iter().position(|head| head == name).expect("a column");
    csv.records().map(|row| row.expect("a row")[at].to_owned()).collect()
}

#[test]
fn passes_have_what_each_of_them_counted_and_the_clocks() {
    let mut stage = stage();
    stage.perform(Command::ExportPasses);
    assert_eq!(stage.place(), PLACE, "an export does not move the view");
    let numbers = |stage: &Stage, name: &str| -> Vec<u64> {
        column(stage, name).iter().map(|field| field.parse().unwrap_or_else(|_| panic!("{name}: {field:?}"))).collect()
    };
    let names = ["cells_visited", "triangles_tested", "rays_in", "duration_ns", "host_run_ns", "sample"];
    let all = names.map(|name| numbers(&stage, name));
    let [cells, tests, rays, duration, host, sample] = &all;
    let kernels = column(&stage, "kernel");
    for (i, kernel) in kernels.iter().enumerate() {
        let counted = [cells[i], tests[i]];
        match kernel.as_str() {
            "intersect" => assert!(counted[0] == 0 && counted[1] <= rays[i], "pass {i}: {counted:?}"),
            "traverse_grid" => assert!(counted[0] <= rays[i] && counted[1] == 0, "pass {i}: {counted:?}"),
            "generate" | "shade" => assert_eq!(counted, [0, 0], "pass {i}"),
            _ => {}
        }
    }
    assert!(tests.iter().sum::<u64>() > 1024 && sample.iter().all(|&sample| sample == 0));
    assert!(host.iter().all(|&ns| ns == duration.iter().sum::<u64>()), "on the CPU, one clock times all");
    // As far as here, the same.
    stage.perform(Command::Export);
    stage.frames(2);
    stage.click(Role::RadioButton, "up to here: 12 passes");
    stage.frame();
    stage.click(Role::Button, Command::ExportPasses.name());
    stage.settle();
    for (name, all) in names.iter().zip(&all).take(3) {
        assert_eq!(numbers(&stage, name), all[..PLACE], "{name}");
    }
}

#[test]
fn the_rays_rows_are_counted_and_predicted_ones_are_said() {
    let mut stage = stage();
    let history = stage.inspector().model().history.clone().expect("a history");
    let here = history.rows.iter().filter(|row| row.is_within(PLACE)).count();
    let all = history.rows.len();
    assert!(0 < here && here < all);
    stage.perform(Command::ExportRay);
    says(&stage, &format!("{all} rows ({} of them predicted) written to", all - here));
    stage.perform(Command::Export);
    stage.frames(2);
    stage.click(Role::RadioButton, "up to here: 12 passes");
    stage.frame();
    assert!(stage.reads(&format!(": {here} rows")), "{}", stage.read_out());
    stage.click(Role::Button, Command::ExportRay.name());
    stage.settle();
    assert_eq!(rows(&stage), [all, here]);
}

/// A clock with which no adapter's timestamps agree.
fn counting() -> u64 {
    static CALLS: AtomicU64 = AtomicU64::new(0);
    CALLS.fetch_add(1, Ordering::Relaxed)
}

#[test]
fn an_adapter_without_valid_times_has_none_in_any_panel_or_file() {
    let settings = Settings { size: [32, 32], device: DeviceKind::Gpu, ..Settings::default() };
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter");
    block_on(&gpu, gpu.check_clock(counting)).expect("a device");
    let mut stage = Stage::new(Plan { size: [900.0, 700.0], gpu, ..Plan::default() });
    stage.open(CORNELL, settings, Arrival::picture());
    let model = stage.inspector().model();
    let why = model.opened.as_ref().and_then(|opened| opened.why_no_times.clone()).expect("a reason");
    assert!(model.passes.iter().all(|pass| pass.duration_ns.is_none() && pass.begin_ns.is_none()));
    stage.close_panels();
    let is_time = |text: &String| {
        let units = ["µs", "ms", "s"].map(|unit| format!(" {unit}"));
        let has_number = |before: &str| before.ends_with(|c: char| c.is_ascii_digit());
        units.iter().any(|unit| text.strip_suffix(unit.as_str()).is_some_and(has_number))
    };
    use PaneKind as P;
    for kind in [P::Passes, P::Timings, P::Timeline, P::Error, P::Cost, P::Plan, P::Dataflow] {
        stage.perform(Command::Show(kind));
        // The host's time is said to be the host's.
        let painted: Vec<String> = stage.painted().into_iter().filter(|text| is_time(text)).collect();
        assert_eq!(painted, Vec::<String>::new(), "{kind:?}");
        if kind == P::Timings {
            says(&stage, &why);
            says(&stage, "by the host's clock");
        }
        stage.perform(Command::Show(kind));
    }
    stage.perform(Command::ExportPasses);
    let desk = stage.desk.lock().expect("not poisoned");
    let mut csv = csv::Reader::from_reader(desk.saved[0].bytes.as_slice());
    let heads = csv.headers().expect("heads").clone();
    let column = |name: &str| heads.iter().position(|head| head == name).expect("a column");
    let (duration, begin, valid) = (column("duration_ns"), column("begin_ns"), column("valid"));
    let rows: Vec<csv::StringRecord> = csv.records().map(|row| row.expect("a row")).collect();
    assert!(rows.len() > 30);
    assert!(rows.iter().all(|row| (&row[duration], &row[begin], &row[valid]) == ("", "", "false")), "{:?}", rows[3]);
}

#[test]
fn pass_timings_are_exported_by_a_key_and_save() {
    let mut stage = stage();
    dialogs(&stage, Dialogs::Missing);
    stage.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    stage.settle();
    assert!(rows(&stage).is_empty());
    stage.click(Role::Button, "Save");
    stage.settle();
    says(&stage, "rows written to /here/cornell-box.passes.csv");
    assert_eq!(rows(&stage).len(), 1);
}

#[test]
fn what_is_cancelled_is_said() {
    // So many rays that the run cannot end before it is cancelled.
    let mut stage = stage_of([512, 512]);
    stage.inspector().perform(Command::ExportPasses);
    stage.inspector().perform(Command::Cancel);
    stage.settle();
    says(&stage, "cancelled: nothing written");
    assert_eq!((stage.place(), rows(&stage).len()), (PLACE, 0));
    let mut stage = self::stage();
    dialogs(&stage, Dialogs::Cancel);
    stage.perform(Command::ExportPasses);
    says(&stage, "cancelled: nothing written");
    stage.perform(Command::OpenScene);
    says(&stage, "cancelled: no scene opened");
    assert_eq!(rows(&stage).len(), 0);
}

#[test]
fn where_there_are_no_dialogs_the_window_asks_for_a_path() {
    let mut stage = stage();
    dialogs(&stage, Dialogs::Missing);
    stage.perform(Command::End);
    let all = stage.place();
    stage.perform(Command::ExportPasses);
    says(&stage, NO_DIALOG);
    stage.snapshot("dialog-path");
    stage.key(Modifiers::NONE, Key::Enter);
    stage.settle();
    says(&stage, &format!("{all} rows written to /here/cornell-box.passes.csv"));
    // The same name again: asks before replacing the file.
    stage.perform(Command::ExportPasses);
    stage.key(Modifiers::NONE, Key::Enter);
    stage.settle();
    says(&stage, "it is there already");
    assert_eq!(rows(&stage), [all]);
    stage.click(Role::CheckBox, "replace an existing file");
    stage.frame();
    stage.click(Role::Button, "Save");
    stage.settle();
    assert_eq!(rows(&stage), [all, all]);
    // If the dialog is cancelled, nothing is written.
    stage.perform(Command::ExportPasses);
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    says(&stage, "cancelled: nothing written");
    assert_eq!(rows(&stage), [all, all]);
    // Open a scene by its path.
    let generation = stage.inspector().model().generation;
    stage.perform(Command::OpenScene);
    stage.key(Modifiers::COMMAND, Key::A);
    stage.answer(CORNELL);
    assert_eq!(stage.inspector().model().generation, generation + 1);
    stage.perform(Command::OpenScene);
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    says(&stage, "cancelled: no scene opened");
}

#[test]
fn auto_is_the_twins_where_the_adapter_is_software() {
    let plan = Plan::default();
    let wanted = if plan.gpu.is_software() { DeviceKind::Cpu } else { DeviceKind::Gpu };
    let mut stage = Stage::new(plan);
    let device = |stage: &mut Stage| stage.inspector().model().opened.as_ref().map(|o| o.settings.device);
    stage.perform(Command::PasteLink);
    stage.answer(&format!("raystep:1?scene={CORNELL}&size=32x32&pixel=3,4&pass=7"));
    assert_eq!(device(&mut stage), Some(wanted), "by a link");
    stage.perform(Command::PasteLink);
    stage.answer(&format!("raystep:1?scene={CORNELL}&size=32x32&device=gpu&pixel=3,4&pass=7"));
    assert_eq!(device(&mut stage), Some(DeviceKind::Gpu), "by a link that says it");
    let mut stage = Stage::new(Plan::default());
    stage.desk.lock().expect("not poisoned").choice = Some(TRIANGLE.into());
    stage.perform(Command::OpenScene);
    assert_eq!(device(&mut stage), Some(wanted), "by a dialog");
}
