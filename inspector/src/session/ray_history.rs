//! The history of the selected ray: at once from the CPU reference kernels, then confirmed by the device's own streams;
//! from the session's streams where only they know it.

use std::sync::Arc;

use raystep_kernels::Accelerator;
use raystep_kernels::export::trace::{RunSoFar, Trace, TraceRow};

use super::engine::FOLLOWING;
use super::request::Request;
use super::{HistorySource, Model, Subject};
use crate::settings::DeviceKind;

impl Model {
    /// Selects a pixel's ray, or another element. A ray's history is there at once if the CPU reference kernels can tell it; otherwise the
    /// session is asked for it, once it has no other work.
    pub fn follow(&mut self, subject: impl Into<Subject>) {
        let subject: Subject = subject.into();
        let pixel = subject.texel;
        if let Some(history) = self.reference(pixel).filter(|_| subject.set.is_none()) {
            self.followed = Some(subject);
            (self.history, self.reference_history) = (Some(Arc::new(history)), None);
            let is_gpu = self.opened.as_ref().is_some_and(|opened| opened.settings.device == DeviceKind::Gpu);
            // On the CPU they are the session's own kernels.
            self.history_source = if is_gpu { HistorySource::Reference } else { HistorySource::Device };
            self.ask(Request::Confirm(pixel));
        } else if !self.is_busy() {
            self.followed = Some(subject);
            self.ask(Request::Follow(subject));
        }
    }

    /// A pixel whose ray has a history worth looking at: it goes through some cells or nodes, tests triangles and hits
    /// one. The nearest to the centre of some, if possible of those that step along several axes and start on no plane;
    /// `None` if there is none, or histories are too long to search.
    #[must_use]
    pub fn telling_pixel(&self) -> Option<[u32; 2]> {
        let plan = &self.opened.as_ref().filter(|opened| opened.plan.accelerator != Accelerator::None)?.plan;
        let (mut rows, mut plain) = (0, None);
        for [x, y] in from_the_middle() {
            let [x, y] =
                [(x, plan.width), (y, plan.height)].map(|(part, side)| (part * side / (2 * ALONG)).min(side - 1));
            let history = self.reference([x, y])?;
            match is_telling(&history) {
                true if shows_the_loop(&history) => return Some([x, y]),
                true => plain = plain.or(Some([x, y])),
                false => {}
            }
            rows += history.rows.len();
            if rows > MOST_ROWS {
                break;
            }
        }
        plain
    }

    /// The history of the ray under the cursor by the CPU reference kernels, if they can tell it.
    pub fn glance(&mut self, pixel: Option<[u32; 2]>) -> Option<&Arc<Trace>> {
        let Some(pixel) = pixel else {
            self.glanced = None;
            return None;
        };
        if self.glanced.as_ref().is_none_or(|seen| seen.pixel != pixel) {
            self.glanced = self.reference(pixel).map(Arc::new);
        }
        self.glanced.as_ref()
    }

    /// The ray under the cursor, see [`glance`](Self::glance).
    #[must_use]
    pub fn glanced(&self) -> Option<&Arc<Trace>> {
        self.glanced.as_ref()
    }

    /// Whether this ray or other element has yet to be followed.
    #[must_use]
    pub fn is_to_follow(&self, subject: impl Into<Subject>) -> bool {
        let subject: Subject = subject.into();
        self.has(&subject) && self.followed != Some(subject)
    }

    /// Whether the run has such elements.
    #[must_use]
    pub fn has(&self, subject: &Subject) -> bool {
        let plan = self.opened.as_ref().map(|opened| &opened.plan);
        plan.is_some_and(|plan| subject.set.is_none() || subject.decoding(plan).is_some())
    }

    /// Whether a row of the selected ray's history is of a pass that has not run yet.
    #[must_use]
    pub fn is_predicted(&self, row: &TraceRow) -> bool {
        self.history.as_ref().is_some_and(|history| history.passes.is_none()) && !row.is_within(self.passes.len())
    }

    /// A pixel's ray by the CPU reference kernels. `None` if only the session knows its history: after an edit, with
    /// passes on the CPU reference, or for a ray that was entered.
    fn reference(&self, pixel: [u32; 2]) -> Option<Trace> {
        let opened = self.opened.as_ref().filter(|_| self.edits.is_empty() && self.twins.is_none())?;
        let (plan, data) = (&opened.plan, &opened.data);
        let run = RunSoFar { plan, data, passes: &self.passes, is_complete: self.is_complete };
        match opened.settings.device {
            DeviceKind::CpuF64 => run.follow::<f64>(pixel),
            DeviceKind::Auto | DeviceKind::Gpu | DeviceKind::Cpu => run.follow::<f32>(pixel),
        }
    }

