//! A scene as kernels read it: the bytes of every uniform and storage buffer that a run binds.

use bytemuck::cast_slice;
use raystep_scenes::{Camera as SceneCamera, Light as SceneLight, Projection, Scene, Texture as SceneTexture, Wrap};

use crate::bvh::{self, BvhNode, BvhOptions, BvhQuality, WideContent, WideNode};
use crate::features::Features;
use crate::generate::Camera;
use crate::grid::{self, GridData, GridSize};
use crate::intersect::SceneInfo;
use crate::options::{Options, Ray, RaySource, ScheduleKind};
use crate::plan::PlanError;
use crate::real::{Real, Vec3};
use crate::shade::{DIRECTIONAL, Light, Material, NO_TEXTURE, POINT, SPOT, Shading};
use crate::shared::bvh_walk::link_above;
use crate::shared::grid_walk::Grid;
use crate::shared::texture::Texture;
use crate::units::{Units, exp2, floor_log2};

/// Linear colour of rays that hit nothing.
pub const BACKGROUND: [f32; 3] = [0.015, 0.018, 0.024];

/// Host side of everything that is bound. What a run does not bind stays empty.
#[derive(Clone, Default)]
pub struct SceneData {
    /// The options decided.
    pub features: Features,
    /// Scene units and traced units.
    pub units: Units,
    /// Uniform `camera`.
    pub camera: Camera,
    /// Uniform `grid`.
    pub grid: Grid,
    /// Uniform `scene`.
    pub info: SceneInfo,
    /// Uniform `shading`.
    pub shading: Shading,
    /// Nine a triangle, traced units.
    pub vertices: Vec<f32>,
    /// One a cell and one more.
    pub grid_cells: Vec<u32>,
    /// Triangle ids.
    pub grid_items: Vec<u32>,
    /// Four cells a word, a byte each: see [`crate::grid::distances`].
    pub grid_distances: Vec<u32>,
    /// What cells and boxes were grown by, traced units.
    pub growth: f32,
    /// The binary tree.
    pub bvh_nodes: Vec<BvhNode>,
    /// One a node.
    pub bvh_parents: Vec<u32>,
    /// Triangle ids.
    pub bvh_items: Vec<u32>,
    /// The wide tree.
    pub wide_nodes: Vec<WideNode>,
    /// Nodes on the longest way through it.
    pub wide_depth: u32,
    /// Corners and ids as the fused kernel reads them.
    pub packed_triangles: Vec<[u32; 12]>,
    /// Nine a triangle.
    pub normals: Vec<f32>,
    /// Six a triangle.
    pub texcoords: Vec<f32>,
    /// Nine a triangle.
    pub vertex_colors: Vec<f32>,
    /// One a triangle.
    pub triangle_materials: Vec<u32>,
    /// At least one.
    pub materials: Vec<Material>,
    /// At least one.
    pub lights: Vec<Light>,
    /// As many as materials refer to.
    pub textures: Vec<Texture>,
    /// Two words a texel.
    pub texels: Vec<u32>,
}

impl std::fmt::Debug for SceneData {
    /// Sizes only: the contents of a scene fill no log.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut sizes = f.debug_struct("SceneData");
        for info in crate::buffer::BUFFERS {
            sizes.field(info.name, &self.bytes(info.name).map_or(0, <[u8]>::len));
        }
        sizes.finish()
    }
}

impl SceneData {
    /// The corners of a triangle.
    #[must_use]
    pub fn corners<R: Real>(&self, triangle: u32) -> [Vec3<R>; 3] {
        let first = 9 * triangle as usize;
        let v = &self.vertices[first..first + 9];
        [0, 3, 6].map(|c| Vec3::from_f32([v[c], v[c + 1], v[c + 2]]))
    }

    /// Where the list of a cell or leaf begins, and how many triangles it has; all triangles where there is
    /// neither grid nor tree.
    #[must_use]
    pub fn list(&self, cell: u32) -> (u32, u32) {
        if self.features.grid {
            let first = self.grid_cells[cell as usize];
            (first, self.grid_cells[cell as usize + 1] - first)
        } else if self.features.bvh {
            let node = &self.bvh_nodes[cell as usize];
            (node.first, node.count())
        } else {
            (0, self.info.triangles)
        }
    }

