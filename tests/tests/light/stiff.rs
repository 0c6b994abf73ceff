//! Stiff cases of shadow rays: grazing light, lights on surfaces, touching boxes, thin walls, far, tiny and huge scenes.

use glam::{DMat3, DVec3};
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Accelerator, Options, Ray, RaySource, ScheduleKind};
use raystep_lab::rays::Random;
use raystep_scenes::{Light, Scene};
use raystep_tests::configurations::Configuration;
use raystep_tests::{devices, thorough, traced, values};

use super::{COLOR, HIT, HIT_TRIANGLE, judged, with_shadows};

type Triangle = [DVec3; 3];

/// Rays of a case: in the full suite, eight times as many.
fn rays() -> u32 {
    if thorough() { 8 * 256 } else { 256 }
}

/// A box of twelve triangles that face outwards.
fn solid(centre: DVec3, half: DVec3) -> Vec<Triangle> {
    let corner = |i: usize| {
        let side = DVec3::new([-1.0, 1.0][i & 1], [-1.0, 1.0][i >> 1 & 1], [-1.0, 1.0][i >> 2 & 1]);
        centre + side * half
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect()
}

/// 12 by 12 squares around the origin, which face up.
fn floor() -> Vec<Triangle> {
    const SIDE: i32 = 12;
    let at = |i: i32, k: i32| DVec3::new(f64::from(2 * i - SIDE), 0.0, f64::from(2 * k - SIDE)) / f64::from(SIDE);
    let places = (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| (i, k)));
    let square =
        |(i, k): (i32, i32)| [[at(i, k), at(i, k + 1), at(i + 1, k + 1)], [at(i, k), at(i + 1, k + 1), at(i + 1, k)]];
    places.flat_map(square).collect()
}

/// Triangles with lights, the points that rays go to, and where these come from.
struct Case {
    triangles: Vec<Triangle>,
    /// Positions of point lights.
    points: Vec<DVec3>,
    /// Directions of directional lights.
    directions: Vec<DVec3>,
    from: DVec3,
}

impl Case {
    fn new(triangles: Vec<Triangle>) -> Self {
        Self { triangles, points: Vec::new(), directions: Vec::new(), from: DVec3::new(0.2, 1.7, 0.1) }
    }

    /// The same, turned, scaled and moved.
    fn placed(mut self, turn: DMat3, scale: f64, offset: DVec3) -> Self {
        let to = |p: DVec3| turn * p * scale + offset;
        self.triangles.iter_mut().flatten().for_each(|p| *p = to(*p));
        self.points.iter_mut().for_each(|p| *p = to(*p));
        self.directions.iter_mut().for_each(|d| *d = turn * *d);
        Self { from: to(self.from), ..self }
    }

    fn scene(&self) -> Scene {
        let triangles = self.triangles.iter().map(|t| t.map(|p| p.as_vec3().to_array())).collect();
        let color = [1.0; 3];
        let points =
            self.points.iter().map(|p| Light::Point { position: p.as_vec3().to_array(), color, intensity: 1.0 });
        let directions = self.directions.iter().map(|d| Light::Directional {
            direction: d.normalize().as_vec3().to_array(),
            color,
            intensity: 1.0,
        });
        Scene { lights: points.chain(directions).collect(), ..Scene::from_triangles(triangles) }
    }

    /// Rays from about one place to the insides and edges of triangles.
    fn rays(&self) -> Vec<Ray> {
        let size = self.triangles.iter().flatten().map(|p| p.distance(self.from)).fold(0.0, f64::max);
        let ray = |i: u32| {
            let mut random = Random::of(i, 11);
            let [a, b, c] = self.triangles[random.below(self.triangles.len())];
            let (u, v) = random.in_triangle();
            let target = if i.is_multiple_of(3) { a.lerp(b, random.unit()) } else { a + (b - a) * u + (c - a) * v };
            let origin = (self.from + random.on_sphere() * 0.1 * size).as_vec3();
            Ray::new(origin.to_array(), (target - origin.as_dvec3()).as_vec3().to_array())
        };
        (0..rays()).map(ray).collect()
    }

