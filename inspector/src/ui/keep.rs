//! Settings that persist between sessions: the layout, watches, the last place, recent files.

use egui_tiles::Tree;

use super::Inspector;
use super::pane::Pane;
use crate::saved::Saved;
use crate::session::Watch;

impl Inspector {
    /// Restores saved settings. What cannot be read is reported, and keeps its default.
    pub fn restore(&mut self, bytes: &[u8]) {
        let (saved, error) = Saved::from_bytes_or_default(bytes);
        if let Some(error) = error {
            self.fail(error.to_string());
        }
        if let Some(tree) = saved.layout.as_deref().and_then(|text| serde_json::from_str::<Tree<Pane>>(text).ok()) {
            self.tree = tree;
        }
        if let Some(watches) =
            saved.watches.as_deref().and_then(|text| serde_json::from_str::<Vec<(Watch, bool)>>(text).ok())
        {
            self.shared.watches = watches;
        }
        self.shared.units = saved.units;
        self.shared.recent = saved.recent().to_vec();
        self.shared.last_place = saved.link.as_ref().map(ToString::to_string);
        self.saved = saved;
    }

    /// Hands the settings to the host for saving.
    pub fn keep(&mut self) {
        self.saved.layout = serde_json::to_string(&self.tree).ok();
        self.saved.watches = serde_json::to_string(&self.shared.watches).ok();
        self.saved.units = self.shared.units;
        if let Some(link) = self.link() {
            self.saved.link = Some(link);
        }
        match self.saved.to_text() {
            Ok(text) => self.host.remember(&text),
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// A scene was read from a file.
    pub(super) fn remember_file(&mut self) {
        if let Some(path) = self.path.as_deref().filter(|path| *path != super::lessons::BUILT_IN) {
            self.saved.opened(path);
            self.shared.recent = self.saved.recent().to_vec();
        }
    }
}