    /// The triangle at a place of the lists.
    #[must_use]
    pub fn listed(&self, place: u32) -> u32 {
        if self.features.grid {
            self.grid_items[place as usize]
        } else if self.features.bvh {
            self.bvh_items[place as usize]
        } else {
            place
        }
    }

    /// Whether every index that the fused kernel follows stays within what it points into: what a shader
    /// without bounds checks relies on.
    #[must_use]
    pub fn indices_hold(&self) -> bool {
        let entries = self.packed_triangles.len();
        if self.features.grid {
            let cells = self.grid.cells.iter().map(|&n| n as usize).product::<usize>();
            let lists = self.grid_cells.len() == cells + 1
                && self.grid_cells.is_sorted()
                && self.grid_cells.last().is_some_and(|&end| end as usize <= self.grid_items.len());
            return lists
                && self.grid_items.iter().all(|&item| (item as usize) < entries)
                && (!self.features.skip || 4 * self.grid_distances.len() >= cells);
        }
        if self.features.bvh {
            let within = |content| match content {
                WideContent::Inner(node) => (node as usize) < self.wide_nodes.len(),
                WideContent::Leaf { first, count } => (first + count) as usize <= entries,
            };
            let holds = |node: &WideNode| (0..8).filter_map(|slot| node.content(slot)).all(within);
            return !self.wide_nodes.is_empty()
                && self.wide_depth <= self.features.stack + 1
                && self.wide_nodes.iter().all(holds);
        }
        self.info.triangles as usize <= entries
    }

    /// Chessboard distance of an empty cell to the nearest one with a list; 0 for a cell with a list.
    #[must_use]
    pub fn empty_distance(&self, cell: u32) -> i32 {
        (self.grid_distances[cell as usize / 4] >> (8 * (cell % 4)) & 0xff) as i32
    }

    /// The bytes of a buffer, by name; a storage buffer that would be empty gets 16 zero bytes, since
    /// nothing can be bound to nothing. `None` for a name that the table does not have.
    #[must_use]
    pub fn bytes(&self, name: &str) -> Option<&[u8]> {
        const EMPTY: &[u8] = &[0; 80];
        let bytes: &[u8] = match name {
            "camera" => bytemuck::bytes_of(&self.camera),
            "grid" => bytemuck::bytes_of(&self.grid),
            "scene" => bytemuck::bytes_of(&self.info),
            "shading" => bytemuck::bytes_of(&self.shading),
            "vertices" => cast_slice(&self.vertices),
            "grid_cells" => cast_slice(&self.grid_cells),
            "grid_items" => cast_slice(&self.grid_items),
            "grid_distances" => cast_slice(&self.grid_distances),
            "bvh_nodes" => cast_slice(&self.bvh_nodes),
            "bvh_parents" => cast_slice(&self.bvh_parents),
            "bvh_items" => cast_slice(&self.bvh_items),
            "wide_nodes" => cast_slice(&self.wide_nodes),
            "packed_triangles" => cast_slice(&self.packed_triangles),
            "normals" => cast_slice(&self.normals),
            "texcoords" => cast_slice(&self.texcoords),
            "vertex_colors" => cast_slice(&self.vertex_colors),
            "triangle_materials" => cast_slice(&self.triangle_materials),
            "materials" => cast_slice(&self.materials),
            "lights" => cast_slice(&self.lights),
            "textures" => cast_slice(&self.textures),
            "texels" => cast_slice(&self.texels),
            _ => return None,
        };
        Some(if bytes.is_empty() { EMPTY } else { bytes })
    }

