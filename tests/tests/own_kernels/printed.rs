//! What a kernel of a user's prints, and what it asserts.

use std::ops::ControlFlow;

use raystep_kernels::export::trace::{Rays, RunSoFar, Trace, trace};
use raystep_kernels::programs::closest_hit::streams::{COLOR, HIT, STATE};
use raystep_kernels::{Device, GpuError, Options, RenderError, Renderer};
use raystep_scenes::{Scene, generate};
use raystep_tests::{block_on, devices, gpu_of, values};

use super::{difference, line_of, own, run, single_steps};

/// What a kernel prints changes nothing of the run, and is in the rows of a ray, alone or among all, and followed without the
/// device.
#[test]
fn what_a_kernel_prints_is_in_the_rows_of_a_ray() {
    let scene = generate::cornell_box();
    let by = own("traverse_grid", "    if (!walk.inside) {", "    note(\"tmax\", walk.tmax);\n    if (!walk.inside) {");
    let plain = single_steps(&scene);
    let options = Options { replaced: vec![by.clone()], ..plain.clone() };
    for (_, device) in devices() {
        let with = run(&scene, &options, &device).expect("a run");
        let without = run(&scene, &plain, &device).expect("a run");
        for stream in [STATE, HIT, COLOR] {
            assert_eq!(values(&with, stream), values(&without, stream), "{}", stream.name());
        }
        let traced = |rays| {
            block_on(gpu_of(&device), async {
                let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                trace(&mut renderer, 7, 5, rays, |_| ControlFlow::Continue(())).await.expect("a history")
            })
        };
        let (alone, all) = (traced(Rays::One), traced(Rays::All));
        let notes = |history: &Trace| history.rows.iter().map(|row| row.notes.clone()).collect::<Vec<_>>();
        assert_eq!(notes(&alone), notes(&all));
        let (plan, data) = (with.shared_plan(), with.shared_data());
        let known = RunSoFar { plan: &plan, data: &data, passes: with.passes(), is_complete: true };
        // A device that contracts products and sums has other last bits.
        let four_digits = |notes: Vec<Vec<String>>| {
            let word =
                |word: &str| word.parse::<f32>().map_or_else(|_| word.to_owned(), |value| format!("{value:.4e}"));
            let words = |note: String| note.split(' ').map(word).collect::<Vec<_>>();
            notes.into_iter().map(|row| row.into_iter().map(words).collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        let followed = known.follow::<f32>([7, 5]).expect("a history");
        assert_eq!(four_digits(notes(&followed)), four_digits(notes(&all)));
        let mut printed = 0;
        for row in &all.rows {
            assert_eq!(row.notes.is_empty(), row.kernel != "traverse_grid", "{row:?}");
            let Some(note) = row.notes.first() else { continue };
            printed += 1;
            // Behind the last cell there is no tMax to store.
            if let Some(tmax) =
                row.after.tmax.iter().copied().collect::<Option<Vec<f32>>>().filter(|_| row.cell_after.is_some())
            {
                let numbers: Vec<String> = tmax.iter().map(f32::to_string).collect();
                assert_eq!(*note, format!("tmax = {}", numbers.join(" ")));
            }
        }
        assert!(printed > 2, "{:?}", notes(&all));
    }
    let wrong = own("intersect", "item += 1u;", "note(\"item\", item);\n        item += 2u;");
    assert_eq!(difference(&scene, wrong, &Device::Cpu(None)).notes, ["item = 0"]);
}

#[test]
fn an_assertion_that_does_not_hold_ends_the_run_and_is_counted_on_a_device() {
    let scene = generate::cornell_box();
    let asserted = |condition: &str| {
        own(
            "intersect",
            "    let list = list_of(cell);",
            &format!("    assert_that({condition}, \"few\");\n    let list = list_of(cell);"),
        )
    };
    for (_, device) in devices() {
        let held = Options { replaced: vec![asserted("item < 1000u")], ..single_steps(&scene) };
        run(&scene, &held, &device).expect("it holds");
        let by = asserted("item < 1u");
        let options = Options { replaced: vec![by.clone()], ..single_steps(&scene) };
        let error = run(&scene, &options, &device).map(drop).expect_err("it does not hold");
        match &error {
            RenderError::Gpu(GpuError::Assertion { file, label, count, .. }) => {
                // As many rays as have a second triangle in their first list with one.
                let first = first_with_items(&scene, &device);
                assert_eq!((&**file, &**label, *count), ("my-intersect.wgsl", "few", first), "{error}");
            }
            RenderError::Failed(failed) => {
                let line = line_of(&by, "assert_that");
                assert_eq!(failed.place, format!("my-intersect.wgsl:{line}"));
                assert!(error.to_string().contains("the assertion \"few\" does not hold"), "{error}");
            }
            other => panic!("{other}"),
        }
    }
}

/// Of the first pass of `intersect` that starts with rays whose item is not 0, how many.
fn first_with_items(scene: &Scene, device: &Device) -> u32 {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, &single_steps(scene), device).await.expect("a renderer");
        loop {
            let kernel = renderer.next_kernel().expect("not the end");
            if kernel.name() == "intersect" {
                let state = renderer.values(STATE).await.expect("values");
                let rays = (0..state.width as usize * state.height as usize)
                    .filter(|&ray| kernel.takes().contains(&state.get(0, ray)) && state.get(3, ray) > 0);
                let count = rays.count();
                if count > 0 {
                    return count as u32;
                }
            }
            renderer.step().await.expect("a pass");
        }
    })
}
