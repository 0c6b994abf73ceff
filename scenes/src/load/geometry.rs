//! Converts meshes to the scene's triangles.
//!
//! Exactly the required memory is allocated, and each primitive is decoded once and placed by its nodes. Vertices are
//! placed one by one, in f64, and rounded once; no mesh is stored a second time in world space.

use super::budget::Budget;
use super::check::is_lack;
use super::instances::Instances;
use super::lost::Lost;
use super::notes::Wrong;
use super::place::{Placement, flat_normal};
use super::pose::{Key, Posed, Vertices};
use super::primitive::{Decoded, Decoder};
use super::survey::Primitive;
use super::{LoadError, at};
use glam::{DAffine3, DVec3};

/// The scene's lists, see [`Scene`](crate::Scene).
#[derive(Default)]
pub(super) struct Triangles {
    pub(super) positions: Vec<[[f32; 3]; 3]>,
    pub(super) normals: Option<Vec<[[f32; 3]; 3]>>,
    pub(super) texcoords: Option<Vec<[[f32; 2]; 3]>>,
    pub(super) colors: Option<Vec<[[f32; 3]; 3]>>,
    pub(super) materials: Vec<u32>,
    /// Smallest and largest coordinates.
    pub(super) bounds: [DVec3; 2],
    /// The translation that all shapes share, if they do.
    pub(super) translation: Option<DVec3>,
}

/// Triangles of one primitive that are left out.
#[derive(Default)]
struct LeftOut {
    /// With an index beyond the vertices.
    indices: usize,
    /// With a vertex that is not finite.
    vertices: usize,
    /// With a place that is not finite.
    places: usize,
    /// The first, and its node.
    first: Option<(usize, usize)>,
}

impl Triangles {
    /// Space for all triangles of these primitives.
    pub(super) fn with_space(
        primitives: &[Primitive<'_>],
        instances: &Instances,
        is_textured: bool,
        budget: &Budget,
    ) -> Result<Self, LoadError> {
        let of_node = |node: &usize| instances.get(node).and_then(Option::as_ref).map_or(1, |own| own.len() as u64);
        let of_primitive = |primitive: &Primitive<'_>| {
            let copies = primitive.group.nodes.iter().map(of_node).fold(0, u64::saturating_add);
            primitive.triangles.saturating_mul(copies)
        };
        let total = primitives.iter().map(of_primitive).fold(0, u64::saturating_add);
        let path = "meshes";
        if total >= u64::from(u32::MAX) {
            return Err(at(path, format!("the scene has {total} triangles; expected fewer than {}", u32::MAX)));
        }
        let any = |name: &str| primitives.iter().any(|primitive| primitive.has(name));
        Ok(Self {
            positions: budget.vec(total, path)?,
            normals: any("NORMAL").then(|| budget.vec(total, path)).transpose()?,
            texcoords: is_textured.then(|| budget.vec(total, path)).transpose()?,
            colors: any("COLOR_0").then(|| budget.vec(total, path)).transpose()?,
            materials: budget.vec(total, path)?,
            ..Self::default()
        })
    }