    /// The triangles in traced units, and the structure that `features` name: what the rest of the plan
    /// depends on.
    ///
    /// # Errors
    /// Where it cannot be built.
    pub(crate) fn accelerate(
        scene: &Scene,
        options: &Options,
        features: &Features,
        units: Units,
        storage_bytes: u64,
    ) -> Result<Self, PlanError> {
        let mut data = Self { units, ..Self::default() };
        data.info.triangles = scene.triangles.len() as u32;
        data.info.steps = options.steps_per_pass;
        data.vertices = traced_vertices(scene, units);
        let most_words = storage_bytes / 4;
        if features.grid {
            let reach = reach(&data.vertices, options, units);
            data.set_grid(grid::build(&data.vertices, options.grid, reach, most_words)?);
        }
        if features.bvh {
            data.growth = bvh_growth(reach(&data.vertices, options, units));
            let how = BvhOptions { most_words, quality: BvhQuality::for_triangles(scene.triangles.len() as u64) };
            if options.schedule == ScheduleKind::Fused {
                let built = bvh::build_wide(&data.vertices, data.growth, &how)?;
                (data.wide_nodes, data.packed_triangles) = (built.nodes, built.triangles);
                data.wide_depth = built.depth;
            } else {
                let built = bvh::build(&data.vertices, data.growth, &how)?;
                data.bvh_parents = built.parents.iter().map(|&p| link_above(&built.nodes, p)).collect();
                (data.bvh_nodes, data.bvh_items) = (built.nodes, built.items);
            }
        }
        Ok(data)
    }

    /// Prepares leaps: a finer grid where its resolution was left to us, and how far each empty cell is from the
    /// next list; see [`crate::grid::distances`].
    ///
    /// # Errors
    /// Where the grid cannot be built.
    pub(crate) fn prepare_leaps(&mut self, options: &Options, storage_bytes: u64) -> Result<(), PlanError> {
        if options.grid == GridSize::Auto {
            let reach = reach(&self.vertices, options, self.units);
            self.set_grid(grid::build_for_leaps(&self.vertices, reach, storage_bytes / 4)?);
        }
        self.grid_distances = grid::distances(&self.grid, &self.grid_cells);
        Ok(())
    }

    fn set_grid(&mut self, built: GridData) {
        (self.grid, self.grid_cells, self.grid_items, self.growth) =
            (built.grid, built.cells, built.items, built.growth);
    }

    /// Fills what `wanted` names. `scene` must have as many entries per attribute as triangles.
    pub(crate) fn fill(
        &mut self,
        scene: &Scene,
        options: &Options,
        features: Features,
        units: Units,
        wanted: impl Fn(&str) -> bool,
    ) {
        let data = self;
        data.features = features;
        if wanted("camera")
            && let RaySource::Camera { camera, width, height } = &options.rays
        {
            data.camera = traced_camera(camera, units, *width, *height);
        }
        if wanted("packed_triangles") && data.packed_triangles.is_empty() {
            data.packed_triangles = packed_triangles(&data.vertices, features.bvh.then_some(&data.bvh_items));
        }
        if wanted("normals") {
            data.normals = match &scene.normals {
                Some(normals) => normals.as_flattened().as_flattened().to_vec(),
                None => scene.triangles.iter().flat_map(|t| [flat_normal(t); 3]).flatten().collect(),
            };
        }
        if wanted("texcoords") {
            data.texcoords = match &scene.texcoords {
                Some(uv) => uv.as_flattened().as_flattened().to_vec(),
                None => vec![0.0; 6 * scene.triangles.len()],
            };
        }
        if wanted("vertex_colors") {
            data.vertex_colors = match &scene.colors {
                Some(colors) => colors.as_flattened().as_flattened().to_vec(),
                None => vec![1.0; 9 * scene.triangles.len()],
            };
        }
        if wanted("triangle_materials") {
            data.triangle_materials.clone_from(&scene.triangle_materials);
        }
        if wanted("materials") {
            data.materials = scene.materials.iter().map(material).collect();
        }
        if wanted("lights") {
            data.lights = lights(scene, options, units);
            data.shading = Shading { background: BACKGROUND, lights: data.lights.len() as u32 };
        }
        if wanted("texels") {
            (data.textures, data.texels) = textures(&scene.textures);
        }
    }
}

