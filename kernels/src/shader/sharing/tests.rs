use super::*;
use crate::options::features::Features;
use crate::programs::closest_hit::kernels::GENERATE;
use crate::programs::closest_hit::streams::{HIT, RAY_DIRECTION, RAY_ORIGIN, STATE, TMAX};

fn storage_textures(source: &str) -> usize {
    Parsed::new(source).expect("WGSL").module.global_variables.iter().filter(|(_, g)| g.binding.is_some()).count()
}

fn named(variant: &Variant) -> Vec<&str> {
    variant.bindings.iter().map(|binding| binding.name.as_str()).collect()
}

#[test]
fn a_kernel_that_fits_stays_as_it_is() {
    let variant = Variant::new(GENERATE, &Features::default(), &[]).expect("a kernel");
    let groups = [vec![RAY_ORIGIN, RAY_DIRECTION]];
    assert!(variant.sharing(&groups, 4).expect("no change").is_none());
    assert!(variant.sharing(&[], 2).expect("no change").is_none());
    assert!(variant.sharing(&[vec![RAY_ORIGIN, TMAX]], 2).expect("no change").is_none(), "only one is written");
}

/// naga renames globals that are called like a parameter, when it writes the first group.
#[test]
fn a_second_group_is_found_whatever_its_streams_are_called_by_then() {
    let mut variant = Variant::new(GENERATE, &Features::default(), &[]).expect("a kernel");
    let own = storage_textures(&variant.source);
    let entry = variant.source.find("fn generate(").expect("an entry point");
    let body = entry + variant.source[entry..].find("{\n").expect("a body") + 2;
    variant.source.insert_str(body, "    _ = sum_of(1u, 2u);\n");
    variant.source += "\nfn sum_of(state: u32, hit: u32) -> u32 {\n    return state + hit;\n}\n";
    let shared = variant.sharing(&[vec![RAY_ORIGIN, RAY_DIRECTION], vec![HIT, STATE]], 2);
    let shared = shared.expect("a kernel").expect("two groups");
    let found = named(&shared);
    assert!(found.contains(&"streams_with_ray_origin") && found.contains(&"streams_with_hit"), "{found:?}");
    assert!(!["ray_origin", "ray_direction", "hit", "state"].iter().any(|name| found.contains(name)), "{found:?}");
    assert_eq!(storage_textures(&shared.source), own - 2, "{}", shared.source);
}

/// A layer that the stream does not have is neither stored nor loaded, as without sharing.
#[test]
fn layers_are_those_of_the_stream_alone() {
    let group = vec![HIT, STATE];
    assert_eq!((first_layer(&group, HIT), first_layer(&group, STATE)), (0, HIT.layers() as u32));
    let source = Variant::new(GENERATE, &Features::default(), &[]).expect("a kernel");
    let shared = source.sharing(&[vec![RAY_ORIGIN, RAY_DIRECTION]], 3).expect("a kernel").expect("a group");
    assert!(shared.source.contains("< 3u"), "{}", shared.source);
}

#[test]
fn a_texture_that_a_function_takes_is_named_as_the_reason() {
    let mut variant = Variant::new(GENERATE, &Features::default(), &[]).expect("a kernel");
    let entry = variant.source.find("fn generate(").expect("an entry point");
    let body = entry + variant.source[entry..].find("{\n").expect("a body") + 2;
    variant.source.insert_str(body, "    _ = first_of(tmax);\n");
    variant.source += "\n@group(0) @binding(40) var tmax: texture_2d_array<f32>;\n\
                       fn first_of(t: texture_2d_array<f32>) -> f32 {\n    return textureLoad(t, vec2u(0u), 0, 0).x;\n}\n";
    let (name, resource) = ("tmax".to_owned(), Resource::ReadStream(TMAX));
    variant.bindings.push(Binding { group: 0, index: 40, name, resource, reads: true, writes: false });
    let error = variant.sharing(&[vec![RAY_ORIGIN, RAY_DIRECTION, TMAX]], 2).expect_err("a texture is given away");
    assert!(error.to_string().contains("gives a stream's texture to a function"), "{error}");
}
