//! The layers of `kernels/src`: no module uses a higher one, and modules on the same level do not use each other in a
//! cycle.
//!
//! Dependencies are read from the paths in the sources, with re-exports followed to the module that defines the item.
//! Test-only code is ignored; a folder's own file and the modules below it count as one.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

/// The modules of the crate, lowest first: each may use those in its own line and in the lines before it.
const FLOORS: &[&[&str]] = &[
    &["numbers"],
    &["shared"],
    &["options"],
    &["tables"],
    &["structures"],
    &["scene_data"],
    &["program"],
    &["programs"],
    &["compose", "shader"],
    &["plan"],
    &["executor"],
    &["renderer"],
    &["history"],
    &["export"],
];

/// A path in a source file: names separated by `::`, starting at the crate's root.
type Names = Vec<String>;

/// A module of the crate.
#[derive(Default)]
struct Module {
    file: String,
    /// The source of each name that it imports or re-exports.
    imports: BTreeMap<String, Names>,
    /// Every path in its code, and its line.
    paths: Vec<(usize, Names)>,
}

/// A dependency between two modules, and where it occurs.
struct Arrow {
    from: Names,
    to: Names,
    place: String,
}

/// The code of a file without comments, strings and test-only items; line numbers stay the same.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = match c {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '"' => string_end(rest),
            '\'' if rest.starts_with("'\"'") => 3,
            '#' if rest.starts_with("#[cfg(test)]") => item_end(rest),
            _ => {
                code.push(c);
                rest = &rest[c.len_utf8()..];
                continue;
            }
        };
        code.extend(rest[..skipped].chars().filter(|&c| c == '\n'));
        rest = &rest[skipped..];
    }
    code
}

/// The end of the string that begins here.
fn string_end(text: &str) -> usize {
    let mut escaped = false;
    let is_end = |(_, c): &(usize, char)| {
        let ends = *c == '"' && !escaped;
        escaped = *c == '\\' && !escaped;
        ends
    };
    text.char_indices().skip(1).find(is_end).map_or(text.len(), |(at, _)| at + 1)
}

/// The end of the item that begins here: its semicolon, or the brace that closes its block.
fn item_end(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 && (c == '}' || c == ';') {
            return at + 1;
        }
    }
    text.len()
}

