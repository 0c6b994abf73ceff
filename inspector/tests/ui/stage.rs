//! An inspector in egui's test harness, drawn with our own device.

mod paint;

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use egui::mutex::RwLock;
use egui::{Event, Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use egui_kittest::{Harness, Node, SnapshotOptions};
use egui_wgpu::{Renderer, RendererOptions};
use raystep_inspector::command::{Command, Layout};
use raystep_inspector::draw::picture::FORMAT;
use raystep_inspector::session::devices::Devices;
use raystep_inspector::session::measure::Measure;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::retained::Retained;
use raystep_inspector::ui::{Arrival, Inspector};
use raystep_kernels::{Gpu, Stream};

use crate::ui::adapter::gpu;
use crate::ui::desk::{Desk, TestHost};
use crate::ui::measured::measured;
use paint::Painter;

/// Time limit for any wait, on a slow and busy machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(240);

/// Messages to the window's owner.
#[derive(Default)]
pub(crate) struct Heard {
    /// Texts copied to the clipboard.
    pub(crate) copied: Vec<String>,
    /// Whether closing the window was requested.
    pub(crate) is_closed: bool,
}

/// An inspector in a window, with its host.
pub(crate) struct Stage {
    pub(crate) harness: Harness<'static, Inspector>,
    pub(crate) desk: Arc<Mutex<Desk>>,
    pub(crate) heard: Heard,
    gpu: Arc<Gpu>,
    renderer: Arc<RwLock<Renderer>>,
    retained: Arc<Mutex<Retained>>,
}

/// How to build a stage.
#[derive(Clone)]
pub(crate) struct Plan {
    /// In points.
    pub(crate) size: [f32; 2],
    pub(crate) scale: f32,
    pub(crate) theme: egui::Theme,
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) measure: Measure,
}

impl Default for Plan {
    fn default() -> Self {
        Self { size: [1280.0, 800.0], scale: 1.0, theme: egui::Theme::Dark, gpu: gpu(), measure: measured() }
    }
}

/// Nanoseconds that depend only on how often this thread asked, so that durations in snapshots are reproducible.
fn clock() -> u64 {
    thread_local! { static NOW: std::cell::Cell<(u64, u64)> = const { std::cell::Cell::new((0, 0)) }; }
    NOW.with(|now| {
        let (calls, ns) = now.get();
        let ns = ns + 1_500 + 700 * (calls % 7);
        now.set((calls + 1, ns));
        ns
    })
}

impl Stage {
    /// A stage without a scene.
    pub(crate) fn new(plan: Plan) -> Self {
        let renderer = Arc::new(RwLock::new(Renderer::new(&plan.gpu.device, FORMAT, RendererOptions::PREDICTABLE)));
        let desk = Arc::new(Mutex::new(Desk::default()));
        let retained = Arc::new(Mutex::new(Retained::default()));
        let host = TestHost { gpu: plan.gpu.clone(), desk: desk.clone() };
        // Frames are drawn one after another here: there is nothing to wake.
        let devices =
            Devices { gpu: plan.gpu.clone(), clock: Some(clock), measure: plan.measure, wake: Arc::new(|| {}) };
        let inspector = Inspector::new(devices, renderer.clone(), Box::new(host));
        let harness = Harness::builder()
            // The harness adds a margin of 8 points around its contents.
            .with_size(egui::Vec2::from(plan.size) + egui::Vec2::splat(16.0))
            .with_pixels_per_point(plan.scale)
            .with_theme(plan.theme)
            .with_render_cursor(false)
            .with_options(snapshot_options())
            .renderer(Painter { gpu: plan.gpu.clone(), renderer: renderer.clone(), retained: retained.clone() })
            .build_ui_state(|ui, inspector: &mut Inspector| inspector.ui(ui), inspector);
        Self { harness, desk, heard: Heard::default(), gpu: plan.gpu, renderer, retained }
    }

    /// A stage of the default size with a scene open, after some passes.
    pub(crate) fn with_scene(path: &str, settings: Settings, arrival: Arrival) -> Self {
        let mut stage = Self::new(Plan::default());
        stage.open(path, settings, arrival);
        stage
    }

    pub(crate) fn open(&mut self, path: &str, settings: Settings, arrival: Arrival) {
        self.inspector().open(path, settings, arrival);
        self.settle();
    }

