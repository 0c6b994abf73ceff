//! The documentation: every link in it leads to a file, and to a heading if it names one. And the README is short.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Pages outside of the folder `docs`.
const PAGES: [&str; 4] = ["README.md", "CHANGELOG.md", "scenes/README.md", "app/python/README.md"];

/// What fits on a screen or two.
const README_LINES: usize = 90;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Markdown files in a folder and below.
fn pages_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries
        .flat_map(|path| match path.extension() {
            _ if path.is_dir() => pages_in(&path),
            Some(end) if end == "md" => vec![path],
            _ => Vec::new(),
        })
        .collect()
}

/// The lines that are neither code blocks nor indented code.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    page.lines().filter(move |line| {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence && !line.starts_with("    ")
    })
}

/// The anchors of headings, as GitHub makes them: lower case, words joined by hyphens, without punctuation.
fn anchors(page: &str) -> BTreeSet<String> {
    let heading = |line: &str| Some(line.trim_start_matches('#').strip_prefix(' ')?.trim().to_lowercase());
    let headings = prose(page).filter(|line| line.starts_with('#')).filter_map(heading);
    let kept = |c: char| c.is_alphanumeric() || "-_ ".contains(c);
    headings.map(|text| text.chars().filter(|&c| kept(c)).collect::<String>().replace(' ', "-")).collect()
}

/// The targets of inline links and images.
fn links(page: &str) -> impl Iterator<Item = &str> {
    prose(page).flat_map(|line| line.split("](").skip(1)).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link)
}

/// What is wrong with a link of a page.
fn fault(page: &Path, link: &str) -> Option<String> {
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = if file.is_empty() { page.to_owned() } else { page.parent()?.join(file) };
    if !target.exists() {
        return Some(format!("{}: {link}: no such file", page.display()));
    }
    let is_page = target.extension().is_some_and(|end| end == "md");
    let is_missing = !anchor.is_empty() && is_page && !anchors(&read(&target)).contains(anchor);
    is_missing.then(|| format!("{}: {link}: no such heading", page.display()))
}

#[test]
fn every_link_of_the_documentation_leads_somewhere() {
    let root = root();
    let pages = PAGES.map(|name| root.join(name)).into_iter().chain(pages_in(&root.join("docs")));
    let mut faults = Vec::new();
    let mut checked = 0;
    for page in pages {
        let text = read(&page);
        for link in links(&text).filter(|link| !link.contains("://")) {
            checked += 1;
            faults.extend(fault(&page, link));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(checked > 100, "only {checked} links found");
}

#[test]
fn anchors_and_links_are_read_as_github_reads_them() {
    let page =
        "# What `--x` does\n\n## Scenes (slow)\n```sh\n# no heading\n```\n[a](b.md#c) ![d](e.png)\n    [no](link)\n";
    assert_eq!(anchors(page).into_iter().collect::<Vec<_>>(), ["scenes-slow", "what---x-does"]);
    assert_eq!(links(page).collect::<Vec<_>>(), ["b.md#c", "e.png"]);
    let here = root().join("README.md");
    assert_eq!(fault(&here, "docs/glossary.md#glossary"), None);
    assert!(fault(&here, "docs/nothing.md").is_some_and(|fault| fault.ends_with("no such file")));
    assert!(fault(&here, "docs/glossary.md#nothing").is_some_and(|fault| fault.ends_with("no such heading")));
}

#[test]
fn the_readme_is_short() {
    let lines = read(&root().join("README.md")).lines().count();
    assert!(lines <= README_LINES, "{lines} lines");
}
