//! The marks beside a kernel's source lines: every condition has an evaluation, and over whole traces the marks agree
//! with what the ray did.

use std::collections::BTreeSet;

use raystep_inspector::source::{Class, Line, Mark, composed, conditions_in, kernel_file, lines};
use raystep_kernels::export::trace::{RayState, ray_state};
use raystep_kernels::programs::closest_hit::states::STATES;
use raystep_kernels::programs::closest_hit::{PROGRAM, conditions, kernels};
use raystep_kernels::{Accelerator, Device, Keep, Kernel, Numerics, Options, Renderer, Samples, ScheduleKind};
use raystep_scenes::{Scene, generate};

use crate::data::common::options;

const STEPPED: [Kernel; 7] = {
    use kernels::{ACCUMULATE, GENERATE, INTERSECT, SETUP, SHADE, TRAVERSE_BVH, TRAVERSE_GRID};
    [GENERATE, SETUP, TRAVERSE_GRID, TRAVERSE_BVH, INTERSECT, SHADE, ACCUMULATE]
};

#[test]
fn every_condition_of_a_kernel_is_in_the_table_and_the_table_has_no_other() {
    for kernel in STEPPED {
        let found: BTreeSet<String> = conditions_in(kernel).expect("understood").into_iter().collect();
        let rows = || conditions::of(kernel).iter().map(|c| c.text.to_owned());
        assert_eq!(rows().collect::<BTreeSet<_>>(), found, "{kernel}", kernel = kernel.name());
        assert_eq!(rows().count(), found.len(), "{}: duplicate row", kernel.name());
    }
    for kernel in PROGRAM.kernels() {
        let found = conditions_in(kernel).expect("understood");
        for row in conditions::of(kernel) {
            assert!(found.iter().any(|text| text == row.text), "{}: {}", kernel.name(), row.text);
        }
    }
}

#[test]
fn every_branch_and_loop_of_every_file_is_found() {
    for kernel in PROGRAM.kernels() {
        let info = kernel.info();
        let words = lines(info.wgsl).into_iter().flat_map(|line| {
            let keywords = line.spans.iter().filter(|(_, class)| *class == Class::Keyword);
            keywords.map(|(range, _)| line.text[range.clone()].to_owned()).collect::<Vec<_>>()
        });
        let branching = ["if", "for", "while", "loop", "switch"];
        let count = words.filter(|word| branching.contains(&word.as_str())).count();
        assert_eq!(conditions_in(kernel).expect("understood").len(), count, "{}", info.name);
    }
}

#[test]
fn lines_are_the_text_and_spans_are_the_whole_line() {
    for info in PROGRAM.kernels().map(Kernel::info) {
        let lines = lines(info.wgsl);
        assert_eq!(lines.iter().map(|l| l.text.clone() + "\n").collect::<String>(), info.wgsl, "{}", info.name);
        for line in &lines {
            let mut end = 0;
            for (range, _) in &line.spans {
                assert_eq!(range.start, end, "{}: {}", info.name, line.text);
                end = range.end;
            }
            assert_eq!(end, line.text.len(), "{}: {}", info.name, line.text);
        }
    }
    let spans = &lines("/* a\nb */ let x = 1u;")[1].spans;
    let classes: Vec<_> = spans.iter().map(|(_, class)| *class).collect();
    use Class::{Comment, Keyword, Number, Plain};
    assert_eq!(classes, [Comment, Plain, Keyword, Plain, Number, Plain]);
}

/// Runs to the end and calls `look` for every pass of some rays, with renderer, kernel, and state before and after.
fn follow(scene: &Scene, options: &Options, mut look: impl FnMut(&Renderer, Kernel, &RayState, &RayState)) {
    let mut renderer = pollster::block_on(Renderer::new(scene, options, &Device::Cpu(None))).expect("a small scene");
    let (width, height) = (renderer.plan().width, renderer.plan().height);
    let states = |renderer: &Renderer| -> Vec<RayState> {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        texels.map(|(x, y)| pollster::block_on(ray_state(renderer, x, y)).expect("a ray")).collect()
    };
    let mut before = states(&renderer);
    while let Some(pass) = pollster::block_on(renderer.step()).expect("a pass") {
        let after = states(&renderer);
        for (before, after) in before.iter().zip(&after) {
            if pass.kernel.info().takes.contains(&before.tag) {
                look(&renderer, pass.kernel, before, after);
            }
        }
        before = after;
    }
}

fn ran<'a>(lines: &'a [Line], part: &str) -> Vec<&'a Line> {
    lines.iter().filter(|l| l.mark == Mark::Run && l.text.contains(part)).collect()
}

