//! The timeline: dragging, scales, the ray's events, bookmarks, thumbnails, keys.

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Role, pos2};
use egui_kittest::kittest::NodeT as _;
use image::RgbaImage;
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::Choices;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

const PIXEL: [u32; 2] = [40, 44];

fn settings(device: DeviceKind) -> Settings {
    Settings { size: [64, 64], device, ..Settings::default() }
}

/// 21 passes in six stages.
pub(crate) fn sort(device: DeviceKind) -> Settings {
    let choices = Choices { program: raystep_kernels::options::ProgramName::Sort, elements: 64, ..Choices::stepped() };
    Settings { choices, device, ..Settings::default() }
}

/// To the second pass of a turn after so many.
pub(crate) fn into_turn(stage: &mut Stage, turns: usize) {
    stage.perform(Command::Start);
    (0..turns).for_each(|_| stage.perform(Command::IterationEnd));
    (0..2).for_each(|_| stage.perform(Command::NextPass));
}

/// The layout Step, at a place.
fn stage(settings: Settings, place: usize) -> Stage {
    let mut stage = Stage::new(Plan::default());
    stage.arrange(Layout::Step);
    // The kernel's panel names a pass too.
    stage.perform(Command::Show(PaneKind::Ray));
    stage.open(CORNELL, settings, Arrival { pixel: Some(PIXEL), place: Some(place), ..Arrival::default() });
    stage
}

fn timeline(stage: &Stage) -> Rect {
    stage.find(Role::Slider, |name| name.contains("known passes")).expect("a timeline").rect()
}

fn name(stage: &Stage) -> String {
    let node = stage.find(Role::Slider, |name| name.contains("known passes")).expect("a timeline");
    node.accesskit_node().label().expect("a name")
}

fn button(stage: &mut Stage, pos: Pos2, button: PointerButton, pressed: bool) {
    stage.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
}

/// Moves the cursor there; what it shows about it has its size after a frame.
fn hover(stage: &mut Stage, pos: Pos2) {
    stage.event(Event::PointerMoved(pos));
    stage.frame();
}

/// The place under the cursor, as the window says it.
fn under_cursor(stage: &Stage) -> Option<usize> {
    let texts = stage.painted();
    if texts.iter().any(|text| text == "before the first pass") {
        return Some(0);
    }
    let pass = texts.iter().find_map(|text| text.strip_prefix("pass ")?.split_once(": ")?.0.parse::<usize>().ok());
    pass.map(|pass| pass + 1)
}

/// The stream as it is drawn.
fn picture(stage: &mut Stage) -> RgbaImage {
    stage.event(Event::PointerGone);
    stage.settle();
    let place = stage.place();
    let end = format!("after {place} pass");
    let rect = stage.find(Role::Image, |name| name.contains(&end)).expect("the stream").rect().shrink(1.0);
    let whole = stage.harness.render().expect("it can be drawn");
    let [x, y, width, height] = [rect.left(), rect.top(), rect.width(), rect.height()].map(|side| side as u32);
    image::imageops::crop_imm(&whole, x, y, width, height).to_image()
}

#[test]
fn dragging_ends_at_the_place_under_the_cursor_with_its_picture() {
    for device in [DeviceKind::Gpu, DeviceKind::Cpu] {
        let mut s = stage(settings(device), usize::MAX);
        let end = s.place();
        let rect = timeline(&s);
        let y = rect.center().y;
        let mut met = Vec::new();
        for (from, to) in [(0.95, 0.3), (0.3, 0.55), (0.55, -0.1)] {
            let x = |part: f32| rect.left() + 40.0 + part * (rect.width() - 46.0);
            s.event(Event::PointerMoved(pos2(x(from), y)));
            button(&mut s, pos2(x(from), y), PointerButton::Primary, true);
            for i in 1..=30 {
                s.event(Event::PointerMoved(pos2(x(from + (to - from) * i as f32 / 30.0), y)));
                // The playhead is where the cursor is, wherever the run is.
                let under = under_cursor(&s).expect("a pass is named");
                assert!(name(&s).starts_with(&format!("after {under} of")), "{under}: {}", name(&s));
            }
            let under = under_cursor(&s).expect("a pass is named");
            button(&mut s, pos2(x(to), y), PointerButton::Primary, false);
            s.settle();
            assert_eq!(s.place(), under, "from {from} to {to} on {device:?}");
            met.push(under);
            let shown = picture(&mut s);
            let mut other = stage(settings(device), under);
            let expected = picture(&mut other);
            assert!(shown == expected, "another picture after {under} passes on {device:?}");
        }
        assert!(met[0] > 5 && met[0] < met[1] && met[1] < end && met[2] == 0, "{met:?} of {end}");
    }
}

