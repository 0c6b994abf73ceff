//! The course: every solution passes, every hole is found, and typical wrong answers are named by the place where they are
//! wrong. All on the CPU: that is what every student has.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raystep_kernels::Device;
use raystep_kernels::options::replacement::Replacement;
use raystep_lab::course::exercises::EXERCISES;
use raystep_lab::course::{Exercise, Found, Task, Verdict, check_view, files};
use raystep_tests::block_on;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/course")
}

fn solution(exercise: &Exercise) -> String {
    fs::read_to_string(folder().join("solutions").join(exercise.file())).expect("a solution")
}

fn tasks() -> impl Iterator<Item = (&'static Exercise, &'static Task)> {
    EXERCISES.iter().map(|exercise| (exercise, &exercise.task))
}

/// What becomes of this text; with the number of the view, from 0, in which something is wrong.
fn judged(task: &Task, source: String) -> (usize, Verdict) {
    let by = Arc::new(Replacement { kernel: task.kernel.into(), file: "my.wgsl".into(), source });
    let mut sum = 0;
    for (i, view) in task.views.iter().enumerate() {
        match block_on(None, check_view(task, view, &by, &Device::Cpu(None))).expect("a check") {
            Found::Right(rays) => sum += rays,
            Found::Wrong(verdict) => return (i, verdict),
        }
    }
    (task.views.len(), Verdict::Passed { views: task.views.len(), rays: sum })
}

/// Works on all at once, and lists what any of them complains about.
fn complaints<T: Sync>(all: &[T], check: impl Fn(&T) -> Option<String> + Sync) -> Vec<String> {
    let half = all.len().div_ceil(2).max(1);
    std::thread::scope(|scope| {
        let check = &check;
        let threads: Vec<_> = all
            .chunks(half)
            .map(|part| scope.spawn(move || part.iter().filter_map(check).collect::<Vec<_>>()))
            .collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no panic")).collect()
    })
}