    /// Decodes and places all triangles. With `is_rounded`, those are left out whose corners 32-bit numbers do not hold.
    pub(super) fn fill(
        &mut self,
        primitives: &[Primitive<'_>],
        instances: &Instances,
        decoder: &Decoder<'_, '_>,
        is_rounded: bool,
    ) -> Result<(), LoadError> {
        self.positions.clear();
        self.materials.clear();
        self.normals.iter_mut().for_each(Vec::clear);
        self.texcoords.iter_mut().for_each(Vec::clear);
        self.colors.iter_mut().for_each(Vec::clear);
        self.bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.translation = None;
        let (mut has_normals, mut has_colors, mut is_first) = (false, false, true);
        for primitive in primitives {
            let decoded = match decoder.decode(primitive) {
                Ok(decoded) => decoded,
                Err(error) if is_lack(&error) => return Err(error),
                Err(error) => {
                    decoder.notes.borrow_mut().lost(Lost::Primitive, primitive.key, error);
                    continue;
                }
            };
            has_normals |= decoded.vertices.normals.is_some();
            has_colors |= decoded.colors.is_some();
            let left_out = self.place_all(primitive, instances, decoder, &decoded, is_rounded, &mut is_first)?;
            left_out.note(primitive, decoder, &decoded, self.positions.len() == self.materials.len());
            let material = decoder.materials.id(primitive.material()).0;
            self.materials.resize(self.positions.len(), material);
        }
        self.normals.take_if(|_| !has_normals);
        self.colors.take_if(|_| !has_colors);
        Ok(())
    }

    /// Places a primitive for each of its nodes and their instances.
    fn place_all(
        &mut self,
        primitive: &Primitive<'_>,
        instances: &Instances,
        decoder: &Decoder<'_, '_>,
        decoded: &Decoded,
        is_rounded: bool,
        is_first: &mut bool,
    ) -> Result<LeftOut, LoadError> {
        let poser = decoder.poser;
        let mut left_out = LeftOut::default();
        let mut posed: Option<(Key, Vertices)> = None;
        let (json, path, key) = (primitive.json, &primitive.path[..], primitive.key);
        for &node in &primitive.group.nodes {
            let pose = poser.key(node, json, !decoded.influences.is_empty());
            if let Some(pose) = pose
                && posed.as_ref().is_none_or(|(known, _)| *known != pose)
            {
                // Drop the previous pose first, so that two are never in memory.
                drop(posed.take());
                let mesh_weights = primitive.group.mesh.weights.ok();
                let primitive = Posed { json, mesh_weights, key, path };
                posed = Some((pose, poser.pose(pose, primitive, &decoded.vertices, &decoded.influences)?));
            }
            let vertices = match (pose, &posed) {
                (Some(_), Some((_, vertices))) => vertices,
                _ => &decoded.vertices,
            };
            let is_skinned = vertices.mirrored.is_some();
            let own = instances.get(&node).and_then(Option::as_deref);
            for k in 0..own.map_or(1, <[_]>::len) {
                let instance = own.and_then(|own| own.get(k));
                let world = match (is_skinned, instance) {
                    (true, instance) => poser.of_skinned(instance),
                    (false, None) => poser.graph.world(node),
                    (false, Some(instance)) => poser.graph.world(node) * *instance,
                };
                let shared = if is_skinned { None } else { Some(world.translation) };
                self.translation =
                    if *is_first { shared } else { self.translation.filter(|known| shared == Some(*known)) };
                *is_first = false;
                self.place(primitive, decoded, vertices, world, (node, is_rounded), &mut left_out);
            }
            if is_skinned {
                decoder.notes.borrow_mut().add("skins are shown in their rest pose");
            }
        }
        if !json.targets.elements().is_empty() {
            decoder.notes.borrow_mut().add("morph targets are shown with their default weights");
        }
        Ok(left_out)
    }

    /// Appends the triangles, transformed by `world`.
    fn place(
        &mut self,
        primitive: &Primitive<'_>,
        decoded: &Decoded,
        vertices: &Vertices,
        world: DAffine3,
        (node, is_rounded): (usize, bool),
        left_out: &mut LeftOut,
    ) {
        let placement = Placement::new(world);
        let count = usize::try_from(primitive.triangles).unwrap_or_default();
        let indices = primitive.indices(decoded);
        let [mut min, mut max] = self.bounds;
        // Without closures for each of three corners, which are calls where code is to be small.
        for i in 0..count {
            let Some([a, b, c]) = primitive.corners(i, indices) else {
                left_out.add(i, node, None);
                continue;
            };
            let mirrors = match &vertices.mirrored {
                Some(mirrored) => mirrored.get(a).copied().unwrap_or_default(),
                None => placement.mirrors,
            };
            let [a, b, c] = if mirrors { [a, c, b] } else { [a, b, c] };
            let points = &vertices.positions;
            let (Some(p), Some(q), Some(r)) = (points.get(a), points.get(b), points.get(c)) else {
                left_out.add(i, node, None);
                continue;
            };
            let [u, v, w] = [placement.position(p), placement.position(q), placement.position(r)];
            let [x, y, z] = [u.as_vec3(), v.as_vec3(), w.as_vec3()];
            let is_held = x.is_finite() && y.is_finite() && z.is_finite();
            if !is_held && (is_rounded || !(u.is_finite() && v.is_finite() && w.is_finite())) {
                left_out.add(i, node, Some([p, q, r]));
                continue;
            }
            (min, max) = (min.min(u).min(v).min(w), max.max(u).max(v).max(w));
            let positions = [x.to_array(), y.to_array(), z.to_array()];
            self.positions.push(positions);
            if let Some(normals) = &mut self.normals {
                let own =
                    |k| vertices.normals.as_ref().and_then(|own| own.get(k)).map_or([0.0; 3], |n| placement.normal(n));
                normals.push([own(a), own(b), own(c)]);
                for normal in normals.last_mut().into_iter().flatten().filter(|n| **n == [0.0; 3]) {
                    *normal = flat_normal(positions);
                }
            }
            if let Some(texcoords) = &mut self.texcoords {
                texcoords.push(gather(decoded.texcoords.as_deref(), [a, b, c]).unwrap_or_default());
            }
            if let Some(colors) = &mut self.colors {
                colors.push(gather(decoded.colors.as_deref(), [a, b, c]).unwrap_or([[1.0; 3]; 3]));
            }
        }
        self.bounds = [min, max];
    }
}

impl LeftOut {
    /// Counts triangle `i`, whose corners are these if the primitive has all of them.
    #[cold]
    fn add(&mut self, i: usize, node: usize, corners: Option<[DVec3; 3]>) {
        self.first.get_or_insert((i, node));
        *match corners {
            None => &mut self.indices,
            Some(corners) if corners.iter().any(|corner| !corner.is_finite()) => &mut self.vertices,
            Some(_) => &mut self.places,
        } += 1;
    }