/// What boxes of a tree are grown by, in traced units: as much as the grid's cells, and 24 roundings for the
/// slab test. Its planes lie at `q * (2^e / d) + (p - o) / d`: 7 roundings of the distance to the node's
/// corner, 6 of the distance from there, and 1 of the sum; both distances are below `reach`, the
/// second one twice at most, since the planes' spacing is the next power of two.
fn bvh_growth(reach: f32) -> f32 {
    grid::growth(reach) * (64.0 / 40.0)
}

/// Corners and ids of all triangles, or of those listed.
fn packed_triangles(vertices: &[f32], items: Option<&Vec<u32>>) -> Vec<[u32; 12]> {
    // The tree of an empty scene has a leaf that nothing enters.
    let items = items.filter(|_| !vertices.is_empty());
    let mut packed = vec![[0; 12]; items.map_or(vertices.len() / 9, Vec::len)];
    crate::parallel::for_chunks(&mut packed, 1 << 14, |first, piece| {
        for (i, to) in piece.iter_mut().enumerate() {
            let id = items.map_or((first + i) as u32, |items| items[first + i]);
            let from = &vertices[9 * id as usize..9 * id as usize + 9];
            let v = |k: usize| from[k].to_bits();
            *to = [v(0), v(1), v(2), id, v(3), v(4), v(5), 0, v(6), v(7), v(8), 0];
        }
    });
    packed
}

fn traced_vertices(scene: &Scene, units: Units) -> Vec<f32> {
    let mut vertices = scene.triangles.as_flattened().as_flattened().to_vec();
    let scale = units.scale();
    if scale != 1.0 {
        crate::parallel::for_chunks(&mut vertices, 1 << 16, |_, piece| {
            for v in piece {
                *v = (f64::from(*v) * scale) as f32;
            }
        });
    }
    vertices
}

/// The camera as the kernel has it. The view plane lies at distance 1, whatever the units.
#[must_use]
pub fn traced_camera(camera: &SceneCamera, units: Units, width: u32, height: u32) -> Camera {
    let aspect = f64::from(width) / f64::from(height);
    let (half_height, forward) = match camera.projection {
        Projection::Perspective { vertical_fov } => ((vertical_fov * 0.5).tan(), camera.forward),
        Projection::Orthographic { half_height } => (half_height * units.scale(), camera.forward),
    };
    let to_f32 = |v: glam::DVec3| v.as_vec3().to_array();
    Camera {
        eye: camera.eye.to_array().map(|v| units.to_traced_f64(v)),
        pixel_x: (2.0 / f64::from(width)) as f32,
        right: to_f32(camera.right * (half_height * aspect)),
        pixel_y: (2.0 / f64::from(height)) as f32,
        up: to_f32(camera.up * half_height),
        forward: to_f32(forward),
        ..Camera::default()
    }
}

/// A ray in traced units: the origin scaled, the direction scaled by a power of two of its own so that
/// its largest component lies in [1, 2). Also the exponent k of the scene's t: `t_scene = t_traced * 2^k`.
#[must_use]
pub fn traced_ray(ray: &Ray, units: Units) -> (Ray, i32) {
    let origin = ray.origin.map(|v| units.to_traced(v));
    let largest = ray.direction.iter().fold(0.0f32, |m, d| m.max(d.abs()));
    let exponent = if largest > 0.0 && largest.is_finite() { -floor_log2(f64::from(largest)) } else { 0 };
    let direction = ray.direction.map(|v| (f64::from(v) * exp2(exponent)) as f32);
    let unit = floor_log2(units.scene_units_per_stream_unit());
    (Ray { origin, direction }, unit + exponent)
}

