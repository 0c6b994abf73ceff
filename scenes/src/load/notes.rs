//! Notes for the user: what was ignored, assumed or mended, one counted sentence per kind.

use super::LoadError;
use super::lost::{Losses, Lost};
use std::collections::{BTreeMap, HashSet};

/// Faults that are noted but do not prevent loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Wrong {
    /// Vertices whose normal has no direction, by accessor.
    Normals,
    /// Vertices whose colour is not finite, by accessor.
    Colors,
    /// Vertices whose colour is outside [0, 1], by accessor.
    ColorsOutside,
    /// Vertices whose texture coordinates are not finite, by accessor.
    Texcoords,
    /// Accessors with elements outside their `min` and `max`, by accessor.
    Bounds,
    /// A material's colours outside [0, 1], by material.
    FactorOutside,
    /// Lights with a colour outside [0, 1], by light.
    LightOutside,
    /// Nodes with a matrix and also a translation, rotation or scale, by node.
    MatrixBesideParts,
    /// Nodes with a rotation that is not of length 1, by node.
    RotationNotUnit,
    /// Nodes and instances with a rotation of length 0, by node.
    RotationZero,
    /// Nodes whose instances' attributes have different counts, by node.
    InstanceCounts,
    /// Instances with a transform that is not finite, by node.
    Instances,
    /// Nodes that KHR_node_visibility hides, by node.
    Hidden,
    /// Triangles with an index beyond the vertices, by primitive.
    TrianglesMissing,
    /// Triangles with a vertex that is not finite, by primitive.
    TrianglesNotFinite,
    /// Triangles moved beyond 32-bit numbers, by primitive.
    TrianglesBeyond,
    /// Accessors of positions whose steps are coarse beside their extent, by accessor.
    Lattice,
    /// Spot lights whose cone angles are out of range or too close, by light.
    Cones,
    /// Cameras whose clipping planes or width are out of range, by camera.
    Planes,
    /// Vertices whose position is not finite in f32.
    Positions,
    /// Faces of fewer than three corners.
    FacesShort,
    /// Faces with a corner that is no vertex.
    FacesMissing,
    /// Faces with such a position.
    FacesNotFinite,
    /// Corners with the index of a normal that does not exist.
    NormalsMissing,
    /// Corners with the index of texture coordinates that do not exist.
    TexcoordsMissing,
    /// Vertices whose encoded colour is not between black and white.
    ColorsClamped,
    /// Polygons with edges that cross, or without an area.
    PolygonsImproper,
    /// Polygons with corners off their plane.
    PolygonsNotPlanar,
}

impl Wrong {
    /// The note for this number of occurrences.
    fn sentence(self, count: usize) -> String {
        let (one, many, rest) = match self {
            Self::Normals => ("normal", "normals", "no direction (zeros, NaN or infinities): drawn flat there"),
            Self::Colors => ("vertex colour", "vertex colours", "parts that are no numbers: drawn as 1"),
            Self::ColorsOutside => ("vertex colour", "vertex colours", "parts outside of 0 to 1: drawn as they are"),
            Self::Texcoords => ("texture coordinate", "texture coordinates", "parts that are no numbers: drawn as 0"),
            Self::Bounds => ("accessor", "accessors", "elements outside of min and max: drawn as they are"),
            Self::FactorOutside => {
                ("material factor", "material factors", "parts outside of 0 to 1: drawn as they are")
            }
            Self::LightOutside => ("light", "lights", "a colour outside of 0 to 1: drawn as it is"),
            Self::MatrixBesideParts => {
                ("node", "nodes", "a matrix beside a translation, rotation or scale: drawn by the matrix")
            }
            Self::RotationNotUnit => ("node", "nodes", "a rotation of another length than 1: drawn as if it were 1"),
            Self::RotationZero => ("node", "nodes", "a rotation of length 0: drawn without it"),
            Self::InstanceCounts => {
                ("node", "nodes", "instances with different numbers of attributes: as many drawn as have all of them")
            }
            Self::Instances => ("instance", "instances", "a transform with parts that are no numbers: left out"),
            Self::Hidden => ("node", "nodes", "\"visible\": false (KHR_node_visibility): left out, with all below"),
            Self::TrianglesMissing => ("triangle", "triangles", "indices beyond the vertices: left out"),
            Self::TrianglesNotFinite => ("triangle", "triangles", "a vertex with parts that are no numbers: left out"),
            Self::TrianglesBeyond => ("triangle", "triangles", "a position beyond 32-bit numbers: left out"),
            Self::Lattice => (
                "accessor",
                "accessors",
                "positions so far from the origin that 32-bit numbers round their shape: drawn as they are",
            ),
            Self::Cones => ("spot light", "spot lights", "angles other than 0 <= inner < outer <= pi/2: mended"),
            Self::Planes => ("camera", "cameras", "clipping planes or a width out of range: not used"),
            Self::Positions => ("vertex", "vertices", "a position that is not finite in 32 bits: not drawn"),
            Self::FacesShort => ("face", "faces", "fewer than 3 corners: left out"),
            Self::FacesMissing => ("face", "faces", "a corner that is no vertex of the file: left out"),
            Self::FacesNotFinite => ("face", "faces", "a corner that is not finite in 32 bits: left out"),
            Self::NormalsMissing => ("corner", "corners", "a normal that does not exist: drawn flat there"),
            Self::TexcoordsMissing => ("corner", "corners", "texture coordinates that do not exist: drawn as 0"),
            Self::ColorsClamped => {
                ("vertex colour", "vertex colours", "parts out of range: drawn as the nearest colour")
            }
            Self::PolygonsImproper => ("polygon", "polygons", "edges that cross, or no area: drawn approximately"),
            Self::PolygonsNotPlanar => ("polygon", "polygons", "corners off the best plane by over 1% of the size"),
        };
        if count == 1 { format!("1 {one} has {rest}") } else { format!("{count} {many} have {rest}") }
    }
}

/// Notes for the user, without duplicates.
#[derive(Default)]
pub(crate) struct Notes {
    said: Vec<String>,
    known: HashSet<String>,
    /// How often each fault occurs in one part of the file; the part may be read repeatedly.
    found: BTreeMap<(Wrong, usize), usize>,
    losses: Losses,
}

impl Notes {
    pub(crate) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        if self.known.insert(note.clone()) {
            self.said.push(note);
        }
    }

    /// Records that this fault occurs `count` times in the part of the file with this index.
    pub(crate) fn found(&mut self, what: Wrong, index: usize, count: usize) {
        if count > 0 {
            self.found.insert((what, index), count);
        }
    }

    /// Records that the part of the file with this key is lost, and why.
    pub(crate) fn lost(&mut self, what: Lost, key: (usize, usize), reason: LoadError) {
        self.losses.add(what, key, reason);
    }

    /// The number of primitives that the picture should show.
    pub(crate) fn expect_primitives(&mut self, count: usize) {
        self.losses.primitives = count;
    }

    /// Why the first shape is missing from the picture.
    pub(crate) fn lost_shape(&self) -> Option<&LoadError> {
        self.losses.shape()
    }

    /// All notes: what is lost, sentences, then counted faults.
    pub(crate) fn into_vec(self) -> Vec<String> {
        let mut counts: BTreeMap<Wrong, usize> = BTreeMap::new();
        for ((what, _), count) in self.found {
            *counts.entry(what).or_default() += count;
        }
        self.losses
            .sentences()
            .chain(self.said)
            .chain(counts.into_iter().map(|(what, count)| what.sentence(count)))
            .collect()
    }
}
