//! Lights and cameras, placed by their nodes. One that is wrong is left out.

use super::budget::Budget;
use super::check;
use super::graph::Graph;
use super::json::{self, Node, Property, Root};
use super::lost::Lost;
use super::materials::{color, held, text};
use super::notes::{Notes, Wrong};
use super::{LoadError, at};
use crate::{Camera, Light, Projection};
use glam::{DAffine3, DVec3};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use std::f32::consts::FRAC_PI_2;
use std::f64::consts::{FRAC_PI_4, PI};

/// The cameras of these nodes.
pub(super) fn cameras(
    root: &Root<'_>,
    graph: &Graph,
    nodes: &[usize],
    budget: &Budget,
    notes: &mut Notes,
) -> Vec<Camera> {
    let mut cameras = Vec::new();
    for &i in nodes {
        let Some(node) = root.nodes.elements().get(i).and_then(|node| node.ok()) else { continue };
        match camera(root, graph, (i, node), budget, notes) {
            Ok(camera) => cameras.extend(camera),
            Err(error) => notes.lost(Lost::Camera, (i, 0), error),
        }
    }
    cameras
}

fn camera(
    root: &Root<'_>,
    graph: &Graph,
    (i, node): (usize, &Node<'_>),
    budget: &Budget,
    notes: &mut Notes,
) -> Result<Option<Camera>, LoadError> {
    let path = format!("nodes[{i}].camera");
    let Some(index) = node.camera.get(|| path.clone())? else { return Ok(None) };
    let camera = root.cameras.at(*index, &path, ("cameras", "camera"))?;
    let path = format!("cameras[{index}]");
    let (projection, is_whole) = projection(camera, &path)?;
    notes.found(Wrong::Planes, index.index(), usize::from(!is_whole));
    // Many cameras may share one long name.
    let name = if camera.name.ok().is_some() { &camera.name } else { &node.name };
    budget.take(name.ok().map_or(0, |name| name.0.len() as u64), &format!("{path}.name"))?;
    place(&graph.world(i), &format!("nodes[{i}]"), text(name), projection).map(Some)
}

/// A camera's projection, and whether what is not used of it is in range.
fn projection(camera: &json::Camera<'_>, path: &str) -> Result<(Projection, bool), LoadError> {
    let kind = camera.kind.need_known(|| format!("{path}.type"), "perspective or orthographic")?;
    let missing = |name: &str| at(path, format!("has no {name:?}, which its type asks for"));
    let unused = |value: &Property<json::Number>| value.ok().map_or(f64::NAN, |value| value.0);
    let field = |name: &str, value: &Property<json::Number>, most: f64, right: &str| {
        let path = || format!("{path}.{name}");
        let value = value.need(path)?.0;
        // Written so that NaN is rejected.
        if value > 0.0 && value < most {
            return Ok(value);
        }
        Err(at(path(), format!("is {value}; {right} would be right")))
    };
    match kind {
        CameraType::Perspective => {
            let p = camera.perspective.get(|| format!("{path}.perspective"))?.ok_or_else(|| missing("perspective"))?;
            let right = "an angle in radians above 0 and below pi";
            let vertical_fov = field("perspective.yfov", &p.yfov, PI, right)?;
            let (near, far) = (unused(&p.znear), if p.zfar.ok().is_some() { unused(&p.zfar) } else { f64::INFINITY });
            Ok((Projection::Perspective { vertical_fov }, near > 0.0 && far > near))
        }
        CameraType::Orthographic => {
            let o =
                camera.orthographic.get(|| format!("{path}.orthographic"))?.ok_or_else(|| missing("orthographic"))?;
            let half_height = field("orthographic.ymag", &o.ymag, f64::INFINITY, "a length above 0")?;
            let (width, near, far) = (unused(&o.xmag), unused(&o.znear), unused(&o.zfar));
            Ok((Projection::Orthographic { half_height }, width > 0.0 && width.is_finite() && far > near))
        }
    }
}

/// A camera looks along its node's -Z with +Y up. Scales, shears and mirrors of the node's matrix are ignored: forward
/// is kept, up is made orthogonal to it, and right follows.
fn place(world: &DAffine3, path: &str, name: String, projection: Projection) -> Result<Camera, LoadError> {
    let forward = (-world.matrix3.z_axis).try_normalize();
    let axes = forward.and_then(|forward| {
        let up = world.matrix3.y_axis.try_normalize()?;
        let right = forward.cross(up).try_normalize()?;
        Some((right, right.cross(forward), forward))
    });
    let eye = world.translation;
    match axes {
        Some((right, up, forward)) if eye.is_finite() && (right + up + forward).is_finite() => {
            Ok(Camera { name, eye, right, up, forward, projection })
        }
        _ => Err(at(path, "its transform leaves its camera without a direction; a scale other than 0 would be right")),
    }
}

/// The lights of these nodes.
pub(super) fn lights(root: &Root<'_>, graph: &Graph, nodes: &[usize], notes: &mut Notes) -> Vec<Light> {
    let mut lights = Vec::new();
    let mut first_intensity = None;
    let mut matters = false;
    for &i in nodes {
        let found = link(root, i).and_then(|found| {
            let Some((index, json)) = found else { return Ok(None) };
            let path = format!("extensions.KHR_lights_punctual.lights[{index}]");
            convert(json, index, &graph.world(i), [&path, &format!("nodes[{i}]")], notes)
                .map(|light| Some((json, light)))
        });
        match found {
            Ok(None) => {}
            Ok(Some((json, light))) => {
                let (Light::Point { intensity, .. }
                | Light::Directional { intensity, .. }
                | Light::Spot { intensity, .. }) = light;
                matters |= json.range.ok().is_some() || *first_intensity.get_or_insert(intensity) != intensity;
                lights.push(light);
            }
            Err(error) => notes.lost(Lost::Light, (i, 0), error),
        }
    }
    if matters {
        notes
            .add("the lights' intensities and ranges are not used: each light shines with its colour, without falloff");
    }
    lights
}

/// The light that a node has, and its index.
fn link<'b>(root: &'b Root<'_>, i: usize) -> Result<Option<(usize, &'b json::Light)>, LoadError> {
    let node = root.nodes.elements().get(i).and_then(|node| node.ok());
    let Some(extensions) = node.and_then(|node| node.extensions.ok()) else { return Ok(None) };
    let path = format!("nodes[{i}].extensions.KHR_lights_punctual");
    let Some(link) = extensions.light.get(|| path.clone())? else { return Ok(None) };
    let path = format!("{path}.light");
    let index = *link.light.need(|| path.clone())?;
    let none = json::List::default();
    let extension = root.extensions.ok().map(|extensions| &extensions.lights);
    let known = match extension {
        Some(extension) => extension.get(|| "extensions.KHR_lights_punctual".to_owned())?.map(|all| &all.lights),
        None => None,
    };
    match known {
        Some(lights) => {
            let light = lights.at(index, &path, ("extensions.KHR_lights_punctual.lights", "light"))?;
            Ok(Some((index.index(), light)))
        }
        // The message says that there are none.
        None => none.at(index, &path, ("extensions.KHR_lights_punctual.lights", "light")).map(|_: &json::Light| None),
    }
}

