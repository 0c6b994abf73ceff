//! Reads glTF 2.0, JSON or GLB: calls the other modules in the order in which a file is read.

use super::budget::Budget;
use super::json::Root;
use super::notes::Notes;
use super::{
    LoadError, LoadOptions, Resolver, accessor, buffers, check, container, geometry, graph, images, instances,
    lights_cameras, materials, offset, pose, primitive, survey,
};
use crate::{Note, Scene};
use glam::DVec3;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeSet, HashMap};

/// The scene of a glTF file, without a name.
pub(super) fn read(
    bytes: &[u8],
    resolver: &dyn Resolver,
    options: &LoadOptions,
    budget: &Budget,
) -> Result<Scene, LoadError> {
    let (root, bin) = container::parse(bytes, budget)?;
    let notes = RefCell::new(Notes::default());
    check::extensions(&root, &mut notes.borrow_mut())?;

    let buffers = buffers::Buffers::new(&root, bin, resolver, budget)?;
    let accessors = accessor::Accessors::new(&root, &buffers, budget, &notes);

    let mut graph = graph::Graph::new(&root, &mut notes.borrow_mut())?;
    let nodes = graph.nodes_of(&root, options.scene, &mut notes.borrow_mut())?;
    graph::check_transforms(&root, &nodes, &mut notes.borrow_mut());
    let visible = graph.visible(&root, &nodes, &mut notes.borrow_mut());
    let instances = instances::read(&root, &visible, &accessors, budget, &notes)?;
    let survey = survey::Survey { root: &root, buffers: &buffers, accessors: &accessors, budget, notes: &notes };
    let groups = survey.groups(&visible, &instances);
    let primitives = survey.primitives(&groups)?;

    // Sorted without duplicates: the default material, then file order.
    let used: BTreeSet<Option<usize>> = primitives.iter().map(survey::Primitive::material).collect();
    let images =
        images::Images { buffers: &buffers, resolver, budget, max_texels: options.max_texels, texels: Cell::new(0) };
    let materials = materials::read(&root, &used, &images, &mut notes.borrow_mut());

    let is_textured = primitives.iter().any(|primitive| materials.id(primitive.material()).1.is_some());
    let mut triangles = geometry::Triangles::with_space(&primitives, &instances, is_textured, budget)?;
    let parts = Parts { root: &root, accessors: &accessors, materials: &materials, budget, notes: &notes };
    // Nearly every scene lies where it is drawn, and is complete now.
    parts.fill(&mut triangles, &primitives, &instances, (&graph, DVec3::ZERO), false)?;
    let offset = offset::choose(triangles.bounds, triangles.translation);
    let is_held = |corner: &DVec3| corner.as_vec3().is_finite();
    if offset != DVec3::ZERO || !triangles.bounds.iter().all(is_held) {
        graph = graph.shifted(offset);
        parts.fill(&mut triangles, &primitives, &instances, (&graph, offset), true)?;
    }
    let mut notes = notes.take();
    if let (true, Some(error)) = (triangles.positions.is_empty(), notes.lost_shape()) {
        return Err(error.clone());
    }
    let cameras = lights_cameras::cameras(&root, &graph, &nodes, budget, &mut notes);
    let lights = lights_cameras::lights(&root, &graph, &visible, &mut notes);

    say_defaults(&root, &mut notes, [triangles.positions.len(), cameras.len(), lights.len()]);
    Ok(Scene {
        offset,
        triangles: triangles.positions,
        normals: triangles.normals,
        texcoords: triangles.texcoords,
        colors: triangles.colors,
        triangle_materials: triangles.materials,
        materials: materials.materials,
        textures: materials.textures,
        lights,
        cameras,
        notes: notes.into_vec().into_iter().map(Note).collect(),
        ..Scene::default()
    })
}

/// What triangles are made from.
struct Parts<'a, 'b> {
    root: &'a Root<'b>,
    accessors: &'a accessor::Accessors<'b>,
    materials: &'a materials::Materials,
    budget: &'a Budget,
    notes: &'a RefCell<Notes>,
}

impl Parts<'_, '_> {
    /// Decodes and places all triangles, `offset` subtracted, as in `graph`.
    fn fill(
        &self,
        triangles: &mut geometry::Triangles,
        primitives: &[survey::Primitive<'_>],
        instances: &instances::Instances,
        (graph, offset): (&graph::Graph, DVec3),
        is_rounded: bool,
    ) -> Result<(), LoadError> {
        let Self { root, accessors, materials, budget, notes } = *self;
        let joints = RefCell::new(HashMap::new());
        let poser = pose::Poser { root, accessors, graph, budget, notes, offset, joints };
        let decoder = primitive::Decoder { accessors, poser: &poser, materials, notes };
        triangles.fill(primitives, instances, &decoder, is_rounded)
    }
}

/// Notes what the file does not have.
fn say_defaults(root: &Root<'_>, notes: &mut Notes, [triangles, cameras, lights]: [usize; 3]) {
    if root.asset.ok().is_none_or(|asset| asset.version.ok().is_none()) {
        notes.add("the file does not say its version: read as glTF 2.0");
    }
    if triangles == 0 {
        notes.add("the scene has no triangles");
    }
    if cameras == 0 {
        notes.add("no camera in the file: using one that frames the scene");
    }
    if lights == 0 {
        notes.add("no lights in the file: using a headlight at the eye");
    }
    if !root.animations.elements().is_empty() {
        notes.add("animations are ignored");
    }
}
