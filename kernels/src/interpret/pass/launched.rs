//! The threads of a launch, workgroup by workgroup.

use super::columns::Columns;
use super::group::{Group, Stored};
use super::{Conflict, Given, PassError, Race, Raced};
use crate::interpret::code::{Global, NONE, Slot, What};
use crate::interpret::flow::Stop;
use crate::interpret::invocation::Invocation;
use crate::interpret::machine::{Machine, Thread};
use crate::interpret::recording::Recording;
use crate::interpret::stopped::Stopped;
use crate::interpret::trace::Trace;
use crate::interpret::{Absentee, InterpretError, Interpreter};
use crate::shader::Printed;
use crate::shared;
use crate::tables::kernel::Launch;
use crate::tables::stream::STATE_TAG;

/// Most threads of a workgroup that devices have.
const MOST_THREADS: u32 = 1024;

/// A launch of a kernel.
pub(super) struct Launched<'a> {
    kernel: &'a Interpreter,
    given: &'a Given<'a>,
    columns: &'a Columns<'a>,
    /// Workgroups along x and y, and threads of each along x, y and z.
    groups: [u32; 2],
    sides: [u32; 3],
    threads: u32,
    is_list: bool,
    parameters: shared::launch::Launch,
}

impl<'a> Launched<'a> {
    pub(super) fn new(
        kernel: &'a Interpreter,
        given: &'a Given<'a>,
        columns: &'a Columns<'a>,
    ) -> Result<Self, InterpretError> {
        let sides = kernel.workgroup;
        let threads = sides.iter().try_fold(1u32, |product, &side| product.checked_mul(side));
        let unsupported = |what: String| InterpretError::Unsupported { what, line: 0 };
        let threads = threads.filter(|threads| (1..=MOST_THREADS).contains(threads)).ok_or_else(|| {
            let [x, y, z] = sides;
            unsupported(format!("a workgroup of {x} by {y} by {z} threads"))
        })?;
        let groups = kernel.kernel.groups(given.size);
        let all = u64::from(groups[0]) * u64::from(groups[1]) * u64::from(threads);
        if all >= u64::from(u32::MAX) {
            return Err(unsupported(format!("a pass of {all} threads")));
        }
        let is_list = matches!(kernel.kernel.info().launch, Launch::List { .. });
        let size = given.size;
        let parameters = shared::launch::Launch::new(size.count, size.width, given.parameter);
        Ok(Self { kernel, given, columns, groups, sides, threads, is_list, parameters })
    }

    /// Number of workgroups.
    pub(super) fn groups(&self) -> u32 {
        self.groups[0] * self.groups[1]
    }

    pub(super) fn first_thread(&self, group: u32) -> u32 {
        group * self.threads
    }

    pub(super) fn invocation(&self, group: u32, lane: u32) -> Invocation {
        let [across, down] = self.groups;
        let own = [group % across.max(1), group / across.max(1), 0];
        let [x, y, _] = self.sides;
        let local = [lane % x, lane / x % y, lane / (x * y)];
        let global = [0, 1, 2].map(|axis| own[axis] * self.sides[axis] + local[axis]);
        Invocation { global, local, index: lane, group: own, groups: [across, down, 1] }
    }

    /// The texel of the element that a thread has: in a list, of as many threads as elements.
    fn texel(&self, group: u32, lane: u32) -> [u32; 2] {
        if !self.is_list {
            let [x, y, _] = self.invocation(group, lane).global;
            return [x, y];
        }
        let (element, width) = (self.first_thread(group) + lane, self.given.size.width.max(1));
        [element % width, element / width]
    }

    /// The place of an element among those of its set; `None` if it has none.
    fn element(&self, [x, y]: [u32; 2]) -> Option<usize> {
        let size = self.given.size;
        let is_there = x < size.width && y < size.height;
        let at = y as usize * size.width as usize + x as usize;
        (is_there && at < size.count as usize).then_some(at)
    }

