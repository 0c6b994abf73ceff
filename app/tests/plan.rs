//! What `plan` says about what it leaves out.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::{Place, scene};

/// Options with their values; a flag has none.
type Words = BTreeMap<String, String>;

fn words(options: &[(&str, &str)]) -> Words {
    options.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect()
}

/// What a plan with these options leaves out because of them, with the reasons.
fn left_out(place: &Place, options: &Words) -> BTreeMap<String, String> {
    let teapot = scene("teapot.glb").display().to_string();
    let mut arguments = vec!["plan", &teapot, "--size", "8x8", "--device", "cpu", "--json", "--quiet"];
    for (name, value) in options {
        arguments.push(name);
        arguments.extend((!value.is_empty()).then_some(value.as_str()));
    }
    let plan: Value = serde_json::from_str(&place.ok(&arguments).stdout).expect("JSON");
    let all = plan["left_out"].as_array().expect("a list").iter().filter(|item| item["because"] == "options");
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    all.map(|item| (text(&item["what"]), text(&item["reason"]))).collect()
}

/// The options that a reason names, up to the first alternative: the first value of each.
fn named(reason: &str) -> Words {
    let first = reason.split(", or ").next().unwrap_or_default();
    let words: Vec<&str> = first.split(' ').collect();
    let option = |(i, word): (usize, &&str)| {
        let value = words
            .get(i + 1)
            .filter(|next| !next.starts_with("--"))
            .map_or("", |next| next.trim_end_matches([',', ':']));
        word.starts_with("--").then(|| ((*word).to_owned(), value.to_owned()))
    };
    words.iter().enumerate().filter_map(option).collect()
}

#[test]
fn what_options_leave_out_is_added_by_those_that_the_reason_names() {
    let place = Place::new();
    let mut tried = 0;
    for base in [
        &[("--accelerator", "grid"), ("--schedule", "second")][..],
        &[("--accelerator", "grid"), ("--schedule", "compact"), ("--skip", "off")],
        &[("--accelerator", "grid"), ("--schedule", "fused"), ("--numerics", "paper")],
        &[("--accelerator", "grid"), ("--schedule", "first"), ("--numerics", "paper"), ("--traversal", "3d-dda")],
        &[("--accelerator", "irregular"), ("--schedule", "compact"), ("--steps-per-pass", "1")],
        &[("--accelerator", "bvh"), ("--schedule", "fused")],
        &[("--accelerator", "bvh"), ("--schedule", "compact")],
        &[("--accelerator", "none"), ("--schedule", "second")],
        &[("--accelerator", "grid"), ("--schedule", "second"), ("--integrator", "shadows")],
        &[("--accelerator", "grid"), ("--schedule", "second"), ("--integrator", "path")],
    ] {
        let base = words(base);
        for (what, reason) in left_out(&place, &base) {
            assert!(reason.contains("needed only "), "{what} with {base:?}: {reason}");
            let more = named(&reason);
            // Some need more work than one dispatch can do, or rays with an interval: no option of this command.
            let is_possible =
                !(more.get("--accelerator").is_some_and(|a| a == "irregular") && base.contains_key("--numerics"));
            if more.is_empty() || !is_possible {
                continue;
            }
            let mut with: Words = base.clone().into_iter().chain(more.clone()).collect();
            // Options that belong to what was replaced.
            with.retain(|name, _| match name.as_str() {
                "--steps-per-pass" => !more.contains_key("--schedule") || more.contains_key(name),
                "--skip" => !more.contains_key("--accelerator") || more.contains_key(name),
                "--traversal" => {
                    let is_kept = !more.contains_key("--accelerator") && !more.contains_key("--numerics");
                    is_kept || more.contains_key(name)
                }
                _ => true,
            });
            assert!(!left_out(&place, &with).contains_key(&what), "{what}: {reason}; {with:?} does not add it");
            tried += 1;
        }
    }
    assert!(tried > 80, "{tried} reasons");
}

#[test]
fn what_a_build_leaves_out_is_added_by_the_grid_that_the_reason_names() {
    let place = Place::new();
    let of =
        |accelerator: &str| left_out(&place, &words(&[("--program", "grid-build"), ("--accelerator", accelerator)]));
    let (uniform, irregular) = (of("grid"), of("irregular"));
    assert!(uniform.len() > 60 && uniform.contains_key("kernel scan_halves"), "{uniform:?}");
    for (what, reason) in &uniform {
        assert!(named(reason)["--accelerator"] == "irregular" || reason.contains("crowded cells"), "{what}: {reason}");
        // The other kernel of a pair is for another number of digits, which the scene decides.
        let is_there = !irregular.contains_key(what);
        assert!(is_there || reason.contains("grid, if crowded cells"), "{what}: {reason}");
    }
    for (what, reason) in &irregular {
        assert_eq!(named(reason)["--accelerator"], "grid", "{what}: {reason}");
        assert!(!uniform.contains_key(what) || reason.contains("if crowded cells are divided"), "{what}: {reason}");
    }
}
