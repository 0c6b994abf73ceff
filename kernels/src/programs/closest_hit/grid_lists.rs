//! Twin of `grid_lists.wgsl`: what follows when the list of a cell ends.

use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, SHADE, TRAV};
use crate::tables::state::Tag;

/// The state after a cell's list has ended; `exit` is the t at which the ray leaves the cell.
pub fn list_ended<R: Real>(features: &Features, tag: Tag, nearest_t: R, exit: R) -> Tag {
    let is_hit = tag == ISECT_HIT;
    match (features.in_cell, features.any_hit) {
        (false, false) if is_hit && nearest_t <= exit => SHADE,
        // Nothing was hit, and hits behind the ray's end do not count.
        (false, true) if nearest_t <= exit => BACKGROUND,
        (true, _) if is_hit => SHADE,
        _ => TRAV,
    }
}
