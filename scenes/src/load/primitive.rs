//! Decodes a primitive's attributes and indices. Positions and indices have to be right; whatever else is wrong is left
//! out.

use super::LoadError;
use super::accessor::{Accessors, Component, Elements, Kind};
use super::check;
use super::json::{Int, Property};
use super::lost::Lost;
use super::materials::Materials;
use super::notes::{Notes, Wrong};
use super::points::Points;
use super::pose::{Influences, Poser, SMALL, Vertices};
use super::survey::Primitive;
use gltf::json::mesh::Mode;
use std::cell::RefCell;

/// One primitive's decoded attributes.
pub(super) struct Decoded {
    pub(super) vertices: Vertices,
    pub(super) texcoords: Option<Vec<[f32; 2]>>,
    pub(super) colors: Option<Vec<[f32; 3]>>,
    pub(super) indices: Option<Vec<[u32; 1]>>,
    pub(super) influences: Influences,
}

/// What decoding a primitive needs.
pub(super) struct Decoder<'a, 'b> {
    pub(super) accessors: &'a Accessors<'b>,
    pub(super) poser: &'a Poser<'a, 'b>,
    pub(super) materials: &'a Materials,
    pub(super) notes: &'a RefCell<Notes>,
}

impl Decoder<'_, '_> {
    pub(super) fn decode(&self, primitive: &Primitive<'_>) -> Result<Decoded, LoadError> {
        let position = self.elements(primitive, "POSITION", primitive.position)?;
        position.expect(&[Kind::Vec3], &SMALL, "VEC3 of F32, or of 8 or 16-bit integers")?;
        let count = position.count;
        let positions = position.points()?;
        let indices = self.indices(primitive)?;
        let normals = self.optional(primitive, Lost::Normals, "NORMAL", |e| self.normals(&e, count));
        let colors = self.optional(primitive, Lost::Colors, "COLOR_0", |e| self.colors(&e, count));
        let texcoords = self.texcoords(primitive, count);
        let influences = self.poser.influences(primitive.json, count, &primitive.path);
        let influences = influences.unwrap_or_else(|error| {
            self.notes.borrow_mut().lost(Lost::Skin, primitive.key, error);
            Influences::new()
        });
        let vertices = Vertices { positions, normals, mirrored: None };
        Ok(Decoded { vertices, texcoords, colors, indices, influences })
    }

