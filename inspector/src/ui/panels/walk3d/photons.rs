//! Photons in the 3D view: where they are stored, the search of the selected pixel, and the way of the selected photon.

use std::sync::Arc;

use egui::{DragValue, Ui};
use glam::DVec2;
use raystep_kernels::Kernel;
use raystep_kernels::programs::photons::stored::{self, Stored};
use raystep_lab::text::counted;

use super::super::walked::{Walked, number};
use crate::draw::scene3d::{PhotonPaint, Settings};
use crate::orbit::Orbit;
use crate::photons::{Photons, Searched, path};
use crate::session::request::{Job, JobContext, Opened, Request, answered, job};
use crate::session::{Model, Subject};
use crate::ui::choice::Choices as _;
use crate::ui::pane::Context;
use crate::ui::units::Scale;
use crate::walk::{Aabb, to_f64};

/// The engine's job, named while it runs.
const READING: &str = "reading stored photons";
/// How far from the cursor a photon may be that is meant, in points.
const NEAR: f64 = 6.0;

const PAINTS: [(PhotonPaint, &str, &str); 3] = [
    (PhotonPaint::Power, "power", "the hue of a photon's power, brighter the larger it is"),
    (PhotonPaint::Bounce, "bounce", "dark (first bounce at which photons are stored) to bright (last)"),
    (PhotonPaint::Map, "map", "orange: came by mirrors and glass alone; blue: all others"),
];

/// The streams of a run as of some pass: its edition, and how many passes before had written them.
type Written = (u64, usize);

/// What the engine has read.
struct Read {
    edition: u64,
    place: usize,
    photons: Vec<Stored>,
}

/// The photons of the run up to the current pass.
#[derive(Default)]
pub(super) struct Layer {
    known: Option<(Written, Vec<Stored>)>,
    asked: Option<Written>,
    /// What `shown` was made from: what is known, and the walk's version.
    made: Option<(Option<Written>, u64)>,
    pub(super) shown: Arc<Photons>,
    /// Incremented with every change.
    pub(super) version: u64,
}

/// How many of the passes so far may have stored photons; `None` if the run stores none.
fn written(model: &Model, opened: &Opened, place: usize) -> Option<Written> {
    let plan = stored::has_photons(&opened.plan).then_some(&opened.plan)?;
    // Looked up once: there may be many passes, and this is for every frame.
    let writers = plan.variants.iter().filter(|variant| variant.written_streams().any(|s| s == stored::RECORDS));
    let writers: Vec<Kernel> = writers.map(|variant| variant.kernel).collect();
    let passes = model.passes.get(..place).unwrap_or(&model.passes);
    Some((model.edition, passes.iter().filter(|pass| writers.contains(&pass.kernel)).count()))
}

impl Layer {
    /// Reads photons where those that are known are not those of this pass. Returns whether what is to be drawn is new.
    pub(super) fn update(
        &mut self,
        cx: &mut Context<'_>,
        opened: &Opened,
        walked: &Walked,
        settings: &Settings,
        scene: &Aabb,
    ) -> bool {
        while let Some(read) = cx.model.take_answer::<Read>(READING) {
            let Read { edition, place, photons } = *read;
            let of = written(cx.model, opened, place).filter(|now| now.0 == edition);
            self.known = of.map(|of| (of, photons));
        }
        let now = written(cx.model, opened, cx.model.place);
        let is_wanted = settings.photons || settings.search || cx.selection.element.is_some();
        match now {
            None => (self.known, self.asked) = (None, None),
            Some((_, 0)) => self.known = now.map(|now| (now, Vec::new())),
            _ if self.of() != now && is_wanted && self.asked != now && !cx.model.is_busy() => {
                self.asked = now;
                cx.model.ask(Request::Job(READING, read(cx.model.edition)));
            }
            _ => {}
        }
        let made = (self.of(), walked.version);
        if self.made.replace(made) == Some(made) {
            return false;
        }
        self.make(opened, walked, scene);
        self.version += 1;
        true
    }

    /// What the known photons are of.
    fn of(&self) -> Option<Written> {
        self.known.as_ref().map(|(of, _)| *of)
    }

