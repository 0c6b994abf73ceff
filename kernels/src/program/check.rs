//! Checks a program before anything runs it; each kind of problem has its own error.

use std::collections::BTreeSet;

use super::Program;
use crate::tables::elements::Count;
use crate::tables::kernel::{Counts, Role};
use crate::tables::state::{MOST_LISTS, MOST_STATES, StateRole, Tag};
use crate::tables::stream::{STATE_TAG, Stream};
use crate::tables::texels::MOST_STREAMS;

/// A problem with a program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Two rows of a table have the same name.
    #[error("{program}: two {what} are called {name:?}")]
    Twice {
        /// The program.
        program: &'static str,
        /// The table.
        what: &'static str,
        /// The name.
        name: &'static str,
    },
    /// A row is not at its own index.
    #[error("{program}: {name} does not stand at its own place of the table")]
    Place {
        /// The program.
        program: &'static str,
        /// The row.
        name: &'static str,
    },
    /// A table has more rows than executors support.
    #[error("{program} has {count} {what}, at most {most} fit")]
    TooMany {
        /// The program.
        program: &'static str,
        /// The table.
        what: &'static str,
        /// Number of its rows.
        count: usize,
        /// Most rows.
        most: usize,
    },
    /// A row names a state, list, set or stream that the program does not have.
    #[error("{program}: {of} names {missing}, which the program does not have")]
    Missing {
        /// The program.
        program: &'static str,
        /// The row that names it.
        of: &'static str,
        /// What it names.
        missing: String,
    },
    /// A stream does not have one initial value and one meaning per layer.
    #[error("{program}: stream {stream} has {layers} layers and {given} {what}")]
    Layers {
        /// The program.
        program: &'static str,
        /// The stream.
        stream: &'static str,
        /// Number of layers.
        layers: usize,
        /// Initial values or meanings.
        what: &'static str,
        /// Number of these.
        given: usize,
    },
    /// A kernel takes a state and sends it nowhere, or sends from a state that it does not take.
    #[error("{program}: kernel {kernel} {problem} {state}")]
    Transition {
        /// The program.
        program: &'static str,
        /// The kernel.
        kernel: &'static str,
        /// The problem.
        problem: &'static str,
        /// The state.
        state: &'static str,
    },
    /// A stream cannot become another one.
    #[error("{program}: kernel {kernel} makes {adopted} the stream {stream}, which has other layers")]
    Adoption {
        /// The program.
        program: &'static str,
        /// The kernel.
        kernel: &'static str,
        /// The stream.
        stream: &'static str,
        /// What is to become it.
        adopted: &'static str,
    },
    /// Elements that no kernel has written are not unborn.
    #[error("{program}: stream {stream} does not begin with state {state}")]
    Begin {
        /// The program.
        program: &'static str,
        /// The stream of states.
        stream: &'static str,
        /// The state in which the course begins.
        state: &'static str,
    },
    /// No kernel sends elements to a state.
    #[error("{program}: no element is ever in state {state}")]
    Unreached {
        /// The program.
        program: &'static str,
        /// The state.
        state: &'static str,
    },
    /// No kernel takes elements out of a state.
    #[error("{program}: no kernel takes elements from state {state}")]
    DeadEnd {
        /// The program.
        program: &'static str,
        /// The state.
        state: &'static str,
    },
}

impl Program {
    /// Everything that is wrong with the program; empty if it can run.
    #[must_use]
    pub fn faults(&'static self) -> Vec<Fault> {
        let mut faults = Vec::new();
        self.check_tables(&mut faults);
        self.check_streams(&mut faults);
        self.check_kernels(&mut faults);
        self.check_states(&mut faults);
        faults
    }

    fn check_tables(&'static self, faults: &mut Vec<Fault>) {
        let program = self.name;
        let tables: [(&'static str, Vec<&'static str>, usize); 6] = [
            ("kernels", self.kernels.iter().map(|k| k.name).collect(), usize::MAX),
            ("streams", self.streams.iter().map(|s| s.name).collect(), MOST_STREAMS),
            ("states", self.states.iter().map(|s| s.name).collect(), MOST_STATES),
            ("lists", self.lists.iter().map(|l| l.name).collect(), MOST_LISTS),
            ("buffers", self.buffers.iter().map(|b| b.name).collect(), usize::MAX),
            ("sets of elements", self.elements.iter().map(|e| e.name).collect(), usize::MAX),
        ];
        for (what, names, most) in tables {
            if names.len() > most {
                faults.push(Fault::TooMany { program, what, count: names.len(), most });
            }
            let mut seen = BTreeSet::new();
            faults.extend(names.into_iter().filter(|n| !seen.insert(*n)).map(|name| Fault::Twice {
                program,
                what,
                name,
            }));
        }
        let streams = self.streams.iter().enumerate().map(|(i, s)| (i, s.index, s.name));
        let states = self.states.iter().enumerate().map(|(i, s)| (i, s.tag as usize, s.name));
        let out_of_place = streams.chain(states).filter(|(i, index, _)| i != index);
        faults.extend(out_of_place.map(|(.., name)| Fault::Place { program, name }));
    }

