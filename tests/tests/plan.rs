//! Whatever a scene does not need is neither compiled, bound, allocated nor uploaded.

use std::collections::BTreeSet;

use raystep_kernels::programs::closest_hit::{kernels, streams};
use raystep_kernels::{Accelerator, Device, Item, Keep, Limits, Numerics, Options, Plan, RaySource, Renderer};
use raystep_tests::configurations::{Configuration, EVERY, STEPPED};
use raystep_tests::{block_on, differences, gpu, options, rays, scene, thorough, traced, values};

fn renderer(file: &str, change: impl FnOnce(&mut Options)) -> Renderer {
    let scene = scene(file);
    let mut options = options(&scene, 64, 48);
    change(&mut options);
    block_on(Some(&gpu()), Renderer::new(&scene, &options, &Device::Gpu(gpu()))).expect("a renderer")
}

/// Names that any variant binds, according to reflection.
fn bound(plan: &Plan) -> BTreeSet<&str> {
    plan.variants.iter().flat_map(|v| &v.bindings).map(|b| b.name.as_str()).collect()
}

#[test]
fn bytes_of_the_plan_are_the_bytes_allocated() {
    let files = ["cornell-box.gltf", "textures.gltf", "lights.gltf", "empty.gltf"];
    for (file, configuration) in files.iter().flat_map(|file| EVERY.map(|configuration| (file, configuration))) {
        let renderer = renderer(file, |o| *o = configuration.of(o));
        let allocated = renderer.gpu().expect("a gpu").allocated();
        let planned: Vec<(&str, u64)> = (renderer.plan().streams.iter().map(|s| (s.what.name(), s.bytes)))
            .chain(renderer.plan().buffers.iter().map(|b| (b.what, b.bytes)))
            .collect();
        assert_eq!(allocated, planned, "{file} {configuration}");
        assert_eq!(allocated.iter().map(|(_, b)| b).sum::<u64>(), renderer.plan().bytes(), "{file} {configuration}");
    }
}

#[test]
fn three_scenes_leave_out_what_they_do_not_have() {
    // (scene, names that must be bound and allocated, names that must be neither)
    let cases: [(&str, &[&str], &[&str]); 3] = [
        (
            "cornell-box.gltf",
            &["vertices", "triangle_materials"],
            &["normals", "texcoords", "texels", "textures", "vertex_colors"],
        ),
        ("textures.gltf", &["texcoords", "texels", "textures"], &["counters"]),
        ("lights.gltf", &["lights", "normals"], &["texels", "textures", "counters"]),
    ];
    for (file, present, absent) in cases {
        let renderer = renderer(file, |_| {});
        let plan = renderer.plan();
        let bound = bound(plan);
        let allocated: BTreeSet<&str> =
            renderer.gpu().expect("a gpu").allocated().into_iter().map(|(n, _)| n).collect();
        let source: String = plan.variants.iter().map(|v| v.source.as_str()).collect();
        for name in present {
            assert!(bound.contains(name) && allocated.contains(name), "{file}: {name}\n{plan}");
        }
        for name in absent {
            assert!(!bound.contains(name) && !allocated.contains(name), "{file}: {name}\n{plan}");
            assert!(!source.contains(&format!(" {name}:")), "{file}: {name} is compiled");
            let contents = plan.program.buffer(name).map(|info| info.contents(renderer.data()));
            assert!(contents.is_none_or(|b| b.iter().all(|&b| b == 0)), "{file}: {name} is filled");
            assert!(plan.left_out.iter().any(|l| l.what.ends_with(name)), "{file}: {name} has no reason\n{plan}");
        }
    }
}

#[test]
fn code_for_lights_that_are_not_there_is_not_compiled() {
    let shade = |file: &str| {
        let renderer = renderer(file, |_| {});
        renderer.plan().variant(kernels::SHADE).expect("shade").source.clone()
    };
    assert!(
        !shade("cornell-box.gltf").contains("light.cone_scale") && shade("lights.gltf").contains("light.cone_scale")
    );
    assert!(!shade("cornell-box.gltf").contains(".kind =="));
    assert!(shade("textures.gltf").contains("sample_texture") && !shade("lights.gltf").contains("sample_texture"));
}