#[test]
fn every_solution_passes_and_every_hole_is_found_in_the_first_view() {
    let all: Vec<_> = tasks().collect();
    assert_eq!(all.len(), 8);
    let wrong = complaints(&all, |(exercise, task)| {
        let (of_solution, of_hole) = (judged(task, solution(exercise)), judged(task, task.hole.into()));
        let passes = matches!(of_solution.1, Verdict::Passed { rays, .. } if rays > 500);
        // Where lists are short, both schedules take about as many passes.
        let latest = if task.is_schedule() { 3 } else { 2 };
        let is_found = !matches!(of_hole.1, Verdict::Passed { .. } | Verdict::Mistake { .. }) && of_hole.0 <= latest;
        (!passes || !is_found).then(|| format!("{}: {of_solution:?}, {of_hole:?}", exercise.name))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// An answer: what it replaces in the solution, and where it is found to be wrong: stream and layer, or the verdict.
type Answer = (&'static str, &'static str, &'static str, &'static [&'static str]);

const ANSWERS: &[Answer] = &[
    // The plane behind; always the upper face; a distance; no INF; tDelta; from the world's origin; INF for small components.
    ("1-tmax", "vec3f(cell + ahead)", "vec3f(cell)", &["tmax"]),
    ("1-tmax", "select(vec3i(0), vec3i(1), direction > vec3f(0.0))", "vec3i(1)", &["tmax"]),
    ("1-tmax", "(plane - origin) / direction", "plane - origin", &["tmax"]),
    ("1-tmax", "return select(t, vec3f(INF), direction == vec3f(0.0));", "return t;", &["tmax"]),
    ("1-tmax", "(plane - origin) / direction", "abs(grid.width / direction)", &["tmax"]),
    ("1-tmax", "(plane - origin) / direction", "(plane + grid.corner - origin) / direction", &["tmax"]),
    ("1-tmax", "direction == vec3f(0.0)", "abs(direction) < vec3f(0.1)", &["tmax"]),
    ("1-tmax", "vec3f(cell + ahead)", "vec3f(cell) + 0.5", &["tmax"]),
    // The largest; z is forgotten; ties; all axes grow; another grows; none grows; backwards; always towards larger ones.
    (
        "2-step",
        "here.tmax.x < here.tmax.y && here.tmax.x < here.tmax.z",
        "here.tmax.x > here.tmax.y && here.tmax.x > here.tmax.z",
        &["state.cell", "state.tag"],
    ),
    (
        "2-step",
        "here.tmax.x < here.tmax.y && here.tmax.x < here.tmax.z",
        "here.tmax.x < here.tmax.y",
        &["state.cell", "state.tag"],
    ),
    ("2-step", "if (here.tmax.x < here.tmax.y", "if (here.tmax.x <= here.tmax.y", &["state.cell"]),
    ("2-step", "here.tmax.y < here.tmax.z) {", "here.tmax.y <= here.tmax.z) {", &["state.cell"]),
    ("2-step", "next.tmax.z += t_delta.z;", "next.tmax += t_delta;", &["tmax"]),
    ("2-step", "next.tmax.y += t_delta.y;", "next.tmax.x += t_delta.x;", &["tmax"]),
    ("2-step", "next.tmax.x += t_delta.x;", "", &["tmax"]),
    ("2-step", "next.cell.x += forward.x;", "next.cell.x -= forward.x;", &["state.cell", "state.tag"]),
    ("2-step", "next.cell.z += forward.z;", "next.cell.z += 1;", &["state.cell", "state.tag"]),
    // A condition is missing; weights exchanged; one side only; another length; another sign; an epsilon for small ones.
    ("3-triangle", "u >= 0.0 && ", "", &["state.tag", "hit.u", "state.t"]),
    ("3-triangle", "v >= 0.0 && ", "", &["state.tag", "hit.u", "state.t"]),
    ("3-triangle", "u + v <= 1.0 && ", "", &["state.tag", "hit.u", "state.t"]),
    ("3-triangle", "Candidate(t, u, v,", "Candidate(t, v, u,", &["hit.u"]),
    ("3-triangle", "t > 0.0 && ", "", &["state.tag", "hit.u", "state.t"]),
    ("3-triangle", "det != 0.0", "det > 0.0", &["state.tag", "state.t", "hit.u"]),
    ("3-triangle", "let t = dot3(edge2, q) / det;", "let t = dot3(edge2, q) / det * length(direction);", &["state.t"]),
    ("3-triangle", "cross3(direction, edge2)", "cross3(edge2, direction)", &["state.t", "state.tag", "hit.u"]),
    ("3-triangle", "det != 0.0", "abs(det) > 0.001", &["state.t", "state.tag", "hit.u"]),
    ("3-triangle", "u + v <= 1.0", "u <= 1.0 && v <= 1.0", &["state.tag", "hit.u", "state.t"]),
    // At once; never; the last face; one axis; the other way round; the background.
    ("4-list-end", " && nearest_t <= exit", "", &["state.tag"]),
    ("4-list-end", "select(TRAV, SHADE, tag == ISECT_HIT && nearest_t <= exit)", "TRAV", &["state.tag"]),
    ("4-list-end", "min(tmax.x, min(tmax.y, tmax.z))", "max(tmax.x, max(tmax.y, tmax.z))", &["state.tag"]),
    ("4-list-end", "min(tmax.x, min(tmax.y, tmax.z))", "tmax.x", &["state.tag"]),
    ("4-list-end", "nearest_t <= exit", "nearest_t >= exit", &["state.tag"]),
    ("4-list-end", "select(TRAV,", "select(BACKGROUND,", &["state.tag"]),
    (
        "4-list-end",
        "select(TRAV, SHADE, tag == ISECT_HIT && nearest_t <= exit)",
        "select(SHADE, TRAV, nearest_t > exit || tag == ISECT_HIT)",
        &["state.tag"],
    ),
    // The first schedule; a loop that nothing begins; one that never ends; no colour; no start.
    ("5-schedule", "{ run = \"intersect\" }", "{ until_idle = \"intersect\" }", &["slow"]),
    ("5-schedule", "[\"intersect\", \"traverse_grid\"]", "[\"traverse_grid\"]", &["fails"]),
    ("5-schedule", "{ run = \"traverse_grid\" },", "", &["fails"]),
    ("5-schedule", "{ run = \"shade\" },", "", &["fails"]),
    ("5-schedule", "{ run = \"setup\" },", "", &["fails"]),
    // No clamp; none at the lower faces; to the nearest; up; from 1; another order; another base; x's width for all; one cell too few.
    (
        "6-resolution",
        "clamp(vec3i(floor(point / width)), vec3i(0), cells - vec3i(1))",
        "vec3i(floor(point / width))",
        &["tmax", "state.cell"],
    ),
    (
        "6-resolution",
        "clamp(vec3i(floor(point / width)), vec3i(0), cells - vec3i(1))",
        "min(vec3i(floor(point / width)), cells - vec3i(1))",
        &["tmax", "state.cell"],
    ),
    ("6-resolution", "floor(point / width)", "round(point / width)", &["tmax", "state.cell"]),
    ("6-resolution", "floor(point / width)", "ceil(point / width)", &["tmax", "state.cell"]),
    ("6-resolution", "vec3i(floor(point / width))", "vec3i(floor(point / width)) + 1", &["tmax", "state.cell"]),
    (
        "6-resolution",
        "cell.x + cells.x * (cell.y + cells.y * cell.z)",
        "cell.z + cells.z * (cell.y + cells.y * cell.x)",
        &["state.cell"],
    ),
    (
        "6-resolution",
        "cell.x + cells.x * (cell.y + cells.y * cell.z)",
        "cell.x + cells.y * (cell.y + cells.x * cell.z)",
        &["state.cell"],
    ),
    (
        "6-resolution",
        "cell.x + cells.x * (cell.y + cells.y * cell.z)",
        "cell.x + cells.x * (cell.y + cells.x * cell.z)",
        &["state.cell"],
    ),
    ("6-resolution", "size / vec3f(cells)", "vec3f(size.x / f32(cells.x))", &["tmax", "state.cell"]),
    ("6-resolution", "cells - vec3i(1))", "cells - vec3i(2))", &["tmax", "state.cell"]),
    // Open at edges; one side only; weights at wrong corners; a corner exchanged; a tolerance.
    (
        "7-crack",
        "q.x * r.y >= q.y * r.x && r.x * p.y >= r.y * p.x && p.x * q.y >= p.y * q.x",
        "q.x * r.y > q.y * r.x && r.x * p.y > r.y * p.x && p.x * q.y > p.y * q.x",
        &["leaks"],
    ),
    ("7-crack", "left || right", "left", &["state.tag", "state.t", "hit.u"]),
    (
        "7-crack",
        "Weights(q.x * r.y - q.y * r.x, r.x * p.y - r.y * p.x,",
        "Weights(r.x * p.y - r.y * p.x, q.x * r.y - q.y * r.x,",
        &["hit.u"],
    ),
    ("7-crack", "q.x * r.y >= q.y * r.x && ", "", &["state.tag", "hit.u", "state.t"]),
    ("7-crack", "r.x * p.y - r.y * p.x,", "r.y * p.x - r.x * p.y,", &["hit.u", "state.t", "state.tag"]),
    (
        "7-crack",
        "q.x * r.y >= q.y * r.x && r.x * p.y >= r.y * p.x && p.x * q.y >= p.y * q.x",
        "q.x * r.y - q.y * r.x >= -0.000001 && r.x * p.y - r.y * p.x >= -0.000001 && p.x * q.y - p.y * q.x >= -0.000001",
        &["state.tag", "hit.u", "state.t"],
    ),
    // Towards the surface; no end; as the light travels; a needless ray; on the surface; another length; kinds exchanged.
    (
        "8-shadow",
        "lights[i].position - origin",
        "origin - lights[i].position",
        &["shadow_direction", "state.tag", "color"],
    ),
    ("8-shadow", "end = end_before(lights[i].position, direction);", "", &["state.t"]),
    (
        "8-shadow",
        "var direction = -lights[i].direction;",
        "var direction = lights[i].direction;",
        &["shadow_direction", "state.tag", "color"],
    ),
    ("8-shadow", "dot3(start.normal, direction) > 0.0", "true", &["state.tag", "shadow_direction", "color", "pending"]),
    (
        "8-shadow",
        "let origin = leaving(start);",
        "let origin = start.point + start.normal * 0.001;",
        &["shadow_origin"],
    ),
    (
        "8-shadow",
        "direction = lights[i].position - origin;",
        "direction = normalize(lights[i].position - origin);",
        &["shadow_direction", "state.t"],
    ),
    (
        "8-shadow",
        "lights[i].kind != 1u",
        "lights[i].kind == 1u",
        &["shadow_direction", "state.t", "state.tag", "color"],
    ),
    (
        "8-shadow",
        "dot3(start.normal, direction) > 0.0",
        "dot3(start.normal, direction) < 0.0",
        &["state.tag", "color", "shadow_direction"],
    ),
    ("8-shadow", "end_before(lights[i].position, direction)", "1.0", &["state.t"]),
];

#[test]
fn wrong_answers_are_named_by_their_place_and_with_a_hint() {
    let wrong = complaints(ANSWERS, |(name, from, to, places)| {
        let (exercise, task) = tasks().find(|(exercise, _)| exercise.name == *name).expect("an exercise");
        let source = solution(exercise);
        assert!(source.contains(from), "{name} has no {from:?}");
        let (_, verdict) = judged(task, source.replacen(from, to, 1));
        let place = match &verdict {
            Verdict::Differs(difference) => format!("{}.{}", difference.stream, difference.layer),
            other => other.name().into(),
        };
        let is_named = places.iter().any(|wanted| place == *wanted || place.starts_with(&format!("{wanted}.")));
        let hint = task.hint(&verdict);
        (!is_named || hint.is_none()).then(|| format!("{name}: {to}: {place}, {hint:?}: {verdict:?}"))
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Signed volumes also give the neighbour the same numbers.
#[test]
fn another_repair_of_the_crack_passes_too() {
    let (_, task) = tasks().find(|(exercise, _)| exercise.name == "7-crack").expect("an exercise");
    let (first, rest) = task.hole.split_once("    // HOLE").expect("a hole");
    let (_, last) = rest.split_once("return Weights").expect("its end");
    let volumes = "    let of_a = dot3(direction, cross3(b, c));\n    let of_b = dot3(direction, cross3(c, a));\n    let \
                   of_c = dot3(direction, cross3(a, b));\n    let is_inside = min(of_a, min(of_b, of_c)) >= 0.0 || \
                   max(of_a, max(of_b, of_c)) <= 0.0;\n    return Weights";
    let (_, verdict) = judged(task, format!("{first}{volumes}{last}"));
    assert!(matches!(verdict, Verdict::Passed { .. }), "{verdict:?}");
}

/// What a student gets is complete in itself: its pages lead to each other, and to nothing else.
#[test]
fn the_pages_lead_to_files_of_the_course_and_have_no_solution() {
    let all: Vec<_> = files().collect();
    let names: BTreeSet<&str> = all.iter().map(|(name, _)| *name).collect();
    for exercise in &EXERCISES {
        assert!(names.contains(&*format!("{}.md", exercise.name)), "{}", exercise.name);
        assert!(names.contains(&*exercise.file()), "{}", exercise.name);
    }
    for (name, text) in all.iter().filter(|(name, _)| name.ends_with(".md")) {
        let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
        for link in links.filter(|link| !link.contains("://")) {
            assert!(names.contains(link), "{name}: {link}");
        }
    }
    assert!(all.iter().all(|(name, text)| !name.starts_with("solutions") && !text.contains("A solution of")));
    for (_, task) in tasks() {
        assert!(
            (task.is_schedule() || task.hole.contains("HOLE"))
                && matches!(task.read("a".into(), task.hole.into()), Err(Verdict::Untouched))
        );
        let with_other_ends = task.hole.replace('\n', " \r\n");
        assert!(matches!(task.read("a".into(), with_other_ends.into()), Err(Verdict::Untouched)));
    }
}