    /// An attribute's elements, decompressed or from its accessor.
    fn elements<'p>(&'p self, primitive: &'p Primitive<'_>, name: &str, index: Int) -> Result<Elements<'p>, LoadError> {
        let path = format!("{}.attributes.{name}", primitive.path);
        let Some(draco) = primitive.draco.as_ref().filter(|draco| draco.has(name)) else {
            return self.accessors.open(index, &path);
        };
        let elements = self.accessors.without_bytes(index, &path)?;
        match draco.attribute(name, elements.kind(), &path)? {
            Some(attribute) => Ok(elements.with_bytes(&attribute.bytes, attribute.component)),
            None => self.accessors.open(index, &path),
        }
    }

    /// An attribute that the picture does not need.
    fn optional<'p, T>(
        &'p self,
        primitive: &'p Primitive<'_>,
        lost: Lost,
        name: &str,
        decode: impl FnOnce(Elements<'p>) -> Result<T, LoadError>,
    ) -> Option<T> {
        let index: &Property<Int> = primitive.attributes.get(name)?;
        let path = || format!("{}.attributes.{name}", primitive.path);
        let decoded = index.need(path).and_then(|index| decode(self.elements(primitive, name, *index)?));
        decoded.map_err(|error| self.notes.borrow_mut().lost(lost, primitive.key, error)).ok()
    }

    fn normals(&self, elements: &Elements<'_>, count: u64) -> Result<Points, LoadError> {
        let components = [Component::F32, Component::I8, Component::I16];
        elements.expect(&[Kind::Vec3], &components, "VEC3 of F32, I8 or I16")?;
        elements.expect_count(count)?;
        let values = elements.singles::<3>()?;
        let has_none = |n: &&[f32; 3]| !n.iter().all(|c| c.is_finite()) || **n == [0.0; 3];
        elements.found(Wrong::Normals, values.iter().filter(has_none).count());
        Ok(Points::Single(values))
    }

    fn colors(&self, elements: &Elements<'_>, count: u64) -> Result<Vec<[f32; 3]>, LoadError> {
        let right = "VEC3 or VEC4 of F32 or of normalized U8 or U16";
        let components = [Component::F32, Component::U8, Component::U16];
        elements.expect(&[Kind::Vec3, Kind::Vec4], &components, right)?;
        elements.expect_normalized()?;
        elements.expect_count(count)?;
        let mut values = elements.singles::<3>()?;
        elements.found(Wrong::Colors, replace_not_finite(&mut values, 1.0));
        elements.found(Wrong::ColorsOutside, values.iter().filter(|c| c.iter().any(check::is_outside)).count());
        Ok(values)
    }

    fn texcoords(&self, primitive: &Primitive<'_>, count: u64) -> Option<Vec<[f32; 2]>> {
        let usage = self.materials.id(primitive.material()).1?;
        let name = format!("TEXCOORD_{}", usage.set);
        if !primitive.attributes.contains_key(&name) {
            let note = "a mesh without the texture coordinates of its texture is shown with one texel";
            self.notes.borrow_mut().add(note);
            return None;
        }
        self.optional(primitive, Lost::Texcoords, &name, |elements| {
            elements.expect(&[Kind::Vec2], &SMALL, "VEC2 of F32, or of 8 or 16-bit integers")?;
            elements.expect_count(count)?;
            let mut values = elements.singles::<2>()?;
            values.iter_mut().for_each(|uv| *uv = usage.apply(*uv));
            elements.found(Wrong::Texcoords, replace_not_finite(&mut values, 0.0));
            Ok(values)
        })
    }

    /// The indices, which may be beyond the vertices.
    fn indices(&self, primitive: &Primitive<'_>) -> Result<Option<Vec<[u32; 1]>>, LoadError> {
        let path = || format!("{}.indices", primitive.path);
        if primitive.draco.is_some() {
            return Ok(None);
        }
        let Some(index) = primitive.json.indices.get(path)? else { return Ok(None) };
        let elements = self.accessors.open(*index, &path())?;
        let components = [Component::U8, Component::U16, Component::U32];
        elements.expect(&[Kind::Scalar], &components, "SCALAR of U8, U16 or U32")?;
        elements.integers::<1>().map(Some)
    }
}

impl Primitive<'_> {
    /// The file's material index.
    pub(super) fn material(&self) -> Option<usize> {
        self.json.material.ok().map(|material| material.index())
    }

    pub(super) fn has(&self, attribute: &str) -> bool {
        self.attributes.contains_key(attribute)
    }

    /// The indices, if the primitive has some.
    pub(super) fn indices<'a>(&'a self, decoded: &'a Decoded) -> Option<&'a [[u32; 1]]> {
        self.draco.as_ref().map(|draco| &draco.indices[..]).or(decoded.indices.as_deref())
    }

    /// The vertices of triangle `i`.
    #[inline]
    pub(super) fn corners(&self, i: usize, indices: Option<&[[u32; 1]]>) -> Option<[usize; 3]> {
        let corners = match self.mode {
            // Every other triangle of a strip is reversed, so that all face the same way.
            Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::TriangleFan => [i + 1, i + 2, 0],
            _ => [3 * i, 3 * i + 1, 3 * i + 2],
        };
        let Some(indices) = indices else { return Some(corners) };
        let [a, b, c] = corners;
        let ([a], [b], [c]) = (indices.get(a)?, indices.get(b)?, indices.get(c)?);
        Some([*a as usize, *b as usize, *c as usize])
    }
}

/// Replaces colours and texture coordinates that are not finite, which must not reach the image. Returns their number.
fn replace_not_finite<const N: usize>(values: &mut [[f32; N]], with: f32) -> usize {
    let wrong = values.iter_mut().filter(|value| !value.iter().all(|part| part.is_finite()));
    wrong.map(|value| value.iter_mut().filter(|part| !part.is_finite()).for_each(|part| *part = with)).count()
}
