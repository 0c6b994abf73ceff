//! A scene as kernels read it: the bytes of every uniform and storage buffer that a run binds.

pub mod buffer;
mod error;
mod indices;
mod shading;
mod shading_indices;
mod traced;

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use raystep_scenes::Scene;

use crate::numbers::real::{Real, Vec3};
pub use crate::numbers::srgb::{linear_to_srgb, srgb_to_linear};
use crate::numbers::units::Units;
use crate::options::features::{Features, StructureKind};
use crate::options::samples::Samples;
use crate::options::{Options, RaySource};
use crate::shared::build::Build;
use crate::shared::bvh_walk::link_above;
use crate::shared::camera::Camera;
use crate::shared::constants::{LAST_ITEM, OUTSIDE};
use crate::shared::emitters::{Emission, Emitter};
use crate::shared::grid_walk::Grid;
use crate::shared::irregular_walk::{Irregular, IrregularCell};
use crate::shared::packed_triangles::PackedTriangle;
use crate::shared::photon_map::PhotonMap;
use crate::shared::samples::Sampling;
use crate::shared::scene::SceneInfo;
use crate::shared::shading::{Light, Material, Optics, Shading};
use crate::shared::texture::Texture;
use crate::structures::Structure;
use crate::structures::bvh::{BvhNode, WideNode};
use crate::structures::grid::Corners;
use crate::tables::stream::StreamData;
pub use error::SceneDataError;
use error::reserve;
pub use shading::BACKGROUND;
use shading::{background, emitters, flat_normal, lights, material, optics, textures};
pub(crate) use traced::as_f32;
use traced::packed_triangles;
pub(crate) use traced::{bvh_growth, origins, traced_vertices};
pub use traced::{traced_camera, traced_ray};

/// What kernels read of a scene, and the options that they are compiled with.
///
/// The contents are shared: a kernel with options of its own has a view of them that costs no copy.
#[derive(Clone, Default)]
pub struct SceneData {
    /// Options of the kernels.
    pub features: Features,
    contents: Arc<Contents>,
}

impl Deref for SceneData {
    type Target = Contents;

    fn deref(&self) -> &Contents {
        &self.contents
    }
}

impl DerefMut for SceneData {
    fn deref_mut(&mut self) -> &mut Contents {
        Arc::make_mut(&mut self.contents)
    }
}

/// For kernels without options.
impl From<Contents> for SceneData {
    fn from(contents: Contents) -> Self {
        Self::new(Features::default(), contents)
    }
}

/// The host's copy of all buffers and uniforms. Those that a run does not bind stay empty.
#[derive(Clone, Default)]
pub struct Contents {
    /// Streams that a run begins with, of a program that is given them without a scene.
    pub inputs: Vec<StreamData>,
    /// Conversion between scene units and traced units.
    pub units: Units,
    /// Uniform `build`.
    pub build: Build,
    /// Uniform `camera`.
    pub camera: Camera,
    /// Uniform `grid`.
    pub grid: Grid,
    /// Uniform `scene`.
    pub info: SceneInfo,
    /// Uniform `sampling`.
    pub sampling: Sampling,
    /// Uniform `shading`.
    pub shading: Shading,
    /// Nine per triangle, traced units.
    pub vertices: Vec<f32>,
    /// One per cell, and one more.
    pub grid_cells: Vec<u32>,
    /// Triangle ids.
    pub grid_items: Vec<u32>,
    /// One byte per cell, four cells per word: see [`crate::structures::grid::distances`].
    pub grid_distances: Vec<u32>,
    /// Triangles that an irregular grid which is being built sets aside; the other vertices are left out.
    pub set_aside: Vec<u32>,
    /// The voxel map of an irregular grid: see [`crate::structures::irregular`].
    pub irregular_map: Vec<u32>,
    /// The cells of an irregular grid.
    pub irregular_cells: Vec<IrregularCell>,
    /// Triangle ids; bit 31 marks the last of a list.
    pub irregular_items: Vec<u32>,
    /// Length of each list of an irregular grid, which no kernel reads.
    pub irregular_lengths: Vec<u32>,
    /// Growth of cells or boxes, in traced units; 0 for boxes that are grown as they are tested.
    pub growth: f32,
    /// The box of the corners that the structure was built for, in traced units.
    pub bounds: Corners,
    /// Bounds distances along an axis between these corners and ray origins, in traced units.
    pub reach: f32,
    /// Nodes of the binary BVH.
    pub bvh_nodes: Vec<BvhNode>,
    /// One per node.
    pub bvh_parents: Vec<u32>,
    /// Triangle ids.
    pub bvh_items: Vec<u32>,
    /// Nodes of the wide BVH.
    pub wide_nodes: Vec<WideNode>,
    /// Nodes on the longest path through the wide BVH.
    pub wide_depth: u32,
    /// Corners and ids as the fused kernel reads them.
    pub packed_triangles: Vec<PackedTriangle>,
    /// Nine per triangle.
    pub normals: Vec<f32>,
    /// Six per triangle.
    pub texcoords: Vec<f32>,
    /// Nine per triangle.
    pub vertex_colors: Vec<f32>,
    /// One per triangle.
    pub triangle_materials: Vec<u32>,
    /// At least one.
    pub materials: Vec<Material>,
    /// One per material.
    pub optics: Vec<Optics>,
    /// What gives light, as a path picks it.
    pub emitters: Vec<Emitter>,
    /// Uniform `emission`.
    pub emission: Emission,
    /// Uniform `photon_map`.
    pub photon_map: PhotonMap,
    /// At least one.
    pub lights: Vec<Light>,
    /// As many as materials refer to.
    pub textures: Vec<Texture>,
    /// Two words per texel.
    pub texels: Vec<u32>,
}

