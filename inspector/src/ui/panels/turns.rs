//! The turns of the schedule's loops: the bands of the timeline, and the tree of passes.

use raystep_kernels::Pass;
use raystep_kernels::program::schedule::Schedule;

/// A turn of a loop: its first pass, and the pass after its last one.
pub(super) type Turn = [usize; 2];

/// The turns that passes are in.
#[derive(Clone, Debug, Default)]
pub(super) struct Turns {
    /// By level, outermost first.
    levels: Vec<Vec<Turn>>,
    /// Passes looked at.
    passes: usize,
}

impl Turns {
    /// Takes in the passes that were added.
    pub(super) fn extend(&mut self, passes: &[Pass]) {
        let mut before =
            self.passes.checked_sub(1).and_then(|last| passes.get(last)).map_or(&[][..], |pass| &pass.loops);
        for (index, pass) in passes.iter().enumerate().skip(self.passes) {
            let continued = before.iter().zip(&pass.loops).take_while(|(a, b)| a == b).count();
            self.levels.resize(self.levels.len().max(pass.loops.len()), Vec::new());
            for (level, turns) in self.levels.iter_mut().take(pass.loops.len()).enumerate() {
                match turns.last_mut() {
                    Some(turn) if level < continued => turn[1] = index + 1,
                    _ => turns.push([index, index + 1]),
                }
            }
            before = &pass.loops;
        }
        self.passes = passes.len();
    }

    /// The turns of each level, outermost first. No levels if none has several turns: there is nothing to tell apart.
    pub(super) fn levels(&self) -> &[Vec<Turn>] {
        if self.levels.iter().all(|turns| turns.len() < 2) { &[] } else { &self.levels }
    }

    /// The turn of a level that a pass belongs to.
    pub(super) fn of(&self, level: usize, pass: usize) -> Option<Turn> {
        let turns = self.levels().get(level)?;
        let at = turns.partition_point(|turn| turn[0] <= pass).checked_sub(1)?;
        Some(turns[at]).filter(|turn| pass < turn[1])
    }
}

/// The names of the turns that a pass is in, outermost first.
pub(super) fn names(of: &Schedule, pass: &Pass) -> Vec<String> {
    let around = of.loops_around(pass.kernel, pass.loops.len());
    around.iter().zip(&pass.loops).map(|(around, turn)| format!("{} {turn}", around.turn_name())).collect()
}

/// The passes of a turn.
pub(super) fn range([first, end]: Turn) -> String {
    if end - first == 1 { first.to_string() } else { format!("{first}–{}", end - 1) }
}
