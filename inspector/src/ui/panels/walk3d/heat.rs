//! Colours by cost: how often all rays test each triangle, or come to each cell or leaf.

use std::sync::Arc;

use egui::{Sense, Ui, vec2};
use raystep_kernels::options::features::StructureKind;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Device, RenderError, Renderer};
use raystep_lab::text::counted;
use raystep_lab::work::{CostOrder, Visits, has_single_steps, single_steps, visits};
use serde::{Deserialize, Serialize};

use crate::draw::scene3d::{PaintedBox, Scene3d};
use crate::draw::stream::Colors;
use crate::session::request::{Job, JobContext, Request, answered, flow, job};
use crate::ui::choice::Choices as _;
use crate::ui::pane::Context;
use crate::ui::panels::cost::scale::{self, Scale};
use crate::ui::state::Picked;
use crate::walk::Aabb;

/// The engine's job, named while it runs.
const COUNTING: &str = "counting tests and visits of all rays";
/// Most boxes shown: more would hide each other.
const MOST_BOXES: usize = 400;
/// Counts differ by orders of magnitude.
const SCALE: Scale = Scale { colors: Colors::Viridis, is_log: true };
/// What no ray tests.
const UNTESTED: [u8; 4] = [120, 122, 126, 255];

/// What colours tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Paint {
    #[default]
    Materials,
    Tests,
    Places,
}

impl Paint {
    const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Materials, "materials", "the colours of the scene"),
        (Self::Tests, "tests", "how often all rays, one per pixel, are tested against each triangle"),
        (Self::Places, "visits", "how often all rays, one per pixel, come to each cell or leaf"),
    ];

    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(paint, ..)| *paint == self).map_or("", |(_, name, _)| name)
    }

    /// The next one.
    pub(super) fn next(self) -> Self {
        match self {
            Self::Materials => Self::Tests,
            Self::Tests => Self::Places,
            Self::Places => Self::Materials,
        }
    }
}

/// What the engine counted.
struct Counted {
    edition: u64,
    /// The scene as the rays that were counted saw it.
    data: Arc<SceneData>,
    /// Whether its structure is that of the run.
    is_same: bool,
    visits: Visits,
}

/// What the colours found, in words.
struct Told {
    text: String,
    hottest: Option<Hottest>,
    /// After its name.
    rest: String,
}

/// What has the highest count.
struct Hottest {
    count: u32,
    /// What is counted.
    what: &'static str,
    name: String,
    picked: Option<Picked>,
}

/// The colours of the run.
#[derive(Default)]
pub(super) struct Heat {
    known: Option<Counted>,
    asked: Option<u64>,
    /// The run and what its triangles and boxes were painted by.
    painted: (u64, Option<(u64, Paint)>),
    /// What was found, found once for each painting.
    told: Option<Told>,
    /// Changes with every painting.
    pub(super) version: u64,
}

