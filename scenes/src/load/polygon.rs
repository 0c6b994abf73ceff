//! Cuts polygons of more than three corners into triangles.
//!
//! A polygon whose fan around its first corner lies within it keeps that fan: every convex polygon does. Whether it
//! does is decided up to the rounding of the corners to f32. If the polygon has few corners, the fan around another one
//! may do. Any other polygon is projected to its plane and becomes the faces of a constrained Delaunay triangulation
//! around which its edges wind. Holes that are joined to the outline by a doubled edge, corners on an edge and corners
//! that touch are found exactly, since all predicates are exact, and no corner is lost, so that neighbours still meet in
//! it.
//!
//! The triangulation is that of `spade`. The smaller `earcut` 0.4.12 was tried: it drops corners on straight edges, and
//! its time is quadratic where many corners share a cell of its curve. A spiral of 10,000 corners and one far outside
//! took it 2.3 s, where this takes 10 ms; a star of 100,000 corners 3.2 s, here 0.5 s. Corners and edges are inserted in
//! random order, which makes the expected time close to linear for every polygon. `spade`'s own bulk loader is quadratic
//! for corners on one line, and its splitting of edges that cross panics for some.

use super::budget::Budget;
use crate::generate::mix;
use glam::{DVec2, DVec3};
use spade::handles::{FixedDirectedEdgeHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, HierarchyHintGenerator, Point2, Triangulation as _};
use std::collections::HashMap;

/// A polygon is not planar if its corners are further apart along its normal than this part of its size.
const PLANAR: f64 = 0.01;
/// Up to this part of its size they are in a plane, for all that rounding lets one see.
const EXACTLY_PLANAR: f64 = 1e-6;
/// Heights below this part of the largest coordinate are rounding: four times half a unit in the last place of f32.
const ROUNDING: f64 = 1.0 / (1 << 22) as f64;
/// Up to so many corners, the fan around each is tried.
const FEW_FANS: usize = 16;
/// Bytes that a triangulation takes for each corner: 380 were measured with 100,000 corners.
const BYTES_PER_CORNER: u64 = 512;
/// Up to so many corners, each triangle of a polygon that crosses itself is compared with all edges.
const FEW: usize = 512;

type Triangulation = ConstrainedDelaunayTriangulation<Point2<f64>, (), (), (), HierarchyHintGenerator<f64>>;

/// Cuts polygons one after the other, and counts those that are not as polygons should be.
#[derive(Default)]
pub(super) struct Polygons {
    /// Polygons with edges that cross, or without an area.
    pub(super) improper: usize,
    /// Polygons with corners off their plane.
    pub(super) not_planar: usize,
    /// The triangles of the last polygon.
    triangles: Vec<[u32; 3]>,
}

/// How a polygon becomes triangles.
enum Shape {
    /// By the fan around this corner.
    Fan(usize),
    Cut(Cut),
    /// By no way that is known: it has no area, or too many edges that cross.
    Unknown,
}

/// The corners of a polygon.
struct Outline<'a> {
    corners: &'a [DVec3],
    /// The largest distance of a corner from the first.
    size: f64,
    /// What rounding may have done to a corner.
    rounding: f64,
}

impl Polygons {
    /// The triangles of a polygon of at least three finite corners, as indices of its corners, with its winding.
    pub(super) fn triangles(&mut self, corners: &[DVec3], budget: &Budget) -> &[[u32; 3]] {
        self.triangles.clear();
        let fan = match self.cut(&Outline::new(corners), budget) {
            Shape::Fan(first) => first as u32,
            Shape::Cut(cut) => {
                self.triangles = cut.triangles;
                return &self.triangles;
            }
            Shape::Unknown => {
                self.improper += 1;
                0
            }
        };
        let count = corners.len() as u64;
        let corner = |i: u64| ((u64::from(fan) + i) % count) as u32;
        self.triangles.extend((2..count).map(|i| [corner(0), corner(i - 1), corner(i)]));
        &self.triangles
    }

    fn cut(&mut self, outline: &Outline<'_>, budget: &Budget) -> Shape {
        let Some(normal) = outline.normal() else { return Shape::Unknown };
        let height = outline.height(normal);
        let is_planar = height <= PLANAR * outline.size + outline.rounding;
        self.not_planar += usize::from(!is_planar);
        let firsts = if outline.corners.len() > FEW_FANS { 1 } else { outline.corners.len() };
        if let Some(first) = (0..firsts).find(|&first| outline.is_fan(first, normal)) {
            return Shape::Fan(first);
        }
        // Every quadrilateral that does not cross itself is a fan.
        if outline.corners.len() == 4 {
            return Shape::Unknown;
        }
        // What is given back here again and again is bounded by the corners, which are not.
        let bytes = BYTES_PER_CORNER.saturating_mul(outline.corners.len() as u64);
        let cut = budget.hold(bytes, "a face", || Ok(Cut::new(&outline.projected(normal, height))));
        match cut.unwrap_or_default() {
            // Edges that cross only when they are projected are all part of the fan, so that neighbours still meet.
            Some(cut) if is_planar || !cut.crosses => {
                self.improper += usize::from(cut.crosses);
                Shape::Cut(cut)
            }
            _ => Shape::Unknown,
        }
    }
}

