//! A hash to compare contents: scene files, kernel sources, hits.

use std::fmt;
use std::str::FromStr;

use raystep_kernels::RayHit;

/// FNV-1a, 64 bits (Fowler, Noll and Vo; draft-eastlake-fnv): compares contents; it is not cryptographic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    /// Hashes bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let mut hash = Self::default();
        hash.add(bytes);
        hash
    }

    /// Adds more bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Hashes numbers by their bits.
    #[must_use]
    pub fn of_floats(values: &[f32]) -> Self {
        let mut hash = Self::default();
        values.iter().for_each(|value| hash.add(&value.to_bits().to_le_bytes()));
        hash
    }

    /// Hashes a scene that no file has.
    #[must_use]
    pub fn of_triangles(triangles: &[[[f32; 3]; 3]]) -> Self {
        Self::of_floats(triangles.as_flattened().as_flattened())
    }

    /// Hashes the hits of all rays by their bits. If rays may stop at any hit, only whether they hit is hashed.
    #[must_use]
    pub fn of_hits(hits: &[Option<RayHit>], is_any_hit: bool) -> Self {
        let mut hash = Self::default();
        for hit in hits {
            match hit {
                None => hash.add(&[0]),
                Some(_) if is_any_hit => hash.add(&[1]),
                Some(hit) => {
                    hash.add(&hit.triangle.to_le_bytes());
                    hash.add(&hit.t.to_bits().to_le_bytes());
                    hash.add(&hit.u.to_bits().to_le_bytes());
                    hash.add(&hit.v.to_bits().to_le_bytes());
                }
            }
        }
        hash
    }
}

/// With the name of its method, so that no program takes it for a number.
impl fmt::Display for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fnv1a64:{:016x}", self.0)
    }
}

/// A text that is no hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected fnv1a64: and 16 hexadecimal digits")]
pub struct NotAHash;

impl FromStr for Hash {
    type Err = NotAHash;

    fn from_str(text: &str) -> Result<Self, NotAHash> {
        let is_hash = |digits: &&str| digits.len() == 16 && digits.bytes().all(|b| b.is_ascii_hexdigit());
        let digits = text.strip_prefix("fnv1a64:").filter(is_hash).ok_or(NotAHash)?;
        u64::from_str_radix(digits, 16).map(Self).map_err(|_| NotAHash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_the_published_ones() {
        // Test vectors of draft-eastlake-fnv: FNV-1a of "", "a" and "foobar".
        assert_eq!(Hash::default().to_string(), "fnv1a64:cbf29ce484222325");
        assert_eq!(Hash::of(b"a").to_string(), "fnv1a64:af63dc4c8601ec8c");
        assert_eq!(Hash::of(b"foobar").to_string(), "fnv1a64:85944171f73967e8");
        assert_eq!("fnv1a64:85944171f73967e8".parse(), Ok(Hash::of(b"foobar")));
        for wrong in
            ["", "85944171f73967e8", "fnv1a64:85944171f73967e", "fnv1a64:+5944171f73967e8", "fnv1a64:85944171f73967e8 "]
        {
            assert_eq!(wrong.parse::<Hash>(), Err(NotAHash), "{wrong}");
        }
    }

    #[test]
    fn hits_differ_by_a_bit_unless_any_hit_will_do() {
        let hit = RayHit { t: 1.0, u: 0.0, v: 0.0, triangle: 3 };
        let one = [Some(hit), None];
        for other in [
            [Some(RayHit { v: -0.0, ..hit }), None],
            [Some(RayHit { u: 0.5, ..hit }), None],
            [Some(RayHit { t: 1.0 + f64::EPSILON, ..hit }), None],
            [Some(RayHit { triangle: 4, ..hit }), None],
        ] {
            assert_ne!(Hash::of_hits(&one, false), Hash::of_hits(&other, false));
            assert_eq!(Hash::of_hits(&one, true), Hash::of_hits(&other, true));
        }
        assert_ne!(Hash::of_hits(&one, true), Hash::of_hits(&[None, Some(hit)], true));
    }
}