    /// The device's history has arrived, or why there is none.
    pub(super) fn compare(&mut self, device: Result<Box<Trace>, String>) {
        let Some(history) = self.history.clone().filter(|_| self.history_source == HistorySource::Reference) else {
            return;
        };
        match device {
            Err(why) => self.history_source = HistorySource::Unconfirmed(why),
            Ok(device) if device.pixel == history.pixel => {
                let rows = device.rows.len().max(history.rows.len());
                let differs = |&row: &usize| text(device.rows.get(row)) != text(history.rows.get(row));
                let differing: Vec<usize> = (0..rows).filter(differs).collect();
                if !differing.is_empty() {
                    let mut shown = Trace { rays: history.rays, passes: history.passes, ..*device };
                    number(&mut shown.rows, &history.rows);
                    (self.history, self.reference_history) = (Some(Arc::new(shown)), Some(history));
                }
                self.history_source = HistorySource::Compared { differing };
            }
            Ok(_) => {}
        }
    }

    /// Work was cancelled: if it was to confirm the history, that stays unconfirmed.
    pub(super) fn unconfirmed(&mut self, what: &str) {
        if self.history_source == HistorySource::Reference && what == FOLLOWING {
            self.history_source = HistorySource::Unconfirmed("cancelled".into());
        }
    }

    /// More passes are known, or the streams have changed.
    pub(super) fn follow_on(&mut self, is_changed: bool) {
        self.glanced = None;
        let Some(Subject { set, texel: pixel }) = self.followed else { return };
        if is_changed {
            self.followed = None;
            return;
        }
        if set.is_some() {
            return;
        }
        if self.history_source == HistorySource::Device
            && self.history.as_ref().is_none_or(|history| history.passes.is_some())
        {
            return;
        }
        let Some(fresh) = self.reference(pixel) else { return };
        match (&self.history_source, &self.history) {
            (HistorySource::Compared { differing }, Some(history)) if !differing.is_empty() => {
                let mut shown = Trace { passes: fresh.passes, ..Trace::clone(history) };
                number(&mut shown.rows, &fresh.rows);
                (self.history, self.reference_history) = (Some(Arc::new(shown)), Some(Arc::new(fresh)));
            }
            _ => self.history = Some(Arc::new(fresh)),
        }
    }
}

/// Pixels along a side that are looked at for a history.
const ALONG: u32 = 5;
/// Most rows of all their histories.
const MOST_ROWS: usize = 20_000;
/// Fewest cells or nodes of a walk worth looking at.
const LEAST_PLACES: usize = 4;

/// Odd numerators below twice [`ALONG`], in pairs: the middles of tiles of a picture, the nearest to its centre first.
fn from_the_middle() -> Vec<[u32; 2]> {
    let mut tiles: Vec<[u32; 2]> = (0..ALONG).flat_map(|y| (0..ALONG).map(move |x| [2 * x + 1, 2 * y + 1])).collect();
    tiles.sort_by_key(|tile| tile.iter().map(|&at| at.abs_diff(ALONG).pow(2)).sum::<u32>());
    tiles
}

/// Whether a ray goes through some cells or nodes, tests triangles and hits one.
fn is_telling(history: &Trace) -> bool {
    let mut places: Vec<_> = history.rows.iter().filter_map(|row| row.index_after).collect();
    places.dedup();
    let hits = history.rows.last().is_some_and(|row| row.after.triangle.is_some());
    hits && places.len() >= LEAST_PLACES && history.rows.iter().any(|row| row.tested.is_some())
}

/// Whether a ray in a grid steps along several axes, and does not start on a plane of the grid, where it leaves its cell
/// at once. In other structures, any does.
fn shows_the_loop(history: &Trace) -> bool {
    let cells: Vec<_> = history.rows.iter().filter_map(|row| row.cell_after).collect();
    let Some(first) = history.rows.iter().find(|row| row.cell_after.is_some()) else { return true };
    let steps = |axis: usize| cells.windows(2).any(|pair| pair[0][axis] != pair[1][axis]);
    first.after.tmax.iter().flatten().all(|&t| t > 0.0) && (0..3).filter(|&axis| steps(axis)).count() > 1
}

/// A row without the number of its pass, with all digits of its floats.
fn text(row: Option<&TraceRow>) -> Option<String> {
    row.map(|row| format!("{:?}", TraceRow { pass: None, ..row.clone() }))
}

