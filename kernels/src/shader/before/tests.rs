use std::collections::BTreeMap;
use std::sync::Arc;

use super::*;
use crate::options::folder::Folder;
use crate::programs::own;

/// The copies that a kernel with this body makes, over an image of 8 by 8 and a stream of floats with two layers.
fn copies(body: &str, in_place: bool) -> Vec<&'static str> {
    let manifest = format!(
        "[elements]\npixels = {{ image = [8, 8] }}\n[streams.a]\ntype = \"f32\"\nlayers = [\"x\", \"y\"]\n[kernels]\nrun = {{ in_place \
         = {} }}\n[schedule]\nsteps = [{{ run = \"run\" }}]\n",
        if in_place { "[\"a\"]" } else { "[]" }
    );
    let wgsl = format!(
        "@group(0) @binding(0) var a: texture_storage_2d_array<r32float, read_write>;\n\
         fn flipped(at: vec2u) -> vec2u {{ return textureDimensions(a) - 1u - at; }}\n\
         fn load(at: vec2u) -> f32 {{ return textureLoad(a, at, 0).x; }}\n\
         @compute @workgroup_size(8, 8)\nfn run(@builtin(global_invocation_id) id: vec3u) {{\n{body}\n}}\n"
    );
    let files = [("program.toml", manifest), ("run.wgsl", wgsl.clone())];
    let files: BTreeMap<String, Vec<u8>> =
        files.into_iter().map(|(name, text)| (name.into(), text.into_bytes())).collect();
    let folder = Arc::new(Folder::new("a".into(), String::new(), files).expect("a folder"));
    let own = own::read(&folder).unwrap_or_else(|mistake| panic!("{mistake}\n{wgsl}"));
    own.program.kernels[0].copies.iter().map(|(_, from)| from.name()).collect()
}

#[test]
fn a_stream_is_copied_where_a_thread_loads_what_another_stores() {
    for own in [
        "textureStore(a, id.xy, 0, vec4f(textureLoad(a, id.xy, 1).x));",
        "let at = id.xy; textureStore(a, at, 0, vec4f(load(id.xy)));",
        "textureStore(a, flipped(id.xy), 0, vec4f(textureLoad(a, flipped(id.xy), 0).x));",
        "textureStore(a, id.yx, 0, vec4f(1.0));",
        "if (id.x < 4u) { textureStore(a, id.xy, 0, vec4f(load(id.xy))); }",
    ] {
        assert_eq!(copies(own, false), [""; 0], "{own}");
    }
    for other in [
        "textureStore(a, id.xy, 0, vec4f(textureLoad(a, id.xy + 1u, 0).x));",
        "textureStore(a, id.xy, 0, vec4f(load(id.yx)));",
        "textureStore(a, flipped(id.xy), 0, vec4f(load(id.xy)));",
        // The same variable, but not the same value.
        "var at = id.xy; let x = textureLoad(a, at, 0).x; at += 1u; textureStore(a, at, 0, vec4f(x));",
        "for (var i = 0u; i < 8u; i++) { let at = vec2u(i, id.y); textureStore(a, at, 0, vec4f(textureLoad(a, at, 0).x)); }",
        // All threads have this one.
        "textureStore(a, vec2u(0u), 0, vec4f(textureLoad(a, vec2u(0u), 0).x + 1.0));",
    ] {
        assert_eq!(copies(other, false), ["a"], "{other}");
        assert_eq!(copies(other, true), [""; 0], "{other}, which is said to be in place");
    }
}

#[test]
fn loads_are_from_the_copy_on_the_same_lines() {
    let source = "@group(0) @binding(0) var a: texture_storage_2d_array<r32uint, read_write>;\nfn f() {\n    let x = textureLoad(a, max(p, vec2u(1u)), 0).x; // a\n    textureStore(a, p, 0, vec4u(x));\n}\n";
    let text = from_copies(source, &[("a".into(), Texel::U32)]).expect("a text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[2], "    let x = textureLoad(a_before, max(p, vec2u(1u)), 0, 0).x; // a");
    assert_eq!(lines[3], "    textureStore(a, p, 0, vec4u(x));");
    assert_eq!(lines[5], "@group(0) @binding(640) var a_before: texture_2d_array<u32>;");
    // A parameter of the same name is another thing.
    let shadowed = "fn f(a: u32) -> u32 { return g(a); }\nfn h() { let x = textureLoad(a, p, 0).x; }\n";
    let text = from_copies(shadowed, &[("a".into(), Texel::U32)]).expect("a text");
    assert!(
        text.starts_with("fn f(a: u32) -> u32 { return g(a); }\nfn h() { let x = textureLoad(a_before, p, 0, 0).x; }"),
        "{text}"
    );
    assert_eq!(from_copies("fn f() { g(a); }", &[("a".into(), Texel::U32)]), Err(11));
}
