//! Random numbers that are the same bits on every machine.

use glam::DVec3;

/// PCG's RXS-M-XS 32/32: O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good
/// Algorithms for Random Number Generation", 2014.
pub(crate) struct Random {
    state: u32,
}

impl Random {
    /// A pixel's own sequence. It begins at a hash of pixel and seed by the same step, as Jarzynski and Olano,
    /// "Hash Functions for GPU Rendering", JCGT 9(3), 2020, recommend.
    pub(crate) fn new(pixel: u32, seed: u32) -> Self {
        Self { state: pcg(pixel.wrapping_add(pcg(seed))) }
    }

    fn next(&mut self) -> u32 {
        let value = output(self.state);
        self.state = advance(self.state);
        value
    }

    /// Evenly in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        f64::from(self.next()) / 4_294_967_296.0
    }

    /// Evenly from 0 to `count` - 1; 0 where there is no such number.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Evenly on the unit sphere: Marsaglia, "Choosing a Point from the Surface of a Sphere", 1972. It needs
    /// neither sine nor cosine, which differ between machines.
    pub(crate) fn on_sphere(&mut self) -> DVec3 {
        // Each turn succeeds with probability π/4: nobody will see the end of the loop.
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
}

fn pcg(value: u32) -> u32 {
    output(advance(value))
}

fn advance(state: u32) -> u32 {
    state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453)
}

fn output(state: u32) -> u32 {
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!([0, 1, 2].map(pcg), [129_708_002, 2_831_084_092, 2_055_130_248]);
    }
}