    fn check_streams(&'static self, faults: &mut Vec<Fault>) {
        let program = self.name;
        let has = |name: &str| self.elements(name).is_some();
        for stream in self.streams {
            let layers = stream.layers.len();
            for (what, given) in [("initial values", stream.unwritten.len()), ("meanings", stream.meaning.len())] {
                if layers != given || layers == 0 {
                    faults.push(Fault::Layers { program, stream: stream.name, layers, what, given });
                }
            }
            if !has(stream.elements.name) {
                let missing = format!("elements {:?}", stream.elements.name);
                faults.push(Fault::Missing { program, of: stream.name, missing });
            }
        }
        for course in self.courses {
            let begins = course.stream.info().unwritten.get(STATE_TAG).copied();
            if begins != Some(course.unborn) {
                let (stream, state) = (course.stream.name(), self.states.name(course.unborn));
                faults.push(Fault::Begin { program, stream, state });
            }
        }
        for elements in self.elements {
            let missing = match elements.count {
                Count::Found { in_stream, .. } if self.stream(in_stream).is_none() => format!("stream {in_stream:?}"),
                Count::Per { of, .. } if !has(of) => format!("elements {of:?}"),
                _ => continue,
            };
            faults.push(Fault::Missing { program, of: elements.name, missing });
        }
    }

    fn check_kernels(&'static self, faults: &mut Vec<Fault>) {
        let program = self.name;
        for kernel in self.kernels() {
            let (info, of) = (kernel.info(), kernel.name());
            let is_list = |name: &str| self.lists.iter().any(|list| list.name == name);
            let mut missing = |missing: String| faults.push(Fault::Missing { program, of, missing });
            if self.elements(kernel.instance().over.name).is_none() {
                missing(format!("elements {:?}", kernel.instance().over.name));
            }
            if let (Some(list), None) = (info.list, kernel.list()) {
                missing(format!("list {:?}", kernel.bound(list)));
            }
            for (_, bound) in kernel.instance().binds {
                if self.stream(bound).is_none() && self.buffer(bound).is_none() && !is_list(bound) {
                    missing(format!("{bound:?}"));
                }
            }
            let adopts = kernel.instance().adopts;
            for stream in adopts.iter().flat_map(|(to, from)| [to, from]).filter(|s| self.stream(s.name()).is_none()) {
                missing(format!("{:?}", stream.name()));
            }
            let tags = kernel.takes().iter().chain(kernel.sends().iter().flat_map(|send| [&send.from, &send.to]));
            for tag in tags.filter(|&&tag| self.states.role(tag).is_none()) {
                missing(format!("state {tag}"));
            }
            let format = |stream: Stream| (stream.layers(), stream.info().texel);
            for &(to, from) in adopts.iter().filter(|(to, from)| format(*to) != format(*from)) {
                faults.push(Fault::Adoption { program, kernel: of, stream: to.name(), adopted: from.name() });
            }
        }
    }

    fn check_states(&'static self, faults: &mut Vec<Fault>) {
        let (program, name) = (self.name, |tag: Tag| self.states.name(tag));
        for kernel in self.kernels() {
            let unborn = kernel.course().map(|course| course.unborn);
            let info = kernel.info();
            let mut add = |problem, tag| {
                faults.push(Fault::Transition { program, kernel: kernel.name(), problem, state: name(tag) });
            };
            for &tag in kernel.takes() {
                if !kernel.sends().iter().any(|send| send.from == tag) {
                    add("sends nothing on from", tag);
                }
            }
            for send in kernel.sends() {
                // A kernel that handles an element from start to end may also create it.
                let makes = info.role == Role::Whole && Some(send.from) == unborn;
                if !kernel.takes().contains(&send.from) && !makes {
                    add("does not take what it sends on from", send.from);
                }
                if let Counts::AllTo(to) = kernel.counts()
                    && send.to != to
                    && send.to != send.from
                {
                    add("does not send all elements to", to);
                }
            }
        }
        let sent: BTreeSet<Tag> = self.transitions().map(|(_, send)| send.to).collect();
        let taken: BTreeSet<Tag> = self.kernels().flat_map(|kernel| kernel.takes()).copied().collect();
        let begins: Vec<Tag> = self.courses.iter().flat_map(|course| [course.unborn, course.born]).collect();
        // In a part of a program of ours as a user's, states keep their numbers, whether they occur or not.
        let occurs = |tag: Tag| sent.contains(&tag) || taken.contains(&tag) || begins.contains(&tag);
        let is_whole = self.files.is_empty();
        for state in self.states.iter().filter(|state| is_whole || occurs(state.tag)) {
            if !sent.contains(&state.tag) && !begins.contains(&state.tag) {
                faults.push(Fault::Unreached { program, state: state.name });
            }
            if !taken.contains(&state.tag) && state.role != StateRole::Finished {
                faults.push(Fault::DeadEnd { program, state: state.name });
            }
        }
    }
}