/// Takes over the numbers of passes of rows with the same kernels.
fn number(rows: &mut [TraceRow], from: &[TraceRow]) {
    for (row, from) in rows.iter_mut().zip(from).take_while(|(row, from)| row.kernel == from.kernel) {
        row.pass = from.pass;
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::export::trace::{Rays, trace};
    use raystep_kernels::{Device, Renderer};
    use raystep_scenes::generate;

    use super::*;
    use crate::session::request::Opened;
    use crate::settings::Settings;

    const PIXEL: [u32; 2] = [9, 7];

    /// A model of a run at its end, without an engine that answers; and the device's history of a ray.
    fn model(device: DeviceKind) -> (Model, Trace) {
        let scene = Arc::new(generate::cornell_box());
        let settings = Settings { size: [16, 16], device, ..Settings::default() };
        pollster::block_on(async {
            let options = settings.options(&scene);
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let [x, y] = PIXEL;
            let go_on = |_: &_| ControlFlow::Continue(());
            let history = trace(&mut renderer, x, y, Rays::One, go_on).await.expect("a history");
            renderer.restart();
            renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
            // The task is kept: a model whose task is gone reports a bug.
            let (mut model, task) = Model::new(|engine| Box::pin(async move { drop(engine) }));
            std::mem::forget(task);
            model.passes = renderer.passes().to_vec();
            (model.place, model.is_complete) = (model.passes.len(), true);
            model.opened = Some(Opened {
                path: None,
                scene,
                settings,
                plan: renderer.shared_plan(),
                data: renderer.shared_data(),
                textures: Vec::new(),
                device: String::new(),
                why_no_times: None,
            });
            (model, history)
        })
    }

    #[test]
    fn a_history_is_there_at_once_and_then_confirmed() {
        let (mut model, device) = model(DeviceKind::Gpu);
        assert!(model.is_to_follow(PIXEL));
        model.follow(PIXEL);
        assert!(!model.is_to_follow(PIXEL) && model.is_to_follow([0, 0]));
        let history = model.history.clone().expect("a history");
        assert_eq!((history.pixel, &model.history_source), (PIXEL, &HistorySource::Reference));
        assert!(history.rows.iter().all(|row| !model.is_predicted(row)));
        model.compare(Ok(Box::new(Trace { pixel: [0, 0], ..device.clone() })));
        assert_eq!(model.history_source, HistorySource::Reference, "another ray's history confirms nothing");
        model.compare(Ok(Box::new(device)));
        assert_eq!(model.history_source, HistorySource::Compared { differing: Vec::new() });
        assert!(
            model.history.as_ref().is_some_and(|shown| Arc::ptr_eq(shown, &history))
                && model.reference_history.is_none()
        );
    }

    #[test]
    fn a_difference_is_shown_with_the_devices_values() {
        let (mut model, mut device) = model(DeviceKind::Gpu);
        model.follow(PIXEL);
        let reference = model.history.clone().expect("a history");
        device.rows[3].after.tmax[1] = Some(0.125);
        let last = device.rows.len() - 1;
        device.rows.push(device.rows[last].clone());
        model.compare(Ok(Box::new(device)));
        assert_eq!(model.history_source, HistorySource::Compared { differing: vec![3, last + 1] });
        let shown = model.history.clone().expect("a history");
        assert_eq!((shown.rows[3].after.tmax[1], shown.rows.len()), (Some(0.125), last + 2));
        // The device followed the ray alone, and does not know when all rays are shaded.
        assert!(shown.rows[last].pass.is_some() && shown.rows[last].pass == reference.rows[last].pass);
        assert!(model.reference_history.as_ref().is_some_and(|kept| Arc::ptr_eq(kept, &reference)));
    }

    #[test]
    fn a_history_that_cannot_be_confirmed_says_why() {
        let (mut model, _) = self::model(DeviceKind::Gpu);
        model.follow(PIXEL);
        model.compare(Err("the device was lost".into()));
        assert_eq!(model.history_source, HistorySource::Unconfirmed("the device was lost".into()));
        let (mut cpu, _) = self::model(DeviceKind::Cpu);
        let all = cpu.passes.clone();
        cpu.passes.truncate(all.len() / 2);
        cpu.is_complete = false;
        cpu.follow(PIXEL);
        assert_eq!(cpu.history_source, HistorySource::Device, "they are its own kernels");
        let predicted = |model: &Model| {
            let history = model.history.clone().expect("a history");
            let count = history.rows.iter().rev().take_while(|row| model.is_predicted(row)).count();
            (count, history.rows.len())
        };
        let (count, rows) = predicted(&cpu);
        assert!(count > 0 && count < rows, "{count} of {rows}");
        (cpu.passes, cpu.is_complete) = (all, true);
        cpu.follow_on(false);
        assert_eq!(predicted(&cpu), (0, rows));
        // With the streams changed by hand, only the session knows.
        cpu.twins = Some(3);
        cpu.follow_on(true);
        assert!(cpu.is_to_follow(PIXEL));
    }
}
