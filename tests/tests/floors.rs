//! The floors of the crates: no module uses one on a higher floor, and modules of a folder do not use each other in a
//! circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use raystep_tests::floors::{ALL_FLOORS, Arrow, CRATES, KNOWN_CIRCLES, Names, arrows_of, modules_of, sources};

/// A circle of arrows, if there is one, as the values of its arrows.
fn circle<'a>(arrows: &BTreeMap<(&'a str, &'a str), &'a str>) -> Option<Vec<&'a str>> {
    // An arrow that no other one leads to, or continues, is not part of a circle.
    let mut rest: BTreeSet<(&str, &str)> = arrows.keys().copied().collect();
    loop {
        let (starts, ends): (BTreeSet<_>, BTreeSet<_>) = rest.iter().copied().unzip();
        let before = rest.len();
        rest.retain(|(from, to)| ends.contains(from) && starts.contains(to));
        if rest.len() == before {
            break;
        }
    }
    let mut at = rest.first()?.0;
    let mut way = Vec::new();
    loop {
        let step = *rest.range((at, "")..).next()?;
        if let Some(begin) = way.iter().position(|&(from, _)| from == step.0) {
            return Some(way[begin..].iter().map(|step| arrows[step]).collect());
        }
        way.push(step);
        at = step.1;
    }
}

/// The arrows between modules of a folder, each with one place in the sources.
type Siblings<'a> = BTreeMap<(&'a str, &'a str), &'a str>;

/// Each arrow counts between the two modules of the innermost common folder in which its paths differ.
fn siblings(arrows: &[Arrow]) -> BTreeMap<String, Siblings<'_>> {
    let mut siblings: BTreeMap<String, Siblings<'_>> = BTreeMap::new();
    for arrow in arrows {
        let common = arrow.from.iter().zip(&arrow.to).take_while(|(a, b)| a == b).count();
        if let (Some(from), Some(to), true) = (arrow.from.get(common), arrow.to.get(common), common > 0) {
            let folder = arrow.from[..common].join("::");
            siblings.entry(folder).or_default().entry((from, to)).or_insert(&arrow.place);
        }
    }
    siblings
}