    pub(crate) fn inspector(&mut self) -> &mut Inspector {
        self.harness.state_mut()
    }

    pub(crate) fn place(&self) -> usize {
        self.harness.state().model().place
    }

    /// Draws a frame for every waiting event, at least one.
    pub(crate) fn frame(&mut self) {
        self.harness.step();
        let output = self.harness.output();
        for command in &output.platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                self.heard.copied.push(text.clone());
            }
        }
        let commands = output.viewport_output.values().flat_map(|viewport| &viewport.commands);
        self.heard.is_closed |= commands.into_iter().any(|c| *c == egui::ViewportCommand::Close);
    }

    pub(crate) fn frames(&mut self, count: usize) {
        (0..count).for_each(|_| self.frame());
    }

    /// Draws frames until nothing is pending, plus a few for layouts that take several to settle.
    #[track_caller]
    pub(crate) fn settle(&mut self) {
        self.until("the work ends", |stage| !stage.harness.state().is_busy());
        let mut calm = 0;
        while calm < 5 {
            self.frame();
            calm += 1;
            if self.harness.state().is_busy() {
                self.until("the work ends", |stage| !stage.harness.state().is_busy());
                calm = 0;
            }
        }
    }

    /// Draws frames until `holds` is true.
    #[track_caller]
    pub(crate) fn until(&mut self, what: &str, holds: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        loop {
            self.frame();
            if holds(self) {
                return;
            }
            assert!(begin.elapsed() < PATIENCE, "not within {PATIENCE:?}: {what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    pub(crate) fn perform(&mut self, command: Command) {
        self.inspector().perform(command);
        self.settle();
    }

    /// Shows a layout as it is at first.
    pub(crate) fn arrange(&mut self, layout: Layout) {
        self.perform(Command::Arrange(layout));
        self.perform(Command::ResetLayout);
    }

    /// Closes all panels, also those behind tabs.
    pub(crate) fn close_panels(&mut self) {
        while let Some(&kind) = self.harness.state().panes_in_view().first() {
            self.perform(Command::Show(kind));
        }
    }

    /// The same, but goes on at once.
    pub(crate) fn perform_without_waiting(&mut self, command: Command) {
        self.inspector().perform(command);
        self.frame();
    }

    /// Presses and releases a key, one event per frame.
    pub(crate) fn key(&mut self, modifiers: Modifiers, key: Key) {
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        let held = [Event::ModifiersChanged(modifiers), event(true), event(false)];
        for event in held.into_iter().chain([Event::ModifiersChanged(Modifiers::NONE)]) {
            self.event(event);
        }
    }

    pub(crate) fn event(&mut self, event: Event) {
        self.harness.input_mut().events.push(event);
        self.frame();
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.event(Event::Text(text.into()));
    }

    /// Writes into the field with this name.
    pub(crate) fn fill(&mut self, name: &str, text: &str) {
        self.get(Role::TextInput, name).focus();
        self.frame();
        self.key(Modifiers::COMMAND, Key::A);
        self.text(text);
        self.frame();
    }

    /// Types into the open dialog and confirms it.
    pub(crate) fn answer(&mut self, text: &str) {
        self.frame();
        self.text(text);
        self.key(Modifiers::NONE, Key::Enter);
        self.settle();
    }

    pub(crate) fn click_at(&mut self, pos: egui::Pos2) {
        self.event(Event::PointerMoved(pos));
        for pressed in [true, false] {
            let button = egui::PointerButton::Primary;
            self.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
        }
        self.event(Event::PointerGone);
    }

    /// All accessibility nodes.
    pub(crate) fn nodes(&self) -> Vec<Node<'_>> {
        let root = self.harness.root();
        root.children_recursive().filter(|node| !node.accesskit_node().is_hidden()).collect()
    }

    /// The first node with this role and a matching name.
    pub(crate) fn find(&self, role: Role, is_so: impl Fn(&str) -> bool) -> Option<Node<'_>> {
        self.nodes().into_iter().find(|node| {
            let node = node.accesskit_node();
            node.role() == role && node.label().is_some_and(|label| is_so(&label))
        })
    }

    /// The node with this role and name, which must exist.
    #[track_caller]
    pub(crate) fn get(&self, role: Role, name: &str) -> Node<'_> {
        self.find(role, |label| label == name).unwrap_or_else(|| panic!("no {role:?} {name:?} in\n{}", self.read_out()))
    }

    #[track_caller]
    pub(crate) fn click(&mut self, role: Role, name: &str) {
        self.get(role, name).click_accesskit();
        self.frame();
    }

    /// Whether a visible text contains this.
    pub(crate) fn reads(&self, part: &str) -> bool {
        let text = |node: &Node<'_>| {
            let node = node.accesskit_node();
            [node.label(), node.value()].into_iter().flatten().any(|text| text.contains(part))
        };
        self.nodes().iter().any(text)
    }

    /// Everything that has a name, for failure messages.
    pub(crate) fn read_out(&self) -> String {
        let line = |node: &Node<'_>| {
            let node = node.accesskit_node();
            let text = node.label().or(node.value())?;
            Some(format!("{:?} {text:?}", node.role()))
        };
        self.nodes().iter().filter_map(line).collect::<Vec<_>>().join("\n")
    }

    /// Shows another stream, or only one of its components, as a user does.
    pub(crate) fn show_stream(&mut self, stream: Stream, layer: &str) {
        self.click(Role::ComboBox, "stream");
        self.frames(2);
        self.click(Role::Button, stream.name());
        // A pointer click closes the list, but a screen reader's click leaves it open.
        self.key(Modifiers::NONE, Key::Escape);
        self.settle();
        self.click(Role::Button, layer);
        self.settle();
    }

    /// The value of a number field, by its label.
    #[track_caller]
    pub(crate) fn number(&self, name: &str) -> f64 {
        self.get(Role::SpinButton, name).accesskit_node().numeric_value().expect("a number")
    }

    /// The painted texts that are not clipped away, in order.
    pub(crate) fn painted(&self) -> Vec<String> {
        fn collect(shape: &egui::Shape, clip: egui::Rect, texts: &mut Vec<String>) {
            match shape {
                egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, clip, texts)),
                egui::Shape::Text(text) if text.visual_bounding_rect().intersects(clip) => {
                    texts.push(text.galley.text().to_owned());
                }
                _ => {}
            }
        }
        let mut texts = Vec::new();
        for clipped in &self.harness.output().shapes {
            collect(&clipped.shape, clipped.clip_rect, &mut texts);
        }
        texts
    }

    /// Whether a painted text contains this.
    pub(crate) fn paints(&self, part: &str) -> bool {
        self.painted().iter().any(|text| text.contains(part))
    }

    /// Compares the window with the image and the text of this name.
    #[track_caller]
    pub(crate) fn snapshot(&mut self, name: &str) {
        self.harness.snapshot(name);
        self.snapshot_of_text(name);
    }

    /// Compares all painted text with the file of this name: not a digit may differ.
    #[track_caller]
    fn snapshot_of_text(&self, name: &str) {
        let path = std::path::Path::new(SNAPSHOTS).join(format!("{name}.txt"));
        let painted = self.painted().iter().map(|text| format!("{text:?}\n")).collect::<String>();
        if std::env::var("UPDATE_SNAPSHOTS").is_ok_and(|value| !matches!(value.as_str(), "" | "0" | "false")) {
            std::fs::write(&path, painted).expect("a folder that can be written to");
            return;
        }
        let kept = std::fs::read_to_string(&path);
        let kept = kept.unwrap_or_else(|e| panic!("{}: {e}; UPDATE_SNAPSHOTS=1 writes it", path.display()));
        // A checkout may change line ends.
        let differs = kept.lines().zip(painted.lines()).find(|(kept, painted)| kept != painted);
        if let Some((kept, painted)) = differs {
            panic!("{name}: {painted} is painted, and {} has {kept}", path.display());
        }
        assert_eq!(
            kept.lines().count(),
            painted.lines().count(),
            "{name}: texts more or fewer than {}",
            path.display()
        );
    }
}

/// Folder of the snapshots.
const SNAPSHOTS: &str = "tests/ui/snapshots";

/// Images differ between versions of Mesa in the rounding of blends, and in texels at the edges of images with
/// nearest-neighbour filtering. 0.6 is kittest's own bound for such rounding in a pixel; at edges, a few dozen pixels
/// may change. A digit has fewer pixels than that, so texts are compared separately.
fn snapshot_options() -> SnapshotOptions {
    SnapshotOptions::new().threshold(0.6).max_failed_pixels(40).output_path(SNAPSHOTS)
}
