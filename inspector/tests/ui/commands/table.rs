//! What each command needs, and how to tell that it worked.

use egui::Role;
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::link::Link;
use raystep_inspector::session_file::SessionFile;
use raystep_kernels::export::csv::COLUMNS;

use super::effects::{
    ask, assert_all, begin_lesson, begin_play, beside, bookmarks_around, choose_cornell, choose_kernel, choose_session,
    event, exposure, focused, is_ray_watched, is_shown, keep, layer, leave_lesson, moved_range, moved_view, nothing,
    open_session, over_a_texel, pixel_moved, play, range, remove_bookmarks, replace_kernel, same_kernel, show_passes,
    show_watches, shown, slice, sort_rays, watch_the_ray, zoomed,
};
use super::files::{drawing, file, saved};
use super::layouts::{arranged, arranged_own, elsewhere, hide_the_ray, save_layouts, saved_layout, the_ray_is_back};
use super::{Before, PIXEL};
use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

type Prepare = fn(&mut Stage) -> f64;
type Check = fn(&mut Stage, &Before);

/// A row of the table.
pub(super) struct Row {
    /// Prepares the command; returns the number that it changes, if any.
    pub(super) prepare: Prepare,
    /// Fails if the command did not have its effect.
    pub(super) check: Check,
}

