//! The walk of the selected ray in 3D, synchronised with the timeline.

mod control;
mod labels;
mod tools;

use std::sync::{Arc, Weak};

use egui::{Color32, Rect, Sense, pos2, vec2};
use raystep_scenes::Scene;
use serde::{Deserialize, Serialize};

use super::walked::{Walked, describe, event_buttons};
use crate::draw::scene3d::{Scene3d, Settings, TriangleStyle};
use crate::orbit::Orbit;
use crate::session::Target;
use crate::session::request::{Opened, Request};
use crate::settings::View;
use crate::ui::canvas::Picture;
use crate::ui::pane::{Context, NO_RAYS, Panel};
use crate::walk::{Aabb, Structure};

/// The saved part of the view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Look {
    settings: Settings,
    labels: bool,
    /// The scene that the camera was made for.
    scene: String,
    /// Scene units.
    camera: Option<Orbit>,
    /// Trace the scene from this camera whenever it moves.
    traces: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self { settings: Settings::default(), labels: true, scene: String::new(), camera: None, traces: false }
    }
}

/// The inputs that the picture was drawn from: it is only redrawn if they change.
#[derive(Clone, Copy, PartialEq)]
struct Drawn {
    generation: u64,
    walk: u64,
    camera: Orbit,
    settings: Settings,
    size: [u32; 2],
}

/// The 3D view.
#[derive(Default)]
pub(in crate::ui) struct Walk3d {
    look: Look,
    walked: Walked,
    scene: Option<Scene3d>,
    /// The run whose triangles are uploaded.
    generation: u64,
    /// The scene that the camera is in.
    inside: Weak<Scene>,
    picture: Picture,
    drawn: Option<Drawn>,
    /// The camera that was traced last.
    traced: Option<Orbit>,
}

impl Panel for Walk3d {
    fn title(&self) -> String {
        "Walk in 3D".into()
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let Some(opened) = cx.model.opened.clone() else {
            ui.weak("Open a scene and click a pixel to see its ray's path.");
            return;
        };
        self.walked.update(cx.model);
        let traced_bounds = self.bounds(&opened, cx);
        let scale = opened.data.units.scale();
        let aspect = f64::from(ui.available_rect_before_wrap().aspect_ratio());
        let mut camera = self.camera(&opened, &traced_bounds, scale, aspect);
        let wish = self.tools(ui, cx);
        let size = ui.available_size().max(vec2(16.0, 16.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let wish = wish.or(control::control(ui, &response, &mut camera));
        if let Some(wish) = wish {
            self.fulfil(wish, &mut camera, &opened, &traced_bounds, rect.aspect_ratio().into(), cx);
        }
        self.look.camera = Some(camera);
        let traced = camera.scaled(scale);
        self.paint(ui, cx, rect, traced);
        self.annotate(ui, rect, &traced, cx.has_rays());
        if response.has_focus() {
            cx.shared.keeps_keys = true;
            cx.todo.extend(ui.input(control::commands));
        }
        let what = self.walked.walk.as_ref().map_or_else(|| "scene without a ray".into(), describe);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &what));
        if self.look.traces && !cx.model.is_busy() && self.traced != Some(camera) {
            self.trace(&camera, &opened, cx);
        }
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        if let Ok(look) = serde_json::from_str(saved) {
            self.look = look;
        }
    }
}

/// A request to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    /// Reset.
    Reset,
    /// Frame the whole scene.
    FrameScene,
    /// Frame the ray's current cell or node.
    FrameCell,
    /// Look along the ray, from behind its current position.
    AlongRay,
    /// The view of the traced camera.
    TracedView,
    /// Trace the scene from this view.
    Trace,
}

impl Walk3d {
    /// The box of the triangles, in traced units; uploads those of a new run.
    fn bounds(&mut self, opened: &Opened, cx: &Context<'_>) -> Aabb {
        let gpu = &cx.canvas.gpu;
        let scene = self.scene.get_or_insert_with(|| Scene3d::new(&gpu.device, &gpu.queue));
        if self.generation != cx.model.generation {
            self.generation = cx.model.generation;
            scene.set_scene(&opened.data);
        }
        scene.bounds()
    }

