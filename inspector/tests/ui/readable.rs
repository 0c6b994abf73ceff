//! Text can be read: its size and contrast as drawn, in every panel and both themes; no text is cut off, or lies over
//! another one.

mod ink;
mod overlap;

use std::collections::HashSet;

use egui::{Role, Theme};
use raystep_inspector::command::{Command, Layout, Menu, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};
pub(crate) use ink::contrast;
use ink::{contrast_of, cut, disabled, inks};
use overlap::overlapping;

/// Contrast of normal text (WCAG 2.1, 1.4.3, level AA).
const LEAST_CONTRAST: f64 = 4.5;
/// Smallest text, in points.
const SMALLEST: f32 = 11.0;

fn open(stage: &mut Stage) {
    let settings = Settings { size: [64, 64], device: DeviceKind::Cpu, ..Settings::default() };
    stage.open(CORNELL, settings, Arrival { pixel: Some([40, 44]), place: Some(35), ..Arrival::default() });
}

/// Shows a panel as its command does, with something in it.
fn show(stage: &mut Stage, kind: PaneKind) {
    if stage.harness.state().panes_in_view().contains(&kind) {
        return;
    }
    match kind {
        PaneKind::Compare => stage.perform(Command::Compare),
        PaneKind::Divergence => stage.perform(Command::Divergence),
        PaneKind::Error => stage.perform(Command::Judge),
        PaneKind::Choices => stage.perform(Command::Measure),
        kind => stage.perform(Command::Show(kind)),
    }
}

/// Texts of the last frame that are too small or too pale.
fn pale(stage: &Stage) -> HashSet<String> {
    let (disabled, beneath) = (disabled(stage), stage.draw_without_text());
    let points = stage.harness.ctx.pixels_per_point();
    let mut found = HashSet::new();
    for ink in inks(stage) {
        if ink.size < SMALLEST && ink.rows.iter().any(|row| row.intersects(ink.clip)) {
            found.insert(format!("{:?}: {} points", ink.text, ink.size));
        }
        for run in &ink.runs {
            if disabled.iter().any(|rect| rect.expand(1.0).contains(run.rect.center())) {
                continue;
            }
            if let Some(ratio) = contrast_of(run, &ink, &beneath, points).filter(|ratio| *ratio < LEAST_CONTRAST) {
                found.insert(format!("{:?}: {:?} has {ratio:.2}:1 at {:?}", ink.text, run.color, run.rect));
            }
        }
    }
    found
}

/// Every state of the window that is looked at: all panels, all menus, all dialogs.
fn everywhere(stage: &mut Stage, mut look: impl FnMut(&mut Stage, &str)) {
    look(stage, "welcome");
    open(stage);
    look(stage, "overview");
    let picture = stage.find(Role::Image, |name| name.starts_with("state after")).expect("the stream");
    let at = picture.rect().center();
    stage.event(egui::Event::PointerMoved(at));
    stage.event(egui::Event::Zoom(15.0));
    stage.event(egui::Event::PointerGone);
    stage.settle();
    look(stage, "values in texels");
    for &kind in PaneKind::ALL {
        stage.arrange(Layout::Overview);
        show(stage, kind);
        look(stage, &format!("{kind:?}"));
    }
    for menu in Menu::ALL {
        stage.click(Role::Button, menu.name());
        stage.frames(3);
        look(stage, &format!("menu {}", menu.name()));
        stage.key(egui::Modifiers::NONE, egui::Key::Escape);
        stage.settle();
    }
    for command in [
        Command::Palette,
        Command::Help,
        Command::GoToPixel,
        Command::TypeRay,
        Command::PasteLink,
        Command::EditTexel,
        Command::Export,
        Command::Lesson(0),
    ] {
        stage.perform(command);
        stage.frames(3);
        look(stage, &format!("{command:?}"));
        stage.key(egui::Modifiers::NONE, egui::Key::Escape);
        stage.settle();
    }
    stage.perform(Command::CloseLesson);
    for layout in Layout::ALL {
        stage.arrange(layout);
        look(stage, &format!("layout {layout:?}"));
    }
    stage.arrange(Layout::Step);
    stage.perform(Command::Maximise);
    look(stage, "maximised");
}