/// The paths in a use tree such as `a::{b, c::{self, d as e}}`, each with the name that it introduces.
fn expand(tree: &str, before: &[String], all: &mut Vec<(String, Names)>) {
    let tree = tree.trim();
    let mut depth = 0;
    let comma = tree.char_indices().filter(|&(_, c)| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    let mut parts = Vec::new();
    let mut start = 0;
    for (at, _) in comma {
        parts.push(&tree[start..at]);
        start = at + 1;
    }
    parts.push(&tree[start..]);
    for part in parts.into_iter().map(str::trim).filter(|part| !part.is_empty()) {
        let (path, inner) = part.split_once('{').map_or((part, None), |(path, inner)| (path, inner.strip_suffix('}')));
        let (path, name) = path.split_once(" as ").map_or((path, None), |(path, name)| (path, Some(name.trim())));
        let mut names = before.to_vec();
        names.extend(path.split("::").map(str::trim).filter(|n| !n.is_empty() && *n != "self").map(str::to_owned));
        match inner {
            Some(inner) => expand(inner, &names, all),
            None => {
                let last = name.map(str::to_owned).or_else(|| names.last().cloned()).unwrap_or_default();
                all.push((last, names));
            }
        }
    }
}

/// A path as written in `module`, made absolute from the crate's root; `None` for a path that leaves the crate.
fn absolute(written: &[String], module: &[String], modules: &BTreeMap<Names, Module>) -> Option<Names> {
    let (first, rest) = written.split_first()?;
    let mut base = match first.as_str() {
        "crate" => Vec::new(),
        "super" => module.split_last()?.1.to_vec(),
        "self" => module.to_vec(),
        name => {
            let child = [module, &[name.to_owned()]].concat();
            return modules.contains_key(&child).then(|| [module, written].concat());
        }
    };
    let supers = rest.iter().take_while(|name| *name == "super").count();
    base.truncate(base.len().checked_sub(supers)?);
    base.extend_from_slice(&rest[supers..]);
    Some(base)
}

/// The module that defines what an absolute path names, with re-exports followed.
fn owner(path: &[String], modules: &BTreeMap<Names, Module>, depth: usize) -> Names {
    let mut at = Vec::new();
    for (i, name) in path.iter().enumerate() {
        let child = [at.as_slice(), std::slice::from_ref(name)].concat();
        if modules.contains_key(&child) {
            at = child;
            continue;
        }
        let import = modules.get(&at).and_then(|module| module.imports.get(name));
        return match import {
            Some(import) if depth > 0 => owner(&[import.as_slice(), &path[i + 1..]].concat(), modules, depth - 1),
            _ => at,
        };
    }
    at
}

/// Parses the modules of a crate from its files, with paths relative to `src`.
fn modules_of(files: &[(String, String)]) -> BTreeMap<Names, Module> {
    let module_of = |file: &str| -> Names {
        let path = file.trim_end_matches(".rs");
        let path = path.strip_suffix("/mod").unwrap_or(if path == "lib" { "" } else { path });
        path.split('/').filter(|name| !name.is_empty()).map(str::to_owned).collect()
    };
    let mut modules: BTreeMap<Names, Module> = BTreeMap::new();
    for (file, _) in files {
        modules.insert(module_of(file), Module { file: file.clone(), ..Module::default() });
    }
    for (file, text) in files {
        let name = module_of(file);
        let code = code_of(text);
        let (mut imports, mut paths) = (BTreeMap::new(), Vec::new());
        for (written, line, as_name) in paths_in(&code) {
            if let Some(path) = absolute(&written, &name, &modules) {
                if let Some(as_name) = as_name {
                    imports.insert(as_name, path.clone());
                }
                paths.push((line, path));
            }
        }
        let module = modules.get_mut(&name).expect("just inserted");
        (module.imports, module.paths) = (imports, paths);
    }
    modules
}

/// Every path of the crate that code mentions: as written, its line, and the name that a `use` introduces for it.
fn paths_in(code: &str) -> Vec<(Names, usize, Option<String>)> {
    let line_of = |at: usize| 1 + code[..at].matches('\n').count();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut all = Vec::new();
    let mut uses = Vec::new();
    for (at, _) in code.match_indices("use ") {
        if code[..at].ends_with(is_word) {
            continue;
        }
        let end = at + code[at..].find(';').unwrap_or(0);
        uses.push(at..end);
        let mut expanded = Vec::new();
        expand(&code[at + 4..end], &[], &mut expanded);
        all.extend(expanded.into_iter().map(|(name, path)| (path, line_of(at), Some(name))));
    }
    for start in ["crate::", "super::"] {
        for (at, _) in code.match_indices(start) {
            if code[..at].ends_with(is_word) || code[..at].ends_with("::") || uses.iter().any(|u| u.contains(&at)) {
                continue;
            }
            let path = code[at..].split(|c| !is_word(c) && c != ':').next().unwrap_or_default();
            all.push((path.split("::").filter(|n| !n.is_empty()).map(str::to_owned).collect(), line_of(at), None));
        }
    }
    all
}

fn arrows_of(modules: &BTreeMap<Names, Module>) -> Vec<Arrow> {
    let mut arrows = Vec::new();
    // The crate's root re-exports from everywhere, so it is ignored.
    for (from, module) in modules.iter().filter(|(from, _)| !from.is_empty()) {
        for (line, path) in &module.paths {
            let place = format!("{}:{line}: {} -> {}", module.file, from.join("::"), path.join("::"));
            arrows.push(Arrow { from: from.clone(), to: owner(path, modules, 8), place });
        }
    }
    arrows
}

/// A cycle in the dependencies, as the list of those that form it.
fn circle<'a>(arrows: &BTreeMap<(&'a str, &'a str), &'a str>) -> Option<Vec<&'a str>> {
    // A module that no remaining one depends on is in no cycle.
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

