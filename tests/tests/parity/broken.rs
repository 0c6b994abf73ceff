//! Kernels that are broken on purpose: the comparison has to name them, and to let another rounding pass.

use raystep_kernels::program::breaks::Shows;
use raystep_kernels::programs::closest_hit::{PROGRAM, kernels};
use raystep_kernels::{Accelerator, GridSize, Kernel, Options, Plan, RaySource, ScheduleKind};
use raystep_tests::configurations::{Configuration, STEPPED};
use raystep_tests::parity::Parity;
use raystep_tests::{gpu, options, parity, rays, scene};

use super::knot;

/// Changes only a kernel's WGSL.
fn change(kernel: Kernel, from: &str, to: &str) -> impl FnOnce(&mut Plan) {
    move |plan| {
        let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("in the plan");
        variant.source = parity::change(&variant.source, from, to);
    }
}

fn compare_broken(options: &Options, kernel: Kernel, from: &str, to: &str) -> Parity {
    parity::compare_broken(&gpu(), &scene("cornell-box.gltf"), options, change(kernel, from, to))
}

/// The room, with a grid resolution at which the eye does not lie on a plane, where floor and ceil would agree.
fn room(configuration: Configuration) -> Options {
    let options = configuration.of(&options(&scene("cornell-box.gltf"), 40, 40));
    Options { counters: true, grid: GridSize::Cells([7, 7, 9]), ..options }
}

/// For every break in the kernels' rows, the comparison must name the broken kernel.
#[test]
fn a_broken_kernel_is_named() {
    let scene = scene("cornell-box.gltf");
    for kernel in PROGRAM.kernels() {
        let breaks = kernel.info().breaks;
        assert!(!breaks.is_empty(), "nothing breaks {}", kernel.name());
        for broken in breaks {
            let mut options = room(STEPPED);
            (broken.run)(&mut options);
            let change = change(kernel, broken.from, broken.to);
            let found = match broken.iterations {
                Some(most) => parity::compare_broken_in_turns(&gpu(), &scene, &options, most, change),
                None => parity::compare_broken(&gpu(), &scene, &options, change),
            };
            let what = format!("{} with {:?}", kernel.name(), broken.to);
            match broken.shows {
                Shows::Stream => assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernel), "{what}"),
                Shows::Counts => {
                    assert_eq!(found.miscounts.first().map(|m| m.kernel), Some(kernel), "{what}");
                    assert_eq!(found.breaches, [], "{what}");
                }
            }
        }
    }
}

/// Code that is compiled only for other scenes or rays: several lights, and rays that end at any hit.
#[test]
fn a_kernel_broken_for_other_rays_is_named() {
    let lights = scene("lights.gltf");
    let (from, to) = ("LIGHTS_SUMMED + end", "LIGHTS_SUMMED + end + 1u");
    let options = Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 8).of(&options(&lights, 40, 40));
    let found = parity::compare_broken_in_turns(&gpu(), &lights, &options, 1, change(kernels::SHADE, from, to));
    assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernels::SHADE), "lights are left out unnoticed");
    let rays = RaySource::Given(rays::segments(&scene("cornell-box.gltf"), 500, 3)).until(1.0);
    let shadows = room(Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 8));
    let shadows = Options { any_hit: true, shade: false, rays, ..shadows };
    for (from, to) in [
        ("select(TRAV, BACKGROUND, nearest_t <= exit)", "select(TRAV, BACKGROUND, nearest_t < 0.5 * exit)"),
        ("candidate.t < trace.t", "true"),
    ] {
        let found = compare_broken(&shadows, kernels::WALK, from, to);
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernels::WALK), "{to:?}");
    }
}

/// Code that is compiled only if triangles are set aside.
#[test]
fn a_kernel_broken_around_the_grid_is_named() {
    let knot = knot();
    for (schedule, steps, kernel, from, to) in [
        (ScheduleKind::Second, 1, kernels::SETUP, "select(INF, box.t, box.meets)", "box.t"),
        (ScheduleKind::Second, 1, kernels::TRAVERSE_IRREGULAR, "(walk.cell == OUTSIDE)", "(false)"),
        (ScheduleKind::Compact, 8, kernels::WALK, "(walk.cell == OUTSIDE)", "(false)"),
        (ScheduleKind::Fused, 1, kernels::FUSED, "return at_voxel(vec3i(0), OUTSIDE)", "return enter_cells(ray)"),
    ] {
        let options = Configuration::new(Accelerator::Irregular, schedule, steps).of(&options(&knot, 40, 40));
        let found = parity::compare_broken(&gpu(), &knot, &options, change(kernel, from, to));
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernel), "{to:?}");
    }
}