#[test]
fn what_is_marked_as_run_is_what_the_ray_did() {
    let mut ways = 0;
    for scene in [generate::cornell_box(), generate::icosphere(1).expect("a sphere")] {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
            for (numerics, counters, keep_all, count) in [
                (Numerics::Robust, false, false, 1),
                (Numerics::Robust, false, false, 3),
                (Numerics::Robust, true, true, 1),
                (Numerics::Paper, true, false, 1),
            ] {
                let options = options(&scene, accelerator, ScheduleKind::Second, [4, 3]);
                let samples = Samples { count, ..Samples::default() };
                let options = Options { numerics, counters, keep: Keep::all_if(keep_all), samples, ..options };
                follow(&scene, &options, |renderer, kernel, before, after| {
                    let features = &renderer.plan().features;
                    let lines = kernel_file(kernel, features, Some((before, after)));
                    let what = || format!("{accelerator} {} {} > {}", kernel.name(), before.state, after.state);
                    if kernel == kernels::ACCUMULATE {
                        // The last sample keeps the tag, and writes the mean to the image.
                        let moved = |part: &str| !ran(&lines, part).is_empty();
                        assert_eq!(moved("textureStore(state, texel, 0, vec4u(UNWRITTEN))"), after.tag == 0);
                        assert_eq!(moved("textureStore(color, texel, 0,"), after.tag == 7);
                        ways += 1;
                        return;
                    }
                    // Exactly one line stores the tag, and if it names a tag, that is the ray's.
                    let stores = ran(&lines, "textureStore(state, texel, 0,");
                    assert_eq!(stores.len(), 1, "{}: {stores:?}", what());
                    let store = &stores[0].text;
                    let named = STATES.iter().find(|s| store.contains(&format!("({})", s.name)));
                    assert!(named.is_none_or(|s| s.tag == after.tag), "{}: {store}", what());
                    let moved = |part: &str| !ran(&lines, part).is_empty();
                    if kernel == kernels::INTERSECT {
                        assert_eq!(moved("item += 1u"), after.item == before.item + 1, "{}", what());
                        assert_eq!(moved("tag = ISECT_HIT;"), after.triangle != before.triangle, "{}", what());
                        let has_ended =
                            moved("tag = list_ended(") || moved("tag = TRAV;") || moved("tag = select(BACK");
                        assert_eq!(has_ended, after.tag < 3 || after.tag > 4, "{}", what());
                    }
                    if kernel == kernels::TRAVERSE_GRID {
                        assert_eq!(moved("textureStore(tmax"), after.tag == 3 || after.tag == 4, "{}", what());
                    }
                    if kernel == kernels::SHADE {
                        assert_eq!(moved("surface_normal(triangle, u, v)"), before.tag == 5, "{}", what());
                    }
                    ways += 1;
                });
            }
        }
    }
    assert!(ways > 1000, "{ways}");
}

#[test]
fn what_the_device_is_not_given_is_left_out_and_all_else_of_a_body_has_a_mark() {
    let scene = generate::cornell_box();
    let mut chosen_lines = 0;
    for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
        let options = options(&scene, accelerator, ScheduleKind::Second, [3, 2]);
        follow(&scene, &options, |renderer, kernel, before, after| {
            let plan = renderer.plan();
            let squeeze = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
            let given = squeeze(&plan.variant(kernel).expect("planned").source);
            let lines = kernel_file(kernel, &plan.features, Some((before, after)));
            let still = kernel_file(kernel, &plan.features, None);
            for (line, still) in lines.iter().zip(&still) {
                assert_eq!(still.mark == Mark::LeftOut, line.mark == Mark::LeftOut, "{}", line.text);
                assert!(matches!(still.mark, Mark::Plain | Mark::LeftOut), "{}", line.text);
                // A statement that an option chooses is in the plan's source unless its line is marked as left out.
                let choice = line
                    .text
                    .trim()
                    .strip_prefix("@else ")
                    .or_else(|| line.text.trim().split_once(") let ").map(|s| s.1));
                if let Some(chosen) = choice.filter(|c| c.ends_with(';') && !c.contains("0x")) {
                    let chosen = squeeze(chosen);
                    assert_eq!(given.contains(&chosen), line.mark != Mark::LeftOut, "{}: {}", kernel.name(), line.text);
                    chosen_lines += 1;
                }
                let is_store = line.text.contains("textureStore(") && line.text.ends_with(';');
                if is_store && !line.text.contains("@if") {
                    let store = squeeze(&line.text);
                    let named = store.split("vec4").next().unwrap_or_default();
                    let is_given = given.contains(named);
                    assert!(is_given || line.mark == Mark::LeftOut, "{}: {}", kernel.name(), line.text);
                    assert_ne!(line.mark, Mark::Plain, "{}: {}", kernel.name(), line.text);
                }
            }
        });
    }
    assert!(chosen_lines > 100, "{chosen_lines}");
}

#[test]
fn what_the_streams_do_not_tell_is_unknown() {
    let mut scene = generate::cornell_box();
    scene.materials.iter_mut().for_each(|m| m.double_sided = true);
    let options = options(&scene, Accelerator::Grid, ScheduleKind::Second, [3, 2]);
    let mut seen = 0;
    follow(&scene, &options, |renderer, kernel, before, after| {
        if kernel != kernels::SHADE {
            return;
        }
        let lines = kernel_file(kernel, &renderer.plan().features, Some((before, after)));
        let mark = |part: &str| lines.iter().find(|l| l.text.contains(part)).map(|l| l.mark);
        assert_eq!(mark("normal = -normal;"), Some(Mark::Unknown));
        assert_eq!(mark("rgb = rgb * diffuse;"), Some(Mark::Run), "what follows is known again");
        seen += 1;
    });
    assert!(seen > 0);
}

#[test]
fn the_composed_source_is_what_the_device_is_given() {
    let scene = generate::cornell_box();
    let options = options(&scene, Accelerator::Grid, ScheduleKind::Second, [3, 2]);
    let renderer = pollster::block_on(Renderer::new(&scene, &options, &Device::Cpu(None))).expect("a small scene");
    for variant in &renderer.plan().variants {
        let lines = composed(variant);
        assert!(lines.iter().all(|l| l.mark == Mark::Plain && !l.text.contains("@if")));
        let text = lines.iter().map(|l| l.text.as_str()).collect::<Vec<_>>().join("\n");
        assert_eq!(text.trim_end(), variant.source.trim_end());
    }
}
