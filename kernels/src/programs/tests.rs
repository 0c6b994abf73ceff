//! Checks every program, and that the checks find what is wrong.

use std::collections::BTreeMap;

use super::*;
use crate::program::{Course, Instance, Kernel, Renamed};
use crate::tables::elements::{Count, Elements};
use crate::tables::state::{StateInfo, StateRole, States};
use crate::tables::stream::{Meaning, StreamInfo};

#[test]
fn no_program_has_a_fault_and_streams_of_one_name_are_the_same() {
    let mut names = BTreeMap::new();
    for program in all() {
        assert_eq!(program.faults(), [], "{program:?}");
        for stream in program.streams() {
            assert_eq!(*names.entry(stream.name()).or_insert(stream), stream);
        }
        for kernel in program.kernels() {
            assert!(std::ptr::eq(kernel.program(), program), "{kernel:?}");
        }
    }
}

#[test]
fn one_program_is_chosen_by_any_options() {
    for &program in ProgramName::ALL {
        assert_eq!(named(program).name.replace('_', "-"), program.name());
        for &integrator in Integrator::ALL {
            let choices = Choices { program, integrator, ..Choices::default() };
            let is_it = |it: &&Registered| it.name == program && it.integrators.contains(&integrator);
            assert_eq!(REGISTRY.iter().filter(is_it).count(), 1, "{program} {integrator}");
            assert_eq!(chosen(&choices).name, program);
        }
    }
    let shadows = Choices { integrator: Integrator::Shadows, ..Choices::default() };
    assert_eq!((chosen(&shadows).program().name, all().count()), ("light", 6));
}

/// A changed program, leaked for the duration of the test.
fn changed(change: impl FnOnce(&mut Program)) -> &'static Program {
    let mut program = Program { ..closest_hit::PROGRAM };
    change(&mut program);
    Box::leak(Box::new(program))
}

fn leaked<T>(values: Vec<T>) -> &'static [T] {
    Vec::leak(values)
}

/// The kernels with one of them changed.
fn with(kernel: Kernel, change: impl FnOnce(&mut Instance)) -> &'static [Instance] {
    let mut kernels = closest_hit::PROGRAM.kernels.to_vec();
    change(&mut kernels[kernel.index()]);
    leaked(kernels)
}

#[test]
fn every_fault_is_found_and_said() {
    use closest_hit::kernels::{ACCUMULATE, GENERATE, INTERSECT, SHADE};
    use closest_hit::states::SHADE as SHADED;
    use closest_hit::streams::{RAY_ORIGIN, STATE, STREAMS};
    static NOWHERE: Elements = Elements { name: "nowhere", count: Count::Image };
    static LOST: Elements = Elements { name: "lost", count: Count::Per { of: "nowhere", per: 2, each: 1 } };
    let state = |tag, name| StateInfo { tag, name, role: StateRole::Active, colour: [0; 3], meaning: "" };
    let stream = |change: fn(&mut StreamInfo)| {
        let mut streams = STREAMS.to_vec();
        change(&mut streams[0]);
        leaked(streams)
    };
    let cases: Vec<(&str, &'static Program)> = vec![
        ("two streams are called \"state\"", changed(|p| p.streams = stream(|s| s.name = "state"))),
        ("ray_origin does not stand at its own place", changed(|p| p.streams = stream(|s| s.index = 5))),
        ("has 56 states, at most 55 fit", changed(|p| p.states = States(leaked(vec![state(0, "LATE"); 56])))),
        (
            "stream ray_origin has 3 layers and 1 initial values",
            changed(|p| p.streams = stream(|s| s.unwritten = &[0])),
        ),
        (
            "stream ray_origin has 3 layers and 1 meanings",
            changed(|p| p.streams = stream(|s| s.meaning = &[Meaning::Float])),
        ),
        ("ray_origin names elements \"nowhere\"", changed(|p| p.streams = stream(|s| s.elements = &NOWHERE))),
        ("lost names elements \"nowhere\"", changed(|p| p.elements = leaked(vec![p.elements[0], &LOST]))),
        ("intersect names list \"late\"", changed(|p| p.kernels = with(INTERSECT, |k| k.kernel.list = Some("late")))),
        ("intersect names state 99", changed(|p| p.kernels = with(INTERSECT, |k| k.kernel.takes = &[99]))),
        ("generate names elements \"nowhere\"", changed(|p| p.kernels = with(GENERATE, |k| k.over = &NOWHERE))),
        ("generate names \"nothing\"", changed(|p| p.kernels = with(GENERATE, |k| k.binds = &[("hit", "nothing")]))),
        (
            "shade makes state the stream ray_origin, which has other layers",
            changed(|p| p.kernels = with(SHADE, |k| k.adopts = &[(RAY_ORIGIN, STATE)])),
        ),
        ("shade sends nothing on from BACKGROUND", changed(|p| p.kernels = with(SHADE, |k| k.kernel.sends = &[]))),
        (
            "accumulate does not take what it sends on from DONE",
            changed(|p| p.kernels = with(ACCUMULATE, |k| k.kernel.takes = &[])),
        ),
        (
            "stream state does not begin with state DONE",
            changed(|p| {
                let course = Course { unborn: closest_hit::states::DONE, ..p.courses[0] };
                p.courses = leaked(vec![course]);
            }),
        ),
        ("no element is ever in state SHADE", changed(|p| p.kernels = &with(GENERATE, |_| ())[..1])),
        (
            "no kernel takes elements from state BACKGROUND",
            changed(|p| {
                p.kernels = with(SHADE, |k| k.kernel.takes = &[SHADED]);
            }),
        ),
    ];
    for (said, program) in cases {
        let faults = program.faults();
        assert!(faults.iter().any(|fault| fault.to_string().contains(said)), "{said}: {faults:#?}");
    }
}

#[test]
fn a_guest_needs_every_state_that_it_names() {
    use closest_hit::kernels::INTERSECT;
    let state = |tag, name| StateInfo { tag, name, role: StateRole::Active, colour: [0; 3], meaning: "" };
    let names = ["TRAV", "SHADE", "BACKGROUND", "TESTS", "KEEPS", "EXACT"];
    let states = States(leaked((0..).zip(names).map(|(tag, name)| state(tag, name)).collect()));
    let pairs = [("ISECT_NO_HIT", "TESTS"), ("ISECT_HIT", "KEEPS")];
    let renamed = Renamed::new(INTERSECT.info(), states, &pairs).expect("its states");
    assert_eq!(
        renamed.tags,
        [(2, 0), (3, 3), (4, 4), (5, 5), (6, 1), (7, 2)],
        "those that no pair names have the same name"
    );
    assert!(Renamed::new(INTERSECT.info(), states, &pairs[..1]).is_none(), "ISECT_HIT is missing");
    assert!(Renamed::new(INTERSECT.info(), states, &[pairs[0], pairs[1], ("NOTHING", "TRAV")]).is_none());
}