impl Heat {
    /// Chooses what colours tell.
    pub(super) fn choose(ui: &mut Ui, paint: &mut Paint) {
        egui::ComboBox::from_id_salt("colours")
            .selected_text(paint.name())
            .width(84.0)
            .show_ui(ui, |ui| {
                for (choice, name, about) in Paint::ALL {
                    ui.choice_of(paint, choice, name).on_hover_text(about);
                }
            })
            .response
            .on_hover_text("what the colours tell: materials, or the cost of all rays")
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "colours"));
    }

    /// Takes and asks for counts, and paints the scene by them.
    pub(super) fn update(&mut self, cx: &mut Context<'_>, paint: Paint, scene: &mut Scene3d, data: &SceneData) {
        let (generation, edition) = (cx.model.generation, cx.model.edition);
        while let Some(answer) = cx.model.take_answer::<Counted>(COUNTING) {
            self.known = Some(*answer);
        }
        if paint == Paint::Materials {
            // Chosen again, they are counted again if that was cancelled.
            self.asked = None;
        } else if self.of(edition).is_none()
            && self.asked != Some(edition)
            && cx.has_rays()
            && !cx.model.passes.is_empty()
            && !cx.model.is_busy()
        {
            self.asked = Some(edition);
            cx.model.ask(Request::Job(COUNTING, count(edition)));
        }
        let by = self.of(edition).map(|_| (edition, paint)).filter(|(_, paint)| *paint != Paint::Materials);
        let now = (generation, by);
        // A new run has been drawn in the colours of its materials.
        let is_done = self.painted == now || (by.is_none() && self.painted.0 != generation);
        self.painted = now;
        if !is_done {
            let known = self.of(edition).filter(|_| by.is_some());
            let (colors, boxes) = known.map_or_else(Default::default, |known| known.painted(paint));
            let told = known.map(|known| known.told(paint));
            scene.paint(data, colors.as_deref(), boxes);
            self.told = told;
            self.version += 1;
        }
    }

    /// What the colours found, and their scale.
    pub(super) fn show(&self, ui: &mut Ui, cx: &mut Context<'_>, paint: Paint) {
        if paint == Paint::Materials {
            return;
        }
        let Some(told) = self.of(cx.model.edition).and(self.told.as_ref()) else {
            let text = match (cx.has_rays(), cx.model.passes.is_empty(), cx.model.is_busy()) {
                (false, ..) => "This program traces no rays.".into(),
                (_, true, _) => "No pass has run yet.".into(),
                (.., true) => format!("{COUNTING} …"),
                _ => "Not counted: choose the colours again.".into(),
            };
            ui.weak(text);
            return;
        };
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            ui.label(&told.text);
            if let Some(Hottest { count, name, picked, .. }) = &told.hottest {
                let link = ui.link(format!("{count} of {name}"));
                if link.on_hover_text(format!("select {name}")).clicked() {
                    cx.selection.picked = *picked;
                }
                ui.label(&told.rest);
            }
        });
        let Some(Hottest { count, what, .. }) = told.hottest else { return };
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), scale::HEIGHT), Sense::hover());
        SCALE.paint(ui, &ui.painter_at(rect), rect, count);
        let text = format!("colours from 0 to {count} {what}, logarithmic");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        response.on_hover_text(text);
    }

    fn of(&self, edition: u64) -> Option<&Counted> {
        self.known.as_ref().filter(|known| known.edition == edition)
    }
}

impl Counted {
    /// Counts of each triangle, cell or leaf; inner nodes contain what their leaves show.
    fn counts(&self, paint: Paint) -> std::borrow::Cow<'_, [u32]> {
        let is_tree = self.data.features.structure() == StructureKind::Bvh;
        match paint {
            Paint::Places if is_tree => {
                let nodes = self.visits.places.iter().zip(&self.data.bvh_nodes);
                nodes.map(|(&count, node)| if node.count() > 0 { count } else { 0 }).collect()
            }
            Paint::Places => self.visits.places.as_slice().into(),
            Paint::Tests | Paint::Materials => self.visits.triangles.as_slice().into(),
        }
    }

    /// What is counted, and what one count is.
    fn words(&self, paint: Paint) -> (&'static str, &'static str) {
        match (paint, self.data.features.structure()) {
            (Paint::Places, StructureKind::Bvh) => ("leaf", "visits"),
            (Paint::Places, _) => ("cell", "visits"),
            _ => ("triangle", "tests"),
        }
    }

    fn name(&self, paint: Paint, index: usize) -> String {
        match (self.words(paint).0, self.cell(index)) {
            ("cell", Some([x, y, z])) => format!("cell {x},{y},{z}"),
            (noun, _) => format!("{noun} {index}"),
        }
    }

    /// The coordinates of a cell of a uniform grid.
    fn cell(&self, index: usize) -> Option<[i32; 3]> {
        let is_grid = self.data.features.structure() == StructureKind::Grid;
        is_grid.then(|| self.data.grid.cell_of_index(index as u32))
    }

    /// A selection of it, if the run's structure has it.
    fn picked(&self, paint: Paint, index: usize) -> Option<Picked> {
        match (self.words(paint).0, self.cell(index)) {
            ("triangle", _) => Some(Picked::Triangle(index as u32)),
            ("leaf", _) if self.is_same => Some(Picked::Node(index as u32)),
            ("cell", Some(cell)) if self.is_same => super::picked::cell(cell),
            _ => None,
        }
    }

    fn bounds(&self, index: usize) -> Option<Aabb> {
        match self.data.features.structure() {
            StructureKind::None => None,
            StructureKind::Grid => Some(Aabb::of_cells(&self.data.grid, self.cell(index)?, [1; 3])),
            StructureKind::Irregular => {
                let [low, high] = self.data.irregular_cells.get(index)?.corners();
                Some(Aabb::of_cells(&self.data.grid, low, [0, 1, 2].map(|axis| high[axis] - low[axis])))
            }
            StructureKind::Bvh => self.data.bvh_nodes.get(index).map(|node| Aabb::of_f32(node.min, node.max)),
        }
    }

    fn told(&self, paint: Paint) -> Told {
        let counts = self.counts(paint);
        let Some((count, first)) = hottest(&counts) else {
            let text = match (paint, self.data.features.structure()) {
                (Paint::Places, StructureKind::None) => "This run has no grid and no BVH: rays visit nothing.",
                (Paint::Places, _) => "No ray comes to a cell or leaf.",
                _ => "No ray is tested against a triangle.",
            };
            return Told { text: text.into(), hottest: None, rest: String::new() };
        };
        let (noun, what) = self.words(paint);
        let seen = counts.iter().filter(|&&count| count > 0).count();
        let rest = match (paint, self.is_same) {
            (Paint::Places, _) if seen > MOST_BOXES => format!(". The first {MOST_BOXES} of {seen} are shown."),
            (_, false) => ", one step at a time.".into(),
            _ => ".".into(),
        };
        let (name, picked) = (self.name(paint, first), self.picked(paint, first));
        let hottest = Some(Hottest { count, what, name, picked });
        Told { text: sentence(&counts, noun, what) + " The most, ", hottest, rest }
    }

    /// Colours of triangles, and boxes.
    fn painted(&self, paint: Paint) -> (Option<Vec<[u8; 4]>>, Vec<PaintedBox>) {
        let counts = self.counts(paint);
        let most = counts.iter().copied().max().unwrap_or(0);
        let color = |count: u32, opacity: u8| {
            let [r, g, b] = SCALE.colors.at(SCALE.part(f64::from(count), most));
            [r, g, b, opacity]
        };
        if paint != Paint::Places {
            let of = |&count: &u32| if count == 0 { UNTESTED } else { color(count, 255) };
            return (Some(counts.iter().map(of).collect()), Vec::new());
        }
        let mut order: Vec<usize> = (0..counts.len()).filter(|&index| counts[index] > 0).collect();
        order.sort_by_key(|&index| std::cmp::Reverse(counts[index]));
        order.truncate(MOST_BOXES);
        let boxes = order.iter().filter_map(|&index| {
            let part = SCALE.part(f64::from(counts[index]), most);
            Some(PaintedBox { bounds: self.bounds(index)?, color: color(counts[index], (10.0 + 50.0 * part) as u8) })
        });
        (None, boxes.collect())
    }
}