    /// The workgroup and the thread in it that has an element.
    pub(super) fn thread_of(&self, texel: [u32; 2]) -> Option<(u32, u32)> {
        let element = self.element(texel)?;
        let (group, lane) = if self.is_list {
            (element as u32 / self.threads, element as u32 % self.threads)
        } else {
            let [x, y] = [0, 1].map(|axis| (texel[axis] / self.sides[axis], texel[axis] % self.sides[axis]));
            (y.0 * self.groups[0] + x.0, y.1 * self.sides[0] + x.1)
        };
        (group < self.groups() && lane < self.threads).then_some((group, lane))
    }

    fn line(&self, statement: u32) -> usize {
        let span = self.kernel.code.statements.get(statement as usize);
        span.map_or(0, |span| crate::interpret::compile::line_of(&self.kernel.source, span.start) + 1)
    }

    pub(super) fn race_of(&self, conflict: &Conflict) -> Race {
        let Conflict { threads, stream, layer, texel, statement, is_load } = *conflict;
        let texels = threads.map(|thread| self.texel(thread / self.threads, thread % self.threads));
        let what = match is_load {
            true => Raced::Loaded { stream, layer, texel },
            false => Raced::Stored { stream, layer, texel },
        };
        Race { texels, line: self.line(statement), what }
    }
}

/// What workgroups have done.
pub(super) struct Done {
    /// What each has stored, in the order of its threads.
    pub(super) groups: Vec<(u32, Vec<Stored>)>,
    /// The first race in the memory of one.
    pub(super) race: Option<Race>,
    /// How often each statement ran.
    pub(super) runs: Vec<u64>,
    /// What elements have printed.
    pub(super) noted: Vec<(usize, Vec<Printed>)>,
    /// What they did at the kernel's stops.
    pub(super) stopped: Vec<(usize, Vec<Stopped>)>,
}

/// How a thread goes on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Next {
    Begin,
    /// Behind a barrier.
    GoOn,
    /// Loads what all see, and waits again.
    Load,
}

/// Runs workgroups, one after the other.
pub(super) struct Runner<'a> {
    of: &'a Launched<'a>,
    pub(super) machine: Machine<'a>,
    /// The threads of a workgroup that wait; one for all if none ever waits.
    threads: Vec<Thread<'a>>,
    done: Done,
    /// The thread whose steps are followed, before it begins.
    pub(super) follows: Option<(u32, Box<Trace>)>,
}

impl<'a> Runner<'a> {
    pub(super) fn new(of: &'a Launched<'a>) -> Self {
        let code = &of.kernel.code;
        let mut machine = Machine::new(of.kernel, of.given.data, None);
        machine.group = Some(Box::new(Group::new(of.columns, of.threads, code.workgroup)));
        for (bytes, global) in machine.bytes.iter_mut().zip(&code.globals) {
            if *global == Global::Launch {
                *bytes = bytemuck::bytes_of(&of.parameters);
            }
        }
        let waiting = if code.barriers.is_empty() { 0 } else { of.threads };
        let threads = (0..waiting).map(|_| Thread::default()).collect();
        let done = Done { groups: Vec::new(), race: None, runs: Vec::new(), noted: Vec::new(), stopped: Vec::new() };
        Self { of, machine, threads, done, follows: None }
    }

    pub(super) fn done(mut self) -> Done {
        self.done.runs = self.machine.runs;
        self.done
    }