    /// Traces it every way, on every device, and judges each shadow ray in f64: none is wrong, none hits what it leaves.
    /// Returns how many there were, how many of these were occluded and how many ties.
    fn judge(&self, name: &str) -> [usize; 3] {
        use ScheduleKind::{Compact, Fused, Second};
        let scene = self.scene();
        let mut sums = [0; 3];
        let structures = [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None];
        for (row, accelerator) in structures.into_iter().enumerate() {
            for (place, (on, device)) in devices().into_iter().enumerate() {
                let schedule = [Fused, Compact, Second][(row + place) % 3];
                let of = Configuration::new(accelerator, schedule, if schedule == Compact { 64 } else { 1 });
                let options = with_shadows(of.of(&Options::new(RaySource::Given(self.rays()))));
                let found = judged(&scene, &options, &device);
                assert_eq!(found.wrong, [""; 0], "{name}, {of} on {on}");
                assert_eq!(found.own, 0, "{name}, {of} on {on}: rays hit the surface that they leave");
                for (sum, count) in sums.iter_mut().zip([found.rays, found.occluded, found.ties]) {
                    *sum += count;
                }
            }
        }
        println!("{name}: {} shadow rays, {} occluded, {} ties", sums[0], sums[1], sums[2]);
        sums
    }
}

fn aslant() -> DMat3 {
    DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(0.4)
}

/// A floor with a box on it, whose face lies in the plane of the floor.
fn stage() -> Case {
    let on_floor = solid(DVec3::new(0.13, 0.25, -0.11), DVec3::new(0.21, 0.25, 0.17));
    Case::new([floor(), on_floor].concat())
}

#[test]
fn grazing_light_is_decided_right() {
    for turn in [DMat3::IDENTITY, aslant()] {
        for sine in [0.1, 1e-3, 1e-5, 1e-6, 1e-7] {
            let mut case = stage();
            case.directions = vec![DVec3::new(0.8, -sine, 0.6), DVec3::new(-1.0, -sine, 0.0)];
            // As near to the floor, from inside of its edges and outside.
            case.points = vec![DVec3::new(-0.7, sine, 0.37), DVec3::new(3.0, sine, -2.0)];
            let [rays, occluded, _] = case.placed(turn, 1.0, DVec3::ZERO).judge(&format!("sine {sine:e}"));
            assert!(rays > 1_000 && occluded > 50, "{rays} rays, {occluded} occluded");
        }
    }
}

/// A light within a triangle, on an edge, on a vertex, and as near to one as rounding allows.
#[test]
fn a_light_on_a_surface_is_decided_right() {
    for turn in [DMat3::IDENTITY, aslant()] {
        let mut case = stage();
        let [a, b, c] = case.triangles[floor().len()];
        let [p, q, _] = case.triangles[40];
        case.points =
            vec![(a + b + c) / 3.0, (a + b) / 2.0, a, (p + q) / 2.0, p, p + DVec3::Y * 6e-8, p - DVec3::Y * 6e-8];
        let [rays, ..] = case.placed(turn, 1.0, DVec3::ZERO).judge("on a surface");
        assert!(rays > 1_000, "{rays} rays");
    }
}

/// Boxes that share a face, an edge and a corner, with lights in the planes of their faces.
#[test]
fn touching_boxes_are_decided_right() {
    for turn in [DMat3::IDENTITY, aslant()] {
        let half = DVec3::splat(0.25);
        let places = [[0.0, 0.25, 0.0], [0.5, 0.25, 0.0], [0.0, 0.75, 0.5], [-0.5, 0.75, -0.5]];
        let boxes = places.into_iter().flat_map(|place| solid(place.into(), half));
        let mut case = Case::new(floor().into_iter().chain(boxes).collect());
        case.points =
            [[0.25, 1.5, 0.9], [0.9, 0.5, 0.25], [-0.25, 0.5, 1.4], [0.25, 0.5, 0.6]].map(DVec3::from).to_vec();
        case.directions = vec![DVec3::new(0.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0)];
        let [rays, occluded, _] = case.placed(turn, 1.0, DVec3::ZERO).judge("touching boxes");
        assert!(rays > 2_000 && occluded > 500, "{rays} rays, {occluded} occluded");
    }
}

