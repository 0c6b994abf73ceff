//! How long the window takes to respond: a script of clicks, keys and movements of the mouse for whoever draws the
//! window, and the time from each of them until the first frame that shows the response is drawn: a frame after which
//! the response is known, and whose stream views show the present place.

mod actions;

use egui::Event;

use super::Inspector;
use actions::{ACTIONS, Action, OPENING};
use raystep_lab::statistics::quantile;

/// An action that takes longer is given up, nanoseconds.
const PATIENCE_NS: u64 = 20_000_000_000;
/// An action that was given up so often is not tried again.
const MOST_FAILED: usize = 2;
/// Most time between two reports of progress, nanoseconds.
const TELL_EVERY_NS: u64 = 5_000_000_000;
/// Frames without work before the next action.
const CALM: u32 = 4;

/// Times of one action.
struct Row {
    name: &'static str,
    limit_ms: f64,
    times_ms: Vec<f64>,
    /// Drawn by each action until its response was shown.
    frames: Vec<f64>,
    /// Actions that were given up.
    failed: usize,
}

/// An action whose response is awaited.
struct Begun {
    ns: u64,
    before: actions::Before,
    /// Whether the last frame has shown the response.
    is_shown: bool,
    /// Frames since then.
    frames: u32,
}

/// The script, and what was measured.
pub struct Script {
    begin_ns: u64,
    /// Which action, and how often it was done.
    at: (usize, usize),
    begun: Option<Begun>,
    calm: u32,
    rows: Vec<Row>,
    about: String,
    /// When it last reported progress.
    told_ns: u64,
}

impl Script {
    /// Begins at a time in nanoseconds, with a window that is opening a scene.
    #[must_use]
    pub fn new(begin_ns: u64) -> Self {
        Self { begin_ns, at: (0, 0), begun: None, calm: 0, rows: Vec::new(), about: String::new(), told_ns: begin_ns }
    }

    /// Before a frame, once the frame before is on the screen: its events, or `None` at the end of the script.
    pub fn frame(&mut self, now_ns: u64, inspector: &mut Inspector) -> Option<Vec<Event>> {
        let action = ACTIONS.get(self.at.0)?;
        if let Some(begun) = &mut self.begun {
            let ns = now_ns.saturating_sub(begun.ns);
            if begun.is_shown || ns > PATIENCE_NS {
                let (is_shown, frames) = (begun.is_shown, begun.frames);
                self.begun = None;
                self.describe(inspector);
                self.note(action, ns, frames, is_shown);
            }
            return Some(Vec::new());
        }
        // The first actions are to open the scene, which began with the program.
        let is_opening = self.at.0 < OPENING;
        if !is_opening {
            self.calm = if inspector.is_busy() { 0 } else { self.calm + 1 };
            if self.calm < CALM {
                return Some(Vec::new());
            }
        }
        self.calm = 0;
        let before = actions::Before::of(inspector);
        let events = (action.events)(inspector, self.at.1);
        let ns = if is_opening { self.begin_ns } else { now_ns };
        self.begun = Some(Begun { ns, before, is_shown: false, frames: 0 });
        Some(events)
    }

    /// After a frame. Returns whether the next one must follow at once: otherwise it follows when the engine wakes the
    /// window, so that repaints do not take time from the work that is awaited.
    #[must_use]
    pub fn after(&mut self, inspector: &Inspector) -> bool {
        let (Some(begun), Some(action)) = (&mut self.begun, ACTIONS.get(self.at.0)) else { return true };
        begun.frames += 1;
        if begun.frames < action.frames {
            return true;
        }
        let is_known = (action.is_shown)(inspector, &begun.before);
        begun.is_shown = is_known && inspector.is_up_to_date();
        is_known
    }

    /// How far the script has got, in one line, if it is time to say so.
    pub fn progress(&mut self, now_ns: u64) -> Option<String> {
        let action = ACTIONS.get(self.at.0).filter(|_| now_ns >= self.told_ns.saturating_add(TELL_EVERY_NS))?;
        self.told_ns = now_ns;
        let (number, actions, times) = (self.at.0 + 1, ACTIONS.len(), action.times);
        Some(format!("action {number} of {actions}: {}, {} of {times} done", action.name, self.at.1))
    }

    fn describe(&mut self, inspector: &Inspector) {
        if let Some(opened) = &inspector.model().opened {
            let plan = &opened.plan;
            self.about = format!(
                "{}: {} triangles, {} × {} rays, traced by {}",
                opened.scene.name, plan.triangles, plan.width, plan.height, opened.device
            );
        }
    }

    fn note(&mut self, action: &Action, ns: u64, frames: u32, is_shown: bool) {
        if self.at.1 == 0 {
            let (name, limit_ms) = (action.name, action.limit_ms);
            self.rows.push(Row { name, limit_ms, times_ms: Vec::new(), frames: Vec::new(), failed: 0 });
        }
        if let Some(row) = self.rows.last_mut() {
            if is_shown {
                row.times_ms.push(ns as f64 / 1e6);
                row.frames.push(f64::from(frames));
            } else {
                row.failed += 1;
            }
        }
        self.at.1 += 1;
        let is_given_up = self.rows.last().is_some_and(|row| row.failed >= MOST_FAILED);
        if self.at.1 == action.times || is_given_up {
            self.at = (self.at.0 + 1, 0);
        }
    }

    /// The table, in Markdown.
    #[must_use]
    pub fn table(&self, drawn_by: &str) -> String {
        let mut text = format!("{}, drawn by {drawn_by}\n\n", self.about);
        text += "| action | times | frames | median, ms | 90 %, ms | worst, ms | limit, ms |\n|---|--:|--:|--:|--:|--:|---|\n";
        let of = |row: &Row, share: f64| quantile(&row.times_ms, share).unwrap_or(f64::NAN);
        let repaints = self.rows.iter().find(|row| row.name == actions::REPAINTS).map_or(0.0, |row| of(row, 0.5));
        for row in &self.rows {
            let [median, most, worst] = [0.5, 0.9, 1.0].map(|share| of(row, share));
            // Where two repaints take longer than a limit, they are the limit.
            let limit = row.limit_ms.max(if row.name == actions::REPAINTS { 0.0 } else { repaints });
            let verdict = match median <= limit && row.failed == 0 {
                _ if limit.is_infinite() => "none".to_owned(),
                true => format!("within {limit:.0}"),
                false => format!("over {limit:.0}"),
            };
            let failed = if row.failed > 0 { format!(", {} without a response", row.failed) } else { String::new() };
            let (name, times) = (row.name, row.times_ms.len());
            let frames = quantile(&row.frames, 0.5).unwrap_or(f64::NAN);
            text += &format!(
                "| {name} | {times}{failed} | {frames:.0} | {median:.0} | {most:.0} | {worst:.0} | {verdict} |\n"
            );
        }
        text
    }
}
