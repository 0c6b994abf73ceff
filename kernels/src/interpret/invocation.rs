//! Which thread of a launch runs: its `@builtin` arguments.

use naga::{Binding, BuiltIn, Function, TypeInner};

use super::Interpreter;
use super::code::{Body, Slot, slots};
use super::recording::KNOWN;

/// A thread of a launch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Invocation {
    pub(super) global: [u32; 3],
    pub(super) local: [u32; 3],
    pub(super) index: u32,
    pub(super) group: [u32; 3],
    pub(super) groups: [u32; 3],
}

impl Invocation {
    /// Other built-in values are 0.
    fn value(&self, binding: Option<&Binding>) -> [u32; 3] {
        match binding {
            Some(Binding::BuiltIn(BuiltIn::GlobalInvocationId)) => self.global,
            Some(Binding::BuiltIn(BuiltIn::LocalInvocationId)) => self.local,
            Some(Binding::BuiltIn(BuiltIn::LocalInvocationIndex)) => [self.index, 0, 0],
            Some(Binding::BuiltIn(BuiltIn::WorkGroupId)) => self.group,
            Some(Binding::BuiltIn(BuiltIn::NumWorkGroups)) => self.groups,
            _ => [0; 3],
        }
    }
}

/// Whether all arguments of an entry point are what a thread knows.
pub(super) fn are_known(module: &naga::Module, function: &Function) -> bool {
    use BuiltIn as B;
    let is_known = |binding: &Binding| match binding {
        Binding::BuiltIn(builtin) => matches!(
            builtin,
            B::GlobalInvocationId | B::LocalInvocationId | B::LocalInvocationIndex | B::WorkGroupId | B::NumWorkGroups
        ),
        Binding::Location { .. } => false,
    };
    function.arguments.iter().all(|argument| match module.types[argument.ty].inner {
        TypeInner::Struct { ref members, .. } => members.iter().filter_map(|m| m.binding.as_ref()).all(is_known),
        _ => argument.binding.as_ref().is_some_and(is_known),
    })
}

/// Puts a thread's arguments into its frame.
pub(super) fn enter(of: &Invocation, kernel: &Interpreter, function: &Function, entry: &Body, stack: &mut [Slot]) {
    let types = &kernel.module.types;
    for (argument, to) in function.arguments.iter().zip(&entry.arguments) {
        let mut at = to.place as usize;
        let mut put = |binding: Option<&Binding>, width: u32| {
            for bits in of.value(binding).into_iter().take(width as usize) {
                stack[at] = Slot { bits, from: KNOWN, wide: 0.0 };
                at += 1;
            }
        };
        match types[argument.ty].inner {
            TypeInner::Struct { ref members, .. } => members.iter().for_each(|member| {
                put(member.binding.as_ref(), slots(types, &types[member.ty].inner).unwrap_or(0));
            }),
            _ => put(argument.binding.as_ref(), to.width),
        }
    }
}
