//! Reads glTF 2.0, JSON or GLB: calls the other modules in the order in which a file is read.

use super::budget::Budget;
use super::notes::Notes;
use super::{
    LoadError, LoadOptions, Resolver, accessor, buffers, check, container, geometry, graph, images, lights_cameras,
    materials, pose,
};
use crate::{Note, Scene};
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

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

    let graph = graph::Graph::new(&root)?;
    let nodes = graph.nodes_of(&root, options.scene)?;
    graph::check_transforms(&root, &nodes, &mut notes.borrow_mut());
    let groups = geometry::groups(&root, &nodes)?;
    let primitives = geometry::survey(&root, &accessors, &groups, &notes)?;

    // Sorted without duplicates: the default material, then file order.
    let used: BTreeSet<Option<usize>> = primitives.iter().map(geometry::Primitive::material).collect();
    let images =
        images::Images { buffers: &buffers, resolver, budget, max_texels: options.max_texels, texels: Cell::new(0) };
    let materials = materials::read(&root, &used, &images, &mut notes.borrow_mut())?;

    let poser = pose::Poser::new(&root, &accessors, &graph, budget);
    let triangles = geometry::triangles(&primitives, &accessors, &poser, &graph, &materials, budget, &notes)?;
    let mut notes = notes.take();
    let cameras = lights_cameras::cameras(&root, &graph, &nodes, budget)?;
    let lights = lights_cameras::lights(&root, &graph, &nodes, &mut notes)?;

    if triangles.positions.is_empty() {
        notes.add("the scene has no triangles");
    }
    if cameras.is_empty() {
        notes.add("no camera in the file: using one that frames the scene");
    }
    if lights.is_empty() {
        notes.add("no lights in the file: using a headlight at the eye");
    }
    if !root.animations.is_empty() {
        notes.add("animations are ignored");
    }
    Ok(Scene {
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
