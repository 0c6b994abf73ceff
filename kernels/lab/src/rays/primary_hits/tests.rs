use std::ops::ControlFlow;

use raystep_kernels::{Device, Options, RaySource, Renderer};
use raystep_scenes::generate;

use super::*;

fn camera(eye: DVec3) -> Camera {
    let projection = Projection::Perspective { vertical_fov: 1.0 };
    Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection).expect("a view")
}

/// A floor at y = 7, seen from above; some pixels hit nothing.
fn floor(lights: Vec<Light>) -> (Scene, Vec<Option<RayHit>>) {
    let triangles = vec![[[-4.0, 7.0, -4.0], [4.0, 7.0, -4.0], [0.0, 7.0, 8.0]]];
    let hit = |i: u32| RayHit { t: 1.0, u: 0.3, v: (i % 64) as f32 / 100.0, triangle: 0 };
    let hits = (0..16_384).map(|i| (i % 4 != 1).then(|| hit(i))).collect();
    (Scene { triangles, lights, ..Scene::default() }, hits)
}

#[test]
fn bounces_leave_on_the_viewers_side_cosine_weighted() {
    let (scene, hits) = floor(Vec::new());
    for side in [1.0, -1.0] {
        let camera = camera(DVec3::new(0.0, 7.0 + 20.0 * side, 1.0));
        let rays = PrimaryHits { scene: &scene, camera: &camera, width: 128, hits: &hits }.bounce(1);
        assert_eq!(rays.len(), 12_288, "one per hit");
        let mut cosines = [0.0; 2];
        let mut sum = Vec3::ZERO;
        for ray in &rays {
            let height = (f64::from(ray.origin[1]) - 7.0) * side;
            // At most about 90 roundings of the triangle's size, which is 12.6.
            assert!(height > 0.0 && height < 8e-5, "{ray:?}");
            let cosine = f64::from(ray.direction[1]) * side;
            assert!(cosine >= 0.0, "{ray:?} goes below");
            cosines[0] += cosine;
            cosines[1] += cosine * cosine;
            sum += Vec3::from(ray.direction);
        }
        // The means of cos θ and cos² θ are 2/3 and 1/2; tolerance is five standard errors of 12,288 rays.
        let n = rays.len() as f64;
        assert!((cosines[0] / n - 2.0 / 3.0).abs() < 0.011, "{}", cosines[0] / n);
        assert!((cosines[1] / n - 0.5).abs() < 0.014, "{}", cosines[1] / n);
        assert!((sum.x / sum.y).abs() < 0.03 && (sum.z / sum.y).abs() < 0.03, "no side is preferred: {sum}");
    }
}

#[test]
fn shadow_rays_end_at_the_light_unless_it_is_behind() {
    let color = [1.0; 3];
    let point = |y| Light::Point { position: [1.0, y, 2.0], color, intensity: 1.0 };
    let above = camera(DVec3::new(0.0, 30.0, 1.0));
    let rays = |lights: Vec<Light>, camera: &Camera| {
        let (scene, hits) = floor(lights);
        PrimaryHits { scene: &scene, camera, width: 128, hits: &hits }.shadow(1)
    };
    let end = |ray: &Ray| Vec3::from(ray.origin) + Vec3::from(ray.direction);
    let lit = rays(vec![point(9.0)], &above);
    assert_eq!(lit.len(), 12_288);
    assert!(lit.iter().all(|r| end(r).abs_diff_eq(Vec3::new(1.0, 9.0, 2.0), 1e-5)));
    assert_eq!(rays(vec![point(-9.0)], &above), [], "the floor blocks its light everywhere");
    assert_eq!(rays(vec![point(9.0)], &camera(DVec3::new(0.0, -30.0, 1.0))), []);

    let down = Light::Directional { direction: [0.0, -1.0, 0.0], color, intensity: 1.0 };
    let far = (8.0f32 * 8.0 + 12.0 * 12.0).sqrt() * 2.0;
    assert!(rays(vec![down], &above).iter().all(|r| r.direction == [0.0, far, 0.0]));

    let both = rays(vec![point(9.0), point(12.0)], &above);
    let low = both.iter().filter(|r| end(r).y < 10.0).count();
    assert!((5_800..6_500).contains(&low), "each light gets its half: {low} of {}", both.len());

    // Without a light, the centre of the box's top is used; a slope raises the top above the floor.
    let (mut scene, hits) = floor(Vec::new());
    scene.triangles.push([[-4.0, 7.0, 0.0], [4.0, 11.0, 0.0], [0.0, 7.0, 0.0]]);
    let rays = PrimaryHits { scene: &scene, camera: &above, width: 128, hits: &hits }.shadow(1);
    assert!(!rays.is_empty() && rays.iter().all(|r| end(r).abs_diff_eq(Vec3::new(0.0, 11.0, 2.0), 1e-5)));
}

#[test]
fn a_pixels_ray_is_its_own() {
    let (scene, hits) = floor(Vec::new());
    let camera = camera(DVec3::new(0.0, 20.0, 1.0));
    let bounce =
        |hits: &[Option<RayHit>], seed| PrimaryHits { scene: &scene, camera: &camera, width: 128, hits }.bounce(seed);
    let all = bounce(&hits, 1);
    assert_eq!(all, bounce(&hits, 1));
    assert_ne!(all, bounce(&hits, 2));
    let mut fewer = hits.clone();
    fewer[..8].fill(None);
    let kept = bounce(&fewer, 1);
    assert_eq!(kept.len(), all.len() - 6);
    assert!(kept.iter().all(|ray| all.contains(ray)), "what other pixels see does not matter");
    assert_eq!(bounce(&vec![None; 9], 1), []);
}

