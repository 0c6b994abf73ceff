//! What OBJ, PLY and STL have in common: vertices and polygons, which become a [`Scene`].
//!
//! These formats say little about surfaces, so the scene has one light grey material, double-sided because windings in
//! such files are unreliable, and neither lights nor cameras. Normals, texture coordinates and vertex colours are used
//! if present. A reader stores what the file says, right or wrong; what cannot be drawn is left out here, and counted
//! in the notes.

use super::budget::Budget;
use super::notes::{Notes, Wrong};
use super::place::{flat_normal, unit};
use super::polygon::Polygons;
use super::{LoadError, at};
use crate::{Material, Note, Scene, offset_for};
use glam::DVec3;

/// The index of an attribute that a corner does not have.
pub(super) const NONE: u32 = u32::MAX;
/// An index that the file gives, but that no entry can have.
pub(super) const MISSING: u32 = u32::MAX - 1;

/// Where memory for triangles is refused.
const TRIANGLES: &str = "triangles";

/// A part of a colour above this is not a rounded 1: it is of 0 to 255.
const ABOVE_ONE: f32 = 1.01;

/// The vertices and polygons of a file. Numbers that the file does not have are NaN.
pub(super) struct Mesh<'a> {
    budget: &'a Budget,
    pub(super) notes: Notes,
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) texcoords: Vec<[f32; 2]>,
    /// Encoded as sRGB, parallel to `positions`; empty if there are none.
    pub(super) colors: Vec<Option<[f32; 3]>>,
    /// The value of a full colour, by channel.
    pub(super) full: [f32; 3],
    /// Of each corner, its position.
    corners: Vec<u32>,
    /// Of each corner, its normal and its texture coordinates, if it may have others than its vertex. Corners at the end
    /// that have none may be left out.
    normal_of: Vec<u32>,
    texcoord_of: Vec<u32>,
    attributes_of: AttributesOf,
    /// How many corners each face has.
    sizes: Vec<u32>,
}

/// What attributes belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum AttributesOf {
    Vertices,
    Corners,
}

/// A corner of a face, as indices; of the attributes, [`NONE`] means none.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) normal: u32,
    pub(super) texcoord: u32,
}

/// Why a face is not drawn.
#[derive(Clone, Copy)]
pub(super) enum Fault {
    /// It has fewer than three corners.
    Short,
    /// This corner, counted from 1, has a vertex that does not exist.
    Missing(usize),
    /// The position of this corner, counted from 1, is not finite in f32.
    NotFinite(usize),
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Short => f.write_str("it has fewer than 3 corners"),
            Self::Missing(corner) => write!(f, "its corner {corner} is no vertex of the file"),
            Self::NotFinite(corner) => write!(f, "the position of its corner {corner} is not finite in 32 bits"),
        }
    }
}

/// What is known of a mesh before its triangles are made.
struct Survey {
    min: DVec3,
    max: DVec3,
    /// At most so many triangles.
    triangles: u64,
    has_normals: bool,
    has_texcoords: bool,
    has_colors: bool,
    /// The first face that cannot be drawn, counted from 0.
    first: Option<(usize, Fault)>,
}

impl<'a> Mesh<'a> {
    pub(super) fn new(attributes_of: AttributesOf, budget: &'a Budget) -> Self {
        Self {
            budget,
            attributes_of,
            notes: Notes::default(),
            positions: Vec::new(),
            normals: Vec::new(),
            texcoords: Vec::new(),
            colors: Vec::new(),
            full: [1.0; 3],
            corners: Vec::new(),
            normal_of: Vec::new(),
            texcoord_of: Vec::new(),
            sizes: Vec::new(),
        }
    }

    /// Reserves space for the first vertices.
    pub(super) fn reserve_vertices(&mut self, count: u64) -> Result<(), LoadError> {
        if self.positions.is_empty() {
            self.positions = self.budget.vec(count, "vertices")?;
        }
        Ok(())
    }

    /// Reserves space for the first faces.
    pub(super) fn reserve_faces(&mut self, count: u64) -> Result<(), LoadError> {
        if self.sizes.is_empty() {
            self.sizes = self.budget.vec(count, "faces")?;
        }
        Ok(())
    }

