//! Converts meshes to the scene's triangles.
//!
//! First a survey: which primitives are shown, how often, and how many triangles they have. Then exactly the required
//! memory is allocated, and each primitive is decoded once and placed by its nodes. Vertices are placed one by one; no
//! mesh is stored a second time in world space.

use super::accessor::Accessors;
use super::budget::Budget;
use super::check;
use super::graph::Graph;
use super::materials::Materials;
use super::notes::{Notes, Wrong};
use super::place::{Placement, flat_normal};
use super::pose::{Influences, Key, Poser, Vertices, expect_count};
use super::{LoadError, at};
use glam::DAffine3;
use gltf::json::accessor::{ComponentType as C, Type};
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Mesh, Root};
use std::cell::RefCell;
use std::collections::HashMap;

/// A mesh and the nodes that show it.
pub(super) struct Group<'a> {
    mesh_index: usize,
    mesh: &'a Mesh,
    nodes: Vec<usize>,
}

/// A primitive with at least one triangle.
pub(super) struct Primitive<'a> {
    group: &'a Group<'a>,
    json: &'a gltf::json::mesh::Primitive,
    position: Index<Accessor>,
    mode: Mode,
    triangles: u64,
    path: String,
}

/// The scene's lists, see [`Scene`](crate::Scene).
#[derive(Default)]
pub(super) struct Triangles {
    pub(super) positions: Vec<[[f32; 3]; 3]>,
    pub(super) normals: Option<Vec<[[f32; 3]; 3]>>,
    pub(super) texcoords: Option<Vec<[[f32; 2]; 3]>>,
    pub(super) colors: Option<Vec<[[f32; 3]; 3]>>,
    pub(super) materials: Vec<u32>,
}

/// One primitive's decoded attributes.
struct Decoded {
    vertices: Vertices,
    texcoords: Option<Vec<[f32; 2]>>,
    colors: Option<Vec<[f32; 3]>>,
    indices: Option<Vec<[u32; 1]>>,
    influences: Influences,
}

/// The meshes of these nodes, in the order of first occurrence.
pub(super) fn groups<'a>(root: &'a Root, nodes: &[usize]) -> Result<Vec<Group<'a>>, LoadError> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    let mut known: HashMap<usize, usize> = HashMap::new();
    for &i in nodes {
        let Some(node) = root.nodes.get(i) else { continue };
        let Some(index) = node.mesh else { continue };
        let mesh = check::get(&root.meshes, index, &format!("nodes[{i}].mesh"), "mesh")?;
        if let Some(skin) = node.skin {
            check::get(&root.skins, skin, &format!("nodes[{i}].skin"), "skin")?;
        }
        let mesh_index = index.value();
        match known.get(&mesh_index).and_then(|&k| groups.get_mut(k)) {
            Some(group) => group.nodes.push(i),
            None => {
                known.insert(mesh_index, groups.len());
                groups.push(Group { mesh_index, mesh, nodes: vec![i] });
            }
        }
    }
    Ok(groups)
}

/// The primitives that have triangles. Checks what determines their number, without decoding anything.
pub(super) fn survey<'a>(
    root: &'a Root,
    accessors: &Accessors<'_>,
    groups: &'a [Group<'a>],
    notes: &RefCell<Notes>,
) -> Result<Vec<Primitive<'a>>, LoadError> {
    let mut primitives = Vec::new();
    for group in groups {
        for (k, json) in group.mesh.primitives.iter().enumerate() {
            let path = format!("meshes[{}].primitives[{k}]", group.mesh_index);
            let mode = check::known(&json.mode, &format!("{path}.mode"), "0 to 6")?;
            if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                notes.borrow_mut().add("points and lines are omitted");
                continue;
            }
            let Some(&position) = json.attributes.get(&Checked::Valid(Semantic::Positions)) else {
                notes.borrow_mut().add("primitives without positions are omitted");
                continue;
            };
            let counting = match json.indices {
                Some(indices) => accessors.open(indices, &format!("{path}.indices"))?,
                None => accessors.open(position, &format!("{path}.attributes.POSITION"))?,
            };
            let corners = counting.count;
            if mode == Mode::Triangles && !corners.is_multiple_of(3) {
                return Err(counting.wrong(format!("has {corners} corners; expected a multiple of 3")));
            }
            let triangles = if mode == Mode::Triangles { corners / 3 } else { corners.saturating_sub(2) };
            if let Some(material) = json.material {
                check::get(&root.materials, material, &format!("{path}.material"), "material")?;
            }
            if triangles > 0 {
                primitives.push(Primitive { group, json, position, mode, triangles, path });
            }
        }
    }
    Ok(primitives)
}

