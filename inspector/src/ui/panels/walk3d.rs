//! The walk of the selected ray in 3D, synchronised with the timeline.
//!
//! Touches: selection, display, asks.

mod camera;
mod control;
mod glance;
mod heat;
mod labels;
mod lit;
mod photons;
mod pick;
mod tools;

use std::sync::Weak;

use egui::{Rect, Sense, vec2};
use glam::DVec2;
use raystep_scenes::Scene;
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use super::picked;
use super::walked::{Walked, describe, event_buttons, go_on};
use crate::command::Command;
use crate::draw::scene3d::{Around, Marked, Scene3d, Settings, TriangleStyle};
use crate::orbit::Orbit;
use crate::session::request::{Opened, Request};
use crate::settings::View;
use crate::ui::canvas::Picture;
use crate::ui::pane::{Context, NO_RAYS, Panel, saves};
use crate::ui::state::Picked;
use crate::ui::units::Scale;
use crate::walk::Aabb;
use camera::Framed;
use heat::{Heat, Paint};
use labels::{LabelStyle, Ready, Subject};
use lit::Lit;
use photons::Layer;

/// The saved part of the view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, SmartDefault)]
#[serde(default)]
struct Look {
    settings: Settings,
    paint: Paint,
    #[default(true)]
    labels: bool,
    /// The scene that the camera was made for.
    scene: String,
    /// Scene units.
    camera: Option<Orbit>,
    /// Whether the camera was moved by hand: then it does not follow the selected ray.
    is_moved: bool,
    /// Trace the scene from this camera whenever it moves.
    traces: bool,
}

/// The inputs that the picture was drawn from: it is only redrawn if they change.
#[derive(Clone, Copy, PartialEq)]
struct Drawn {
    generation: u64,
    walk: u64,
    camera: Orbit,
    settings: Settings,
    around: Around,
    painted: u64,
    photons: u64,
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
    /// The camera of the last frame.
    seen: Option<Orbit>,
    /// What the camera frames.
    framed: Framed,
    /// What a command asked of the camera.
    wish: Option<Wish>,
    /// The labels of the picture drawn last, and where it was.
    labels: Option<(Drawn, Rect, LabelStyle, Vec<Ready>)>,
    about: picked::About,
    heat: Heat,
    lit: Lit,
    photons: Layer,
}