impl std::fmt::Debug for SceneData {
    /// Prints sizes only: a scene's contents would flood a log.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SceneData")
            .field("triangles", &self.info.triangles)
            .field("grid_cells", &self.grid_cells.len())
            .field("grid_items", &self.grid_items.len())
            .field("bvh_nodes", &self.bvh_nodes.len())
            .field("wide_nodes", &self.wide_nodes.len())
            .field("packed_triangles", &self.packed_triangles.len())
            .finish_non_exhaustive()
    }
}

impl SceneData {
    /// These contents, for kernels with options of the run.
    #[must_use]
    pub fn new(features: Features, contents: Contents) -> Self {
        Self { features, contents: Arc::new(contents) }
    }

    /// The same contents for kernels with other options.
    #[must_use]
    pub fn with(&self, features: Features) -> Self {
        Self { features, contents: self.contents.clone() }
    }

    /// The corners of a triangle.
    #[must_use]
    pub fn corners<R: Real>(&self, triangle: u32) -> [Vec3<R>; 3] {
        let first = 9 * triangle as usize;
        let v = &self.vertices[first..first + 9];
        [0, 3, 6].map(|c| Vec3::from_f32([v[c], v[c + 1], v[c + 2]]))
    }

    /// Start of the list of a cell or leaf, and its number of triangles; all triangles if there is neither grid nor
    /// BVH. One that there is not, as a user's kernel may name, has an empty list.
    #[must_use]
    pub fn list(&self, cell: u32) -> (u32, u32) {
        let at = cell as usize;
        let list = match self.features.structure() {
            StructureKind::None => Some((0, self.info.triangles)),
            StructureKind::Grid => {
                self.grid_cells.get(at).zip(self.grid_cells.get(at + 1)).map(|(first, end)| (*first, end - first))
            }
            StructureKind::Irregular => match self.irregular_lengths.get(at) {
                None | Some(0) => None,
                Some(length) => self.irregular_cells.get(at).map(|cell| (cell.first, *length)),
            },
            StructureKind::Bvh => self.bvh_nodes.get(at).map(|node| (node.first, node.count())),
        };
        list.unwrap_or_default()
    }

    /// The triangle at an index in the lists.
    #[must_use]
    pub fn listed(&self, place: u32) -> u32 {
        match self.features.structure() {
            StructureKind::None => place,
            StructureKind::Grid => self.grid_items[place as usize],
            StructureKind::Irregular => self.irregular_items[place as usize] & !LAST_ITEM,
            StructureKind::Bvh => self.bvh_items[place as usize],
        }
    }