    pub(super) fn position(&mut self, position: [f64; 3]) -> Result<(), LoadError> {
        self.budget.push(&mut self.positions, position, "vertices")
    }

    /// The colour of the position that was added last.
    pub(super) fn color(&mut self, color: [f32; 3]) -> Result<(), LoadError> {
        while self.colors.len() + 1 < self.positions.len() {
            self.budget.push(&mut self.colors, None, "vertex colours")?;
        }
        self.budget.push(&mut self.colors, Some(color), "vertex colours")
    }

    pub(super) fn normal(&mut self, normal: [f32; 3]) -> Result<(), LoadError> {
        self.budget.push(&mut self.normals, normal, "normals")
    }

    pub(super) fn texcoord(&mut self, texcoord: [f32; 2]) -> Result<(), LoadError> {
        self.budget.push(&mut self.texcoords, texcoord, "texture coordinates")
    }

    /// A corner whose attributes are those of its vertex.
    pub(super) fn vertex(&mut self, position: u32) -> Result<(), LoadError> {
        self.budget.push(&mut self.corners, position, "faces")
    }

    /// A corner with attributes of its own.
    pub(super) fn corner(&mut self, corner: Corner) -> Result<(), LoadError> {
        let lists = [(&mut self.normal_of, corner.normal), (&mut self.texcoord_of, corner.texcoord)];
        for (list, index) in lists.into_iter().filter(|(_, index)| *index != NONE) {
            while list.len() < self.corners.len() {
                self.budget.push(list, NONE, "faces")?;
            }
            self.budget.push(list, index, "faces")?;
        }
        self.vertex(corner.position)
    }

    /// Ends a face of this many corners.
    pub(super) fn face(&mut self, corners: u64) -> Result<(), LoadError> {
        let size = u32::try_from(corners).map_err(|_| at("faces", format!("one has {corners} corners")))?;
        self.budget.push(&mut self.sizes, size, "faces")
    }

    /// Decides whether colours given as floats, whose full value cannot be seen, are of 0 to 1 or of 0 to 255.
    pub(super) fn guess_full(&mut self, channels: [bool; 3]) {
        let parts = || self.colors.iter().flatten().flat_map(|c| c.iter().zip(channels));
        // What is far beyond is no evidence.
        let most = parts().filter(|(v, is_float)| *is_float && **v <= 255.0).map(|(v, _)| *v).fold(0.0, f32::max);
        if most > ABOVE_ONE {
            self.full_is_255(channels, most);
        }
    }

    /// Reads these channels of colours as 0 to 255, since this is their largest value.
    pub(super) fn full_is_255(&mut self, channels: [bool; 3], most: f32) {
        self.notes.add(format!("vertex colours are read as 0 to 255, since the largest is {most}"));
        for (full, is_meant) in self.full.iter_mut().zip(channels) {
            if is_meant {
                *full = 255.0;
            }
        }
    }

    /// Why a face of these corners cannot be drawn.
    fn fault(&self, face: &[u32]) -> Option<Fault> {
        if face.len() < 3 {
            return Some(Fault::Short);
        }
        face.iter().zip(1..).find_map(|(&index, corner)| match self.positions.get(index as usize) {
            None => Some(Fault::Missing(corner)),
            Some(position) => (!is_finite(position)).then_some(Fault::NotFinite(corner)),
        })
    }

    /// The faces with the range of their corners, and why they cannot be drawn.
    fn faces(&self) -> impl Iterator<Item = (std::ops::Range<usize>, Option<Fault>)> {
        let mut start = 0;
        self.sizes.iter().map(move |&size| {
            let range = start..start + size as usize;
            start = range.end;
            let fault = self.fault(self.corners.get(range.clone()).unwrap_or_default());
            (range, fault)
        })
    }

