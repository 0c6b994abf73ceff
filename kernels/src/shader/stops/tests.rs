use super::*;
use crate::compose::words as words_of;
use crate::options::features::Features;
use crate::program::live;
use crate::programs::closest_hit::{PROGRAM, kernels};
use crate::shader::FileLine;

/// A kernel of ours through a grid.
fn sourced(kernel: crate::Kernel) -> Sourced {
    let features = Features { robust: true, watertight: true, grid: true, ..Features::default() };
    let lists = live::lists(&[kernel], &features);
    let variant = Variant::new(kernel, &features, &lists).expect("a variant");
    Sourced::new(&variant, &features, &lists).expect("valid")
}

/// The line of a kernel's own file that begins with a text.
fn line(of: &Sourced, begins: &str) -> FileLine {
    let found = of.files[0].text.lines().position(|line| line.trim().starts_with(begins));
    FileLine { file: 0, line: found.unwrap_or_else(|| panic!("no {begins}")) + 1 }
}

fn at(of: &Sourced, begins: &str, when: &str) -> Stop {
    Stop { statement: of.statement(line(of, begins)).expect("a statement"), when: Some(when.into()) }
}

#[test]
fn the_text_is_that_of_the_device_and_its_lines_are_those_of_the_files() {
    for kernel in PROGRAM.kernels() {
        let features = Features { robust: true, grid: true, live_lists: true, ..Features::default() };
        let features = Features { bvh: kernel == kernels::TRAVERSE_BVH, ..features };
        let features = Features { irregular: kernel == kernels::TRAVERSE_IRREGULAR, ..features };
        let grid = !features.bvh && !features.irregular;
        let features = Features { grid, samples: kernel == kernels::ACCUMULATE, ..features };
        let lists = live::lists_of(kernel, &live::lists(&[kernel], &features));
        let variant = Variant::new(kernel, &features, &lists).expect("a variant");
        let of = Sourced::new(&variant, &features, &lists).expect("valid");
        let code = |text: &str| {
            let all = words_of(text).into_iter().filter(|word| word.kind != WordKind::Comment);
            all.map(|word| word.text.to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(code(&of.variant.source), code(&variant.source), "{}", kernel.name());
        assert!(of.files[0].text == kernel.info().wgsl && !of.files[0].is_own);
        for (index, text) in of.variant.source.lines().enumerate().filter(|(_, text)| !text.trim().is_empty()) {
            let place = of.place(index).unwrap_or_else(|| panic!("{}: {text}", kernel.name()));
            // Options are left out of it.
            let there = code(of.text_of(place));
            assert!(code(text).iter().all(|word| there.contains(word)), "{text}");
        }
    }
}

#[test]
fn a_stop_is_on_the_line_that_it_is_for_and_keeps_the_variables_of_its_condition() {
    let of = sourced(kernels::INTERSECT);
    let stop =
        at(&of, "if (candidate.is_hit && accepted)", "candidate.t /* , */ < 0.5 && any(ray.origin != vec3f(0.0)) // x");
    let stopping = of.stopping(std::slice::from_ref(&stop), false).expect("a condition");
    assert_eq!(stopping.watched, [["candidate.t", "ray.origin"]]);
    let count = |text: &str| text.lines().count();
    assert_eq!(count(&stopping.variant.source), count(&of.variant.source) + 1);
    let own = stopping.variant.source.lines().position(|line| line.contains("stop___0(")).expect("the stop");
    let place = of.place(own).expect("a place");
    assert_eq!((place.file, place), (0, of.line_of_statement(stop.statement).expect("a place")));
    let traced = of.stopping(&[stop], true).expect("a condition").variant.source;
    assert_eq!(traced.matches("at___(").count(), of.statements.starts.iter().filter(|s| s.is_open).count() + 1);
}

#[test]
fn a_mistake_in_a_condition_has_its_place_and_what_would_be_right() {
    let of = sourced(kernels::INTERSECT);
    for (when, column, message) in [
        ("candidat.t < 0.5", 1, "variables here: a, accepted, b, c, candidate"),
        ("candidate.t < item", 1, ""),
        ("  candidate.tt < 0.5", 13, "invalid field accessor"),
        ("candidate.t", 1, "compare it, as in x < 0.0"),
        ("item", 1, "compare it, as in x == 0"),
        ("ray.origin < ray.direction", 1, "use any(…) or all(…)"),
        ("item = 1u", 6, "== compares two"),
        ("true); item += 1u; (true", 5, "nothing is open here that ) closes"),
        ("(item == 1u", 12, "( is not closed"),
        ("item == 1u; true", 11, "expected one expression"),
        ("", 1, "expected one expression"),
        ("// true", 1, "expected one expression"),
        ("item ==", 8, "expected"),
        ("stop___1(true)", 1, "reserved"),
    ] {
        let error = of.stopping(&[at(&of, "if (candidate.is_hit", when)], false).expect_err(when);
        assert!(error.message.contains(message) && (error.column == column || message.is_empty()), "{when}: {error:?}");
    }
    // A name is not known before it is declared, or outside of its block.
    assert!(of.stopping(&[at(&of, "let a = vertex", "candidate.t < 0.0")], false).is_err());
    assert!(of.stopping(&[at(&of, "if (ended)", "candidate.t < 0.0")], false).is_err());
    assert!(of.stopping(&[at(&of, "if (ended)", "nearest_t < 0.0 && item >= 1u")], false).is_ok());
}

#[test]
fn lines_without_a_statement_have_no_stop_and_options_leave_lines_out() {
    let of = sourced(kernels::INTERSECT);
    assert_eq!(of.statement(FileLine { file: 0, line: 1 }), None);
    assert_eq!(of.statement(line(&of, "@if(any_hit)")), None);
    let lines = of.statement_lines(0);
    assert!(lines.contains(&line(&of, "item += 1u;").line) && lines.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(of.files.iter().any(|file| file.is_called("triangle") && file.is_called("triangle.wgsl")));
}
