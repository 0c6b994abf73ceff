//! A kernel's source, line by line.

use raystep_inspector::source::{Class, Mark, composed, in_composed, in_files, kernel_files, lines};
use raystep_kernels::programs::closest_hit::PROGRAM;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Accelerator, Device, Kernel, Limits, Plan, Renderer, ScheduleKind};
use raystep_scenes::generate;

use crate::data::common::options;

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

#[test]
fn a_line_of_the_composed_source_is_one_of_the_kernels_files() {
    let scene = generate::cornell_box();
    let options = options(&scene, Accelerator::Grid, ScheduleKind::Second, [3, 2]);
    let (plan, _) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
    let (mut found, mut of_others) = (0, 0);
    for variant in &plan.variants {
        let of = plan.sourced(variant.kernel).expect("valid").expect("a part of the plan");
        for (line, text) in variant.source.lines().enumerate() {
            let Some(at) = in_files(&of, variant, &plan.features, line) else {
                let is_statement = text.starts_with("    ") && text.trim_end().ends_with(';');
                assert!(!is_statement, "{}:{}: {text}", variant.kernel.name(), line + 1);
                continue;
            };
            assert!(of.text_of(at).trim().ends_with(text.trim()), "{}: {text}", of.text_of(at));
            (found, of_others) = (found + 1, of_others + usize::from(at.file > 0));
        }
    }
    assert!(found > 200 && of_others > 100, "{found} {of_others}");
}

#[test]
fn what_the_device_is_not_given_is_left_out_and_all_else_of_a_function_is_found_in_the_composed_source() {
    let scene = generate::cornell_box();
    let (mut chosen_lines, mut found, mut dropped) = (0, 0, 0);
    for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
        for schedule in [ScheduleKind::Second, ScheduleKind::Fused] {
            let options = options(&scene, accelerator, schedule, [3, 2]);
            let (plan, _) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
            for variant in &plan.variants {
                let squeeze = |text: &str| text.chars().filter(|c| !c.is_whitespace()).collect::<String>();
                let given = squeeze(&variant.source);
                let composed: Vec<&str> = variant.source.split('\n').collect();
                let lines = kernel_files(variant.kernel, Some(variant), &plan.features);
                // The part that belongs to the scene's structure is there too, below its name.
                if variant.kernel.role() == Role::Whole {
                    let at = |part: &str| lines.iter().position(|line| line.text.starts_with(part));
                    assert!(at("// ---- fused_structure") < at("fn traced("), "{accelerator}");
                    assert!(at("// ---- fused_structure").is_some(), "{accelerator}");
                }
                let placed = in_composed(variant, &plan.features);
                for (line, there) in lines.iter().zip(&placed) {
                    assert!(matches!(line.mark, Mark::Plain | Mark::LeftOut), "{}", line.text);
                    let text = line.text.trim();
                    // Of a file that belongs to the kernel, functions that it does not call are left out as well.
                    if let Some((name, _)) = line.text.strip_prefix("fn ").and_then(|head| head.split_once('(')) {
                        let is_given = given.contains(&format!("fn{name}("));
                        assert!(is_given || line.mark == Mark::LeftOut, "{}: {text}", variant.kernel.name());
                        dropped += usize::from(!is_given);
                    }
                    // A statement that an option chooses is in the plan's source unless its line is marked as left out.
                    let choice = text.split_once(") let ").map(|s| s.1).or_else(|| text.strip_prefix("@else "));
                    if let Some(chosen) = choice.filter(|c| c.ends_with(';') && !c.contains("0x")) {
                        let chosen = squeeze(chosen);
                        let is_left_out = line.mark == Mark::LeftOut;
                        assert_eq!(given.contains(&chosen), !is_left_out, "{}: {text}", variant.kernel.name());
                        chosen_lines += 1;
                    }
                    if let Some(there) = there {
                        let there = composed[*there].trim();
                        assert!(text.ends_with(there), "{text} is not {there}");
                        found += 1;
                    }
                    let is_statement = line.text.starts_with("    ") && text.ends_with(';') && !text.contains("//");
                    let is_in_function = is_statement && !text.contains(": ") && !text.starts_with("@builtin");
                    if is_in_function && line.mark == Mark::Plain {
                        assert!(
                            there.is_some() || !given.contains(&squeeze(text)),
                            "{}: {text}",
                            variant.kernel.name()
                        );
                    }
                }
            }
        }
    }
    assert!(chosen_lines > 100 && found > 800 && dropped > 20, "{chosen_lines} {found} {dropped}");
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
