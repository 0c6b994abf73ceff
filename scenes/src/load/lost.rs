//! What is missing from the picture, or drawn more simply, because something in the file cannot be read: one counted
//! sentence per kind, with the first reason.

use super::LoadError;
use std::collections::{BTreeMap, BTreeSet};

/// What is lost. Everything of a file that is not in this list has to be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Lost {
    /// A node with all below it, by node.
    Node,
    /// A node's mesh, by node.
    Mesh,
    /// A primitive, by mesh and primitive, like all kinds up to [`Self::Morph`].
    Primitive,
    /// Corners after the last whole triangle.
    Corners,
    Normals,
    Colors,
    Texcoords,
    Skin,
    Morph,
    /// An image, by material.
    Texture,
    /// A texture's sampler, by material.
    Sampler,
    /// A property of a material, by material.
    Material,
    /// A light, by node.
    Light,
    /// A camera, by node.
    Camera,
    /// A link in the hierarchy, by node and child.
    Link,
    /// Which scene to show.
    Scene,
}

impl Lost {
    /// Whether the picture may lack a shape. If nothing is left of it, the file is rejected.
    fn is_shape(self) -> bool {
        matches!(self, Self::Node | Self::Mesh | Self::Primitive | Self::Link)
    }

    /// The sentence for one and for many.
    fn sentences(self) -> (&'static str, &'static str) {
        match self {
            Self::Node => ("node is missing, with all below it", "nodes are missing, with all below them"),
            Self::Mesh => ("node's mesh is missing", "nodes' meshes are missing"),
            Self::Primitive => ("primitive is missing", "primitives are missing"),
            Self::Corners => {
                ("primitive has corners after its last triangle", "primitives have corners after their last triangle")
            }
            Self::Normals => {
                ("primitive is drawn flat, without its normals", "primitives are drawn flat, without their normals")
            }
            Self::Colors => ("primitive is drawn without its colours", "primitives are drawn without their colours"),
            Self::Texcoords => (
                "primitive is drawn with one texel of its texture",
                "primitives are drawn with one texel of their texture",
            ),
            Self::Skin => ("primitive is drawn without its skin", "primitives are drawn without their skins"),
            Self::Morph => {
                ("primitive is drawn without a morph target", "primitives are drawn without some morph targets")
            }
            Self::Texture => ("material is drawn without its texture", "materials are drawn without their textures"),
            Self::Sampler => ("texture is repeated and filtered", "textures are repeated and filtered"),
            Self::Material => ("property of a material has its default", "properties of materials have their defaults"),
            Self::Light => ("light is left out", "lights are left out"),
            Self::Camera => ("camera is left out", "cameras are left out"),
            Self::Link => ("link in the tree of nodes is mended", "links in the tree of nodes are mended"),
            Self::Scene => ("choice of a scene is ignored", "choices of a scene are ignored"),
        }
    }
}

/// Everything that is lost.
#[derive(Default)]
pub(crate) struct Losses {
    /// The parts that are lost, and why the first is. A part may be read repeatedly.
    found: BTreeMap<Lost, (BTreeSet<(usize, usize)>, LoadError)>,
    /// The number of primitives, missing ones included.
    pub(crate) primitives: usize,
}

impl Losses {
    /// Records that the part of the file with this key is lost.
    pub(crate) fn add(&mut self, what: Lost, key: (usize, usize), reason: LoadError) {
        self.found.entry(what).or_insert_with(|| (BTreeSet::new(), reason)).0.insert(key);
    }

    /// Why the first shape is missing.
    pub(crate) fn shape(&self) -> Option<&LoadError> {
        self.found.iter().find(|(what, _)| what.is_shape()).map(|(_, (_, reason))| reason)
    }

    /// A sentence for each kind.
    pub(crate) fn sentences(self) -> impl Iterator<Item = String> {
        let primitives = self.primitives;
        self.found.into_iter().map(move |(what, (parts, reason))| {
            let (one, many) = what.sentences();
            match parts.len() {
                1 if what == Lost::Primitive && primitives > 1 => {
                    format!("1 of {primitives} primitives is missing: {reason}")
                }
                1 => format!("1 {one}: {reason}"),
                count if what == Lost::Primitive => {
                    format!("{count} of {primitives} {many}; the first: {reason}")
                }
                count => format!("{count} {many}; the first: {reason}"),
            }
        })
    }
}
