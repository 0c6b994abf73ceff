//! Which tiles of a frame differ from those of the last one, by signatures of the triangles that may cover them (Anglada
//! and others 2019, "Rendering Elimination").

use std::collections::BTreeSet;
use std::hash::{Hash as _, Hasher as _};

use egui::epaint::{Primitive, Vertex};
use egui::{ClippedPrimitive, Rect, TextureId, pos2};
use rustc_hash::FxHasher;

/// Pixels along a tile.
const SIDE: u32 = 32;

/// Most rectangles that are drawn one by one: each repeats the commands, and the vertices, of all that it meets.
const MOST_PARTS: usize = 8;

/// Signatures of the tiles of a frame.
pub(super) struct Tiles {
    columns: usize,
    rows: usize,
    signatures: Vec<u64>,
}

/// Tiles from the first up to, but without, the second of each pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Span {
    x: [usize; 2],
    y: [usize; 2],
}

impl Span {
    fn area(&self) -> usize {
        (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])
    }

    fn with(&self, other: &Self) -> Self {
        let both = |a: [usize; 2], b: [usize; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { x: both(self.x, other.x), y: both(self.y, other.y) }
    }
}

impl Tiles {
    /// Tiles of a frame that was never drawn.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| side.div_ceil(SIDE) as usize);
        Self { columns, rows, signatures: vec![0; columns * rows] }
    }

    /// Rectangles in points that cover all that differs from the last frame. `replaced`: textures whose contents do.
    pub(super) fn changed(
        &mut self,
        jobs: &[ClippedPrimitive],
        pixels_per_point: f32,
        replaced: &BTreeSet<TextureId>,
    ) -> Vec<Rect> {
        // Never those of a frame that was not drawn.
        let mut signatures = vec![1; self.signatures.len()];
        let mut changed = vec![false; self.signatures.len()];
        for ClippedPrimitive { clip_rect, primitive } in jobs {
            let mut head = FxHasher::default();
            head.write(bytemuck::bytes_of(&[clip_rect.min.x, clip_rect.min.y, clip_rect.max.x, clip_rect.max.y]));
            let mut add = |rect: Rect, signature: u64, is_changed: bool| {
                for tile in self.tiles(self.span(rect.intersect(*clip_rect) * pixels_per_point)) {
                    let mut hasher = FxHasher::default();
                    hasher.write_u64(signatures[tile]);
                    hasher.write_u64(signature);
                    signatures[tile] = hasher.finish();
                    changed[tile] |= is_changed;
                }
            };
            match primitive {
                Primitive::Mesh(mesh) => {
                    mesh.texture_id.hash(&mut head);
                    let is_replaced = replaced.contains(&mesh.texture_id);
                    for corners in mesh.indices.chunks_exact(3) {
                        let Some(corners) = vertices(&mesh.vertices, corners) else { continue };
                        let mut triangle = head.clone();
                        triangle.write(bytemuck::bytes_of(&corners));
                        add(Rect::from_points(&corners.map(|corner| corner.pos)), triangle.finish(), is_replaced);
                    }
                }
                // Nobody knows what it draws.
                Primitive::Callback(callback) => add(callback.rect, head.finish(), true),
            }
        }
        for (changed, (now, last)) in changed.iter_mut().zip(signatures.iter().zip(&self.signatures)) {
            *changed |= now != last;
        }
        self.signatures = signatures;
        let scale = SIDE as f32 / pixels_per_point;
        let point = |x: usize, y: usize| pos2(x as f32 * scale, y as f32 * scale);
        let spans = fewer(self.spans(&changed));
        spans.iter().map(|s| Rect::from_min_max(point(s.x[0], s.y[0]), point(s.x[1], s.y[1]))).collect()
    }

    /// The tiles that a rectangle in pixels touches, and a pixel around it: clips are rounded to pixels.
    fn span(&self, pixels: Rect) -> Span {
        if pixels.is_negative() || pixels.any_nan() {
            return Span { x: [0; 2], y: [0; 2] };
        }
        // Casts saturate, also from below 0.
        let along = |from: f32, to: f32, count: usize| {
            let tile = |at: f32| ((at / SIDE as f32).floor() as usize).min(count);
            [tile(from - 1.0), (tile(to + 1.0) + 1).min(count)]
        };
        Span { x: along(pixels.min.x, pixels.max.x, self.columns), y: along(pixels.min.y, pixels.max.y, self.rows) }
    }

    fn tiles(&self, span: Span) -> impl Iterator<Item = usize> + use<> {
        let columns = self.columns;
        (span.y[0]..span.y[1]).flat_map(move |y| (span.x[0]..span.x[1]).map(move |x| y * columns + x))
    }

    /// Runs of changed tiles within rows, each joined with an equal one above.
    fn spans(&self, changed: &[bool]) -> Vec<Span> {
        let mut spans: Vec<Span> = Vec::new();
        for (y, row) in changed.chunks(self.columns.max(1)).enumerate() {
            let mut x = 0;
            for run in row.chunk_by(|a, b| a == b) {
                let run_x = [x, x + run.len()];
                x += run.len();
                if !run[0] {
                    continue;
                }
                match spans.iter_mut().find(|span| span.y[1] == y && span.x == run_x) {
                    Some(above) => above.y[1] = y + 1,
                    None => spans.push(Span { x: run_x, y: [y, y + 1] }),
                }
            }
        }
        spans
    }
}

