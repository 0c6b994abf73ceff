//! Triangles that are much farther away than the others.
//!
//! A grid over a small object and a huge plane below it has no cell small enough for the object, and its cells grow by
//! more than the object is large: growth follows the largest distance. A few such triangles are therefore set aside, in
//! a list of their own that every ray tests first, and the grid is laid out for the others alone.

/// Most triangles that are set aside, since every ray tests them.
const MOST: usize = 16;

/// How much farther away than the others the farthest must be. The virtual grid's cells are 2¹⁵ along an axis: up to
/// here, there remain some hundreds for the others.
const FAR: f32 = 64.0;

/// Corners from which the middle is computed.
const SAMPLED: usize = 1 << 12;

/// The triangles to be set aside, ascending: those that reach more than twice as far from the middle of all as the others
/// do, if the farthest reaches [`FAR`] times as far.
pub(super) fn far_away(vertices: &[f32]) -> Vec<u32> {
    let triangles = vertices.len() / 9;
    if triangles <= MOST {
        return Vec::new();
    }
    let middle = [0, 1, 2].map(|axis| median_along(vertices, axis));
    let reach = |corners: &[f32]| {
        corners.iter().zip(middle.iter().cycle()).fold(0.0, |far: f32, (v, middle)| far.max((v - middle).abs()))
    };
    let reaches: Vec<f32> = vertices.chunks_exact(9).map(reach).collect();
    let mut sorted = reaches.clone();
    let (farther, &mut others, _) = sorted.select_nth_unstable_by(MOST, |a, b| b.total_cmp(a));
    let farthest = farther.iter().copied().fold(0.0, f32::max);
    if farthest <= FAR * others {
        return Vec::new();
    }
    (0..triangles as u32).filter(|&triangle| reaches[triangle as usize] > 2.0 * others).collect()
}

/// The median of some of the triangles' first corners.
fn median_along(vertices: &[f32], axis: usize) -> f32 {
    let every = (vertices.len() / 9).div_ceil(SAMPLED);
    let mut values: Vec<f32> = vertices.chunks_exact(9).step_by(every).map(|corners| corners[axis]).collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// The corners of all triangles but those set aside.
pub(super) fn without(vertices: &[f32], aside: &[u32]) -> Vec<f32> {
    let others = (0..).zip(vertices.chunks_exact(9)).filter(|(id, _)| aside.binary_search(id).is_err());
    others.flat_map(|(_, corners)| corners).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::irregular::{IrregularCell, IrregularData, LAST_ITEM, Layout, OUTSIDE, cell_entry};

    /// Small triangles in a cube of side 2, and one for each of `corners` far away.
    fn cloud(small: usize, corners: &[f32]) -> Vec<f32> {
        let at = |i: usize, k: usize| ((i * k) % 101) as f32 / 50.0 - 1.0;
        let mut vertices: Vec<f32> = (0..small)
            .flat_map(|i| {
                let [x, y, z] = [at(i, 37), at(i, 59), at(i, 83)];
                [x, y, z, x + 0.02, y, z, x, y + 0.02, z]
            })
            .collect();
        for (i, &far) in corners.iter().enumerate() {
            let place = 9 * (2 * i + 1).min(vertices.len() / 9);
            vertices.splice(place..place, [far, 0.0, 0.0, far, 1.0, 0.0, 0.0, 0.0, 1.0]);
        }
        vertices
    }

    #[test]
    fn few_triangles_much_farther_away_are_set_aside() {
        assert_eq!(far_away(&cloud(200, &[1000.0])), [1]);
        assert_eq!(far_away(&cloud(200, &[-1000.0, 90.0])), [1, 3]);
        // A grid resolves scenes as large as this.
        assert!(far_away(&cloud(200, &[50.0])).is_empty());
        // A ray would test too many.
        assert_eq!(far_away(&cloud(200, &[1000.0; 16])).len(), 16);
        assert!(far_away(&cloud(200, &[1000.0; 17])).is_empty());
        for few in [0, 1, 15] {
            assert!(far_away(&cloud(few, &[1000.0])).is_empty());
        }
        // All others at one point.
        assert_eq!(far_away(&[&[0.5; 9 * 16][..], &[7.0; 9]].concat()), [16]);
    }

    #[test]
    fn the_others_keep_their_ids() {
        let vertices = cloud(20, &[1000.0, 2000.0]);
        let aside = far_away(&vertices);
        assert_eq!(aside, [1, 3]);
        let others = without(&vertices, &aside);
        let layout = Layout::below(&others, 1.0, true, [1; 3]);
        let items: Vec<u32> = (0..20).map(|id| if id == 19 { id | LAST_ITEM } else { id }).collect();
        let cell = IrregularCell { low: [0; 3], high: [1; 3], first: 0 };
        let inside = IrregularData::of_buffers(&layout, vec![cell_entry(0)], vec![cell], items, vec![20]);
        let data = inside.with_aside(&aside);
        assert_eq!(data.list(OUTSIDE).collect::<Vec<_>>(), aside);
        let listed: Vec<u32> = data.list(data.find([0; 3])).collect();
        assert_eq!(listed, [&[0, 2][..], &(4..22).collect::<Vec<_>>()].concat());
        for (corners, id) in others.chunks_exact(9).zip(listed) {
            assert_eq!(corners, &vertices[9 * id as usize..][..9]);
        }
    }
}
