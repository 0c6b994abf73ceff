//! The selected ray or element in a pass, interpreted; and all of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use raystep_kernels::interpret::{
    Element, InterpretError, Interpreter, LineWork, MOST_SITES, Many, Outcomes, Recording,
};
use raystep_kernels::program::schedule::Call;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::elements::Size;
use raystep_kernels::{Kernel, Pass};
use raystep_lab::divergence::{Fate, fates};
use raystep_lab::passed::Code;
use raystep_lab::text::counted;

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

/// What happened to an element, and the state in which it ended.
type Recorded = (Arc<Recording>, Option<u32>);
type Given = (PassKey, [u32; 2], Result<Recorded, String>);
type Prepared = (Kernel, Result<Arc<Code>, InterpretError>);

/// An element in a pass.
pub(super) struct Looked<'a> {
    pub(super) kernel: Kernel,
    pub(super) pass: usize,
    pub(super) texel: [u32; 2],
    /// The state in which its history says that it ended.
    pub(super) state: Option<&'a str>,
}

/// One ray in a pass.
pub(super) struct OneRay {
    pub(super) branches: Branches,
    pub(super) code: Arc<Code>,
    /// What is to be said about it.
    pub(super) note: Option<&'static str>,
}

/// Interprets the current run's kernels.
#[derive(Default)]
pub(super) struct Runs {
    /// Kernels of the run with this generation.
    kernels: (u64, Vec<Prepared>),
    /// What the session's streams tell of an element.
    given: Option<Given>,
    asked: Option<(PassKey, [u32; 2])>,
    pub(super) all: Option<AllRays>,
}

impl Runs {
    /// Takes the answers of jobs. Returns whether there was one.
    pub(super) fn listen(&mut self, model: &mut Model) -> bool {
        let mut is_new = false;
        while let Some(answer) = model.take_answer::<Given>(READING) {
            (self.given, is_new) = (Some(*answer), true);
        }
        while let Some(answer) = model.take_answer::<AllRays>(INTERPRETING) {
            (self.all, is_new) = (Some(*answer), true);
        }
        is_new
    }

    /// A kernel of the run, prepared once.
    pub(super) fn code(
        &mut self,
        generation: u64,
        opened: &Opened,
        kernel: Kernel,
    ) -> Result<Arc<Code>, InterpretError> {
        if self.kernels.0 != generation {
            (self.kernels, self.all, self.given, self.asked) = ((generation, Vec::new()), None, None, None);
        }
        if let Some((_, known)) = self.kernels.1.iter().find(|(known, _)| *known == kernel) {
            return known.clone();
        }
        let no_variant = || InterpretError::NotAlone(kernel.name());
        let variant = opened.plan.variant(kernel).ok_or_else(no_variant);
        let made = variant.and_then(|variant| Code::new(variant, opened.plan.turns)).map(Arc::new);
        self.kernels.1.push((kernel, made.clone()));
        made
    }

    /// What an element did in a pass. `None` while streams are read; the error is one line.
    pub(super) fn branches(&mut self, model: &mut Model, looked: &Looked<'_>) -> Option<Result<OneRay, String>> {
        let opened = model.opened.clone()?;
        let code = match self.code(model.generation, &opened, looked.kernel) {
            Ok(code) => code,
            Err(error) => return Some(Err(error.to_string())),
        };
        let key = PassKey { generation: model.generation, edition: model.edition, pass: looked.pass };
        let (recording, tag) = match self.recorded(model, &opened, &code, key, looked.texel)? {
            Ok(recorded) => recorded,
            Err(error) => return Some(Err(error)),
        };
        let ended = tag.zip(looked.state).map(|(tag, state)| opened.plan.program.states.name(tag) == state);
        let note = (ended == Some(false)).then_some(
            "the device ended in another state: it rounds differently, or a texel was edited after the pass",
        );
        Some(Ok(OneRay { branches: Branches::new(code.interpreter(), &recording), code, note }))
    }

