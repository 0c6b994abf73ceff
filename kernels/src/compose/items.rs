//! Declarations and imports of a module whose options are decided.

use std::collections::BTreeMap;

use super::ComposeError;
use super::options::node_end;
use super::words::{Word, code, line_of, with_comment_above};

/// A declaration.
#[derive(Debug)]
pub(super) struct Item {
    pub(super) name: String,
    /// Source text, including the comment right above it.
    pub(super) text: String,
    /// Where that begins in the module.
    pub(super) start: usize,
    /// Names that it mentions, except members.
    pub(super) mentions: Vec<String>,
}

/// A module, with its options decided.
#[derive(Debug, Default)]
pub(super) struct Module {
    /// In the file's order.
    pub(super) items: Vec<Item>,
    /// Maps an imported name to its module.
    pub(super) imports: BTreeMap<String, String>,
}

/// What is wrong with a declaration that goes on to the end of the module.
const ENDLESS: &str = "it does not end: the brackets after it do not match, or a semicolon is missing";

impl Module {
    /// Reads a module whose options are decided.
    pub(super) fn parse(name: &str, text: &str) -> Result<Self, ComposeError> {
        let words = code(text);
        let mut module = Self::default();
        let mut at = 0;
        while at < words.len() {
            let because = |message: &str| ComposeError::Malformed {
                module: name.to_owned(),
                line: line_of(text, words[at].start),
                message: message.to_owned(),
            };
            let malformed = || because("neither an import nor a declaration with a name");
            let end = node_end(&words, at, false).ok_or_else(|| because(ENDLESS))?;
            let node = &words[at..end];
            if node[0].text == "import" {
                let (from, names) = import(node).ok_or_else(malformed)?;
                module.imports.extend(names.into_iter().map(|name| (name, from.clone())));
            } else if node[0].text != ";" {
                let first = with_comment_above(text, node[0].start);
                let whole = &text[first..words[end - 1].end()];
                module.items.push(Item {
                    name: declared(node).ok_or_else(malformed)?.to_owned(),
                    text: whole.trim_matches('\n').to_owned(),
                    start: first + whole.len() - whole.trim_start_matches('\n').len(),
                    mentions: mentions(node),
                });
            }
            at = end;
        }
        Ok(module)
    }

    pub(super) fn declares(&self, name: &str) -> bool {
        self.items.iter().any(|item| item.name == name)
    }
}

/// `import package::MODULE::NAME;` or `…::{NAME, NAME};`
fn import(node: &[Word<'_>]) -> Option<(String, Vec<String>)> {
    let texts: Vec<&str> = node.iter().map(|word| word.text).collect();
    let ["import", "package", ":", ":", module, ":", ":", names @ .., ";"] = texts.as_slice() else { return None };
    let names: Vec<String> = match names {
        ["{", names @ .., "}"] => {
            names.split(|&word| word == ",").filter(|name| !name.is_empty()).map(|name| name.concat()).collect()
        }
        [name] => vec![(*name).to_owned()],
        _ => return None,
    };
    Some(((*module).to_owned(), names))
}

/// The name that a declaration introduces.
fn declared<'a>(node: &[Word<'a>]) -> Option<&'a str> {
    let keyword =
        node.iter().position(|word| matches!(word.text, "fn" | "struct" | "var" | "const" | "override" | "alias"))?;
    let mut after = &node[keyword + 1..];
    // `var<storage, read>`
    if after.first()?.text == "<" {
        let close = after.iter().position(|word| word.text == ">")?;
        after = &after[close + 1..];
    }
    after.first().filter(|word| word.is_name()).map(|word| word.text)
}

fn mentions(node: &[Word<'_>]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut before = "";
    for word in node {
        if word.is_name() && before != "." && !names.iter().any(|name| name == word.text) {
            names.push(word.text.to_owned());
        }
        before = word.text;
    }
    names
}
