//! Where the camera of the 3D view is: it frames the selected ray's walk until it is moved by hand.

use std::sync::Arc;

use glam::DVec3;
use raystep_kernels::export::trace::Trace;

use super::lit::Extent;
use super::{Walk3d, Wish, control};
use crate::orbit::Orbit;
use crate::session::request::Opened;
use crate::ui::pane::Context;
use crate::walk::{Aabb, Structure, WalkGeometry};

/// Share of the picture that stays free at each edge, for labels.
const MARGIN: f64 = 0.09;

/// The whole walk of the selected ray, which the camera frames: it stays while stepping.
#[derive(Default)]
pub(super) struct Framed {
    of: Option<(Arc<Trace>, u64)>,
    /// Traced units.
    extent: Vec<DVec3>,
    /// Lights that are seen, too.
    lights: Vec<DVec3>,
    direction: DVec3,
    /// The walk's version and the picture's size for which the camera was set last.
    done: Option<(u64, [u32; 2])>,
    /// Incremented with every change.
    version: u64,
}

impl Framed {
    /// Takes over the selected ray of a run.
    pub(super) fn update(&mut self, history: Option<&Arc<Trace>>, generation: u64, opened: &Opened, scene: &Aabb) {
        let is_same = match (&self.of, history) {
            (Some((then, of)), Some(now)) => Arc::ptr_eq(then, now) && *of == generation,
            (then, now) => then.is_none() && now.is_none(),
        };
        if is_same {
            return;
        }
        self.of = history.map(|history| (history.clone(), generation));
        let whole = history
            .filter(|history| !history.rows.is_empty())
            .map(|history| WalkGeometry::new(history, &opened.data, usize::MAX));
        self.extent = whole.as_ref().map_or_else(Vec::new, WalkGeometry::extent);
        // A light outside of the scene is seen, but nothing is cut away for it.
        let lit = history.map_or_else(Extent::default, |history| Extent::of(history, opened, scene));
        self.extent.extend(lit.inside);
        self.lights = lit.ends;
        self.direction = whole.map_or(DVec3::ZERO, |walk| walk.direction);
        self.version += 1;
    }

    /// Whether there is a walk.
    pub(super) fn has_walk(&self) -> bool {
        !self.extent.is_empty()
    }

    /// Where the walk begins, seen from the camera, as a distance from the origin along the view; traced units.
    pub(super) fn front(&self, camera: &Orbit) -> Option<f64> {
        let forward = camera.pose.axes()[2];
        let nearest = self.extent.iter().map(|point| point.dot(forward)).min_by(f64::total_cmp)?;
        let farthest = self.extent.iter().map(|point| point.dot(forward)).max_by(f64::total_cmp)?;
        // Triangles in the first plane of the walk itself belong to it.
        Some(nearest - (farthest - nearest) * 1e-3)
    }

    fn frame(&self, camera: &mut Orbit, aspect: f64, unit: f64) {
        let points: Vec<DVec3> = self.extent.iter().chain(&self.lights).map(|&point| point * unit).collect();
        camera.frame_from_side(&points, self.direction, aspect, MARGIN);
    }
}

impl Walk3d {
    /// The camera, in scene units; reset for a new scene.
    pub(super) fn camera(&mut self, opened: &Opened, bounds: &Aabb, scale: f64, aspect: f64) -> Orbit {
        let is_same =
            std::ptr::eq(self.inside.as_ptr(), Arc::as_ptr(&opened.scene)) || self.look.scene == opened.scene.name;
        self.inside = Arc::downgrade(&opened.scene);
        self.look.scene.clone_from(&opened.scene.name);
        let kept = self.look.camera.filter(|_| is_same);
        self.look.is_moved &= kept.is_some();
        kept.unwrap_or_else(|| Orbit::framing(bounds, aspect).scaled(1.0 / scale))
    }

    /// Frames the walk of a ray that was selected, or after the pane has changed, unless the camera was moved by hand.
    pub(super) fn frame_new(&mut self, camera: &mut Orbit, size: egui::Vec2, unit: f64) {
        let size_px = [size.x, size.y].map(|side| side.round().clamp(1.0, 65_536.0) as u32);
        let wanted = Some((self.framed.version, size_px));
        // A camera that is traced must not follow from what it traces.
        if self.look.is_moved || self.look.traces || !self.framed.has_walk() || self.framed.done == wanted {
            return;
        }
        self.framed.done = wanted;
        self.framed.frame(camera, size.x.max(1.0) as f64 / f64::from(size.y.max(1.0)), unit);
    }

    /// Does what was asked of the camera.
    pub(super) fn fulfil(
        &mut self,
        wish: Wish,
        camera: &mut Orbit,
        opened: &Opened,
        bounds: &Aabb,
        aspect: f64,
        cx: &mut Context<'_>,
    ) {
        let unit = 1.0 / opened.data.units.scale();
        let in_scene = |b: &Aabb| Aabb { min: b.min * unit, max: b.max * unit };
        let walk = self.walked.walk.as_ref();
        let place = walk.and_then(|walk| match walk.structure {
            Structure::Grid => walk.cells.last().map(|cell| cell.bounds),
            Structure::Tree => walk.current_box,
            Structure::Nothing => None,
        });
        self.look.is_moved =
            !matches!(wish, Wish::Reset | Wish::FrameWalk) && (self.look.is_moved || wish != Wish::Trace);
        match wish {
            Wish::Reset | Wish::FrameWalk if self.framed.has_walk() => self.framed.frame(camera, aspect, unit),
            Wish::Reset | Wish::FrameWalk => camera.reset(),
            Wish::FrameScene => camera.frame(&in_scene(bounds), aspect),
            Wish::FrameCell => camera.frame(&in_scene(place.as_ref().unwrap_or(bounds)), aspect),
            Wish::AlongRay => {
                if let Some(walk) = walk {
                    let size = place.map_or(bounds.radius() * 0.25, |b| b.radius());
                    let at = walk.current_point() * unit;
                    control::look_along(camera, at, walk.direction, size * unit * 4.0);
                }
            }
            Wish::TracedView => {
                let traced = opened.settings.view.camera(&opened.scene);
                camera.pose = Orbit::from_camera(&traced, &in_scene(bounds)).pose;
            }
            Wish::Trace => self.trace(camera, opened, cx),
        }
    }
}
