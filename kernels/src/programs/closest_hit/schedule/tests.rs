//! Tests the order of kernels, without a GPU.

use super::super::{kernels, states};
use super::*;
use crate::program::schedule::Cursor;
use crate::programs::closest_hit::states::{DONE, ISECT_NO_HIT, SHADE as SHADED, TRAV};
use crate::tables::kernel::Launch;
use crate::tables::state::{Population, StateCounts, Tag};

fn counts(isect: u32, trav: u32, shade: u32) -> Population {
    in_states(&[(ISECT_NO_HIT, isect), (TRAV, trav), (SHADED, shade)])
}

fn in_states(rays: &[(Tag, u32)]) -> Population {
    let mut counts = StateCounts::none(states::STATES);
    rays.iter().for_each(|&(tag, rays)| counts.add(tag, rays));
    counts.into()
}

fn run(kind: ScheduleKind, structure: StructureKind, script: &[Population]) -> Vec<&'static str> {
    let schedule = new(kind, &features(structure, false), false, true);
    let mut cursor = Cursor::start();
    let mut now = counts(0, 0, 0);
    let mut names = Vec::new();
    for after in script {
        names.push(cursor.next(&schedule, &now).map_or("end", Kernel::name));
        now = after.clone();
    }
    names.push(cursor.next(&schedule, &now).map_or("end", Kernel::name));
    names
}

#[test]
fn second_takes_turns_until_both_are_idle() {
    let (c, done) = (counts, in_states(&[(DONE, 9)]));
    let script = [c(0, 0, 0), c(9, 0, 0), c(4, 5, 0), c(9, 0, 0), c(0, 4, 5), c(0, 0, 9), done];
    let names = run(ScheduleKind::Second, StructureKind::Grid, &script);
    let expected = ["generate", "setup", "intersect", "traverse_grid", "intersect", "traverse_grid", "shade", "end"];
    assert_eq!(names, expected);
}

#[test]
fn first_empties_intersect_before_it_traverses() {
    let c = counts;
    let script = [c(0, 0, 0), c(9, 0, 0), c(4, 5, 0), c(0, 9, 0), c(2, 0, 7), c(0, 0, 9), c(0, 0, 9), c(0, 0, 0)];
    let names = run(ScheduleKind::First, StructureKind::Grid, &script);
    let expected =
        ["generate", "setup", "intersect", "intersect", "traverse_grid", "intersect", "traverse_grid", "shade", "end"];
    assert_eq!(names, expected);
}

#[test]
fn without_a_grid_there_is_nothing_to_traverse() {
    let c = counts;
    let script = [c(0, 0, 0), c(9, 0, 0), c(3, 0, 6), c(0, 0, 9), c(0, 0, 0)];
    let names = run(ScheduleKind::Second, StructureKind::None, &script);
    assert_eq!(names, ["generate", "setup", "intersect", "intersect", "shade", "end"]);
}

fn features(structure: StructureKind, many_steps: bool) -> Features {
    Features {
        grid: structure == StructureKind::Grid,
        irregular: structure == StructureKind::Irregular,
        bvh: structure == StructureKind::Bvh,
        many_steps,
        ..Features::default()
    }
}

fn sampled(kind: ScheduleKind, structure: StructureKind, many_steps: bool) -> Schedule {
    for_samples(new(kind, &features(structure, many_steps), false, true))
}

#[test]
fn all_steps_come_again_as_long_as_a_pixel_wants_a_sample() {
    let schedule = sampled(ScheduleKind::Second, StructureKind::Grid, false);
    let c = counts;
    let (unwritten, done) = (in_states(&[(states::UNWRITTEN, 9)]), in_states(&[(DONE, 9)]));
    let mut cursor = Cursor::start();
    let once = [unwritten, c(0, 0, 0), c(9, 0, 0), c(0, 9, 0), c(0, 0, 9), done.clone()];
    let names = ["generate", "setup", "intersect", "traverse_grid", "shade", "accumulate"];
    for turn in 0..3 {
        for ((now, name), iteration) in once.iter().zip(names).zip([0, 0, 1, 1, 1, 1]) {
            assert_eq!(cursor.next(&schedule, now).map(Kernel::name), Some(name), "sample {turn}");
            assert_eq!(cursor.iteration, iteration, "{name}");
            assert_eq!(cursor.samples, turn + u32::from(name == "accumulate"));
        }
    }
    assert_eq!(cursor.next(&schedule, &done), None);
    assert_eq!(cursor.samples, 3);
}

