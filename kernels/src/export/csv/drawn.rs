//! The parts of a pass that is drawn.

use crate::executor::{DrawTime, Drawing};
use crate::plan::Plan;
use crate::renderer::Pass;
use crate::tables::stream::Stream;

/// A part of a pass that is drawn, for a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawnPart {
    /// How long it took.
    pub time: DrawTime,
    /// Names of the streams that it writes, separated by spaces.
    pub targets: String,
    /// Fragments that it covers.
    pub fragments_drawn: u64,
    /// Bytes that it copies.
    pub bytes_copied: u64,
}

impl DrawnPart {
    /// What it is, with the streams that it copies or writes.
    #[must_use]
    pub fn name(&self) -> String {
        match self.time.what {
            Drawing::Copies => format!("copy {}", self.targets),
            Drawing::Depths => "draw depths".into(),
            Drawing::Draw(_) => format!("draw {}", self.targets),
        }
    }

    /// The parts of a pass of this plan.
    #[must_use]
    pub fn of(plan: &Plan, pass: &Pass, draws: &[DrawTime]) -> Vec<Self> {
        let Some(drawn) = plan.drawn.as_ref() else { return Vec::new() };
        let texels = plan.size().texels();
        let names = |streams: &[Stream]| streams.iter().map(|stream| stream.name()).collect::<Vec<_>>().join(" ");
        let kernel = drawn.of(pass.kernel);
        let part = |time: &DrawTime| {
            let (targets, fragments_drawn, bytes_copied) = match time.what {
                Drawing::Copies => {
                    let copied = kernel.map_or(&[][..], |kernel| &kernel.updates);
                    (names(copied), 0, drawn.copied_bytes(pass.kernel, plan.size()))
                }
                Drawing::Depths => ("depth".to_owned(), texels, 0),
                Drawing::Draw(draw) => {
                    let targets = kernel.and_then(|kernel| kernel.draws.get(draw)).map(|draw| names(&draw.targets));
                    (targets.unwrap_or_default(), texels, 0)
                }
            };
            Self { time: *time, targets, fragments_drawn, bytes_copied }
        };
        draws.iter().map(part).collect()
    }
}
