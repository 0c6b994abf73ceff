//! Rectangles of a picture.

use super::picture::Point;

/// A rectangle of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Its left side.
    pub left: f64,
    /// Its right side.
    pub right: f64,
    /// Its upper side.
    pub top: f64,
    /// Its lower side.
    pub bottom: f64,
}

impl Frame {
    /// Whether the two have more than an edge in common.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
        self.left < other.right && self.right > other.left && self.top < other.bottom && self.bottom > other.top
    }

    /// Whether the other lies within it.
    #[must_use]
    pub fn holds(self, other: Self) -> bool {
        self.left <= other.left && other.right <= self.right && self.top <= other.top && other.bottom <= self.bottom
    }

    /// Around a point.
    pub(super) fn around((x, y): Point, half: f64) -> Self {
        Self { left: x - half, right: x + half, top: y - half, bottom: y + half }
    }

    /// Around points.
    pub(super) fn along(points: &[Point], half: f64) -> Self {
        let none = Self { left: f64::MAX, right: f64::MIN, top: f64::MAX, bottom: f64::MIN };
        let all = points.iter().fold(none, |frame, &(x, y)| Self {
            left: frame.left.min(x),
            right: frame.right.max(x),
            top: frame.top.min(y),
            bottom: frame.bottom.max(y),
        });
        all.grown(half)
    }

    pub(super) fn grown(self, by: f64) -> Self {
        Self { left: self.left - by, right: self.right + by, top: self.top - by, bottom: self.bottom + by }
    }

    pub(super) fn has(self, (x, y): Point) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    /// The point of it that is nearest to another.
    pub(super) fn nearest(self, (x, y): Point) -> Point {
        (x.clamp(self.left, self.right.max(self.left)), y.clamp(self.top, self.bottom.max(self.top)))
    }

    pub(super) fn corners(self) -> [Point; 4] {
        let Self { left, right, top, bottom } = self;
        [(left, top), (right, top), (right, bottom), (left, bottom)]
    }
}