impl Panel for Walk3d {
    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let Some(opened) = cx.model.opened.clone() else {
            ui.weak("Open a scene and click a pixel to see its ray's path.");
            return;
        };
        self.walked.update(cx.model);
        let traced_bounds = self.bounds(&opened, cx);
        if self.lit.update(&self.walked, cx.model, &traced_bounds)
            && let Some(scene) = &mut self.scene
        {
            scene.show_light(self.lit.branches.clone());
        }
        if self.photons.update(cx, &opened, &self.walked, &self.look.settings, &traced_bounds)
            && let Some(scene) = &mut self.scene
        {
            scene.show_photons(self.photons.shown.clone());
        }
        if let Some(scene) = &mut self.scene {
            self.heat.update(cx, self.look.paint, scene, &opened.data);
        }
        self.framed.update(cx.model.history.as_ref(), cx.model.generation, &opened, &traced_bounds);
        let scale = opened.data.units.scale();
        let aspect = f64::from(ui.available_rect_before_wrap().aspect_ratio());
        let mut camera = self.camera(&opened, &traced_bounds, scale, aspect);
        let wish = self.tools(ui, cx, &opened).or(self.wish.take());
        self.heat.show(ui, cx, self.look.paint);
        self.about.show(ui, cx.model, cx.selection, cx.display);
        let size = ui.available_size().max(vec2(16.0, 16.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        self.frame_new(&mut camera, size, 1.0 / scale);
        let before = camera.pose;
        let wish = wish.or(control::control(ui, &response, &mut camera));
        self.look.is_moved |= camera.pose != before;
        if let Some(wish) = wish {
            self.fulfil(wish, &mut camera, &opened, &traced_bounds, rect.aspect_ratio().into(), cx);
        }
        self.look.camera = Some(camera);
        let traced = camera.scaled(scale);
        let other = cx.display.beside.as_ref().filter(|_| cx.selection.picked.is_some());
        let marked = cx.selection.picked.and_then(|picked| {
            let of = |data| Some((picked, picked::marked(picked, data)?));
            of(&opened.data).or_else(|| other.and_then(|data| of(data)))
        });
        let around = Around { marked: marked.map(|(_, marked)| marked), cut: self.framed.front(&traced) };
        self.paint(ui, cx, rect, traced, around);
        let scale = self.walked.history.as_ref().map_or(Scale::TRACED, |history| Scale::of(cx.display.units, history));
        let style = LabelStyle { scale, hides_next: cx.display.hides_next };
        self.annotate(ui, rect, &traced, marked, cx.has_rays(), style);
        if let Some(glanced) = cx.model.glanced() {
            glance::draw(&ui.painter().with_clip_rect(rect), ui.visuals(), rect, glanced, &traced, &traced_bounds);
        }
        if response.has_focus() {
            cx.display.keeps_keys = true;
            cx.asks.commands.extend(ui.input(control::commands));
        } else if response.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Escape)) {
            cx.selection.picked = None;
        }
        let mut what = self.walked.walk.as_ref().map_or_else(|| "scene without a ray".into(), describe);
        if self.look.settings.light && !self.lit.told.is_empty() {
            what += &format!("; {}", self.lit.told);
        }
        for told in self.photons.told(&self.look.settings, &style.scale) {
            what += &format!("; {told}");
        }
        if self.look.is_moved {
            what += "; view moved by hand";
        }
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &what));
        self.pick(&response, &traced, around, cx, &opened);
        self.follow_camera(ui, &camera, &opened, cx);
    }

    saves!(look);

    fn command(&mut self, command: Command, _: &mut Context<'_>) -> bool {
        match command {
            Command::FrameWalk => self.wish = Some(Wish::FrameWalk),
            Command::PaintScene => self.look.paint = self.look.paint.next(),
            _ => return false,
        }
        true
    }
}