impl<'a> Outline<'a> {
    fn new(corners: &'a [DVec3]) -> Self {
        let first = corners.first().copied().unwrap_or_default();
        let largest = corners.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
        let size = corners.iter().map(|corner| corner.distance(first)).fold(0.0, f64::max);
        Self { corners, size, rounding: ROUNDING * largest }
    }

    /// All corners relative to this one, which comes first.
    fn sides(&self, first: usize) -> impl Iterator<Item = DVec3> {
        let (before, after) = self.corners.split_at_checked(first).unwrap_or_default();
        let origin = after.first().copied().unwrap_or_default();
        after.iter().chain(before).map(move |&corner| corner - origin)
    }

    /// The fan around this corner: pairs of sides.
    fn fan(&self, first: usize) -> impl Iterator<Item = (DVec3, DVec3)> {
        self.sides(first).zip(self.sides(first).skip(1))
    }

    /// The unit vector along the sum of the fan's triangles (Newell's normal); `None` if they have no area. Where they
    /// nearly cancel each other, the plane of the largest is better known than that of the sum.
    fn normal(&self) -> Option<DVec3> {
        let (mut sum, mut total, mut largest) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for area in self.fan(0).map(|(a, b)| a.cross(b)) {
            sum += area;
            total += area.length();
            if area.length_squared() > largest.length_squared() {
                largest = area;
            }
        }
        if largest.length() <= self.rounding * self.size {
            return None;
        }
        let is_sure = sum.length() > 1e-3 * total;
        if is_sure { sum } else { largest * sum.dot(largest).signum() }.try_normalize()
    }

    /// How far the corners are apart along the normal.
    fn height(&self, normal: DVec3) -> f64 {
        let heights = self.sides(0).map(|side| side.dot(normal));
        let (min, max) = heights.fold((0.0_f64, 0.0_f64), |(min, max), height| (min.min(height), max.max(height)));
        max - min
    }

    /// Whether no triangle of the fan around this corner is turned over, except by rounding.
    fn is_fan(&self, first: usize, normal: DVec3) -> bool {
        self.fan(first).all(|(a, b)| a.cross(b).dot(normal) >= -self.rounding * a.length().max(b.length()))
    }

    /// The corners in the polygon's plane, where it winds to the left, with coordinates of at most 2. Exactly planar
    /// polygons lose a coordinate, so that corners on a line stay on a line.
    fn projected(&self, normal: DVec3, height: f64) -> Vec<DVec2> {
        let (u, v) = if height <= EXACTLY_PLANAR * self.size + self.rounding {
            let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
            let axes = [(y, z), (z, x), (x, y)];
            let axis = normal.abs().max_position();
            let (u, v) = axes.get(axis).copied().unwrap_or((x, y));
            if normal.to_array().get(axis).is_some_and(|&n| n < 0.0) { (v, u) } else { (u, v) }
        } else {
            let u = normal.any_orthonormal_vector();
            (u, normal.cross(u))
        };
        // A power of two, so that this is exact.
        let scale = self.size.log2().floor().exp2();
        // The triangulation takes no smaller numbers; these are zeros next to the polygon's size.
        let flushed = |v: f64| if v.abs() < 1e-40 { 0.0 } else { v };
        self.sides(0).map(|side| DVec2::new(flushed(side.dot(u) / scale), flushed(side.dot(v) / scale))).collect()
    }
}

/// The triangles of a polygon in the plane.
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// Whether some edges cross others: the triangles are then roughly those of the polygon.
    crosses: bool,
}

impl Cut {
    /// `None` if the polygon has too many edges that cross or lie on each other.
    fn new(corners: &[DVec2]) -> Option<Self> {
        let count = corners.len();
        let seed = corners.iter().flat_map(|c| c.to_array()).fold(0, |seed, v| mix(seed ^ v.to_bits()));
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.sort_unstable_by_key(|&corner| mix(seed ^ u64::from(corner)));
        let mut plane = Plane::new(corners, &order)?;
        let mut crosses = false;
        let mut most_parts = 4 * count + 64;
        for &corner in &order {
            match plane.edge(corner as usize, (corner as usize + 1) % count) {
                Some(parts) => most_parts = most_parts.checked_sub(parts)?,
                None if count > FEW => return None,
                None => crosses = true,
            }
        }
        let triangles = if crosses { plane.roughly_inside(corners) } else { plane.inside() };
        (!triangles.is_empty()).then_some(Self { triangles, crosses })
    }
}

