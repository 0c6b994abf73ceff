//! Notes and assertions are found, typed, and leave every column where it is.

use std::sync::Arc;

use super::*;
use crate::options::features::Features;
use crate::programs::closest_hit::kernels::TRAVERSE_GRID;
use crate::shader::{ShaderError, Variant};

const STORE: &str = "    if (!walk.inside) {";

/// The kernel with these lines before the walk's end is decided.
fn with(lines: &str) -> Result<Variant, Mistake> {
    let own = TRAVERSE_GRID.info().wgsl;
    assert!(own.contains(STORE));
    let source = own.replacen(STORE, &format!("{lines}\n{STORE}"), 1);
    let by = Replacement { kernel: "traverse_grid".into(), file: "my.wgsl".into(), source };
    let features = Features { grid: true, ..Features::default() };
    Variant::replaced(TRAVERSE_GRID, &features, &[], &Arc::new(by)).map_err(|error| match error {
        ShaderError::Mistake(mistake) => *mistake,
        other => panic!("{other}"),
    })
}

fn noted(lines: &str) -> Vec<(String, ScalarKind, u32)> {
    let variant = with(lines).unwrap_or_else(|mistake| panic!("{lines}: {mistake}"));
    let notes = &variant.replaced.as_ref().expect("a user's").notes;
    notes.noted.iter().map(|note| (note.label.clone(), note.kind, note.words)).collect()
}

#[test]
fn values_have_the_types_of_their_expressions() {
    use ScalarKind::{Bool, Float, Sint, Uint};
    let lines = "    note(\"t\", walk.tmax.x);
    if (index > 2u) { note(\"cells, x y z\", vec3i(1, 2, 3)); }
    let again = index;
    note(\"index\", index); note(\"index again\", again); /* note(\"no\", 1); */ note ( \"inside\" , walk.inside ); // note(\"no\", 2);";
    let kinds = noted(lines).into_iter().map(|(_, kind, words)| (kind, words));
    assert_eq!(kinds.collect::<Vec<_>>(), [(Float, 1), (Sint, 3), (Uint, 1), (Uint, 1), (Bool, 1)]);
    assert_eq!(noted(lines)[1].0, "cells, x y z");
    assert_eq!(
        noted("    note(\"n\", 1);\n    note(\"m\", 2.5);").iter().map(|n| n.1).collect::<Vec<_>>(),
        [Sint, Float]
    );
    // In a function that is never called there is nothing to print.
    assert_eq!(noted("").len(), 0);
}

#[test]
fn a_value_in_words_says_how_often_it_was_printed() {
    let of = |kind, words| Noted { label: "a".into(), kind, words };
    assert_eq!(
        of(ScalarKind::Float, 2).told(([1f32.to_bits(), 0.5f32.to_bits(), 7, 7], 1)).as_deref(),
        Some("a = 1 0.5")
    );
    assert_eq!(of(ScalarKind::Sint, 1).told(([u32::MAX, 0, 0, 0], 3)).as_deref(), Some("a = -1, the last of 3"));
    assert_eq!(of(ScalarKind::Bool, 1).told(([1, 0, 0, 0], 1)).as_deref(), Some("a = true"));
    assert_eq!(of(ScalarKind::Uint, 1).told(([1, 0, 0, 0], 0)), None);
}

#[test]
fn what_is_wrong_is_named_at_its_place() {
    let line = TRAVERSE_GRID.info().wgsl.split(STORE).next().expect("a part").matches('\n').count() + 1;
    for (lines, column, wanted) in [
        ("    note(\"a\" index);", 5, "expected note(\"label\", value);"),
        ("    note(index);", 5, "expected note(\"label\", value);"),
        ("    note(\"\", index);", 10, "a label has 1 to 32 characters"),
        ("    note(\"a/b\", index);", 10, "a label has 1 to 32 characters"),
        ("    note(\"a\", walk);", 5, "a note has a number, a truth value, or a vector of these"),
        ("    note(\"a\", nothing);", 15, "no definition in scope for identifier: `nothing`"),
        ("    note(\"a\", walk.tmax); let x: f32 = 1u;", 31, "the type of `x` is expected to be `f32`, but got `u32`"),
        ("    note___3(index);", 5, "the name note___3 is reserved: choose another"),
        ("    assert_that(\"a\", index > 1u);", 5, "expected assert_that(condition, \"label\");"),
        ("    assert_that(index, \"a\");", 5, "argument 1 has another type than the function's parameter"),
        (
            "    note(\"a\", vec4u(1u)); note(\"b\", walk.tmax); note(\"c\", vec2i(1));",
            49,
            "at most 8 words, and these have 9",
        ),
    ] {
        let mistake = with(lines).map(drop).expect_err(lines);
        assert_eq!((mistake.place.line, mistake.place.column), (line, column), "{lines}: {mistake}");
        assert!(mistake.message.contains(wanted), "{lines}: {mistake}");
    }
    let many = "    assert_that(true, \"a\");\n".repeat(9);
    assert!(with(&many).map(drop).expect_err("too many").message.contains("at most 8 assertions"));
}

#[test]
fn a_device_gets_no_note_and_counts_what_does_not_hold() {
    let variant = with("    note(\"t\", walk.tmax);\n    assert_that(index > 1u, \"a\");").expect("a kernel");
    assert!(variant.source.contains("note___0("));
    let guarded = variant.guarded(1000).expect("valid").expect("an assertion");
    // naga writes neither name as it was.
    assert!(!guarded.source.contains("note_0"), "{}", guarded.source);
    assert!(guarded.source.contains("atomicAdd") && guarded.source.contains("fn assert_"), "{}", guarded.source);
    // Without either, and without loops, nothing is changed.
    assert!(with("").expect("a kernel").guarded(1000).expect("valid").is_none());
}
