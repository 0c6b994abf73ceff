//! Where a float became infinite or not a number: the operation that made it of finite operands, behind all that passed it on.

use naga::{Expression, Handle};

use super::Interpreter;
use super::code::Slot;
use super::compile::line_of;
use super::machine::{Frame, Machine};
use super::recording::{KNOWN, Node, NonFinite, Operation, Recording};
use crate::tables::stream::Stream;

impl NonFinite {
    /// In words, with lines from 1.
    #[must_use]
    pub fn sentence(&self) -> String {
        let (stream, layer) = (self.stream.name(), self.stream.info().layers[self.layer]);
        let stored = format!("{stream}.{layer} becomes {} in line {}", self.value, self.line + 1);
        let Some(Operation { line, text, operands, result, .. }) = &self.operation else {
            return format!("{stored}: it was read as it is");
        };
        let with: Vec<String> = operands.iter().map(|(name, value)| format!("{name} = {value:?}")).collect();
        format!("{stored}; line {}, {text}, gives {result} from {}", line + 1, with.join(", "))
    }
}

impl Machine<'_> {
    /// Records an operation whose result is not finite, and returns its node.
    pub(super) fn computed(
        &mut self,
        frame: &Frame<'_>,
        at: Handle<Expression>,
        operands: &[(Handle<Expression>, Slot)],
        result: Slot,
    ) -> u32 {
        let Some(recording) = self.thread.recording.as_ref().filter(|recording| recording.takes_operations()) else {
            return result.from;
        };
        let float = |slot: Slot| f32::from_bits(slot.bits);
        // Copies of a value that is not finite are told by what made it.
        let is_cause = |slot: &&Slot| !float(**slot).is_finite() && recording.operation(slot.from).is_some();
        let operand = operands.iter().map(|(_, slot)| slot).find(is_cause).map_or(KNOWN, |slot| slot.from);
        let start = frame.function.expressions.get_span(at).to_range().map_or(0, |span| span.start);
        let operation = Operation {
            line: line_of(self.kernel.source(), start),
            text: self.text(frame, at),
            operands: operands.iter().map(|&(operand, slot)| (self.text(frame, operand), float(slot))).collect(),
            result: float(result),
            operand,
            from: result.from,
        };
        self.thread.recording.as_mut().map_or(result.from, |recording| recording.compute(operation))
    }

    /// The first component that was finite before, and is not now.
    pub(super) fn non_finite(&self, recording: &Recording, before: &[u32]) -> Option<NonFinite> {
        let kernel: &Interpreter = self.kernel;
        let components = kernel.streams().iter().flat_map(|&s| (0..s.layers()).map(move |layer| (s, layer)));
        let is_finite = |bits: u32| f32::from_bits(bits).is_finite();
        let became = |(at, (stream, layer)): &(usize, (Stream, usize))| {
            stream.is_float_layer(*layer) && is_finite(before[*at]) && !is_finite(self.row[*at].bits)
        };
        let (at, (stream, layer)) = components.enumerate().find(became)?;
        let mut operation = recording.operation(self.row[at].from);
        while let Some(cause) = operation.and_then(|operation| recording.operation(operation.operand)) {
            operation = Some(cause);
        }
        let statement = kernel.statements().get(self.stored[at] as usize);
        Some(NonFinite {
            stream,
            layer,
            value: f32::from_bits(self.row[at].bits),
            line: statement.map_or(0, |span| line_of(kernel.source(), span.start)),
            operation: operation.cloned(),
        })
    }
}

impl Recording {
    /// The latest operation that a value comes from, not by what was decided.
    fn operation(&self, from: u32) -> Option<&Operation> {
        let (mut waiting, mut seen) = (vec![from], std::collections::BTreeSet::new());
        let mut latest = None;
        while let Some(at) = waiting.pop() {
            if !seen.insert(at) {
                continue;
            }
            match self.node(at) {
                Some(Node::Both(a, b)) => waiting.extend([a, b]),
                Some(Node::Operation(index)) => latest = latest.max(Some(index)),
                Some(Node::Comparison(..) | Node::Decision(_)) | None => {}
            }
        }
        latest.and_then(|index| self.operations.get(index))
    }
}
