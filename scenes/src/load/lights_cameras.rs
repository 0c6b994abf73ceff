//! Lights and cameras, placed by their nodes.

use super::budget::Budget;
use super::check;
use super::graph::Graph;
use super::notes::{Notes, Wrong};
use super::{LoadError, at};
use crate::{Camera, Light, Projection};
use glam::{DAffine3, DVec3};
use gltf::json::Root;
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use std::f32::consts::FRAC_PI_2;
use std::f64::consts::PI;

/// The cameras of these nodes.
pub(super) fn cameras(root: &Root, graph: &Graph, nodes: &[usize], budget: &Budget) -> Result<Vec<Camera>, LoadError> {
    let mut cameras = Vec::new();
    for &i in nodes {
        let Some(node) = root.nodes.get(i) else { continue };
        let Some(index) = node.camera else { continue };
        let camera = check::get(&root.cameras, index, &format!("nodes[{i}].camera"), "camera")?;
        let projection = projection(camera, &format!("cameras[{index}]"))?;
        // Many cameras may share one long name.
        let name_bytes = camera.name.as_ref().or(node.name.as_ref()).map_or(0, |name| name.len() as u64);
        budget.take(name_bytes, &format!("cameras[{index}].name"))?;
        let name = camera.name.as_ref().or(node.name.as_ref()).cloned().unwrap_or_default();
        cameras.push(place(&graph.world(i), &format!("nodes[{i}]"), name, projection)?);
    }
    Ok(cameras)
}

fn projection(camera: &gltf::json::Camera, path: &str) -> Result<Projection, LoadError> {
    let field = |name: &str, value: f32, ok: bool, right: &str| {
        if ok {
            Ok(f64::from(value))
        } else {
            Err(at(format!("{path}.{name}"), format!("is {value}; {right} would be right")))
        }
    };
    let missing = |name: &str| at(path, format!("has no \"{name}\", which its type asks for"));
    match check::known(&camera.type_, &format!("{path}.type"), "perspective or orthographic")? {
        CameraType::Perspective => {
            let p = camera.perspective.as_ref().ok_or_else(|| missing("perspective"))?;
            let vertical_fov = f64::from(p.yfov);
            let ok = vertical_fov > 0.0 && vertical_fov < PI;
            field("perspective.yfov", p.yfov, ok, "an angle in radians above 0 and below pi")?;
            field("perspective.znear", p.znear, p.znear > 0.0, "a distance above 0")?;
            let zfar = p.zfar.unwrap_or(f32::INFINITY);
            field("perspective.zfar", zfar, zfar > p.znear, "a distance beyond znear")?;
            Ok(Projection::Perspective { vertical_fov })
        }
        CameraType::Orthographic => {
            let o = camera.orthographic.as_ref().ok_or_else(|| missing("orthographic"))?;
            field("orthographic.xmag", o.xmag, o.xmag > 0.0 && o.xmag.is_finite(), "a length above 0")?;
            field("orthographic.zfar", o.zfar, o.zfar > o.znear, "a distance beyond znear")?;
            let ok = o.ymag > 0.0 && o.ymag.is_finite();
            let half_height = field("orthographic.ymag", o.ymag, ok, "a length above 0")?;
            Ok(Projection::Orthographic { half_height })
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
pub(super) fn lights(root: &Root, graph: &Graph, nodes: &[usize], notes: &mut Notes) -> Result<Vec<Light>, LoadError> {
    let known = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let known = known.map_or(&[][..], |e| &e.lights);
    let mut lights = Vec::new();
    let mut first_intensity = None;
    let mut matters = false;
    for &i in nodes {
        let Some(node) = root.nodes.get(i) else { continue };
        let Some(link) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else { continue };
        let path = format!("nodes[{i}].extensions.KHR_lights_punctual.light");
        let light = check::get(known, link.light, &path, "light")?;
        let path = format!("extensions.KHR_lights_punctual.lights[{}]", link.light);
        matters |= light.range.is_some() || *first_intensity.get_or_insert(light.intensity) != light.intensity;
        let is_outside = light.color.iter().any(check::is_outside);
        notes.found(Wrong::LightOutside, link.light.value(), usize::from(is_outside));
        lights.push(convert(light, &graph.world(i), &path, &format!("nodes[{i}]"))?);
    }
    if matters {
        notes
            .add("the lights' intensities and ranges are not used: each light shines with its colour, without falloff");
    }
    Ok(lights)
}

fn convert(light: &JsonLight, world: &DAffine3, path: &str, node_path: &str) -> Result<Light, LoadError> {
    let color = check::finite(light.color, &format!("{path}.color"))?;
    let [intensity] = check::finite([light.intensity], &format!("{path}.intensity"))?;
    let position = || check::finite(world.translation.as_vec3().to_array(), node_path);
    let direction = || {
        let direction: Option<DVec3> = (-world.matrix3.z_axis).try_normalize().filter(|d| d.is_finite());
        let problem = "its transform leaves its light without a direction; a scale other than 0 would be right";
        direction.map(|d| d.as_vec3().to_array()).ok_or_else(|| at(node_path, problem))
    };
    Ok(match check::known(&light.type_, &format!("{path}.type"), "directional, point or spot")? {
        LightType::Point => Light::Point { position: position()?, color, intensity },
        LightType::Directional => Light::Directional { direction: direction()?, color, intensity },
        LightType::Spot => {
            let path = format!("{path}.spot");
            let Some(spot) = &light.spot else { return Err(at(path, "is missing, which a spot light needs")) };
            let (inner_cone, mut outer_cone) = (spot.inner_cone_angle, spot.outer_cone_angle);
            // Writers round pi/2 up to an f32 above it.
            if outer_cone > FRAC_PI_2 && outer_cone < FRAC_PI_2 + 1e-6 {
                outer_cone = FRAC_PI_2;
            }
            // Written so that NaN is rejected.
            if !(0.0 <= inner_cone && inner_cone < outer_cone && outer_cone <= FRAC_PI_2) {
                let problem = format!(
                    "has the cone angles {inner_cone} and {outer_cone}; 0 <= inner < outer <= pi/2 would be right"
                );
                return Err(at(path, problem));
            }
            Light::Spot { position: position()?, direction: direction()?, color, intensity, inner_cone, outer_cone }
        }
    })
}