/// Decodes and places all triangles.
pub(super) fn triangles(
    primitives: &[Primitive<'_>],
    accessors: &Accessors<'_>,
    poser: &Poser<'_>,
    graph: &Graph,
    materials: &Materials,
    budget: &Budget,
    notes: &RefCell<Notes>,
) -> Result<Triangles, LoadError> {
    let total =
        primitives.iter().map(|p| p.triangles.saturating_mul(p.group.nodes.len() as u64)).fold(0, u64::saturating_add);
    let path = "meshes";
    if total >= u64::from(u32::MAX) {
        return Err(at(path, format!("the scene has {total} triangles; expected fewer than {}", u32::MAX)));
    }
    let any = |semantic: &Semantic| primitives.iter().any(|p| p.attribute(semantic.clone()).is_some());
    let textured = primitives.iter().any(|p| materials.id(p.material()).1.is_some());
    let mut out = Triangles {
        positions: budget.vec(total, path)?,
        normals: any(&Semantic::Normals).then(|| budget.vec(total, path)).transpose()?,
        texcoords: textured.then(|| budget.vec(total, path)).transpose()?,
        colors: any(&Semantic::Colors(0)).then(|| budget.vec(total, path)).transpose()?,
        materials: budget.vec(total, path)?,
    };
    for primitive in primitives {
        let decoded = primitive.decode(accessors, poser, materials, notes)?;
        let mut posed: Option<(Key, Vertices)> = None;
        for &node in &primitive.group.nodes {
            let key = poser.key(node, primitive.json, !decoded.influences.is_empty());
            if let Some(key) = key
                && posed.as_ref().is_none_or(|(known, _)| *known != key)
            {
                let weights = primitive.group.mesh.weights.as_deref();
                let (json, path) = (primitive.json, &primitive.path);
                // Drop the previous pose first, so that two are never in memory.
                drop(posed.take());
                posed = Some((key, poser.pose(key, weights, json, &decoded.vertices, &decoded.influences, path)?));
            }
            let vertices = match (key, &posed) {
                (Some(_), Some((_, vertices))) => vertices,
                _ => &decoded.vertices,
            };
            let world = if vertices.mirrored.is_some() { DAffine3::IDENTITY } else { graph.world(node) };
            primitive.place(&decoded, vertices, &Placement::new(world), node, &mut out)?;
        }
        if posed.is_some_and(|(key, _)| key.is_skinned()) {
            notes.borrow_mut().add("skins are shown in their rest pose");
        }
        if primitive.json.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            notes.borrow_mut().add("morph targets are shown with their default weights");
        }
        let count = out.positions.len();
        out.materials.resize(count, materials.id(primitive.material()).0);
    }
    Ok(out)
}

