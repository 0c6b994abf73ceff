//! Where in a JSON text a byte is, as people write it: `meshes[0].primitives[1].mode`.
//!
//! serde_json says line and column of an error, which help nobody in a file of one line. Keeping the path while
//! parsing would compile every type of glTF a second time.

/// What encloses a place.
enum Level {
    /// An object, with the key whose value the place is in.
    Object(Option<String>),
    /// An array, with the element that the place is in.
    Array(usize),
}

/// The path of the value that ends at or encloses the byte before a place; empty for the whole text. `line` and
/// `column` count from 1, the column in bytes, as serde_json's errors do. The text up to there is JSON.
pub(super) fn path_at(text: &str, line: usize, column: usize) -> String {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let bytes = &text.as_bytes()[..text.len().min(start + column)];
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
            // What was just closed is the last value of what encloses it.
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
    use super::*;

    const TEXT: &str = r#"{"asset": {"version": "2.0"}, "meshes": [
  {"primitives": [{"mode": 4}, {"mode": [1, "a]\"}", 3], "b.c": {}}]}
], "scene": 0}"#;

    /// The path at the end of the first occurrence of a piece.
    fn path_after(piece: &str) -> String {
        let end = TEXT.find(piece).expect("in the text") + piece.len();
        let before = &TEXT[..end];
        let line = before.matches('\n').count() + 1;
        path_at(TEXT, line, end - before.rfind('\n').map_or(0, |at| at + 1))
    }

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
            assert_eq!(path_after(piece), path, "{piece}");
        }
    }

    #[test]
    fn a_place_beyond_the_text_is_its_end() {
        assert_eq!(path_at("", 1, 0), "");
        assert_eq!(path_at("[[1, \"", 7, 99), "[0][1]");
        assert_eq!(path_at("{\"a\\", 1, 4), "");
    }
}
