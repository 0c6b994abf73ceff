//! Where the scene's origin lies in the file's coordinates.

use crate::offset_for;
use glam::DVec3;

/// The offset for vertices with these bounds. Where it is not 0 and all shapes share a translation that brings them near
/// the origin, that is the offset: then vertices keep the file's bits, and what was written with an offset is read with
/// the same.
pub(super) fn choose([min, max]: [DVec3; 2], translation: Option<DVec3>) -> DVec3 {
    let of_box = offset_for(min, max);
    let Some(translation) = translation else { return of_box };
    // The box of rounded vertices differs by up to 2^-24 of its extent from that of the vertices for which an offset was
    // chosen before.
    let rounding = DVec3::splat((max - min).max_element() / f64::from(1 << 21));
    let is_far = offset_for(min + rounding, max - rounding).cmpne(DVec3::ZERO);
    let shared = DVec3::select(is_far, translation, DVec3::ZERO);
    if shared.is_finite() && offset_for(min - shared, max - shared) == DVec3::ZERO { shared } else { of_box }
}