    /// The camera, in scene units; reset for a new scene.
    fn camera(&mut self, opened: &Opened, bounds: &Aabb, scale: f64, aspect: f64) -> Orbit {
        let is_same =
            std::ptr::eq(self.inside.as_ptr(), Arc::as_ptr(&opened.scene)) || self.look.scene == opened.scene.name;
        self.inside = Arc::downgrade(&opened.scene);
        self.look.scene.clone_from(&opened.scene.name);
        let kept = self.look.camera.filter(|_| is_same);
        kept.unwrap_or_else(|| Orbit::framing(bounds, aspect).scaled(1.0 / scale))
    }

    fn fulfil(
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
        match wish {
            Wish::Reset => camera.reset(),
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

    /// Traces the scene from this view, up to the current pass.
    fn trace(&mut self, camera: &Orbit, opened: &Opened, cx: &mut Context<'_>) {
        self.traced = Some(*camera);
        let view = View::of(&camera.to_camera("3D view"));
        if opened.settings.view == view && opened.settings.ray.is_none() {
            return;
        }
        let place = cx.model.place;
        let target = if cx.model.next.is_none() { Target::End } else { Target::Pass(place) };
        let settings = crate::settings::Settings { view, ray: None, ..opened.settings.clone() };
        cx.model.ask(Request::Plan(Box::new(settings)));
        if place > 0 {
            cx.model.ask(Request::Step(target));
        }
    }

    fn paint(&mut self, ui: &egui::Ui, cx: &Context<'_>, rect: Rect, camera: Orbit) {
        let points = ui.ctx().pixels_per_point();
        let most = cx.canvas.most_side();
        let size = [rect.width(), rect.height()].map(|side| ((side * points).round() as u32).clamp(1, most));
        let settings = Settings { is_dark: ui.visuals().dark_mode, line_width_px: 1.25 * points, ..self.look.settings };
        let drawn = Drawn { generation: self.generation, walk: self.walked.version, camera, settings, size };
        let (target, is_new) = self.picture.target(cx.canvas, size);
        if let Some(scene) = self.scene.as_mut().filter(|_| is_new || self.drawn != Some(drawn)) {
            scene.draw(target, size, &camera, self.walked.walk.as_ref(), &settings);
            self.drawn = Some(drawn);
        }
        if let Some(id) = self.picture.id() {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(id, rect, whole, Color32::WHITE);
        }
    }

    /// Labels over the picture.
    fn annotate(&self, ui: &egui::Ui, rect: Rect, camera: &Orbit, has_rays: bool) {
        let painter = ui.painter().with_clip_rect(rect);
        match &self.walked.walk {
            Some(walk) if self.look.labels => labels::draw(&painter, ui.visuals(), rect, walk, camera),
            Some(_) => {}
            None => {
                let text = if !has_rays {
                    NO_RAYS
                } else if self.walked.life.is_some() {
                    "No pass has processed this ray yet."
                } else {
                    "Click a pixel to see its ray's path."
                };
                let font = egui::TextStyle::Body.resolve(ui.style());
                painter.text(
                    rect.center_top() + vec2(0.0, 8.0),
                    egui::Align2::CENTER_TOP,
                    text,
                    font,
                    ui.visuals().weak_text_color(),
                );
            }
        }
        if let Some(shown) = self.scene.as_ref().map(|scene| scene.shown().to_string()).filter(|text| !text.is_empty())
        {
            let font = egui::TextStyle::Small.resolve(ui.style());
            painter.text(
                rect.left_bottom() + vec2(6.0, -4.0),
                egui::Align2::LEFT_BOTTOM,
                shown,
                font,
                ui.visuals().weak_text_color(),
            );
        }
    }
}