/// Joins those that cost the least area until there are few.
fn fewer(mut spans: Vec<Span>) -> Vec<Span> {
    while spans.len() > MOST_PARTS {
        let mut best = (usize::MAX, 0, 1);
        for (i, a) in spans.iter().enumerate() {
            for (j, b) in spans.iter().enumerate().skip(i + 1) {
                let added = a.with(b).area().saturating_sub(a.area() + b.area());
                best = best.min((added, i, j));
            }
        }
        let (_, i, j) = best;
        let other = spans.remove(j);
        spans[i] = spans[i].with(&other);
    }
    spans
}

fn vertices(all: &[Vertex], corners: &[u32]) -> Option<[Vertex; 3]> {
    let corner = |i: usize| all.get(*corners.get(i)? as usize).copied();
    Some([corner(0)?, corner(1)?, corner(2)?])
}

#[cfg(test)]
mod tests {
    use egui::epaint::{Mesh, WHITE_UV};
    use egui::{Color32, Pos2};

    use super::*;

    fn rect(min: [f32; 2], max: [f32; 2]) -> Rect {
        Rect::from_min_max(Pos2::from(min), Pos2::from(max))
    }

    fn job(rect: Rect, clip_rect: Rect, color: Color32) -> ClippedPrimitive {
        let mut mesh = Mesh::default();
        mesh.add_rect_with_uv(rect, Rect::from_min_max(WHITE_UV, WHITE_UV), color);
        ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) }
    }

    #[test]
    fn only_tiles_under_what_differs_are_drawn_again() {
        let mut tiles = Tiles::new([320, 160]);
        let all = rect([0.0; 2], [320.0, 160.0]);
        let background = || job(all, all, Color32::BLACK);
        let small = |x: f32, color| job(rect([x, 40.0], [x + 10.0, 50.0]), all, color);
        let none = BTreeSet::new();
        let mut changed = |jobs: &[ClippedPrimitive], scale: f32| tiles.changed(jobs, scale, &none);

        assert_eq!(changed(&[background()], 1.0), [all], "the first frame");
        assert_eq!(changed(&[background()], 1.0), [], "the same again");
        assert_eq!(changed(&[background(), small(70.0, Color32::RED)], 1.0), [rect([64.0, 32.0], [96.0, 64.0])]);
        assert_eq!(changed(&[background(), small(70.0, Color32::BLUE)], 1.0), [rect([64.0, 32.0], [96.0, 64.0])]);
        // Where it was and where it is, with the pixel around it.
        assert_eq!(
            changed(&[background(), small(150.0, Color32::BLUE)], 1.0),
            [rect([64.0, 32.0], [96.0, 64.0]), rect([128.0, 32.0], [192.0, 64.0]),]
        );
        let clipped = job(all, rect([300.0, 100.0], [310.0, 110.0]), Color32::RED);
        let two = [background(), small(150.0, Color32::BLUE), clipped];
        assert_eq!(changed(&two, 1.0), [rect([288.0, 96.0], [320.0, 128.0])], "no more than its clip");
        let [_, moved, _] = two;
        let order = |a, b| [background(), job(rect([70.0, 40.0], [80.0, 50.0]), all, a), small(70.0, b), moved.clone()];
        changed(&order(Color32::RED, Color32::BLUE), 1.0);
        let swapped = changed(&order(Color32::BLUE, Color32::RED), 1.0);
        assert_eq!(swapped, [rect([64.0, 32.0], [96.0, 64.0])], "the order counts");
    }

    #[test]
    fn a_replaced_texture_is_a_difference_and_points_may_be_several_pixels() {
        let mut tiles = Tiles::new([320, 160]);
        let jobs = [job(rect([40.0, 40.0], [60.0, 60.0]), rect([0.0; 2], [160.0, 80.0]), Color32::RED)];
        let (none, font) = (BTreeSet::new(), BTreeSet::from([TextureId::default()]));
        tiles.changed(&jobs, 2.0, &none);
        assert_eq!(tiles.changed(&jobs, 2.0, &none), []);
        // From pixel 79 to 121.
        assert_eq!(tiles.changed(&jobs, 2.0, &font), [rect([32.0, 32.0], [64.0, 64.0])]);
        assert_eq!(tiles.changed(&jobs, 2.0, &none), [], "once is enough");
    }

    #[test]
    fn triangles_anywhere_and_of_any_numbers_do_no_harm() {
        let mut tiles = Tiles::new([64, 64]);
        let all = rect([0.0; 2], [64.0; 2]);
        let far = [
            rect([-1e9, -1e9], [-5.0, -5.0]),
            rect([1e9, 1e9], [2e9, 2e9]),
            rect([f32::NAN, 0.0], [1.0, 1.0]),
            rect([f32::NEG_INFINITY; 2], [f32::INFINITY; 2]),
        ];
        tiles.changed(&far.map(|far| job(far, all, Color32::RED)), 1.0, &BTreeSet::new());
        let mut tiles = Tiles::new([0, 0]);
        assert_eq!(tiles.changed(&[job(all, all, Color32::RED)], 1.0, &BTreeSet::new()), []);
    }

    #[test]
    fn many_parts_are_joined_to_few_that_cover_them() {
        let spans: Vec<Span> = (0..40).map(|i| Span { x: [3 * i, 3 * i + 1], y: [i, i + 1] }).collect();
        let few = fewer(spans.clone());
        assert_eq!(few.len(), MOST_PARTS);
        let is_within = |a: &Span, b: &Span| a.with(b) == *b;
        assert!(spans.iter().all(|span| few.iter().any(|part| is_within(span, part))));
    }
}
