//! Whether a thread of a user's kernel tells the state in which it leaves its element: passes after it depend on that, and a
//! picture of wrong counts is only incomplete.

use super::machine::Machine;
use super::{InterpretError, Interpreter};
use crate::shared::constants::NOBODY;
use crate::tables::kernel::{Counts, Role};

impl Interpreter {
    /// Whether its threads have to tell the states of their elements.
    pub(super) fn is_to_book(&self) -> bool {
        self.is_users && self.kernel.counts() == Counts::Sent && self.tag().is_some()
    }

    fn check_booked(&self, states: Option<[u32; 2]>, booked: Option<u32>) -> Result<(), InterpretError> {
        let kernel = self.kernel;
        let name = |tag: u32| match tag {
            NOBODY => "NOBODY".to_owned(),
            tag => kernel.program().states.name(tag).to_owned(),
        };
        let Some([before, after]) = states.filter(|[before, _]| {
            let unborn = kernel.course().map(|course| course.unborn);
            let begins = kernel.role() == Role::Whole && unborn == Some(*before);
            kernel.takes().is_empty() || kernel.takes().contains(before) || begins
        }) else {
            return match booked {
                None | Some(NOBODY) => Ok(()),
                Some(told) => Err(InterpretError::BookedNobody(name(told))),
            };
        };
        match booked {
            Some(told) if told == after => {}
            Some(told) => return Err(InterpretError::Booked { told: name(told), state: name(after) }),
            None => return Err(InterpretError::NotBooked(name(after))),
        }
        let is_sent = kernel.sends().iter().any(|sent| (sent.from, sent.to) == (before, after));
        let is_listed = is_sent || before == after || kernel.takes().is_empty() || !self.is_of_folder();
        if is_listed { Ok(()) } else { Err(InterpretError::NotSent { from: name(before), to: name(after) }) }
    }

    /// Whether it is a kernel of a user's program, whose rows are the user's too.
    fn is_of_folder(&self) -> bool {
        !self.kernel.program().files.is_empty()
    }
}

impl Machine<'_> {
    /// Compares the states of an element before and after a pass with what its thread told; a thread without an element has
    /// no states.
    ///
    /// # Errors
    /// If it told another state, or a state that the kernel does not send to: the thread is then where it told.
    pub(super) fn check_booked(&mut self, states: Option<[u32; 2]>) -> Result<(), InterpretError> {
        let booked = self.thread.booked;
        let checked = self.kernel.check_booked(states, booked.map(|(tag, _)| tag));
        if let (Err(_), Some((_, statement))) = (&checked, booked) {
            self.thread.at = statement;
        }
        checked
    }
}
