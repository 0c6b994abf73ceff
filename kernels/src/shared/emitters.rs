//! What gives light, in the format of `emitters.wgsl`.

use bytemuck::{Pod, Zeroable};

/// The mark of a light among emitters.
pub(crate) const PUNCTUAL: u32 = 1 << 31;
/// How bright the eye sees linear red, green and blue (ITU-R BT.709).
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// An entry of the buffer `emitters`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Emitter {
    /// The row stands for itself below this number, else for another.
    pub keep: f32,
    /// The other row.
    pub other: u32,
    /// A triangle, or a light, marked by the highest bit.
    pub id: u32,
    /// The probability that it is picked.
    pub chance: f32,
}

/// The uniform `emission`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Emission {
    /// Number of emitters.
    pub count: u32,
    /// The pdf of a point of a triangle that glows, by area in traced units, divided by the luminance of its sides.
    pub per_luminance: f32,
}

/// Rows with these ids and weights, none of which is negative: by the alias method of Walker (1974), in the order of Vose
/// (1991). Empty if all weights are 0.
#[must_use]
pub(crate) fn table(ids: &[u32], weights: &[f64]) -> Vec<Emitter> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let count = ids.len() as f64;
    let mut shares: Vec<f64> = weights.iter().map(|weight| weight * count / total).collect();
    let row = |(&id, &weight): (&u32, &f64)| Emitter { keep: 1.0, other: 0, id, chance: (weight / total) as f32 };
    let mut rows: Vec<Emitter> = ids.iter().zip(weights).map(row).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..ids.len()).partition(|&i| shares[i] < 1.0);
    while let (Some(&less), Some(&more)) = (small.last(), large.last()) {
        small.pop();
        rows[less].keep = shares[less] as f32;
        rows[less].other = more as u32;
        shares[more] -= 1.0 - shares[less];
        if shares[more] < 1.0 {
            large.pop();
            small.push(more);
        }
    }
    for (i, row) in rows.iter_mut().enumerate() {
        if row.keep == 1.0 {
            row.other = i as u32;
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_emitter_is_picked_by_its_weight() {
        let weights = [3.0, 0.0, 0.5, 10.0, 1e-9, 2.5];
        let rows = table(&[10, 11, 12, 13, 14, 15], &weights);
        let mut chance = [0.0; 6];
        for (i, row) in rows.iter().enumerate() {
            chance[i] += f64::from(row.keep) / 6.0;
            chance[row.other as usize] += (1.0 - f64::from(row.keep)) / 6.0;
            assert_eq!(row.id, 10 + i as u32);
        }
        for (found, weight) in chance.into_iter().zip(weights) {
            // keep is rounded to f32.
            assert!((found - weight / 16.000_000_001).abs() < 1e-7, "{chance:?}");
        }
        assert!(table(&[1, 2], &[0.0, 0.0]).is_empty() && table(&[], &[]).is_empty());
    }
}