/// The row of a command; a command without one does not compile.
pub(super) fn row(command: Command) -> Row {
    use Command as C;
    let (prepare, check): (Prepare, Check) = match command {
        C::OpenScene => (choose_cornell, |s, was| {
            s.settle();
            assert_eq!(s.harness.state().model().generation, was.generation + 1);
        }),
        C::ReloadScene => (nothing, |s, was| {
            s.settle();
            assert_eq!(s.harness.state().model().generation, was.generation + 1);
            assert_eq!((s.place(), s.harness.state().pixel()), (was.place, was.pixel));
        }),
        C::ReplaceKernel => (choose_kernel, |s, was| {
            s.settle();
            let model = s.harness.state().model();
            assert_eq!((model.generation, model.place), (was.generation + 1, was.place));
            assert_eq!(model.opened.as_ref().expect("a run").plan.replaced().len(), 1);
        }),
        C::BuiltInKernels => (replace_kernel, |s, was| {
            s.settle();
            let model = s.harness.state().model();
            assert_eq!((model.generation, model.place), (was.generation + 1, was.place));
            assert!(model.opened.as_ref().expect("a run").plan.replaced().is_empty());
        }),
        C::CopyLink => (nothing, |s, was| {
            s.settle();
            let link: Link = s.heard.copied.last().expect("a link was copied").parse().expect("a link");
            assert_eq!((link.scene.as_deref(), link.pass), (Some(CORNELL), Some(was.place)));
            assert!(link.to_string().contains("pixel=40,44"), "{link}");
        }),
        C::PasteLink => (nothing, |s, was| {
            s.answer(&format!("raystep:1?scene={CORNELL}&size=32x32&pixel=3,4&pass=7"));
            assert_eq!((s.place(), s.harness.state().pixel()), (7, Some([3, 4])));
            assert!(s.harness.state().model().generation > was.generation);
        }),
        C::Export => (nothing, |s, _| {
            s.settle();
            s.click(Role::Button, Command::ExportPasses.name());
            s.settle();
            assert_eq!(saved(s, ".passes.csv").len(), 1);
        }),
        C::ExportPasses => (nothing, |s, was| {
            let bytes = file(s, ".passes.csv");
            let mut reader = csv::Reader::from_reader(bytes.as_slice());
            assert_eq!(reader.headers().expect("a header").iter().collect::<Vec<_>>(), *COLUMNS);
            let rows: Vec<_> = reader.records().map(|row| row.expect("a row")).collect();
            assert_all(s, was, rows.len(), "rows");
        }),
        C::ExportTrace => (nothing, |s, was| {
            let json: serde_json::Value = serde_json::from_slice(&file(s, ".trace.json")).expect("JSON");
            let events = json["traceEvents"].as_array().expect("events");
            assert_all(s, was, events.iter().filter(|event| event["cat"] == "pass").count(), "passes");
        }),
        C::ExportExr => (nothing, |s, _| {
            let bytes = file(s, ".exr");
            assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01]);
            assert!(bytes.len() > 1000, "{}", bytes.len());
        }),
        C::ExportNpy => (nothing, |s, _| {
            let bytes = file(s, ".npy");
            assert_eq!(&bytes[..6], b"\x93NUMPY");
            assert_eq!(bytes.len() % (64 * 64 * 4), 128, "a header and whole layers: {}", bytes.len());
        }),
        C::ExportRay => (nothing, |s, _| {
            let bytes = file(s, ".csv");
            let mut reader = csv::Reader::from_reader(bytes.as_slice());
            let rows = s.harness.state().model().history.as_ref().expect("a history").rows.len();
            assert_eq!(reader.records().count(), rows);
            assert!(rows > 10, "{rows}");
        }),
        C::ExportTexels => (nothing, |s, _| {
            let picture = image::load_from_memory(&file(s, "Stream.png")).expect("a PNG").to_rgba8();
            assert_eq!(picture.dimensions(), (64, 64));
            // However large it is shown, the view has the same pixels in the same colours.
            s.perform(C::ExportView);
            let view =
                image::load_from_memory(&saved(s, "Stream.png").pop().expect("a view")).expect("a PNG").to_rgba8();
            let side = view.width().min(view.height());
            let corner = [(view.width() - side) / 2, (view.height() - side) / 2];
            for (x, y, texel) in picture.enumerate_pixels() {
                let at = |corner: u32, texel: u32| corner + (2 * texel + 1) * side / 128;
                assert_eq!(view.get_pixel(at(corner[0], x), at(corner[1], y)), texel, "at {x},{y}");
            }
        }),
        C::ExportView => (nothing, |s, _| {
            let picture = image::load_from_memory(&file(s, "Stream.png")).expect("a PNG").to_rgba8();
            let colors: std::collections::HashSet<_> = picture.pixels().map(|p| p.0).collect();
            assert!(colors.len() > 2 && picture.width() > 100, "{} colours", colors.len());
        }),
        C::ExportWalk => (nothing, |s, _| drawing(s, PaneKind::Walk2d)),
        C::ExportDataflow => (nothing, |s, _| drawing(s, PaneKind::Dataflow)),
        C::Quit => (nothing, |s, _| {
            s.settle();
            assert!(s.heard.is_closed);
        }),

        C::NextPass => (nothing, |s, was| {
            s.settle();
            assert_eq!(s.place(), was.place + 1);
        }),
        C::PreviousPass => (nothing, |s, was| {
            s.settle();
            assert_eq!(s.place(), was.place - 1);
        }),
        C::NextOfKernel => (nothing, |s, was| same_kernel(s, was, true)),
        C::PreviousOfKernel => (nothing, |s, was| same_kernel(s, was, false)),
        C::NextEvent => (nothing, |s, was| event(s, was, true)),
        C::PreviousEvent => (nothing, |s, was| event(s, was, false)),
        C::IterationEnd => (nothing, |s, was| {
            s.settle();
            let end = s.place();
            assert!(end > was.place, "{end}");
            s.perform(Command::NextPass);
            let passes = &s.harness.state().model().passes;
            assert_ne!(passes[end].iteration, passes[end - 1].iteration, "not the end of an iteration");
        }),
        C::IterationStart => (nothing, |s, was| {
            s.settle();
            assert!(s.place() < was.place, "{}", s.place());
        }),
        C::Start => (nothing, |s, _| {
            s.settle();
            assert_eq!(s.place(), 0);
        }),
        C::End => (nothing, |s, _| {
            s.settle();
            assert_eq!(s.harness.state().model().next, None);
            assert!(s.place() > 30, "{}", s.place());
        }),
        C::RunToWatch => (watch_the_ray, |s, was| {
            s.settle();
            assert!(s.place() > was.place && s.reads("state"), "{}", s.place());
        }),
        C::RunBackToWatch => (watch_the_ray, |s, was| {
            s.settle();
            assert!(s.place() < was.place && s.place() > 0, "{}", s.place());
        }),
        C::ToggleWatch => (show_watches, |s, was| {
            s.settle();
            assert_eq!(is_ray_watched(s), was.number == 0.0);
            s.perform(Command::ToggleWatch);
        }),
        C::ToggleBookmark => (show_passes, |s, was| {
            s.settle();
            let flag = format!("{} •", was.place - 1);
            assert!(s.paints(&flag), "{:?}", s.painted());
            s.perform(Command::ToggleBookmark);
            assert!(!s.paints(&flag));
        }),
        C::NextBookmark => (bookmarks_around, |s, was| {
            s.settle();
            assert_eq!(s.place(), was.place + 1);
            remove_bookmarks(s, Command::PreviousBookmark);
        }),
        C::PreviousBookmark => (bookmarks_around, |s, was| {
            s.settle();
            assert_eq!(s.place(), was.place - 1);
            remove_bookmarks(s, Command::NextBookmark);
        }),
        C::Play => (nothing, |s, was| {
            let place = was.place;
            s.until("three passes are played", |s| s.place() >= place + 3);
            s.perform(Command::Cancel);
        }),
        C::Cancel => (play, |s, _| {
            s.settle();
            let place = s.place();
            s.frames(5);
            s.settle();
            assert_eq!(s.place(), place, "it did not pause");
            assert!(s.harness.state().model().next.is_some(), "it played to the end");
        }),

        C::GoToPixel => (nothing, |s, _| {
            s.answer("3,4");
            assert_eq!(s.harness.state().pixel(), Some([3, 4]));
        }),
        C::TypeRay => (nothing, |s, _| {
            s.answer("0.5,0.5,3,0,0,-1");
            let opened = s.harness.state().model().opened.as_ref().expect("a run");
            assert_eq!(opened.settings.ray, "0.5,0.5,3,0,0,-1".parse().ok());
            assert_eq!(opened.plan.rays, 1);
        }),
        C::NudgeLeft => (nothing, |s, _| pixel_moved(s, [-1, 0])),
        C::NudgeRight => (nothing, |s, _| pixel_moved(s, [1, 0])),
        C::NudgeUp => (nothing, |s, _| pixel_moved(s, [0, -1])),
        C::NudgeDown => (nothing, |s, _| pixel_moved(s, [0, 1])),
        C::PreviousRayByCost | C::NextRayByCost => (sort_rays, |s, was| {
            s.settle();
            is_shown(s, PaneKind::Cost);
            assert_ne!(s.harness.state().pixel(), was.pixel);
        }),
        C::EditTexel => (nothing, |s, was| {
            s.answer("2");
            let edits = &s.harness.state().model().edits;
            assert_eq!(edits.len(), 1, "{edits:?}");
            assert_eq!((edits[0].place, [edits[0].x, edits[0].y], edits[0].bits), (was.place, PIXEL, 2));
        }),

        C::ExposureUp => (exposure, |s, was| {
            s.settle();
            assert_eq!(s.number("exposure"), 2.0 * was.number);
            s.perform(Command::ResetRange);
        }),
        C::ExposureDown => (exposure, |s, was| {
            s.settle();
            assert_eq!(s.number("exposure"), 0.5 * was.number);
            s.perform(Command::ResetRange);
        }),
        C::OffsetUp => (range, |s, was| {
            s.settle();
            assert!(s.number("from") > was.number);
            s.perform(Command::ResetRange);
        }),
        C::OffsetDown => (range, |s, was| {
            s.settle();
            assert!(s.number("from") < was.number);
            s.perform(Command::ResetRange);
        }),
        C::Normalise | C::ResetRange => (moved_range, |s, was| {
            s.settle();
            assert_eq!(s.number("from"), was.number);
        }),
        C::Fit => (zoomed, |s, _| {
            s.settle();
            s.get(Role::Button, "fit");
        }),
        C::FrameWalk => (moved_view, |s, _| {
            s.settle();
            is_shown(s, PaneKind::Walk3d);
            assert!(!s.reads("view moved by hand"), "{}", s.read_out());
        }),
        C::PaintScene => (nothing, |s, _| {
            s.settle();
            is_shown(s, PaneKind::Walk3d);
            assert!(s.reads("tests are of"), "{}", s.read_out());
        }),
        C::SecondWalk => (nothing, |s, _| {
            s.settle();
            is_shown(s, PaneKind::Walk2d);
            assert!(s.reads("A grid: ") && s.reads("B bvh: "), "{}", s.read_out());
        }),
        C::Magnifier => (over_a_texel, |s, was| {
            s.settle();
            let bits = || s.painted().iter().filter(|text| text.starts_with("0x")).count();
            assert_eq!(bits() > 0, was.number == 0.0);
            s.perform(Command::Magnifier);
        }),
        C::Pin => (nothing, |s, was| {
            s.settle();
            s.get(Role::Button, &format!("state after {}", was.place));
        }),
        C::NextSlice => (
            |s| slice(s, Command::PreviousSlice),
            |s, was| {
                s.settle();
                assert_eq!(layer(s), was.number + 1.0);
            },
        ),
        C::PreviousSlice => (
            |s| slice(s, Command::NextSlice),
            |s, was| {
                s.settle();
                assert_eq!(layer(s), was.number - 1.0);
            },
        ),
        C::SliceAxis => (nothing, |s, _| {
            s.settle();
            is_shown(s, PaneKind::Structure);
            assert!(s.reads("perpendicular to x"), "{}", s.read_out());
        }),
        C::Theme => (nothing, |s, was| {
            s.settle();
            assert_ne!(s.harness.ctx.global_style().visuals.dark_mode, was.is_dark);
        }),
        C::LargerText => (nothing, |s, was| {
            s.settle();
            assert!(s.harness.ctx.zoom_factor() > was.zoom);
            s.perform(Command::NormalText);
        }),
        C::SmallerText => (nothing, |s, was| {
            s.settle();
            assert!(s.harness.ctx.zoom_factor() < was.zoom);
            s.perform(Command::NormalText);
        }),
        C::NormalText => (
            |s| {
                s.perform(Command::SmallerText);
                0.0
            },
            |s, was| {
                s.settle();
                assert_eq!((was.zoom, s.harness.ctx.zoom_factor()), (0.9, 1.0));
            },
        ),
        C::ToolbarWords => (
            |s| {
                assert!(s.paints("Previous event"));
                0.0
            },
            |s, _| {
                s.settle();
                assert!(!s.paints("Previous event"));
                s.perform(Command::ToolbarWords);
            },
        ),
        C::Maximise => (nothing, |s, was| {
            s.settle();
            assert_eq!((was.panes.len(), s.harness.state().panes_in_view().len()), (4, 1));
            s.get(Role::Button, "Restore layout");
            s.perform(Command::Maximise);
            assert_eq!(s.harness.state().panes_in_view(), was.panes);
        }),
        C::NextPanel => (nothing, |s, _| {
            s.settle();
            assert_eq!(focused(s).as_deref(), Some("Stream panel"));
        }),
        C::PreviousPanel => (nothing, |s, _| {
            s.settle();
            assert_eq!(focused(s).as_deref(), Some("Ray panel"));
        }),
        C::NextTab | C::PreviousTab => (beside, |s, was| {
            s.settle();
            assert!(was.panes.contains(&PaneKind::Log));
            is_shown(s, PaneKind::Passes);
        }),
        C::Arrange(_) => (elsewhere, arranged),
        C::ArrangeOwn(_) => (save_layouts, arranged_own),
        C::SaveLayout => (nothing, saved_layout),
        C::ResetLayout => (hide_the_ray, the_ray_is_back),
        C::Show(_) => (nothing, |s, was| {
            s.settle();
            let now = s.harness.state().panes_in_view();
            let changed = PaneKind::ALL.iter().filter(|kind| now.contains(kind) != was.panes.contains(kind));
            let changed: Vec<_> = changed.collect();
            // A panel opens as a tab beside the widest panel and hides it.
            assert!(changed.iter().any(|kind| Command::Show(**kind) == was.command), "{changed:?}");
            assert!(changed.len() <= 2, "{changed:?}");
        }),

        C::Compare => (nothing, |s, was| {
            s.settle();
            shown(s, was, PaneKind::Compare);
            s.get(Role::Image, "hit of run B");
        }),
        C::EndCompare => (
            |s| {
                s.perform(Command::Compare);
                0.0
            },
            |s, _| {
                s.settle();
                assert!(s.find(Role::Image, |name| name == "hit of run B").is_none());
                assert!(s.reads("Run the scene a second time"));
            },
        ),
        C::Divergence => (nothing, |s, was| {
            s.settle();
            shown(s, was, PaneKind::Divergence);
            assert!(s.find(Role::Image, |name| name.contains(" rays")).is_some());
        }),

        C::NextBranch | C::PreviousBranch => (nothing, |s, was| {
            s.settle();
            is_shown(s, PaneKind::Kernel);
            // From the deciding branch to another one.
            assert!(s.reads("taken: line ") && !s.reads("deciding:"), "{:?}: {}", was.command, s.read_out());
        }),
        C::MaskBranch => (
            |s| {
                s.arrange(Layout::Step);
                0.0
            },
            |s, _| {
                s.settle();
                let rays = s.harness.state().model().last_pass().expect("a pass").rays_in;
                assert!(s.reads(&format!(" of {rays} rays")), "{}", s.read_out());
                s.click(Role::Button, "Remove mask");
                s.settle();
            },
        ),

        C::Judge => (nothing, |s, was| {
            s.settle();
            shown(s, was, PaneKind::Error);
            assert!(s.reads(" of 4,096 judged rays wrong"), "{}", s.read_out());
        }),

        C::Measure => (nothing, |s, was| {
            s.settle();
            shown(s, was, PaneKind::Choices);
            assert!(s.reads("bvh, fused, robust is fastest"), "{}", s.read_out());
        }),

        C::OpenSession => (choose_session, |s, was| {
            s.settle();
            assert_eq!(s.harness.state().model().generation, was.generation + 1);
            assert_eq!((s.place(), s.harness.state().pixel()), (5, Some([3, 4])));
        }),
        C::SaveSession => (nothing, |s, was| {
            let session = SessionFile::from_bytes(&file(s, ".raystep-session")).expect("a session");
            assert_eq!(session.here.link.pass, Some(was.place));
        }),
        C::KeepRun => (nothing, |s, was| {
            s.settle();
            assert!(s.paints("kept as \"grid compact robust"), "{:?}", s.painted());
            assert_eq!(s.place(), was.place);
        }),
        C::RunKept => (open_session, |s, _| {
            s.settle();
            let kept = &s.harness.state().kept_runs().list()[0];
            let outcome = kept.outcome.as_ref().expect("it has run");
            assert!(outcome.passes.len() > 30 && kept.picture.is_ok(), "{}", outcome.passes.len());
        }),
        C::NextRun => (keep, |s, _| {
            s.settle();
            let label = "compact robust";
            let is_label = |text: &String| text.starts_with("kept run ") && text.contains(label);
            assert!(s.painted().iter().any(is_label), "{:?}", s.painted());
            s.perform(Command::PreviousRun);
            assert!(!s.painted().iter().any(is_label));
        }),
        C::PreviousRun => (keep, |s, was| {
            s.settle();
            let label = format!("kept run {} of {}: ", was.number, was.number);
            assert!(s.paints(&label), "{label}: {:?}", s.painted());
            s.perform(Command::NextRun);
            assert!(!s.paints(&label));
        }),
        C::NextDifferingRay => (keep, |s, _| {
            s.settle();
            assert!(s.paints("no ray differs in triangle"), "{:?}", s.painted());
        }),

        C::Palette => (nothing, |s, _| {
            s.frames(3);
            s.get(Role::TextInput, "command");
        }),
        C::Help => (nothing, |s, _| {
            s.frames(3);
            assert!(s.reads("In pictures"));
        }),
        C::Lesson(_) => (nothing, |s, was| {
            s.settle();
            assert!(s.reads("step 1 of"));
            assert!(s.harness.state().model().generation > was.generation);
        }),
        C::NextStep => (begin_lesson, |s, _| {
            s.settle();
            assert_eq!(s.harness.state().lesson_step().map(|(step, _)| step), Some(2));
        }),
        C::PreviousStep => (begin_lesson, |s, _| {
            s.settle();
            assert_eq!(s.harness.state().lesson_step().map(|(step, _)| step), Some(0));
        }),
        C::RepeatStep => (leave_lesson, |s, was| {
            s.settle();
            assert_ne!(s.harness.state().pixel(), was.pixel, "the ray of the lesson is not selected again");
        }),
        C::Choose(_) => (ask, |s, was| {
            s.settle();
            let wanted = if was.command == Command::Choose(2) { "Right." } else { "Not right." };
            assert!(s.reads(wanted), "{:?}\n{}", was.command, s.read_out());
        }),
        C::SkipPlay => (begin_play, |s, was| {
            s.settle();
            assert!(s.place() > was.place);
            assert!(s.reads("5 of 5 iterations"), "{}", s.read_out());
        }),
        C::CloseLesson => (begin_lesson, |s, was| {
            s.settle();
            assert_eq!(s.harness.state().lesson_step(), None);
            assert_ne!(s.harness.state().panes_in_view(), was.panes, "the panels of the lesson stay");
        }),
    };
    Row { prepare, check }
}