    /// At once if the CPU reference kernels know the element's streams; otherwise from the session's.
    fn recorded(
        &mut self,
        model: &mut Model,
        opened: &Opened,
        code: &Arc<Code>,
        key: PassKey,
        texel: [u32; 2],
    ) -> Option<Result<Recorded, String>> {
        if let Code::Element(interpreter) = &**code
            && let Some(texels) = model.texels_before(texel, key.pass, interpreter.streams())
        {
            let element = Element { texel, size: [opened.plan.width, opened.plan.height] };
            return Some(record(interpreter, &opened.data, element, texels));
        }
        if let Some((_, _, given)) = self.given.as_ref().filter(|(of, at, _)| (*of, *at) == (key, texel)) {
            return Some(given.clone());
        }
        if self.asked != Some((key, texel)) && !model.is_busy() {
            self.asked = Some((key, texel));
            model.ask(Request::Job(READING, one(code.clone(), key, texel)));
        }
        None
    }

    /// Interprets all rays of a pass, unless they are known.
    pub(super) fn ask_for_all(&mut self, model: &mut Model, code: &Arc<Code>, key: PassKey) {
        if self.all.as_ref().is_none_or(|all| all.key != key) && !model.is_busy() {
            let Some(call) = model.passes.get(key.pass).map(Pass::call) else { return };
            model.ask(Request::Job(INTERPRETING, all(code.clone(), key, call)));
        }
    }
}

fn record(code: &Interpreter, data: &SceneData, element: Element, mut texels: Vec<u32>) -> Result<Recorded, String> {
    let recording = code.record(&code.kernel().reads(data), element, &mut texels).map_err(|error| error.to_string())?;
    Ok((Arc::new(recording), code.tag().and_then(|tag| texels.get(tag).copied())))
}

fn one(code: Arc<Code>, key: PassKey, texel: [u32; 2]) -> Job {
    job!(JobContext { session, .. }, {
        let begun = session.begun(key.pass, code.streams()).await.map_err(|e| e.to_string())?;
        let begun = begun.ok_or("the run has no such pass")?;
        let data = session.renderer().shared_data();
        let [x, y] = texel;
        let recorded = if x >= begun.size.width || y >= begun.size.height {
            let Size { width, height, .. } = begun.size;
            let [columns, rows] = [counted(width, "column"), counted(height, "row")];
            Err(format!("this pass has {columns} and {rows}, and no element at {x},{y}"))
        } else if !code.works_on(&begun, texel) {
            Err(format!("the pass did not work on the element at {x},{y}"))
        } else {
            match &*code {
                Code::Element(alone) => record(alone, &data, begun.element(texel), begun.texels(texel)),
                Code::Whole(_) => {
                    let recorded = code.record(&begun, &data, texel);
                    recorded.map(|recording| (Arc::new(recording), None)).map_err(|failure| failure.to_string())
                }
            }
        };
        let given: Given = (key, texel, recorded);
        answered(given)
    })
}

fn all(code: Arc<Code>, key: PassKey, call: Call) -> Job {
    job!(JobContext { session, progress, .. }, {
        let begun = session.begun(key.pass, code.streams()).await.map_err(|e| e.to_string())?;
        let begun = begun.ok_or("the run has no such pass")?;
        let data = session.renderer().shared_data();
        let size = [begun.size.width, begun.size.height];
        let (mut outcomes, mut runs) = (Vec::new(), vec![0; code.interpreter().statements().len()]);
        match &*code {
            Code::Element(kernel) => {
                let read = kernel.kernel().reads(&data);
                let many = Many { kernel, data: &read, streams: &begun.streams };
                let rays = size[0] as usize * size[1] as usize;
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
            }
            Code::Whole(_) => (_, runs) = code.runs(&begun, &data).map_err(|failure| failure.to_string())?,
        }
        let heat = heat(code.interpreter().sites().iter().map(|site| site.line), &outcomes);
        let fates = match outcomes.iter().flatten().any(|ray| ray.differs != 0) {
            true => fates(&session.renderer().shared_plan(), &data, call, &begun.streams).map_err(|e| e.to_string())?,
            false => None,
        };
        let work = code.interpreter().by_line(&runs);
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
