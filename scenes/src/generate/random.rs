//! Random numbers that are the same on every machine.

/// SplitMix64: Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014.
pub(super) struct Random(u64);

/// The finaliser of SplitMix64, a bijection in which every input bit affects every output bit.
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Uniform in [0, 1), a multiple of 2^-24, which f32 represents exactly.
    pub(super) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// Uniform in [-1, 1).
    pub(super) fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// Three numbers in [-1, 1).
    pub(super) fn signed3(&mut self) -> glam::Vec3 {
        // Three statements, because the order of the draws is part of the result.
        let x = self.signed();
        let y = self.signed();
        let z = self.signed();
        glam::Vec3::new(x, y, z)
    }

    /// A uniformly distributed direction: by rejection, which needs no sine (von Neumann 1951).
    pub(super) fn direction(&mut self) -> glam::Vec3 {
        loop {
            let v = self.signed3();
            let l = v.length_squared();
            if l <= 1.0 && l > 1e-4 {
                return v / l.sqrt();
            }
        }
    }
}
