//! A walk as lines, dots and filled triangles.

use super::{Color, Overlay, Palette, faded};
use crate::draw::scene3d::settings::Settings;
use crate::walk::{Outcome, Structure, WalkGeometry};

/// Most cells, nodes or tests drawn, the latest: otherwise a ray that tests all triangles of a large scene would hide
/// itself.
const MOST: usize = 20_000;

impl Overlay {
    pub(super) fn walk(&mut self, walk: &WalkGeometry, settings: &Settings, palette: &Palette) {
        if settings.visited {
            self.cells(walk, palette);
            self.nodes(walk, settings, palette);
        }
        if settings.tested {
            self.tested(walk, palette);
        }
        if settings.visited {
            self.current(walk, palette);
        }
        if settings.ray {
            self.ray(walk, palette);
        }
        if settings.crossings {
            self.crossings(walk, palette);
        }
        if let Some(hit) = walk.hit.filter(|_| settings.ray) {
            self.dot(hit.point, 9.0, palette.ray);
            self.dot(hit.point, 6.5, palette.hit);
        }
    }

    fn cells(&mut self, walk: &WalkGeometry, palette: &Palette) {
        let count = walk.cells.len();
        for (i, cell) in walk.cells.iter().enumerate().skip(count.saturating_sub(MOST)) {
            self.edges(&cell.bounds, 1.0, faded(palette.in_order(i, count), 0.85));
        }
    }

    fn nodes(&mut self, walk: &WalkGeometry, settings: &Settings, palette: &Palette) {
        let count = walk.nodes.len();
        for (i, node) in walk.nodes.iter().enumerate().skip(count.saturating_sub(MOST)) {
            if node.is_met {
                // Large boxes near the root are many lines with little information.
                let (widths, opacity) = if node.is_leaf { (1.4, 0.95) } else { (0.9, 0.5) };
                self.edges(&node.bounds, widths, faded(palette.in_order(i, count), opacity));
            } else if settings.missed_nodes {
                self.edges(&node.bounds, 0.7, faded(palette.missed, 0.45));
            }
        }
    }

    fn current(&mut self, walk: &WalkGeometry, palette: &Palette) {
        let current = match walk.structure {
            Structure::Grid => walk.current_cell().map(|cell| cell.bounds),
            Structure::Tree => walk.current_box,
            Structure::Nothing => None,
        };
        let Some(bounds) = current else { return };
        for face in bounds.faces() {
            self.triangle(face, faded(palette.current, 0.13));
        }
        self.edges(&bounds, 2.0, palette.current);
    }

    fn tested(&mut self, walk: &WalkGeometry, palette: &Palette) {
        let tested = walk.distinct_tested();
        let first = tested.len().saturating_sub(MOST);
        // Hits last, over the others.
        for is_hit in [false, true] {
            for test in tested[first..].iter().filter_map(|&i| walk.tested.get(i)) {
                if test.outcome.is_hit() != is_hit {
                    continue;
                }
                let color: Color = if is_hit { palette.hit } else { palette.missed };
                let nearest = walk.hit.is_some_and(|hit| hit.triangle == test.triangle);
                let (fill, widths, opacity) = match (test.outcome, nearest) {
                    (Outcome::Missed, _) => (0.10, 1.1, 0.7),
                    (_, false) => (0.10, 1.3, 0.8),
                    (_, true) => (0.34, 1.8, 1.0),
                };
                self.triangle(test.corners, faded(color, fill));
                let [a, b, c] = test.corners;
                for [from, to] in [[a, b], [b, c], [c, a]] {
                    self.line(from, to, widths, faded(color, opacity));
                }
            }
        }
    }

    fn ray(&mut self, walk: &WalkGeometry, palette: &Palette) {
        let (at, end) = (walk.current_point(), walk.point(walk.last_t()));
        self.line(at, end, 1.4, palette.dim_ray);
        self.line(walk.origin, at, 2.2, palette.ray);
        self.dot(walk.origin, 4.0, palette.ray);
        if walk.t > 0.0 {
            self.dot(at, 5.0, palette.ray);
        }
    }

    fn crossings(&mut self, walk: &WalkGeometry, palette: &Palette) {
        let first = walk.crossings.len().saturating_sub(MOST);
        for crossing in &walk.crossings[first..] {
            self.dot(crossing.point, 3.6, palette.axes[crossing.axis]);
        }
        let next = if walk.is_over { Vec::new() } else { walk.next_crossings() };
        let leaves = walk.current_cell().map(|cell| cell.exit_axis);
        for crossing in next {
            let is_next = leaves == Some(crossing.axis);
            let (widths, opacity) = if is_next { (5.5, 1.0) } else { (3.6, 0.6) };
            self.dot(crossing.point, widths, faded(palette.axes[crossing.axis], opacity));
        }
    }
}
