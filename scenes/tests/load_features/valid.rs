//! Valid but rare files.

use crate::load_common::*;
use raystep_scenes::{LoadOptions, NoFiles, load};
use serde_json::json;

#[test]
fn whole_numbers_may_have_a_fraction_or_an_exponent() {
    let mut doc = Doc::triangle();
    let name = r#"1.0 \"2.0\" 3e0 \\"#;
    doc.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.25}, "name": "NAME"}));
    doc.json["nodes"] = json!([{"mesh": 0, "camera": 0, "translation": [0.5, -2.0, 1e-3], "scale": [4, 1, 1]}]);
    doc.json["scenes"] = json!([{"nodes": [0]}]);
    doc.json["scene"] = json!(0);
    let plain = doc.json.to_string().replace("NAME", name);
    let load = |text: &str| {
        let text = text.replace("\"buffers\":[]", &format!("\"buffers\":[{{\"byteLength\":36,\"uri\":\"{URI}\"}}]"));
        load("x", text.as_bytes(), &NoFiles, &LoadOptions::default())
    };
    let expected = load(&plain).unwrap();
    assert_eq!(expected.cameras[0].name, "1.0 \"2.0\" 3e0 \\");
    // Every integer of the document, each written differently.
    let spelled = |number: &str, i: usize| match (i % 5, number) {
        (0, _) => format!("{number}.0"),
        (1, _) => format!("{number}e0"),
        (2, "0") => "0E-1".to_owned(),
        (2, _) => format!("{number}0E-1"),
        (3, "0") => "0.000e+7".to_owned(),
        (3, _) => format!("{number}0.00e-1"),
        _ => format!("{number}.000"),
    };
    let mut other = String::new();
    let (mut is_text, mut digits, mut changed) = (false, String::new(), 0);
    let mut before = ' ';
    for c in plain.chars().chain([' ']) {
        if !is_text && c.is_ascii_digit() && (digits.len() + 1 > 1 || "[:,".contains(before)) {
            digits.push(c);
            continue;
        }
        if !digits.is_empty() {
            let is_whole = c != '.' && c != 'e';
            other += &if is_whole { spelled(&digits, changed) } else { digits.clone() };
            changed += usize::from(is_whole);
            digits.clear();
        }
        is_text ^= c == '"' && before != '\\';
        // A backslash after another one is text, not the start of an escape sequence.
        before = if c == '\\' && before == '\\' { ' ' } else { c };
        other.push(c);
    }
    assert!(changed == 15 && other.contains("\"count\":30E-1"), "{changed}: {other}");
    assert_eq!(load(&other).unwrap(), expected, "{other}");

    for (wrong, words) in [
        ("1.5", "nodes[0].mesh: 1.5 is no whole number"),
        ("0.1", "nodes[0].mesh"),
        ("-1.0", "nodes[0].mesh"),
        ("1e0", "nodes[0].mesh: refers to mesh 1"),
        ("4294967296.0", "nodes[0].mesh: refers to mesh 4294967296"),
        ("1e300", "nodes[0].mesh"),
        ("1e99999999999999999999", "nodes[0].mesh"),
        ("\"0\"", "nodes[0].mesh: \"0\" is no whole number"),
        ("1.", "JSON"),
        ("01.0", "JSON"),
        ("1e", "JSON"),
    ] {
        let text = plain.replace("\"mesh\":0", &format!("\"mesh\":{wrong}"));
        let error = one_line(&load(&text).unwrap_err());
        assert!(error.contains(words), "{wrong}: {error:?} does not say {words:?}");
    }
}

/// The triangle's positions.
const URI: &str = "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";

#[test]
fn channels_of_animations_need_no_node() {
    let mut doc = Doc::triangle();
    doc.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    doc.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let pointer = json!({"KHR_animation_pointer": {"pointer": "/nodes/0/translation"}});
    doc.json["animations"] = json!([
        {"channels": [{"sampler": 0, "target": {"path": "translation"}}], "samplers": [{"input": 0, "output": 0}]},
        {"channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": pointer}}], "samplers": []},
    ]);
    doc.json["nodes"][0]["translation"] = json!([0.1, 0.2, 0.3]);
    doc.json["nodes"][0]["name"] = json!("ü \u{1}");
    let scene = doc.scene();
    assert_eq!(scene.triangles[0][0], [0.1, 0.2, 0.3]);
    assert_eq!(notes(&scene).iter().filter(|n| n.contains("animations are ignored")).count(), 1);
    assert!(notes(&scene).contains(&"the extension KHR_animation_pointer is ignored"));
    // Together with a scene that has no nodes.
    doc.json["scenes"] = json!([{}, {"nodes": [0]}]);
    doc.json["scene"] = json!(1);
    assert_eq!(doc.scene().triangles, scene.triangles);
    doc.json["scene"] = json!(0);
    assert_eq!(doc.scene().triangles.len(), 0);
}

#[test]
fn buffers_that_nothing_on_show_uses_may_be_missing() {
    let mut doc = Doc::triangle();
    let bin = std::mem::take(&mut doc.bin);
    doc.json["buffers"] = json!([
        {"byteLength": 36, "uri": URI},
        {"byteLength": 8},
        {"byteLength": 8, "uri": "http://example.com/a.bin"},
        {"byteLength": 8, "uri": "missing.bin"},
        {"byteLength": 99, "uri": "data:,short"},
    ]);
    for buffer in 1..5 {
        doc.push("bufferViews", json!({"buffer": buffer, "byteLength": 8}));
        doc.push("accessors", json!({"bufferView": buffer, "componentType": F32, "count": 1, "type": "SCALAR"}));
        doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": buffer}}]}));
    }
    let text = |doc: &Doc| doc.json.to_string();
    let scene = load("x", text(&doc).as_bytes(), &NoFiles, &LoadOptions::default()).unwrap();
    assert_eq!((scene.triangles.len(), bin.len()), (1, 36));
    for (buffer, words) in
        [(1, "has no uri"), (2, "is a http: URI"), (3, "no files can be read"), (4, "has 5 bytes, fewer than")]
    {
        doc.json["nodes"] = json!([{"mesh": buffer}]);
        let error = load("x", text(&doc).as_bytes(), &NoFiles, &LoadOptions::default()).unwrap_err();
        assert!(
            one_line(&error).starts_with(&format!("buffers[{buffer}]")) && error.to_string().contains(words),
            "{error}"
        );
    }
}