/// A request to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    /// Frame the walk; without one, the whole scene.
    Reset,
    /// The same, from a button or a command.
    FrameWalk,
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
        let scene = self.scene.get_or_insert_with(|| Scene3d::new(gpu));
        if self.generation != cx.model.generation {
            self.generation = cx.model.generation;
            scene.set_scene(&opened.data);
        }
        scene.bounds()
    }

    /// Traces as the camera moves: at a lower resolution until it rests.
    fn follow_camera(&mut self, ui: &egui::Ui, camera: &Orbit, opened: &Opened, cx: &mut Context<'_>) {
        let has_moved = self.seen.replace(*camera) != Some(*camera);
        if !self.look.traces || self.traced == Some(*camera) {
            return;
        }
        if has_moved || ui.input(|input| input.pointer.any_down()) {
            let view = View::of(&camera.to_camera("3D view"), &opened.scene);
            cx.model.ask_glimpse(crate::settings::Settings { view, ray: None, ..opened.settings.clone() });
            ui.ctx().request_repaint();
        } else if !cx.model.is_busy() {
            self.trace(camera, opened, cx);
        }
    }

    /// Traces the scene from this view, up to the current pass.
    fn trace(&mut self, camera: &Orbit, opened: &Opened, cx: &mut Context<'_>) {
        self.traced = Some(*camera);
        let view = View::of(&camera.to_camera("3D view"), &opened.scene);
        if opened.settings.view == view && opened.settings.ray.is_none() {
            return;
        }
        let settings = crate::settings::Settings { view, ray: None, ..opened.settings.clone() };
        cx.model.ask(Request::Plan(Box::new(settings)));
    }

    fn paint(&mut self, ui: &egui::Ui, cx: &Context<'_>, rect: Rect, camera: Orbit, around: Around) {
        let points = ui.ctx().pixels_per_point();
        let most = cx.canvas.most_side();
        let size = [rect.width(), rect.height()].map(|side| ((side * points).round() as u32).clamp(1, most));
        let settings = Settings { is_dark: ui.visuals().dark_mode, line_width_px: 1.25 * points, ..self.look.settings };
        let (generation, walk, painted) = (self.generation, self.walked.version, self.heat.version);
        let photons = self.photons.version;
        let drawn = Drawn { generation, walk, camera, settings, around, painted, photons, size };
        let target = self.picture.target(cx.canvas, size, self.drawn != Some(drawn));
        if let Some((scene, target)) = self.scene.as_mut().zip(target) {
            scene.draw(target, size, &camera, self.walked.walk.as_ref(), &around, &settings);
            self.drawn = Some(drawn);
        }
        self.picture.show(ui, rect);
    }

    /// Hovering tells what is under the cursor, and a click picks it and goes to its pass.
    fn pick(&self, response: &egui::Response, camera: &Orbit, around: Around, cx: &mut Context<'_>, opened: &Opened) {
        let Some(at) = response.hover_pos().filter(|_| !response.dragged()) else { return };
        let [at, size] = [at - response.rect.min, response.rect.size()].map(|v| DVec2::new(v.x.into(), v.y.into()));
        if let Some(photon) = self.photons.under(camera, at, size, &self.look.settings) {
            if response.clicked() {
                cx.asks.follow = Some(photons::subject(photon.photon, opened));
            }
            response.clone().on_hover_text_at_pointer(photons::name(&photon));
            return;
        }
        let (Some(history), Some(walk)) = (&self.walked.history, &self.walked.walk) else { return };
        let cut = around.cut.filter(|_| self.look.settings.cut);
        let found = pick::under(walk, camera, at, size, cut);
        if response.clicked() && !found.is_empty() {
            let chosen = pick::chosen(&found, cx.selection.picked);
            cx.selection.picked = chosen.map(|found| found.what);
            cx.asks.go_to = chosen.and_then(|found| history.rows.get(found.row)?.place());
        }
        if let Some(first) = found.first() {
            let mut text = picked::name(first.what);
            if found.len() > 1 {
                text += &format!(", and {} behind or around it", found.len() - 1);
            }
            response.clone().on_hover_text_at_pointer(text + &go_on(history, first.row));
        }
    }

    /// Labels over the picture.
    fn annotate(
        &mut self,
        ui: &egui::Ui,
        rect: Rect,
        camera: &Orbit,
        marked: Option<(Picked, Marked)>,
        has_rays: bool,
        style: LabelStyle,
    ) {
        let painter = ui.painter().with_clip_rect(rect);
        let drawn = self.drawn.filter(|_| self.look.labels);
        match (&self.walked.walk, drawn) {
            (Some(walk), Some(drawn)) => {
                let now = (drawn, rect, style);
                let is_known = self.labels.as_ref().is_some_and(|(of, at, style, _)| (*of, *at, *style) == now);
                if !is_known {
                    let lights = if self.look.settings.light { &self.lit.branches[..] } else { &[] };
                    let subject = Subject { walk, lights, picked: marked };
                    let ready = labels::arrange(&painter, ui.visuals(), rect, subject, camera, style);
                    self.labels = Some((drawn, rect, style, ready));
                }
                let ready = self.labels.as_ref().map_or(&[][..], |(.., ready)| ready);
                labels::draw(&painter, ui.visuals(), ready);
            }
            (Some(_), None) => {}
            (None, _) => {
                let text = if !has_rays {
                    NO_RAYS
                } else if self.walked.history.is_some() {
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
        let shown = self.scene.as_ref().map(|scene| scene.shown().to_string()).filter(|text| !text.is_empty());
        let unit =
            (drawn.is_some() && self.walked.walk.is_some()).then(|| format!("t in {}", style.scale.units.name()));
        let photons = self.photons.told(&self.look.settings, &style.scale);
        let shown: Vec<String> = shown.into_iter().chain(photons).chain(unit).collect();
        if !shown.is_empty() {
            let font = egui::TextStyle::Small.resolve(ui.style());
            let galley = painter.layout(shown.join("; "), font, ui.visuals().text_color(), rect.width() - 12.0);
            let place = Rect::from_min_size(rect.left_bottom() + vec2(6.0, -4.0 - galley.size().y), galley.size());
            painter.rect_filled(place.expand2(vec2(4.0, 1.0)), 3.0, ui.visuals().extreme_bg_color);
            painter.galley(place.min, galley, ui.visuals().text_color());
        }
    }
}
