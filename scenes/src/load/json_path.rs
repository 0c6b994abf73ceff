//! Finds the path of a byte in a JSON text, for example `meshes[0].primitives[1].mode`.
//!
//! serde_json reports the line and column of an error, which are useless in a file of one line. Keeping the path while
//! parsing would compile every type of glTF a second time.

/// A container around a position in the text.
enum Level {
    /// An object, with the key of the value at the position.
    Object(Option<String>),
    /// An array, with the index of the element at the position.
    Array(usize),
}

/// The path of the value that a serde_json error is about; empty for the whole text. The text before the error is valid
/// JSON.
pub(super) fn path_of(text: &str, error: &serde_json::Error) -> String {
    let start: usize = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
    // Lines and columns count from 1, columns in bytes; the last byte included is the one in error.
    let bytes = &text.as_bytes()[..text.len().min(start + error.column())];
    match bytes {
        // A misplaced bracket or comma ends nothing.
        [before @ .., b',' | b'}' | b']'] if error.is_syntax() => path_after(before),
        _ => path_after(bytes),
    }
}

/// The path of the value that ends with these bytes, or continues after them.
fn path_after(bytes: &[u8]) -> String {
    let mut levels: Vec<Level> = Vec::new();
    let mut key_is_next = false;
    let mut at = 0;
    while at < bytes.len() {
        let byte = bytes[at];
        let begin = at;
        at += 1;
        if byte.is_ascii_whitespace() {
            continue;
        }
        match byte {
            b'{' => {
                levels.push(Level::Object(None));
                key_is_next = true;
            }
            b'[' => {
                levels.push(Level::Array(0));
                key_is_next = false;
            }
            // What was just closed is the last value of its container.
            b'}' | b']' => drop(levels.pop()),
            b',' => match levels.last_mut() {
                Some(Level::Object(key)) => {
                    *key = None;
                    key_is_next = true;
                }
                Some(Level::Array(index)) => *index += 1,
                None => {}
            },
            b'"' => {
                while at < bytes.len() && bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at = bytes.len().min(at + 1);
                if let (true, Some(Level::Object(key))) = (key_is_next, levels.last_mut()) {
                    *key = serde_json::from_slice(&bytes[begin..at]).ok();
                    key_is_next = false;
                }
            }
            _ => {}
        }
    }
    let mut path = String::new();
    for level in &levels {
        match level {
            Level::Object(Some(key)) => {
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(key);
            }
            Level::Object(None) => {}
            Level::Array(index) => path.push_str(&format!("[{index}]")),
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    const TEXT: &str = r#"{"asset": {"version": "2.0"}, "meshes": [
  {"primitives": [{"mode": 4}, {"mode": [1, "a]\"}", 3], "b.c": {}}]}
], "scene": 0}"#;

    #[test]
    fn a_value_is_named_by_keys_and_indices() {
        for (piece, path) in [
            ("{\"asset\"", "asset"),
            ("\"2.0\"", "asset.version"),
            ("\"2.0\"}", "asset"),
            ("[\n  {\"primitives\"", "meshes[0].primitives"),
            ("{\"mode\": 4", "meshes[0].primitives[0].mode"),
            ("{\"mode\": 4}", "meshes[0].primitives[0]"),
            ("[1", "meshes[0].primitives[1].mode[0]"),
            ("\"a]\\\"}\"", "meshes[0].primitives[1].mode[1]"),
            (", 3]", "meshes[0].primitives[1].mode"),
            ("{}}", "meshes[0].primitives[1]"),
            ("\n]", "meshes"),
            ("\"scene\": 0", "scene"),
            ("0}", ""),
        ] {
            let end = TEXT.find(piece).expect("in the text") + piece.len();
            assert_eq!(path_after(&TEXT.as_bytes()[..end]), path, "{piece}");
        }
        assert_eq!(path_after(b""), "");
        assert_eq!(path_after(b"[[1, \""), "[0][1]");
        assert_eq!(path_after(b"{\"a\\"), "");
    }

    #[test]
    fn what_is_no_json_is_named_by_what_it_stands_in() {
        for (text, path) in [
            ("{\"meshes\": }", "meshes"),
            ("{\"a\": {\n\"b\": ,\n\"c\": 1}}", "a.b"),
            ("{\"a\": [1,]}", "a[1]"),
            ("{\"a\": [1}", "a[0]"),
            ("{\"a\": [1 2]}", "a[0]"),
            ("{\"a\": {\"b\": 1]}", "a.b"),
            ("{\"a\": {\"b\": 1,}}", "a"),
            // The end of the text ends nothing, but the byte before it may.
            ("{\"a\": [1,", "a[1]"),
            ("{\"a\": {\"b\": [1]", "a.b"),
            ("", ""),
            ("}", ""),
        ] {
            let error = serde_json::from_str::<serde_json::Value>(text).expect_err("no JSON");
            assert_eq!(path_of(text, &error), path, "{text}: {error}");
        }
    }

    #[test]
    fn what_does_not_fit_is_named_itself() {
        type Lists = BTreeMap<String, Vec<[u8; 2]>>;
        for (text, path) in [
            ("{\"a\": [[1, 2]], \"ä\": 3}", "ä"),
            ("{\"a\": [[1, 2],\n [1]]}", "a[1]"),
            ("{\"a\": [[1, 2], [300, 1]]}", "a[1][0]"),
        ] {
            let error = serde_json::from_str::<Lists>(text).expect_err("other types");
            assert_eq!(path_of(text, &error), path, "{text}: {error}");
        }
    }
}