/// Emulates a GPU that contracts or divides differently: t, or distances to planes, are off by one rounding. No ray may
/// count as broken, and the few that take another path because of it must be found.
#[test]
fn other_rounding_is_not_broken() {
    use Accelerator::{Bvh, Grid, Irregular};
    use ScheduleKind::{Compact, Fused};
    const OF_A_STEP: (&str, &str) = ("ray.direction * t", "ray.direction * (t * 1.0000001)");
    let scene = scene("teapot.glb");
    let (mut tolerated, mut undecided) = (0, 0);
    for (kernel, configuration, from, to) in [
        (
            kernels::WALK,
            Configuration::new(Grid, Compact, 8),
            "trace.t = candidate.t",
            "trace.t = candidate.t * 1.0000001",
        ),
        (kernels::WALK, Configuration::new(Grid, Compact, 8), "- ray.origin)", "- ray.origin * 0.9999999)"),
        (
            kernels::WALK,
            Configuration::new(Grid, Compact, 8).skipping(),
            "ray.direction * t",
            "ray.direction * (t * 1.0000001)",
        ),
        (kernels::WALK, Configuration::new(Bvh, Compact, 8), "node.min - origin", "node.min * 0.9999999 - origin"),
        (
            kernels::WALK,
            Configuration::new(Bvh, Compact, 8).padded(),
            "node.min - origin",
            "node.min * 0.9999999 - origin",
        ),
        (kernels::FUSED, Configuration::new(Grid, Fused, 1), "- ray.origin)", "- ray.origin * 0.9999999)"),
        (kernels::TRAVERSE_IRREGULAR, Configuration::new(Irregular, Compact, 1), OF_A_STEP.0, OF_A_STEP.1),
        (kernels::WALK, Configuration::new(Irregular, Compact, 8), OF_A_STEP.0, OF_A_STEP.1),
        (kernels::FUSED, Configuration::new(Irregular, Fused, 1), "- ray.origin)", "- ray.origin * 0.9999999)"),
    ] {
        let options = Options { counters: true, ..configuration.of(&options(&scene, 128, 128)) };
        let found = parity::compare_changed(&gpu(), &scene, &options, change(kernel, from, to));
        assert_eq!(found.breaches, [], "{} {configuration} with {to:?}", kernel.name());
        let compared = found.compared.total();
        tolerated += compared.tolerated;
        undecided += compared.undecided;
    }
    assert!(tolerated > 0 && undecided > 0, "{tolerated} tolerated, {undecided} undecided");
}

/// A kernel that loses a ray from a list leaves its own streams correct, so the next kernel shows the error. Other
/// errors in lists and counts show in the kernel itself.
#[test]
fn broken_lists_and_books_show() {
    let [one, several] = [1, 8].map(|steps| room(Configuration::new(Accelerator::Grid, ScheduleKind::Compact, steps)));
    for (options, kernel, named) in [
        (&one, kernels::SETUP, kernels::INTERSECT),
        (&one, kernels::INTERSECT, kernels::TRAVERSE_GRID),
        (&several, kernels::SETUP, kernels::WALK),
        (&several, kernels::WALK, kernels::WALK),
    ] {
        // A workgroup's last ray overwrites another one in the list.
        let found = compare_broken(options, kernel, "first_ray[list] + place", "first_ray[list] + min(place, 254u)");
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(named), "{} loses a ray", kernel.name());
    }
    for (options, kernel) in [(&one, kernels::TRAVERSE_GRID), (&several, kernels::WALK)] {
        let found = compare_broken(options, kernel, "place >= own_list[3]", "place + 1u >= own_list[3]");
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernel), "{} leaves a ray out", kernel.name());
        let found = compare_broken(options, kernel, "atomicAdd(&sent_here[tag], 1u)", "atomicAdd(&sent_here[tag], 2u)");
        assert_eq!(found.miscounts.first().map(|m| m.kernel), Some(kernel), "{:?}", found.miscounts);
    }
}