    /// Runs a workgroup, and records one of its threads. Ends early, with the thread in the machine, if one that is
    /// followed has ended, or is where it was to be run to.
    pub(super) fn run(&mut self, group: u32, recorded: Option<u32>) -> Result<(), PassError> {
        let of = self.of;
        if let Some(shared) = &mut self.machine.group {
            shared.begin(of.first_thread(group));
        }
        let mut next = Next::Begin;
        let (mut first, mut other) = (Vec::new(), Vec::new());
        loop {
            // The first thread that waits, and one that does not wait there.
            let (mut waits, mut missing): (Option<u32>, Option<Absentee>) = (None, None);
            let mut ended = None;
            // Threads that never wait do not depend on each other, and have one place for what belongs to a thread.
            let lanes = match recorded.filter(|_| self.threads.is_empty()) {
                Some(lane) => lane..lane + 1,
                None => 0..of.threads,
            };
            for lane in lanes {
                self.exchange(lane);
                let stop = self.go_on(group, lane, next, recorded).map_err(|why| PassError {
                    why,
                    texel: of.texel(group, lane),
                    lines: self.machine.lines(),
                })?;
                // A thread that is followed stays where it has ended.
                if stop == Stop::Ended && self.machine.thread.trace.is_some() {
                    return Ok(());
                }
                match (stop, waits) {
                    (Stop::Paused, _) => return Ok(()),
                    (Stop::Ended, _) => {
                        ended = ended.or(Some(lane));
                        self.check_booked(group, lane).map_err(|why| PassError {
                            why,
                            texel: of.texel(group, lane),
                            lines: self.machine.lines(),
                        })?;
                        self.end(group, lane);
                    }
                    (Stop::Waits, None) => {
                        waits = Some(lane);
                        self.machine.place_of_wait(&mut first);
                    }
                    (Stop::Waits, Some(_)) => {
                        self.machine.place_of_wait(&mut other);
                        if other != first {
                            missing = missing.or(Some(Absentee { thread: lane, has_ended: false }));
                        }
                    }
                }
                self.exchange(lane);
            }
            let Some(lane) = waits else { break };
            let missing = ended.map(|thread| Absentee { thread, has_ended: true }).or(missing);
            self.exchange(lane);
            if let Some(missing) = missing {
                let why = InterpretError::Barrier(missing);
                return Err(PassError { why, texel: of.texel(group, lane), lines: self.machine.lines() });
            }
            let (which, is_load) = match self.machine.waiting() {
                Some(What::Barrier(which)) => (*which, false),
                _ => (naga::Barrier::WORK_GROUP, true),
            };
            self.exchange(lane);
            next = if is_load && next != Next::Load { Next::Load } else { Next::GoOn };
            if let Some(shared) = &mut self.machine.group {
                shared.synchronise(which.contains(naga::Barrier::WORK_GROUP), which.contains(naga::Barrier::TEXTURE));
            }
        }
        self.leave(group);
        Ok(())
    }

    /// Puts a thread into the machine, or back.
    fn exchange(&mut self, lane: u32) {
        if let Some(thread) = self.threads.get_mut(lane as usize) {
            std::mem::swap(&mut self.machine.thread, thread);
        }
    }

    fn go_on(&mut self, group: u32, lane: u32, next: Next, recorded: Option<u32>) -> Result<Stop, InterpretError> {
        let machine = &mut self.machine;
        if let Some(shared) = &mut machine.group {
            shared.lane = lane;
        }
        match next {
            Next::Begin => {
                machine.begin(&self.of.invocation(group, lane));
                let is_recorded = recorded == Some(lane);
                machine.thread.trace = self.follows.take_if(|(of, _)| *of == lane).map(|(_, trace)| trace);
                machine.thread.recording = is_recorded.then(|| Recording::new(&self.of.kernel.code));
            }
            Next::Load => {
                if let Some(What::UniformLoad { pointer, result }) = machine.waiting() {
                    machine.load_uniform(*pointer, *result)?;
                }
                return Ok(Stop::Waits);
            }
            Next::GoOn => {}
        }
        machine.go_on()
    }

