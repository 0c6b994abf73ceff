use super::*;
use crate::options::features::Features;
use crate::program::live;
use crate::programs::closest_hit::kernels;

/// A shader with every way to load from a list that kernels have.
const SHADER: &str = "
struct Item { low: vec3f, first: u32, high: vec3f, link: i32 }
@group(1) @binding(3) var<storage, read> items: array<Item>;
@group(1) @binding(4) var<storage, read> words: array<u32>;
@group(1) @binding(5) var<storage, read> quads: array<vec4u>;
@group(2) @binding(0) var<storage, read_write> sums: array<f32>;

fn whole(at: i32) -> Item {
    return items[at];
}

@compute @workgroup_size(1)
fn setup(@builtin(global_invocation_id) id: vec3u) {
    let element = &items[id.x];
    var sum = f32(whole(2).link) + (*element).high.y + f32(words[0]);
    for (var i = 0u; i < quads[id.y].w && words[i] < 7u; i += words[i + 1u]) {
        sum += f32((*element).first) + f32(quads[words[i]].x);
    }
    sums[id.x] = sum;
}
";

fn bindings() -> Vec<Binding> {
    let binding = |group, index, name: &str, resource| {
        let writes = resource != Resource::Storage;
        Binding { group, index, name: name.into(), resource, reads: true, writes }
    };
    vec![
        binding(1, 3, "items", Resource::Storage),
        binding(1, 4, "words", Resource::Storage),
        binding(1, 5, "quads", Resource::Storage),
        binding(2, 0, "sums", Resource::Live { writable: true }),
    ]
}

#[test]
fn every_load_from_a_list_becomes_a_call_and_what_is_written_stays_a_buffer() {
    let (source, changed) = in_textures(kernels::SETUP, SHADER, &bindings()).expect("a shader");
    let lists = changed.iter().filter(|binding| binding.resource == Resource::List).count();
    assert_eq!((lists, changed[3].resource), (3, Resource::Live { writable: true }));
    assert_eq!(source.matches("var<storage").count(), 1, "{source}");
    assert_eq!(source.matches(": texture_2d<u32>;").count(), 3, "{source}");
    // Members are loaded alone: word 3 of an item, and word 1 + 4 for its `high.y`.
    for call in [
        "load_Item_0_of_items_signed(",
        "load_word_3_of_items(",
        "load_word_5_of_items(",
        "load_word_3_of_quads(",
        "load_word_0_of_quads(",
        "load_word_0_of_words(0u)",
    ] {
        assert!(source.contains(call), "{call} in {source}");
    }
    let body = source.split("fn load_Item_0_of_items_signed").nth(1).expect("a function");
    assert!(body.contains("(8u * u32(i") && body.contains("bitcast<f32>"), "{source}");
    // The paper's function, once.
    assert_eq!(source.matches("fn get_address(").count(), 1, "{source}");
}

#[test]
fn what_cannot_be_in_a_texture_is_refused() {
    let cases = [
        ("words[0]", "arrayLength(&words)", "setup is not valid"),
        ("(*element).high.y", "(*element).high[id.z]", "an index within an element"),
    ];
    for (from, to, message) in cases {
        assert!(SHADER.contains(from), "{from}");
        let error = in_textures(kernels::SETUP, &SHADER.replacen(from, to, 1), &bindings()).expect_err(to);
        assert!(error.to_string().contains(message), "{to}: {error}");
    }
}

#[test]
fn a_shader_without_lists_is_left_as_it_is() {
    let variant = Variant::new(kernels::SETUP, &Features::default(), &[]).expect("a variant");
    let same = variant.in_textures().expect("a variant");
    assert_eq!((same.source, same.bindings), (variant.source, variant.bindings));
}

#[test]
fn kernels_bind_in_a_texture_what_they_bound_in_a_buffer() {
    let features = Features { grid: true, robust: true, many_steps: true, live_lists: true, ..Features::default() };
    let lists = live::lists(&[kernels::WALK], &features);
    let variant = Variant::new(kernels::WALK, &features, &lists).expect("a variant");
    let changed = variant.in_textures().expect("a variant");
    let places = |variant: &Variant| -> Vec<(u32, u32, String)> {
        variant.bindings.iter().map(|b| (b.group, b.index, b.name.clone())).collect()
    };
    assert_eq!(places(&changed), places(&variant));
    for (before, after) in variant.bindings.iter().zip(&changed.bindings) {
        let wanted = if before.resource == Resource::Storage { Resource::List } else { before.resource };
        assert_eq!(after.resource, wanted, "{}", before.name);
    }
    assert!(changed.source.contains(&format!("fn {}(", kernels::WALK.info().name)));
}