/// Bounds every coordinate of corners and origins and the distances between them, in traced units; a
/// power of two, so that a small move of the camera does not change the grid.
fn reach(vertices: &[f32], options: &Options, units: Units) -> f32 {
    let largest_of = |values: &[f32]| values.iter().fold(0.0f32, |m, v| m.max(v.abs()));
    let scene = crate::parallel::map_ranges(vertices.len(), 1 << 18, |range| largest_of(&vertices[range]));
    let scene = largest_of(&scene);
    let origins = match &options.rays {
        RaySource::Camera { camera, width, height } => {
            let c = traced_camera(camera, units, *width, *height);
            let spread = match camera.projection {
                Projection::Perspective { .. } => 0.0,
                Projection::Orthographic { .. } => largest_of(&c.right) + largest_of(&c.up),
            };
            largest_of(&c.eye) + spread
        }
        RaySource::Given(rays) => rays.iter().map(|r| largest_of(&traced_ray(r, units).0.origin)).fold(0.0, f32::max),
    };
    let distance = f64::from(scene) + f64::from(origins);
    exp2(floor_log2(distance.clamp(1.0, 1e30)) + 1) as f32
}

fn flat_normal(triangle: &[[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = triangle.map(|p| glam::Vec3::from(p).as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
}

fn material(m: &raystep_scenes::Material) -> Material {
    Material {
        base_color: m.base_color,
        texture: m.texture.unwrap_or(NO_TEXTURE),
        emissive: m.emissive,
        double_sided: u32::from(m.double_sided),
    }
}

/// The scene's lights in traced units, or a headlight.
fn lights(scene: &Scene, options: &Options, units: Units) -> Vec<Light> {
    if scene.lights.is_empty() {
        let position = match &options.rays {
            RaySource::Camera { camera, .. } => camera.eye.to_array().map(|v| units.to_traced_f64(v)),
            RaySource::Given(rays) => rays.first().map_or([0.0; 3], |r| r.origin.map(|v| units.to_traced(v))),
        };
        return vec![Light { position, kind: POINT, color: [1.0; 3], ..Light::default() }];
    }
    // Farther than that, only a light's direction is left of it.
    let place = |p: &[f32; 3]| p.map(|v| units.to_traced(v).clamp(-1e18, 1e18));
    let traced = |light: &SceneLight| match light {
        SceneLight::Point { position, color, .. } => {
            Light { position: place(position), kind: POINT, color: *color, ..Light::default() }
        }
        SceneLight::Directional { direction, color, .. } => {
            Light { direction: *direction, kind: DIRECTIONAL, color: *color, ..Light::default() }
        }
        SceneLight::Spot { position, direction, color, inner_cone, outer_cone, .. } => {
            let cos_outer = outer_cone.cos();
            // As KHR_lights_punctual recommends: at least 0.001 between the cosines.
            let cone_scale = 1.0 / (inner_cone.cos() - cos_outer).max(0.001);
            Light { position: place(position), kind: SPOT, direction: *direction, cos_outer, color: *color, cone_scale }
        }
    };
    scene.lights.iter().map(traced).collect()
}

/// All texels in one buffer, linear, 16 bits a channel: fine enough for 8-bit sRGB's darkest steps.
fn textures(textures: &[SceneTexture]) -> (Vec<Texture>, Vec<u32>) {
    let white = [SceneTexture {
        width: 1,
        height: 1,
        texels: vec![[255; 4]],
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        linear: false,
    }];
    let textures = if textures.is_empty() { &white } else { textures };
    let linear: Vec<u32> = (0..=255u32).map(|v| (srgb_to_linear(v as f32 / 255.0) * 65535.0).round() as u32).collect();
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let (mut infos, mut words) = (Vec::new(), Vec::new());
    for t in textures {
        infos.push(Texture {
            first: (words.len() / 2) as u32,
            width: t.width as i32,
            height: t.height as i32,
            sampling: wrap(t.wrap_u) | wrap(t.wrap_v) << 2 | u32::from(t.linear) << 4,
        });
        words.extend(
            t.texels
                .iter()
                .flat_map(|&[r, g, b, _]| [linear[r as usize] | linear[g as usize] << 16, linear[b as usize]]),
        );
    }
    (infos, words)
}

/// IEC 61966-2-1.
#[must_use]
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// IEC 61966-2-1.
#[must_use]
pub fn linear_to_srgb(v: f32) -> f32 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}
