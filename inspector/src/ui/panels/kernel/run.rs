//! The selected ray in the current row's pass, interpreted; and all rays of the pass.

use std::collections::BTreeMap;
use std::sync::Arc;

use raystep_kernels::export::trace::Trace;
use raystep_kernels::interpret::{Element, InterpretError, Interpreter, LineWork, MOST_SITES, Many, Outcomes};
use raystep_kernels::program::schedule::Call;
use raystep_kernels::{Kernel, Pass, StreamData};
use raystep_lab::divergence::{Fate, fates};

use crate::branches::Branches;
use crate::session::Model;
use crate::session::before::pause;
use crate::session::request::{Job, JobContext, Opened, Request, answered, job};

/// The name of reading one ray's streams.
const READING: &str = "reading the ray's streams";
/// The name of interpreting all rays.
const INTERPRETING: &str = "interpreting all rays of the pass";
/// Rays between two reports of progress: some ten milliseconds.
const RAYS_A_REPORT: usize = 4096;

/// A pass of a run, with streams that nothing has changed since.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PassKey {
    pub(super) generation: u64,
    pub(super) edition: u64,
    pub(super) pass: usize,
}

/// All rays of a pass.
pub(super) struct AllRays {
    pub(super) key: PassKey,
    pub(super) size: [u32; 2],
    pub(super) outcomes: Vec<Option<Outcomes>>,
    /// How each ray fares in f64; `None` if f64 decides the same, or rays hit nothing.
    pub(super) fates: Option<Vec<Fate>>,
    /// The lines with conditions, of the composed source.
    pub(super) heat: BTreeMap<usize, Heat>,
    /// What the lines of the composed source took.
    pub(super) work: BTreeMap<usize, LineWork>,
}

/// How the conditions of a line came out for all rays of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Heat {
    /// Rays that reached one of them.
    pub(super) reached: u64,
    /// Rays for which one was true.
    pub(super) taken: u64,
    /// Rays that the pass processed.
    pub(super) of: u64,
}

/// The heat of each line that has conditions, from the line of each condition.
fn heat(lines: impl Iterator<Item = usize>, outcomes: &[Option<Outcomes>]) -> BTreeMap<usize, Heat> {
    let mut masks = BTreeMap::<usize, u128>::new();
    for (site, line) in lines.take(MOST_SITES).enumerate() {
        *masks.entry(line).or_default() |= 1 << site;
    }
    let of_mask = |mask: u128| {
        outcomes.iter().flatten().fold(Heat::default(), |heat, ray| Heat {
            reached: heat.reached + u64::from(ray.reached & mask != 0),
            taken: heat.taken + u64::from(ray.taken & mask != 0),
            of: heat.of + 1,
        })
    };
    masks.into_iter().map(|(line, mask)| (line, of_mask(mask))).collect()
}

type Texels = (PassKey, [u32; 2], Vec<u32>);
type Prepared = (Kernel, Result<Arc<Interpreter>, InterpretError>);

/// One ray in a pass.
pub(super) struct OneRay {
    pub(super) branches: Branches,
    pub(super) interpreter: Arc<Interpreter>,
    /// What is to be said about it.
    pub(super) note: Option<&'static str>,
}

/// Interprets the current run's kernels.
#[derive(Default)]
pub(super) struct Runs {
    /// Kernels of the run with this generation.
    kernels: (u64, Vec<Prepared>),
    /// A ray's texels from the session.
    given: Option<Texels>,
    asked: Option<(PassKey, [u32; 2])>,
    pub(super) all: Option<AllRays>,
}

impl Runs {
    /// Takes the answers of jobs. Returns whether there was one.
    pub(super) fn listen(&mut self, model: &mut Model) -> bool {
        let mut is_new = false;
        while let Some(answer) = model.take_answer::<Texels>(READING) {
            (self.given, is_new) = (Some(*answer), true);
        }
        while let Some(answer) = model.take_answer::<AllRays>(INTERPRETING) {
            (self.all, is_new) = (Some(*answer), true);
        }
        is_new
    }

    /// A kernel of the run, prepared once.
    pub(super) fn interpreter(
        &mut self,
        generation: u64,
        opened: &Opened,
        kernel: Kernel,
    ) -> Result<Arc<Interpreter>, InterpretError> {
        if self.kernels.0 != generation {
            (self.kernels, self.all, self.given, self.asked) = ((generation, Vec::new()), None, None, None);
        }
        if let Some((_, known)) = self.kernels.1.iter().find(|(known, _)| *known == kernel) {
            return known.clone();
        }
        let no_variant = || InterpretError::NotAlone(kernel.name());
        let made = opened.plan.variant(kernel).ok_or_else(no_variant).and_then(Interpreter::new).map(Arc::new);
        self.kernels.1.push((kernel, made.clone()));
        made
    }

