//! Reads from the sources which modules of the crates use which others.
//!
//! The paths in the sources are resolved to the module that defines the item, through re-exports. Test code is ignored.
//! A folder's own file and the modules below it count as one.

mod tables;

use std::collections::BTreeMap;
use std::path::Path;

pub use tables::{ALL_FLOORS, FLOORS, KNOWN_CIRCLES};

/// The crates, lowest first, each with its folder and its name in paths.
pub const CRATES: [(&str, &str); 5] = [
    ("scenes/src", "raystep_scenes"),
    ("kernels/src", KERNELS),
    ("kernels/lab/src", "raystep_lab"),
    ("inspector/src", "raystep_inspector"),
    ("app/src", "raystep"),
];

/// The crate with floors.
pub const KERNELS: &str = "raystep_kernels";

/// A path in a source file: names separated by `::`, starting with a crate.
pub type Names = Vec<String>;

/// A module of a crate.
#[derive(Default)]
pub struct Module {
    /// Its file, relative to the repository's root.
    pub file: String,
    /// Its code, without comments, strings and tests.
    code: String,
    /// The names that it imports or re-exports, with their full paths.
    imports: BTreeMap<String, Names>,
    /// Every path in its code, with its line.
    paths: Vec<(usize, Names)>,
}

/// Modules by their paths.
pub type Modules = BTreeMap<Names, Module>;

/// A use of one module by another, with its place in the sources.
pub struct Arrow {
    /// The module that uses an item.
    pub from: Names,
    /// The module that defines it.
    pub to: Names,
    /// File, line, and both paths.
    pub place: String,
}

/// The code of a file without comments, strings and test code; line numbers are preserved.
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

/// The length of the string literal at the start of `text`.
fn string_end(text: &str) -> usize {
    let mut escaped = false;
    let is_end = |(_, c): &(usize, char)| {
        let ends = *c == '"' && !escaped;
        escaped = *c == '\\' && !escaped;
        ends
    };
    text.char_indices().skip(1).find(is_end).map_or(text.len(), |(at, _)| at + 1)
}

/// The length of the item at the start of `text`: up to its semicolon, or the brace that closes its block.
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

/// The paths of a use tree such as `a::{b, c::{self, d as e}}`, each with the name that it introduces.
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

/// The absolute path for a path written in `module`; `None` if it leads to a crate that is not in `modules`.
fn absolute(written: &[String], module: &[String], modules: &Modules) -> Option<Names> {
    let (first, rest) = written.split_first()?;
    let mut base = match first.as_str() {
        "crate" => module[..1].to_vec(),
        "super" => module.split_last()?.1.to_vec(),
        "self" => module.to_vec(),
        name => {
            let child = [module, &[name.to_owned()]].concat();
            if modules.contains_key(&child) {
                return Some([module, written].concat());
            }
            return modules.contains_key(&written[..1]).then(|| written.to_vec());
        }
    };
    let supers = rest.iter().take_while(|name| *name == "super").count();
    base.truncate(base.len().checked_sub(supers)?);
    base.extend_from_slice(&rest[supers..]);
    Some(base)
}

/// The module that defines the item at an absolute path; follows re-exports, at most `depth` of them.
fn owner(path: &[String], modules: &Modules, depth: usize) -> Names {
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

/// The module in a file, given by its path relative to the repository's root.
fn module_of(file: &str) -> Names {
    let inside = |(folder, name)| Some((name, file.strip_prefix(folder)?.strip_prefix('/')?));
    let (name, path) = CRATES.into_iter().find_map(inside).unwrap_or(("", file));
    let path = path.trim_end_matches(".rs");
    let path = path.strip_suffix("/mod").unwrap_or(if path == "lib" || path == "main" { "" } else { path });
    [name].into_iter().chain(path.split('/')).filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// Reads modules from files, given by name and text.
#[must_use]
pub fn modules_of(files: &[(String, String)]) -> Modules {
    let mut modules = Modules::new();
    for (file, text) in files {
        let name = module_of(file);
        modules.entry(name[..1].to_vec()).or_default();
        modules.insert(name, Module { file: file.clone(), code: code_of(text), ..Module::default() });
    }
    let mut found = Vec::new();
    for (name, module) in &modules {
        let (mut imports, mut paths) = (BTreeMap::new(), Vec::new());
        for (written, line, as_name) in paths_in(&module.code) {
            if let Some(path) = absolute(&written, name, &modules) {
                if let Some(as_name) = as_name {
                    imports.insert(as_name, path.clone());
                }
                paths.push((line, path));
            }
        }
        found.push((imports, paths));
    }
    for (module, (imports, paths)) in modules.values_mut().zip(found) {
        (module.imports, module.paths) = (imports, paths);
    }
    modules
}

/// Every path in code: as written, with its line and the name that a `use` introduces. Outside of `use`, only paths
/// that start with `crate`, `super` or the name of a crate.
fn paths_in(code: &str) -> Vec<(Names, usize, Option<String>)> {
    let line_of = |at: usize| 1 + code[..at].matches('\n').count();
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
    for start in ["crate", "super"].into_iter().chain(CRATES.map(|(_, name)| name)) {
        for (at, _) in code.match_indices(&format!("{start}::")) {
            if code[..at].ends_with(is_word) || code[..at].ends_with("::") || uses.iter().any(|u| u.contains(&at)) {
                continue;
            }
            let path = code[at..].split(|c| !is_word(c) && c != ':').next().unwrap_or_default();
            all.push((path.split("::").filter(|n| !n.is_empty()).map(str::to_owned).collect(), line_of(at), None));
        }
    }
    all
}

/// Every arrow between modules.
#[must_use]
pub fn arrows_of(modules: &Modules) -> Vec<Arrow> {
    let mut arrows = Vec::new();
    // Crate roots are ignored, since they re-export from everywhere.
    for (from, module) in modules.iter().filter(|(from, _)| from.len() > 1) {
        for (line, path) in &module.paths {
            let place = format!("{}:{line}: {} -> {}", module.file, from.join("::"), path.join("::"));
            arrows.push(Arrow { from: from.clone(), to: owner(path, modules, 8), place });
        }
    }
    arrows
}

/// Whether a module defines this item: a function, type or constant, or a method, written as `Type::method`.
#[must_use]
pub fn defines(module: &Module, item: &str) -> bool {
    let code = module.code.as_str();
    let Some((of, method)) = item.split_once("::") else {
        return ["fn", "struct", "enum", "trait", "const", "static"].iter().any(|kind| has_words(code, kind, item));
    };
    code.match_indices("impl").any(|(at, _)| {
        let block = &code[at..at + item_end(&code[at..])];
        let header = block.split('{').next().unwrap_or_default();
        !code[..at].ends_with(is_word)
            && header.split(|c| !is_word(c)).any(|word| word == of)
            && has_words(block, "fn", method)
    })
}

/// Whether code contains these two words, one after the other.
fn has_words(code: &str, first: &str, second: &str) -> bool {
    let both = format!("{first} {second}");
    code.match_indices(&both)
        .any(|(at, _)| !code[..at].ends_with(is_word) && !code[at + both.len()..].starts_with(is_word))
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The source files of a crate, except test files: paths relative to the repository's root, and texts.
#[must_use]
pub fn sources(folder: &str) -> Vec<(String, String)> {
    let mut files = Vec::new();
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder), &format!("{folder}/"), &mut files);
    files.sort();
    files
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