    /// What a walk needs of the irregular grid.
    #[must_use]
    pub fn irregular(&self) -> Irregular<'_> {
        Irregular {
            grid: &self.grid,
            map: &self.irregular_map,
            cells: &self.irregular_cells,
            has_aside: self.features.aside,
        }
    }

    /// Whether a cell is the space around an irregular grid, which lists the triangles set aside.
    #[must_use]
    pub fn is_outside(&self, cell: u32) -> bool {
        self.features.irregular && self.features.aside && cell == OUTSIDE
    }

    /// Chessboard distance of an empty cell to the nearest one with a list; 0 for a cell with a list, or if no distances
    /// are known.
    #[must_use]
    pub fn empty_distance(&self, cell: u32) -> i32 {
        if !self.features.skip {
            return 0;
        }
        self.grid_distances.get(cell as usize / 4).map_or(0, |four| (four >> (8 * (cell % 4)) & 0xff) as i32)
    }

    /// The data of a run whose structure and features are decided: the buffers in `wanted`, and the structure. Each
    /// attribute of `scene` must have as many entries as there are triangles; `vertices` are its corners in traced
    /// units.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub(crate) fn of(
        scene: &Scene,
        options: &Options,
        features: Features,
        units: Units,
        (vertices, structure): (Vec<f32>, Structure),
        info: SceneInfo,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Self, SceneDataError> {
        let triangles = scene.triangles.len();
        let mut data = Self::new(features, Contents { units, info, vertices, ..Contents::default() });
        data.set_structure(structure);
        if wanted("camera")
            && let RaySource::Camera { camera, width, height } = &options.rays
        {
            data.camera = traced_camera(camera, units, *width, *height);
        }
        if wanted("sampling") {
            let Samples { count: samples, seed, first, .. } = options.samples;
            data.sampling = Sampling { samples, seed, first };
        }
        if wanted("packed_triangles") && data.packed_triangles.is_empty() {
            data.packed_triangles = packed_triangles(&data.vertices, features.bvh.then_some(&data.bvh_items));
        }
        if wanted("normals") {
            data.normals = reserve("normals", 9 * triangles)?;
            match &scene.normals {
                Some(normals) => data.normals.extend_from_slice(normals.as_flattened().as_flattened()),
                None => data.normals.extend(scene.triangles.iter().flat_map(|t| [flat_normal(t); 3]).flatten()),
            }
        }
        if wanted("texcoords") {
            data.texcoords = reserve("texcoords", 6 * triangles)?;
            match &scene.texcoords {
                Some(uv) => data.texcoords.extend_from_slice(uv.as_flattened().as_flattened()),
                None => data.texcoords.resize(6 * triangles, 0.0),
            }
        }
        if wanted("vertex_colors") {
            data.vertex_colors = reserve("vertex_colors", 9 * triangles)?;
            match &scene.colors {
                Some(colors) => data.vertex_colors.extend_from_slice(colors.as_flattened().as_flattened()),
                None => data.vertex_colors.resize(9 * triangles, 1.0),
            }
        }
        if wanted("triangle_materials") {
            data.triangle_materials.clone_from(&scene.triangle_materials);
        }
        if wanted("materials") {
            data.materials = scene.materials.iter().map(material).collect();
        }
        if wanted("optics") {
            data.optics = scene.materials.iter().map(|material| optics(material.optics)).collect();
        }
        if wanted("lights") || wanted("shading") {
            data.lights = lights(scene, options, units);
            data.shading = Shading { background: background(scene, options), lights: data.lights.len() as u32 };
        }
        if wanted("emitters") {
            (data.emitters, data.emission) = emitters(scene, options, &data.lights, &data.vertices)?;
        }
        if wanted("texels") {
            (data.textures, data.texels) = textures(&scene.textures)?;
        }
        Ok(data)
    }

    /// Replaces the camera, which must not require another structure, and the number of its rays.
    pub(crate) fn set_view(&mut self, scene: &Scene, options: &Options) {
        let RaySource::Camera { camera, width, height } = &options.rays else { return };
        self.camera = traced_camera(camera, self.units, *width, *height);
        (self.info.rays, self.info.size) = (width * height, [*width, *height]);
        // Without lights of its own, a scene is lit from the camera.
        if !self.lights.is_empty() {
            self.lights = lights(scene, options, self.units);
        }
    }

    fn set_structure(&mut self, structure: Structure) {
        match structure {
            Structure::None => {}
            Structure::Grid { data, distances } => {
                (self.grid, self.grid_cells, self.grid_items, self.growth) =
                    (data.grid, data.cells, data.items, data.growth);
                self.grid_distances = distances;
            }
            Structure::Irregular(data) => {
                (self.grid, self.growth, self.irregular_lengths) = (data.grid, data.growth, data.lengths);
                (self.irregular_map, self.irregular_cells, self.irregular_items) = (data.map, data.cells, data.items);
            }
            Structure::Bvh(data) => {
                self.bvh_parents = data.parents.iter().map(|&p| link_above(&data.nodes, p)).collect();
                (self.bvh_nodes, self.bvh_items, self.growth) = (data.nodes, data.items, data.padding.growth());
            }
            Structure::Wide(data) => {
                (self.wide_nodes, self.packed_triangles, self.growth) =
                    (data.nodes, data.triangles, data.padding.growth());
                self.wide_depth = data.depth;
            }
        }
    }
}
