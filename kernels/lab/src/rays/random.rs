//! Random numbers that are the same bits on every machine: fastrand's wyrand.

use glam::DVec3;

/// A sequence of random numbers.
#[derive(Clone, Debug)]
pub struct Random(fastrand::Rng);

impl Random {
    /// A separate sequence for every seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    /// A separate sequence for every element and seed.
    #[must_use]
    pub fn of(index: u32, seed: u32) -> Self {
        // Sequences of adjacent seeds start alike; seeds drawn from them are not adjacent.
        let drawn = |seed: u32| fastrand::Rng::with_seed(u64::from(seed)).u64(..);
        Self::new(drawn(seed).rotate_left(32).wrapping_add(drawn(index)))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0.f64()
    }

    /// Uniform from 0 to `count` - 1; 0 if `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        // As u64, so that 32-bit machines draw the same numbers.
        if count == 0 { 0 } else { self.0.u64(..count as u64) as usize }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.u64(..)
    }

    /// Puts values into a random order.
    pub fn shuffle<T>(&mut self, values: &mut [T]) {
        // Fisher and Yates, by our own draws: these are the same on 32-bit machines.
        for i in (1..values.len()).rev() {
            values.swap(i, self.below(i + 1));
        }
    }

    /// Weights of the second and third corner of a triangle, uniform over its area.
    pub fn in_triangle(&mut self) -> (f64, f64) {
        let (u, v) = (self.unit(), self.unit());
        if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) }
    }

    /// Uniform on the unit sphere: Marsaglia, "Choosing a Point from the Surface of a Sphere", 1972. It needs neither
    /// sine nor cosine, which differ between machines.
    pub fn on_sphere(&mut self) -> DVec3 {
        // Each iteration succeeds with probability π/4, so the loop never reaches its limit in practice.
        for _ in 0..1000 {
            let x = 2.0 * self.unit() - 1.0;
            let y = 2.0 * self.unit() - 1.0;
            let s = x * x + y * y;
            if s < 1.0 {
                let r = 2.0 * (1.0 - s).sqrt();
                return DVec3::new(x * r, y * r, 1.0 - 2.0 * s);
            }
        }
        DVec3::Z
    }

    /// Uniform on the unit sphere, rounded to f32.
    pub fn direction(&mut self) -> [f32; 3] {
        self.on_sphere().as_vec3().to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Different numbers would mean different rays: earlier benchmarks would not be comparable.
    #[test]
    fn the_numbers_do_not_change_with_the_crate() {
        let mut random = Random::of(7, 1);
        let drawn = [random.below(1000), random.below(1000), random.below(1000)];
        assert_eq!((drawn, random.unit()), ([83, 572, 933], 0.467_104_027_893_448_3));
    }

    #[test]
    fn neighbours_draw_other_numbers() {
        let first: Vec<f64> = (0..4096).map(|index| Random::of(index, 1).unit()).collect();
        let mean = first.iter().sum::<f64>() / 4096.0;
        // Mean within four standard errors; successive numbers uncorrelated within five.
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12f64).sqrt() / 64.0, "{mean}");
        let correlation = first.windows(2).map(|w| (w[0] - 0.5) * (w[1] - 0.5)).sum::<f64>() / 4095.0 * 12.0;
        assert!(correlation.abs() < 5.0 / 64.0, "{correlation}");
        assert_eq!((Random::new(3).below(0), Random::new(3).below(1)), (0, 0));
    }
}