/// Behind a wall, a thousandth to a millionth of the scene thick, lamps about as near to it as it is thick: none shines
/// through.
#[test]
fn no_lamp_shines_through_a_thin_wall() {
    for turn in [DMat3::IDENTITY, aslant()] {
        for thickness in [1e-3, 1e-5, 1e-6] {
            let mut case = Case::new(solid(DVec3::ZERO, DVec3::new(1.0, thickness / 2.0, 1.0)));
            case.triangles.extend(solid(DVec3::new(0.5, 0.3, -0.5), DVec3::splat(0.1)));
            // A ceiling, which faces down.
            case.triangles.extend(floor().iter().map(|[a, b, c]| [a, c, b].map(|p| *p * 0.9 + DVec3::Y * 0.9)));
            case.from = DVec3::new(0.1, 0.5, 0.2);
            // Below the wall, within its edges: all that the rays hit is above it. Rays to a light end before it by 16 roundings
            // of the scene's size and the light's position, 2e-6 here: nearer to a wall than that, a lamp is on it for f32.
            let near = f64::max(thickness, 1e-5);
            let lamp = |[x, z]: [f64; 2], away: f64| DVec3::new(x, -thickness / 2.0 - away, z);
            case.points = vec![lamp([0.0, 0.0], near), lamp([0.31, -0.47], near), lamp([-0.6, 0.2], 0.3)];
            let case = case.placed(turn, 1.0, DVec3::ZERO);
            let [rays, occluded, _] = case.judge(&format!("wall of {thickness:e}"));
            assert!(rays > 1_000, "{rays} rays");
            // Ties too: who passes between two triangles of the wall is stopped by one of them.
            assert_eq!(occluded, rays, "wall of {thickness:e}");
            for (row, (on, device)) in devices().into_iter().enumerate() {
                let of = Configuration::new([Accelerator::Bvh, Accelerator::Grid][row], ScheduleKind::Fused, 1);
                let options = with_shadows(of.of(&Options::new(RaySource::Given(case.rays()))));
                let renderer = traced(&case.scene(), &options, &device);
                let (hit, light) = (values(&renderer, HIT), values(&renderer, COLOR));
                // What hits nothing has the background's colour.
                let is_hit = |ray: &usize| hit.get(HIT_TRIANGLE, *ray) != NO_TRIANGLE;
                let lit = (0..case.rays().len()).filter(is_hit).filter(|&ray| light.get_f32(1, ray) != 0.0).count();
                assert_eq!(lit, 0, "wall of {thickness:e}: rays with light on {on}");
            }
        }
    }
}

#[test]
fn far_tiny_and_huge_scenes_are_decided_right() {
    let away = DVec3::new(1.0, -0.7, 0.4);
    let places = [
        ("100 away", 1.0, away * 1e2),
        ("10,000 away", 1.0, away * 1e4),
        ("100,000 away", 1.0, away * 1e5),
        ("tiny", 1e-12, DVec3::ZERO),
        ("tiny and away", 1e-12, away * 1e-9),
        ("huge", 1e12, DVec3::ZERO),
        ("huge and away", 1e12, away * 1e15),
    ];
    for (name, scale, offset) in places {
        let mut case = stage();
        case.points = vec![DVec3::new(-0.7, 0.6, 0.37), DVec3::new(0.4, 1.5, -0.9), DVec3::new(0.35, 1e-3, 0.07)];
        case.directions = vec![DVec3::new(0.8, -0.3, 0.6)];
        let [rays, occluded, _] = case.placed(aslant(), scale, offset).judge(name);
        assert!(rays > 2_000 && occluded > 100, "{name}: {rays} rays, {occluded} occluded");
    }
}
