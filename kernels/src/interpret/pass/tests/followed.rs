//! One thread, step by step, and stops.

use super::*;
use crate::interpret::{Shown, StreamView};
use crate::shader::{FileLine, Sourced, Stop};

#[test]
fn a_thread_is_followed_to_any_of_its_steps_and_stops_count_elements() {
    let body = "
    var sum = 0u;
    for (var turn = 0u; turn < 3u; turn++) {
        all[lane] = lane + turn;
        workgroupBarrier();
        let next = all[(lane + 1u) % BLOCK];
        workgroupBarrier();
        sum += next;
    }
    if (i < launch.elements) { store(i, sum); }";
    let variant = listed("var<workgroup> all: array<u32, 256>;", body);
    let of = Sourced::new(&variant, &Features::default(), &[]).expect("valid");
    let line = |text: &str| of.files[0].text.lines().position(|line| line.contains(text)).expect(text) + 1;
    let at = |text: &str| of.statement(FileLine { file: 0, line: line(text) }).expect(text);
    let stop = Stop { statement: at("sum += next"), when: Some("turn == 1u && next > 100u".into()) };
    let stopping = of.stopping(std::slice::from_ref(&stop), false).expect("a condition");
    let pass = Pass::new(&stopping.variant).expect("valid");
    let size = Size::folded(300, 1 << 12).expect("a size");
    let (data, streams) = (SceneData::default(), streams(&pass, size));
    let given = Given { data: &data, size, parameter: 0, streams: &streams };

    // Every element comes there three times, and the condition holds in one turn or in none.
    let passed = pass.run(&given).expect("a pass");
    assert_eq!((passed.stopped.len(), &stopping.watched[0]), (300, &vec!["turn".to_owned(), "next".to_owned()]));
    for (element, stopped) in &passed.stopped {
        let next = (element % 256 + 1) % 256 + 1;
        assert_eq!((stopped[0].reached, stopped[0].held), (3, u32::from(next > 100)), "{element}");
        let values = if next > 100 { [1, next as u32] } else { [0, next as u32 - 1] };
        assert_eq!(stopped[0].values, values, "{element}");
    }

    // With the steps of one thread, stops are that thread's.
    let stepping = of.stopping(&[stop], true).expect("a condition");
    let pass = Pass::new(&stepping.variant).expect("valid");
    let followed = pass.follow(&given, [9, 0]).expect("a thread");
    assert!(followed.failed.is_none() && followed.held.is_empty() && !followed.is_cut);
    let adding: Vec<usize> = (0..followed.steps.len())
        .filter(|&step| followed.steps[step].statement as usize == at("sum += next"))
        .collect();
    assert_eq!(adding.len(), 3);
    // A stop's condition has names of its own, in place of those of what it reads.
    let plain = of.stopping(&[], true).expect("valid");
    let pass = Pass::new(&plain.variant).expect("valid");
    let value = |step: usize, name: &str| {
        let view = pass.view(&given, [9, 0], step).expect("a view");
        let found = view.frames[0].variables.iter().find(|variable| variable.name == name).expect(name).clone();
        found.value.told()
    };
    for (turn, &step) in adding.iter().enumerate() {
        assert_eq!((value(step, "turn"), value(step, "next")), (turn.to_string(), (10 + turn).to_string()));
        assert_eq!(value(step, "sum"), (10 * turn + turn.saturating_sub(1)).to_string());
    }
    // Inside of the function that it calls, and behind the last step.
    let inside = followed.steps.iter().position(|step| step.depth == 1).expect("a call");
    let view = pass.view(&given, [9, 0], inside).expect("a view");
    let names = |frame: usize| view.frames[frame].variables.iter().map(|v| v.name.as_str()).collect::<Vec<_>>();
    assert_eq!((view.frames[0].function.as_str(), view.frames.len()), ("element", 2));
    assert!(names(1).contains(&"lane") && !names(1).contains(&"sum"));
    let end = pass.view(&given, [9, 0], followed.steps.len()).expect("a view");
    let stored = end.streams.iter().find(|of| of.stream == rows::A && of.layer == 0).expect("the stream");
    assert!(matches!(stored, StreamView { before: 27, now: 33, .. }), "{stored:?}");
    let all = end.module.iter().find(|variable| variable.name == "all").expect("the variable");
    assert!(matches!(&all.value, Shown::Parts(parts) if parts.len() == 256) && all.of == "array<u32, 256>");
    assert!(pass.view(&given, [31, 9], 0).is_err());
    // An expression, with its own value at each step.
    let variant = of.evaluating(at("sum += next"), "vec2u(next, turn) + 1u").expect("an expression");
    let evaluating = Pass::new(&variant).expect("valid");
    let told = evaluating.view(&given, [9, 0], adding[2]).expect("a view").evaluated.expect("a value");
    assert_eq!((told.value.told(), told.of.as_str()), ("(13, 3)".into(), "vec2<u32>"));
}
