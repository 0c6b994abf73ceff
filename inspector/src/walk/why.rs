//! Why the test of a triangle had its outcome, in two or three words.

use raystep_kernels::export::trace::RayState;
use raystep_kernels::scene_data::SceneData;

/// Why a test did not become the nearest hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// It is the nearest hit.
    Accepted,
    /// The ray lies in the triangle's plane.
    EdgeOn,
    /// The ray meets the plane beside the triangle: this barycentric weight is negative there.
    Outside(&'static str),
    /// The ray meets the plane behind its origin.
    Behind,
    /// The hit lies before the ray's first t.
    BeforeStart,
    /// The hit lies beyond the ray's last t.
    BeyondEnd,
    /// The same hit was found before.
    Again,
    /// A nearer hit is known.
    NotNearer,
    /// The hit lies in another cell.
    OtherCell,
    /// The device's own rounding decided.
    Rounding,
}

impl Why {
    /// For a ray that misses: weights and t where it meets the plane.
    pub(super) fn missed([u, v]: [f32; 2], t: f32) -> Self {
        if !(u.is_finite() && v.is_finite()) {
            return Self::EdgeOn;
        }
        let weights = [("u", u), ("v", v), ("1 - u - v", 1.0 - u - v)];
        let (name, smallest) = weights.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(weights[0]);
        match () {
            () if smallest < 0.0 => Self::Outside(name),
            () if t <= 0.0 => Self::Behind,
            () => Self::Rounding,
        }
    }

    /// For a hit at `t` that was not accepted.
    pub(super) fn refused(data: &SceneData, before: Option<&RayState>, triangle: u32, t: f32) -> Self {
        let Some(before) = before else { return Self::Rounding };
        if before.interval.is_some_and(|[first, _]| t <= first) {
            return Self::BeforeStart;
        }
        match before.t.or(before.interval.map(|[_, last]| last)) {
            Some(_) if before.triangle == Some(triangle) => Self::Again,
            Some(end) if t >= end && before.triangle.is_none() => Self::BeyondEnd,
            Some(nearest) if t >= nearest => Self::NotNearer,
            _ if data.features.in_cell => Self::OtherCell,
            _ => Self::Rounding,
        }
    }
}

impl std::fmt::Display for Why {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Accepted => write!(f, "accepted"),
            Self::EdgeOn => write!(f, "seen edge-on"),
            Self::Outside(weight) => write!(f, "{weight} < 0"),
            Self::Behind => write!(f, "behind the origin"),
            Self::BeforeStart => write!(f, "before the ray's first t"),
            Self::BeyondEnd => write!(f, "beyond the ray's last t"),
            Self::Again => write!(f, "the same hit again"),
            Self::NotNearer => write!(f, "not nearer"),
            Self::OtherCell => write!(f, "outside of this cell"),
            Self::Rounding => write!(f, "by less than a rounding"),
        }
    }
}