    /// Whether a thread that has ended told the state in which it leaves its element. Where the kernel finds its element by a
    /// function of ours, only what it has stored says which one it is.
    fn check_booked(&mut self, group: u32, lane: u32) -> Result<(), InterpretError> {
        let kernel = self.of.kernel;
        let Some(course) = kernel.kernel().course().filter(|_| kernel.is_to_book()) else { return Ok(()) };
        let columns = self.of.columns;
        let texel = self.of.texel(group, lane);
        let own = self.of.element(texel).filter(|_| !kernel.is_tiled);
        let own = own.map(|_| columns.component(course.stream, STATE_TAG as u32, texel));
        let layer = columns.layer(course.stream, STATE_TAG as u32);
        let stored = self.machine.group.iter().find_map(|shared| shared.stored_by(lane, &layer));
        let Some(component) = own.or(stored.map(|(component, _)| component)) else {
            return if kernel.is_tiled { Ok(()) } else { self.machine.check_booked(None) };
        };
        let before = columns.load(component, course.stream, false).bits;
        let after = stored.filter(|(there, _)| *there == component).map_or(before, |(_, bits)| bits);
        self.machine.check_booked(Some([before, after]))
    }

    /// A thread has come to its end.
    fn end(&mut self, group: u32, lane: u32) {
        let stopped = &mut self.machine.thread.stopped;
        if !stopped.is_empty()
            && let Some(element) = self.of.element(self.of.texel(group, lane))
        {
            self.done.stopped.push((element, std::mem::take(stopped)));
        }
        let noted = &self.machine.thread.noted;
        if noted.iter().any(|(_, times)| *times > 0)
            && let Some(element) = self.of.element(self.of.texel(group, lane))
        {
            self.done.noted.push((element, noted.clone()));
        }
    }

    /// All threads of a workgroup have.
    fn leave(&mut self, group: u32) {
        let Some(shared) = &mut self.machine.group else { return };
        let mut stored = std::mem::take(&mut shared.stored);
        stored.sort_by_key(|one| one.lane);
        if let (Some(clash), None) = (shared.clash, &self.done.race) {
            let shared = &self.of.kernel.code.shared;
            let name = shared.iter().rev().find(|(first, _)| *first as usize <= clash.word);
            let what = Raced::Variable(name.map_or_else(String::new, |(_, name)| name.clone()));
            let texels = clash.lanes.map(|lane| self.of.texel(group, lane));
            self.done.race = Some(Race { texels, line: self.of.line(clash.statement), what });
        }
        self.done.groups.push((group, stored));
    }

    /// The recording of a thread of the last workgroup.
    pub(super) fn recorded(mut self, lane: u32, texel: [u32; 2]) -> Result<Recording, PassError> {
        self.exchange(lane);
        let (kernel, columns) = (self.of.kernel, self.of.columns);
        let components: Vec<Option<usize>> = kernel
            .streams()
            .iter()
            .flat_map(|&stream| {
                let [width, height] = columns.size(stream);
                let is_there = texel[0] < width && texel[1] < height;
                let layers = 0..stream.layers() as u32;
                layers.map(move |layer| is_there.then(|| columns.component(stream, layer, texel)))
            })
            .collect();
        let machine = &mut self.machine;
        machine.written = vec![false; components.len()];
        machine.stored = vec![NONE; components.len()];
        machine.before = vec![0; components.len()];
        machine.row = vec![Slot::default(); components.len()];
        let streams = kernel.streams().iter().flat_map(|&stream| (0..stream.layers()).map(move |_| stream));
        for (at, (component, stream)) in components.iter().zip(streams).enumerate() {
            if let Some(component) = component {
                machine.row[at] = columns.load(*component, stream, false);
                machine.before[at] = machine.row[at].bits;
            }
        }
        let all = self.done.groups.last().map_or(&[][..], |(_, stored)| stored);
        for one in all.iter().filter(|one| one.lane == lane) {
            if let Some(at) = components.iter().position(|component| *component == Some(one.component)) {
                machine.row[at] = one.slot;
                machine.written[at] = true;
                machine.stored[at] = one.statement;
            }
        }
        let lines = machine.lines();
        self.machine.finish().map_err(|why| PassError { why, texel, lines })
    }
}