impl Primitive<'_> {
    /// The file's material index.
    pub(super) fn material(&self) -> Option<usize> {
        self.json.material.map(|material| material.value())
    }

    fn attribute(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.json.attributes.get(&Checked::Valid(semantic)).copied()
    }

    fn decode(
        &self,
        accessors: &Accessors<'_>,
        poser: &Poser<'_>,
        materials: &Materials,
        notes: &RefCell<Notes>,
    ) -> Result<Decoded, LoadError> {
        let open = |index, name: &str| accessors.open(index, &format!("{}.attributes.{name}", self.path));
        let small = [C::F32, C::I8, C::U8, C::I16, C::U16];

        let position = open(self.position, "POSITION")?;
        position.expect(&[Type::Vec3], &small, "VEC3 of F32, or of 8 or 16-bit integers")?;
        let count = position.count;
        let positions = position.vectors::<3>()?;
        if let Some((i, p)) = positions.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            return Err(position.wrong(format!("element {i} is {p:?}; positions must be finite")));
        }

        let mut normals = None;
        if let Some(index) = self.attribute(Semantic::Normals) {
            let elements = open(index, "NORMAL")?;
            elements.expect(&[Type::Vec3], &[C::F32, C::I8, C::I16], "VEC3 of F32, I8 or I16")?;
            expect_count(&elements, count)?;
            let values = elements.vectors::<3>()?;
            let has_none = |n: &&[f32; 3]| !n.iter().all(|c| c.is_finite()) || **n == [0.0; 3];
            elements.found(Wrong::Normals, values.iter().filter(has_none).count());
            normals = Some(values);
        }

        let mut colors = None;
        if let Some(index) = self.attribute(Semantic::Colors(0)) {
            let elements = open(index, "COLOR_0")?;
            let right = "VEC3 or VEC4 of F32 or of normalized U8 or U16";
            elements.expect(&[Type::Vec3, Type::Vec4], &[C::F32, C::U8, C::U16], right)?;
            elements.expect_normalized()?;
            expect_count(&elements, count)?;
            let mut values = elements.vectors::<3>()?;
            elements.found(Wrong::Colors, replace_not_finite(&mut values, 1.0));
            elements.found(Wrong::ColorsOutside, values.iter().filter(|c| c.iter().any(check::is_outside)).count());
            colors = Some(values);
        }

        let mut texcoords = None;
        if let Some(usage) = materials.id(self.material()).1 {
            match self.attribute(Semantic::TexCoords(usage.set)) {
                None => notes
                    .borrow_mut()
                    .add("a mesh without the texture coordinates of its texture is shown with one texel"),
                Some(index) => {
                    let elements = open(index, &format!("TEXCOORD_{}", usage.set))?;
                    elements.expect(&[Type::Vec2], &small, "VEC2 of F32, or of 8 or 16-bit integers")?;
                    expect_count(&elements, count)?;
                    let mut values = elements.vectors::<2>()?;
                    values.iter_mut().for_each(|uv| *uv = usage.apply(*uv));
                    elements.found(Wrong::Texcoords, replace_not_finite(&mut values, 0.0));
                    texcoords = Some(values);
                }
            }
        }

        let influences = poser.influences(self.json, count, &self.path)?;
        let indices = self.indices(accessors, count)?;
        let vertices = Vertices { positions, normals, mirrored: None };
        Ok(Decoded { vertices, texcoords, colors, indices, influences })
    }

    /// The indices, all below `vertices`.
    fn indices(&self, accessors: &Accessors<'_>, vertices: u64) -> Result<Option<Vec<[u32; 1]>>, LoadError> {
        let Some(index) = self.json.indices else { return Ok(None) };
        let elements = accessors.open(index, &format!("{}.indices", self.path))?;
        elements.expect(&[Type::Scalar], &[C::U8, C::U16, C::U32], "SCALAR of U8, U16 or U32")?;
        let indices = elements.integers::<1>()?;
        match indices.iter().enumerate().find(|(_, [index])| u64::from(*index) >= vertices) {
            None => Ok(Some(indices)),
            Some((i, [bad])) => {
                Err(elements.wrong(format!("element {i} is {bad}, but there are {vertices} vertices (counted from 0)")))
            }
        }
    }

    /// The vertices of triangle `i`.
    fn corners(&self, i: usize, indices: Option<&[[u32; 1]]>) -> Option<[usize; 3]> {
        let corners = match self.mode {
            // Every other triangle of a strip is reversed, so that all face the same way.
            Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::TriangleFan => [i + 1, i + 2, 0],
            _ => [3 * i, 3 * i + 1, 3 * i + 2],
        };
        let Some(indices) = indices else { return Some(corners) };
        let [a, b, c] = corners.map(|corner| indices.get(corner).map(|[index]| *index as usize));
        Some([a?, b?, c?])
    }

    /// Appends the triangles, transformed by `placement`.
    fn place(
        &self,
        decoded: &Decoded,
        vertices: &Vertices,
        placement: &Placement,
        node: usize,
        out: &mut Triangles,
    ) -> Result<(), LoadError> {
        for i in 0..usize::try_from(self.triangles).unwrap_or_default() {
            // The survey and the checks of indices guarantee that this succeeds.
            let Some([a, b, c]) = self.corners(i, decoded.indices.as_deref()) else { continue };
            let mirrors = match &vertices.mirrored {
                Some(mirrored) => mirrored.get(a).copied().unwrap_or_default(),
                None => placement.mirrors,
            };
            let corners = if mirrors { [a, c, b] } else { [a, b, c] };
            let Some(positions) = gather(&vertices.positions, corners) else { continue };
            let positions = positions.map(|p| placement.position(p));
            if !positions.iter().flatten().all(|p| p.is_finite()) {
                let problem = format!("its transform moves triangle {i} of {} beyond 32-bit numbers", self.path);
                return Err(at(format!("nodes[{node}]"), problem));
            }
            out.positions.push(positions);
            if let Some(normals) = &mut out.normals {
                let own = vertices.normals.as_deref().and_then(|own| gather(own, corners)).unwrap_or_default();
                let mut own = own.map(|n| placement.normal(n));
                for normal in own.iter_mut().filter(|n| **n == [0.0; 3]) {
                    *normal = flat_normal(positions);
                }
                normals.push(own);
            }
            if let Some(texcoords) = &mut out.texcoords {
                let own = decoded.texcoords.as_deref().and_then(|own| gather(own, corners));
                texcoords.push(own.unwrap_or_default());
            }
            if let Some(colors) = &mut out.colors {
                let own = decoded.colors.as_deref().and_then(|own| gather(own, corners));
                colors.push(own.unwrap_or([[1.0; 3]; 3]));
            }
        }
        Ok(())
    }
}

/// Three elements of a list.
fn gather<T: Copy>(list: &[T], [a, b, c]: [usize; 3]) -> Option<[T; 3]> {
    Some([*list.get(a)?, *list.get(b)?, *list.get(c)?])
}

/// Replaces colours and texture coordinates that are not finite, which must not reach the image. Returns their number.
fn replace_not_finite<const N: usize>(values: &mut [[f32; N]], with: f32) -> usize {
    let wrong = values.iter_mut().filter(|value| !value.iter().all(|part| part.is_finite()));
    wrong.map(|value| value.iter_mut().filter(|part| !part.is_finite()).for_each(|part| *part = with)).count()
}
