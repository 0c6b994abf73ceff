//! The history of the selected ray: at once from the CPU reference kernels, then confirmed by the device's own streams;
//! from the session's streams where only they know it.

use std::sync::Arc;

use raystep_kernels::export::trace::{RunSoFar, Trace, TraceRow};

use super::Model;
use super::request::Request;
use crate::settings::DeviceKind;

/// Whose kernels a history is from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Told {
    /// The device's, from the session's own streams.
    #[default]
    Device,
    /// The CPU reference's; the device has yet to confirm it.
    Reference,
    /// The device's, compared with the CPU reference's.
    Compared {
        /// Rows that differ; none if the two agree in every bit.
        differing: Vec<usize>,
    },
    /// The CPU reference's; why the device could not confirm it.
    Unconfirmed(String),
}

impl Model {
    /// Selects a pixel's ray. Its history is there at once if the CPU reference kernels can tell it; otherwise the
    /// session is asked for it, once it has no other work.
    pub fn follow(&mut self, pixel: [u32; 2]) {
        if let Some(life) = self.reference(pixel) {
            self.followed = Some(pixel);
            (self.life, self.reference_life) = (Some(Arc::new(life)), None);
            let is_gpu = self.opened.as_ref().is_some_and(|opened| opened.settings.device == DeviceKind::Gpu);
            // On the CPU they are the session's own kernels.
            self.told = if is_gpu { Told::Reference } else { Told::Device };
            self.ask(Request::Confirm(pixel));
        } else if !self.is_busy() {
            self.followed = Some(pixel);
            self.ask(Request::Follow(pixel));
        }
    }

    /// Whether this ray has yet to be followed.
    #[must_use]
    pub fn is_to_follow(&self, pixel: [u32; 2]) -> bool {
        self.opened.is_some() && self.followed != Some(pixel)
    }

    /// Whether a row of the selected ray's history is of a pass that has not run yet.
    #[must_use]
    pub fn is_predicted(&self, row: &TraceRow) -> bool {
        self.life.as_ref().is_some_and(|life| life.passes.is_none()) && !row.is_within(self.passes.len())
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
        let Some(life) = self.life.clone().filter(|_| self.told == Told::Reference) else { return };
        match device {
            Err(why) => self.told = Told::Unconfirmed(why),
            Ok(device) if device.pixel == life.pixel => {
                let rows = device.rows.len().max(life.rows.len());
                let differs = |&row: &usize| text(device.rows.get(row)) != text(life.rows.get(row));
                let differing: Vec<usize> = (0..rows).filter(differs).collect();
                if !differing.is_empty() {
                    let mut shown = Trace { rays: life.rays, passes: life.passes, ..*device };
                    number(&mut shown.rows, &life.rows);
                    (self.life, self.reference_life) = (Some(Arc::new(shown)), Some(life));
                }
                self.told = Told::Compared { differing };
            }
            Ok(_) => {}
        }
    }

    /// More passes are known, or the streams have changed.
    pub(super) fn follow_on(&mut self, is_changed: bool) {
        let Some(pixel) = self.followed else { return };
        if is_changed {
            self.followed = None;
            return;
        }
        if self.told == Told::Device && self.life.as_ref().is_none_or(|life| life.passes.is_some()) {
            return;
        }
        let Some(fresh) = self.reference(pixel) else { return };
        match (&self.told, &self.life) {
            (Told::Compared { differing }, Some(life)) if !differing.is_empty() => {
                let mut shown = Trace { passes: fresh.passes, ..Trace::clone(life) };
                number(&mut shown.rows, &fresh.rows);
                (self.life, self.reference_life) = (Some(Arc::new(shown)), Some(Arc::new(fresh)));
            }
            _ => self.life = Some(Arc::new(fresh)),
        }
    }
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
