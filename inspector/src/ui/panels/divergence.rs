//! Where the GPU differs from the CPU reference: the first such pass of each ray, as a map over the image.
//!
//! Touches: selection, asks.

use crate::ui::canvas::WHOLE;
use crate::ui::panels::zoom::Placed;
use egui::{Color32, ColorImage, Sense, TextureHandle, TextureOptions, vec2};
use raystep_kernels::plan::Bytes;
use raystep_kernels::{Device, RenderError, Renderer};
use raystep_lab::divergence::{Class, DivergenceMap, Parting, divergence, divergence_bytes};
use raystep_lab::lockstep::{Lockstep, lockstep};
use raystep_lab::text::counted;

use crate::command::Command;
use crate::session::request::{Job, JobContext, Request, answered, flow, job};
use crate::ui::pane::{Context, Panel};
use crate::ui::style::strong;

const WHAT: &str = "comparing every pass with the CPU reference";

/// The map.
#[derive(Default)]
pub(in crate::ui) struct Divergence {
    map: Option<(u64, DivergenceMap)>,
    picture: Option<TextureHandle>,
    /// Classes that are hidden.
    hidden: Vec<Class>,
    /// Of a program without states, whose results are equal bit for bit.
    equal: Option<(u64, Lockstep)>,
}

fn color(class: Class) -> Color32 {
    match class {
        Class::Rounding => Color32::from_rgb(70, 90, 120),
        Class::Tie => Color32::from_rgb(230, 200, 80),
        Class::Precision => Color32::from_rgb(240, 130, 40),
        Class::Excess => Color32::from_rgb(220, 60, 200),
        Class::Decision => Color32::from_rgb(235, 50, 40),
    }
}

/// A second run, compared pass by pass.
fn job(generation: u64) -> Job {
    job!(context, {
        let JobContext { session, device, progress, .. } = context;
        let (plan, data) = (session.renderer().shared_plan(), session.renderer().shared_data());
        let options = session.options().clone();
        let fail = |e: raystep_kernels::RenderError| e.to_string();
        let mut renderer = Renderer::from_plan(plan, data, &options, &device).await.map_err(fail)?;
        let map = divergence(&mut renderer, |now| flow(progress(now.run.rays_decided, now.run.rays)));
        let map = map.await.map_err(fail)?;
        answered((generation, map))
    })
}

/// The same for a program without states: its results must be the same bits.
fn lockstep_job(generation: u64) -> Job {
    job!(context, {
        let JobContext { session, device, progress, .. } = context;
        let renderer = async |device: &Device| {
            let (plan, data) = (session.renderer().shared_plan(), session.renderer().shared_data());
            Renderer::from_plan(plan, data, session.options(), device).await
        };
        let mut compared = async || {
            let (mut ours, mut reference) = (renderer(&device).await?, renderer(&Device::Cpu(None)).await?);
            let more = |now: raystep_kernels::Progress| flow(progress(now.rays_decided, now.rays));
            lockstep(&mut ours, &mut reference, more).await
        };
        let found = compared().await.map_err(|error: RenderError| error.to_string())?;
        answered((generation, found))
    })
}

impl Divergence {
    fn show_equal(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        while let Some(answer) = cx.model.take_answer::<(u64, Lockstep)>(WHAT) {
            self.equal = Some(*answer);
        }
        let button = egui::Button::new("Compare every pass with the CPU reference");
        let about = "Runs the program on the device and on the CPU reference kernels, and compares every stream that a \
                     pass writes, bit for bit.";
        if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
            cx.model.ask(Request::Job(WHAT, lockstep_job(cx.model.generation)));
        }
        let Some((_, found)) = self.equal.as_ref().filter(|(generation, _)| *generation == cx.model.generation) else {
            ui.weak("The first pass where an element differs from the CPU reference.");
            return;
        };
        let total = found.compared.total();
        let compared = format!("{}, {}", counted(total.passes, "pass"), counted(total.components, "component"));
        let Some(first) = &found.first else {
            strong(ui, format!("{compared}: the same bits as on the CPU reference."));
            return;
        };
        strong(ui, "Differs from the CPU reference");
        ui.label(format!("{compared} compared: {first}."));
        if ui.button("Go there").clicked() {
            cx.asks.go_to = Some(first.pass + 1);
        }
    }
}

/// A component that differs, as a number.
fn value(parting: &Parting, bits: u32) -> String {
    if parting.stream.is_float_layer(parting.layer) { f32::from_bits(bits).to_string() } else { bits.to_string() }
}