#[test]
fn a_walk_that_is_left_goes_on_with_its_own_sample() {
    for (kind, structure, many_steps) in [
        (ScheduleKind::Second, StructureKind::Grid, false),
        (ScheduleKind::First, StructureKind::Grid, false),
        (ScheduleKind::First, StructureKind::Bvh, false),
        (ScheduleKind::Compact, StructureKind::Grid, true),
        (ScheduleKind::Second, StructureKind::None, false),
    ] {
        for schedule in [new(kind, &features(structure, many_steps), false, true), sampled(kind, structure, many_steps)]
        {
            let mut cursor = Cursor::start();
            let mut unwritten = counts(5, 5, 0);
            unwritten.in_state.add(states::UNWRITTEN, 1);
            while !cursor.next(&schedule, &unwritten).expect("a walk").is_walk() {
                let mut outside = cursor.clone();
                outside.leave_walk(&schedule);
                assert!(outside == cursor || outside.next(&schedule, &unwritten) == Some(kernels::SHADE));
            }
            cursor.next(&schedule, &unwritten);
            cursor.leave_walk(&schedule);
            assert_eq!(cursor.next(&schedule, &unwritten), Some(kernels::SHADE), "{kind} {structure:?}");
            let again = cursor.clone();
            cursor.leave_walk(&schedule);
            assert_eq!(cursor, again, "there is nothing to leave");
        }
    }
}

/// The kernels that are submitted ahead.
fn guess(cursor: &Cursor, schedule: &Schedule, counts: &Population, most: usize) -> Vec<Kernel> {
    cursor
        .guess(schedule, counts, most, |kernel| kernel.info().launch == Launch::Bands)
        .into_iter()
        .map(|call| call.kernel)
        .collect()
}

#[test]
fn a_guess_goes_on_to_the_next_sample_and_no_farther_than_its_walk() {
    let guesses = |schedule: &Schedule, most: usize| {
        let mut cursor = Cursor::start();
        let unwritten = in_states(&[(states::UNWRITTEN, 9)]);
        let first = guess(&cursor, schedule, &unwritten, most);
        while cursor.next(schedule, &unwritten) != Some(SHADE) {}
        (first, guess(&cursor.before(), schedule, &counts(0, 0, 9), most))
    };
    let compact = sampled(ScheduleKind::Compact, StructureKind::Grid, true);
    let (first, next) = guesses(&compact, 7);
    assert_eq!(first, [GENERATE, SETUP, WALK, WALK, WALK, WALK, WALK]);
    assert_eq!(next, [SHADE, ACCUMULATE, GENERATE, SETUP, WALK, WALK, WALK]);
    assert_eq!(guesses(&compact, 3).1, [SHADE, ACCUMULATE, GENERATE]);
    let (first, next) = guesses(&sampled(ScheduleKind::Fused, StructureKind::Grid, false), 8);
    assert_eq!((first, next), (vec![GENERATE], vec![SHADE, ACCUMULATE, GENERATE]));
    let (first, _) = guesses(&sampled(ScheduleKind::First, StructureKind::Bvh, false), 8);
    assert_eq!(first, [GENERATE, SETUP, TRAVERSE_BVH], "others may come before the next step");
    let (first, _) = guesses(&sampled(ScheduleKind::Second, StructureKind::None, false), 4);
    assert_eq!(first, [GENERATE, SETUP, INTERSECT, INTERSECT]);
}

#[test]
fn a_guess_never_leaves_the_loop() {
    let schedule = new(ScheduleKind::First, &features(StructureKind::Grid, false), false, true);
    let mut cursor = Cursor::start();
    assert_eq!(guess(&cursor, &schedule, &counts(0, 0, 0), 8), [kernels::GENERATE]);
    cursor.next(&schedule, &counts(0, 0, 0));
    cursor.next(&schedule, &counts(0, 0, 0));
    assert_eq!(guess(&cursor, &schedule, &counts(5, 0, 0), 4), [kernels::INTERSECT; 4]);
}

#[test]
fn a_guess_never_takes_a_step_that_another_kernel_may_come_before() {
    let schedule = new(ScheduleKind::First, &features(StructureKind::Bvh, false), false, true);
    let mut cursor = Cursor::start();
    for _ in 0..2 {
        cursor.next(&schedule, &counts(0, 0, 0));
    }
    // Rays that this step takes to a leaf are tested before the next step.
    assert_eq!(guess(&cursor, &schedule, &counts(0, 9, 0), 8), [kernels::TRAVERSE_BVH]);
    cursor.next(&schedule, &counts(0, 9, 0));
    assert_eq!(guess(&cursor, &schedule, &counts(4, 5, 0), 3), [kernels::INTERSECT; 3]);
}