#[test]
fn passes_that_were_never_shown_have_thumbnails() {
    for device in [DeviceKind::Gpu, DeviceKind::Cpu] {
        let mut s = stage(settings(device), usize::MAX);
        let rect = timeline(&s);
        let mut places = Vec::new();
        for x in (50..rect.width() as i32 - 10).step_by(10) {
            hover(&mut s, pos2(rect.left() + x as f32, rect.center().y));
            let thumb = s.find(Role::Image, |name| name.starts_with("thumbnail after ")).expect("a thumbnail");
            let label = thumb.accesskit_node().label().expect("a name");
            places.push(label.split(' ').nth(2).and_then(|n| n.parse::<usize>().ok()).expect("a place"));
        }
        places.dedup();
        assert!(places.len() > 8 && places.is_sorted(), "{device:?}: {places:?}");
        assert_eq!(places.last(), Some(&s.place()), "the one that is shown");
        // It is the picture of that place: one where rays are in several states. Whether the first has a thumbnail depends
        // on how long passes take.
        let place = *places.iter().find(|&&place| place > 8).expect("a later place");
        let mut x = rect.left() + 40.0;
        let name = format!("thumbnail after {} passes", place);
        while s.find(Role::Image, |label| label == name).is_none() {
            x += 3.0;
            assert!(x < rect.right(), "{name} is not found again");
            hover(&mut s, pos2(x, rect.center().y));
        }
        s.frames(2);
        let thumb = s.get(Role::Image, &name).rect();
        let small = texels(&s.harness.render().expect("it can be drawn"), thumb);
        let mut other = stage(settings(device), place);
        let end = format!("after {} passes", place);
        // Thumbnails are of states, also where the stream shows cells as all rays are in one state.
        other.click(Role::Button, "tag");
        other.settle();
        let rect = other.find(Role::Image, |name| name.contains(&end)).expect("the stream").rect();
        let large = texels(&other.harness.render().expect("it can be drawn"), rect);
        let off = |a: [u8; 4], b: [u8; 4]| a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max();
        let is_marked = |i: usize| PIXEL[0].abs_diff(i as u32 % 64) < 4 && PIXEL[1].abs_diff(i as u32 / 64) < 4;
        let colors: std::collections::HashSet<_> = large.iter().collect();
        assert!(colors.len() > 2, "{device:?}: {} colours", colors.len());
        for (i, (a, b)) in small.iter().zip(&large).enumerate().filter(|(i, _)| !is_marked(*i)) {
            // Blending rounds by one, twice.
            assert!(off(*a, *b) <= Some(2), "{device:?}, {end}: texel {i} is {a:?} and not {b:?}");
        }
    }
}

/// The colours of 64 × 64 texels fitted into the middle of a rectangle.
fn texels(whole: &RgbaImage, rect: Rect) -> Vec<[u8; 4]> {
    let scale = rect.width().min(rect.height()) / 64.0;
    let origin = rect.center() - egui::Vec2::splat(32.0 * scale);
    let texels = (0..64 * 64).map(|i| [i % 64, i / 64].map(|at| at as f32 + 0.5));
    let at = texels.map(|[x, y]| origin + egui::vec2(x, y) * scale);
    at.map(|at| whole.get_pixel(at.x as u32, at.y as u32).0).collect()
}

#[test]
fn scales_change_what_is_under_the_cursor_and_are_saved() {
    let mut s = stage(settings(DeviceKind::Cpu), usize::MAX);
    let rect = timeline(&s);
    let first = pos2(rect.left() + 42.0, rect.center().y);
    hover(&mut s, first);
    assert_eq!(under_cursor(&s), Some(1), "the first pass is shown first");
    s.click(Role::CheckBox, "walk only");
    s.click(Role::CheckBox, "log");
    s.settle();
    assert!(name(&s).ends_with("by pass, logarithmic, walk only"), "{}", name(&s));
    hover(&mut s, first + egui::vec2(0.5, 0.0));
    assert_eq!(under_cursor(&s), Some(3), "generate and setup are hidden");
    s.click(Role::Button, "by device time");
    s.settle();
    assert!(name(&s).contains("by device time"), "{}", name(&s));
    s.inspector().keep();
    let saved = s.desk.lock().expect("not poisoned").remembered.clone();
    let mut other = Stage::new(Plan::default());
    other.inspector().restore(saved.as_bytes());
    other.open(CORNELL, settings(DeviceKind::Cpu), Arrival::picture());
    assert!(name(&other).ends_with("by device time, logarithmic, walk only"), "{}", name(&other));
}

