//! Rays with an end, like shadow rays: the only result is whether anything lies before it.

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Accelerator, Device, Options, Ray, RaySource, Renderer};
use raystep_lab::rays::PrimaryHits;
use raystep_lab::reference::{Possible, possible};
use raystep_scenes::Scene;
use raystep_tests::configurations::EVERY;
use raystep_tests::{block_on, camera, devices, options, rays, scene, thorough, traced, values};

/// The result of f64 brute force for a ray.
#[derive(Clone, Debug, PartialEq)]
struct Truth {
    /// The ray's end, as its t.
    end: f64,
    /// What it may hit before that, as far as f32 can tell.
    before: Vec<Possible>,
    /// Whether something certainly lies before its end.
    is_hit: bool,
}

/// The correct result for every ray of a run that has not started; its end is its initial t.
fn truth(renderer: &Renderer) -> Vec<Truth> {
    let [origins, directions, state] =
        [streams::RAY_ORIGIN, streams::RAY_DIRECTION, streams::STATE].map(|s| values(renderer, s));
    let data = renderer.data();
    let of = |ray: usize| {
        let [origin, direction] = [&origins, &directions].map(|s| [0, 1, 2].map(|layer| s.get_f32(layer, ray)));
        let end = f64::from(state.get_f32(1, ray));
        let seen = (0..data.info.triangles).filter_map(|id| possible(&data.vertices, origin, direction, id));
        let before: Vec<Possible> = seen.filter(|p| p.t - p.t_bound <= end).collect();
        let is_hit = before.iter().any(|p| p.is_definite && p.t + p.t_bound < end);
        Truth { end, before, is_hit }
    };
    (0..renderer.plan().rays as usize).map(of).collect()
}

/// The mistake of a ray that hit `triangle`, or nothing, at `t`.
fn mistake(truth: &Truth, triangle: u32, t: f32) -> Option<&'static str> {
    if triangle == NO_TRIANGLE {
        return truth.is_hit.then_some("missed what lies before its end");
    }
    let Some(hit) = truth.before.iter().find(|p| p.triangle == triangle) else {
        return Some("hit what does not lie before its end");
    };
    let t = f64::from(t);
    (t >= truth.end || (t - hit.t).abs() > hit.t_bound).then_some("hit at a wrong t")
}

/// Rays from the camera's hits to the lights.
fn shadow_rays(scene: &Scene, device: &Device) -> Vec<Ray> {
    let mut options = options(scene, 32, 32);
    options.shade = false;
    let renderer = traced(scene, &options, device);
    let hits = block_on(renderer.gpu().map(|g| &**g.gpu()), renderer.hits()).expect("hits");
    PrimaryHits { scene, camera: &camera(scene), width: 32, hits: &hits }.shadow(1)
}

#[test]
fn what_lies_before_a_rays_end_is_found_and_what_lies_behind_is_not() {
    let files = ["cornell-box.gltf", "lights.gltf", "primitives.gltf", "skin-and-morph.gltf", "terrain.glb"];
    for (place, file) in files.into_iter().enumerate() {
        let scene = scene(file);
        let mut given = shadow_rays(&scene, &Device::Cpu(None));
        assert!(given.len() > 20, "{file}: {} rays towards lights", given.len());
        given.extend(rays::segments(&scene, 400, 11));
        let options = Options { any_hit: true, shade: false, ..Options::new(RaySource::Given(given).until(1.0)) };
        let start = block_on(None, Renderer::new(&scene, &options, &Device::Cpu(None))).expect("a renderer");
        let truth = truth(&start);
        let (hits, free) = (truth.iter().filter(|t| t.is_hit), truth.iter().filter(|t| t.before.is_empty()));
        let (hits, free) = (hits.count(), free.count());
        assert!(hits > 20 && free > 20, "{file}: {hits} rays hit, {free} do not");
        // Three quarters of the segments start or end on a surface, which is a tie unless they hit another triangle.
        assert!(10 * (hits + free) > 6 * truth.len(), "{file}: {hits} rays hit, {free} do not, of {}", truth.len());
        for (name, device) in devices() {
            for (row, configuration) in EVERY.into_iter().enumerate() {
                // Every configuration is tried on every other scene; in the full suite, on every scene.
                if (row + place) % 2 > 0 && !thorough() {
                    continue;
                }
                // These need as many passes as there are triangles.
                if configuration.accelerator == Accelerator::None
                    && configuration.steps == 1
                    && scene.triangles.len() > 500
                {
                    continue;
                }
                let renderer = traced(&scene, &configuration.of(&options), &device);
                assert_eq!(renderer.unfinished(), 0, "{file} {name} {configuration}");
                let (state, hit) = (values(&renderer, streams::STATE), values(&renderer, streams::HIT));
                for (ray, truth) in truth.iter().enumerate() {
                    let (triangle, t) = (hit.get(2, ray), state.get_f32(1, ray));
                    let wrong = mistake(truth, triangle, t);
                    assert_eq!(
                        wrong, None,
                        "{file} {name} {configuration}: ray {ray} at {t}, triangle {triangle}: {truth:?}"
                    );
                }
            }
        }
    }
}