impl Panel for Divergence {
    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("Open a scene first.");
            return;
        };
        if !cx.has_rays() {
            self.show_equal(ui, cx);
            return;
        }
        let bytes = Bytes(divergence_bytes(&opened.plan));
        while let Some(answer) = cx.model.take_answer::<(u64, DivergenceMap)>(WHAT) {
            (self.map, self.picture) = (Some(*answer), None);
        }
        if self.map.as_ref().is_some_and(|(generation, _)| *generation != cx.model.generation) {
            (self.map, self.picture) = (None, None);
        }
        ui.horizontal_wrapped(|ui| {
            let button = egui::Button::new("Compare every pass with the CPU reference");
            let about = format!(
                "Each pass also runs on the CPU reference kernels in f32 and f64, starting from the device's streams \
                 before it. Takes {bytes} of memory."
            );
            if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
                cx.model.ask(Request::Job(WHAT, job(cx.model.generation)));
            }
        });
        let Some((_, map)) = &self.map else {
            ui.weak("The first pass where a ray differs from the CPU reference, or where f32 and f64 disagree.");
            return;
        };
        strong(ui, map.sentence());
        if let Some((ray, first)) = map.earliest() {
            let [x, y] = [ray as u32 % map.width(), ray as u32 / map.width()];
            let layer = first.stream.info().layers[first.layer];
            let [found, expected] = [first.theirs, first.twin].map(|bits| value(&first, bits));
            ui.horizontal_wrapped(|ui| {
                if ui.button("Go there").clicked() {
                    (cx.asks.select, cx.asks.go_to) = (Some([x, y]), Some(first.pass + 1));
                }
                ui.label(format!(
                    "First in pass {}, {}, for the ray of pixel {x},{y}: {}.{layer} is {found}, expected {expected}",
                    first.pass,
                    first.kernel.name(),
                    first.stream.name()
                ));
            });
        }
        ui.horizontal_wrapped(|ui| {
            for class in Class::ALL {
                let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                ui.painter().rect_filled(rect, 2.0, color(class));
                let mut is_shown = !self.hidden.contains(&class);
                let text = format!("{} {}", map.count(class), class.name());
                if ui.checkbox(&mut is_shown, text).on_hover_text(class.summary()).changed() {
                    if is_shown {
                        self.hidden.retain(|c| *c != class)
                    } else {
                        self.hidden.push(class)
                    }
                    self.picture = None;
                }
            }
        });
        let (width, height) = (map.width(), map.height());
        let hidden = &self.hidden;
        let shown =
            |ray: usize| Class::ALL.into_iter().rev().find(|c| !hidden.contains(c) && map.first(*c, ray).is_some());
        let picture = self.picture.get_or_insert_with(|| {
            let rays = width as usize * height as usize;
            let pixels = (0..rays).map(|ray| shown(ray).map_or(Color32::from_gray(24), color)).collect();
            let image = ColorImage::new([width as usize, height as usize], pixels);
            ui.ctx().load_texture("divergence", image, TextureOptions::NEAREST)
        });
        let room = ui.available_size().max(vec2(16.0, 16.0));
        let scale = (room.x / width as f32).min(room.y / height as f32);
        let (rect, response) = ui.allocate_exact_size(vec2(width as f32, height as f32) * scale, Sense::click());
        ui.painter().image(picture.id(), rect, WHOLE, Color32::WHITE);
        let placed = Placed { rect, origin: rect.min, scale, size: [width, height] };
        let texel = response.hover_pos().and_then(|at| placed.texel(at));
        let counts = Class::ALL.map(|class| format!("{} {}", map.count(class), class.name())).join(", ");
        let text = format!("map of rays that differ from the CPU reference: {counts}");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        let Some([x, y]) = texel else { return };
        cx.selection.hovered = Some([x, y]);
        let ray = (y * width + x) as usize;
        let parting = shown(ray).and_then(|class| map.first(class, ray));
        let is_clicked = response.clicked();
        if let Some(parting) = parting {
            response.on_hover_ui_at_pointer(|ui| {
                strong(ui, format!("{}: {}", parting.class.name(), parting.class.summary()));
                let layer = parting.stream.info().layers[parting.layer];
                ui.label(format!(
                    "pass {}, {}: {}.{layer}",
                    parting.pass,
                    parting.kernel.name(),
                    parting.stream.name()
                ));
                ui.label(format!(
                    "{} on the device, {} on the CPU reference in f32",
                    value(&parting, parting.theirs),
                    value(&parting, parting.twin)
                ));
                if let Some(ulps) = parting.ulps {
                    ui.label(format!("{ulps} ulp apart"));
                }
            });
        }
        if is_clicked {
            cx.asks.select = Some([x, y]);
            cx.asks.go_to = parting.map(|p| p.pass + 1);
        }
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if command != Command::Divergence {
            return false;
        }
        let job = if cx.has_rays() { job } else { lockstep_job };
        cx.model.ask(Request::Job(WHAT, job(cx.model.generation)));
        true
    }
}
