//! Messages: lines of the log, and short notifications over the panels, shown long enough to read them.

use egui::Color32;
use egui_notify::{Toast, ToastLevel, Toasts};
use smart_default::SmartDefault;

/// Most lines; the oldest are dropped.
const MOST: usize = 1000;
/// Red, readable on light and dark.
const ERROR: Color32 = Color32::from_rgb(230, 70, 60);

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// An error.
    pub is_error: bool,
    /// A message.
    pub text: String,
    /// Nanoseconds since the start; `None` without a clock.
    pub at_ns: Option<u64>,
    /// The number of passes that had run.
    pub place: usize,
}

/// The messages.
#[derive(SmartDefault)]
pub struct Log {
    /// The lines, oldest first.
    pub lines: Vec<LogLine>,
    /// The number of lines that were dropped to make room.
    pub dropped: u64,
    /// The number of passes that have run.
    pub place: usize,
    /// A clock in nanoseconds, and what it was at the start.
    pub clock: Option<(fn() -> u64, u64)>,
    #[default(Toasts::default().with_anchor(egui_notify::Anchor::BottomRight))]
    pub(in crate::ui) toasts: Toasts,
}

impl Log {
    /// Adds a line to the log, and says nothing over the panels.
    pub fn say(&mut self, is_error: bool, text: impl Into<String>) {
        if self.lines.len() == MOST {
            self.lines.remove(0);
            self.dropped += 1;
        }
        let at_ns = self.clock.map(|(now, began_ns)| now().saturating_sub(began_ns));
        self.lines.push(LogLine { is_error, text: text.into(), at_ns, place: self.place });
    }

    /// Says something over the panels.
    pub fn tell(&mut self, text: impl Into<String>) {
        self.toast(text.into(), ToastLevel::None);
    }

    /// Says over the panels what cannot be done.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.toast(text.into(), ToastLevel::Custom("!".into(), ERROR));
    }

    /// Reports success: over the panels, in the log, and to screen readers.
    pub fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.say(false, text.clone());
        self.tell(text);
    }

    /// Reports an error: over the panels, and in the log.
    pub fn fail(&mut self, message: String) {
        self.say(true, message.clone());
        self.warn(message);
    }

    fn toast(&mut self, text: String, level: ToastLevel) {
        // egui's fonts lack the icons of the usual levels and of the close button.
        let mut toast = Toast::custom(text, level);
        toast.closable(false);
        self.toasts.add(toast);
    }
}
