//! Items that only some scenes need, and the set of those that a plan keeps nevertheless.

use crate::numbers::named::named;
use crate::options::features::Features;

/// Something that only some scenes, or views of them, need. For the others, the plan omits its code and its buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Item {
    /// Rays are clipped to the grid: not needed if all of them start inside it.
    Clipping,
    /// Boxes of the BVH are grown as they are tested: not needed if what the scene's reach requires hardly enlarges them.
    RayPadding,
    /// Vertex normals.
    Normals,
    /// Base colour textures with their coordinates.
    Textures,
    /// Vertex colours.
    VertexColors,
    /// More than one material: an index for each triangle.
    ManyMaterials,
    /// Emitted light.
    Emission,
    /// Materials that are shaded on both sides.
    DoubleSided,
    /// More than one light.
    ManyLights,
    /// Directional lights.
    DirectionalLights,
    /// Spot lights.
    SpotLights,
}

named!(
    Item,
    "clipping, ray-padding, normals, textures, vertex-colors, many-materials, emission, double-sided, many-lights, \
     directional-lights, spot-lights",
    Clipping "clipping",
    RayPadding "ray-padding",
    Normals "normals",
    Textures "textures",
    VertexColors "vertex-colors",
    ManyMaterials "many-materials",
    Emission "emission",
    DoubleSided "double-sided",
    ManyLights "many-lights",
    DirectionalLights "directional-lights",
    SpotLights "spot-lights"
);

/// A set of [`Item`]s that a plan keeps even if the scene does not need them, to measure what omitting them saves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Keep(u16);

impl Keep {
    /// Only what the scene needs.
    pub const NONE: Self = Self(0);
    /// Every item.
    pub const ALL: Self = {
        let mut all = 0;
        let mut i = 0;
        while i < Item::ALL.len() {
            all |= 1 << Item::ALL[i] as u16;
            i += 1;
        }
        Self(all)
    };

    /// One item, and otherwise what the scene needs.
    #[must_use]
    pub const fn only(item: Item) -> Self {
        Self(1 << item as u16)
    }

    /// [`ALL`](Self::ALL) with `--keep-all`, else [`NONE`](Self::NONE).
    #[must_use]
    pub const fn all_if(is_asked: bool) -> Self {
        if is_asked { Self::ALL } else { Self::NONE }
    }

    /// Whether an item is kept.
    #[must_use]
    pub const fn has(self, item: Item) -> bool {
        self.0 & Self::only(item).0 != 0
    }
}

/// As the option `--keep-all`: whether everything is kept.
#[cfg(feature = "serde")]
impl serde::Serialize for Keep {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bool(*self == Self::ALL)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Keep {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        bool::deserialize(deserializer).map(Self::all_if)
    }
}

impl Features {
    /// Whether kernels with these options have an item.
    #[must_use]
    pub fn has(&self, item: Item) -> bool {
        match item {
            Item::Clipping => self.clip,
            Item::RayPadding => self.ray_padding,
            Item::Normals => self.normals,
            Item::Textures => self.textures,
            Item::VertexColors => self.vertex_colors,
            Item::ManyMaterials => self.many_materials,
            Item::Emission => self.emissive,
            Item::DoubleSided => self.double_sided,
            Item::ManyLights => self.many_lights,
            Item::DirectionalLights => self.directional_lights,
            Item::SpotLights => self.spot_lights,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_have_none_one_or_all() {
        for &item in Item::ALL {
            assert!(Keep::ALL.has(item) && !Keep::NONE.has(item));
            let one = Keep::only(item);
            assert_eq!(Item::ALL.iter().filter(|&&other| one.has(other)).collect::<Vec<_>>(), [&item]);
        }
        assert_eq!((Keep::all_if(true), Keep::all_if(false)), (Keep::ALL, Keep::default()));
    }
}
