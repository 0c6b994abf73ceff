//! Follows one thread of a pass, among those of its workgroup.

use super::columns::Columns;
use super::launched::{Launched, Runner};
use super::{Given, Pass, PassError};
use crate::interpret::steps::Followed;
use crate::interpret::trace::Trace;
use crate::interpret::view::{Shown, StreamView, Variable, View};
use crate::interpret::{InterpretError, Kind};

impl Pass {
    /// The steps of an element's thread, of a kernel that [`Sourced::stopping`](crate::shader::Sourced::stopping) has traced.
    /// The other threads of its workgroup run with it.
    ///
    /// # Errors
    /// If no thread has this element, or another thread fails before.
    pub fn follow(&self, given: &Given<'_>, texel: [u32; 2]) -> Result<Followed, PassError> {
        let columns = Columns::new(&self.0, given.streams, false).map_err(PassError::before)?;
        let launched = Launched::new(&self.0, given, &columns).map_err(PassError::before)?;
        let (group, lane) = thread(&launched, given, texel)?;
        let mut runner = Runner::new(&launched);
        runner.follows = Some((lane, Box::default()));
        let failed = match runner.run(group, None) {
            Err(PassError { why, texel: of, lines }) if of == texel => Some((why, lines)),
            Err(other) => return Err(other),
            Ok(()) => None,
        };
        let trace = runner.machine.thread.trace.take();
        Ok(Followed::of(trace.map(|trace| *trace).unwrap_or_default(), failed))
    }

    /// What the thread's variables are at a step; behind the last, when it has ended or failed.
    ///
    /// # Errors
    /// As [`follow`](Self::follow), and if an expression that is evaluated there has no value.
    pub fn view(&self, given: &Given<'_>, texel: [u32; 2], step: usize) -> Result<View, PassError> {
        let columns = Columns::new(&self.0, given.streams, false).map_err(PassError::before)?;
        let launched = Launched::new(&self.0, given, &columns).map_err(PassError::before)?;
        let (group, lane) = thread(&launched, given, texel)?;
        let mut runner = Runner::new(&launched);
        runner.follows = Some((lane, Box::new(Trace::until(step))));
        let ran = runner.run(group, None);
        let is_there = runner.machine.thread.trace.as_ref().is_some_and(|trace| trace.is_there());
        match ran {
            Err(failed) if failed.texel != texel || !is_there && self.0.evaluates() => return Err(failed),
            _ => {}
        }
        let mut view = runner.machine.view();
        view.thread = thread_of(&launched, given, group, lane);
        let stored = runner.machine.group.as_ref().map_or(&[][..], |group| &group.stored);
        for &stream in self.streams() {
            let [width, height] = columns.size(stream);
            if texel[0] >= width || texel[1] >= height {
                continue;
            }
            for layer in 0..stream.layers() {
                let component = columns.component(stream, layer as u32, texel);
                let before = columns.load(component, stream, false).bits;
                let own = stored.iter().rev().find(|one| one.lane == lane && one.component == component);
                let now = own.map_or(before, |one| one.slot.bits);
                view.streams.push(StreamView { stream, layer, before, now });
            }
        }
        Ok(view)
    }
}

fn thread(launched: &Launched<'_>, given: &Given<'_>, texel: [u32; 2]) -> Result<(u32, u32), PassError> {
    launched.thread_of(texel).ok_or_else(|| {
        let what = format!("the {} columns and {} rows of the elements", given.size.width, given.size.height);
        let index = u64::from(texel[1]) * u64::from(given.size.width) + u64::from(texel[0]);
        PassError { texel, ..PassError::before(InterpretError::OutOfBounds { index, what }) }
    })
}

/// The built-in values of a thread, and the parameters of its launch.
fn thread_of(launched: &Launched<'_>, given: &Given<'_>, group: u32, lane: u32) -> Vec<Variable> {
    let of = launched.invocation(group, lane);
    let scalar =
        |name: &str, bits: u32| Variable { name: name.into(), of: "u32".into(), value: Shown::Scalar(Kind::U32, bits) };
    let vector = |name: &str, value: [u32; 3]| {
        let parts = ["x", "y", "z"].into_iter().zip(value).map(|(name, bits)| scalar(name, bits));
        Variable { name: name.into(), of: "vec3<u32>".into(), value: Shown::Parts(parts.collect()) }
    };
    vec![
        vector("global_invocation_id", of.global),
        vector("local_invocation_id", of.local),
        scalar("local_invocation_index", of.index),
        vector("workgroup_id", of.group),
        vector("num_workgroups", of.groups),
        scalar("launch.elements", given.size.count),
        scalar("launch.width", given.size.width),
        scalar("launch.parameter", given.parameter),
    ]
}