    /// Notes what is left out of a primitive, and that nothing of it `is_left`.
    fn note(self, primitive: &Primitive<'_>, decoder: &Decoder<'_, '_>, decoded: &Decoded, is_empty: bool) {
        let Some((i, node)) = self.first else { return };
        let mut notes = decoder.notes.borrow_mut();
        if is_empty {
            notes.lost(Lost::Primitive, primitive.key, self.reason(primitive, decoded, i, node));
            return;
        }
        let (mesh, k) = primitive.key;
        // Each primitive has a number of its own.
        let index = mesh.wrapping_mul(1 << 20).wrapping_add(k);
        for (what, count) in [
            (Wrong::TrianglesMissing, self.indices),
            (Wrong::TrianglesNotFinite, self.vertices),
            (Wrong::TrianglesBeyond, self.places),
        ] {
            notes.found(what, index, count);
        }
    }

    /// Why triangle `i` is left out.
    fn reason(&self, primitive: &Primitive<'_>, decoded: &Decoded, i: usize, node: usize) -> LoadError {
        let count = decoded.vertices.positions.len();
        let path = &primitive.path;
        let corners = primitive.corners(i, primitive.indices(decoded)).unwrap_or([usize::MAX; 3]);
        if let Some(bad) = corners.into_iter().find(|&corner| corner >= count) {
            let problem = format!("triangle {i} has the index {bad}, but there are {count} vertices (counted from 0)");
            return at(format!("{path}.indices"), problem);
        }
        let points = corners.map(|corner| (corner, decoded.vertices.positions.get(corner).unwrap_or_default()));
        match points.into_iter().find(|(_, point)| !point.is_finite()) {
            Some((corner, point)) => {
                let problem = format!("element {corner} is {:?}; positions must be finite", point.to_array());
                at(format!("{path}.attributes.POSITION"), problem)
            }
            None => {
                let problem = format!("its transform moves triangle {i} of {path} beyond 32-bit numbers");
                at(format!("nodes[{node}]"), problem)
            }
        }
    }
}

/// Three elements of a list.
fn gather<T: Copy>(list: Option<&[T]>, [a, b, c]: [usize; 3]) -> Option<[T; 3]> {
    let list = list?;
    Some([*list.get(a)?, *list.get(b)?, *list.get(c)?])
}