#[track_caller]
fn report(found: &[(String, HashSet<String>)]) {
    let lines = found.iter().flat_map(|(place, found)| found.iter().map(move |text| format!("{place}: {text}")));
    let lines: Vec<_> = lines.collect();
    assert!(lines.is_empty(), "{} texts:\n{}", lines.len(), lines.join("\n"));
}

fn all_text_can_be_read(theme: Theme) {
    let mut stage = Stage::new(Plan { theme, size: [1280.0, 720.0], ..Plan::default() });
    stage.settle();
    let mut found = Vec::new();
    everywhere(&mut stage, |stage, place| found.push((place.to_owned(), pale(stage))));
    report(&found);
}

#[test]
fn all_text_can_be_read_in_the_dark_theme() {
    all_text_can_be_read(Theme::Dark);
}

#[test]
fn all_text_can_be_read_in_the_light_theme() {
    all_text_can_be_read(Theme::Light);
}

/// Elided texts whose full text does not appear when they are hovered over.
fn without_hover(stage: &mut Stage) -> HashSet<String> {
    let window = stage.harness.ctx.content_rect();
    let elided = inks(stage).into_iter().filter(|ink| ink.is_elided);
    let places: Vec<_> = elided
        .filter_map(|ink| {
            let row = ink.rows.first()?.intersect(ink.clip).intersect(window);
            row.is_positive().then(|| (ink.text, row.center()))
        })
        .collect();
    let mut found = HashSet::new();
    let mut seen = HashSet::new();
    for (text, at) in places {
        if !seen.insert(text.clone()) {
            continue;
        }
        stage.event(egui::Event::PointerMoved(at));
        stage.frames(3);
        if inks(stage).iter().filter(|ink| !ink.is_elided && ink.text.contains(&text)).count() == 0 {
            found.insert(format!("{text:?} at {at:?} has no hover text"));
        }
        stage.event(egui::Event::PointerGone);
        stage.frames(2);
    }
    found
}

/// Texts that are cut off, or lie over each other, in one of the themes.
fn unreadable(stage: &mut Stage) -> HashSet<String> {
    let mut found = HashSet::new();
    for theme in [Theme::Light, Theme::Dark] {
        stage.harness.ctx.set_theme(theme);
        stage.frames(2);
        found.extend(cut(stage).into_iter().chain(overlapping(stage)).map(|text| format!("{theme:?}: {text}")));
    }
    found
}

/// A window of 1280 by 720 pixels at this scale: no text is cut off, and none lies over another one.
fn all_text_is_apart(scale: f32) {
    let size = [1280.0 / scale, 720.0 / scale];
    let mut stage = Stage::new(Plan { scale, size, ..Plan::default() });
    for theme in [Theme::Dark, Theme::Light] {
        stage.harness.ctx.style_mut_of(theme, |style| {
            style.interaction.tooltip_delay = 0.0;
            style.interaction.show_tooltips_only_when_still = false;
        });
    }
    stage.settle();
    let mut found = Vec::new();
    everywhere(&mut stage, |stage, place| {
        found.push((place.to_owned(), unreadable(stage)));
        // With less room, layouts put texts over other things than at 1.
        if scale > 1.0 && place.starts_with("layout") {
            for theme in [Theme::Light, Theme::Dark] {
                stage.harness.ctx.set_theme(theme);
                stage.frames(2);
                found.push((format!("{place}, {theme:?}"), pale(stage)));
            }
        }
        if !place.starts_with("menu") && !place.starts_with("Lesson") {
            found.push((place.to_owned(), without_hover(stage)));
        }
    });
    for &kind in PaneKind::ALL {
        stage.arrange(Layout::Step);
        show(&mut stage, kind);
        found.push((format!("{kind:?} in the step layout"), unreadable(&mut stage)));
    }
    report(&found);
}

#[test]
fn no_text_is_cut_off_or_over_another_at_1x() {
    all_text_is_apart(1.0);
}

#[test]
fn no_text_is_cut_off_or_over_another_at_1_5x() {
    all_text_is_apart(1.5);
}

#[test]
fn no_text_is_cut_off_or_over_another_at_2x() {
    all_text_is_apart(2.0);
}