    /// The corner at this place.
    fn at(&self, corner: usize) -> Corner {
        let position = self.corners.get(corner).copied().unwrap_or(NONE);
        let of = |list: &[u32], is_given: bool| match self.attributes_of {
            AttributesOf::Corners => list.get(corner).copied().unwrap_or(NONE),
            AttributesOf::Vertices if is_given => position,
            AttributesOf::Vertices => NONE,
        };
        Corner {
            position,
            normal: of(&self.normal_of, !self.normals.is_empty()),
            texcoord: of(&self.texcoord_of, !self.texcoords.is_empty()),
        }
    }

    /// Counts what is wrong and what can be drawn.
    fn survey(&mut self) -> Survey {
        let (min, max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut survey =
            Survey { min, max, triangles: 0, has_normals: false, has_texcoords: false, has_colors: false, first: None };
        let [mut short, mut missing, mut not_finite, mut no_normal, mut no_texcoord] = [0; 5];
        for (face, (range, fault)) in self.faces().enumerate() {
            match fault {
                Some(Fault::Short) => short += 1,
                Some(Fault::Missing(_)) => missing += 1,
                Some(Fault::NotFinite(_)) => not_finite += 1,
                None => survey.triangles += range.len() as u64 - 2,
            }
            if let Some(fault) = fault {
                survey.first = survey.first.or(Some((face, fault)));
                continue;
            }
            for corner in range.map(|corner| self.at(corner)) {
                let position = self.positions.get(corner.position as usize).copied().unwrap_or_default();
                survey.min = survey.min.min(DVec3::from(position));
                survey.max = survey.max.max(DVec3::from(position));
                let has_normal = (corner.normal as usize) < self.normals.len();
                let has_texcoord = (corner.texcoord as usize) < self.texcoords.len();
                no_normal += usize::from(!has_normal && corner.normal != NONE);
                no_texcoord += usize::from(!has_texcoord && corner.texcoord != NONE);
                survey.has_normals |= has_normal;
                survey.has_texcoords |= has_texcoord;
                survey.has_colors |= matches!(self.colors.get(corner.position as usize), Some(Some(_)));
            }
        }
        let counts = [
            (Wrong::Positions, self.positions.iter().filter(|p| !is_finite(p)).count()),
            (Wrong::FacesShort, short),
            (Wrong::FacesMissing, missing),
            (Wrong::FacesNotFinite, not_finite),
            (Wrong::Normals, self.normals.iter().filter(|n| direction(n).is_none()).count()),
            (Wrong::NormalsMissing, no_normal),
            (Wrong::Texcoords, self.texcoords.iter().filter(|t| !t.iter().all(|v| v.is_finite())).count()),
            (Wrong::TexcoordsMissing, no_texcoord),
            (Wrong::Colors, self.colors.iter().flatten().filter(|c| c.iter().any(|v| v.is_nan())).count()),
            (Wrong::ColorsClamped, self.colors.iter().flatten().filter(|c| self.is_outside(c)).count()),
        ];
        for (what, count) in counts {
            self.notes.found(what, 0, count);
        }
        survey
    }

    fn is_outside(&self, color: &[f32; 3]) -> bool {
        color.iter().zip(self.full).any(|(&part, full)| part < 0.0 || part / full > ABOVE_ONE)
    }

    /// The scene of these faces. `nothing` is the error for a mesh of which nothing can be drawn, given its first face
    /// that has a fault, counted from 0.
    pub(super) fn scene(
        mut self,
        nothing: impl FnOnce(Option<(usize, Fault)>) -> LoadError,
    ) -> Result<Scene, LoadError> {
        let survey = self.survey();
        if survey.triangles == 0 {
            return Err(nothing(survey.first));
        }
        if survey.triangles >= u64::from(u32::MAX) {
            let problem = format!("they have {} triangles; expected fewer than {}", survey.triangles, u32::MAX);
            return Err(at("faces", problem));
        }
        let grey = Material {
            name: "light grey".to_owned(),
            base_color: [0.73; 3],
            double_sided: true,
            ..Material::default()
        };
        let (count, path) = (survey.triangles, TRIANGLES);
        let mut scene = Scene {
            offset: offset_for(survey.min, survey.max),
            triangles: self.budget.vec(count, path)?,
            normals: survey.has_normals.then(|| self.budget.vec(count, path)).transpose()?,
            texcoords: survey.has_texcoords.then(|| self.budget.vec(count, path)).transpose()?,
            colors: survey.has_colors.then(|| self.budget.vec(count, path)).transpose()?,
            triangle_materials: self.budget.vec(count, path)?,
            materials: vec![grey],
            ..Scene::default()
        };
        let mut polygons = Polygons::default();
        let mut outline = Vec::new();
        for range in self.faces().filter_map(|(range, fault)| fault.is_none().then_some(range)) {
            let (start, size) = (range.start, range.len());
            if size == 3 {
                self.triangle([start, start + 1, start + 2], &mut scene)?;
                continue;
            }
            outline.clear();
            for corner in range {
                let position = self.placed(self.at(corner).position, scene.offset).map(f64::from);
                self.budget.push(&mut outline, DVec3::from(position), "a face")?;
            }
            for triangle in polygons.triangles(&outline, self.budget) {
                self.triangle(triangle.map(|corner| start + corner as usize), &mut scene)?;
            }
        }
        self.notes.found(Wrong::PolygonsImproper, 0, polygons.improper);
        self.notes.found(Wrong::PolygonsNotPlanar, 0, polygons.not_planar);
        scene.notes = self.notes.into_vec().into_iter().map(Note).collect();
        Ok(scene)
    }

    /// A position of the scene, rounded once.
    fn placed(&self, index: u32, offset: DVec3) -> [f32; 3] {
        let position = self.positions.get(index as usize).copied().unwrap_or_default();
        (DVec3::from(position) - offset).as_vec3().to_array()
    }

    /// Adds the triangle of these corners.
    fn triangle(&self, corners: [usize; 3], scene: &mut Scene) -> Result<(), LoadError> {
        let (budget, path) = (self.budget, TRIANGLES);
        let corners = corners.map(|corner| self.at(corner));
        let triangle = corners.map(|corner| self.placed(corner.position, scene.offset));
        if let Some(normals) = &mut scene.normals {
            let normal = |corner: Corner| self.normals.get(corner.normal as usize).and_then(direction);
            let of_corners = corners.map(|corner| normal(corner).unwrap_or_else(|| flat_normal(triangle)));
            budget.push(normals, of_corners, path)?;
        }
        if let Some(texcoords) = &mut scene.texcoords {
            let texcoord = |corner: Corner| self.texcoords.get(corner.texcoord as usize).copied().unwrap_or_default();
            let of_corners = corners.map(|corner| texcoord(corner).map(|v| if v.is_finite() { v } else { 0.0 }));
            budget.push(texcoords, of_corners, path)?;
        }
        if let Some(colors) = &mut scene.colors {
            let color = |corner: Corner| self.colors.get(corner.position as usize).copied().flatten();
            let of_corners = corners.map(|corner| color(corner).map_or([1.0; 3], |color| self.linear(color)));
            budget.push(colors, of_corners, path)?;
        }
        budget.push(&mut scene.triangle_materials, 0, path)?;
        budget.push(&mut scene.triangles, triangle, path)
    }

    /// A colour of the file as linear parts of 0 to 1. What is no number becomes 1.
    fn linear(&self, color: [f32; 3]) -> [f32; 3] {
        let [r, g, b] = color;
        let [full_r, full_g, full_b] = self.full;
        [r / full_r, g / full_g, b / full_b].map(linear)
    }
}

/// Whether a position can be one of a scene.
fn is_finite(position: &[f64; 3]) -> bool {
    position.iter().all(|&v| (v as f32).is_finite())
}

/// The unit vector along a normal.
fn direction(normal: &[f32; 3]) -> Option<[f32; 3]> {
    unit(DVec3::from(normal.map(f64::from)))
}

/// sRGB in [0, 1] to linear (IEC 61966-2-1). The formats' colours usually come from 8-bit tools.
fn linear(encoded: f32) -> f32 {
    let c = if encoded.is_nan() { 1.0 } else { encoded.clamp(0.0, 1.0) };
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