    /// What the ray did in a row of its history. `None` while its streams are read; the error is one line.
    pub(super) fn branches(
        &mut self,
        model: &mut Model,
        history: &Trace,
        row: usize,
    ) -> Option<Result<OneRay, String>> {
        let opened = model.opened.clone()?;
        let row = history.rows.get(row)?;
        let kernel = opened.plan.program.kernel(row.kernel)?;
        let Some(pass) = row.pass else { return Some(Err("the index of this pass is not known yet".into())) };
        let interpreter = match self.interpreter(model.generation, &opened, kernel) {
            Ok(interpreter) => interpreter,
            Err(error) => return Some(Err(error.to_string())),
        };
        let key = PassKey { generation: model.generation, edition: model.edition, pass };
        let mut texels = self.texels(model, &interpreter, key, history.pixel)?;
        let size = [opened.plan.width, opened.plan.height];
        let element = Element { texel: history.pixel, size };
        let recording = match interpreter.record(&opened.data, element, &mut texels) {
            Ok(recording) => recording,
            Err(error) => return Some(Err(error.to_string())),
        };
        let tag = interpreter.tag().and_then(|tag| texels.get(tag).copied());
        let is_as_told = tag.is_none_or(|tag| opened.plan.program.states.name(tag) == row.after.state);
        let note = (!is_as_told).then_some(
            "the device ended in another state: it rounds differently, or a texel was edited after the pass",
        );
        Some(Ok(OneRay { branches: Branches::new(&interpreter, &recording), interpreter, note }))
    }

    fn texels(
        &mut self,
        model: &mut Model,
        interpreter: &Arc<Interpreter>,
        key: PassKey,
        pixel: [u32; 2],
    ) -> Option<Vec<u32>> {
        if let Some(texels) = model.texels_before(pixel, key.pass, interpreter.streams()) {
            return Some(texels);
        }
        if let Some((_, _, texels)) = self.given.as_ref().filter(|(of, ray, _)| (*of, *ray) == (key, pixel)) {
            return Some(texels.clone());
        }
        if self.asked != Some((key, pixel)) && !model.is_busy() {
            self.asked = Some((key, pixel));
            model.ask(Request::Job(READING, one_ray(interpreter.clone(), key, pixel)));
        }
        None
    }

    /// Interprets all rays of a pass, unless they are known.
    pub(super) fn ask_for_all(&mut self, model: &mut Model, interpreter: &Arc<Interpreter>, key: PassKey) {
        if self.all.as_ref().is_none_or(|all| all.key != key) && !model.is_busy() {
            let Some(call) = model.passes.get(key.pass).map(Pass::call) else { return };
            model.ask(Request::Job(INTERPRETING, all_rays(interpreter.clone(), key, call)));
        }
    }
}

fn one_ray(interpreter: Arc<Interpreter>, key: PassKey, pixel: [u32; 2]) -> Job {
    job!(context, {
        let read = context.session.streams_before(key.pass, interpreter.streams(), Some(pixel)).await;
        let texels = read.map_err(|e| e.to_string())?.into_iter().flat_map(|data| data.bits).collect::<Vec<u32>>();
        answered((key, pixel, texels))
    })
}

fn all_rays(interpreter: Arc<Interpreter>, key: PassKey, call: Call) -> Job {
    job!(context, {
        let JobContext { session, progress, .. } = context;
        let read = session.streams_before(key.pass, interpreter.streams(), None).await;
        let streams: Vec<StreamData> = read.map_err(|e| e.to_string())?;
        let data = session.renderer().shared_data();
        let many = Many { kernel: &interpreter, data: &data, streams: &streams };
        let size = many.size();
        let rays = size[0] as usize * size[1] as usize;
        let (mut outcomes, mut runs) = (Vec::with_capacity(rays), vec![0; interpreter.statements().len()]);
        for first in (0..rays).step_by(RAYS_A_REPORT) {
            if !progress(first as u64, rays as u64) {
                return Err("cancelled".into());
            }
            let part = many.outcomes_and_runs(first..first + RAYS_A_REPORT);
            let (of_part, ran) = part.map_err(|e| e.to_string())?;
            outcomes.extend(of_part);
            runs.iter_mut().zip(ran).for_each(|(sum, ran)| *sum += ran);
            pause().await;
        }
        let heat = heat(interpreter.sites().iter().map(|site| site.line), &outcomes);
        let fates = match outcomes.iter().flatten().any(|ray| ray.differs != 0) {
            true => fates(&session.renderer().shared_plan(), &data, call, &streams).map_err(|e| e.to_string())?,
            false => None,
        };
        let work = interpreter.by_line(&runs);
        answered(AllRays { key, size, outcomes, fates, heat, work })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_as_hot_as_the_rays_that_reached_any_of_its_conditions() {
        let ray = |reached, taken| Some(Outcomes { reached, taken, differs: 0 });
        let rays = [ray(0b011, 0b010), ray(0b100, 0b100), None, ray(0, 0)];
        let found = heat([7, 9, 9].into_iter(), &rays);
        let found: Vec<_> = found.iter().map(|(line, heat)| (*line, [heat.reached, heat.taken, heat.of])).collect();
        assert_eq!(found, [(7, [1, 0, 3]), (9, [2, 2, 3])]);
        // Conditions that have no bit.
        assert_eq!(heat(0..500, &rays).len(), MOST_SITES);
    }
}