/// Dependencies on higher modules, cycles, and modules missing from the list.
fn faults(files: &[(String, String)], floors: &[&[&str]]) -> Vec<String> {
    let modules = modules_of(files);
    let arrows = arrows_of(&modules);
    let floor = |module: &Names| floors.iter().position(|floor| floor.contains(&module[0].as_str()));
    let mut faults = Vec::new();
    for module in modules.keys().filter(|module| module.len() == 1 && floor(module).is_none()) {
        faults.push(format!("{} has no floor", module[0]));
    }
    for arrow in arrows.iter().filter(|arrow| !arrow.to.is_empty() && floor(&arrow.to) > floor(&arrow.from)) {
        faults.push(format!("up: {}", arrow.place));
    }
    // The two paths separate at these sibling modules.
    let mut siblings: BTreeMap<&[String], BTreeMap<(&str, &str), &str>> = BTreeMap::new();
    for arrow in &arrows {
        let common = arrow.from.iter().zip(&arrow.to).take_while(|(a, b)| a == b).count();
        if let (Some(from), Some(to)) = (arrow.from.get(common), arrow.to.get(common)) {
            siblings.entry(&arrow.from[..common]).or_default().entry((from, to)).or_insert(&arrow.place);
        }
    }
    for (folder, arrows) in siblings {
        if let Some(circle) = circle(&arrows) {
            let mut text = format!("a cycle in {}:", if folder.is_empty() { "src".into() } else { folder.join("/") });
            circle.iter().for_each(|place| write!(text, "\n    {place}").expect("a string"));
            faults.push(text);
        }
    }
    faults
}

fn read(folder: &Path, prefix: &str, files: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("a name");
        if entry.file_type().expect("a type").is_dir() {
            read(&entry.path(), &format!("{prefix}{name}/"), files);
        } else if name.ends_with(".rs") && name != "tests.rs" {
            files.push((format!("{prefix}{name}"), std::fs::read_to_string(entry.path()).expect("text")));
        }
    }
}

#[test]
fn no_module_reaches_up_or_in_a_circle() {
    let mut files = Vec::new();
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "", &mut files);
    files.sort();
    let arrows = arrows_of(&modules_of(&files)).len();
    assert!(files.len() > 80 && arrows > 500, "{} files, {arrows} arrows", files.len());
    let faults = faults(&files, FLOORS);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn an_arrow_up_and_a_circle_are_found() {
    let of = |sources: &[(&str, &str)]| {
        let files: Vec<_> = sources.iter().map(|&(file, text)| (file.to_owned(), text.to_owned())).collect();
        faults(&files, &[&["low", "beside"], &["high"]])
    };
    let high = ("high.rs", "use crate::low::{self, A};");
    let low = "/* */ // use crate::high::B;\nfn f() { \"crate::high::B\"; }\n#[cfg(test)]\nmod tests { use crate::high::B; }\n";
    assert_eq!(of(&[("low.rs", low), high]), [""; 0]);
    for up in ["use crate::high::B;", "fn f() { crate::high::b() }", "use crate::Short;", "use super::high;"] {
        let found = of(&[("low.rs", &format!("{low}{up}")), high, ("lib.rs", "pub use high::C as Short;")]);
        assert!(found.len() == 2 && found[0].starts_with("up: low.rs:5: "), "{up}: {found:?}");
        assert!(found[1].starts_with("a cycle in src:"), "{up}: {found:?}");
    }
    let beside = [("low.rs", "use crate::beside::A;"), ("beside/mod.rs", "pub use inner::A;"), ("beside/inner.rs", "")];
    assert_eq!(of(&beside), [""; 0]);
    let back = [beside[0], beside[1], ("beside/inner.rs", "\nuse crate::low::{B, C};")];
    let found = of(&back);
    assert!(found.len() == 1 && found[0].contains("beside/inner.rs:2: beside::inner -> low::B"), "{found:?}");
    assert_eq!(of(&[("new.rs", "")]), ["new has no floor"]);
}
