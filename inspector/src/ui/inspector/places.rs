//! Places: links, the second run, watches, edited texels.

use raystep_kernels::{Accelerator, Stream};
use raystep_lab::text::counted;

use crate::command::PaneKind;
use crate::link::{Link, LinkRay, Shown};
use crate::session::request::Request;
use crate::session::{Direction, Model, Target, Watch};
use crate::settings::Settings;
use crate::ui::desk::layout;
use crate::ui::panels::watches;
use crate::ui::{Arrival, Inspector};

impl Inspector {
    /// The place that is shown, as a link; `None` without a scene.
    #[must_use]
    pub fn link(&self) -> Option<Link> {
        let opened = self.model.opened.as_ref()?;
        let link = opened.settings.link();
        let ray = link.ray.or(self.state.selection.pixel.map(LinkRay::Pixel));
        let shown = self.state.display.shown;
        let (zoom, pan) = shown.map_or((None, None), |s| (s.zoom, s.pan.filter(|_| s.zoom.is_some())));
        let stream = shown.map(|s| s.stream);
        let (scene, scene_index) = self.host.scene_of(self.scene.path.as_deref().unwrap_or_default());
        let (scene, pass) = (Some(scene), Some(self.model.place));
        let scene_hash = self.state.runs.hash(&opened.scene).and_then(|hash| hash.parse().ok());
        Some(Link { scene, scene_index, scene_hash, ray, stream, zoom, pan, pass, ..link })
    }

    /// Goes to the target of a link.
    pub fn follow_link(&mut self, link: &Link) {
        let pixel = match link.ray {
            Some(LinkRay::Pixel(pixel)) => Some(pixel),
            _ => None,
        };
        let place = link.pass.or(Arrival::picture().place);
        let arrival = Arrival { pixel, place, shown: Shown::of(link), scene_hash: link.scene_hash };
        let path =
            link.scene.as_ref().map(|scene| self.host.path_of(scene, link.scene_index)).or(self.scene.path.clone());
        if let Some(path) = path {
            let settings = if link.pass.is_some() { self.settings_of(link) } else { Settings::from(link) };
            self.open(&path, settings, arrival);
        }
    }

    /// The settings of a link that counts passes: those of its schedule, on the CPU where the window's adapter cannot draw
    /// them.
    pub(super) fn settings_of(&self, link: &Link) -> Settings {
        let settings = Settings::from(link);
        let here = settings.clone().on(&self.devices.gpu);
        if here.choices.schedule == settings.choices.schedule { settings } else { settings.computed() }
    }

    /// Goes to the target of a link, or reports what is wrong with it.
    pub fn go_to_link(&mut self, text: &str) {
        if let Err(error) = self.visit(text) {
            self.fail(error);
        }
    }

    /// Goes to the target of a link; the error says what is wrong with it.
    pub(super) fn visit(&mut self, text: &str) -> Result<(), String> {
        let link = text.parse::<Link>().map_err(|error| error.to_string())?;
        self.follow_link(&link);
        Ok(())
    }

    /// Edits a component of the selected ray; the error says what was expected.
    pub(super) fn edit_texel(&mut self, stream: Stream, layer: usize, text: &str) -> Result<(), String> {
        let Some(pixel) = self.state.selection.pixel else { return Ok(()) };
        let text = text.trim();
        let bits = match text.strip_prefix("0x") {
            Some(bits) => u32::from_str_radix(bits, 16).ok(),
            None if stream.is_float_layer(layer) => text.parse::<f32>().ok().map(f32::to_bits),
            None => text.parse().ok(),
        };
        let bits = bits.ok_or_else(|| {
            let kind = if stream.is_float_layer(layer) { "a number" } else { "an integer of at least 0" };
            format!("{text:?}: expected {kind}, or bits such as 0x3f800000")
        })?;
        self.model.ask(Request::Edit(stream, layer, pixel, bits));
        Ok(())
    }

    pub(super) fn run_to_watch(&mut self, direction: Direction) {
        match watches::run(&self.state.watches.list, direction) {
            Some(request) => {
                self.model.ask(request);
            }
            None => layout::show(&mut self.desk.tree, PaneKind::Watches),
        }
    }

    /// Reports the result of the last run to a watch.
    pub(super) fn tell_fired(&mut self) {
        let Some(fired) = self.model.fired.take() else { return };
        let text = match fired {
            Some(fired) => {
                let [x, y] = fired.ray;
                if !fired.watch.is_of_ray() {
                    self.state.asks.select = Some(fired.ray);
                }
                let more = if fired.rays > 1 {
                    format!(" and {}", counted(fired.rays - 1, "other ray"))
                } else {
                    String::new()
                };
                format!("after {}, pixel {x},{y}{more}: {}", counted(fired.place, "pass"), fired.value)
            }
            None => "no watch fired".into(),
        };
        self.state.log.tell(text.clone());
        self.state.log.say(false, text.clone());
        self.state.watches.fired = Some(text);
    }

    /// Toggles the watch on the selected ray's state and hit.
    pub(super) fn toggle_watch(&mut self) {
        let of_ray = |watch: Watch| matches!(watch, Watch::RayState | Watch::RayHit);
        let is_on = self.state.watches.list.iter().any(|(watch, is_on)| of_ray(*watch) && *is_on);
        for (_, on) in self.state.watches.list.iter_mut().filter(|(watch, _)| of_ray(*watch)) {
            *on = !is_on;
        }
        let what = if is_on { "no longer watched" } else { "watched: F5 runs to the next change of its state or hit" };
        self.state.log.tell(format!("the selected ray is {what}"));
    }

    /// Opens a second run of the same scene: with the BVH if this run has the grid, otherwise with the grid.
    pub(super) fn compare(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        if self.other.is_some() {
            // The comparison goes on as it is.
            layout::show(&mut self.desk.tree, PaneKind::Compare);
            return;
        }
        let (scene, settings) = (opened.scene.clone(), opened.settings.clone());
        let accelerator =
            if opened.plan.accelerator == Accelerator::Grid { Accelerator::Bvh } else { Accelerator::Grid };
        let devices = self.devices.clone();
        let (mut other, task) = Model::new(|engine| engine.serve(devices));
        self.host.spawn(task);
        other.ask(Request::Share(scene, Box::new(settings.through(accelerator))));
        other.ask(Request::Step(Target::End));
        self.other = Some(other);
        layout::show(&mut self.desk.tree, PaneKind::Compare);
    }
}