#[test]
fn without_a_view_nothing_is_shaded_and_without_a_grid_nothing_is_walked() {
    let hits = renderer("cornell-box.gltf", |o| o.shade = false);
    assert!(!hits.plan().has_stream(streams::COLOR) && !bound(hits.plan()).contains("materials"));
    let grid = renderer("cornell-box.gltf", |o| *o = STEPPED.of(o));
    assert!(grid.plan().has_stream(streams::TMAX) && bound(grid.plan()).contains("grid_cells"));
    let none = renderer("cornell-box.gltf", |o| *o = Configuration { accelerator: Accelerator::None, ..STEPPED }.of(o));
    assert!(!none.plan().has_stream(streams::TMAX) && !bound(none.plan()).contains("grid_cells"));
    let scene = scene("cornell-box.gltf");
    let mut given = options(&scene, 1, 1);
    given.rays = RaySource::Given(rays::random(&scene, 10, 1));
    let (plan, _) = Plan::new(&scene, &given, &Limits::CPU).expect("a plan");
    assert!(plan.variant(kernels::GENERATE).is_none() && !bound(&plan).contains("camera"));
}

/// What a plan leaves out, of one item or of all things.
fn left_out(plan: &Plan, item: impl Fn(Option<Item>) -> bool) -> BTreeSet<&str> {
    plan.left_out.iter().filter(|left| item(left.item)).map(|left| left.what.as_str()).collect()
}

#[test]
fn an_item_puts_back_what_is_left_out_for_it_and_nothing_else() {
    let mut seen = BTreeSet::new();
    for file in ["cornell-box.gltf", "textures.gltf", "lights.gltf", "bare.gltf", "empty.gltf"] {
        let scene = scene(file);
        for (i, (configuration, shade)) in
            EVERY.iter().flat_map(|configuration| [(configuration, true), (configuration, false)]).enumerate()
        {
            // All configurations with the first scene; in the full suite, with all scenes.
            if file != "cornell-box.gltf" && i % 3 > 0 && !thorough() {
                continue;
            }
            let options = Options { shade, ..configuration.of(&options(&scene, 8, 8)) };
            let plan =
                |keep| Plan::new(&scene, &Options { keep, ..options.clone() }, &Limits::CPU).expect("a small scene").0;
            let (lean, full) = (plan(Keep::NONE), plan(Keep::ALL));
            for &item in Item::ALL {
                let kept = plan(Keep::only(item));
                let what = format!("{file} {configuration} {item}");
                let (before, after) = (left_out(&lean, |_| true), left_out(&kept, |_| true));
                let put_back: BTreeSet<&str> = before.difference(&after).copied().collect();
                assert_eq!(put_back, left_out(&lean, |of| of == Some(item)), "{what}");
                for &other in Item::ALL {
                    assert_eq!(kept.features.has(other), other == item || lean.features.has(other), "{what}: {other}");
                }
                seen.extend((!put_back.is_empty()).then_some(item));
            }
            assert_eq!(left_out(&full, |of| of.is_some()), BTreeSet::new(), "{file} {configuration}");
        }
    }
    assert_eq!(seen, Item::ALL.iter().copied().collect(), "items that no scene leaves out are not tested");
}

#[test]
fn keeping_more_changes_no_hit() {
    let everything = [Keep::ALL].as_slice();
    let each: Vec<Keep> = Item::ALL.iter().map(|&item| Keep::only(item)).collect();
    for (file, numerics, keeps) in [
        ("cornell-box.gltf", Numerics::Robust, everything),
        ("cornell-box.gltf", Numerics::Paper, everything),
        ("lights.gltf", Numerics::Robust, everything),
        ("lights.gltf", Numerics::Paper, everything),
        ("bare.gltf", Numerics::Robust, &[each.as_slice(), everything].concat()),
        ("bare.gltf", Numerics::Paper, everything),
        ("primitives.gltf", Numerics::Robust, everything),
        ("primitives.gltf", Numerics::Paper, everything),
    ] {
        let scene = scene(file);
        let options = Options { numerics, ..options(&scene, 96, 96) };
        let lean = traced(&scene, &options, &Device::Gpu(gpu()));
        for &keep in keeps {
            let full = traced(&scene, &Options { keep, ..options.clone() }, &Device::Gpu(gpu()));
            assert!(keep != Keep::ALL || full.plan().bytes() > lean.plan().bytes(), "{file}");
            for stream in [streams::HIT, streams::STATE] {
                let differ = differences(&values(&lean, stream), &values(&full, stream)).count();
                assert_eq!(differ, 0, "{file} {numerics} {keep:?}: {}", stream.name());
            }
        }
    }
}