#[test]
fn an_event_of_the_ray_is_named_and_a_click_goes_there() {
    let mut s = stage(settings(DeviceKind::Gpu), usize::MAX);
    let rect = timeline(&s);
    let lane = rect.top() + 8.0;
    let reads = |s: &Stage| s.painted().into_iter().find(|text| text.starts_with("the selected ray: triangle"));
    let mut x = rect.left() + 40.0;
    while reads(&s).is_none() {
        x += 3.0;
        assert!(x < rect.right(), "no event is named");
        hover(&mut s, pos2(x, lane));
    }
    let text = reads(&s).expect("an event");
    s.click_at(pos2(x, lane));
    s.settle();
    let place = s.place();
    let history = s.harness.state().model().history.clone().expect("a history");
    let row = history.rows.iter().find(|row| row.place() == Some(place)).expect("a pass of the ray");
    assert!(row.tested.is_some() && text.ends_with(&row.why), "{text}: {}", row.why);
}

#[test]
fn a_bookmark_is_a_flag_that_returns_is_renamed_kept_and_deleted() {
    let mut s = stage(settings(DeviceKind::Gpu), 12);
    s.key(Modifiers::COMMAND, Key::M);
    s.settle();
    s.perform(Command::End);
    s.perform(Command::NudgeLeft);
    let is_flag = |name: &str| name.starts_with("bookmark ");
    let flag = s.find(Role::Button, is_flag).expect("a flag");
    assert!(name(&s).contains("1 bookmark"), "{}", name(&s));
    let at = flag.rect().left_center() + egui::vec2(4.0, 0.0);
    s.click_at(at);
    s.settle();
    assert_eq!((s.place(), s.inspector().pixel()), (12, Some(PIXEL)), "its place and its ray");

    // Rename it.
    hover(&mut s, at);
    for pressed in [true, false] {
        button(&mut s, at, PointerButton::Secondary, pressed);
    }
    s.frames(3);
    s.get(Role::TextInput, "name").focus();
    s.frames(2);
    s.text(" here it turns");
    s.frames(2);
    s.key(Modifiers::NONE, Key::Enter);
    s.settle();
    s.event(Event::PointerGone);
    s.settle();
    let renamed =
        |s: &Stage| s.find(Role::Button, |name| name.starts_with("bookmark pass 11 here it turns:")).is_some();
    assert!(renamed(&s), "{}", s.read_out());
    assert_eq!(s.place(), 12);

    // It is there after the next start, and not in another scene.
    s.inspector().keep();
    let saved = s.desk.lock().expect("not poisoned").remembered.clone();
    let mut other = Stage::new(Plan::default());
    other.inspector().restore(saved.as_bytes());
    other.open(CORNELL, settings(DeviceKind::Gpu), Arrival::picture());
    assert!(renamed(&other), "{}", other.read_out());
    other.open(crate::ui::desk::TRIANGLE, settings(DeviceKind::Gpu), Arrival::picture());
    assert!(other.find(Role::Button, is_flag).is_none());
    other.open(CORNELL, settings(DeviceKind::Gpu), Arrival::picture());
    assert!(other.find(Role::Button, is_flag).is_none(), "dropped with its scene");

    // Delete it.
    for pressed in [true, false] {
        button(&mut s, at, PointerButton::Secondary, pressed);
    }
    s.frames(3);
    s.click(Role::Button, "Delete");
    s.settle();
    assert!(s.find(Role::Button, is_flag).is_none());
}

