//! Moves a run forwards and backwards.

use raystep_kernels::{Checkpoint, Device, Options, RenderError, Renderer};

use crate::border::Watcher;

/// Most bytes of checkpoints.
const BUDGET: u64 = 1 << 30;

/// A run, and what it keeps to go back.
pub(crate) struct Run {
    /// The run.
    pub(crate) renderer: Renderer,
    /// Another run of the same plan, for what must not move this one.
    side: Option<Renderer>,
    /// By place, ascending.
    kept: Vec<Checkpoint>,
}

impl Run {
    pub(crate) fn new(renderer: Renderer) -> Self {
        Self { renderer, side: None, kept: Vec::new() }
    }

    /// The other run.
    pub(crate) async fn side(&mut self, options: &Options, device: &Device) -> Result<&mut Renderer, RenderError> {
        let side = match self.side.take() {
            Some(side) if side.health().is_ok() => side,
            _ => {
                let options = Options { timings: false, keep_passes: false, ..options.clone() };
                self.renderer.another(&options, device).await?
            }
        };
        Ok(self.side.insert(side))
    }

    /// Runs until so many passes have run, or to the end. If the watcher stops it, it stays where it is.
    pub(crate) async fn go(&mut self, place: usize, watcher: &mut Watcher) -> Result<(), RenderError> {
        if place < self.renderer.pass_count() {
            self.kept.retain(|kept| kept.place() <= place);
            let base = match self.kept.last() {
                Some(kept) => {
                    self.renderer.restore(kept)?;
                    kept.place()
                }
                None => {
                    self.renderer.restart();
                    0
                }
            };
            for stop in stops(base, place) {
                self.renderer.run_to(stop, |progress| watcher.tell(progress)).await?;
                watcher.expect_calm(&self.renderer)?;
                self.keep().await?;
            }
        }
        self.renderer.run_to(place, |progress| watcher.tell(progress)).await
    }

    /// Keeps a checkpoint here.
    async fn keep(&mut self) -> Result<(), RenderError> {
        self.kept.push(self.renderer.checkpoint().await?);
        while Checkpoint::bytes_of(&self.kept) > BUDGET {
            self.kept.remove(self.kept.len() / 2);
        }
        Ok(())
    }
}

/// Where checkpoints are kept on the way from a base to a place before which one may go next: 1, 2, 4, … passes before
/// it, so that each of many steps back repeats few passes.
fn stops(base: usize, place: usize) -> Vec<usize> {
    let before = (0..usize::BITS).map(|k| place.saturating_sub(1 << k));
    let mut stops: Vec<usize> = before.take_while(|&stop| stop > base).collect();
    stops.reverse();
    stops
}
