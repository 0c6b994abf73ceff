//! The floors of `kernels/src`: no module uses one on a higher floor, and modules of a folder do not use each other in
//! a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use raystep_tests::floors::{FLOORS, Names, arrows_of, modules_of, sources};

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

/// Arrows to a higher floor, circles, and modules without a floor.
fn faults(files: &[(String, String)], floors: &[&[&str]]) -> Vec<String> {
    let modules = modules_of(files);
    let arrows = arrows_of(&modules);
    let floor = |module: &Names| {
        let name = module.get(1)?.as_str();
        floors.iter().position(|floor| floor.contains(&name))
    };
    let mut faults = Vec::new();
    for module in modules.keys().filter(|module| module.len() == 2 && floor(module).is_none()) {
        faults.push(format!("{} has no floor", module[1]));
    }
    for arrow in arrows.iter().filter(|arrow| floor(&arrow.to) > floor(&arrow.from)) {
        faults.push(format!("up: {}", arrow.place));
    }
    // Each arrow counts between the two modules of the innermost common folder in which its paths differ.
    let mut siblings: BTreeMap<&[String], BTreeMap<(&str, &str), &str>> = BTreeMap::new();
    for arrow in &arrows {
        let common = arrow.from.iter().zip(&arrow.to).take_while(|(a, b)| a == b).count();
        if let (Some(from), Some(to)) = (arrow.from.get(common), arrow.to.get(common)) {
            siblings.entry(&arrow.from[..common]).or_default().entry((from, to)).or_insert(&arrow.place);
        }
    }
    for (folder, arrows) in siblings {
        if let Some(circle) = circle(&arrows) {
            let mut text = format!("a circle in {}:", folder.join("::"));
            circle.iter().for_each(|place| write!(text, "\n    {place}").expect("a string"));
            faults.push(text);
        }
    }
    faults
}

#[test]
fn no_module_reaches_up_or_in_a_circle() {
    let files = sources("kernels/src");
    let arrows = arrows_of(&modules_of(&files)).len();
    assert!(files.len() > 80 && arrows > 500, "{} files, {arrows} arrows", files.len());
    let faults = faults(&files, FLOORS);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn an_arrow_up_and_a_circle_are_found() {
    let of = |sources: &[(&str, &str)]| {
        let files: Vec<_> =
            sources.iter().map(|&(file, text)| (format!("kernels/src/{file}"), text.to_owned())).collect();
        faults(&files, &[&["low", "beside"], &["high"]])
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
    assert_eq!(of(&[("new.rs", "")]), ["new has no floor"]);
}