/// The highest count, and what has it first; `None` if all are 0.
fn hottest(counts: &[u32]) -> Option<(u32, usize)> {
    let most = counts.iter().copied().max().filter(|&most| most > 0)?;
    Some((most, counts.iter().position(|&count| count == most)?))
}

/// How many of the counted things have half of all counts.
fn sentence(counts: &[u32], noun: &str, what: &str) -> String {
    let seen = counts.iter().filter(|&&count| count > 0).count();
    let order = CostOrder::new(counts.to_vec());
    let (total, half) = (order.total(), order.half());
    match seen {
        1 => format!("All {total} {what} are of one {noun}."),
        _ => format!("Half of all {total} {what} are of {half} of {}.", counted(seen, noun)),
    }
}

/// Runs all rays on the CPU reference kernels, one step a pass.
fn count(edition: u64) -> Job {
    job!(context, {
        let JobContext { session, scene, progress, .. } = context;
        let mut run = async || {
            let (run, options) = (session.renderer(), single_steps(session.options()));
            let is_same = has_single_steps(run.plan()) && session.options().samples.count == 1;
            let device = Device::Cpu(None);
            let mut renderer = if is_same {
                Renderer::from_plan(run.shared_plan(), run.shared_data(), &options, &device).await?
            } else {
                Renderer::new(scene, &options, &device).await?
            };
            let found = visits(&mut renderer, |now| flow(progress(now.rays_decided, now.rays))).await?;
            Ok(found.map(|visits| Counted { edition, data: renderer.shared_data(), is_same, visits }))
        };
        let counted = run().await.map_err(|error: RenderError| error.to_string())?;
        answered(counted.ok_or("this program has no passes of single steps")?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_says_how_few_have_half_of_the_cost() {
        assert_eq!(sentence(&[0, 5, 1, 4], "triangle", "tests"), "Half of all 10 tests are of 1 of 3 triangles.");
        assert_eq!(sentence(&[2, 2, 2, 2], "leaf", "visits"), "Half of all 8 visits are of 2 of 4 leaves.");
        assert_eq!(sentence(&[0, 7], "cell", "visits"), "All 7 visits are of one cell.");
        assert_eq!((hottest(&[0, 0]), hottest(&[]), hottest(&[1, 9, 9])), (None, None, Some((9, 1))));
    }
}