fn convert(
    json: &json::Light,
    index: usize,
    world: &DAffine3,
    [path, node_path]: [&str; 2],
    notes: &mut Notes,
) -> Result<Light, LoadError> {
    let color = color(&json.color, || format!("{path}.color"))?.unwrap_or([1.0; 3]);
    let intensity_path = || format!("{path}.intensity");
    let [intensity] = held([json.intensity.number(1.0, intensity_path)?], intensity_path)?;
    let position = || held(world.translation.to_array(), || node_path.to_owned());
    let direction = || {
        let direction: Option<DVec3> = (-world.matrix3.z_axis).try_normalize().filter(|d| d.is_finite());
        let problem = "its transform leaves its light without a direction; a scale other than 0 would be right";
        direction.map(|d| d.as_vec3().to_array()).ok_or_else(|| at(node_path, problem))
    };
    let light = match json.kind.need_known(|| format!("{path}.type"), "directional, point or spot")? {
        LightType::Point => Light::Point { position: position()?, color, intensity },
        LightType::Directional => Light::Directional { direction: direction()?, color, intensity },
        LightType::Spot => {
            let ([inner_cone, outer_cone], is_right) = cones(json, &format!("{path}.spot"))?;
            notes.found(Wrong::Cones, index, usize::from(!is_right));
            Light::Spot { position: position()?, direction: direction()?, color, intensity, inner_cone, outer_cone }
        }
    };
    notes.found(Wrong::LightOutside, index, usize::from(color.iter().any(check::is_outside)));
    Ok(light)
}

/// A spot light's inner and outer angles, and whether they are as the file says.
fn cones(json: &json::Light, path: &str) -> Result<([f32; 2], bool), LoadError> {
    let spot = json.spot.get(|| path.to_owned())?;
    let angle = |value: Option<&Property<json::Number>>, default| {
        value.map_or(Ok(default), |value| {
            value.get(|| path.to_owned()).map(|value| value.map_or(default, |value| value.0))
        })
    };
    let inner = angle(spot.map(|spot| &spot.inner_cone_angle), 0.0)?;
    let outer = angle(spot.map(|spot| &spot.outer_cone_angle), FRAC_PI_4)?;
    if outer <= 0.0 {
        return Err(at(path, format!("has the outer cone angle {outer}, which nothing is lit in")));
    }
    // Writers round pi/2 up to a number above it.
    let is_right = spot.is_some() && 0.0 <= inner && inner < outer && outer < f64::from(FRAC_PI_2) + 1e-6;
    let outer = (outer as f32).clamp(f32::MIN_POSITIVE, FRAC_PI_2);
    let sharp = outer.next_down();
    let inner = inner as f32;
    // Angles that differ only as 64-bit numbers are equal here.
    let mended = if inner < outer { inner.max(0.0) } else { sharp };
    Ok(([mended, outer], is_right && mended == inner))
}
