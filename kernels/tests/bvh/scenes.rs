//! Test scenes for BVHs.

use raystep_scenes::generate;

/// Pseudo-random numbers in [-1, 1).
pub(crate) struct Random(fastrand::Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    pub(crate) fn unit(&mut self) -> f32 {
        self.0.f32() * 2.0 - 1.0
    }

    pub(crate) fn vector(&mut self) -> [f32; 3] {
        [self.unit(), self.unit(), self.unit()]
    }
}

/// Corners of triangles of a given size in the box [-1, 1] times `extent`, moved by `offset`.
pub(crate) fn soup(count: usize, size: f32, extent: [f32; 3], offset: f32) -> Vec<f32> {
    let mut random = Random::new(1);
    let mut vertices = Vec::new();
    for _ in 0..count {
        let center = extent.map(|e| random.unit() * e);
        for _ in 0..3 {
            let corner = [0, 1, 2].map(|a| if extent[a] == 0.0 { 0.0 } else { center[a] + random.unit() * size });
            vertices.extend(corner.map(|v| v + offset));
        }
    }
    vertices
}

/// Long thin triangles in all directions, of which much can be cut.
pub(crate) fn needles(count: usize) -> Vec<f32> {
    let mut random = Random::new(2);
    let mut vertices = Vec::new();
    for _ in 0..count {
        let from = random.vector();
        let length = 0.003 / (random.unit().abs() + 0.002);
        let along = random.vector().map(|v| v * length);
        let width = random.vector().map(|v| v * 0.001);
        vertices.extend(from);
        vertices.extend([0, 1, 2].map(|a| from[a] + along[a]));
        vertices.extend([0, 1, 2].map(|a| from[a] + width[a]));
    }
    vertices
}

/// Nested boxes, the outermost first or last.
pub(crate) fn nested(count: usize, outermost_first: bool) -> Vec<f32> {
    let sizes = (1..=count).map(|i| if outermost_first { count + 1 - i } else { i } as f32 / count as f32);
    sizes.flat_map(|s| [-s, -s, -s, s, s, s, -s, s, 0.0]).collect()
}

/// The scenes on which every guarantee is checked.
pub(crate) fn scenes() -> Vec<(&'static str, Vec<f32>)> {
    let flat = |scene: raystep_scenes::Scene| scene.triangles.as_flattened().as_flattened().to_vec();
    vec![
        ("none", Vec::new()),
        ("one", soup(1, 0.5, [1.0; 3], 0.0)),
        ("two", soup(2, 0.5, [1.0; 3], 0.0)),
        ("five", soup(5, 0.5, [1.0; 3], 0.0)),
        ("soup", soup(3000, 0.05, [1.0; 3], 0.0)),
        ("filling", soup(2000, 1.0, [1.0; 3], 0.0)),
        ("flat", soup(2000, 0.05, [1.0, 0.0, 1.0], 0.0)),
        ("on a line", soup(2000, 0.01, [1.0, 0.0, 0.0], 0.0)),
        ("points", soup(500, 0.0, [1.0; 3], 0.0)),
        ("in one point", vec![0.25; 9 * 500]),
        ("tiny", soup(2000, 1e-25, [1.0; 3], 0.0).iter().map(|v| v * 1e-10).collect()),
        ("far away", soup(2000, 0.05, [1.0; 3], 1e6)),
        ("farther", soup(2000, 64.0, [256.0; 3], (1u32 << 28) as f32)),
        ("identical", soup(1, 0.5, [1.0; 3], 0.0).repeat(10_000)),
        ("nested", nested(3000, true)),
        ("nested, inside out", nested(3000, false)),
        ("needles", needles(3000)),
        ("hair", flat(generate::hair(64, 1).expect("hair"))),
        ("terrain", flat(generate::terrain(5000, 1).expect("terrain"))),
        ("room", flat(generate::tiny_in_room(2000, 100_000).expect("room"))),
    ]
}
