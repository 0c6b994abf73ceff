//! Short notifications over the panels, shown long enough to read them.

use egui::Color32;
use egui_notify::{Toast, ToastLevel};

use super::Inspector;

/// Red, readable on light and dark.
const ERROR: Color32 = Color32::from_rgb(230, 70, 60);

impl Inspector {
    /// Reports success.
    pub(super) fn tell(&mut self, text: impl Into<String>) {
        self.toast(text.into(), ToastLevel::None);
    }

    /// Reports an error.
    pub(super) fn warn(&mut self, text: impl Into<String>) {
        self.toast(text.into(), ToastLevel::Custom("!".into(), ERROR));
    }

    fn toast(&mut self, text: String, level: ToastLevel) {
        // egui's fonts lack the icons of the usual levels and of the close button.
        let mut toast = Toast::custom(text, level);
        toast.closable(false);
        self.toasts.add(toast);
    }
}
