//! Short messages over the panels, for as long as they take to read.

use egui::Color32;
use egui_notify::{Toast, ToastLevel};

use super::Inspector;

/// Red on light and on dark.
const ERROR: Color32 = Color32::from_rgb(230, 70, 60);

impl Inspector {
    /// Says what was done.
    pub(super) fn tell(&mut self, text: impl Into<String>) {
        self.toast(text.into(), ToastLevel::None);
    }

    /// Says what went wrong.
    pub(super) fn warn(&mut self, text: impl Into<String>) {
        self.toast(text.into(), ToastLevel::Custom("!".into(), ERROR));
    }

    fn toast(&mut self, text: String, level: ToastLevel) {
        // The signs of the usual levels, and the cross to close one, are in none of egui's fonts.
        let mut toast = Toast::custom(text, level);
        toast.closable(false);
        self.toasts.add(toast);
    }
}