    fn make(&mut self, opened: &Opened, walked: &Walked, scene: &Aabb) {
        let photons = self.known.as_ref().map_or(&[][..], |(_, photons)| photons);
        let history = walked.history.as_ref();
        let rows = walked.row.map_or(0, |row| row + 1);
        // The pixel's search stays while a photon that it took is looked at.
        let (search, path, stops) = match history.and_then(|history| Some((history, history.element?))) {
            Some((history, element)) if element.set == stored::SET.name => {
                let stops = photons.iter().filter(|at| at.photon == element.index).copied();
                (self.shown.search.clone(), path(history, rows, scene), stops.collect())
            }
            _ => {
                let rows = history.and_then(|history| history.rows.get(..rows));
                let search = rows.and_then(|rows| Searched::of(rows, &opened.data, photons));
                (search, Vec::new(), Vec::new())
            }
        };
        self.shown = Arc::new(Photons { search, path, stops, ..Photons::of(photons) });
    }

    /// What is shown, in words; lengths in the units of the panel.
    pub(super) fn told(&self, settings: &Settings, scale: &Scale) -> Vec<String> {
        let Some((_, photons)) = &self.known else { return Vec::new() };
        let dots = (settings.photons && !photons.is_empty()).then(|| self.shown.sentence());
        let search = self.shown.search.as_ref().filter(|_| settings.search);
        let search = search.map(|search| search.sentence(|length| number(length * scale.length(1.0))));
        let way = match self.shown.path.len() {
            0 => None,
            points => Some(format!(
                "the photon's way has {}, and it is stored at {}",
                counted(points - 1, "segment"),
                counted(self.shown.stops.len(), "place")
            )),
        };
        [dots, search, way].into_iter().flatten().collect()
    }

    /// The photon under the cursor that is nearest to the eye.
    pub(super) fn under(&self, camera: &Orbit, at: DVec2, size: DVec2, settings: &Settings) -> Option<Stored> {
        let dots = self.shown.dots.iter().filter(|_| settings.photons);
        let taken = self.shown.search.iter().filter(|_| settings.search).flat_map(|search| &search.taken);
        let seen = dots.chain(taken).chain(&self.shown.stops).filter_map(|photon| {
            let (pixel, depth) = camera.pixel(to_f64(photon.point), size)?;
            ((pixel - at).length() <= NEAR).then_some((depth, *photon))
        });
        seen.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, photon)| photon)
    }

    /// Switches and colours, and the number of the selected photon.
    pub(super) fn choices(ui: &mut Ui, settings: &mut Settings, cx: &mut Context<'_>, opened: &Opened) {
        ui.separator();
        ui.checkbox(&mut settings.photons, "stored photons")
            .on_hover_text("where photons are stored; large dots came by mirrors and glass alone");
        ui.horizontal(|ui| {
            ui.label("coloured by");
            for (paint, name, text) in PAINTS {
                ui.choice_of(&mut settings.photon_paint, paint, name).on_hover_text(text);
            }
        });
        ui.checkbox(&mut settings.search, "the pixel's photons").on_hover_text(
            "the cells that it searches, dark (first) to bright (last), the circle, and the photons taken",
        );
        let map = &opened.data.photon_map;
        let selected = cx.selection.element.filter(|element| element.set == Some(stored::SET));
        let mut index = selected.map_or(0, |Subject { texel: [x, y], .. }| y * map.row + x);
        ui.horizontal(|ui| {
            let label = ui.label("photon");
            let field = DragValue::new(&mut index).range(0..=map.photons.saturating_sub(1));
            let field = field.update_while_editing(false);
            let field = ui.add(field).labelled_by(label.id);
            let text = "its history is in the panel of the ray, and its way in this view";
            let is_asked = ui.button("Follow photon").on_hover_text(text).clicked();
            if is_asked || field.on_hover_text(text).changed() {
                cx.asks.follow = Some(subject(index, opened));
            }
        });
    }
}

/// A photon, to be selected.
pub(super) fn subject(index: u32, opened: &Opened) -> Subject {
    let row = opened.data.photon_map.row.max(1);
    Subject { set: Some(stored::SET), texel: [index % row, index / row] }
}

/// A photon in words, for what is under the cursor.
pub(super) fn name(photon: &Stored) -> String {
    let [r, g, b] = photon.power;
    let map = if photon.is_caustic { "caustic photon" } else { "photon" };
    format!(
        "{map} {}, bounce {}, power r {r:.2e} g {g:.2e} b {b:.2e}\nclick: its history",
        photon.photon, photon.bounce
    )
}

fn read(edition: u64) -> Job {
    job!(context, {
        let JobContext { session, .. } = context;
        let records = session.stream(stored::RECORDS).await.map_err(|error| error.to_string())?;
        answered(Read { edition, place: session.place(), photons: stored::stored(&records) })
    })
}