/// A triangulation of the corners of a polygon.
struct Plane {
    triangulation: Triangulation,
    /// The vertex of each corner; corners at the same place share one.
    vertices: Vec<FixedVertexHandle>,
    /// The first corner of each vertex.
    corners: Vec<u32>,
    /// How many edges of the polygon run along each directed edge.
    edges: Vec<i32>,
}

impl Plane {
    fn new(corners: &[DVec2], order: &[u32]) -> Option<Self> {
        let mut plane = Self {
            triangulation: Triangulation::new(),
            vertices: vec![FixedVertexHandle::from_index(0); corners.len()],
            corners: Vec::new(),
            edges: Vec::new(),
        };
        let mut known = HashMap::new();
        // While all vertices are on a line, each insertion visits all others.
        for corner in first_triangle(corners).into_iter().chain(order.iter().copied()) {
            let at = corners.get(corner as usize)? + DVec2::ZERO;
            let vertex = match known.get(&at.to_array().map(f64::to_bits)) {
                Some(&vertex) => vertex,
                None => {
                    let vertex = plane.triangulation.insert(Point2::new(at.x, at.y)).ok()?;
                    known.insert(at.to_array().map(f64::to_bits), vertex);
                    plane.corners.push(corner);
                    vertex
                }
            };
            *plane.vertices.get_mut(corner as usize)? = vertex;
        }
        plane.edges = vec![0; plane.triangulation.num_directed_edges()];
        Some(plane)
    }

    /// Adds an edge of the polygon; returns the number of its parts, or `None` if it crosses another.
    fn edge(&mut self, from: usize, to: usize) -> Option<usize> {
        let (from, to) = (*self.vertices.get(from)?, *self.vertices.get(to)?);
        if from == to {
            return Some(0);
        }
        let parts = self.triangulation.try_add_constraint(from, to);
        for part in &parts {
            *self.edges.get_mut(part.index())? += 1;
        }
        (!parts.is_empty()).then_some(parts.len())
    }

    /// The faces around which the polygon winds: from the outside, where it does not, its winding number changes by
    /// one at each of its edges.
    fn inside(&self) -> Vec<[u32; 3]> {
        let edges_of = |edge: FixedDirectedEdgeHandle| self.edges.get(edge.index()).copied().unwrap_or_default();
        let mut windings = vec![None; self.triangulation.num_all_faces()];
        // Edges to cross, with the winding number on their left.
        let mut ahead: Vec<_> = self.triangulation.convex_hull().map(|edge| (edge.fix(), 0)).collect();
        while let Some((edge, winding)) = ahead.pop() {
            let back = edge.rev();
            let winding = winding - edges_of(edge) + edges_of(back);
            let Some(face) = self.triangulation.directed_edge(back).face().as_inner() else { continue };
            if let Some(known @ None) = windings.get_mut(face.fix().index()) {
                *known = Some(winding);
                ahead.extend(face.adjacent_edges().map(|edge| (edge.fix(), winding)));
            }
        }
        self.faces(|index, _| windings.get(index).is_some_and(|winding| winding.is_some_and(|w| w != 0)))
    }

    /// The faces in whose centres the polygon winds.
    fn roughly_inside(&self, corners: &[DVec2]) -> Vec<[u32; 3]> {
        self.faces(|_, face| {
            let [a, b, c] = face.map(|corner| corners.get(corner as usize).copied().unwrap_or_default());
            winding(corners, (a + b + c) / 3.0) != 0
        })
    }

    fn faces(&self, is_kept: impl Fn(usize, [u32; 3]) -> bool) -> Vec<[u32; 3]> {
        let corner = |vertex: FixedVertexHandle| self.corners.get(vertex.index()).copied().unwrap_or_default();
        let faces = self.triangulation.inner_faces();
        faces
            .map(|face| (face.fix().index(), face.vertices().map(|vertex| corner(vertex.fix()))))
            .filter(|&(index, face)| is_kept(index, face))
            .map(|(_, face)| face)
            .collect()
    }
}

/// Three corners that are not on a line: the first, and the next two around which its fan is largest.
fn first_triangle(corners: &[DVec2]) -> [u32; 3] {
    let area = |i: usize| match (corners.get(i), corners.get(i + 1)) {
        (Some(a), Some(b)) => a.perp_dot(*b).abs(),
        _ => 0.0,
    };
    let largest = (1..corners.len()).max_by(|&i, &j| area(i).total_cmp(&area(j))).unwrap_or_default() as u32;
    [0, largest, largest + 1]
}

/// How often a polygon winds around a point.
fn winding(corners: &[DVec2], point: DVec2) -> i32 {
    let next = corners.iter().cycle().skip(1);
    let crossings = corners.iter().zip(next).map(|(&from, &to)| {
        let is_left = (to - from).perp_dot(point - from) > 0.0;
        match (from.y <= point.y, to.y <= point.y) {
            (true, false) if is_left => 1,
            (false, true) if !is_left => -1,
            _ => 0,
        }
    });
    crossings.sum()
}
