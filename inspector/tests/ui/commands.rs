//! Every command, performed once in each available way: by key, by menu, by palette.

mod effects;
mod files;
mod layouts;
mod table;

use std::collections::HashSet;

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{COMMANDS, Command, CommandInfo, Layout, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;
use raystep_kernels::Kernel;

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

/// The pixel that is selected before every command.
const PIXEL: [u32; 2] = [40, 44];
const PLACE: usize = 12;

/// State of the window before a command.
struct Before {
    command: Command,
    place: usize,
    kernel: Option<Kernel>,
    pixel: Option<[u32; 2]>,
    generation: u64,
    panes: Vec<PaneKind>,
    is_dark: bool,
    zoom: f32,
    /// A number shown in the view that the command changes, if it changes one.
    number: f64,
}

fn look(stage: &Stage, command: Command, number: f64) -> Before {
    let inspector = stage.harness.state();
    let model = inspector.model();
    Before {
        command,
        place: model.place,
        kernel: model.last_pass().map(|pass| pass.kernel),
        pixel: inspector.pixel(),
        generation: model.generation,
        panes: inspector.panes_in_view(),
        is_dark: stage.harness.ctx.global_style().visuals.dark_mode,
        zoom: stage.harness.ctx.zoom_factor(),
        number,
    }
}

fn settings() -> Settings {
    Settings { size: [64, 64], ..Settings::default() }
}

/// Restores the window before each command. If the scene or the run was changed, opens it anew.
fn set(stage: &mut Stage) {
    let inspector = stage.harness.state();
    let model = inspector.model();
    let is_usual = model.opened.as_ref().is_some_and(|o| o.settings == settings() && o.scene.name == "cornell-box");
    if !is_usual || !model.edits.is_empty() || inspector.pixel() != Some(PIXEL) || model.place != PLACE {
        let arrival = Arrival { pixel: Some(PIXEL), place: Some(PLACE), ..Arrival::default() };
        stage.open(CORNELL, settings(), arrival);
    }
    stage.perform(Command::EndCompare);
    stage.arrange(Layout::Overview);
    stage.desk.lock().expect("not poisoned").saved.clear();
    stage.heard = Default::default();
    assert_eq!((stage.place(), stage.harness.state().pixel()), (PLACE, Some(PIXEL)));
}

/// Closes whatever a command has opened.
fn clear(stage: &mut Stage) {
    for _ in 0..2 {
        stage.key(Modifiers::NONE, Key::Escape);
        stage.frames(2);
    }
    stage.perform(Command::CloseLesson);
    stage.settle();
}

fn by_keys(stage: &mut Stage, info: &CommandInfo) -> bool {
    let Some(&(modifiers, key)) = info.keys.first() else { return false };
    stage.key(modifiers, key);
    true
}

fn by_menu(stage: &mut Stage, info: &CommandInfo) -> bool {
    let menu = stage.nodes().into_iter().find(|node| {
        let is_at_the_top = node.accesskit_node().bounding_box().is_some_and(|b| b.y0 < 12.0);
        let node = node.accesskit_node();
        is_at_the_top && node.role() == Role::Button && node.label().is_some_and(|l| l == info.menu.name())
    });
    let before: HashSet<_> = stage.nodes().iter().map(|node| node.accesskit_node().id()).collect();
    menu.unwrap_or_else(|| panic!("no menu {}\n{}", info.menu.name(), stage.read_out())).click_accesskit();
    stage.frames(3);
    let keys = info.command.key_text(&stage.harness.ctx);
    let full = format!("{} {keys}", info.name);
    let full = full.trim_end();
    let item = stage.nodes().into_iter().find(|node| {
        let node = node.accesskit_node();
        let is_named = node.label().is_some_and(|label| label.trim_end() == full);
        !before.contains(&node.id()) && node.role() == Role::Button && is_named
    });
    let item = item.unwrap_or_else(|| panic!("no item {full:?} in {}\n{}", info.menu.name(), stage.read_out()));
    assert!(!item.accesskit_node().is_disabled(), "{:?} cannot be chosen", info.command);
    item.click_accesskit();
    stage.frame();
    true
}

fn by_palette(stage: &mut Stage, info: &CommandInfo) -> bool {
    stage.key(Modifiers::COMMAND, Key::P);
    stage.frames(2);
    stage.text(info.name);
    stage.frames(2);
    stage.key(Modifiers::NONE, Key::Enter);
    true
}

/// A way to perform a command; false if the command does not have it.
type Leads = fn(&mut Stage, &CommandInfo) -> bool;

const WAYS: [(&str, Leads); 3] = [("key", by_keys), ("menu", by_menu), ("palette", by_palette)];

/// Performs every command in the chosen way; returns how many could be performed.
fn all(chosen: impl Fn(usize) -> (&'static str, Leads)) -> usize {
    let mut stage = Stage::with_scene(CORNELL, settings(), Arrival::default());
    let mut count = 0;
    for (i, info) in COMMANDS.iter().enumerate() {
        let (way, leads) = chosen(i);
        let row = table::row(info.command);
        println!("{way}: {}", info.name);
        set(&mut stage);
        let number = (row.prepare)(&mut stage);
        let before = look(&stage, info.command, number);
        if leads(&mut stage, info) {
            count += 1;
            (row.check)(&mut stage, &before);
        }
        clear(&mut stage);
    }
    count
}

/// In the three ways in turn; commands without a key, in the other two.
#[test]
fn every_command_has_an_effect() {
    let way = |i: usize| if COMMANDS[i].keys.is_empty() { WAYS[1 + i % 2] } else { WAYS[i % 3] };
    assert_eq!(all(way), COMMANDS.len());
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn every_command_has_an_effect_by_its_key() {
    let with_keys = COMMANDS.iter().filter(|info| !info.keys.is_empty()).count();
    assert_eq!(all(|_| WAYS[0]), with_keys);
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn every_command_has_an_effect_by_its_menu() {
    assert_eq!(all(|_| WAYS[1]), COMMANDS.len());
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn every_command_has_an_effect_by_its_name_in_the_palette() {
    assert_eq!(all(|_| WAYS[2]), COMMANDS.len());
}

#[test]
fn second_keys_do_the_same() {
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(PLACE), ..Arrival::default() };
    let mut stage = Stage::with_scene(CORNELL, settings(), arrival);
    stage.key(Modifiers::COMMAND, Key::ArrowRight);
    stage.settle();
    assert_eq!(stage.place(), PLACE + 1);
    stage.key(Modifiers::COMMAND, Key::ArrowLeft);
    stage.settle();
    assert_eq!(stage.place(), PLACE);
}

#[test]
fn text_fields_keep_their_own_keys() {
    let arrival = Arrival { pixel: Some(PIXEL), place: Some(PLACE), ..Arrival::default() };
    let mut stage = Stage::with_scene(CORNELL, settings(), arrival);
    stage.perform(Command::GoToPixel);
    for key in [Key::Space, Key::N, Key::P, Key::ArrowLeft, Key::Home, Key::End] {
        stage.key(Modifiers::NONE, key);
    }
    stage.settle();
    assert_eq!((stage.place(), stage.harness.state().pixel()), (PLACE, Some(PIXEL)));
}