#[test]
fn what_cannot_be_traced_is_left_out() {
    let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let huge = [[f32::MAX, 0.0, 0.0], [f32::MAX, 1.0, 0.0], [f32::MAX, 0.0, 1.0]];
    let scene = Scene { triangles: vec![line, huge], ..Scene::default() };
    let camera = camera(DVec3::new(1e39, 0.0, 5.0));
    let hits: Vec<_> = (0..3).map(|triangle| Some(RayHit { t: 1.0, u: 0.1, v: 0.1, triangle })).collect();
    assert_eq!(PrimaryHits { scene: &scene, camera: &camera, width: 128, hits: &hits }.bounce(1), []);
}

/// A ball on a floor, six units wide, moved along x.
fn ball(moved: f32) -> Scene {
    let mut triangles = generate::icosphere(2).expect("a ball").triangles;
    let [a, b, c, d] = [[-3.0, -1.0, -3.0], [3.0, -1.0, -3.0], [3.0, -1.0, 3.0], [-3.0, -1.0, 3.0]];
    triangles.extend([[a, b, c], [a, c, d]]);
    triangles.iter_mut().flatten().for_each(|corner| corner[0] += moved);
    Scene::from_triangles(triangles)
}

fn hits(scene: &Scene, rays: RaySource) -> Vec<Option<RayHit>> {
    pollster::block_on(async {
        let options = Options { shade: false, ..Options::new(rays) };
        let mut renderer = Renderer::new(scene, &options, &Device::Cpu(None)).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        renderer.hits().await
    })
    .expect("a run")
}

/// Bounce rays, those of them that hit something, and shadow rays of a view of a scene.
fn counts(scene: &Scene, camera: Camera) -> [usize; 3] {
    let (width, height) = (64, 64);
    let seen = hits(scene, RaySource::Camera { camera: camera.clone(), width, height });
    let from = PrimaryHits { scene, camera: &camera, width, hits: &seen };
    let bounce = from.bounce(1);
    let hit = hits(scene, RaySource::Given(bounce.clone())).iter().flatten().count();
    [bounce.len(), hit, from.shadow(1).len()]
}

#[test]
fn a_scene_far_from_the_origin_keeps_its_bounces_and_shadows() {
    let [rays, hit, shadows] = {
        let scene = ball(0.0);
        counts(&scene, Camera::framing(&scene.bounds()))
    };
    assert!(rays > 500 && hit > 50 && shadows > 300, "{rays} {hit} {shadows}");
    for moved in [1e2, 1e4, 1e6, -3e6] {
        let scene = ball(moved);
        let found = counts(&scene, Camera::framing(&scene.bounds()));
        // At 3e6 corners are rounded to quarters, so the ball is not as round, and its pixels are a few more or less.
        for (name, before, after) in
            [("rays", rays, found[0]), ("hits", hit, found[1]), ("shadow rays", shadows, found[2])]
        {
            let share = after as f64 / before as f64;
            assert!((0.8..1.25).contains(&share), "{name} of the ball at {moved}: {after} instead of {before}");
        }
    }
}

#[test]
fn what_is_far_away_does_not_matter() {
    let near = ball(0.0);
    let camera = Camera::framing(&near.bounds());
    let mut triangles = near.triangles.clone();
    triangles.push([[1e6, 0.0, 0.0], [1e6, 1.0, 0.0], [1e6, 0.0, 1.0]]);
    let far = Scene::from_triangles(triangles);
    assert_eq!(counts(&far, camera.clone())[..2], counts(&near, camera)[..2]);
}

#[test]
fn no_bounce_hits_the_triangle_that_it_leaves() {
    for (scale, scene) in [1e-20f32, 1.0, 1e20].into_iter().flat_map(|s| [(s, ball(0.0)), (s, generate::cornell_box())])
    {
        let triangles = scene.triangles.iter().map(|t| t.map(|corner| corner.map(|v| v * scale))).collect();
        let scene = Scene::from_triangles(triangles);
        let camera = Camera::framing(&scene.bounds());
        let (width, height) = (48, 48);
        let seen = hits(&scene, RaySource::Camera { camera: camera.clone(), width, height });
        let seen: Vec<_> = seen.into_iter().flatten().map(Some).collect();
        let from = PrimaryHits { scene: &scene, camera: &camera, width: seen.len() as u32, hits: &seen };
        let rays = from.bounce(1);
        assert_eq!(rays.len(), seen.len(), "one per hit at scale {scale}");
        for (ray, hit) in rays.iter().zip(hits(&scene, RaySource::Given(rays.clone()))) {
            // The nearest of the places that rays left from.
            let left = seen.iter().flatten().min_by(|a, b| {
                let off = |hit: &RayHit| {
                    let departure = from.departure(hit).expect("a normal");
                    (departure.point - Vec3::from(ray.origin).as_dvec3()).length()
                };
                off(a).total_cmp(&off(b))
            });
            let triangle = left.map(|hit| hit.triangle);
            assert!(
                hit.is_none() || hit.map(|hit| hit.triangle) != triangle,
                "scale {scale}: {ray:?} hits {triangle:?}"
            );
        }
    }
}