/// Folders of modules by their paths, each with its floors.
type Floors<'a> = [(&'a str, &'a [&'a [&'a str]])];

/// Arrows to a higher floor, circles except those that are `known`, and modules without a floor.
fn faults(files: &[(String, String)], floors: &Floors<'_>, known: &[(&str, &[&str])]) -> Vec<String> {
    let modules = modules_of(files);
    let arrows = arrows_of(&modules);
    let mut faults = Vec::new();
    for (folder, floors) in floors {
        let folder: Vec<&str> = folder.split("::").collect();
        let inside = |path: &Names| folder.iter().zip(path).all(|(a, b)| a == b) && path.len() > folder.len();
        let floor = |path: &Names| floors.iter().position(|floor| floor.contains(&path[folder.len()].as_str()));
        for module in modules.keys().filter(|m| inside(m) && m.len() == folder.len() + 1 && floor(m).is_none()) {
            faults.push(format!("{} has no floor", module.join("::")));
        }
        let within = arrows.iter().filter(|arrow| inside(&arrow.from) && inside(&arrow.to));
        for arrow in within.filter(|arrow| floor(&arrow.to) > floor(&arrow.from)) {
            faults.push(format!("up: {}", arrow.place));
        }
    }
    let mut siblings = siblings(&arrows);
    for (folder, modules) in known {
        let Some(arrows) = siblings.get_mut(*folder) else { continue };
        let is_in = |(from, to): &(&str, &str)| modules.contains(from) && modules.contains(to);
        let own: Siblings<'_> =
            arrows.iter().filter(|(arrow, _)| is_in(arrow)).map(|(a, place)| (*a, *place)).collect();
        if circle(&own).is_none() {
            faults.push(format!("no circle in {folder} any more, remove it from the list: {}", modules.join(", ")));
        }
        arrows.retain(|arrow, _| !is_in(arrow));
    }
    for (folder, arrows) in siblings {
        if let Some(circle) = circle(&arrows) {
            let mut text = format!("a circle in {folder}:");
            circle.iter().for_each(|place| write!(text, "\n    {place}").expect("a string"));
            faults.push(text);
        }
    }
    faults
}

#[test]
fn no_module_reaches_up_or_in_a_circle() {
    let files: Vec<_> = CRATES.iter().flat_map(|(folder, _)| sources(folder)).collect();
    let arrows = arrows_of(&modules_of(&files)).len();
    assert!(files.len() > 500 && arrows > 4000, "{} files, {arrows} arrows", files.len());
    let faults = faults(&files, ALL_FLOORS, KNOWN_CIRCLES);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn an_arrow_up_and_a_circle_are_found() {
    let of = |sources: &[(&str, &str)]| {
        let files: Vec<_> =
            sources.iter().map(|&(file, text)| (format!("kernels/src/{file}"), text.to_owned())).collect();
        faults(&files, &[("raystep_kernels", &[&["low", "beside"], &["high"]])], &[])
    };
    let high = ("high.rs", "use crate::low::{self, A};");
    let low = "/* */ // use crate::high::B;\nfn f() { \"crate::high::B\"; }\n#[cfg(test)]\nmod tests { use crate::high::B; }\n";
    assert_eq!(of(&[("low.rs", low), high]), [""; 0]);
    for up in ["use crate::high::B;", "fn f() { crate::high::b() }", "use crate::Short;", "use super::high;"] {
        let found = of(&[("low.rs", &format!("{low}{up}")), high, ("lib.rs", "pub use high::C as Short;")]);
        assert!(found.len() == 2 && found[0].starts_with("up: kernels/src/low.rs:5: "), "{up}: {found:?}");
        assert!(found[1].starts_with("a circle in raystep_kernels:"), "{up}: {found:?}");
    }
    let beside = [("low.rs", "use crate::beside::A;"), ("beside/mod.rs", "pub use inner::A;"), ("beside/inner.rs", "")];
    assert_eq!(of(&beside), [""; 0]);
    let back = [beside[0], beside[1], ("beside/inner.rs", "\nuse crate::low::{B, C};")];
    let found = of(&back);
    assert!(
        found.len() == 1
            && found[0].contains("beside/inner.rs:2: raystep_kernels::beside::inner -> raystep_kernels::low::B"),
        "{found:?}"
    );
    assert_eq!(of(&[("new.rs", "")]), ["raystep_kernels::new has no floor"]);
}

#[test]
fn a_known_circle_is_no_fault_until_it_is_gone() {
    let files = |back: &str| {
        [("a.rs", "use crate::b::B;"), ("b.rs", back)].map(|(file, text)| (format!("app/src/{file}"), text.to_owned()))
    };
    let floors: &Floors<'_> = &[("raystep", &[&["a", "b"]])];
    let known: &[(&str, &[&str])] = &[("raystep", &["a", "b"])];
    let with_circle = files("use crate::a::A;");
    assert_eq!(faults(&with_circle, floors, known), [""; 0]);
    assert!(faults(&with_circle, floors, &[])[0].starts_with("a circle in raystep:"));
    assert_eq!(faults(&files(""), floors, known), ["no circle in raystep any more, remove it from the list: a, b"]);
}

/// The parts of the inspector's state that panels share: fields of their context.
const PARTS: [&str; 8] = ["other", "selection", "display", "asks", "bookmarks", "watches", "log", "runs"];

/// Whether the code of a panel uses a part.
fn touches(code: &str, part: &str) -> bool {
    let is_end = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    code.match_indices(&format!("cx.{part}")).any(|(at, found)| is_end(&code[at + found.len()..]))
}

#[test]
fn the_file_of_a_panel_says_what_it_touches() {
    let files = sources("inspector/src/ui/panels");
    let is_panel = |(_, text): &&(String, String)| text.contains("\nimpl Panel for ");
    let mut faults = Vec::new();
    let mut shared: Vec<&String> = files.iter().map(|(file, _)| file).collect();
    for (file, head) in files.iter().filter(is_panel) {
        let folder = format!("{}/", file.trim_end_matches(".rs"));
        let is_own = |other: &String| other == file || other.starts_with(&folder);
        shared.retain(|other| !is_own(other));
        let own = files.iter().filter(|(other, _)| is_own(other));
        let code: String = own.map(|(_, text)| text.as_str()).collect();
        let touched: Vec<&str> = PARTS.into_iter().filter(|part| touches(&code, part)).collect();
        let touched = if touched.is_empty() { "nothing".into() } else { touched.join(", ") };
        let wanted = format!("//! Touches: {touched}.");
        if !head.lines().take_while(|line| line.starts_with("//!")).any(|line| line == wanted) {
            faults.push(format!("{file}: expected the line \"{wanted}\" in its head"));
        }
    }
    // What several panels use is given parts, and not all of them.
    for (file, text) in files.iter().filter(|(file, _)| shared.contains(&file)) {
        if text.contains("Context<") {
            faults.push(format!("{file} is no panel: expected the parts that it needs, not the whole context"));
        }
    }
    assert!(files.iter().filter(is_panel).count() >= 20 && faults.is_empty(), "{}", faults.join("\n"));
}