#[test]
fn a_turn_of_a_loop_is_named_and_clicks_go_to_its_first_pass_and_its_end() {
    let mut s = stage(sort(DeviceKind::Cpu), usize::MAX);
    into_turn(&mut s, 3);
    let rect = timeline(&s);
    assert!(name(&s).contains("pass 7: exchange, stage 3, step 1, processed"), "{}", name(&s));
    // Passes 10 to 14 of 21, in the band on top.
    let at = pos2(rect.left() + 40.0 + 12.5 / 21.0 * (rect.width() - 46.0), rect.top() + 6.0);
    hover(&mut s, at);
    for text in ["stage 4", "passes 10–14"] {
        assert!(s.painted().iter().any(|painted| painted == text), "no {text}: {:?}", s.painted());
    }
    assert!(s.paints("µs on the device"), "{:?}", s.painted());
    s.click_at(at);
    s.settle();
    assert_eq!(s.place(), 11, "its first pass");
    // The panel Passes, which is painted before, has them too.
    let band = s.painted().into_iter().filter(|text| text.starts_with("stage ")).collect::<Vec<_>>();
    assert_eq!(
        band[band.len().saturating_sub(6)..],
        ["stage 0", "stage 1", "stage 2", "stage 3", "stage 5", "stage 4"],
        "the current one last"
    );
    s.event(Event::PointerMoved(at));
    // A frame of the harness is a quarter of a second, and the time between two clicks at most 0.3 seconds.
    for _ in 0..2 {
        let click = |pressed| Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        s.harness.input_mut().events.extend([true, false].map(click));
        s.frame();
    }
    s.event(Event::PointerGone);
    s.settle();
    assert_eq!(s.place(), 15, "its end");
    // The band below: its steps are passes.
    s.click_at(at + egui::vec2(0.0, 14.0));
    s.settle();
    assert_eq!(s.place(), 13);
    s.perform(Command::IterationEnd);
    assert_eq!(s.place(), 15, "of the stage");
    // A run with one turn has no bands.
    let choices = Choices { schedule: raystep_kernels::ScheduleKind::Fused, ..Choices::stepped() };
    s.open(CORNELL, Settings { choices, ..settings(DeviceKind::Cpu) }, Arrival::picture());
    assert!(!name(&s).contains("iteration"), "{}", name(&s));
}

#[test]
fn with_the_focus_its_keys_move_by_passes() {
    let mut s = stage(settings(DeviceKind::Gpu), 12);
    let pixel = s.inspector().pixel();
    s.find(Role::Slider, |name| name.contains("known passes")).expect("a timeline").focus();
    s.frames(3);
    for (modifiers, key, place) in [
        (Modifiers::NONE, Key::ArrowLeft, 11),
        (Modifiers::NONE, Key::ArrowLeft, 10),
        (Modifiers::NONE, Key::ArrowRight, 11),
        (Modifiers::SHIFT, Key::ArrowLeft, 1),
        (Modifiers::SHIFT, Key::ArrowRight, 11),
        (Modifiers::SHIFT, Key::ArrowRight, 12),
        (Modifiers::NONE, Key::Home, 0),
    ] {
        s.key(modifiers, key);
        s.settle();
        assert_eq!((s.place(), s.inspector().pixel()), (place, pixel), "{key:?}");
    }
    s.key(Modifiers::NONE, Key::End);
    s.settle();
    assert_eq!(s.harness.state().model().next, None);
    let node = s.find(Role::Slider, |name| name.contains("known passes")).expect("a timeline");
    assert_eq!(node.accesskit_node().numeric_value(), Some(s.place() as f64));
}

#[test]
fn every_schedule_and_the_build_of_a_grid_can_be_scrubbed() {
    use raystep_kernels::options::ProgramName;
    use raystep_kernels::{Accelerator, ScheduleKind};
    let schedules = [ScheduleKind::First, ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused];
    let mut all: Vec<Settings> = schedules
        .into_iter()
        .flat_map(|schedule| {
            [Accelerator::Grid, Accelerator::Bvh, Accelerator::None].map(|accelerator| Settings {
                size: [16, 16],
                choices: Choices { schedule, accelerator, ..Choices::stepped() },
                ..Settings::default()
            })
        })
        .collect();
    all.push(Settings {
        choices: Choices { program: ProgramName::GridBuild, ..settings(DeviceKind::Gpu).choices },
        ..settings(DeviceKind::Gpu)
    });
    let mut s = Stage::new(Plan::default());
    s.arrange(Layout::Step);
    s.perform(Command::Show(PaneKind::Ray));
    for settings in all {
        let what = format!("{} {}", settings.choices.schedule, settings.choices.accelerator);
        s.open(CORNELL, settings, Arrival::picture());
        let end = s.place();
        let rect = timeline(&s);
        let at = pos2(rect.left() + 40.0 + 0.3 * (rect.width() - 46.0), rect.center().y);
        hover(&mut s, at);
        let under = under_cursor(&s).unwrap_or_else(|| panic!("{what}: no pass is named"));
        s.click_at(at);
        s.settle();
        assert_eq!(s.place(), under, "{what}");
        assert!(under > 0 && under <= end, "{what}: {under} of {end}");
        assert!(name(&s).contains(", processed "), "{}", name(&s));
        assert!(s.inspector().panes_in_view().contains(&PaneKind::Timeline));
    }
}
